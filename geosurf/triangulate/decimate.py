"""A horizon of every k-th node, with a proven bound of what that changes.

What is measured, to rounding, is the difference of both surfaces over rows and columns
(`geosurf.kernels.lattices.decimate`). Axes with even steps have the same difference over the map.
Where a node is not where even steps put it, by up to a part ``e`` of a coarse cell, the coarse
surface is read at a place that is off by at most this. It is linear along rows and columns of a
cell, so it is off by at most ``e`` times its largest step. That is added to the difference.

The integral of the difference over a coarse cell is exact on even steps. Cells of the grid whose
areas differ from even ones by a part ``s`` change it by at most ``s`` times the largest difference.

A rotated grid with even steps is the affine image of such a lattice, and affine maps keep what is
linear. Its nodes and the corners of coarse cells may both be off by rounding.

`decimate_frame` chooses the nodes, `bound_of_change` states how far volumes of units may be off.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.kernels.lattices.decimate import (
    bounds_of_cells,
    differences_of_rows_and_columns,
    near_cells,
)
from geosurf.model import Lattice, TriSurface
from geosurf.model.base import in_crs_of

STRIDES = (20, 10, 8, 5, 4, 3, 2)
LEAST_NODES = 10_000  # that stay
LEAST_COARSE = 2_500  # beyond every 10th node: a tenth of a model of a million nodes
_ROUNDING = 128 * 2.0**-52  # of a difference between both surfaces, in elevations
_NEARLY_EVEN = 1e-3  # of a cell: the bound for rotated grids is proven up to here
_PER_NODE = 8 * 2.0**-52  # of a sum over nodes, for each of them, in elevations
IN_VERTEX_DATA = "vertical_error", "volume_error", "volume_change", "volume_doubt"
_GOLDEN = 0.6180339887498949  # multiples of it, without whole parts, are spread evenly


@dataclass(frozen=True)
class Differences:
    """How far a lattice of some rows and columns is from all nodes.

    Attributes
    ----------
    elevation : ndarray of float64, shape (n_row, n_col)
        Of the nodes that are kept [m].
    largest : ndarray of float64, shape (n_row - 1, n_col - 1)
        Largest vertical difference in each coarse cell, or more [m].
    volume : ndarray of float64, shape (n_row - 1, n_col - 1)
        Volume between both surfaces in each coarse cell, or more [m3].
    change : ndarray of float64, shape (n_row - 1, n_col - 1)
        By how much more volume is below all nodes, in each coarse cell [m3].
    doubt : ndarray of float64, shape (n_row - 1, n_col - 1)
        By how much `change` may be wrong: uneven steps and rounding [m3].
    """

    elevation: np.ndarray
    largest: np.ndarray
    volume: np.ndarray
    change: np.ndarray
    doubt: np.ndarray


@dataclass(frozen=True, eq=False)
class Frame:
    """Rows and columns that are kept, and what horizons that have the same nodes share.

    Attributes
    ----------
    rows, cols : ndarray of int64
        With both ends.
    high, wide : ndarray of float64
        Sides of coarse cells along columns (n_row - 1,) and along rows (n_col - 1,) [m].
        Of rotated grids the second ones are areas of a row of cells [m2], the first ones numbers.
    uneven : (float, float)
        How far rows and columns are from even steps, as a part of a coarse cell; inf where 2-D
        coordinates have no even steps.
    stretch : float
        By how much cells of the grid are larger or smaller than the mean of their coarse cell.
    """

    rows: np.ndarray
    cols: np.ndarray
    high: np.ndarray
    wide: np.ndarray
    uneven: tuple[float, float]
    stretch: float

    @classmethod
    def of(cls, lattice: Lattice, stride: int) -> Frame:
        """Every k-th row and column of a lattice, with both ends."""
        rows, cols = (kept_nodes(n, stride) for n in lattice.shape)
        return cls.of_nodes(lattice, rows, cols)

    @classmethod
    def of_nodes(cls, lattice: Lattice, rows: np.ndarray, cols: np.ndarray) -> Frame:
        """Some rows and columns of a lattice, with both ends."""
        if lattice.easting.ndim == 2:
            return cls(rows, cols, *_rotated_cells(lattice, rows, cols))
        along_rows, stretch_of_rows = _unevenness(lattice.northing, rows)
        along_cols, stretch_of_cols = _unevenness(lattice.easting, cols)
        sides = np.diff(lattice.northing[rows]), np.diff(lattice.easting[cols])
        stretch = (1.0 + stretch_of_rows) * (1.0 + stretch_of_cols) - 1.0
        return cls(rows, cols, *sides, (along_rows, along_cols), stretch)


def can_be_decimated(surface: TriSurface) -> bool:
    """Whether nodes can be left out of a horizon: a whole grid, and all of its nodes."""
    lattice = surface.lattice
    return (
        lattice is not None
        and _is_even(lattice)
        and lattice.whole
        and not surface.sectors
        and surface.torn is None
        and "vertical_error" not in surface.vertex_data
    )


def _is_even(lattice: Lattice) -> bool:
    """Whether a lattice has axes that rise, or is rotated."""
    return lattice.easting.ndim == 2 or (lattice.has_rising_axes and lattice.rising)


def strides_of(shape: tuple[int, int]) -> list[int]:
    """Return every how many nodes of a grid may be kept, the largest first.

    Examples
    --------
    >>> strides_of((1001, 1001)), strides_of((300, 301)), strides_of((150, 150))
    ([20, 10, 8, 5, 4, 3, 2], [3, 2], [])
    """
    return [k for k in STRIDES if shape[0] * shape[1] >= least_nodes(k)]


def least_nodes(stride: int) -> int:
    """Return from how many nodes of a grid on every k-th of them is enough.

    Examples
    --------
    >>> least_nodes(2), least_nodes(20)
    (40000, 1000000)
    """
    return (LEAST_COARSE if stride > 10 else LEAST_NODES) * stride**2


def kept_nodes(n: int, stride: int) -> np.ndarray:
    """Return every k-th of n rows or columns, with both ends; steps are k or less, and even.

    Examples
    --------
    >>> kept_nodes(11, 5).tolist(), kept_nodes(12, 5).tolist()
    ([0, 5, 10], [0, 3, 7, 11])
    """
    n_step = -(-(n - 1) // stride)
    return np.arange(n_step + 1) * (n - 1) // n_step


def measure_differences(
    lattice: Lattice, frame: Frame, limit: float, first: float = 0.5
) -> Differences | float:
    """
    Return how far the lattice of some rows and columns is from all nodes.

    Parameters
    ----------
    lattice : Lattice
        Whole, with axes that rise.
    frame : Frame
        Of this lattice, or of another one with the same nodes in the map.
    limit : float
        [m]. What is farther off ends the search.
    first : float
        Where it begins, from 0 (south) to below 1 (north).

    Returns
    -------
    Differences or float
        If the limit is exceeded: where, from 0 (south) to below 1 (north).

    Examples
    --------
    >>> axis = np.arange(5.0)
    >>> bowl = Lattice(axis, axis, axis[:, None] ** 2 + axis**2)
    >>> every_other = Frame.of(bowl, 2)
    >>> differences = measure_differences(bowl, every_other, limit=10.0)
    >>> differences.largest.round(9).tolist(), differences.change.round(9).tolist()
    ([[2.0, 2.0], [2.0, 2.0]], [[-4.0, -4.0], [-4.0, -4.0]])
    >>> measure_differences(bowl, every_other, limit=1.0)
    0.75
    """
    z, rows, cols, wide = lattice.elevation, frame.rows, frame.cols, frame.wide
    if not lattice.rising:  # diagonals that fall rise where columns run the other way
        z, cols, wide = z[:, ::-1].copy(), lattice.shape[1] - 1 - cols[::-1], wide[::-1].copy()

    # rows of cells far apart one after the other: what is rough somewhere shows soon
    n_row = len(rows) - 1
    order = np.argsort(np.arange(n_row) * _GOLDEN % 1.0, kind="stable")
    order = np.roll(order, -int(np.flatnonzero(order == int(first * n_row))[0]))
    kept, *cells, failed = differences_of_rows_and_columns(z, rows, cols, order, limit)
    if failed >= 0:
        return (failed + 0.5) / n_row
    size = max(abs(float(lattice.survey.box[2])), abs(float(lattice.survey.box[5])))
    differences = bounded_differences(kept, cells, frame, cols, wide, size, limit)
    if lattice.rising or not isinstance(differences, Differences):
        return differences
    parts = (getattr(differences, part.name) for part in fields(Differences))
    return Differences(*(part[:, ::-1].copy() for part in parts))


def bounded_differences(
    kept: np.ndarray,
    cells: Sequence[np.ndarray],
    frame: Frame,
    cols: np.ndarray,
    wide: np.ndarray,
    size: float,
    limit: float,
) -> Differences | float:
    """
    Return what `measure_differences` does, from the results of its first kernel.

    Parameters
    ----------
    kept : ndarray of float64, shape (n_row, n_col)
        Elevations of the nodes that are kept [m].
    cells : three ndarray of float64, shape (n_row - 1, n_col - 1)
        How far all nodes are above and below these, at most, and the integral of the difference.
    frame : Frame
    cols, wide : ndarray
        As `frame` has them, or from the other end.
    size : float
        Largest elevation of all nodes, or depth [m].
    limit : float
        [m].
    """
    *bounds, largest, worst_row = bounds_of_cells(
        kept, *cells, frame.rows, cols, frame.high, wide, *frame.uneven,
        frame.stretch, size, _ROUNDING, _PER_NODE,
    )  # fmt: skip
    if largest > limit:
        return (worst_row + 0.5) / len(cells[0])
    return Differences(kept, *bounds)


def _unevenness(axis: np.ndarray, kept: np.ndarray) -> tuple[float, float]:
    """How far nodes are from even steps between those that are kept, as a part of a coarse cell;
    and by which part steps differ from even ones.
    """
    n, step = np.diff(kept), np.diff(axis[kept])
    even = np.interp(np.arange(len(axis)), kept, axis[kept])
    cell, mean = np.repeat(step, n), np.repeat(step / n, n)
    rounding = 8 * 2.0**-52 * float(np.abs(axis[[0, -1]]).max())
    off = float((np.abs(axis - even)[:-1] / cell).max()) + rounding / float(cell.min())
    stretch = float(np.abs(np.diff(axis) / mean - 1.0).max()) + rounding / float(mean.min())
    return off, stretch


def _rotated_cells(
    lattice: Lattice, rows: np.ndarray, cols: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[float, float], float]:
    """Sides, unevenness and stretch of a frame of 2-D coordinates: of its cells as if even."""
    x, y = lattice.easting, lattice.northing
    n_row, n_col = lattice.shape
    over = [float(q[0, -1] - q[0, 0]) / (n_col - 1) for q in (x, y)]
    up = [float(q[-1, 0] - q[0, 0]) / (n_row - 1) for q in (x, y)]
    area = abs(over[0] * up[1] - over[1] * up[0])
    sides = np.diff(rows) * 1.0, np.diff(cols) * area
    size = float(np.abs(lattice.survey.box[[0, 1, 3, 4]]).max())
    off_x, off_y = (
        float(np.abs(q - _even_steps(q, rise, step)).max()) + 8 * 2.0**-52 * size
        for q, step, rise in zip((x, y), over, up, strict=True)
    )

    # off as parts of a cell of the grid, along rows and along columns
    across, along = (off_x * abs(v[1]) + off_y * abs(v[0]) for v in (over, up))
    if not max(across, along) <= _NEARLY_EVEN * area:
        return *sides, (np.inf, np.inf), 0.0
    across, along = across / area, along / area

    # twice: nodes and the corners of coarse cells; a little more: cells are not quite even, either
    uneven = 2.1 * across / int(np.diff(rows).min()), 2.1 * along / int(np.diff(cols).min())
    return *sides, uneven, 2.1 * ((1.0 + 4.0 * max(across, along)) ** 2 - 1.0)


def _even_steps(coordinate: np.ndarray, rise: float, step: float) -> np.ndarray:
    """Coordinates (n_row, n_col) from the first node on, with even steps over rows and columns."""
    n_row, n_col = coordinate.shape
    first_column = coordinate[0, 0] + np.arange(n_row) * rise
    return first_column[:, None] + np.arange(n_col) * step


def decimate_horizon(surface: TriSurface, frame: Frame, differences: Differences) -> TriSurface:
    """
    Return a horizon of some rows and columns of its lattice.

    Parameters
    ----------
    surface : TriSurface
        For which `can_be_decimated` holds.
    frame : Frame
        Which rows and columns are kept.
    differences : Differences
        For these.

    Returns
    -------
    TriSurface
        With its lattice. ``vertex_data["vertical_error"]`` [m] is the largest difference from all
        nodes in the cells around each node. ``["volume_error"]``, ``["volume_change"]`` and
        ``["volume_doubt"]`` [m3] have at each node what `Differences` states of the cell north-east
        of it: the volume between both surfaces, that with its sign, and how unsure the latter is.
    """
    rows, cols = frame.rows, frame.cols
    whole = surface.lattice
    assert whole is not None
    if whole.easting.ndim == 1:
        axes = whole.easting[cols], whole.northing[rows]
    else:
        axes = whole.easting[np.ix_(rows, cols)], whole.northing[np.ix_(rows, cols)]
    lattice = Lattice(*axes, differences.elevation, whole.rising, whole.reverse)

    kept = (rows[:, None] * whole.shape[1] + cols).ravel()
    data = {key: values[kept] for key, values in surface.vertex_data.items()}

    # the largest value of the cells around each node, and the sums of the cell north-east of it
    padded = np.pad(differences.largest, 1)
    around = [padded[i : i + len(rows), j : j + len(cols)] for i, j in np.ndindex(2, 2)]
    sums = differences.volume, differences.change, differences.doubt
    of_nodes = [np.maximum.reduce(around), *(np.pad(cells, (0, 1)) for cells in sums)]
    data.update(zip(IN_VERTEX_DATA, map(np.ravel, of_nodes), strict=True))
    decimated = TriSurface(surface.name, surface.role, lattice=lattice, vertex_data=data)
    return in_crs_of(decimated, [surface])


def decimate_frame(frame: Sequence[TriSurface], tolerance: float) -> list[TriSurface]:
    """
    Return horizons with as few nodes as a tolerance allows; none if they need all.

    Parameters
    ----------
    frame : sequence of TriSurface
        For which `can_be_decimated` holds, with the same nodes in the map, in memory.
    tolerance : float
        [m].

    Returns
    -------
    list of TriSurface
        As `decimate_horizon` makes them, all with the same rows and columns.
    """
    lattices = [horizon.lattice for horizon in frame if horizon.lattice is not None]
    worst, place = 0, 0.5
    for stride in strides_of(lattices[0].shape):
        nodes = Frame.of(lattices[0], stride)
        if nodes.uneven[0] == float("inf"):
            break  # 2-D coordinates without even steps
        measured = _measure_all(lattices, nodes, tolerance, worst, place)
        if isinstance(measured, list):
            return [
                decimate_horizon(horizon, nodes, differences)
                for horizon, differences in zip(frame, measured, strict=True)
            ]
        worst, place = measured
    return []


def _measure_all(
    lattices: list[Lattice], nodes: Frame, tolerance: float, worst: int, place: float
) -> list[Differences] | tuple[int, float]:
    """Differences of all lattices; or the row of one that is farther off than the tolerance, and
    where it is.

    The lattice that failed with fewer nodes comes first, from the place where it failed: with
    these nodes it mostly fails again.
    """
    others = [k for k in range(len(lattices)) if k != worst]

    def measure(k: int) -> Differences | float:
        return measure_differences(lattices[k], nodes, tolerance, place)

    measured = {worst: measure(worst)}
    if isinstance(measured[worst], Differences):
        results = map_threads(measure, [(k,) for k in others])
        measured.update(zip(others, results, strict=True))
    within = []
    for k, result in sorted(measured.items()):
        if not isinstance(result, Differences):
            return k, result
        within.append(result)
    return within


# ---- volume change ----------------------------------------
# How much fewer nodes of a horizon change volumes: with signs, where nothing else comes near.
#
# Between a horizon of fewer nodes and all its nodes lies a thin body. Where no other surface
# meets it, one unit is above it and one below, all over a part whose cells are joined by their
# sides. There what is above and what is below cancels: such a part moves the difference of both
# volumes from the one unit to the other, whichever these are. In cells that another surface comes
# near, or a wall of the box, any of the body may go to any unit, so all of it counts.
#
# Several horizons change one after the other. Each is near another one if their bodies are: these
# hold both the surfaces with fewer nodes and those with all.


_NO_PLANES = np.empty((0, 4))
_UP_AND_DOWN = np.array([0, 0, -1, 0, 0, 1])  # of the corners of a box


def bound_of_change(
    surface: TriSurface, others: Iterable[TriSurface], sides: tuple[float, float, float, float]
) -> float:
    """
    Return by how much the volume of any units may differ from that with all nodes of a horizon.

    Parameters
    ----------
    surface : TriSurface
        Of `geosurf.triangulate.decimate`.
    others : iterable of TriSurface
        All that bounds units besides: horizons, faults, fluid contacts, walls of the model.
    sides : (west, east, south, north)
        Of the model [m].

    Returns
    -------
    float
        [m3].

    Examples
    --------
    Waves go up as far as they go down, so volumes change by little:

    >>> import geosurf as gs
    >>> top = gs.triangulate_horizon(gs.synthetic.waves(n=601).horizons["Top"], name="Top")
    >>> from geosurf.triangulate.decimate import Frame, decimate_horizon, measure_differences
    >>> nodes = Frame.of(top.lattice, 5)
    >>> few = decimate_horizon(top, nodes, measure_differences(top.lattice, nodes, 1.0))
    >>> sides = few.bounds[:4]
    >>> bool(bound_of_change(few, [], sides) < 0.2 * few.vertex_data["volume_error"].sum())
    True
    """
    lattice = surface.lattice
    if lattice is None or not _has_signs(surface):
        return float(surface.vertex_data["volume_error"].sum())
    largest, *sums = (surface.vertex_data[key] for key in IN_VERTEX_DATA)
    between, change, doubt = (cells.reshape(lattice.shape)[:-1, :-1] for cells in sums)

    (west, east), (south, north) = map(_extremes, lattice.horizontal())
    inside = (east >= sides[0]) & (west <= sides[1]) & (north >= sides[2]) & (south <= sides[3])
    alone = inside & ~_cells_near(lattice, _body(lattice, largest), others)

    from scipy.ndimage import label  # not every model is asked for its bound

    part, n_part = label(alone)
    moved = np.bincount(part[alone], change[alone], n_part + 1)
    return float(np.abs(moved).sum() + doubt[alone].sum() + between[inside & ~alone].sum())


def _has_signs(surface: TriSurface) -> bool:
    """Whether a surface is a lattice of fewer nodes, whose cells have changes with signs."""
    lattice = surface.lattice
    return (
        lattice is not None
        and all(key in surface.vertex_data for key in IN_VERTEX_DATA)
        and surface.torn is None
        and not surface.sectors
    )


def _extremes(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest value at the four corners of each cell."""
    corners = values[:-1, :-1], values[:-1, 1:], values[1:, :-1], values[1:, 1:]
    return np.minimum.reduce(corners), np.maximum.reduce(corners)


