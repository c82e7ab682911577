"""Grids of horizons, as arrays of xarray: checked, in metres, and read from a store in parts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np

from geosurf.conventions import HORIZON_DIMS, elevation_sign, first_given, metres_per_unit, place
from geosurf.conventions.crs import crs_of
from geosurf.conventions.machine import free_memory
from geosurf.errors import HorizonError, InputError
from geosurf.kernels.exact.predicates import MAX_COORDINATE
from geosurf.kernels.lattices.decimate import differences_of_rows_and_columns
from geosurf.model import Lattice, TriSurface
from geosurf.model.base import with_crs
from geosurf.triangulate.decimate import (
    Differences,
    Frame,
    bounded_differences,
    decimate_horizon,
    strides_of,
)
from geosurf.triangulate.mesh import map_turns

# ---- checks ----------------------------------------
# Refuse arrays that are no grid of a horizon: by shape, axes, values, and folded cells.


_Corner = tuple[slice, slice]


def check_array(da: Any, what: str) -> None:
    """Refuse what is not a two-dimensional array of numbers."""
    # of the class: to ask an array itself for its values would read them
    values = hasattr(type(da), "values") or hasattr(da, "values")
    if not (values and all(hasattr(da, key) for key in ("dims", "coords", "attrs"))):
        if isinstance(da, str | PathLike):
            raise HorizonError(
                f"{what}: found the path {str(da)!r}, expected the content of the file. Read "
                "it with geosurf.read_horizon(path)."
            )
        raise HorizonError(
            f"{what}: found {type(da).__name__}, expected an xarray.DataArray over {HORIZON_DIMS}. "
            "Make one with xr.DataArray(z, dims=('northing', 'easting'), coords={'northing': y, "
            "'easting': x}, attrs={'units': 'm', 'positive': 'up'}). Scene(..., tear=True) grids "
            "scattered points (n, 3), with and without faults."
        )

    # Scattered points and Datasets look like arrays, but need another step first.
    if not hasattr(da, "dtype") and tuple(getattr(da, "sizes", ())) == ("point",):
        raise HorizonError(
            f"{what}: found scattered points, expected a grid. Scene(..., tear=True) grids them, "
            "and tear_horizon(points, faults); without faults pass faults={}."
        )
    if not hasattr(da, "dtype"):
        raise HorizonError(
            f"{what}: found a {type(da).__name__} with variables {list(da)}, expected one "
            "array. Select it with ds['name']."
        )

    if da.dtype.kind not in "fiu":
        raise HorizonError(
            f"{what}: values have dtype {da.dtype}, expected numbers. "
            "Convert them with da.astype(float)."
        )
    if len(da.dims) != 2:
        raise HorizonError(
            f"{what}: dims are {tuple(da.dims)}, expected two: {HORIZON_DIMS}. "
            "Drop others with da.isel(...) or da.squeeze()."
        )

    if min(da.shape) < 2:
        raise HorizonError(
            f"{what}: the grid has {da.shape[0]} x {da.shape[1]} nodes, expected 2 x 2 or "
            "more. Read a larger part of the grid."
        )


def coordinates_of(da: Any, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Return easting and northing [m], both 1-D or both 2-D."""
    easting, northing = labels_of(da, what)
    return in_metres(easting, f"easting of {what}"), in_metres(northing, f"northing of {what}")


def labels_of(da: Any, what: str) -> tuple[Any, Any]:
    """Return the coordinates of a grid, both 1-D or both over its dimensions; they are not read."""
    # of xarray the arrays alone: labels cost more than what they label
    coords = getattr(da.coords, "variables", da.coords)
    missing = [key for key in ("easting", "northing") if key not in coords]
    flat = not missing and coords["easting"].ndim == coords["northing"].ndim == 2
    if not flat and tuple(da.dims) != HORIZON_DIMS:
        raise HorizonError(
            f"{what}: dims are {tuple(da.dims)}, expected {HORIZON_DIMS}. Rename them with "
            "da.rename(...), add coordinates called x and y or with a CF standard_name, or 2-D "
            "coordinates easting and northing if the grid is rotated."
        )
    if missing:
        raise HorizonError(
            f"{what}: coordinates {missing} are missing; the array has {list(da.coords)}. Add "
            f"them in metres with da.assign_coords({missing[0]}=...)."
        )

    easting, northing = (
        coords[key].transpose(*da.dims) if flat else coords[key] for key in ("easting", "northing")
    )
    return easting, northing


