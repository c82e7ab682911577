"""Every exception that geosurf raises on purpose, and its one kind of warning.

Each message is one or two sentences: what is wrong, where, and what to do next.
The class says whose move it is: the input's (`InputError`), the geometry's
(`GeometryError`) or geosurf's own (`InvariantError`). The command line turns
them into exit codes 2, 3 and 4.
"""

from __future__ import annotations

from collections.abc import Iterable

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
]


class GeosurfError(Exception):
    """Root of all errors raised on purpose.

    Attributes
    ----------
    place : (easting, northing, elevation) or None
        Where it is [m], if it is somewhere; `geosurf.render.render_place` draws it.
    surfaces : tuple of str
        Names of the surfaces that it is about.
    """

    exit_code = 4

    def __init__(
        self, *words: object, place: Iterable[float] | None = None, surfaces: Iterable[str] = ()
    ) -> None:
        super().__init__(*words)
        self.place = None if place is None else tuple(float(value) for value in place)
        self.surfaces = tuple(surfaces)


class InputError(GeosurfError, ValueError):
    """What was handed over cannot be used."""

    exit_code = 2


class FormatError(InputError):
    """A file is not what its format says: path, place, found, expected."""


class HorizonError(InputError):
    """A gridded horizon has the wrong dimensions, order, units or values."""


class SurfaceError(InputError):
    """A triangulated surface has unusable vertices or triangles."""


class ScenarioError(InputError):
    """A scenario has an unknown key, a missing one, or an impossible value."""


class DependencyError(InputError):
    """Something optional is not installed; the message says what brings it."""


class OutputError(InputError):
    """A file or folder cannot be written."""


class GeometryError(GeosurfError):
    """Legal input, impossible geometry."""

    exit_code = 3


class OpenUnitError(GeometryError):
    """A unit leaks: the message gives the length and place of the open rim."""


class RoundingError(GeometryError):
    """The exact result cannot be held in float64 without crossing itself."""


class InvariantError(GeosurfError, AssertionError):
    """geosurf broke one of its own promises; please report it with the input."""

    exit_code = 4


class GeosurfWarning(UserWarning):
    """Something that geosurf assumed and the user could not know, with the size of its effect.

    `Scene.warnings` lists those of a scene; each is also issued once by Python's `warnings`.

    Parameters
    ----------
    kind : str
        What sort of assumption it is, one or two words: ``"area"``, ``"spike"`` ...
    subject : str
        Name of the input that it is about.
    effect : str
        What was assumed or left out, and how much that is: one sentence.
    remedy : str
        What to type if that is not what was meant: one sentence.
    place : (easting, northing, elevation), optional
        Where it is [m], if it is somewhere.

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
