"""The default area: the outline that all horizons share, rotated and not convex as it may be.

The map is divided into cells along the finest lattice. A cell belongs to the area if no rim of a
horizon enters it and all horizons cover its middle. The largest piece becomes a polygon. It loses
corners inward only, and moves inward by a small part of a cell. At last its sides and all rims are
compared exactly, so that it lies inside every horizon.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.conventions import area_text, counted, place
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import ranges
from geosurf.triangulate.footprint import REGULAR, Axes, Footprint
from geosurf.triangulate.outline import (
    check_outline,
    lies_inside,
    moved_inward,
    signed_area,
    with_fewer_corners,
)

FINE = 2000  # map cells along the longer side, where rims do not follow one lattice
MOST = 25_000_000  # map cells
EAR, LOST = 5e-4, 7.5e-3  # parts of the area: the largest ear; what cells at rims and ears may take
EARS = 1e-3  # and ears alone may always take
LEAST = 1e-3  # cells: the area moves inward by twice this; less leaves slivers that rounding moves
SMALL = 1e-4  # parts of the area: smaller pieces are not listed
_HOW = "Pass aoi= with the outline of your model, or box=(west, east, south, north, bottom, top)."


@dataclass(frozen=True, eq=False)
class SharedArea:
    """
    The default area, and what it leaves out.

    Attributes
    ----------
    outline : ndarray of float64, shape (n, 2)
        Corners, counter-clockwise [m].
    axis_parallel : bool
        Whether it is a rectangle along the axes.
    area : float
        Inside the outline [m2].
    share : float
        Part of what all horizons cover.
    pieces : tuple of (float, (float, float))
        Area [m2] and a place of every other piece.
    """

    outline: np.ndarray
    axis_parallel: bool
    area: float
    share: float
    pieces: tuple[tuple[float, tuple[float, float]], ...]


@dataclass(frozen=True, eq=False)
class _MapCells:
    """Cells of equal size along axes; `slack` [cells]: rims this near a border do not enter."""

    axes: Axes
    low: np.ndarray
    step: np.ndarray
    shape: tuple[int, int]
    slack: np.ndarray

    def place_of(self, xy: np.ndarray) -> np.ndarray:
        return (self.axes.to_lattice(xy) - self.low) / self.step

    def to_world(self, uv: np.ndarray) -> np.ndarray:
        return self.axes.to_world(self.low + uv * self.step)

    @property
    def area(self) -> float:
        """Of one cell [m2]."""
        return abs(float(np.linalg.det(self.axes.steps))) * float(self.step.prod())


def shared_area(horizons: Sequence[Footprint]) -> SharedArea:
    """
    Return the largest area that all horizons cover, as one polygon without holes.

    Raises
    ------
    InputError
        If there is none, or it has holes: with their size, place, and how to fill them.

    Examples
    --------
    >>> from geosurf.model import Lattice, TriSurface
    >>> from geosurf.triangulate.footprint import footprint_of
    >>> i, j = np.meshgrid(np.arange(21.0), np.arange(41.0))
    >>> turned = Lattice((i - j) * 50, (i + j) * 50, np.zeros((41, 21)))
    >>> found = shared_area([footprint_of(TriSurface("Top", "horizon", lattice=turned))])
    >>> len(found.outline), round(found.share, 2), found.pieces
    (4, 1.0, ())
    """
    distinct = list({id(horizon.rim): horizon for horizon in horizons}.values())
    cells = _map_cells(distinct)
    covered = np.ones(cells.shape, dtype=bool)
    middles = covered.copy()  # cells whose middle all horizons cover: most of what is lost at rims
    by_rim = {}
    for horizon in distinct:
        rim = cells.place_of(horizon.rim)
        inside = _windings(rim, cells.shape) > 0
        free = inside & ~_entered(rim, cells.shape, cells.slack)
        if horizon.torn:
            inside, free = _filled(inside), _filled(free)
        middles &= inside
        covered &= free
        by_rim[id(horizon.rim)] = inside
    by_horizon = {horizon.name: by_rim[id(horizon.rim)] for horizon in horizons}
    region, pieces = _pieces(covered, cells)
    _refuse_holes(region, by_horizon, cells)

    n_cell, n_middle = int(region.sum()), int(middles.sum())
    ears = max(EARS * n_cell, LOST * n_cell - int((middles & ~covered).sum()))
    ring = with_fewer_corners(_ring_around(region), EAR * n_cell, ears)
    outline, axis_parallel = _inside_all(ring, cells, distinct)
    area = signed_area(outline)
    share = min(area / (max(n_middle, n_cell) * cells.area), 1.0)
    return SharedArea(outline, axis_parallel, area, share, pieces)


def _map_cells(horizons: Sequence[Footprint]) -> _MapCells:
    """Cells along the finest lattice; its own where all rims follow its rows and columns."""
    regular = [horizon.axes for horizon in horizons if horizon.axes is not None]
    axes = min(regular, key=lambda axes: axes.cell, default=None)
    if axes is None:
        axes = Axes(horizons[0].bounds[0], np.eye(2))
    rims = [axes.to_lattice(horizon.rim) for horizon in horizons]
    low = np.max([rim.min(axis=(0, 1)) for rim in rims], axis=0)
    high = np.min([rim.max(axis=(0, 1)) for rim in rims], axis=0)
    if (high - low <= 1e-9 * np.abs(high - low).max()).any():
        where = "; ".join(
            f"{horizon.name!r} is from {' to '.join(map(place, horizon.bounds))}"
            for horizon in horizons
        )
        raise InputError(
            f"the horizons have no area in common: {where}. Check the order of their columns, and "
            "their coordinate systems."
        )

    # rims that follow rows and columns of one lattice need no finer cells than its own
    off = max(float(np.abs(rim - np.rint(rim)).max()) for rim in rims)
    aligned = bool(regular) and off <= REGULAR
    if aligned:
        low, high = np.rint(low), np.rint(high)
    size = high - low
    number = size * _cells_per_step(size, rims, aligned)
    columns, rows = (max(int(n), 1) for n in np.ceil(number - 1e-9))
    step = size / (columns, rows)

    # rims within the slack of a border do not enter: rounding must not cost a row of cells
    slack = (2.0 * (off if aligned else 0.0) + LEAST) / step
    return _MapCells(axes, low, step, (rows, columns), slack)


def _cells_per_step(size: np.ndarray, rims: Sequence[np.ndarray], aligned: bool) -> float:
    """How many cells of the map there are to a cell of the lattice."""
    if not aligned:
        return FINE / float(size.max())
    if size.prod() > MOST:
        return float(np.sqrt(MOST / size.prod()))

    # rims along rows and columns keep whole cells; diagonals cut them, and need finer ones
    along = (np.abs(np.diff(rim, axis=1)[:, 0]).min(axis=1) <= 2 * REGULAR for rim in rims)
    return 1.0 if all(one.all() for one in along) else np.ceil(FINE / float(size.max()))


def _windings(rim: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """How often each cell's middle is covered; rims in cells, (n, 2, 2)."""
    rows, columns = shape

    # winding numbers by scan lines: each rim segment changes the sum at the middles of its rows,
    # upward by -1 and downward by 1; sums along the rows give the windings
    (x, y), (u, v) = rim[:, 0].T, rim[:, 1].T
    low, high = np.minimum(y, v), np.maximum(y, v)
    first = np.clip(np.ceil(low - 0.5), 0, rows).astype(np.int64)
    last = np.clip(np.ceil(high - 0.5), 0, rows).astype(np.int64)  # not included
    edge, row = ranges(first, last - first)

    # where the segment crosses the middle of the row; the steps count from the cell after it on
    at = x[edge] + (u[edge] - x[edge]) * (row + 0.5 - y[edge]) / (v[edge] - y[edge])
    column = np.clip(np.ceil(at - 0.5), 0, columns).astype(np.int64)
    steps = np.zeros((rows, columns + 1), dtype=np.int16)
    np.add.at(steps, (row, column), np.where(v[edge] < y[edge], 1, -1).astype(np.int16))
    return np.cumsum(steps[:, :-1], axis=1, dtype=np.int16)


