"""Refuse arrays without a grid of a horizon: by shape, axes, values, and folded cells."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from geosurf.conventions import HORIZON_DIMS, metres_per_unit, place
from geosurf.errors import HorizonError, InputError
from geosurf.model import Lattice
from geosurf.triangulate.degenerate import map_turns

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
            "'easting': x}, attrs={'units': 'm', 'positive': 'up'})."
        )

    # Scattered points and Datasets look like arrays, but need another step first.
    if not hasattr(da, "dtype") and tuple(getattr(da, "sizes", ())) == ("point",):
        raise HorizonError(
            f"{what}: found scattered points, expected a grid. Make a horizon with "
            "tear_horizon(points, faults); without faults pass faults={}."
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
    return _metres(easting, f"easting of {what}"), _metres(northing, f"northing of {what}")


def labels_of(da: Any, what: str) -> tuple[Any, Any]:
    """Return the coordinates of a grid, both 1-D or both over its dimensions; they are not read."""
    # of xarray the arrays alone: labels cost more than what they label
    coords = getattr(da.coords, "variables", da.coords)
    missing = [key for key in ("easting", "northing") if key not in coords]
    flat = not missing and coords["easting"].ndim == coords["northing"].ndim == 2
    if not flat and tuple(da.dims) != HORIZON_DIMS:
        if set(da.dims) == set(HORIZON_DIMS):
            remedy = "Only the order differs: da.transpose('northing', 'easting')."
        else:
            remedy = (
                "Rename them with da.rename(...), or add 2-D coordinates easting and northing "
                "if the grid is rotated."
            )
        raise HorizonError(f"{what}: dims are {tuple(da.dims)}, expected {HORIZON_DIMS}. {remedy}")
    if missing:
        raise HorizonError(
            f"{what}: coordinates {missing} are missing; the array has {list(da.coords)}. Add "
            f"them in metres with da.assign_coords({missing[0]}=...)."
        )

    easting, northing = (
        coords[key].transpose(*da.dims) if flat else coords[key] for key in ("easting", "northing")
    )
    return easting, northing


def _metres(coord: Any, what: str) -> np.ndarray:
    """Values of one coordinate in metres."""
    if coord.dtype.kind not in "fiu":
        raise HorizonError(
            f"{what}: values have dtype {coord.dtype}, expected metres. Convert them to float."
        )

    length_unit = coord.attrs.get("units")
    try:
        factor = 1.0 if length_unit is None else metres_per_unit(length_unit, what)
    except InputError as error:
        raise HorizonError(str(error)) from error
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
    way = 1.0 if axis[-1] >= axis[0] else -1.0
    bad = np.flatnonzero(way * np.diff(axis) <= 0)
    if len(bad):
        i = int(bad[0])
        verb = "decreases" if way > 0 else "increases"
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
