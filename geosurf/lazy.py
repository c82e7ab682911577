"""Rooms whose names, and packages, that are imported when they are first used.

A command loads only the rooms that its model needs: a scenario without torn horizons loads nothing
of `geosurf.sheets`. A room lists its names once, as imports below ``TYPE_CHECKING`` in the form
``from ... import name as name``, where editors and type checkers find them, too.

``from geosurf.lazy import xarray`` stands for ``import xarray`` where not all calls need it.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

__all__ = ["h5py", "lazily", "pandas", "xarray"]


class Late:
    """A package that is imported when something of it is used."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        """Import the package for all but what Python asks of every object."""
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(import_module(self._name), name)


if TYPE_CHECKING:  # pragma: no cover - types only
    import h5py
    import pandas
    import xarray
else:
    h5py, pandas, xarray = Late("h5py"), Late("pandas"), Late("xarray")


def lazily(room: str) -> tuple[Callable[[str], Any], list[str]]:
    """
    Return the ``__getattr__`` and the ``__all__`` of a room.

    Parameters
    ----------
    room : str
        ``__name__`` of the room. Names that it imports at once in the same form are public, too.

    Examples
    --------
    >>> find, names = lazily("geosurf.sheets")
    >>> find("extend_horizon").__module__, "extend_horizon" in names
    ('geosurf.sheets.extend', True)
    >>> find("extent_horizon")
    Traceback (most recent call last):
    AttributeError: module 'geosurf.sheets' has no attribute 'extent_horizon'
    """
    module: Any = sys.modules[room]
    body = ast.parse(module.__loader__.get_source(room)).body
    (branch,) = (one for one in body if isinstance(one, ast.If) and "TYPE_CHECKING" in _words(one))
    homes = _public(branch.body)

    def find(name: str) -> Any:
        """Import a name, and keep it."""
        if name not in homes:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        home = homes[name]
        value = (
            import_module(f"{room}.{name}") if home == room else getattr(import_module(home), name)
        )
        setattr(module, name, value)
        return value

    names = sorted({*homes, *_public(body)})
    module.__dir__ = lambda: sorted(module.__all__)  # what is public, and nothing else
    return find, names


def _words(branch: ast.If) -> set[str]:
    """The names in the condition of a branch."""
    return {one.id for one in ast.walk(branch.test) if isinstance(one, ast.Name)}


def _public(body: list[ast.stmt]) -> dict[str, str]:
    """Names that are imported as themselves, and their modules."""
    return {
        name.name: str(line.module)
        for line in body
        if isinstance(line, ast.ImportFrom)
        for name in line.names
        if name.asname == name.name
    }
