"""Pillars that follow the faults: moved onto them at the middle of the grid, and tilted along them.

A fault parts columns along a stair of edges. The nodes of that stair move to the nearest place on
the fault and tilt down its dip. All others follow smoothly, and less with distance. Where pillars
would cross, those next to it give way until no cell is folded: the fault is a stair-step there.

A grid rounds a block to whole columns: the trace of a fault becomes a polyline through pillars, and
the outline of the model a stair. What a block gains or loses so, its pillars give
back here: those at boundaries between blocks move and tilt by some metres, all as little as the
differences of volumes allow.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import binary_dilation, label
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from geosurf.grid.pillars import CORNERS, TURNS, Pillars
from geosurf.kernels.search.columns import cross_columns
from geosurf.model.grids import GAUSS, CornerPointGrid

# ---- barriers ----------------------------------------
# Which faults lie between neighbouring columns: rays between the middles of their cells.
#
# A ray along I is a vertical line of a frame whose axes have changed places, so that the exact
# signs of `geosurf.kernels.search.columns` decide whether it meets a fault. A fault parts two
# columns if the ray between them crosses it an odd number of times. Middles lie at different
# elevations: the way from one to the next is vertical, then a ray, then vertical again, so that
# ways around a node agree on what is on which side.


AXES = ((1, 2, 0), (0, 2, 1))  # of a ray along I, along J: the two across it, then along it


def faults_between(
    faults: Sequence[tuple[np.ndarray, np.ndarray]], middle: np.ndarray, inside: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Find the faults between the middles of neighbouring columns.

    Parameters
    ----------
    faults : sequence of (ndarray, ndarray)
        Vertices in lattice coordinates (n, 3) and triangles (m, 3) of each fault.
    middle : ndarray of float64, shape (n_level, ny, nx)
        Elevation of the middle of each column at each level [m].
    inside : ndarray of bool, shape (ny, nx)
        Columns inside the model.

    Returns
    -------
    (ndarray of bool, ndarray of bool)
        Along I (n_fault, n_level, ny, nx - 1) and along J (n_fault, n_level, ny - 1, nx).
    """
    level, ny, nx = middle.shape
    _, j, i = np.meshgrid(*map(np.arange, (level, ny, nx)), indexing="ij")
    place = np.stack([i + 0.5, j + 0.5, middle], axis=-1)

    # the ray lies at the mean elevation of both
    rays_i = place[:, :, :-1].copy()
    rays_i[..., 2] = 0.5 * (middle[:, :, :-1] + middle[:, :, 1:])
    rays_j = place[:, :-1].copy()
    rays_j[..., 2] = 0.5 * (middle[:, :-1] + middle[:, 1:])
    open_i, open_j = inside[:, :-1] & inside[:, 1:], inside[:-1] & inside[1:]
    found_i, found_j = [], []
    for x, triangles in faults:
        apart_i = _crossed(x, triangles, rays_i, open_i, 0)
        apart_j = _crossed(x, triangles, rays_j, open_j, 1)
        below = Below(x, triangles, inside)
        here = below(middle)
        for end in (slice(None, -1), slice(1, None)):
            # of both columns: from the middle to the height of the ray
            z = middle.copy()
            z[:, :, end] = rays_i[..., 2]
            apart_i ^= (below(z) ^ here)[:, :, end]
            z = middle.copy()
            z[:, end] = rays_j[..., 2]
            apart_j ^= (below(z) ^ here)[:, end]
        found_i.append(apart_i & open_i)
        found_j.append(apart_j & open_j)
    return (
        np.array(found_i, dtype=bool).reshape(len(faults), level, ny, nx - 1),
        np.array(found_j, dtype=bool).reshape(len(faults), level, ny - 1, nx),
    )


