"""Find candidate pairs with trees of boxes, built once for each surface.

A lattice is never made a list: the leaves of its tree are blocks of cells. Trees hold world
coordinates, so that they serve every frame.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.memory_limit import check_pairs
from geosurf.kernels.lattices.triangle_list import LARGEST, SMALLEST, build_list_tree, survey_list
from geosurf.kernels.search import tree
from geosurf.kernels.search.tree import IS_LATTICE, N_COL, N_PLACE, N_ROW
from geosurf.kernels.search.voxels import triangle_boxes
from geosurf.model import Lattice, TriSurface

_NO_TRIANGLES = np.empty((0, 3), dtype=np.int64)
_NO_ORDER = np.empty(0, dtype=np.int64)
_LISTED = "_listed"
_NEIGHBOURS = 48  # of a triangle in its own surface, seldom more
_ROOM = 1 << 17  # 2 MB: below what the system hands out in huge pages, filled with zeros
_FINE = 1 << 12  # cells or triangles of a small tree, which faults usually have


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

    @property
    def is_small(self) -> bool:
        """Whether it has few cells or triangles."""
        if self.places[IS_LATTICE]:
            return bool((self.places[N_ROW] - 1) * (self.places[N_COL] - 1) <= _FINE)
        return len(self.order) <= _FINE

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
    search: Callable[[np.ndarray], tuple[int, int]], n_column: int = 2, room: int = _ROOM
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs that a kernel finds, and what they cost; TooManyPairs if there is no room for them."""
    # The search counts on when `pairs` is full, so a second call has enough room.
    pairs = np.empty((room, n_column), dtype=np.int64)
    while True:
        n, visited = search(pairs)
        if n <= len(pairs):
            break
        check_pairs(n)
        pairs = np.empty((n, n_column), dtype=np.int64)

    # A copy, so that the large buffer is freed.
    if n < len(pairs):
        pairs = pairs[:n].copy()
    return pairs, {"nodes": visited, "pairs": n}