def _entered(rim: np.ndarray, shape: tuple[int, int], slack: np.ndarray) -> np.ndarray:
    """Which cells a rim enters, deeper than the slack."""
    rows, columns = shape

    # segments in parts of three cells at most: then each part meets few cells around it
    longest = np.abs(rim[:, 1] - rim[:, 0]).max(axis=1)
    n_part = np.maximum(np.ceil(longest / 3.0), 1.0).astype(np.int64)
    segment, part = ranges(0, n_part)
    step = (rim[:, 1] - rim[:, 0])[segment] / n_part[segment, None]
    start = rim[segment, 0] + part[:, None] * step
    low = np.minimum(start, start + step)
    high = np.maximum(start, start + step)
    base = np.floor(low).astype(np.int64) - 1
    entered = np.zeros(shape, dtype=bool)
    reach = int(np.ceil((high - low).max(initial=0.0))) + 3
    for i in range(reach):
        for j in range(reach):
            cell = base + np.array([i, j])
            near = ((high > cell + slack) & (low < cell + 1 - slack)).all(axis=1)
            near &= (cell >= 0).all(axis=1) & (cell < (columns, rows)).all(axis=1)
            k = np.flatnonzero(near)

            # a cell is entered if the part's box meets it and its corners are on both sides of the
            # part
            sides = []
            for s in (slack[0], 1 - slack[0]):
                for t in (slack[1], 1 - slack[1]):
                    dx, dy = (cell[k] + (s, t) - start[k]).T
                    sides.append(step[k, 0] * dy - step[k, 1] * dx)
            met = (np.min(sides, axis=0) <= 0) & (np.max(sides, axis=0) >= 0)
            entered[cell[k[met], 1], cell[k[met], 0]] = True
    return entered


