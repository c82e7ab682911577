"""Find candidate pairs of grids that stay in their store: only tiles that may meet are read.

A tile is a chunk with the cells that join it to the chunks before it. Each is searched as a lattice
of its own. Its keys become those of the whole grid: points have the same names as in memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.arrangement import tree
from geosurf.arrangement.tree import Tree
from geosurf.model import TriSurface
from geosurf.model.chunked import ChunkedLattice, part_of

BLOCK = 64  # cells along a side of a block
_AT_ONCE = 1 << 20  # comparisons of boxes
_FEW = 512  # triangles of a list whose planes are asked
_SLACK = 1e-12  # thousands of roundings
Window = tuple[tuple[int, int], tuple[int, int]]
Found = tuple[np.ndarray, dict[str, int]]
Search = Callable[[tuple[TriSurface, TriSurface], tuple[Tree, Tree]], Found]


def is_chunked(surface: TriSurface) -> bool:
    """Whether the elevations of a surface stay in a store."""
    return isinstance(surface.lattice, ChunkedLattice)


def pairs_by_tiles(
    surfaces: tuple[TriSurface, TriSurface],
    trees: tuple[Tree, Tree],
    one_map: bool,
    search: Search,
) -> Found:
    """Candidate pairs of two surfaces, of which one at least stays in its store, and their cost.

    Parameters
    ----------
    surfaces, trees
        Of a chunked lattice the tree is its box.
    one_map : bool
        Whether they are lattices with the same nodes in the map.
    search : callable
        (surfaces, trees) -> pairs and cost of two surfaces in memory.
    """
    found: list[np.ndarray] = []
    cost = {"nodes": 0, "pairs": 0}
    for windows in _windows(surfaces, trees, one_map):
        parts = [_part(one, at) for one, at in zip(surfaces, windows, strict=True)]
        both = parts[0], parts[1]
        rows, spent = search(both, (tree.tree_of(parts[0]), tree.tree_of(parts[1])))
        for key, value in spent.items():
            cost[key] = cost.get(key, 0) + value
        if len(rows) == 0:
            continue
        rows = rows.copy()
        for k, (surface, at) in enumerate(zip(surfaces, windows, strict=True)):
            if at is not None:
                rows[:, k] = _as_whole(surface, parts[k], rows[:, k], at)
        found.append(rows)
    if not found:
        return np.empty((0, 2), dtype=np.int64), cost
    return _joined(found), cost


def _joined(found: list[np.ndarray]) -> np.ndarray:
    """All rows in one table; those of two columns leave the contact open."""
    from geosurf.kernels.contacts.axis_grids import NEEDS_EXACT

    n = max(rows.shape[1] for rows in found)
    table = np.full((sum(map(len, found)), n), NEEDS_EXACT, dtype=np.int64)
    start = 0
    for rows in found:
        table[start : start + len(rows), : rows.shape[1]] = rows
        start += len(rows)
    return table


@dataclass(frozen=True)
class Hull:
    """What holds a surface: boxes (n, 6), and planes through what is in them, if that is known.

    A plane is a point (n, 3), a normal (n, 3) of any length, and the size of its terms (n,), which
    bounds its rounding error.
    """

    boxes: np.ndarray
    planes: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def only(self, some: np.ndarray) -> Hull:
        """Some of the boxes."""
        planes = self.planes and (self.planes[0][some], self.planes[1][some], self.planes[2][some])
        return Hull(self.boxes[some], planes)

    def widened(self, slip: float) -> Hull:
        """The same with wider boxes; planes pass near what is in them anyway."""
        return Hull(self.boxes + np.repeat([-slip, slip], 3), self.planes)


def _windows(
    surfaces: tuple[TriSurface, TriSurface], trees: tuple[Tree, Tree], one_map: bool
) -> Iterator[tuple[Window | None, Window | None]]:
    """Windows of both surfaces that may meet; None for a surface as a whole."""
    lattices: list[Any] = [one.lattice for one in surfaces]
    chunked = [is_chunked(one) for one in surfaces]
    k = 0 if chunked[0] else 1
    if all(chunked) and not one_map:
        one, two = lattices
        for (i, j), at in tiles_near(one, Hull(two.bounds.boxes)):
            for _, other in tiles_near(two, Hull(blocks_of(one, i, j))):
                yield at, other
        return
    for _, at in tiles_near(lattices[k], hull_of(surfaces[1 - k], trees[1 - k])):
        # of one map equal windows: cells of other places in the map have nothing to add
        if one_map:
            yield at, at
        else:
            yield (at, None) if k == 0 else (None, at)


def hull_of(surface: TriSurface, whole: Tree) -> Hull:
    """Boxes that hold a surface; of few triangles their planes, too, since these may be long."""
    if isinstance(surface.lattice, ChunkedLattice):
        return Hull(surface.lattice.bounds.blocks)
    if surface.lattice is None and surface.n_triangle <= _FEW:
        a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
        corners = np.stack([a, b, c])
        boxes = np.concatenate([corners.min(axis=0), corners.max(axis=0)], axis=1)
        size = np.linalg.norm(b - a, axis=1) * np.linalg.norm(c - a, axis=1)
        return Hull(boxes, (a, np.cross(b - a, c - a), size))
    nodes, levels = whole.top()
    start, n_row, n_col = levels[0, :3].tolist()
    return Hull(nodes[start : start + n_row * n_col])


def tiles_near(lattice: ChunkedLattice, hull: Hull) -> Iterator[tuple[tuple[int, int], Window]]:
    """Tiles of which a block meets a hull, each with a window around such blocks."""
    hull = hull.only(_overlap(hull.boxes, lattice.survey.box))
    for tile in np.flatnonzero(_meet_any(lattice.bounds.boxes, hull)).tolist():
        i, j = divmod(tile, lattice.tile_shape[1])
        rows, cols = lattice.store.tile(i, j)
        if rows[1] - rows[0] < 2 or cols[1] - cols[0] < 2:
            continue  # no cell: its nodes are in the next tile, too
        near = hull.only(_overlap(hull.boxes, lattice.bounds.boxes[tile]))
        met = _meet_any(blocks_of(lattice, i, j), near)
        if met.any():
            yield (i, j), _around(np.flatnonzero(met), len(met), rows, cols)


def _around(
    blocks: np.ndarray, n_block: int, rows: tuple[int, int], cols: tuple[int, int]
) -> Window:
    """The rows and columns of a tile around some of its blocks; of a single block, all."""
    n_row, n_col = (-(-(last - first - 1) // BLOCK) for first, last in (rows, cols))
    if n_block != n_row * n_col:
        return rows, cols  # a small tile is one block
    i, j = np.divmod(blocks, n_col)
    found = [
        (first + BLOCK * int(k.min()), min(first + BLOCK * (int(k.max()) + 1) + 1, last))
        for k, (first, last) in ((i, rows), (j, cols))
    ]
    return found[0], found[1]


def blocks_of(lattice: ChunkedLattice, i: int, j: int) -> np.ndarray:
    """Boxes around blocks of cells of a tile."""
    tile = i * lattice.tile_shape[1] + j
    start, stop = lattice.bounds.starts[tile : tile + 2].tolist()
    return lattice.bounds.blocks[start:stop]


def _overlap(boxes: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Which boxes (n, 6) meet one box, bool (n,)."""
    marks: np.ndarray = (boxes[:, :3] <= box[3:]) & (boxes[:, 3:] >= box[:3])
    return marks[:, 0] & marks[:, 1] & marks[:, 2]


