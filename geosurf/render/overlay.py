"""Wells, polygons and data points that users add to maps, sections and views."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import real_numbers
from geosurf.conventions.foreign import lines_of_foreign, points_of_foreign
from geosurf.errors import InputError

if TYPE_CHECKING:  # pragma: no cover - types only
    pass

_COLUMNS = ("easting", "northing", "elevation")
Parts = dict[str, tuple[np.ndarray, ...]]


@dataclass(frozen=True, eq=False)
class PictureOverlay:
    """What is drawn on top of a model.

    Parameters
    ----------
    wells : mapping of str to array_like of float, shape (n, 3)
        Path of each well, from the top down [m]; also results of `read_points`. Or a table with
        a column ``well``, as `read_wells` returns it.
    polygons : mapping of str to array_like of float, shape (n, 2) or (n, 3)
        Closed lines, or a list of them, by name, such as results of `read_polygons` and
        `Scene.fault_polygons` [m], or lines and polygons of geopandas and shapely. One whose elevations are all 0 has no elevation.
    points : mapping of str to array_like of float, shape (n, 3)
        Data points by name, such as results of `read_points` [m].

    Raises
    ------
    InputError
        For coordinates of another shape, or values that are not finite.

    Examples
    --------
    >>> PictureOverlay(wells={"W1": [[0, 0, 0], [0, 50, -900]]}).wells["W1"][0].shape
    (2, 3)
    >>> PictureOverlay(points={"picks": [1, 2, 3]})
    Traceback (most recent call last):
    geosurf.errors.InputError: points['picks'] has shape (3,), expected (n, 3): easting, northing, elevation [m].
    """  # noqa: E501 - a message

    wells: Mapping[str, Any] = field(default_factory=dict)
    polygons: Mapping[str, Any] = field(default_factory=dict)
    points: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        # a table of many wells, as `read_wells` returns it
        object.__setattr__(self, "wells", _wells_of_table(self.wells))
        # all coordinates as tuples of arrays, so that pictures need not look at them
        for what, widths in (("wells", (3,)), ("polygons", (2, 3)), ("points", (3,))):
            object.__setattr__(self, what, _checked(what, getattr(self, what), widths))

    def arrays(self) -> tuple[Any, ...]:
        """Return all names and arrays in order: what a picture depends on."""
        kinds = (("wells", self.wells), ("polygons", self.polygons), ("points", self.points))
        return tuple(
            item
            for kind, parts in kinds
            for name, arrays in parts.items()
            for item in (kind, name, *arrays)
        )

    def __bool__(self) -> bool:
        return bool(self.wells or self.polygons or self.points)


def overlay_of(overlay: Any) -> PictureOverlay:
    """Return the overlay, or an empty one for None.

    Raises
    ------
    InputError
        For anything else.
    """
    if overlay is None:
        return NOTHING
    if not isinstance(overlay, PictureOverlay):
        raise InputError(
            f"overlay is a {type(overlay).__name__}, expected a PictureOverlay. "
            "Pass gs.PictureOverlay(wells={'W1': points})."
        )
    return overlay


def _wells_of_table(table: Any) -> Any:
    """Paths by the names of the wells of a table; anything else as it is."""
    is_table = hasattr(table, "data_vars") or hasattr(table, "columns")
    if not (is_table and all(name in table for name in (*_COLUMNS, "well"))):
        return table
    names = [str(name) for name in np.asarray(table["well"]).tolist()]
    points = np.column_stack([np.asarray(table[key], dtype=np.float64) for key in _COLUMNS])
    column = np.array(names, dtype=object)
    return {name: points[column == name] for name in dict.fromkeys(names)}


def _checked(what: str, given: Any, widths: tuple[int, ...]) -> Parts:
    """Coordinates by name, each a tuple of arrays (n, 2) or (n, 3)."""
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
        raise InputError(
            f"{what} is a {type(given).__name__}, expected a mapping of names to coordinates."
        )
    return {name: _parts(f"{what}[{name!r}]", value, widths) for name, value in given.items()}


def _parts(what: str, value: Any, widths: tuple[int, ...]) -> tuple[np.ndarray, ...]:
    """The arrays of one entry: a dataset with columns, one array, or a list of arrays."""
    size = " or ".join(f"(n, {width})" for width in widths)
    how = f"expected {size}: easting, northing, elevation [m]"
    if all(hasattr(value, name) for name in _COLUMNS):
        columns = [np.asarray(getattr(value, name), dtype=np.float64) for name in _COLUMNS]
        whole = np.stack(columns, axis=1)
        ends = np.cumsum(value["count"].values)[:-1] if hasattr(value, "line_of_point") else ()
        return tuple(np.split(whole, ends))
    try:
        foreign = (points_of_foreign if widths == (3,) else lines_of_foreign)(value)
    except ValueError as error:
        raise InputError(f"{what}: {error}; {how}.") from error
    if foreign is not None:
        value = foreign
    listed = value if isinstance(value, list | tuple) else [value]
    single = isinstance(value, np.ndarray) or np.ndim(listed[0] if listed else 0) < 2
    found = []
    for one in [value] if single else listed:
        try:
            points = real_numbers(one)
        except (TypeError, ValueError) as error:
            raise InputError(f"{what} is a {type(value).__name__}, {how}.") from error
        if points.ndim != 2 or points.shape[1] not in widths or not len(points):
            raise InputError(f"{what} has shape {points.shape}, {how}.")
        if not np.isfinite(points).all():
            raise InputError(f"{what} has values that are not finite. Remove these rows.")
        # files of outlines have 0 where they have no elevation
        flat = widths[0] == 2 and points.shape[1] == 3 and not points[:, 2].any()
        found.append(points[:, :2] if flat else points)
    return tuple(found)


NOTHING = PictureOverlay()  # at the end: it is checked by the functions above