def _filled(covered: np.ndarray) -> np.ndarray:
    from scipy.ndimage import binary_fill_holes

    return binary_fill_holes(covered)


def _pieces(
    covered: np.ndarray, cells: _MapCells
) -> tuple[np.ndarray, tuple[tuple[float, tuple[float, float]], ...]]:
    """The largest piece, whose cells nowhere meet in a corner only, and the other pieces."""
    if covered.all():
        return covered, ()
    from scipy.ndimage import label

    covered = covered.copy()
    while True:  # of two cells that meet in a corner only, the upper one goes
        a, b, c, d = covered[:-1, :-1], covered[:-1, 1:], covered[1:, :-1], covered[1:, 1:]
        rising, falling = a & d & ~b & ~c, b & c & ~a & ~d
        if not (rising.any() or falling.any()):
            break
        d[rising], c[falling] = False, False
    number, n = label(covered)
    if n == 0:
        raise InputError(f"the horizons have no area in common. {_HOW}")
    sizes = np.bincount(number.ravel())[1:]
    largest = int(sizes.argmax())
    others = []
    for k in np.argsort(-sizes)[1:]:
        if sizes[k] > SMALL * sizes[largest]:
            others.append((float(sizes[k]) * cells.area, _spot(number == k + 1, cells)))
    return number == largest + 1, tuple(others)


def _spot(region: np.ndarray, cells: _MapCells) -> tuple[float, float]:
    """A place inside a region, near its middle."""
    spots = np.argwhere(region)
    row, column = spots[np.abs(spots - spots.mean(axis=0)).sum(axis=1).argmin()]
    x, y = cells.to_world(np.array([column + 0.5, row + 0.5])).tolist()
    return x, y


def _refuse_holes(region: np.ndarray, by_horizon: dict[str, np.ndarray], cells: _MapCells) -> None:
    """Raise an error for what the region surrounds: which horizon is missing there, and where."""
    if region.all():
        return
    from scipy.ndimage import label

    # what is not in the region, with a rim around it: part 1 is the outside, all others are holes
    number, n = label(~np.pad(region, 1), structure=np.ones((3, 3)))
    if n == 1:
        return
    holes = number[1:-1, 1:-1]
    sizes = np.bincount(number.ravel())[2:] if number[0, 0] == 1 else None
    assert sizes is not None  # the corner is labelled first
    order = np.argsort(-sizes)
    words = []
    for k in order[:3].tolist():
        hole = holes == k + 2
        absent = [name for name, inside in by_horizon.items() if (hole & ~inside).any()]
        names = " and ".join(map(repr, absent)) or "a horizon"
        x, y = _spot(hole, cells)
        words.append(f"{names} at {place((x, y))} ({area_text(float(sizes[k]) * cells.area)})")
    more = f" and {counted(len(order) - 3, 'smaller one')}" if len(order) > 3 else ""
    raise InputError(
        f"the default area has {counted(len(order), 'hole')}: in {', '.join(words)}{more}. Fill "
        "them: horizon = gs.extend_horizon(horizon, fill_holes=True), or fill_holes = true in a "
        "scenario. Or pass aoi= with an outline that leaves them out; aoi='rectangle' takes the "
        "largest axis-parallel rectangle without holes."
    )


