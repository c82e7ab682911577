"""A library in the cache is found by its sources, and used only if no other user can write it."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from geosurf.kernels.compile import own_library as room
from geosurf.kernels.compile.frozen_runner import Unfit, stamp_of
from geosurf.kernels.compile.own_library import own_library
from tests.kernels import frozen

TINY = "tests.kernels.tiny"
STAMP = stamp_of(frozen.folder_of(TINY))


@pytest.fixture
def cached(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a library in a cache of its own."""
    library = frozen.frozen(TINY)  # from the usual cache, before there is another one
    for name in [name for name in os.environ if name.startswith("NUMBA_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("GEOSURF_CACHE_DIR", str(tmp_path))
    tmp_path.chmod(0o700)
    folder = room._folder(STAMP)
    shutil.copytree(library, folder)
    folder.chmod(0o700)
    for file in folder.iterdir():
        file.chmod(0o600)
    return folder


def test_it_is_found_by_the_sources_it_is_made_from(cached):
    found = own_library(STAMP)
    assert found.address(next(iter(found.manifest["written"])))
    with pytest.raises(Unfit, match="the cache has none"):
        own_library("0" * 64)


def test_options_of_numba_are_for_numba(cached, monkeypatch):
    monkeypatch.setenv("NUMBA_BOUNDSCHECK", "1")
    with pytest.raises(Unfit, match="options of numba are set"):
        own_library(STAMP)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="Windows has no such permissions")
@pytest.mark.parametrize("what", ["root", "folder", "library", "manifest"])
def test_what_others_can_write_is_not_used(cached, what):
    places = {"root": cached.parent, "folder": cached, "manifest": cached / "manifest.json"}
    place = places.get(what, cached / frozen.library_name())
    place.chmod(place.stat().st_mode | 0o020)
    with pytest.raises(Unfit, match="can be written by others"):
        own_library(STAMP)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="links need rights on Windows")
@pytest.mark.parametrize("what", ["folder", "library"])
def test_a_link_is_not_used(cached, what, tmp_path):
    place = cached if what == "folder" else cached / frozen.library_name()
    elsewhere = tmp_path / "elsewhere"
    place.rename(elsewhere)
    place.symlink_to(elsewhere)
    with pytest.raises(Unfit, match="is a link"):
        own_library(STAMP)
