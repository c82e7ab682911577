"""Pillars that follow the faults: moved onto them at the middle of the grid, and tilted along them.

A fault parts columns along a stair of edges. The nodes of that stair move to the nearest place on
the fault and tilt down its dip. All others follow smoothly, and less with distance. Where pillars
would cross, those next to it give way until no cell is folded: the fault is a stair-step there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geosurf.grid.barriers import AXES
from geosurf.grid.pillars import CORNERS, TURNS, Pillars
from geosurf.measure.columns import cross_columns

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
    found: np.ndarray = pillars.least_areas()[0].min(axis=0) < LEAST_AREA
    return found


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
    found = np.zeros((ny + 1, nx + 1), dtype=bool)
    found[:-1, 1:-1] |= along_i
    found[1:, 1:-1] |= along_i
    found[1:-1, :-1] |= along_j
    found[1:-1, 1:] |= along_j
    return found


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
        found = cross_columns(
            np.ascontiguousarray(x[:, across]), triangles, place[:, across[:2]].copy(), np.zeros(2)
        )
        gap = found.elevation - place[found.foot, along]

        # the nearest crossing of each node comes last, and is that which stays
        order = np.argsort(-np.abs(gap), kind="stable")
        foot = found.foot[order]
        distance[foot, along] = gap[order]
        nearest = np.zeros((len(j), 3))
        nearest[foot] = normals[found.triangle[order]]
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
    found: np.ndarray = np.logical_or.reduce(parts)
    return found


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
        from scipy.sparse import coo_array
        from scipy.sparse.linalg import splu

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