def in_metres(coord: Any, what: str, error: type[InputError] = HorizonError) -> np.ndarray:
    """Values of one coordinate in metres, not copied where they are."""
    if coord.dtype.kind not in "fiu":
        raise error(
            f"{what}: values have dtype {coord.dtype}, expected metres. Convert them to float."
        )

    length_unit = coord.attrs.get("units")
    try:
        factor = 1.0 if length_unit is None else metres_per_unit(length_unit, what)
    except InputError as reason:
        raise error(str(reason)) from reason
    values = np.asarray(coord.values, dtype=np.float64)
    return values if factor == 1.0 else values * factor


def check_axis(key: str, axis: np.ndarray, what: str) -> None:
    """Refuse a 1-D coordinate that is not finite, or neither increases nor decreases."""
    bad = np.flatnonzero(~np.isfinite(axis))
    if len(bad):
        raise HorizonError(
            f"{what}: {key}[{bad[0]}] is {axis[bad[0]]}. Coordinates of nodes must be finite; "
            f"drop the row or column with da.isel({key}=...)."
        )

    # Strictly increasing or strictly decreasing, by the direction of the ends.
    direction = 1.0 if axis[-1] >= axis[0] else -1.0
    bad = np.flatnonzero(direction * np.diff(axis) <= 0)
    if len(bad):
        i = int(bad[0])
        verb = "decreases" if direction > 0 else "increases"
        remedy = f"Sort it with da.sortby({key!r})."
        if axis[i + 1] == axis[i]:
            verb, remedy = "repeats", f"Keep one with da.drop_duplicates({key!r})."
        raise HorizonError(
            f"{what}: {key} {verb} at index {i + 1}: {axis[i]:g} is followed by "
            f"{axis[i + 1]:g}, expected values that only increase, or only decrease. {remedy}"
        )


def check_values(lattice: Lattice, what: str) -> None:
    """Refuse infinite nodes, nodes without a place, and grids without a single node."""
    if lattice.whole:
        return

    (x, y), elevation = lattice.horizontal(), lattice.elevation

    # NaN is absence; an infinite value is a mistake in the data
    infinite = np.isinf(elevation) | np.isinf(x) | np.isinf(y)
    if infinite.any():
        i, j = map(int, np.argwhere(infinite)[0])
        raise HorizonError(
            f"{what}: {int(infinite.sum())} nodes are infinite, the first is node ({i}, {j}) "
            f"at {place((x[i, j], y[i, j], elevation[i, j]))}. Set missing nodes to NaN: "
            "da.where(np.isfinite(da))."
        )

    present = np.isfinite(elevation)
    if not present.any():
        raise HorizonError(
            f"{what}: all {elevation.size} nodes are NaN. Check the no-data value of the file."
        )

    lost = present & ~(np.isfinite(x) & np.isfinite(y))
    if lost.any():
        i, j = map(int, np.argwhere(lost)[0])
        raise HorizonError(
            f"{what}: {int(lost.sum())} nodes have a value but no position, the first is node "
            f"({i}, {j}), easting {x[i, j]}, northing {y[i, j]}. Give the position, or set the "
            "value to NaN."
        )


def check_cells(lattice: Lattice, what: str) -> None:
    """Refuse a grid without triangles, and a curvilinear one that folds over itself."""
    if lattice.n_triangle == 0:
        n = lattice.present
        n_node = int(n.sum())
        raise HorizonError(
            f"{what}: no triangle has its three nodes: only {n_node} of {n.size} nodes are "
            "present, and they are scattered. Grid them first, or check the NaN mask."
        )
    # axes were found to rise strictly; only curvilinear grids can fold
    if (
        lattice.easting.ndim == 1
        or lattice.is_graph
        or _clearly_unfolded(lattice, _half_cells(lattice))
    ):
        return

    # floats could not decide: exact signs of all triangles
    corners = lattice.build_vertices()[lattice.build_triangles()]
    turns = map_turns(corners)
    bad = np.flatnonzero(turns <= 0)
    if len(bad):
        kind = "turned over" if turns[bad[0]] < 0 else "without area in the map"
        raise HorizonError(
            f"{what}: the grid is folded: {len(bad)} of {len(turns)} triangles are {kind}, the "
            f"first at {place(corners[bad[0]].mean(axis=0))}. Check the 2-D coordinates there, "
            "or set those nodes to NaN."
        )