class Below:
    """Whether a fault is crossed an odd number of times below a point of the line of a column."""

    def __init__(self, x: np.ndarray, triangles: np.ndarray, inside: np.ndarray) -> None:
        j, i = np.nonzero(inside)
        feet = np.stack([i + 0.5, j + 0.5], axis=1)
        found = cross_columns(x, triangles, feet, np.zeros(2))
        self.column, self.elevation = np.flatnonzero(inside)[found.foot], found.elevation

    def __call__(self, z: np.ndarray) -> np.ndarray:
        """Of elevations (n_level, ny, nx)."""
        flat = z.reshape(len(z), -1)
        odd = np.zeros(flat.shape, dtype=np.int64)
        for k, one in enumerate(flat):
            lower = self.elevation < one[self.column]
            odd[k] = np.bincount(self.column[lower], minlength=flat.shape[1])
        return (odd % 2 == 1).reshape(z.shape)


def own_side(
    faults: Sequence[tuple[np.ndarray, np.ndarray]], middle: np.ndarray, inside: np.ndarray
) -> np.ndarray:
    """
    Return which Gauss points of a column lie on the side of its middle of all faults.

    Parameters
    ----------
    faults : sequence of (ndarray, ndarray)
    middle : ndarray of float64, shape (ny, nx)
        Elevation [m].
    inside : ndarray of bool, shape (ny, nx)

    Returns
    -------
    ndarray of bool, shape (ny, nx, 2, 2)
        Last axes along J and I.
    """
    ny, nx = middle.shape
    j, i = np.meshgrid(np.arange(ny), np.arange(nx), indexing="ij")
    half = 0.5 - GAUSS[0]
    same = np.ones((ny, nx, 2, 2), dtype=bool)
    for x, triangles in faults:
        for b in range(2):
            # from the middle along J, then along I: one crossing after the other
            start = np.stack([i + 0.5, j + (GAUSS[0], 0.5)[b], middle], axis=-1)
            first = _crossed(x, triangles, start, inside, 1, half)
            for a in range(2):
                start = np.stack([i + (GAUSS[0], 0.5)[a], j + GAUSS[b], middle], axis=-1)
                same[:, :, b, a] &= first == _crossed(x, triangles, start, inside, 0, half)
    return same


def _crossed(
    x: np.ndarray,
    triangles: np.ndarray,
    start: np.ndarray,
    open_at: np.ndarray,
    along: int,
    length: float = 1.0,
) -> np.ndarray:
    """Whether rays along an axis cross a fault an odd number of times."""
    across = list(AXES[along])
    low, high = x.min(axis=0), x.max(axis=0)
    near = open_at & (start >= low - 1.0).all(axis=-1) & (start <= high + 1.0).all(axis=-1)
    rays = start[near]
    crossings = cross_columns(
        np.ascontiguousarray(x[:, across]), triangles, rays[:, across[:2]].copy(), np.zeros(2)
    )
    first = rays[crossings.foot, along]
    hit = (crossings.elevation >= first) & (crossings.elevation < first + length)
    out = np.zeros(start.shape[:-1], dtype=bool)
    out[near] = np.bincount(crossings.foot[hit], minlength=len(rays)) % 2 == 1
    return out


# ---- unfold ----------------------------------------
# Pillars that fold a cell step aside, by no more than needed.
#
# Three corners of a column may lie on one fault, nearly on a line: the corner between the two
# others has no area. Each such corner moves these three pillars a little, along the gradient of
# its area, until all corners have enough. So pillars stay within some hundredths of a cell of the
# fault.


LEAST_AREA = 0.1  # of a cell, at each of its corners
BEYOND = 1.05  # share of it to which a corner moves, so that rounds end
UNFOLD_ROUNDS = 60


def folded(pillars: Pillars) -> np.ndarray:
    """Cells with a corner that has too little area at some elevation within reach, (ny, nx)."""
    return pillars.least_areas()[0].min(axis=0) < LEAST_AREA


