"""The folder for compiled kernels and for the analysis of their sources."""

from __future__ import annotations

import errno
import os
from pathlib import Path

CHOICE = "GEOSURF_CACHE_DIR"


def cache_root() -> Path:
    """
    Return GEOSURF_CACHE_DIR, or geosurf's folder in the user's cache.

    Raises
    ------
    OSError
        Where a user has neither a cache nor a home.
    """
    # What the user chose goes first, also for read-only homes and shared machines.
    chosen = os.environ.get(CHOICE)
    if chosen:
        return Path(chosen).absolute()
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if base.is_absolute():  # a relative one is to be ignored, by the rules of XDG
        return base / "geosurf"
    try:
        # A process without an account, as in some containers, has no home.
        home = Path.home()
    except RuntimeError as error:
        raise FileNotFoundError(errno.ENOENT, str(error)) from error
    # A relative home would spread caches over working folders.
    if not home.is_absolute():
        raise FileNotFoundError(errno.ENOENT, f"the home folder {home} is relative")
    return home / ".cache" / "geosurf"


def cache_folder(part: str = "") -> Path:
    """
    Return GEOSURF_CACHE_DIR, or a part of geosurf's folder in the user's cache.

    Raises
    ------
    OSError
        Where a user has neither a cache nor a home.
    """
    # A folder that was chosen is used as it is; the default one has a part for each purpose.
    return cache_root() if os.environ.get(CHOICE) else cache_root() / part
