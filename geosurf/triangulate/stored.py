"""Grids in a store (Zarr, NetCDF): read into memory, or in bands of rows where they do not fit.

With a tolerance, each band shows how far every k-th node is from all nodes in it: the horizon of
every k-th node has the bytes that the whole grid in memory leads to.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.conventions import place, volume_text
from geosurf.conventions.crs import crs_of
from geosurf.conventions.machine import free_memory
from geosurf.errors import HorizonError, SurfaceError
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
from geosurf.triangulate.mesh import (
    check_array,
    check_axis,
    coordinates_of,
    labels_of,
    sheets_that_agree,
)
from geosurf.warning import warn_of

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
        found: dict[int, Differences] = {}
        for k in order:
            one = _differences(grids[k], nodes, tolerance)
            if one is None:  # what failed with fewer nodes is asked first
                order = [k, *(other for other in order if other != k)]
                break
            found[k] = one
        else:
            return [_decimated(one, nodes, found[k]) for k, one in enumerate(grids)]
    names = ", ".join(repr(one.name) for one in grids)
    raise HorizonError(
        f"horizon {names}: no grid of every k-th node that fits into memory is within "
        f"{tolerance:g} m of all nodes. Give a larger tolerance, or aoi= to read a part.",
        surfaces=[one.name for one in grids],
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
        some, *parts, failed = differences_of_rows_and_columns(
            z, rows[done : end + 1] - rows[done], cols, order, limit
        )
        if failed >= 0:
            return None
        few[done : end + 1] = some
        for cell, part in zip(cells, parts, strict=True):
            cell[done:end] = part
        size = max(size, float(np.abs(z).max()))
    found = bounded_differences(few, cells, nodes, nodes.cols, nodes.wide, size, limit)
    return found if isinstance(found, Differences) else None


# ---- horizon mesh ----------------------------------------
# Triangulated horizons: whether "above" and "below" mean something.
#
# A closed body (salt, a lens) has an inside and an outside instead: it is refused. A sheet that
# folds over itself (a recumbent fold, a flank of salt) has both sides, but what lies on its upper
# side is not everywhere above it: that is allowed, and a warning names the share.


def check_horizon_mesh(surface: TriSurface) -> None:
    """
    Refuse a horizon that is, or has in it, a closed body; warn of one that folds over itself.

    Parameters
    ----------
    surface : TriSurface
        A gridded one passes: it cannot fold.

    Raises
    ------
    SurfaceError
        For a closed body, with its volume and place; for a sheet with only one side.

    Examples
    --------
    >>> corners = [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]]
    >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    >>> check_horizon_mesh(TriSurface("Salt", "horizon", corners, faces))
    Traceback (most recent call last):
    geosurf.errors.SurfaceError: horizon 'Salt' is a closed body of 122 m³ around \
(E 2.25, N 2.25, elevation 2.25 m), so nothing is above or below it. Pass it as a \
fault, faults={'Salt': ...}; its inside becomes a block.
    """
    if surface.lattice is not None or surface.n_triangle == 0:
        return

    # Relative to a corner, so that products of large coordinates do not lose digits.
    low = surface.vertices.min(axis=0)
    corners = (surface.vertices - low)[surface.triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])  # in the map, with its sign
    if (area >= 0).all() or (area <= 0).all():
        return  # a closed body, or a fold, has triangles of both kinds

    turned, sheet, neighbour = sheets_that_agree(surface)
    sign = np.where(turned, -1.0, 1.0)
    n_sheet = int(sheet.max()) + 1

    # A sheet without a rim is closed.
    rims = np.bincount(sheet, (neighbour < 0).any(axis=1), n_sheet)
    for k in np.flatnonzero(rims == 0):
        mine = sheet == k
        # Signed volume by the divergence theorem: tetrahedra with the origin.
        volume = np.linalg.det(corners[mine]) / 6.0
        take = "" if n_sheet == 1 else "Remove it from the horizon. "
        at = place(corners[mine].reshape(-1, 3)[_distinct(surface, mine)].mean(axis=0) + low)
        raise SurfaceError(
            f"horizon {surface.name!r} {'is' if n_sheet == 1 else 'holds'} a closed body of "
            f"{volume_text(abs(float((sign[mine] * volume).sum())))} around {at}, so nothing "
            f"is above or below it. {take}Pass it as a fault, faults={{{surface.name!r}: "
            "...}; its inside becomes a block."
        )
    _warn_of_folds(surface, area * sign, sheet, corners + low)


def _distinct(surface: TriSurface, mine: np.ndarray) -> np.ndarray:
    """One corner, of those of some triangles, for each of their vertices."""
    return np.unique(surface.triangles[mine].ravel(), return_index=True)[1]


def _warn_of_folds(
    surface: TriSurface, area: np.ndarray, sheet: np.ndarray, corners: np.ndarray
) -> None:
    """Warn of the parts of each sheet that look the other way than most of it."""
    # Each sheet faces the way that most of its area does; the rest folds over.
    up = np.bincount(sheet, area) >= 0
    area = np.where(up[sheet], area, -area)
    over = area < 0
    if not over.any():
        return

    share = float(-area[over].sum() / np.abs(area).sum())
    largest = int(np.argmin(area))
    warn_of(
        "fold",
        surface.name,
        f"Horizon {surface.name!r} folds over itself on {100 * share:.2g} % of its map "
        "area. There, the zone above the horizon lies below it.",
        "If it should not fold, simplify it there, or convert it to a grid.",
        corners[largest].mean(axis=0),
    )