def _ring_around(region: np.ndarray) -> np.ndarray:
    """Corners (n, 2) of the outer border of a region, counter-clockwise: column and row."""
    if region.all():
        n_row, n_col = region.shape
        return np.array([[0, 0], [n_col, 0], [n_col, n_row], [0, n_row]])
    there = np.pad(region, 1)
    inner = there[1:-1, 1:-1]
    sides = (  # the neighbour that is missing, and the corners of that side
        (there[:-2, 1:-1], (0, 0), (1, 0)), (there[1:-1, 2:], (1, 0), (1, 1)),
        (there[2:, 1:-1], (1, 1), (0, 1)), (there[1:-1, :-2], (0, 1), (0, 0)),
    )  # fmt: skip

    # each border side from corner to corner, region on the left; no corner has two ways on, as the
    # region nowhere meets itself in a corner only
    following: dict[tuple[int, int], tuple[int, int]] = {}
    for other, start, end in sides:
        row, column = np.nonzero(inner & ~other)
        for i, j in zip(row.tolist(), column.tolist(), strict=True):
            following[j + start[0], i + start[1]] = (j + end[0], i + end[1])
    first = min(following)
    ring, at = [first], following[first]
    while at != first:
        ring.append(at)
        at = following[at]

    # corners in the middle of a straight side are left out
    corners = np.array(ring, dtype=np.int64)
    ahead, back = np.roll(corners, -1, axis=0) - corners, corners - np.roll(corners, 1, axis=0)
    return corners[(ahead != back).any(axis=1)]


def _inside_all(
    ring: np.ndarray, cells: _MapCells, horizons: Sequence[Footprint]
) -> tuple[np.ndarray, bool]:
    """The outline in the world, inside of all horizons; whether it is an axis-parallel rectangle.

    Sides along nodes of all unrotated grids stay there, the others move inward: those along rows
    farther.
    """
    outline = cells.to_world(ring.astype(np.float64))

    # the slack in metres: sides move inward by twice that, unless they lie on nodes of all grids
    off = np.max(cells.slack * cells.step) * np.hypot(*cells.axes.steps.T).max()
    inward = np.full(len(ring), 2.0 * off)
    lines = [horizon.lines for horizon in horizons]
    ahead = np.roll(ring, -1, axis=0) - ring
    # by the same length, corners would come to lie beside diagonals of square cells, nearly: nodes
    # would have to be moved there
    inward[ahead[:, 1] == 0] *= 1.5
    for axis in (0, 1):
        nodes = _common_lines([None if of is None else of[axis] for of in lines])
        for k in np.flatnonzero(ahead[:, axis] == 0).tolist():
            near = np.abs(nodes - outline[k, axis])
            if len(near) and near.min() <= off:
                outline[k, axis] = outline[(k + 1) % len(ring), axis] = nodes[near.argmin()]
                inward[k] = 0.0
    if inward.any():
        outline = moved_inward(outline, inward)
    outline = check_outline(outline)
    if inward.all() and not all(h.torn or lies_inside(outline, h.rim) for h in horizons):
        raise InputError(f"geosurf cannot find the area that all horizons share. {_HOW}")
    straight = (np.roll(outline, -1, axis=0) == outline).any(axis=1).all()
    return outline, bool(straight and len(outline) == 4)


def _common_lines(axes: Sequence[np.ndarray | None]) -> np.ndarray:
    """Coordinates that all unrotated grids have; none if a horizon is no such grid."""
    if any(axis is None for axis in axes):
        return np.empty(0)
    lines = np.asarray(axes[0])
    for axis in axes[1:]:
        lines = np.intersect1d(lines, np.asarray(axis))
    return lines