def _half_cells(lattice: Lattice) -> tuple[tuple[_Corner, _Corner, _Corner], ...]:
    """Corners of the two triangles of all cells, as slices of the nodes."""
    low, high = slice(None, -1), slice(1, None)
    a, b, c, d = (low, low), (low, high), (high, high), (high, low)
    return ((a, b, c), (a, c, d)) if lattice.rising else ((a, b, d), (b, c, d))


def _clearly_unfolded(
    lattice: Lattice, halves: tuple[tuple[_Corner, _Corner, _Corner], ...]
) -> bool:
    """Whether floats alone show that all triangles turn one way; no triangle is built."""
    # Both halves of all cells at once: the cross product of two sides, with a bound on its
    # rounding.
    x, y, n = lattice.easting, lattice.northing, lattice.present
    sign = 1.0 if lattice.right_handed else -1.0
    for a, b, c in halves:
        plus = (x[b] - x[a]) * (y[c] - y[a])
        minus = (y[b] - y[a]) * (x[c] - x[a])
        clear = sign * (plus - minus) > 1e-12 * (np.abs(plus) + np.abs(minus))
        if not clear[n[a] & n[b] & n[c]].all():
            return False
    return True


def scale_of(da: Any, what: str, positive: str | None, length_unit: str | None) -> float:
    """Return what turns values of a grid into metres above the datum."""
    # Attributes of the array say what its numbers mean, unless arguments do.
    try:
        sign = elevation_sign(first_given(positive, da.attrs.get("positive")), what)
        return sign * metres_per_unit(first_given(length_unit, da.attrs.get("units")), what)
    except InputError as error:
        raise HorizonError(str(error)) from error


# ---- stores ----------------------------------------
# Grids in a store (Zarr, NetCDF): read into memory, or in bands of rows where they do not fit.
#
# With a tolerance, each band shows how far every k-th node is from all nodes in it: the horizon of
# every k-th node has the bytes that the whole grid in memory leads to.


ROOM = 16  # bytes of memory for each value of a grid: as it is read, and in metres
KEPT = 40  # bytes for each node that is kept: its elevation, and four bounds
BAND = 1 << 25  # nodes that are read at once
_BROKEN = (  # what libraries of stores raise for files that are damaged or gone
    OSError, EOFError, ValueError, TypeError, LookupError, RuntimeError, ImportError,
    ArithmeticError, AttributeError,
)  # fmt: skip
Sides = tuple[float, float, float, float]


def is_stored(da: Any) -> bool:
    """Return whether the values of an array are in a store: Dask, or a file that xarray opened."""
    # of the variable: `.data` reads files that were opened without Dask
    values = getattr(getattr(da, "variable", None), "_data", None)
    return hasattr(values, "dask") or type(values).__module__.startswith("xarray.")


def lack_of_memory(grids: Sequence[Any]) -> tuple[int, int] | None:
    """Return the bytes that some grids need and that are free; None if they fit."""
    needed = 0
    for da in grids:
        rotated = "easting" in da.coords and da.coords["easting"].ndim == 2
        needed += ROOM * int(da.size) * (3 if rotated else 1)
    free = free_memory()
    return None if free is None or needed <= free else (needed, free)


def refusal(grids: Mapping[str, Any], lack: tuple[int, int]) -> HorizonError:
    """Return the error for grids in a store that do not fit into memory, by name."""
    name, da = next(iter(grids.items()))
    needed, free = lack
    others = f" and {len(grids) - 1} more" if len(grids) > 1 else ""
    return HorizonError(
        f"horizon {name!r}{others}: a grid of {da.shape[0]} x {da.shape[1]} nodes in its store "
        f"does not fit into memory. {needed} bytes are needed, {free} are free. Give tolerance=1.0 "
        "to keep every k-th node within 1 m, or aoi= to read only the part that you need.",
        surfaces=list(grids),
    )


