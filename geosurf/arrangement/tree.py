"""Find candidate pairs with trees of boxes, built once for each surface.

A lattice is never made a list: the leaves of its tree are blocks of cells. Trees hold world
coordinates, so that they serve every frame.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.threads import check_pairs
from geosurf.kernels.contacts.aligned_grids import aligned_pairs
from geosurf.kernels.contacts.axis_grids import axis_grid_pairs
from geosurf.kernels.lattices.lattice_corners import LARGEST, SMALLEST, build_list_tree, survey_list
from geosurf.kernels.search import tree
from geosurf.kernels.search.tree import N_COL, N_PLACE, N_ROW, triangle_boxes
from geosurf.model import Lattice, TriSurface

_NO_TRIANGLES = np.empty((0, 3), dtype=np.int64)
_NO_ORDER = np.empty(0, dtype=np.int64)
_LISTED = "_listed"
_NEIGHBOURS = 48  # of a triangle in its own surface, seldom more
_ROOM = 1 << 17  # 2 MB: below what the system hands out in huge pages, filled with zeros


@dataclass(frozen=True)
class Tree:
    """Boxes over a surface, and where its coordinates are; see `geosurf.kernels.search.tree`."""

    coordinates: tuple[np.ndarray, np.ndarray, np.ndarray]
    places: np.ndarray
    triangles: np.ndarray
    order: np.ndarray
    nodes: np.ndarray
    levels: np.ndarray

    @property
    def bounds(self) -> np.ndarray:
        """Box around all that the tree holds: lower, then upper corner."""
        return self.nodes[-1]

    def arguments(self) -> tuple:
        """The tree as kernels take it."""
        return (
            *self.coordinates, self.places, self.triangles, self.order, self.nodes, self.levels
        )  # fmt: skip


def tree_of(surface: TriSurface) -> Tree:
    """The tree of a surface, remembered on it; that of a lattice was made while it was surveyed."""
    kept: Tree | None = surface.__dict__.get("_tree")
    if kept is None:
        kept = _list_tree(surface) if surface.lattice is None else tree_of_lattice(surface.lattice)
        surface.__dict__["_tree"] = kept
    return kept


def look_at_list(surface: TriSurface) -> tuple[np.ndarray, float, float]:
    """Rows of triangles that may be flat, and the smallest (not 0) and largest size of a number.

    Boxes and codes, which are found on the way, are kept on the surface until its tree is built.
    """
    boxes, codes, doubted, sizes = survey_list(surface.vertices, surface.triangles)
    surface.__dict__[_LISTED] = boxes, codes
    return doubted, float(sizes[SMALLEST]), float(sizes[LARGEST])


def boxes_of(surface: TriSurface) -> np.ndarray:
    """Boxes of all triangles, row by row, float64 (n_triangle, 6)."""
    if _LISTED in surface.__dict__:
        return surface.__dict__.pop(_LISTED)[0]
    return triangle_boxes(surface.vertices, surface.triangles)


def _list_tree(surface: TriSurface) -> Tree:
    if _LISTED not in surface.__dict__:
        look_at_list(surface)
    boxes, codes = surface.__dict__.pop(_LISTED)
    return tree_of_boxes(surface.vertices, surface.triangles, boxes, codes)


def tree_of_boxes(
    vertices: np.ndarray, triangles: np.ndarray, boxes: np.ndarray, codes: np.ndarray
) -> Tree:
    """A tree over listed triangles with the boxes and codes of `survey_list`."""
    order, nodes, levels = build_list_tree(boxes, codes)

    # The list is one row of nodes in the layout of a lattice: x, y, z are interleaved, with stride
    # 3.
    places = np.zeros(N_PLACE, dtype=np.int64)
    places[:9] = (0, 0, 3, 1, 0, 3, 2, 0, 3)
    places[[N_ROW, N_COL]] = 1, len(vertices)
    flat = vertices.reshape(-1)
    return Tree((flat, flat, flat), places, triangles, order, nodes, levels)


def tree_of_rows(surface: TriSurface, rows: np.ndarray) -> Tree:
    """A tree over some triangles of a list; its keys are places in `rows`."""
    triangles = surface.triangles[rows]
    boxes, codes, _, _ = survey_list(surface.vertices, triangles)
    return tree_of_boxes(surface.vertices, triangles, boxes, codes)


def tree_of_list(vertices: np.ndarray, triangles: np.ndarray) -> Tree:
    """A tree over listed triangles, in the frame of their vertices."""
    boxes, codes, _, _ = survey_list(vertices, triangles)
    return tree_of_boxes(vertices, triangles, boxes, codes)


def tree_of_lattice(lattice: Lattice) -> Tree:
    """The tree over a lattice, which its survey has made."""
    survey = lattice.survey
    given = lattice.coordinates, lattice.places, _NO_TRIANGLES, _NO_ORDER
    return Tree(*given, survey.nodes, survey.levels)


def candidate_pairs(
    one: Tree, two: Tree, *, same: bool = False, room: int = _ROOM
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles that may meet, and what the search cost.

    With more of them than there is `room` for, it is searched twice.

    Returns
    -------
    pairs : ndarray of int64, shape (n_pair, 2)
        Keys of both surfaces (`Lattice.rows_of_keys`). With `same`, the lower key first.
    cost : dict
        Numbers of tree nodes visited and of candidate pairs.
    """
    if len(one.nodes) == 0 or len(two.nodes) == 0:
        return np.empty((0, 2), dtype=np.int64), {"nodes": 0, "pairs": 0}
    given = *one.arguments(), *two.arguments(), same
    return all_pairs(lambda pairs: tree.tree_pairs(*given, pairs), room=room)


