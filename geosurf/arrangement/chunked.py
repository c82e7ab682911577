"""Find candidate pairs of grids that stay in their store: only tiles that may meet are read.

A tile is a chunk with the cells that join it to the chunks before it. Each is searched as a lattice
of its own. Its keys become those of the whole grid: points have the same names as in memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from geosurf.arrangement import tree
from geosurf.arrangement.tree import Tree
from geosurf.model import Lattice, TriSurface
from geosurf.model.chunked import ChunkedLattice, part_of

_AT_ONCE = 1 << 22  # comparisons of boxes
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


def _windows(
    surfaces: tuple[TriSurface, TriSurface], trees: tuple[Tree, Tree], one_map: bool
) -> Iterator[tuple[Window | None, Window | None]]:
    """Windows of both surfaces that may meet; None for a surface as a whole."""
    lattices: list[Any] = [one.lattice for one in surfaces]
    chunked = [is_chunked(one) for one in surfaces]
    if one_map:
        # equal windows of both: cells of other places in the map have nothing to add
        k = 0 if chunked[0] else 1
        for i, j in _tiles_near(lattices[k], _boxes(lattices[1 - k], trees[1 - k])):
            at = lattices[k].store.tile(i, j)
            yield at, at
        return
    if all(chunked):
        one, two = lattices
        for i, j in _tiles_near(one, two.bounds.boxes):
            own = _blocks_of(one, i, j)
            for p, q in _tiles_near(two, own):
                yield one.store.tile(i, j), two.store.tile(p, q)
        return
    k = 0 if chunked[0] else 1
    for i, j in _tiles_near(lattices[k], _boxes(lattices[1 - k], trees[1 - k])):
        at = lattices[k].store.tile(i, j)
        yield (at, None) if k == 0 else (None, at)


def _boxes(lattice: Lattice | None, whole: Tree) -> np.ndarray:
    """Boxes that hold a surface, float64 (n, 6)."""
    if isinstance(lattice, ChunkedLattice):
        return lattice.bounds.blocks
    nodes, levels = whole.top()
    start, n_row, n_col = levels[0, :3].tolist()
    return nodes[start : start + n_row * n_col]


def _tiles_near(lattice: ChunkedLattice, boxes: np.ndarray) -> list[tuple[int, int]]:
    """Tiles of which a block meets one of some boxes."""
    low, high = lattice.survey.box[:3], lattice.survey.box[3:]
    boxes = boxes[((boxes[:, :3] <= high) & (boxes[:, 3:] >= low)).all(axis=1)]
    found = []
    tiles = np.flatnonzero(_meet_any(lattice.bounds.boxes, boxes))
    for tile in tiles.tolist():
        i, j = divmod(tile, lattice.tile_shape[1])
        rows, cols = lattice.store.tile(i, j)
        if rows[1] - rows[0] < 2 or cols[1] - cols[0] < 2:
            continue  # no cell: its nodes are in the next tile, too
        box = lattice.bounds.boxes[tile]
        near = boxes[((boxes[:, :3] <= box[3:]) & (boxes[:, 3:] >= box[:3])).all(axis=1)]
        if _meet_any(_blocks_of(lattice, i, j), near).any():
            found.append((i, j))
    return found


def _blocks_of(lattice: ChunkedLattice, i: int, j: int) -> np.ndarray:
    """Boxes around blocks of cells of a tile."""
    tile = i * lattice.tile_shape[1] + j
    start, stop = lattice.bounds.starts[tile : tile + 2].tolist()
    return lattice.bounds.blocks[start:stop]


def _meet_any(some: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Which boxes (n, 6) meet one of some others at least, bool (n,)."""
    met = np.zeros(len(some), dtype=bool)
    step = max(_AT_ONCE // max(len(others), 1), 1)
    for first in range(0, len(some), step):
        part = some[first : first + step]
        near = np.ones((len(part), len(others)), dtype=bool)
        for k in range(3):
            near &= part[:, None, k] <= others[None, :, k + 3]
            near &= part[:, None, k + 3] >= others[None, :, k]
        met[first : first + step] = near.any(axis=1)
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
        whole.remember(known, lattice.elevation[row, col])
    row, col = np.divmod(keys >> 1, lattice.shape[1] - 1)
    cells = (row + first) * (whole.shape[1] - 1) + col + left
    moved: np.ndarray = 2 * cells + (keys & 1)
    return moved


__all__ = ["is_chunked", "pairs_by_tiles"]
