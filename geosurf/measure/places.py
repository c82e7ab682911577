"""Places that users ask about: points, tables, maps and grids, as one array of coordinates each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from geosurf.conventions import (
    CONVERSION_ERRORS,
    HORIZON_DIMS,
    elevation_sign,
    is_number,
    metres_per_unit,
    real_numbers,
)
from geosurf.conventions.foreign import points_of_foreign
from geosurf.errors import InputError

NAMES = ("easting", "northing", "elevation")
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
        found = _cells(cell, box)
    elif foreign is not None:
        found = _of_array(foreign)
    elif hasattr(where, "coords") and hasattr(where, "dims"):
        found = _of_xarray(where)
    elif isinstance(where, Mapping) or hasattr(where, "columns"):
        found = _of_table(where)
    else:
        found = _of_array(where)
    _check_finite(found)
    return found


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
    return _product(x, y, z)


def _product(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> Places:
    axes = (x[None, None, :], y[None, :, None], z[:, None, None])
    coords = {name: (name, axis, _attrs(name)) for name, axis in zip(NAMES, (x, y, z), strict=True)}
    return Places(NAMES[::-1], (len(z), len(y), len(x)), axes, coords)


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


def _point_coords(dims: tuple[str, ...], axes: tuple[np.ndarray, ...]) -> dict[str, Any]:
    """Coordinates that lie along the dimensions of the points."""
    return {name: (dims, axis, _attrs(name)) for name, axis in zip(NAMES, axes, strict=True)}


def _of_table(where: Any) -> Places:
    """Columns of a table."""
    try:
        columns = {name: where[name] for name in NAMES}
    except CONVERSION_ERRORS as error:
        names = list(getattr(where, "columns", where))
        raise InputError(f"the table has no column {error} among {names}. {HOW}.") from error
    try:
        arrays = [np.ravel(real_numbers(getattr(c, "values", c))) for c in columns.values()]
    except (TypeError, ValueError) as error:
        raise InputError(f"the table has places that are not numbers ({error}). {HOW}.") from error
    sizes = {name: len(array) for name, array in zip(NAMES, arrays, strict=True)}
    if len(set(sizes.values())) != 1:
        raise InputError(f"the columns of the table have different lengths: {sizes}. {HOW}.")
    x, y, z = arrays
    return Places(("point",), x.shape, (x, y, z), _point_coords(("point",), (x, y, z)))


def _of_xarray(where: Any) -> Places:
    """Three coordinates of an xarray object, or a map whose values are elevations."""
    import xarray as xr

    known = {**getattr(where, "data_vars", {}), **where.coords}
    if "elevation" not in known and isinstance(where, xr.DataArray):
        known["elevation"] = where
    if missing := [name for name in NAMES if name not in known]:
        raise InputError(
            f"the places have no {' and no '.join(map(repr, missing))}, only {sorted(known)}. "
            f"{HOW}."
        )

    # in metres and positive up, whatever they declare
    found = []
    for name in NAMES:
        one = xr.DataArray(known[name]).drop_vars([*known[name].coords], errors="ignore")
        factor = metres_per_unit(one.attrs.get("units", "m"), f"{name!r} of the places")
        if name == "elevation":
            factor *= elevation_sign(one.attrs.get("positive", "up"), "the places")
        try:
            found.append(one.copy(data=real_numbers(one.values) * factor + 0.0))
        except (TypeError, ValueError) as error:
            raise InputError(f"{name!r} of the places is not numeric ({error}). {HOW}.") from error

    # levels lead, rows and columns follow, as grids have them
    xr.align(*found, join="exact")
    order = list(dict.fromkeys(d for one in found[::-1] for d in one.dims))
    if set(order) >= set(HORIZON_DIMS):
        order = [d for d in order if d not in HORIZON_DIMS] + list(HORIZON_DIMS)
    shape = tuple(next(one.sizes[d] for one in found if d in one.dims) for d in order)
    coords = {
        name: (one.dims, one.values, _attrs(name)) for name, one in zip(NAMES, found, strict=True)
    }
    arrays = []
    for one in found:
        wide = one.expand_dims([d for d in order if d not in one.dims])
        arrays.append(wide.transpose(*order).values)
    x, y, z = arrays
    return Places(tuple(map(str, order)), shape, (x, y, z), coords)


def _attrs(name: str) -> dict[str, str]:
    return {"units": "m", "positive": "up"} if name == "elevation" else {"units": "m"}


def _check_finite(places: Places) -> None:
    """Refuse places with coordinates that are not finite, with the first of them."""
    # a sum is finite if all its terms are, unless it overflows: then the places are looked through
    with np.errstate(all="ignore"):
        if all(np.isfinite(one.sum()) for one in _all_of(places)):
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


def _all_of(places: Places) -> tuple[np.ndarray, ...]:
    """All coordinates, in as few arrays as there are."""
    return places.axes if places.rows is None else (places.rows,)