def _meet_any(some: np.ndarray, hull: Hull) -> np.ndarray:
    """Which boxes (n, 6) may meet a hull, bool (n,)."""
    met = np.zeros(len(some), dtype=bool)
    step = max(_AT_ONCE // max(len(hull.boxes), 1), 1)
    for first in range(0, len(some), step):
        part = some[first : first + step]
        near = np.ones((len(part), len(hull.boxes)), dtype=bool)
        for k in range(3):
            near &= part[:, None, k] <= hull.boxes[None, :, k + 3]
            near &= part[:, None, k + 3] >= hull.boxes[None, :, k]
        if hull.planes is not None:
            with np.errstate(invalid="ignore"):  # boxes around no node are inside out
                near &= _reaches_planes(part, *hull.planes)
        met[first : first + step] = near.any(axis=1)
    return met


def _reaches_planes(
    boxes: np.ndarray, points: np.ndarray, normals: np.ndarray, sizes: np.ndarray
) -> np.ndarray:
    """Which boxes (n, 6) may meet which planes, bool (n, m); True where rounding leaves doubt."""
    # the box has both signs of the normal's product, or one within its rounding error
    middle, half = 0.5 * (boxes[:, :3] + boxes[:, 3:]), 0.5 * (boxes[:, 3:] - boxes[:, :3])
    way = np.zeros((len(boxes), len(points)))
    reach, far = np.zeros_like(way), np.zeros_like(way)
    for k in range(3):
        off = middle[:, None, k] - points[None, :, k]
        way += off * normals[None, :, k]
        reach += half[:, None, k] * np.abs(normals[None, :, k])
        far += np.abs(middle[:, None, k]) + np.abs(points[None, :, k]) + half[:, None, k]
    met: np.ndarray = np.less_equal(np.abs(way), reach + _SLACK * sizes[None, :] * far)
    return met


def _part(surface: TriSurface, at: Window | None) -> TriSurface:
    """A window of a surface in memory, or the surface as it is."""
    if at is None:
        return surface
    assert surface.lattice is not None  # only lattices have windows
    return TriSurface(surface.name, surface.role, lattice=part_of(surface.lattice, *at))


def _as_whole(surface: TriSurface, part: TriSurface, keys: np.ndarray, at: Window) -> np.ndarray:
    """Keys of a window as keys of the whole lattice, which remembers their nodes."""
    whole, lattice = surface.lattice, part.lattice
    assert whole is not None
    assert lattice is not None
    (first, _), (left, _) = at
    if isinstance(whole, ChunkedLattice):
        nodes = np.unique(lattice.corners_of_keys(np.unique(keys)))
        row, col = np.divmod(nodes, lattice.shape[1])
        known = (row + first) * whole.shape[1] + col + left
        whole.remember(known, whole.values_at(lattice, nodes))
    row, col = np.divmod(keys >> 1, lattice.shape[1] - 1)
    cells = (row + first) * (whole.shape[1] - 1) + col + left
    moved: np.ndarray = 2 * cells + (keys & 1)
    return moved


__all__ = ["Hull", "blocks_of", "hull_of", "is_chunked", "pairs_by_tiles", "tiles_near"]
