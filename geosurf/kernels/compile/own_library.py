"""A frozen library of the sources that are run, in the cache: ``geosurf warmup --library``.

A wheel brings its library along. Sources, such as those of an editable install, compile each kernel
by numba; then each process imports numba and loads its kernels one by one, which takes more than a
second. One library of all kernels starts as a wheel does. It is found by the content of the
sources: once a kernel changes, numba compiles again until there is a library of the new ones.
"""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
import time
from pathlib import Path

from geosurf.errors import OutputError
from geosurf.files.sealed import why_not_ours
from geosurf.kernels.compile.cache_folder import CHOICE, cache_folder, cache_root
from geosurf.kernels.compile.frozen_runner import Library, Unfit, stamp_of
from geosurf.kernels.compile.sources import ROOT

# of numba itself: whoever chooses them wants what numba makes
_OF_NUMBA = "NUMBA_"


def own_library(stamp: str) -> Library:
    """
    Return the library of some sources from the cache.

    Parameters
    ----------
    stamp : str
        Of the sources, see `stamp_of`.

    Returns
    -------
    Library

    Raises
    ------
    Unfit
        If there is none, or if it cannot be trusted.
    """
    if any(name.startswith(_OF_NUMBA) for name in os.environ):
        raise Unfit("options of numba are set")
    try:
        folder = _folder(stamp)
        # A library is code: no other user may have written it, or be able to exchange it.
        held = [folder, *folder.iterdir()]
        for place in (cache_root(), folder.parent, *held):
            found = place.lstat() if place in held else place.stat()
            why = "is a link" if stat.S_ISLNK(found.st_mode) else ""
            if not why and hasattr(os, "getuid"):
                why = why_not_ours(found)
            if why:
                raise Unfit(f"{place} {why}")
    except OSError as error:
        raise Unfit("the cache has none") from error
    return Library(folder, stamp)


def freeze_into_cache() -> str:
    """
    Make the library of these sources, if the cache has none.

    Returns
    -------
    str
        One sentence: what was done.

    Raises
    ------
    DependencyError
        If there is no C compiler, or no numba.
    OutputError
        If it cannot be saved.
    """
    # numba takes a second to load
    from geosurf.kernels.compile.freeze import freeze

    stamp, start = stamp_of(ROOT), time.perf_counter()
    try:
        target = _folder(stamp)
        if target.exists():
            return f"Nothing to compile: the library of all kernels is in {target}."
        target.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        # Made aside and renamed, so that no process sees half a library.
        scratch = Path(tempfile.mkdtemp(prefix=".frozen-", dir=target.parent))
    except OSError as error:
        raise OutputError(
            f"The library cannot be saved in the kernel cache ({error.strerror}). Set {CHOICE} to "
            "a folder that only you can write."
        ) from error
    try:
        made = freeze(scratch)
        for file in scratch.iterdir():
            file.chmod(0o600)
        try:
            scratch.rename(target)
        except OSError:  # another process was faster
            if not target.exists():
                raise
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return (
        f"{len(made['written'])} kernels frozen in {time.perf_counter() - start:.0f} s; the "
        f"library is in {target}."
    )


def _folder(stamp: str) -> Path:
    """Where the library of some sources is, or would be."""
    return cache_folder("kernels") / f"frozen-{stamp[:32]}"


__all__ = ["freeze_into_cache", "own_library"]
