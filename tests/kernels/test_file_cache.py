"""What is kept is used only if it is whole and ours; trouble is a miss, and reported once."""

from __future__ import annotations

import os
import warnings

import pytest

from geosurf.errors import GeosurfWarning
from geosurf.kernels.compile import file_cache
from geosurf.kernels.compile.file_cache import Store, cache_folder

pytestmark = pytest.mark.long  # of the compile machinery: an edit of kernels, not of the model

NAME, PAYLOAD = "mesh.weld-1.nbc", bytes(range(256)) * 3
posix = pytest.mark.skipif(not hasattr(os, "getuid"), reason="permissions are of POSIX")


@pytest.fixture
def store(tmp_path, monkeypatch):
    monkeypatch.setenv("GEOSURF_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(file_cache, "_reported", [])
    made = Store("kernels")
    assert made.save(NAME, PAYLOAD)
    assert made.load(NAME) == PAYLOAD
    return made


def assert_miss_reported_once(store, words):
    """Two misses, one warning: kind, folder, what is wrong, remedy."""
    with warnings.catch_warnings(record=True, action="always") as caught:
        assert store.load(NAME) is None
        assert store.load(NAME) is None
    (note,) = (warning.message for warning in caught)
    assert isinstance(note, GeosurfWarning)
    assert (note.kind, note.subject) == ("kernel cache", str(store.folder))
    assert words in note.effect
    assert str(store.folder) in str(note)
    assert "delete" in note.remedy.lower()


@pytest.mark.parametrize("bit", range(0, 8 * (81 + len(PAYLOAD)), 997))
def test_law_no_bit_may_change(store, bit):
    data = bytearray((store.folder / NAME).read_bytes())
    data[bit // 8] ^= 1 << bit % 8
    (store.folder / NAME).write_bytes(data)
    assert_miss_reported_once(store, "its checksum is wrong")


def test_a_file_under_another_name_is_not_what_was_kept(store):
    (store.folder / NAME).rename(store.folder / "other")
    store.save(NAME, b"new")
    (store.folder / "other").replace(store.folder / NAME)
    assert store.load(NAME) == PAYLOAD
    (store.folder / NAME).rename(store.folder / "tree.nbc")
    (store.folder / NAME).write_bytes((store.folder / "tree.nbc").read_bytes())
    assert store.load(NAME) == PAYLOAD
    with pytest.warns(GeosurfWarning, match="checksum"):
        assert store.load("tree.nbc") is None


@posix
@pytest.mark.parametrize("mode", [0o770, 0o702, 0o777, 0o1777])
def test_a_folder_that_others_can_write_is_not_used(store, mode):
    store.folder.chmod(mode)
    assert_miss_reported_once(store, f"can be written by others (mode {mode:03o})")
    assert not store.save("new", PAYLOAD)
    assert not (store.folder / "new").exists()
    assert "can be written by others" in store.obstacle()


@posix
def test_what_belongs_to_another_is_not_used(store, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    if os.getuid() == 0:  # what belongs to root is trusted, so it is given away
        os.chown(store.folder, 12345, 12345)
    assert_miss_reported_once(store, "belongs to another user")


@posix
def test_the_folder_above_counts_too(tmp_path, monkeypatch):
    monkeypatch.delenv("GEOSURF_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(file_cache, "_reported", [])
    store = Store("kernels")
    assert store.save(NAME, PAYLOAD)
    assert store.folder == tmp_path / "geosurf" / "kernels"
    assert [
        (tmp_path / part).stat().st_mode & 0o777 for part in ("geosurf", "geosurf/kernels")
    ] == [0o700, 0o700]
    (tmp_path / "geosurf").chmod(0o777)
    assert_miss_reported_once(store, f"{tmp_path / 'geosurf'} can be written by others")


@posix
@pytest.mark.parametrize("thing", ["link", "pipe", "folder"])
def test_only_plain_files_are_read(store, thing):
    place = store.folder / NAME
    place.rename(store.folder / "away")
    make = {"link": lambda: place.symlink_to("away"), "pipe": lambda: os.mkfifo(place, 0o600),
            "folder": place.mkdir}  # fmt: skip
    make[thing]()
    assert_miss_reported_once(store, str(place))


def test_a_huge_file_is_not_read(store):
    with (store.folder / NAME).open("r+b") as file:
        file.truncate(2**34)
    assert_miss_reported_once(store, "more than 64 MB")


def test_where_nothing_can_be_kept_one_warning_names_the_remedy(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("GEOSURF_CACHE_DIR", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(file_cache, "_reported", [])
    store = Store("kernels")
    with pytest.warns(GeosurfWarning, match="cannot be saved in .*Set GEOSURF_CACHE_DIR"):
        assert not store.save(NAME, PAYLOAD)
    assert not store.save(NAME, PAYLOAD)  # a second warning would be an error
    assert store.obstacle() == "Not a directory"


def test_leftovers_of_a_day_ago_go(store):
    old, young = (store.folder / f".geosurf-{digit * 16}.part" for digit in "ab")
    for path in (old, young):
        path.write_bytes(b"")
    os.utime(old, (0, 0))
    Store("kernels").save("new", b"")
    assert not old.exists()
    assert young.exists()


@pytest.mark.parametrize("base", ["", "cache", "./cache", "../cache"])
def test_a_relative_xdg_folder_is_ignored(tmp_path, monkeypatch, base):
    monkeypatch.delenv("GEOSURF_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", base)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder("kernels") == tmp_path / ".cache" / "geosurf" / "kernels"


def test_without_a_home_nothing_is_kept(monkeypatch):
    monkeypatch.delenv("GEOSURF_CACHE_DIR", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", "nowhere")
    monkeypatch.setattr(file_cache, "_reported", [])
    store = Store("kernels")
    assert store.load(NAME) is None
    with pytest.warns(GeosurfWarning, match="relative"):
        assert not store.save(NAME, PAYLOAD)
