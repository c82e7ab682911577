"""Where compiled kernels, and what is read off their source, are kept."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder(part: str = "") -> Path:
    """
    Return GEOSURF_CACHE_DIR, or a part of geosurf's folder in the user's cache.

    Raises
    ------
    OSError
        Where a user has neither a cache nor a home.
    """
    chosen = os.environ.get("GEOSURF_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        return (Path(base) if base else Path.home() / ".cache") / "geosurf" / part
    except RuntimeError as error:
        raise FileNotFoundError(str(error)) from error