def unfolded(pillars: Pillars) -> Pillars:
    """Pillars that stepped aside where they folded a cell; some may be folded after all rounds."""
    shift = pillars.shift.copy()
    ny, nx = pillars.level.shape
    for _ in range(UNFOLD_ROUNDS):
        now = replace(pillars, shift=shift)
        areas, at = now.least_areas()
        if (areas >= LEAST_AREA).all():
            return now
        move, count = np.zeros_like(shift), np.zeros((ny, nx, 1))
        for turn, area, z in zip(TURNS, areas, at, strict=True):
            j, i = np.nonzero(area < LEAST_AREA)
            nodes = [(j + CORNERS[c][0], i + CORNERS[c][1]) for c in turn]
            x = [now.places(node, z[j, i]) for node in nodes]
            u, v = x[1] - x[0], x[2] - x[0]
            ahead, back = np.stack([v[:, 1], -v[:, 0]], 1), np.stack([-u[:, 1], u[:, 0]], 1)
            slopes = [-(ahead + back), ahead, back]

            # the shortest step of all three that gives the corner its area
            steep = sum((s**2).sum(axis=1) for s in slopes)
            step = (BEYOND * LEAST_AREA - area[j, i]) / np.maximum(steep, 1e-3)
            for node, slope in zip(nodes, slopes, strict=True):
                np.add.at(move, node, step[:, None] * slope)
                np.add.at(count, node, 1.0)

        # across the rim none moves
        move[:, [0, -1], 0] = 0.0
        move[[0, -1], :, 1] = 0.0
        shift = shift + move / np.maximum(count, 1.0)
    return replace(pillars, shift=shift)


RANGE = 4.0  # cells over which a moved pillar moves others
GIVE_WAY = 0.75  # factor for pillars next to a folded cell
ROUNDS = 25
FOLLOWS = 0.5  # pillars that give way more than this are a stair-step
FARTHEST = 1.2  # cells that a node moves at the middle of the grid

Faults = Sequence[tuple[np.ndarray, np.ndarray]]


def follow_faults(
    faults: Faults,
    between: tuple[np.ndarray, np.ndarray],
    level: np.ndarray,
    reach: np.ndarray,
    cell: np.ndarray,
    min_dip: float,
) -> tuple[Pillars, np.ndarray, np.ndarray]:
    """
    Return pillars along faults.

    Parameters
    ----------
    faults : sequence of (ndarray, ndarray)
        Vertices in lattice coordinates and triangles.
    between : (ndarray of bool, ndarray of bool)
        Faults between columns at the middle of the grid, with one level; see `faults_between`.
    level : ndarray of float64, shape (ny + 1, nx + 1)
        Elevation of the middle of the grid [m].
    reach : ndarray of float64, shape (ny + 1, nx + 1)
        Half its height [m].
    cell : ndarray of float64, shape (2,)
        Size of a cell [m].
    min_dip : float
        Pillars follow faults that dip at least this [degrees].

    Returns
    -------
    (Pillars, ndarray of bool, ndarray of int64)
        Which of them follow a fault (ny + 1, nx + 1), and by fault the number of pillars that
        step, and of all (n_fault, 2).
    """
    ny, nx = level.shape[0] - 1, level.shape[1] - 1
    shift, slope = np.zeros((ny + 1, nx + 1, 2)), np.zeros((ny + 1, nx + 1, 2))
    owner = np.full((ny + 1, nx + 1), -1)
    nodes = [_stair(between, f) for f in range(len(faults))]
    nearest = np.full(level.shape, np.inf)
    for f, (x, triangles) in enumerate(faults):
        j, i = np.nonzero(nodes[f])
        good, moves, tilts = _onto(x, triangles, j, i, level, (ny, nx), cell, min_dip)

        # a node at two faults follows the nearer one
        size = np.hypot(*moves.T)
        good &= size < nearest[j, i]
        j, i = j[good], i[good]
        shift[j, i], slope[j, i], owner[j, i] = moves[good], tilts[good], f
        nearest[j, i] = size[good]

    fixed = owner >= 0
    pillars, share = _without_folds(shift, slope, fixed, level, reach)
    follows = fixed & (share >= FOLLOWS)
    counts = np.array([[(one & ~follows).sum(), one.sum()] for one in nodes], dtype=np.int64)
    return pillars, follows, counts.reshape(len(faults), 2)