def _body(lattice: Lattice, largest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest elevation of a lattice with fewer nodes, and of all nodes, in each cell.

    `largest` has at each node the largest difference of the cells around it.
    """
    low, high = _extremes(lattice.elevation)
    # of the four nodes of a cell, each of which has its largest difference or more
    reach, _ = _extremes(largest.reshape(lattice.shape))
    return low - reach, high + reach


def _cells_near(
    lattice: Lattice, body: tuple[np.ndarray, np.ndarray], others: Iterable[TriSurface]
) -> np.ndarray:
    """Which cells of a lattice are near another surface: boxes meet, and planes do not part them.

    Coordinates are relative to the first node, so that rounding stays below that of the search.
    """
    low, high = body
    x, y = lattice.horizontal()
    corner = np.array([x[0, 0], y[0, 0], 0.0])
    (west, east), (south, north) = _extremes(x - corner[0]), _extremes(y - corner[1])
    boxes = np.stack([west, south, low, east, north, high], axis=-1).reshape(-1, 6)

    near = np.zeros(low.shape, dtype=bool)
    for other in others:
        if other.lattice is not None and _has_signs(other) and lattice.shares_map(other.lattice):
            below, above = _body(other.lattice, other.vertex_data[IN_VERTEX_DATA[0]])
            near |= (low <= above) & (below <= high)
            continue
        other_boxes, planes = _boxes_and_planes(other, corner)
        near |= near_cells(boxes, *low.shape, other_boxes, planes)
    return near


def _boxes_and_planes(surface: TriSurface, corner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (n, 6) around the parts of a surface, and the planes (n, 4) of its triangles, if any.

    Boxes of a lattice of fewer nodes hold all its nodes.
    """
    lattice, shift = surface.lattice, np.tile(corner, 2)
    if lattice is not None and surface.torn is None and not surface.sectors:
        survey = lattice.survey
        leaves = survey.nodes[: int(survey.levels[0, 1] * survey.levels[0, 2])] - shift
        largest = surface.vertex_data.get(IN_VERTEX_DATA[0], np.zeros(1)).max(initial=0.0)
        return leaves + largest * _UP_AND_DOWN, _NO_PLANES
    a, b, c = ((surface.vertices - corner)[surface.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, size, out=np.zeros_like(normals), where=size > 0)
    planes = np.column_stack([normals, (normals * a).sum(axis=1)])
    return np.hstack([np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)]), planes
