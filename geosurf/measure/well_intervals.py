"""Which units a well goes through: intervals along its path, with entry and exit points.

Everything that might be a boundary next to the path is listed, generously: a crossing too many does
no harm, since the unit between two crossings is looked up exactly (`locate`), and neighbours with
the same unit are one interval.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import real_numbers
from geosurf.errors import InputError
from geosurf.measure.boundaries import Boundaries
from geosurf.measure.locate import Locator
from geosurf.measure.places import NAMES, places_of
from geosurf.measure.sample import LABELS
from geosurf.model import Units

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

PIECE = 1 / 64  # of the diagonal of the model: the box around a longer piece holds too much
SLIP = 1e-7  # how far outside of a triangle, as a share of it, a crossing still counts as one


def well_intervals(
    units: Units, path: Any, md: Any, locator: Locator, boundaries: Boundaries
) -> xarray.Dataset:
    """
    Return the units that a well goes through, from its first point to its last.

    Parameters
    ----------
    units : Units
    path : array_like, table or xarray object
        Points along the well, in order: see `sample_units`. A column ``md`` is its measured depth.
    md : array_like of float, shape (n,), optional
        Measured depth of each point [m]. Default: the column ``md``, else the length of the path.
    locator : Locator
        Of these units.
    boundaries : Boundaries
        Of these units.

    Returns
    -------
    xarray.Dataset
        Along ``interval``: ``unit``, ``zone``, ``block`` (``contact``); ``md`` at (interval, end),
        and ``easting``, ``northing``, ``elevation`` there, with ``end`` being "entry" and "exit".

    Raises
    ------
    InputError
        For a path of fewer than two different points, or a measured depth that does not rise.
    """
    import xarray as xr

    points, along = _path(path, md, units.box)
    local = points - boundaries.origin

    # where the path may pass a boundary: place as row of the point, and the share up to the next
    crossings = _crossings(local, boundaries, _longest(units))
    ends = np.unique(np.concatenate([np.arange(len(points)), crossings]))
    middle = 0.5 * (ends[1:] + ends[:-1])
    found = locator.find(_at(middle, points))

    # neighbours in one unit are one interval
    new = np.append(True, found[1:] != found[:-1])
    first, last = ends[:-1][new], np.append(ends[:-1][new][1:], ends[-1])
    which = found[new]
    both = np.stack([first, last], axis=1)
    places = _at(both.ravel(), points).reshape(-1, 2, 3)
    dims = ("interval", "end")
    data: dict[str, Any] = {
        "md": (dims, np.interp(both, np.arange(len(along)), along), {"units": "m"})
    }
    for k, name in enumerate(NAMES):
        data[name] = (dims, places[:, :, k], {"units": "m"})
    crs = {} if units.crs is None else {"crs": units.crs}
    listed = list(units.values())
    for name, (meaning, read) in LABELS.items():
        words = [read(unit) for unit in listed]
        if name != "contact" or any(words):
            labels = np.array([*words, ""], dtype=object)[which]
            data[name] = ("interval", labels, {"long_name": meaning})
    return xr.Dataset(data, {"end": ["entry", "exit"]}, crs)


def intervals_of_wells(
    units: Units, wells: Mapping[str, Any], locator: Locator, boundaries: Boundaries
) -> xarray.Dataset:
    """
    Return the units that each of many wells goes through, in one table.

    Parameters
    ----------
    units : Units
    wells : mapping of str to path
        See `wells_of`.
    locator : Locator
        Of these units.
    boundaries : Boundaries
        Of these units.

    Returns
    -------
    xarray.Dataset
        As `well_intervals` returns it, and ``well`` over ``interval``.

    Raises
    ------
    InputError
        For a path that cannot be used; the message names the well.
    """
    import xarray as xr

    found = []
    for name, path in wells.items():
        one = _named(name, well_intervals, units, path, None, locator, boundaries)
        label = np.full(one.sizes["interval"], name, dtype=object)
        found.append(one.assign(well=("interval", label, {"long_name": "well"})))
    table = xr.concat(found, "interval", combine_attrs="override")
    return table[["well", *(key for key in table.data_vars if key != "well")]]


def wells_of(path: Any) -> dict[str, Any] | None:
    """
    Return many wells by their names; None for the path of one well.

    Parameters
    ----------
    path : mapping of str to path, or table
        Many wells: a mapping whose values are paths, or a table with a column ``well``.

    Raises
    ------
    InputError
        If there is no well, a name is not text, or the column ``well`` does not fit the table.

    Examples
    --------
    >>> wells_of([[0, 0, 5], [0, 0, -5]]) is None
    True
    >>> list(wells_of({"W-1": [[0, 0, 5], [0, 0, -5]]}))
    ['W-1']
    """
    table = hasattr(path, "columns") or hasattr(path, "data_vars")
    if not (table or isinstance(path, Mapping)):
        return None
    if "well" in path and "easting" in path:
        return _wells_of_table(path)
    if table or any(name in path for name in NAMES):
        return None
    if not path or not all(isinstance(name, str) and name for name in path):
        raise InputError(
            "wells have no names. Give a mapping such as {'W-1': path}, or a table with the "
            "columns well, easting, northing and elevation."
        )
    return dict(path)


def _wells_of_table(table: Any) -> dict[str, Any]:
    """Rows of each well of a table, in the order of the wells' first rows."""
    column = np.ravel(np.asarray(getattr(table["well"], "values", table["well"]), dtype=object))
    unnamed = [k for k, name in enumerate(column) if not (isinstance(name, str) and name)]
    if unnamed or not len(column):
        where = f"row {unnamed[0] + 1} has none" if unnamed else "the table has no rows"
        raise InputError(f"the column 'well' must name the well of each row: {where}.")
    names = dict.fromkeys(column.tolist())
    rows = {name: np.flatnonzero(column == name) for name in names}
    if hasattr(table, "data_vars"):
        dims = table["well"].dims
        if len(dims) != 1:
            raise InputError(f"the column 'well' lies along {dims}; it must have one dimension.")
        return {name: table.isel({dims[0]: at}) for name, at in rows.items()}
    keys = [key for key in (*NAMES, "md") if key in table]
    columns = {key: np.ravel(np.asarray(getattr(table[key], "values", table[key]))) for key in keys}
    for key, values in columns.items():
        if len(values) != len(column):
            raise InputError(
                f"the columns of the table have different lengths: well has {len(column)} rows, "
                f"{key} has {len(values)}."
            )
    return {name: {key: columns[key][at] for key in keys} for name, at in rows.items()}