def _without_folds(
    shift: np.ndarray, slope: np.ndarray, fixed: np.ndarray, level: np.ndarray, reach: np.ndarray
) -> tuple[Pillars, np.ndarray]:
    """Pillars of which some are fixed, and how far these had to give way (ny + 1, nx + 1)."""
    zero = Pillars(np.zeros_like(shift), np.zeros_like(slope), level, reach)
    share = np.ones(level.shape)
    if not fixed.any():
        return zero, share
    spread = _Spread(fixed)
    for _ in range(ROUNDS):
        leaning = spread(slope * share[..., None])
        pillars = unfolded(Pillars(spread(shift * share[..., None]), leaning, level, reach))
        bad = np.pad(folded(pillars), 1)
        if not bad.any():
            return pillars, share
        beside = bad[:-1] | bad[1:]
        share[_wider(beside[:, :-1] | beside[:, 1:]) & fixed] *= GIVE_WAY
    return zero, np.zeros(level.shape)


def _stair(between: tuple[np.ndarray, np.ndarray], fault: int) -> np.ndarray:
    """Nodes at edges between columns that a fault parts, (ny + 1, nx + 1)."""
    along_i, along_j = between[0][fault, 0], between[1][fault, 0]
    ny, nx = along_i.shape[0], along_j.shape[1]
    nodes = np.zeros((ny + 1, nx + 1), dtype=bool)
    nodes[:-1, 1:-1] |= along_i
    nodes[1:, 1:-1] |= along_i
    nodes[1:-1, :-1] |= along_j
    nodes[1:-1, 1:] |= along_j
    return nodes


