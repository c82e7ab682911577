"""Issue a `GeosurfWarning`: to the scene that is being computed, else by Python's `warnings`.

A scene collects the warnings of its steps, stores them with their results, and issues each warning
once. Outside a scene a function issues its warnings itself. Both call `warn`.
"""

from __future__ import annotations

import contextlib
import functools
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from geosurf.errors import GeosurfWarning

_PACKAGE = str(Path(__file__).parent)
_collector: ContextVar[list[GeosurfWarning] | None] = ContextVar("collector", default=None)
_silent: ContextVar[bool] = ContextVar("silent", default=False)


def warn(warning: GeosurfWarning) -> None:
    """
    Hand a warning to the scene whose step runs, or issue it as the line of the user's own code.

    Parameters
    ----------
    warning : GeosurfWarning

    Examples
    --------
    >>> note = GeosurfWarning("area", "box", "The box covers 18 % of the field.", "Give aoi=.")
    >>> with collected() as found:
    ...     warn(note)
    >>> found == [note]
    True
    """
    if not pass_on(warning):
        issue(warning)


def warn_of(
    kind: str, subject: str, effect: str, remedy: str, place: Sequence[float] | None = None
) -> None:
    """Make a warning and hand it on, as `warn` does."""
    warn(GeosurfWarning(kind, subject, effect, remedy, place))


def issue(warning: GeosurfWarning) -> None:
    """Issue a warning by Python's `warnings`, as the line of the user's own code."""
    if _silent.get():
        return
    warnings.warn(warning, stacklevel=_depth_of_user())


def pass_on(warning: GeosurfWarning) -> bool:
    """Hand a warning to whoever collects them, and return whether anybody does."""
    found = _collector.get()
    if found is not None:
        found.append(warning)
    return found is not None


@contextmanager
def collected() -> Iterator[list[GeosurfWarning]]:
    """Collect what is warned of inside the ``with`` block, instead of issuing it.

    Yields
    ------
    list of GeosurfWarning
        Grows while the block runs.
    """
    found: list[GeosurfWarning] = []
    token = _collector.set(found)
    try:
        yield found
    finally:
        _collector.reset(token)


@contextmanager
def silenced() -> Iterator[list[GeosurfWarning]]:
    """Collect what is warned of inside the ``with`` block; scenes inside do not issue it either.

    Yields
    ------
    list of GeosurfWarning
        Grows while the block runs.
    """
    token = _silent.set(True)
    try:
        with collected() as found:
            yield found
    finally:
        _silent.reset(token)


def _depth_of_user() -> int:
    """Frames from `issue` up to the first that is not of geosurf, as `warnings` counts them."""
    depth, frame = 1, sys._getframe(1)
    # results that are computed once, and functions with a decorator, pass through the others
    inner = (_PACKAGE, functools.__file__, contextlib.__file__)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(inner):
        depth, frame = depth + 1, frame.f_back
    return depth