def _path(path: Any, md: Any, box: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) of a path, without repeats, and their measured depths."""
    places = places_of(path, None, box)
    if len(places.shape) != 1:
        raise InputError(
            f"the path of a well has the shape {places.shape}; give its points in order, (n, 3)."
        )
    points = places.points(0, places.size) if places.size else np.empty((0, 3))
    if md is None and (isinstance(path, Mapping) or hasattr(path, "columns")) and "md" in path:
        md = path["md"]
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    if md is None:
        along = length[: len(points)]
    else:
        try:
            along = np.ravel(real_numbers(getattr(md, "values", md)))
        except (TypeError, ValueError) as error:
            raise InputError(f"md has values that are not numbers ({error}).") from error
        if len(along) != len(points):
            raise InputError(f"md has {len(along)} values for {len(points)} points of the path.")
        if not (np.diff(along) >= 0).all():
            at = int(np.flatnonzero(~(np.diff(along) >= 0))[0])
            raise InputError(
                f"md does not rise from point {at} to {at + 1} of the path. Sort the points."
            )

    # a point that repeats the one before adds nothing
    keep = np.ones(len(points), dtype=bool)
    keep[1:] = np.diff(length) > 0
    if keep.sum() < 2:
        raise InputError("the path of a well needs at least two different points.")
    return points[keep], along[keep]


def _at(place: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points of the path at places, each a row and a share of the way to the next row."""
    row = np.minimum(place.astype(np.int64), len(points) - 2)
    share = (place - row)[:, None]
    at: np.ndarray = points[row] + share * (points[row + 1] - points[row])
    return at


def _named(name: str, run: Callable[..., Any], *given: Any) -> Any:
    """What a function returns for one well; errors of input name the well."""
    try:
        return run(*given)
    except InputError as error:
        raise InputError(f"well {name!r}: {error}") from error


def _longest(units: Units) -> float:
    """Length of the longest piece of a path whose box is searched [m]."""
    low, high = np.reshape(units.box, (3, 2)).T
    return PIECE * float(np.linalg.norm(high - low))


def _pieces(points: np.ndarray, most: float) -> Iterator[tuple[int, tuple[np.ndarray, np.ndarray]]]:
    """Yield the row and the box (low (3,), high (3,)) of pieces of a path."""
    for row, (p, q) in enumerate(pairwise(points)):
        n = max(int(np.ceil(np.linalg.norm(q - p) / most)), 1)
        for k in range(n):
            a, b = p + (q - p) * (k / n), p + (q - p) * ((k + 1) / n)
            # wider than rounding may move the ends of a piece
            slip = 1e-9 * most
            yield row, (np.minimum(a, b) - slip, np.maximum(a, b) + slip)


def _crossings(points: np.ndarray, boundaries: Boundaries, most: float) -> np.ndarray:
    """Places where the path may pass through a triangle, in no order."""
    found = [np.empty(0)]
    for row, box in _pieces(points, most):
        p, q = points[row : row + 2]
        found.append(row + _shares(p, q - p, boundaries.near(*box)))
    return np.concatenate(found)


def _shares(p: np.ndarray, way: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Shares of the way from p at which it passes triangles (n, 3, 3); a little beside counts."""
    a = corners[:, 0]
    u, v = corners[:, 1] - a, corners[:, 2] - a
    normal = np.cross(u, v)
    fall = normal @ way
    area = (normal**2).sum(axis=1)

    # a piece along a triangle passes its neighbours, or nothing changes
    with np.errstate(divide="ignore", invalid="ignore"):
        share = ((a - p) * normal).sum(axis=1) / fall
        at = p + share[:, None] * way - a
        second = (np.cross(at, v) * normal).sum(axis=1) / area
        third = (np.cross(u, at) * normal).sum(axis=1) / area
        inside = (second >= -SLIP) & (third >= -SLIP) & (second + third <= 1.0 + SLIP)
        inside &= (share >= 0.0) & (share <= 1.0)
    rows: np.ndarray = share[inside]
    return rows
