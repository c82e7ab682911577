"""Every exception that geosurf raises on purpose; its one kind of warning, and how it is issued.

Each message is one or two sentences: what is wrong, where, and what to do next.
The class names the cause: the input (`InputError`), the geometry (`GeometryError`) or a
bug in geosurf (`InvariantError`). The command line turns
them into exit codes 2, 3 and 4.
"""

from __future__ import annotations

import contextlib
import functools
import sys
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

__all__ = [
    "DependencyError",
    "FormatError",
    "GeometryError",
    "GeosurfError",
    "GeosurfWarning",
    "HorizonError",
    "InputError",
    "InvariantError",
    "OpenUnitError",
    "OutputError",
    "RoundingError",
    "ScenarioError",
    "SurfaceError",
    "WorkerError",
]


def _printable(word: object) -> object:
    """A text with escapes in place of control characters; anything else as it is."""
    if not isinstance(word, str) or word.replace("\n", "").replace("\t", "").isprintable():
        return word
    return "".join(c if c.isprintable() or c in "\n\t" else repr(c)[1:-1] for c in word)


class GeosurfError(Exception):
    """Base class of all errors that geosurf raises on purpose.

    Attributes
    ----------
    place : (easting, northing, elevation) or None
        Position of the problem [m], if it has one; ``geosurf.render.render_place`` draws it.
    surfaces : tuple of str
        Names of the surfaces involved.
    close_up : geosurf.model.excerpt.CloseUp or None
        What a picture of the place shows, if that is not in the scene.
    """

    exit_code = 4

    def __init__(
        self,
        *words: object,
        place: Iterable[float] | None = None,
        surfaces: Iterable[str] = (),
        close_up: Any = None,
    ) -> None:
        # control characters of a file would drive the terminal
        super().__init__(*(_printable(word) for word in words))
        self.place = None if place is None else tuple(float(value) for value in place)
        self.surfaces = tuple(surfaces)
        self.close_up = close_up


class InputError(GeosurfError, ValueError):
    """The input cannot be used."""

    exit_code = 2


class FormatError(InputError):
    """A file does not follow its format; the message has path, line, found and expected."""


class HorizonError(InputError):
    """A gridded horizon has the wrong dimensions, order, units or values."""


class SurfaceError(InputError):
    """A triangulated surface has unusable vertices or triangles."""


class ScenarioError(InputError):
    """A scenario has an unknown key, a missing one, or an impossible value."""


class DependencyError(InputError):
    """An optional package is not installed; the message has the command that installs it."""


class OutputError(InputError):
    """A file or folder cannot be written."""


class WorkerError(InputError):
    """A worker of an ensemble was lost; what is finished is stored."""


class GeometryError(GeosurfError):
    """The input is valid, but its geometry cannot be used."""

    exit_code = 3


class OpenUnitError(GeometryError):
    """A unit is not closed; the message has the length and position of the open rim."""


class RoundingError(GeometryError):
    """Rounding the exact result to float64 would make surfaces cross each other."""


class InvariantError(GeosurfError, AssertionError):
    """A bug in geosurf: a result violates a guarantee. Please report it with the input."""

    exit_code = 4


class GeosurfWarning(UserWarning):
    """An assumption that geosurf made, with the size of its effect and a remedy.

    `Scene.warnings` lists those of a scene; each is also issued once by Python's ``warnings``.

    Parameters
    ----------
    kind : str
        Kind of assumption, one or two words: ``"area"``, ``"spike"`` ...
    subject : str
        Name of the input that is affected.
    effect : str
        What geosurf assumed or left out, and how large the effect is.
    remedy : str
        What to type to change it.
    place : (easting, northing, elevation), optional
        Position [m], if it has one.

    Examples
    --------
    >>> note = GeosurfWarning(
    ...     "area", "box", "The default box covers 18 % of the field.", "Give aoi= or box=."
    ... )
    >>> print(note)
    The default box covers 18 % of the field. Give aoi= or box=.
    >>> note.kind, note.subject, note.place
    ('area', 'box', None)
    """

    def __init__(
        self,
        kind: str,
        subject: str,
        effect: str,
        remedy: str,
        place: Iterable[float] | None = None,
    ) -> None:
        where = None if place is None else tuple(float(value) for value in place)
        super().__init__(kind, subject, effect, remedy, where)
        self.kind, self.subject, self.effect, self.remedy, self.place = self.args

    def __str__(self) -> str:
        return f"{self.effect} {self.remedy}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, GeosurfWarning) and self.args == other.args

    def __hash__(self) -> int:
        return hash(self.args)


# ---- warnings ----------------------------------------
# A scene collects the warnings of its steps, stores them with their results, and issues each once.
# Outside a scene a function issues its warnings itself. Both call `warn`.


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
    collector = _collector.get()
    if collector is not None:
        collector.append(warning)
    return collector is not None


@contextmanager
def collected() -> Iterator[list[GeosurfWarning]]:
    """Collect what is warned of inside the ``with`` block, instead of issuing it.

    Yields
    ------
    list of GeosurfWarning
        Grows while the block runs.
    """
    warnings_collected: list[GeosurfWarning] = []
    token = _collector.set(warnings_collected)
    try:
        yield warnings_collected
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