def read_stored(da: Any, name: str) -> Any:
    """
    Return a grid of a store in memory.

    Parameters
    ----------
    da : xarray.DataArray
        For which `is_stored` holds.
    name : str
        Of the horizon, for messages.

    Raises
    ------
    HorizonError
        If memory does not hold it, or the store cannot be read.
    """
    lack = lack_of_memory([da])
    if lack is not None:
        raise refusal({name: da}, lack)
    values = np.empty(da.shape, dtype=da.dtype)
    step = _rows_at_once(da)
    for first in range(0, da.shape[0], step):
        values[first : first + step] = _values_of(da, name, first, first + step)
    values.flags.writeable = False  # nobody else has it: scenes need no copy
    return da.copy(data=values)


def _rows_at_once(da: Any) -> int:
    """Rows of a band: some chunks, unless these are very high."""
    chunks = getattr(da.variable, "chunks", None)
    known = da.encoding.get("preferred_chunks") or {}
    high = max(chunks[0]) if chunks else int(known.get(da.dims[0], 1))
    most = max(BAND // da.shape[1], 1)
    return most if high > most else most // high * high


def _values_of(da: Any, name: str, first: int, last: int) -> np.ndarray:
    """Values of some rows (first, last + 1), or an error that names them."""
    try:
        return np.asarray(da[first:last].values)
    except _BROKEN as error:
        raise HorizonError(
            f"horizon {name!r}: rows {first} to {last - 1} cannot be read from the store "
            f"({type(error).__name__}: {error}). Check that its files are complete."
        ) from error


def cropped(da: Any, name: str, sides: Sides) -> Any:
    """
    Return the rows and columns of a grid that are in a window of the map, and one more around.

    Parameters
    ----------
    da : xarray.DataArray
        In a store; its coordinates are read, its values are not.
    name : str
    sides : (west, east, south, north)
        [m].

    Raises
    ------
    HorizonError
        If no node is in the window.
    """
    what = f"horizon {name!r}"
    west, east, south, north = sides
    flat = labels_of(da, what)[0].ndim == 1
    rows, cols = (np.zeros(n, dtype=bool) for n in da.shape)
    step = da.shape[0] if flat else _rows_at_once(da)
    for first in range(0, da.shape[0], step):
        x, y = coordinates_of(da if flat else da[first : first + step], what)
        x, y = (x[None], y[:, None]) if flat else (x, y)
        inside = (x >= west) & (x <= east) & (y >= south) & (y <= north)
        rows[first : first + step] = inside.any(axis=1)
        cols |= inside.any(axis=0)
    if not rows.any():
        raise HorizonError(f"{what}: no node of its grid is in the area. Check aoi= and box=.")
    spans = [
        slice(max(int(some[0]) - 1, 0), int(some[-1]) + 2)
        for some in (np.flatnonzero(rows), np.flatnonzero(cols))
    ]
    return da[spans[0], spans[1]]


@dataclass(frozen=True, eq=False)
class StoredGrid:
    """
    A grid with axes in a store.

    Attributes
    ----------
    name : str
    data : xarray.DataArray
        Over northing and easting, which rise; its values are read when needed.
    easting, northing : ndarray of float64
        [m].
    scale : float
        From values to metres above the datum.
    """

    name: str
    data: Any
    easting: np.ndarray
    northing: np.ndarray
    scale: float

    @classmethod
    def of(cls, da: Any, name: str, scale: float) -> StoredGrid:
        """Make one of an array in a store.

        Raises
        ------
        HorizonError
            If its axes do not rise or fall, or the grid is rotated.
        """
        what = f"horizon {name!r}"
        check_array(da, what)
        if labels_of(da, what)[0].ndim == 2:
            raise HorizonError(
                f"{what}: its grid has two-dimensional easting and northing and does not fit into "
                "memory. A tolerance needs axes there. Give aoi= to read a part."
            )
        axes = dict(zip(("easting", "northing"), coordinates_of(da, what), strict=True))
        for key, axis in axes.items():
            check_axis(key, axis, what)
            if axis[0] > axis[-1]:
                da, axes[key] = da.isel({key: slice(None, None, -1)}), axis[::-1].copy()
        return cls(name, da, axes["easting"], axes["northing"], scale)

    def has_axes_of(self, other: StoredGrid) -> bool:
        """Whether two grids have the same nodes in the map."""
        both = (self.easting, other.easting), (self.northing, other.northing)
        return all(np.array_equal(one, two) for one, two in both)

    @cached_property
    def frame(self) -> Lattice:
        """The lattice with elevations that take no memory."""
        shape = len(self.northing), len(self.easting)
        return Lattice(self.easting, self.northing, np.broadcast_to(np.float64(0.0), shape))

    def read(self, first: int, last: int) -> np.ndarray:
        """Elevations [m] of some rows (first, last + 1), which all exist."""
        values = _values_of(self.data, self.name, first, last)
        if self.scale != 1.0:
            values = np.multiply(values, self.scale, dtype=np.float64)
        z: np.ndarray = np.add(values, 0.0, dtype=np.float64)  # no -0.0, as for grids in memory
        bad = np.argwhere(~(np.abs(z) <= MAX_COORDINATE))
        if len(bad):
            row, col = int(bad[0, 0]), int(bad[0, 1])
            where = place((self.easting[col], self.northing[first + row]))
            raise HorizonError(
                f"horizon {self.name!r}: the elevation at {where} is {z[row, col]:g}. A tolerance "
                "needs all nodes of a grid that does not fit into memory. Give aoi= to read a part."
            )
        return z

    def bands(self, rows: np.ndarray) -> Iterator[tuple[int, int, np.ndarray]]:
        """Yield blocks between rows that are kept: the first, the last + 1, and all nodes there."""
        step, done = _rows_at_once(self.data), 0
        while done < len(rows) - 1:
            end = int(np.searchsorted(rows, rows[done] + step, side="right")) - 1
            end = min(max(end, done + 1), len(rows) - 1)
            yield done, end, self.read(int(rows[done]), int(rows[end]) + 1)
            done = end


def decimate_stored(grids: Sequence[StoredGrid], tolerance: float) -> list[TriSurface]:
    """
    Return horizons with as few nodes as a tolerance allows; the largest step is tried first.

    Parameters
    ----------
    grids : sequence of StoredGrid
        With the same nodes in the map.
    tolerance : float
        [m].

    Returns
    -------
    list of TriSurface
        As `decimate_horizon` makes them, all with the same rows and columns.

    Raises
    ------
    HorizonError
        If no step is within the tolerance, or memory does not hold what it leaves.
    """
    frame, free = grids[0].frame, free_memory()
    order = list(range(len(grids)))
    for stride in strides_of(frame.shape):
        if free is not None and KEPT * frame.n_node * len(grids) > free * stride**2:
            break
        nodes = Frame.of(frame, stride)
        differences: dict[int, Differences] = {}
        for k in order:
            difference = _differences(grids[k], nodes, tolerance)
            if difference is None:  # what failed with fewer nodes is asked first
                order = [k, *(other for other in order if other != k)]
                break
            differences[k] = difference
        else:
            return [_decimated(grid, nodes, differences[k]) for k, grid in enumerate(grids)]
    names = ", ".join(repr(grid.name) for grid in grids)
    raise HorizonError(
        f"horizon {names}: no grid of every k-th node that fits into memory is within "
        f"{tolerance:g} m of all nodes. Give a larger tolerance, or aoi= to read a part.",
        surfaces=[grid.name for grid in grids],
    )


def _decimated(grid: StoredGrid, nodes: Frame, differences: Differences) -> TriSurface:
    """The horizon of some rows and columns."""
    whole = TriSurface(grid.name, "horizon", lattice=grid.frame)
    return decimate_horizon(with_crs(whole, crs_of(grid.data)), nodes, differences)


def _differences(grid: StoredGrid, nodes: Frame, limit: float) -> Differences | None:
    """How far some rows and columns are from all nodes; None if that exceeds a limit [m]."""
    rows, cols = nodes.rows, nodes.cols
    few = np.empty((len(rows), len(cols)))
    cells = tuple(np.empty((len(rows) - 1, len(cols) - 1)) for _ in range(3))
    size = 0.0
    for done, end, z in grid.bands(rows):
        order = np.arange(end - done)
        heights, *parts, failed = differences_of_rows_and_columns(
            z, rows[done : end + 1] - rows[done], cols, order, limit
        )
        if failed >= 0:
            return None
        few[done : end + 1] = heights
        for cell, part in zip(cells, parts, strict=True):
            cell[done:end] = part
        size = max(size, float(np.abs(z).max()))
    found = bounded_differences(few, cells, nodes, nodes.cols, nodes.wide, size, limit)
    return found if isinstance(found, Differences) else None
