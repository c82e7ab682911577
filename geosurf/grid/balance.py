"""Pillars that move a little, so that the blocks of a grid have the volumes of the model.

A grid rounds a block to whole columns: the trace of a fault becomes a polyline through pillars, and
the outline of the model a stair. What a block gains or loses so is the same along each boundary
as a step of all its pillars to one side, by some metres. That step and a tilt are found here, for
each boundary between two blocks, from the differences of volumes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from geosurf.grid.corners import CORNERS
from geosurf.grid.follow import folded, unfolded
from geosurf.grid.pillars import Pillars
from geosurf.model.grids import CornerPointGrid

ROUNDS = 3  # of a new grid
WIDER = 6  # times that more pillars around a cell that is inside out become parallel
ENOUGH = 1e-3  # difference of a region that is left as it is
GOOD = 5e-4  # of the volume of a region: weighs as much as a move by MOVE
MOVE = 0.02  # of a cell
MOST_MOVE = 0.25  # of a cell, of one pillar
HALVINGS = 6  # of moves that fold a cell
FEW = 10.0  # columns: differences of smaller regions weigh less

Faces = list[dict[tuple[int, int], tuple[int, ...]]]


def misfits(grid: CornerPointGrid) -> np.ndarray:
    """Difference of the volume of each region from that of the model, as a share of it.

    Of regions that are smaller than `FEW` columns, as a share of these.
    """
    table = grid.table
    exact, volume = table.exact.values, table.volume.values
    columns = grid.actnum.any(axis=0).sum()
    of_zone = np.array([exact[(table.zone == name).values].sum() for name in table.zone.values])
    found: np.ndarray = (exact - volume) / np.maximum(exact, FEW * of_zone / max(columns, 1))
    return found


def _without_twists(
    gridded: Callable[[Pillars], CornerPointGrid], pillars: Pillars
) -> tuple[Pillars, CornerPointGrid]:
    """Pillars, and the grid between them, whose cells are not inside out.

    In a wedge, one zone may be thin at three pillars of a column while its surfaces are steep, and
    differently so. Where these pillars lean apart, such a cell is inside out at a corner, though
    the pillars do not cross. Parallel pillars cannot do that.
    """
    from scipy.ndimage import binary_dilation

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
    from scipy.ndimage import label

    slope = pillars.slope.copy()
    groups, n = label(columns, structure=np.ones((3, 3)))
    for group in range(1, n + 1):
        wide = np.pad(groups == group, 1)
        nodes = wide[1:, 1:] | wide[1:, :-1] | wide[:-1, 1:] | wide[:-1, :-1]
        slope[nodes] = slope[nodes].mean(axis=0)
    return replace(pillars, slope=slope)


def balanced(
    gridded: Callable[[Pillars], CornerPointGrid],
    pillars: Pillars,
    follows: np.ndarray,
    cell: np.ndarray,
) -> CornerPointGrid:
    """
    Return the grid whose regions are nearest to the volumes of the model.

    Parameters
    ----------
    gridded : callable
        Makes the grid between pillars.
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
    worst = np.abs(misfits(best)).max(initial=0.0)
    for _ in range(ROUNDS):
        if worst <= ENOUGH:
            break
        pillars = _moved(best, pillars, follows, cell)
        grid = gridded(pillars)
        left = np.abs(misfits(grid)).max(initial=0.0)
        if left >= worst or grid.inside_out.any():
            break
        best, worst = grid, left
    return best


def _moved(
    grid: CornerPointGrid, pillars: Pillars, follows: np.ndarray, cell: np.ndarray
) -> Pillars:
    """Pillars that bring the volumes of regions nearer to those of the model."""
    block = _block_of_columns(grid)
    boundaries = _boundaries(block, _faults_of_faces(grid), cell)
    if not boundaries:
        return pillars

    # each boundary has two unknowns: metres to one side, and metres more at the upper end
    ways = []
    for way in boundaries:
        ways.append((way, np.zeros_like(way)))
        tilt = way * (follows / pillars.reach)[..., None]
        if tilt.any():
            ways.append((np.zeros_like(way), tilt))
    weight = misfits(grid), grid.exact
    size = np.where(weight[0] != 0.0, (grid.exact - grid.table.volume.values) / weight[0], 1.0)
    rates = np.stack([_rates(grid, pillars, one, cell) for one in ways], axis=1) / size[:, None]

    # differences of volumes against moves: the smallest sum of squares of both
    rows = np.concatenate([rates / GOOD, np.eye(len(ways)) / (MOVE * float(cell.mean()))])
    goal = np.concatenate([weight[0] / GOOD, np.zeros(len(ways))])
    step = np.linalg.lstsq(rows, goal, rcond=None)[0]
    shift = sum((s * one[0] for s, one in zip(step, ways, strict=True)), np.zeros_like(ways[0][0]))
    slope = sum((s * one[1] for s, one in zip(step, ways, strict=True)), np.zeros_like(shift))
    most = float((np.abs(shift) + np.abs(slope) * pillars.reach[..., None]).max())
    share = min(1.0, MOST_MOVE / most) if most else 0.0
    for _ in range(HALVINGS):
        moved = replace(
            pillars, shift=pillars.shift + share * shift, slope=pillars.slope + share * slope
        )
        moved = unfolded(moved)
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