def apart(trees: list[Tree]) -> np.ndarray:
    """Which trees' boxes do not meet, bool (n, n): a call for each pair of many costs more."""
    none = np.array([np.inf] * 3 + [-np.inf] * 3)
    boxes = np.array([tree.bounds if len(tree.nodes) else none for tree in trees])
    # Broadcast: lower corner of one box against upper corner of another, on each axis.
    low, high = boxes[:, None, :3], boxes[None, :, 3:]
    beyond = np.logical_not((low <= high).all(axis=2))  # what is not a number reaches nothing
    return beyond | beyond.T


def pairs_of_some(
    surface: TriSurface, whole: Tree, some: np.ndarray
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles of one list, of which one at least is marked in `some`, bool.

    Returns
    -------
    pairs, cost
        As `candidate_pairs` with `same`.
    """
    rows = np.flatnonzero(some)
    if len(rows) == 0:
        return np.empty((0, 2), dtype=np.int64), {"nodes": 0, "pairs": 0}
    part = tree_of_rows(surface, rows)
    pairs, cost = candidate_pairs(part, whole, room=max(_ROOM, _NEIGHBOURS * len(rows)))

    # Rows of the part become rows of the list; a pair of two marked triangles is found twice.
    one, two = rows[pairs[:, 0]], pairs[:, 1]
    once = (one < two) | ((one > two) & ~some[two])  # both may be marked
    one, two = one[once], two[once]
    rows = np.stack([np.minimum(one, two), np.maximum(one, two)], axis=1)
    return rows, {**cost, "pairs": len(rows)}


def all_pairs(
    search: Callable[[np.ndarray], tuple[int, int]], room: int = _ROOM
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs that a kernel finds, and what they cost; TooManyPairs if there is no room for them."""
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
_ULP = 2.0**-52
_MOST = 64  # cells of the straight grid below one of the other; beyond, trees pass by planes


def of_one_map(one: TriSurface, two: TriSurface) -> bool:
    """Whether two surfaces are lattices with the same nodes in the map."""
    return (
        one.lattice is not None and two.lattice is not None and one.lattice.shares_map(two.lattice)
    )


def pairs_of_one_map(
    lattices: tuple[Lattice, Lattice], trees: tuple[Tree, Tree]
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of keys that may meet, and what they cost, as `tree.candidate_pairs` returns them.

    The lattices share their map.
    """
    one, two = lattices
    slip = _SLIP * float(max(np.abs(of.bounds).max() for of in trees))
    sides = [(of.coordinates[2], of.places, of.nodes) for of in trees]
    whole = one.whole and two.whole
    # Cells with holes need another rule. One over the height of a triangle bounds its slope.
    arguments = (*sides[0], *sides[1], trees[0].levels, whole, slip, 1.0 / one.map_height)
    return all_pairs(lambda room: aligned_pairs(*arguments, room))


def needed(one: Lattice, two: Lattice, pairs: np.ndarray) -> np.ndarray:
    """Mask of the pairs (n, 2) of keys, of lattices with one map, that add what no other pair has.

    All pairs with a cell that is not whole; else those above the same triangle of the map, or,
    where diagonals differ, above the same cell.
    """
    whole = (_whole_cells(one) & _whole_cells(two)).ravel()
    cells = pairs >> 1

    # Two keys per cell, so half of the key is the cell; with different diagonals, triangles of one
    # cell overlap on the map.
    above = pairs if one.rising == two.rising else cells
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
    if not any(one.has_rising_axes for one in lattices):
        return False
    if min(len(tree.nodes) for tree in trees) == 0:
        return False

    # `lattice` has straight axes; `other` is any lattice.
    one, two = (0, 1) if lattices[0].has_rising_axes else (1, 0)
    lattice, other = lattices[one], lattices[two]
    bounds = trees[two].bounds
    n_row, n_col = other.shape
    most = _MOST * (n_row - 1) * (n_col - 1)
    # The whole straight grid is small enough.
    if (len(lattice.easting) + 1) * (len(lattice.northing) + 1) <= most:
        return True  # whatever is below

    # Otherwise its cells below the box of the other one count.
    n = 1
    for axis, k in ((lattice.easting, 0), (lattice.northing, 1)):
        low, high = np.searchsorted(axis, bounds[k::3])
        n *= int(high - low) + 1
    return n <= most


def slip_of(trees: tuple[Tree, Tree], origin: np.ndarray) -> float:
    """Rounding in the local frame: half a unit in the last place of the largest difference."""
    start = origin.tolist() * 2
    far = (abs(x - o) for tree in trees for x, o in zip(tree.bounds.tolist(), start, strict=True))
    return _ULP * max(far)


def pairs_of_grids(
    surfaces: tuple[TriSurface, TriSurface], trees: tuple[Tree, Tree], origin: np.ndarray
) -> tuple[np.ndarray, dict[str, int]] | None:
    """Pairs of keys of two grids of like cells, one with straight axes, that may meet, and what
    they cost: numbers of cells asked, and of pairs. None for other surfaces.
    """
    first, second = surfaces[0].lattice, surfaces[1].lattice
    if first is None or second is None or not are_alike((first, second), trees):
        return None

    # The grid with straight axes comes first; rows are swapped back by the kernel.
    swapped = not first.has_rising_axes
    one, two = trees[::-1] if swapped else trees
    sides = [(*of.coordinates, of.places, of.nodes, of.levels) for of in (one, two)]
    slip = slip_of(trees, origin)
    return all_pairs(
        lambda room: axis_grid_pairs(*sides[0], *sides[1], origin, slip, swapped, room)
    )
