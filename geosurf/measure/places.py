"""Places that users ask about: points, tables, maps and grids, as one array of coordinates each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import xarray

from geosurf.arrangement.threads import map_threads
from geosurf.conventions import (
    CONVERSION_ERRORS,
    HORIZON_DIMS,
    elevation_sign,
    is_number,
    metres_of,
    real_numbers,
)
from geosurf.conventions.axes import COORDINATES
from geosurf.conventions.checks import points_of_foreign
from geosurf.errors import InputError
from geosurf.measure.locate import AT_ONCE, Boundaries, Locator, locator_of
from geosurf.model import Unit, Units
from geosurf.model.expected import expect

MOST_CELLS = 1e9
HOW = (
    "Give an array (n, 3) of easting, northing, elevation; or a table or xarray object with these "
    "names; or cell=(dx, dy, dz)"
)


@dataclass(frozen=True, eq=False)
class Places:
    """Places of a question, as arrays of coordinates.

    Attributes
    ----------
    dims : tuple of str
    shape : tuple of int
    axes : tuple of three ndarrays of float64
        Easting, northing, elevation [m]; each fits `shape` by broadcasting.
    coords : dict
        As xarray takes them.
    rows : ndarray of float64, shape (n, 3), optional
        All coordinates, where the user has them in this form: nothing is copied.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    axes: tuple[np.ndarray, np.ndarray, np.ndarray]
    coords: dict[str, Any]
    rows: np.ndarray | None = None

    @property
    def size(self) -> int:
        """Number of places."""
        return int(np.prod(self.shape, dtype=np.int64))

    def parts(self, at_once: int) -> Iterator[tuple[slice, Callable[[], np.ndarray]]]:
        """Parts of about a size: which places, and what makes their coordinates (n, 3)."""
        # whole slices of the first dimension: nothing is broadcast as a whole
        n = self.shape[0] if self.shape else 1
        each = self.size // max(n, 1)
        step = max(at_once // max(each, 1), 1)
        for first in range(0, n, step):
            last = min(first + step, n)
            yield slice(first * each, last * each), partial(self.points, first, last)

    @property
    def is_grid(self) -> bool:
        """Whether the first dimension has levels, and the others places on the map."""
        x, y, z = self.axes
        return x.ndim > 1 and x.shape[0] == y.shape[0] == 1 and z.size == z.shape[0] > 1

    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Places on the map (n, 2), and the levels of a grid."""
        x, y = (np.broadcast_to(axis[0], self.shape[1:]).ravel() for axis in self.axes[:2])
        return np.stack([x, y], axis=1), self.axes[2].ravel()

    def points(self, first: int, last: int) -> np.ndarray:
        """World coordinates (n, 3) of slices of the first dimension."""
        if not self.shape:
            return np.array([[axis.item() for axis in self.axes]])
        if self.rows is not None:
            return self.rows[first:last]
        shown = [np.broadcast_to(axis, self.shape)[first:last].reshape(-1) for axis in self.axes]
        return np.stack(shown, axis=1)


def places_of(where: Any, cell: Any, box: tuple[float, ...]) -> Places:
    """
    Return the places that a user asks about, or raise an error that names what is wrong.

    Parameters
    ----------
    where : array_like, table, xarray object or None
    cell : (dx, dy, dz) or None
        Size of the cells of a regular grid that fills the box [m].
    box : (west, east, south, north, bottom, top)

    Returns
    -------
    Places

    Raises
    ------
    InputError

    Examples
    --------
    >>> places_of([[0, 0, -5], [9, 0, -5]], None, (0, 1, 0, 1, 0, 1)).shape
    (2,)
    >>> places_of(None, (50, 50, 5), (0, 100, 0, 200, -1010, -1000)).shape
    (2, 4, 2)
    """
    if (where is None) == (cell is None):
        raise InputError(f"sample takes either places or cell=. {HOW}.")
    try:
        foreign = points_of_foreign(where)
    except ValueError as error:
        raise InputError(f"places: {error}. {HOW}.") from error
    if where is None:
        places = _cells(cell, box)
    elif foreign is not None:
        places = _of_array(foreign)
    elif hasattr(where, "coords") and hasattr(where, "dims"):
        places = _of_xarray(where)
    elif isinstance(where, Mapping) or hasattr(where, "columns"):
        places = _of_table(where)
    else:
        places = _of_array(where)
    _check_finite(places)
    return places


def _cells(cell: Any, box: tuple[float, ...]) -> Places:
    """Middles of the cells of a regular grid that fills the box; the cells fit it exactly."""
    sizes = cell if isinstance(cell, tuple | list | np.ndarray) and len(np.shape(cell)) == 1 else ()
    if len(sizes) != 3 or not all(is_number(d) and d > 0 for d in sizes):
        raise InputError(f"cell is {cell!r}; give three sizes above 0: cell=(dx, dy, dz) [m].")
    numbers = [
        max(round((high - low) / size), 1)
        for low, high, size in zip(box[::2], box[1::2], cell, strict=True)
    ]
    if float(np.prod(np.array(numbers, dtype=float))) > MOST_CELLS:
        raise InputError(
            f"cells of {cell} m in this box are {' x '.join(map(str, numbers))}, more than "
            f"{MOST_CELLS:g}. Give larger ones."
        )
    x, y, z = (
        low + (np.arange(n) + 0.5) * ((high - low) / n)
        for low, high, n in zip(box[::2], box[1::2], numbers, strict=True)
    )
    axes = (x[None, None, :], y[None, :, None], z[:, None, None])
    coords = {
        name: (name, axis, _attrs(name)) for name, axis in zip(COORDINATES, (x, y, z), strict=True)
    }
    return Places(COORDINATES[::-1], (len(z), len(y), len(x)), axes, coords)


def _of_array(where: Any) -> Places:
    """Points (..., 3)."""
    try:
        points = real_numbers(where)
    except (TypeError, ValueError) as error:
        raise InputError(f"places are not numbers ({error}). {HOW}.") from error
    if points.ndim == 0 or points.shape[-1] != 3:
        raise InputError(f"places have the shape {points.shape}; the last size must be 3. {HOW}.")
    shape = points.shape[:-1]
    dims = ("point",) if len(shape) == 1 else tuple(f"point_{k}" for k in range(len(shape)))
    axes = (points[..., 0], points[..., 1], points[..., 2])
    rows = points if len(shape) == 1 and points.flags.c_contiguous else None
    return Places(dims, shape, axes, _point_coords(dims, axes), rows)


def points_of_array(where: Any) -> np.ndarray:
    """Return points (n, 3), checked, as a new array."""
    found = _of_array(where)
    _check_finite(found)
    return np.stack([axis.ravel() for axis in found.axes], axis=1)


def _point_coords(dims: tuple[str, ...], axes: tuple[np.ndarray, ...]) -> dict[str, Any]:
    """Coordinates that lie along the dimensions of the points."""
    return {name: (dims, axis, _attrs(name)) for name, axis in zip(COORDINATES, axes, strict=True)}


def _of_table(where: Any) -> Places:
    """Columns of a table."""
    try:
        columns = {name: where[name] for name in COORDINATES}
    except CONVERSION_ERRORS as error:
        names = list(getattr(where, "columns", where))
        raise InputError(f"the table has no column {error} among {names}. {HOW}.") from error
    try:
        arrays = [np.ravel(real_numbers(getattr(c, "values", c))) for c in columns.values()]
    except (TypeError, ValueError) as error:
        raise InputError(f"the table has places that are not numbers ({error}). {HOW}.") from error
    sizes = {name: len(array) for name, array in zip(COORDINATES, arrays, strict=True)}
    if len(set(sizes.values())) != 1:
        raise InputError(f"the columns of the table have different lengths: {sizes}. {HOW}.")
    x, y, z = arrays
    return Places(("point",), x.shape, (x, y, z), _point_coords(("point",), (x, y, z)))


def _of_xarray(where: Any) -> Places:
    """Three coordinates of an xarray object, or a map whose values are elevations."""
    known = {**getattr(where, "data_vars", {}), **where.coords}
    if "elevation" not in known and isinstance(where, xarray.DataArray):
        known["elevation"] = where
    if missing := [name for name in COORDINATES if name not in known]:
        raise InputError(
            f"the places have no {' and no '.join(map(repr, missing))}, only {sorted(known)}. "
            f"{HOW}."
        )

    # in metres and positive up, whatever they declare
    axes = []
    for name in COORDINATES:
        coord = xarray.DataArray(known[name]).drop_vars([*known[name].coords], errors="ignore")
        values = metres_of(coord, f"{name!r} of the places")
        if name == "elevation":
            values = values * elevation_sign(coord.attrs.get("positive", "up"), "the places")
        axes.append(coord.copy(data=values + 0.0))

    # levels lead, rows and columns follow, as grids have them
    xarray.align(*axes, join="exact")
    order = list(dict.fromkeys(d for coord in axes[::-1] for d in coord.dims))
    if set(order) >= set(HORIZON_DIMS):
        order = [d for d in order if d not in HORIZON_DIMS] + list(HORIZON_DIMS)
    shape = tuple(next(coord.sizes[d] for coord in axes if d in coord.dims) for d in order)
    coords = {
        name: (coord.dims, coord.values, _attrs(name))
        for name, coord in zip(COORDINATES, axes, strict=True)
    }
    arrays = []
    for coord in axes:
        wide = coord.expand_dims([d for d in order if d not in coord.dims])
        arrays.append(wide.transpose(*order).values)
    x, y, z = arrays
    return Places(tuple(map(str, order)), shape, (x, y, z), coords)


def _attrs(name: str) -> dict[str, str]:
    return {"units": "m", "positive": "up"} if name == "elevation" else {"units": "m"}


def _check_finite(places: Places) -> None:
    """Refuse places with coordinates that are not finite, with the first of them."""
    # a sum is finite if all its terms are, unless it overflows: then the places are looked through
    with np.errstate(all="ignore"):
        known = places.axes if places.rows is None else (places.rows,)
        if all(np.isfinite(one.sum()) for one in known):
            return
    at = 0
    for _, make in places.parts(1 << 20):
        points = make()
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(bad):
            at = at + int(bad[0])
            raise InputError(
                f"place {at} has a coordinate that is not finite: {points[bad[0]].tolist()}. Leave "
                "such places out."
            )
        at += len(points)


# ---- sample ----------------------------------------
# Which zone, block, contact interval and unit is at a place; exact, for any number of places.


# what a unit is called, and how its names are read off it
LABELS: dict[str, tuple[str, Callable[[Unit], str]]] = {
    "unit": ("unit", lambda unit: unit.name),
    "zone": ("zone", lambda unit: unit.zone),
    "block": ("fault block", lambda unit: unit.block),
    "region": ("part of the field through all zones", lambda unit: unit.region),
    "contact": ("interval between fluid contacts", lambda unit: unit.contact),
}
RULE = (
    "A point on a surface belongs to the unit below it. On a vertical surface it belongs to the "
    "unit on the side of the middle of the model, on the floor of the model to the unit above."
)


def sample_units(
    units: Units,
    where: Any = None,
    *,
    cell: Any = None,
    codes: bool = False,
    locator: Locator | None = None,
    boundaries: Boundaries | None = None,
) -> xarray.Dataset:
    """
    Return the zone, block, contact interval and unit at each of some places.

    Parameters
    ----------
    units : Units
        As from `carve_units`.
    where : array_like, table or xarray object, optional
        World coordinates [m]: an array ``(..., 3)`` of easting, northing and elevation; a table
        with these columns; an xarray object with these coordinates, which may be the axes of a
        grid; or a map of elevations.
    cell : (dx, dy, dz), optional
        Instead: the middles of the cells of a regular grid that fills the model box, of about this
        size [m].
    codes : bool
        Whether to return whole numbers, which have their names in ``attrs``, not names. Ten million
        places then take 40 MB a variable, and the dataset can be written to a file.
    locator : Locator, optional
        Of these units; by default made anew.
    boundaries : Boundaries, optional
        Of these units: then there are distances, too.

    Returns
    -------
    xarray.Dataset
        ``unit``, ``zone``, ``block``, and ``contact`` where there are fluid contacts. Outside the
        model names are empty, and codes are -1. A point on a surface belongs to the unit below it,
        a point on a vertical surface to the unit on the side of the middle of the model, a point on
        the floor of the model to the unit above. With `boundaries` also ``distance`` to the nearest
        boundary of a unit, inside and outside the model [m].

    Raises
    ------
    InputError
        For places that are not numbers, not finite, or not three coordinates each.

    Notes
    -----
    Every answer is exact for the triangles of the model: a vertical line from the point passes the
    surfaces above, and signs that doubles do not decide are computed in integers.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes()
    >>> units = gs.Scene(world.horizons, world.faults, world.box).units
    >>> found = sample_units(units, [[1000.0, 1500.0, -2100.0], [1000.0, 1500.0, 99.0]])
    >>> found.zone.values.tolist()
    ['Top/Base', '']
    """
    expect(units, Units, "sample_units takes Units", "pass the result of carve_units")
    if not isinstance(codes, bool | np.bool_):
        raise InputError(f"codes is {codes!r}; give True or False.")
    places = places_of(where, cell, units.box)
    if locator is None:
        locator = locator_of(units)
    expect(locator, Locator, "locator is the Locator of these units", "leave it out")
    if boundaries is not None:
        expect(
            boundaries, Boundaries, "boundaries are the Boundaries of these units", "leave them out"
        )

    found = _of_grid(places, locator) if places.is_grid else _of_all(places, locator.find, np.int32)
    data = _labels(units, found.reshape(places.shape), places.dims, codes=bool(codes))
    if boundaries is not None:
        attrs = {"units": "m", "long_name": "distance to the nearest boundary of a unit"}
        away = _of_all(places, boundaries.distance, np.float64)
        data["distance"] = (places.dims, away.reshape(places.shape), attrs)
    crs = {} if units.crs is None else {"crs": units.crs}
    return xarray.Dataset(data, places.coords, {"rule": RULE, **crs})


def _of_all(places: Places, ask: Callable[[np.ndarray], np.ndarray], dtype: Any) -> np.ndarray:
    """What is asked of each place; parts in threads, each writes its own rows."""
    answers = np.empty(places.size, dtype=dtype)

    def work(rows: slice, points: Callable[[], np.ndarray]) -> None:
        answers[rows] = ask(points())

    parts = list(places.parts(AT_ONCE))
    map_threads(work, parts, worth=len(parts) > 1)
    return answers


def _of_grid(places: Places, locator: Locator) -> np.ndarray:
    """The same for a grid, line by line: a thirtieth of the time of as many points."""
    feet, levels = places.lines()
    order = np.argsort(levels, kind="stable")
    unit_rows = np.empty((len(levels), len(feet)), dtype=np.int32)
    each = max(AT_ONCE // len(levels), 1)

    def work(first: int) -> None:
        rows = slice(first, first + each)
        unit_rows[order, rows] = locator.find_on_lines(feet[rows], levels[order]).T

    parts = [(first,) for first in range(0, len(feet), each)]
    map_threads(work, parts, worth=len(parts) > 1)
    return unit_rows


def _labels(
    units: Units, unit_rows: np.ndarray, dims: tuple[str, ...], *, codes: bool = False
) -> dict[str, Any]:
    """One variable for each kind of name that tells units apart, from their rows."""
    data: dict[str, Any] = {}
    for name, (meaning, read) in LABELS.items():
        words = [read(unit) for unit in units.values()]
        if name in ("region", "contact") and not any(words):
            continue
        if codes:
            data[name] = (dims, *_codes(unit_rows, words, meaning))
        else:  # the last one is what -1 stands for: outside
            names = np.array([*words, ""], dtype=object)[unit_rows]
            data[name] = (dims, names, {"long_name": meaning})
    return data


def _codes(
    unit_rows: np.ndarray, words: list[str], meaning: str
) -> tuple[np.ndarray, dict[str, Any]]:
    """Codes at all places, and their attributes."""
    known = list(dict.fromkeys(words))
    number = {word: k for k, word in enumerate(known)}
    values = np.array([*(number[word] for word in words), -1], dtype=np.int32)
    attrs = {
        "long_name": meaning,
        "flag_values": np.arange(len(known), dtype=np.int32),
        # separated by blanks, as the CF conventions ask; `names` has them as they are
        "flag_meanings": " ".join("_".join(word.split()) or "-" for word in known),
        "names": known,
        "outside": np.int32(-1),
    }
    # units have names of their own, so that their rows are the codes
    return unit_rows if len(known) == len(words) else values[unit_rows], attrs


# ---- well intervals ----------------------------------------
# Which units a well goes through: intervals along its path, with entry and exit points.
#
# Everything that might be a boundary next to the path is listed, generously: a crossing too many
# does no harm, since the unit between two crossings is looked up exactly (`locate`), and
# neighbours with the same unit are one interval.


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
    points, along = _path(path, md, units.box)
    local = points - boundaries.origin

    # where the path may pass a boundary: place as row of the point, and the share up to the next
    longest = PIECE * float(np.linalg.norm(np.ptp(np.reshape(units.box, (3, 2)), axis=1)))
    crossings = _crossings(local, boundaries, longest)
    ends = np.unique(np.concatenate([np.arange(len(points)), crossings]))
    middle = 0.5 * (ends[1:] + ends[:-1])
    unit_rows = locator.find(_at(middle, points))

    # neighbours in one unit are one interval
    new = np.append(True, unit_rows[1:] != unit_rows[:-1])
    first, last = ends[:-1][new], np.append(ends[:-1][new][1:], ends[-1])
    which = unit_rows[new]
    both = np.stack([first, last], axis=1)
    places = _at(both.ravel(), points).reshape(-1, 2, 3)
    dims = ("interval", "end")
    data: dict[str, Any] = {
        "md": (dims, np.interp(both, np.arange(len(along)), along), {"units": "m"})
    }
    for k, name in enumerate(COORDINATES):
        data[name] = (dims, places[:, :, k], {"units": "m"})
    crs = {} if units.crs is None else {"crs": units.crs}
    data |= _labels(units, which, ("interval",))
    return xarray.Dataset(data, {"end": ["entry", "exit"]}, crs)


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
    tables = []
    for name, path in wells.items():
        intervals = _named(name, well_intervals, units, path, None, locator, boundaries)
        label = np.full(intervals.sizes["interval"], name, dtype=object)
        tables.append(intervals.assign(well=("interval", label, {"long_name": "well"})))
    table = xarray.concat(tables, "interval", combine_attrs="override")
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
    if table or any(name in path for name in COORDINATES):
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
    keys = [key for key in (*COORDINATES, "md") if key in table]
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
        # nobody drills from below sea level: the depth of such a first point is not known
        along = length[: len(points)] + (np.nan if len(points) and points[0, 2] < 0.0 else 0.0)
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
    return points[row] + share * (points[row + 1] - points[row])


def _named(name: str, run: Callable[..., Any], *given: Any) -> Any:
    """What a function returns for one well; errors of input name the well."""
    try:
        return run(*given)
    except InputError as error:
        raise InputError(f"well {name!r}: {error}") from error


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
    places = [np.empty(0)]
    for row, box in _pieces(points, most):
        p, q = points[row : row + 2]
        places.append(row + _shares(p, q - p, boundaries.near(*box)))
    return np.concatenate(places)


def _shares(p: np.ndarray, direction: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Shares of the way from p at which it passes triangles (n, 3, 3); a little beside counts."""
    a = corners[:, 0]
    u, v = corners[:, 1] - a, corners[:, 2] - a
    normal = np.cross(u, v)
    fall = normal @ direction
    area = (normal**2).sum(axis=1)

    # a piece along a triangle passes its neighbours, or nothing changes
    with np.errstate(divide="ignore", invalid="ignore"):
        share = ((a - p) * normal).sum(axis=1) / fall
        at = p + share[:, None] * direction - a
        second = (np.cross(at, v) * normal).sum(axis=1) / area
        third = (np.cross(u, at) * normal).sum(axis=1) / area
        inside = (second >= -SLIP) & (third >= -SLIP) & (second + third <= 1.0 + SLIP)
        inside &= (share >= 0.0) & (share <= 1.0)
    return share[inside]
