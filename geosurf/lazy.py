"""Rooms whose names are imported when they are first used.

A command loads only the rooms that its model needs: a scenario without torn horizons loads nothing
of `geosurf.sheets`. A room lists its names twice, for Python and, below ``TYPE_CHECKING``, for
editors; a test compares the lists.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazily(room: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """
    Return the ``__getattr__`` of a room.

    Parameters
    ----------
    room : str
        ``__name__`` of the room.
    homes : mapping of str to str
        Name -> module below the room that defines it.

    Examples
    --------
    >>> find = lazily("geosurf.sheets", {"extend_horizon": "extend"})
    >>> find("extend_horizon").__module__
    'geosurf.sheets.extend'
    >>> find("extent_horizon")
    Traceback (most recent call last):
    AttributeError: module 'geosurf.sheets' has no attribute 'extent_horizon'
    """

    def find(name: str) -> Any:
        """Import a name, and keep it."""
        if name not in homes:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        value = getattr(import_module(f"{room}.{homes[name]}"), name)
        setattr(sys.modules[room], name, value)
        return value

    return find


__all__ = ["lazily"]
