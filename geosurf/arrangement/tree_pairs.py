"""Pairs of triangles of two surfaces that may meet: from their trees; of two grids directly."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np

from geosurf.arrangement.threads import check_pairs
from geosurf.arrangement.trees import AnyTree, Tree
from geosurf.kernels.contacts.aligned_grids import aligned_pairs
from geosurf.kernels.contacts.axis_grids import axis_grid_pairs
from geosurf.kernels.search.tree import tree_pairs
from geosurf.model import Lattice

ULP = 2.0**-52
ROOM = 1 << 17  # 2 MB: below what the system hands out in huge pages, filled with zeros


def apart(trees: Sequence[AnyTree]) -> np.ndarray:
    """Which trees' boxes do not meet, bool (n, n): a call for each pair of many costs more."""
    none = np.array([np.inf] * 3 + [-np.inf] * 3)
    boxes = np.array([tree.bounds if len(tree.nodes) else none for tree in trees])
    # Broadcast: lower corner of one box against upper corner of another, on each axis.
    low, high = boxes[:, None, :3], boxes[None, :, 3:]
    beyond = np.logical_not((low <= high).all(axis=2))  # what is not a number reaches nothing
    return beyond | beyond.T


def pairs_of_two(
    lattices: tuple[Lattice | None, Lattice | None],
    trees: tuple[AnyTree, AnyTree],
    origin: np.ndarray,
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of keys of two surfaces that may meet, and what they cost.

    Parameters
    ----------
    lattices : (Lattice or None, Lattice or None)
        Of the surfaces, where they are lattices.
    trees : (Tree or TornTree, Tree or TornTree)
    origin : ndarray, shape (3,)
        Of the local frame [m].
    """
    first, second = lattices
    if first is not None and second is not None:
        lattice_trees: Any = trees
        if first.shares_map(second):
            return pairs_of_one_map((first, second), lattice_trees)
        if are_alike((first, second), lattice_trees):
            return pairs_of_grids((first, second), lattice_trees, origin)
    return candidate_pairs(*trees)


def candidate_pairs(
    first: AnyTree, second: AnyTree, *, same: bool = False, room: int = ROOM
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles that may meet, and what the search cost.

    With more of them than there is `room` for, it is searched twice.

    Returns
    -------
    pairs : ndarray of int64, shape (n_pair, 2)
        Keys of both surfaces (`Lattice.rows_of_keys`); of a torn sheet rows. With `same`, which is
        for one tree, the lower key first.
    cost : dict
        Numbers of tree nodes visited and of candidate pairs.
    """
    if isinstance(first, Tree) and isinstance(second, Tree):
        return _pairs_of_trees(first, second, same, room)
    every, cost = [], {"nodes": 0, "pairs": 0}
    for (part, rows_of), (other, other_rows_of) in product(_parts(first), _parts(second)):
        pairs, spent = _pairs_of_trees(part, other, False, room)
        exist = np.ones(len(pairs), dtype=bool)
        for column, translate in enumerate((rows_of, other_rows_of)):
            if translate is not None:
                pairs[:, column], there = translate(pairs[:, column])
                exist &= there
        every.append(pairs[exist])
        cost["nodes"] += spent["nodes"]
        cost["pairs"] += len(every[-1])
    return np.concatenate(every), cost


def _parts(tree: AnyTree) -> list[tuple[Tree, Callable | None]]:
    """The trees that a tree consists of, and what makes rows of their keys."""
    if isinstance(tree, Tree):
        return [(tree, None)]
    return [(tree.lattice, tree.rows_of_lattice), (tree.copies, tree.rows_of_copies)]


def _pairs_of_trees(
    first: Tree, second: Tree, same: bool, room: int
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of keys of two trees, and what they cost."""
    if len(first.nodes) == 0 or len(second.nodes) == 0:
        return np.empty((0, 2), dtype=np.int64), {"nodes": 0, "pairs": 0}
    sides = *first.arguments(), *second.arguments(), same
    return all_pairs(lambda pairs: tree_pairs(*sides, pairs), room)


def all_pairs(
    search: Callable[[np.ndarray], tuple[int, int]], room: int = ROOM
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs that a kernel finds, and what they cost; TooManyPairs if memory cannot hold them."""
    # The search counts on when `pairs` is full, so a second call has enough room.
    pairs = np.empty((room, 2), dtype=np.int64)
    while True:
        n, visited = search(pairs)
        if n <= len(pairs):
            break
        check_pairs(n)
        pairs = np.empty((n, 2), dtype=np.int64)

    # A copy, so that the large buffer is freed.
    if n < len(pairs):
        pairs = pairs[:n].copy()
    return pairs, {"nodes": visited, "pairs": n}


# ---- lattice pairs ----------------------------------------
# Find candidate pairs of two grids: of one survey, or one with straight axes and any other.
#
# Lattices of one survey have common nodes on the map. What two triangles share above an edge or a
# corner of the map only, the triangles above the cells on either side share as well. So between
# whole cells only what lies above one triangle is a candidate, whatever the method of search
# (`needed`), and can be listed without a walk (`pairs_of_one_map`). Four horizons of Drogon: 14
# 000 pairs in place of 340 000.
#
# Of other grids, the cells of one with straight axes below a cell of the other are found directly.


_SLIP = 2.0**-48  # of the largest coordinate; above what rounding in any frame moves
_MOST_CELLS = 64  # cells of the straight grid below one of the other; beyond, trees pass by planes


def pairs_of_one_map(
    lattices: tuple[Lattice, Lattice], trees: tuple[Tree, Tree]
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of keys of lattices that share their map, as `candidate_pairs` returns them."""
    slip = _SLIP * float(max(np.abs(tree.bounds).max() for tree in trees))
    first, second = ((tree.coordinates[2], tree.places, tree.nodes) for tree in trees)
    # Cells with holes need another rule. One over the height of a triangle bounds its slope.
    whole = lattices[0].whole and lattices[1].whole
    arguments = (*first, *second, trees[0].levels, whole, slip, 1.0 / lattices[0].map_height)
    return all_pairs(lambda room: aligned_pairs(*arguments, room))


def needed(first: Lattice, second: Lattice, pairs: np.ndarray) -> np.ndarray:
    """Mask of the pairs (n, 2) of keys, of lattices with one map, that add what no other pair has.

    All pairs with a cell that is not whole; else those above the same triangle of the map, or,
    where diagonals differ, above the same cell.
    """
    whole = (_whole_cells(first) & _whole_cells(second)).ravel()
    cells = pairs >> 1

    # Two keys per cell, so half of the key is the cell; with different diagonals, triangles of one
    # cell overlap on the map.
    above = pairs if first.rising == second.rising else cells
    mask: np.ndarray = ~whole[cells].all(axis=1) | (above[:, 0] == above[:, 1])
    return mask


def _whole_cells(lattice: Lattice) -> np.ndarray:
    """Mask (n_row - 1, n_col - 1) of the cells with four nodes."""
    p = lattice.present
    mask: np.ndarray = p[:-1, :-1] & p[:-1, 1:] & p[1:, :-1] & p[1:, 1:]
    return mask


def are_alike(lattices: tuple[Lattice, Lattice], trees: tuple[Tree, Tree]) -> bool:
    """Whether one of two grids has rising axes, and their cells are of like sizes.

    A huge flat cell lies above half a horizon: trees test its plane against their boxes.
    """
    if not any(lattice.has_rising_axes for lattice in lattices):
        return False
    if min(len(tree.nodes) for tree in trees) == 0:
        return False

    # `lattice` has straight axes; the other one is any lattice.
    one, two = (0, 1) if lattices[0].has_rising_axes else (1, 0)
    lattice, bounds = lattices[one], trees[two].bounds
    n_row, n_col = lattices[two].shape
    most = _MOST_CELLS * (n_row - 1) * (n_col - 1)
    # The whole straight grid is small enough.
    if (len(lattice.easting) + 1) * (len(lattice.northing) + 1) <= most:
        return True  # whatever is below

    # Otherwise its cells below the box of the other one count.
    n = 1
    for axis, k in ((lattice.easting, 0), (lattice.northing, 1)):
        low, high = np.searchsorted(axis, bounds[k::3])
        n *= int(high - low) + 1
    return n <= most


def pairs_of_grids(
    lattices: tuple[Lattice, Lattice], trees: tuple[Tree, Tree], origin: np.ndarray
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of keys of two grids of like cells that may meet, and what they cost: numbers of cells
    asked, and of pairs.
    """
    # The grid with straight axes comes first; rows are swapped back by the kernel.
    swapped = not lattices[0].has_rising_axes
    first, second = trees[::-1] if swapped else trees

    # rounding in the local frame: half a unit in the last place of the largest difference
    corner = np.tile(origin, 2)
    slip = ULP * float(max(np.abs(tree.bounds - corner).max() for tree in trees))
    sides = [(*tree.coordinates, tree.places, tree.nodes, tree.levels) for tree in (first, second)]
    return all_pairs(
        lambda room: axis_grid_pairs(*sides[0], *sides[1], origin, slip, swapped, room)
    )