def _onto(
    x: np.ndarray, triangles: np.ndarray, j: np.ndarray, i: np.ndarray, level: np.ndarray,
    shape: tuple[int, int], cell: np.ndarray, min_dip: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Which nodes can follow a fault, how far they move, and how they tilt."""
    place = np.stack([i, j, level[j, i]], axis=1).astype(np.float64)
    a, b, c = (x[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    distance, normal = np.full((len(j), 2), np.inf), np.zeros((len(j), 3))
    for along, axes in enumerate(AXES):
        across = list(axes)
        crossings = cross_columns(
            np.ascontiguousarray(x[:, across]), triangles, place[:, across[:2]].copy(), np.zeros(2)
        )
        gap = crossings.elevation - place[crossings.foot, along]

        # the nearest crossing of each node comes last, and is that which stays
        order = np.argsort(-np.abs(gap), kind="stable")
        foot = crossings.foot[order]
        distance[foot, along] = gap[order]
        nearest = np.zeros((len(j), 3))
        nearest[foot] = normals[crossings.triangle[order]]
        nearest *= np.where(nearest[:, along] < 0, -1.0, 1.0)[:, None]
        weight = 1.0 / np.maximum(np.abs(distance[:, along]), 0.01)
        turned = (nearest * normal).sum(axis=1) < 0
        normal += np.where(turned[:, None], -nearest, nearest) * weight[:, None]

    # nearest place on the straight trace through both crossings; on the rim along the rim
    rim_i, rim_j = (i == 0) | (i == shape[1]), (j == 0) | (j == shape[0])
    distance[rim_i, 0], distance[rim_j, 1] = np.inf, np.inf
    normal[rim_i, 0], normal[rim_j, 1] = 0.0, 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        back = np.clip(1.0 / distance, -1e9, 1e9)
        move = back / (back**2).sum(axis=1)[:, None]
        flat = (normal[:, :2] ** 2).sum(axis=1)
        tilt = -normal[:, 2:] * normal[:, :2] / flat[:, None]
        steep = np.hypot(*(tilt * cell).T) <= 1.0 / np.tan(np.radians(min_dip))
    good = np.isfinite(distance).any(axis=1) & (flat > 0) & steep
    good &= np.isfinite(move).all(axis=1) & (np.hypot(*move.T) <= FARTHEST)
    return good, move, tilt


def _wider(nodes: np.ndarray) -> np.ndarray:
    """Nodes, and those around them."""
    room = np.pad(nodes, 1)
    n, m = nodes.shape
    parts = [room[a : a + n, b : b + m] for a in range(3) for b in range(3)]
    return np.logical_or.reduce(parts)


class _Spread:
    """Values at some nodes, spread to all others: each is nearly the mean of its neighbours."""

    def __init__(self, fixed: np.ndarray) -> None:
        self.fixed = fixed
        self._solve = [self._factor(fixed, along) for along in range(2)] if fixed.any() else []

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Return values at all nodes (ny + 1, nx + 1, 2); across the rim none moves."""
        out = np.zeros_like(values)
        for along, (free, solve) in enumerate(self._solve):
            known = np.where(self.fixed, values[..., along], 0.0)
            out[..., along] = known
            room = np.pad(known, 1)
            load = room[:-2, 1:-1] + room[2:, 1:-1] + room[1:-1, :-2] + room[1:-1, 2:]
            out[free, along] = solve(load[free])
        return out

    @staticmethod
    def _factor(fixed: np.ndarray, along: int):  # type: ignore[no-untyped-def]
        free = ~fixed
        if along == 0:
            free[:, [0, -1]] = False
        else:
            free[[0, -1]] = False
        number = np.full(fixed.shape, -1)
        number[free] = np.arange(free.sum())

        # five-point differences; the remainder on the diagonal makes values decay over RANGE
        count = np.full(fixed.shape, 4.0)
        count[[0, -1]] -= 1.0
        count[:, [0, -1]] -= 1.0
        rows, cols = [], []
        for a, b in ((number[:-1], number[1:]), (number[:, :-1], number[:, 1:])):
            both = (a >= 0) & (b >= 0)
            rows += [a[both], b[both]]
            cols += [b[both], a[both]]
        n = int(free.sum())
        row, col = np.concatenate([*rows, np.arange(n)]), np.concatenate([*cols, np.arange(n)])
        values = np.concatenate([np.full(len(row) - n, -1.0), count[free] + 1.0 / RANGE**2])
        matrix = coo_array((values, (row, col)), shape=(n, n)).tocsc()
        return free, splu(matrix).solve


BALANCE_ROUNDS = 4  # of a new grid
WIDER = 6  # times that more pillars around a cell that is inside out become parallel
ENOUGH = 4e-3  # difference of a unit that pillars leave to thicknesses
CLOSE = 5e-4  # difference of a unit that is left as it is
GOOD = 5e-4  # of the volume of a unit: weighs as much as a move of one pillar by MOVE
MOVE = 0.1  # of a cell
MOST_MOVE = 0.25  # of a cell, of one pillar
HALVINGS = 6  # of moves that fold a cell
THICKENINGS = 4  # of a new grid
MOST_THICKER = 0.05  # of a zone, beside faults
USUAL_GAIN, LEAST_GAIN = 0.5, 0.02  # of a unit: as if that much of it were beside faults
FEW = 10.0  # columns: differences of smaller units weigh less


def misfits(grid: CornerPointGrid) -> np.ndarray:
    """Difference of the volume of each unit from that of the model, as a share of it.

    Units smaller than `FEW` columns count less, by the square: cells cannot follow them.
    """
    table = grid.table
    exact, volume = table.exact.values, table.volume.values
    few = FEW / np.maximum(grid.columns_of_units, 1e-9)
    return (exact - volume) / (exact * np.maximum(few, 1.0) ** 2)


def _without_twists(
    gridded: Callable[[Pillars], CornerPointGrid], pillars: Pillars
) -> tuple[Pillars, CornerPointGrid]:
    """Pillars, and the grid between them, whose cells are not inside out.

    In a wedge, one zone may be thin at three pillars of a column while its surfaces are steep, and
    differently so. Where these pillars lean apart, such a cell is inside out at a corner, though
    the pillars do not cross. Parallel pillars cannot do that.
    """
    last, grid = pillars, gridded(pillars)
    columns = np.zeros(grid.actnum.shape[1:], dtype=bool)
    for _ in range(WIDER):
        twisted = grid.inside_out.any(axis=0)
        if not twisted.any():
            break
        columns |= twisted
        parallel = unfolded(_parallel_around(pillars, columns))
        if folded(parallel).any():  # pillars farther away have to lean less differently, too
            columns = binary_dilation(columns, np.ones((3, 3)))
        else:
            last, grid = parallel, gridded(parallel)
    return last, grid


def _parallel_around(pillars: Pillars, columns: np.ndarray) -> Pillars:
    """Pillars of which those around some columns (ny, nx) lean as they do on average."""
    slope = pillars.slope.copy()
    groups, n = label(columns, structure=np.ones((3, 3)))
    for group in range(1, n + 1):
        wide = np.pad(groups == group, 1)
        nodes = wide[1:, 1:] | wide[1:, :-1] | wide[:-1, 1:] | wide[:-1, :-1]
        slope[nodes] = slope[nodes].mean(axis=0)
    return replace(pillars, slope=slope)


def balanced(
    gridded: Callable[..., CornerPointGrid], pillars: Pillars, follows: np.ndarray, cell: np.ndarray
) -> CornerPointGrid:
    """
    Return the grid whose units are nearest to the volumes of the model.

    Parameters
    ----------
    gridded : callable
        Makes the grid between pillars, and with thicker zones in columns.
    pillars : Pillars
    follows : ndarray of bool, shape (ny + 1, nx + 1)
        Pillars that follow a fault: only these tilt.
    cell : ndarray of float64, shape (2,)
        Size of a cell [m].

    Returns
    -------
    CornerPointGrid
    """
    pillars, best = _without_twists(gridded, pillars)
    left, share = misfits(best), 1.0
    for _ in range(BALANCE_ROUNDS):
        if np.abs(left).max(initial=0.0) <= ENOUGH:
            break
        moved, grid = _without_twists(gridded, _moved(best, pillars, follows, cell, share))
        now = misfits(grid)
        better = (now**2).sum() < (left**2).sum() and not grid.inside_out.any()
        if better:
            pillars, best, left = moved, grid, now
        share = min(2.0 * share, 1.0) if better else 0.25 * share
    return _thickened(gridded, pillars, best)


def _thickened(
    gridded: Callable[..., CornerPointGrid], pillars: Pillars, grid: CornerPointGrid
) -> CornerPointGrid:
    """Give what pillars leave to the thickness of cells beside faults and outlines.

    All other corners are on the horizons, and stay there.
    """
    many = grid.columns_of_units >= FEW
    left, size = np.where(many, misfits(grid), 0.0), np.zeros(len(many))
    gain = np.full(len(many), USUAL_GAIN)
    for _ in range(THICKENINGS):
        if np.abs(left).max(initial=0.0) <= CLOSE:
            break
        step = np.clip(size + left / gain, -MOST_THICKER, MOST_THICKER) - size
        thicker = gridded(pillars, 1.0 + _of_columns(grid, size + step))
        now = np.where(many, misfits(thicker), 0.0)
        if thicker.inside_out.any() or (now**2).sum() >= (left**2).sum():
            break

        # how much of a unit is beside faults shows in what it answers
        told = np.abs(step) > CLOSE
        share = (left - now)[told] / step[told]
        gain[told] = np.clip(share, LEAST_GAIN, 1.0)
        grid, left, size = thicker, now, size + step
    return grid


def _of_columns(grid: CornerPointGrid, values: np.ndarray) -> np.ndarray:
    """Values of units in the columns in which most of a zone is in one, (ny, nx, n_zone, 1, 1)."""
    zone = np.array([grid.zone_names.index(name) for name, _ in grid.unit_names])
    out = np.zeros((*grid.shape[1:], len(grid.zone_names), 1, 1))
    for k in range(len(grid.zone_names)):
        counts = [(grid.unit == u).sum(axis=0) for u in np.flatnonzero(zone == k)]
        if counts:
            most = np.argmax(counts, axis=0)
            out[:, :, k, 0, 0] = np.where(np.any(counts, axis=0), values[zone == k][most], 0.0)
    return out


def _moved(
    grid: CornerPointGrid, pillars: Pillars, follows: np.ndarray, cell: np.ndarray, share: float
) -> Pillars:
    """Pillars that bring the volumes of units nearer to those of the model, by a share of it.

    Each pillar at a boundary has four unknowns: metres to the east and north, and more of both at
    the upper end. Of all moves that balance the units, the least squares are least.
    """
    block = np.pad(_block_of_columns(grid), 1, mode="edge")
    around = [block[:-1, :-1], block[1:, :-1], block[:-1, 1:], block[1:, 1:]]
    j, i = np.nonzero(np.max(around, axis=0) != np.min(around, axis=0))
    wrong = misfits(grid)
    size = np.where(wrong != 0.0, (grid.exact - grid.table.volume.values) / wrong, 1.0)
    rates = _rates(grid, pillars, (j, i), cell)

    # across the rim none moves, and only pillars along faults tilt
    ny, nx = block.shape[0] - 2, block.shape[1] - 2
    rates[:, (i == 0) | (i == nx), :, 0] = 0.0
    rates[:, (j == 0) | (j == ny), :, 1] = 0.0
    rates[:, ~follows[j, i], 1] = 0.0
    rows = rates.reshape(len(wrong), -1) / size[:, None]
    damping = (GOOD / (MOVE * float(cell.mean()))) ** 2
    step = rows.T @ np.linalg.solve(rows @ rows.T + damping * np.eye(len(rows)), wrong)
    step = step.reshape(-1, 2, 2) / cell
    most = float(np.abs(step).sum(axis=1).max(initial=0.0))
    share *= min(1.0, MOST_MOVE / most) if most else 0.0
    for _ in range(HALVINGS):
        shift, slope = pillars.shift.copy(), pillars.slope.copy()
        shift[j, i] += share * step[:, 0]
        slope[j, i] += share * step[:, 1] / pillars.reach[j, i][:, None]
        moved = unfolded(replace(pillars, shift=shift, slope=slope))
        if not folded(moved).any():
            return moved
        share *= 0.5
    return pillars


def _block_of_columns(grid: CornerPointGrid) -> np.ndarray:
    """Block of most of each column, (ny, nx); -1 outside of the model."""
    thick = np.where(grid.actnum, -np.diff(grid.levels, axis=0).mean(axis=(-1, -2)), 0.0)
    share = np.stack(
        [np.where(grid.block == b, thick, 0.0).sum(axis=0) for b in range(len(grid.block_names))]
    )
    return np.where(share.any(axis=0), share.argmax(axis=0), -1)


def _rates(
    grid: CornerPointGrid, pillars: Pillars, at: tuple[np.ndarray, np.ndarray], cell: np.ndarray
) -> np.ndarray:
    """Change of the volume of units by moves and tilts of pillars, (n_unit, n, 2, 2) [m2]."""
    j, i = at
    ny, nx = grid.shape[1:]
    out = np.zeros((len(grid.unit_names), len(j), 2, 2))
    node = np.stack(np.meshgrid(np.arange(nx + 1), np.arange(ny + 1)), axis=-1)
    for m, k in CORNERS:
        # the columns of which these nodes are the corner m, k
        rows = np.flatnonzero((j >= m) & (j - m < ny) & (i >= k) & (i - k < nx))
        jj, ii, here = j[rows] - m, i[rows] - k, (j[rows], i[rows])
        z = grid.levels[:, jj, ii].mean(axis=(-1, -2))
        thick, middle = -np.diff(z, axis=0), 0.5 * (z[1:] + z[:-1])
        up = middle - pillars.level[here]

        # the area of a quadrilateral changes by half the diagonal across the moved corner
        before, after = ((jj + m, ii + 1 - k), (jj + 1 - m, ii + k))
        turn = 1.0 if m == k else -1.0
        across = (
            turn * 0.5 * ((node + pillars.shift)[before] - (node + pillars.shift)[after])
            + turn * 0.5 * (pillars.slope[before] - pillars.slope[after]) * up[..., None]
        )
        move = np.stack([across[..., 1], -across[..., 0]], axis=-1) * cell[::-1] * thick[..., None]
        both = np.stack([move, move * (up / pillars.reach[here])[..., None]], axis=-2)
        unit = grid.unit[:, jj, ii]
        live = unit >= 0
        np.add.at(out, (unit[live], np.broadcast_to(rows, unit.shape)[live]), both[live])
    return out
