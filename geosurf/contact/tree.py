"""Broad phase by trees of boxes: built once for a surface, walked for every pair.

A lattice is never made a list: the leaves of its tree are blocks of cells, and where only a part
of it can meet the other surface, only that part is looked at. Trees hold world coordinates, so
that they serve every frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.kernels import tree
from geosurf.kernels.listed import LARGEST, SMALLEST, build_list_tree, survey_list
from geosurf.kernels.survey import build_tree_of_blocks
from geosurf.kernels.tree import BLOCK, FIRST_COL, FIRST_ROW, N_COL, N_PLACE, N_ROW
from geosurf.kernels.voxels import triangle_boxes
from geosurf.model import Lattice, TriSurface

_NO_TRIANGLES = np.empty((0, 3), dtype=np.int64)
_NO_ORDER = np.empty(0, dtype=np.int64)
_LISTED = "_listed"
_NEIGHBOURS = 48  # of a triangle in its own surface, seldom more
_ROOM = 1 << 17  # 2 MB: below what the system hands out in huge pages, filled with zeros


@dataclass(frozen=True)
class Tree:
    """Boxes over a surface, and where its coordinates are; see `geosurf.kernels.tree`."""

    coordinates: tuple[np.ndarray, np.ndarray, np.ndarray]
    places: np.ndarray
    triangles: np.ndarray
    order: np.ndarray
    nodes: np.ndarray
    levels: np.ndarray
    window: tuple[int, int, int, int] | None = None

    @property
    def bounds(self) -> np.ndarray:
        """Box around all that the tree holds: lower, then upper corner."""
        return self.nodes[-1]

    def arguments(self) -> tuple:
        """The tree as kernels take it."""
        return (
            *self.coordinates, self.places, self.triangles, self.order, self.nodes, self.levels
        )  # fmt: skip


def tree_of(surface: TriSurface, reach: np.ndarray | None = None) -> Tree:
    """The tree of a surface, remembered on it.

    Parameters
    ----------
    surface : TriSurface
    reach : ndarray of float64, shape (6,), optional
        Box that matters; a lattice is looked at only there. A second question
        beyond it builds the whole tree.
    """
    kept = surface.__dict__.get("_tree")
    if surface.lattice is None:
        if kept is None:
            kept = surface.__dict__["_tree"] = _list_tree(surface)
        return kept
    wanted = _window(surface.lattice, None if kept is not None else reach)
    if kept is not None and _covers(kept.window, _window(surface.lattice, reach)):
        return kept
    built = surface.__dict__["_tree"] = _lattice_tree(surface.lattice, wanted)
    return built


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
    return _tree_of_list(surface.vertices, surface.triangles, boxes, codes)


def _tree_of_list(vertices: np.ndarray, triangles: np.ndarray, boxes, codes) -> Tree:
    order, nodes, levels = build_list_tree(boxes, codes)
    places = np.zeros(N_PLACE, dtype=np.int64)
    places[:9] = (0, 0, 3, 1, 0, 3, 2, 0, 3)
    places[[N_ROW, N_COL]] = 1, len(vertices)
    flat = vertices.reshape(-1)
    return Tree((flat, flat, flat), places, triangles, order, nodes, levels)


def _window(lattice: Lattice, reach: np.ndarray | None) -> tuple[int, int, int, int]:
    """First and last row and column of blocks that can reach a box (the last ones excluded)."""
    n_row, n_col = (max(n - 1, 0) for n in lattice.shape)
    rows, cols = (0, n_row), (0, n_col)
    if reach is not None and lattice.easting.ndim == 1:
        cols = _cells_between(lattice.easting, reach[0], reach[3])
        rows = _cells_between(lattice.northing, reach[1], reach[4])
    return (rows[0] // BLOCK, -(-rows[1] // BLOCK), cols[0] // BLOCK, -(-cols[1] // BLOCK))


def _cells_between(axis: np.ndarray, low: float, high: float) -> tuple[int, int]:
    """Cells of a rising or falling axis that reach an interval: first, and last + 1."""
    if len(axis) < 2:
        return 0, 0
    lower, upper = np.minimum(axis[1:], axis[:-1]), np.maximum(axis[1:], axis[:-1])
    inside = np.flatnonzero((upper >= low) & (lower <= high))
    return (int(inside[0]), int(inside[-1]) + 1) if len(inside) else (0, 0)


def _covers(outer: tuple[int, int, int, int], inner: tuple[int, int, int, int]) -> bool:
    """Whether one window holds another."""
    if inner[0] >= inner[1] or inner[2] >= inner[3]:
        return True
    return (
        outer[0] <= inner[0]
        and inner[1] <= outer[1]
        and outer[2] <= inner[2]
        and inner[3] <= outer[3]
    )


def _lattice_tree(lattice: Lattice, window: tuple[int, int, int, int]) -> Tree:
    places = lattice.places.copy()
    places[[FIRST_ROW, FIRST_COL]] = window[0], window[2]
    survey = lattice.survey
    first_row, last_row, first_col, last_col = window
    nodes, levels = build_tree_of_blocks(
        survey.boxes, survey.n_block_col, first_row, last_row, first_col, last_col
    )
    return Tree(lattice.coordinates, places, _NO_TRIANGLES, _NO_ORDER, nodes, levels, window)


def candidate_pairs(one: Tree, two: Tree, *, same: bool = False, room: int = _ROOM):
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
    low, high = boxes[:, None, :3], boxes[None, :, 3:]
    beyond: np.ndarray = ~(low <= high).all(axis=2)  # what is not a number reaches nothing
    return beyond | beyond.T


def pairs_of_some(surface: TriSurface, whole: Tree, some: np.ndarray):
    """Pairs of triangles of one list, of which one at least is marked in `some`, bool.

    Returns
    -------
    pairs, cost
        As `candidate_pairs` with `same`.
    """
    rows = np.flatnonzero(some)
    if len(rows) == 0:
        return np.empty((0, 2), dtype=np.int64), {"nodes": 0, "pairs": 0}
    triangles = surface.triangles[rows]
    boxes, codes, _, _ = survey_list(surface.vertices, triangles)
    part = _tree_of_list(surface.vertices, triangles, boxes, codes)
    pairs, cost = candidate_pairs(part, whole, room=max(_ROOM, _NEIGHBOURS * len(rows)))
    one, two = rows[pairs[:, 0]], pairs[:, 1]
    once = (one < two) | ((one > two) & ~some[two])  # both may be marked
    one, two = one[once], two[once]
    rows = np.stack([np.minimum(one, two), np.maximum(one, two)], axis=1)
    return rows, {**cost, "pairs": len(rows)}


def all_pairs(search, n_column: int = 2, room: int = _ROOM):
    """Pairs that a kernel finds, however many, and what they cost."""
    pairs = np.empty((room, n_column), dtype=np.int64)
    while True:
        n, visited = search(pairs)
        if n <= len(pairs):
            break
        pairs = np.empty((n, n_column), dtype=np.int64)
    return pairs[:n].copy(), {"nodes": visited, "pairs": n}


def trees_for(surfaces, pairs) -> list[Tree]:
    """A tree for each surface; of one pair, the second to be built is looked at only where it
    can meet the first.
    """
    if len(pairs) != 1 or pairs[0][0] == pairs[0][1]:
        return [tree_of(surface) for surface in surfaces]
    i, j = pairs[0]
    upright = [s.lattice is not None and s.lattice.easting.ndim == 1 for s in surfaces]
    if upright[i] and not upright[j]:
        i, j = j, i
    trees: list[Tree] = [None] * len(surfaces)  # type: ignore[list-item]
    trees[i] = tree_of(surfaces[i])
    trees[j] = tree_of(surfaces[j], trees[i].bounds)
    for k, surface in enumerate(surfaces):
        if k not in (i, j):
            trees[k] = tree_of(surface)
    return trees
