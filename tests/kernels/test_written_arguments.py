"""Written arguments are determined from the sources of kernels, and cached by their content."""

from __future__ import annotations

import pytest

from geosurf.errors import GeosurfWarning
from geosurf.kernels.compile import file_cache, written_arguments

KERNEL = "def fill(rows, out):\n    for i in range(len(rows)):\n        {}[i] = 1.0\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("GEOSURF_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(file_cache, "_reported", [])
    (tmp_path / "kernels").mkdir()
    return tmp_path / "kernels"


def found_in(folder):
    """The result in a new process."""
    written_arguments.cached_arguments.cache_clear()
    written_arguments.written_arguments.cache_clear()
    return written_arguments.cached_arguments(str(folder))


def test_the_cache_follows_the_source(folder, monkeypatch):
    (folder / "a.py").write_text(KERNEL.format("out"))
    assert found_in(folder) == {"a.fill": (1,)}
    (folder / "a.py").write_text(KERNEL.format("rows"))
    assert found_in(folder) == {"a.fill": (0,)}
    (folder / "a.py").write_text(KERNEL.format("out"))
    monkeypatch.setattr(written_arguments, "written_arguments", None)  # only the cache can answer
    written_arguments.cached_arguments.cache_clear()
    assert written_arguments.cached_arguments(str(folder)) == {"a.fill": (1,)}
    assert len(list((folder.parent / "cache").iterdir())) == 2


@pytest.mark.parametrize("text", ["", "{", "[1]", "\ufffd", "null"])
def test_a_damaged_cache_is_computed_again(folder, text):
    (folder / "a.py").write_text(KERNEL.format("out"))
    found_in(folder)
    (cached,) = (folder.parent / "cache").iterdir()
    whole = cached.read_text()
    cached.write_text(text, encoding="utf-8")
    with pytest.warns(GeosurfWarning, match="made again"):
        assert found_in(folder) == {"a.fill": (1,)}
    assert cached.read_text() == whole


def test_without_a_cache_it_is_computed(folder, monkeypatch):
    (folder / "a.py").write_text(KERNEL.format("out"))
    monkeypatch.setenv("GEOSURF_CACHE_DIR", str(folder / "a.py"))
    with pytest.warns(GeosurfWarning, match="is not a folder"):
        assert found_in(folder) == {"a.fill": (1,)}


BUNDLES = """
class Pair(NamedTuple):
    one: np.ndarray
    two: np.ndarray

def fill(pair, n):
    one, two = pair.one, pair.two
    for i in range(n):
        two[i] = one[i]

def outer(x, y, z, n):
    pair = Pair(x, y)
    fill(pair, n)

def onward(pair, n):
    fill(pair, n)

def swapped(x, y, z, n):
    pair = Pair(z, x)
    onward(pair, n)
"""


def test_only_the_written_field_of_a_bundle_counts(folder):
    """Or a read-only array in the same named tuple would be refused."""
    (folder / "a.py").write_text(BUNDLES)
    found = found_in(folder)
    assert found["a.outer"] == (1,)
    assert found["a.swapped"] == (0,)
    assert found["a.fill"] == found["a.onward"] == (0,)