def _faults_of_faces(grid: CornerPointGrid) -> Faces:
    """Faults between columns, by J and I of the first one, for both axes."""
    found: Faces = [{}, {}, {}]
    faces = grid.faces
    for fault, axis, (i, j) in zip(
        faces.fault.tolist(), faces.axis.tolist(), faces.column.tolist(), strict=True
    ):
        before = found[axis].get((j, i), ())
        found[axis][j, i] = before if fault in before else (*before, fault)
    return found


def _boundaries(block: np.ndarray, faults: Faces, cell: np.ndarray) -> list[np.ndarray]:
    """Moves by one metre of the pillars of each boundary, each (ny + 1, nx + 1, 2) [cells / m].

    A boundary has the same two blocks on its sides, and the same faults.
    """
    found: dict[tuple[int, ...], np.ndarray] = {}
    ny, nx = block.shape
    for axis in range(2):
        n = (slice(None), slice(-1)) if axis == 0 else (slice(-1), slice(None))
        m = (slice(None), slice(1, None)) if axis == 0 else (slice(1, None), slice(None))
        a, b = block[n], block[m]
        for j, i in np.argwhere(a != b).tolist():
            ends = (int(a[j, i]), int(b[j, i]))
            key = (*sorted(ends), *faults[axis].get((j, i), ()))
            way = found.setdefault(key, np.zeros((ny + 1, nx + 1, 2)))
            up = 1.0 if ends[0] < ends[1] else -1.0
            nodes = ((j, i + 1), (j + 1, i + 1)) if axis == 0 else ((j + 1, i), (j + 1, i + 1))
            for node in nodes:
                way[(*node, axis)] += up * cell[1 - axis]
    for way in found.values():
        # on the rim along the rim; one metre long
        way[:, [0, -1], 0] = 0.0
        way[[0, -1], :, 1] = 0.0
        length = np.hypot(way[..., 0], way[..., 1])[..., None]
        way /= np.where(length > 0.0, length, 1.0) * cell
    return [way for way in found.values() if way.any()]


def _rates(
    grid: CornerPointGrid, pillars: Pillars, way: tuple[np.ndarray, np.ndarray], cell: np.ndarray
) -> np.ndarray:
    """Change of the volume of each region for a unit of a move, (n_region,) [m3]."""
    shift, slope = way
    j, i = np.nonzero((shift != 0.0).any(axis=-1) | (slope != 0.0).any(axis=-1))
    ny, nx = grid.shape[1:]
    out = np.zeros(len(grid.region_names))
    node = np.stack(np.meshgrid(np.arange(nx + 1), np.arange(ny + 1)), axis=-1)
    for m, k in CORNERS:
        # the columns of which these nodes are the corner m, k
        jj, ii = j - m, i - k
        here = (jj >= 0) & (jj < ny) & (ii >= 0) & (ii < nx)
        jj, ii, at = jj[here], ii[here], (j[here], i[here])
        z = grid.levels[:, jj, ii].mean(axis=(-1, -2))
        thick, middle = -np.diff(z, axis=0), 0.5 * (z[1:] + z[:-1])
        up = middle - pillars.level[at]

        # the area of a quadrilateral changes by half the diagonal across the moved corner
        before, after = ((jj + m, ii + 1 - k), (jj + 1 - m, ii + k))
        turn = 1.0 if m == k else -1.0
        across = (
            turn * 0.5 * ((node + pillars.shift)[before] - (node + pillars.shift)[after])
            + turn * 0.5 * (pillars.slope[before] - pillars.slope[after]) * up[..., None]
        )
        move = shift[at] + slope[at] * up[..., None]
        area = (across[..., 1] * move[..., 0] - across[..., 0] * move[..., 1]) * cell.prod()
        region = grid.region[:, jj, ii]
        live = region >= 0
        out += np.bincount(region[live], (area * thick)[live], minlength=len(out))
    return out
