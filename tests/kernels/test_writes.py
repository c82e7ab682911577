"""What kernels write is read off their sources once, and kept under what these hold."""

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


def asked(folder):
    """As a new process asks."""
    written_arguments.cached_arguments.cache_clear()
    written_arguments.written_arguments.cache_clear()
    return written_arguments.cached_arguments(str(folder))


def test_what_is_kept_is_what_the_source_says(folder, monkeypatch):
    (folder / "a.py").write_text(KERNEL.format("out"))
    assert asked(folder) == {"a.fill": (1,)}
    (folder / "a.py").write_text(KERNEL.format("rows"))
    assert asked(folder) == {"a.fill": (0,)}
    (folder / "a.py").write_text(KERNEL.format("out"))
    monkeypatch.setattr(written_arguments, "written_arguments", None)  # nothing is read any more
    written_arguments.cached_arguments.cache_clear()
    assert written_arguments.cached_arguments(str(folder)) == {"a.fill": (1,)}
    assert len(list((folder.parent / "cache").iterdir())) == 2


@pytest.mark.parametrize("text", ["", "{", "[1]", "\ufffd", "null"])
def test_what_is_damaged_is_read_anew(folder, text):
    (folder / "a.py").write_text(KERNEL.format("out"))
    asked(folder)
    (kept,) = (folder.parent / "cache").iterdir()
    whole = kept.read_text()
    kept.write_text(text, encoding="utf-8")
    with pytest.warns(GeosurfWarning, match="made again"):
        assert asked(folder) == {"a.fill": (1,)}
    assert kept.read_text() == whole


def test_where_nothing_can_be_kept_it_is_read(folder, monkeypatch):
    (folder / "a.py").write_text(KERNEL.format("out"))
    monkeypatch.setenv("GEOSURF_CACHE_DIR", str(folder / "a.py"))
    with pytest.warns(GeosurfWarning, match="is not a folder"):
        assert asked(folder) == {"a.fill": (1,)}
