"""Test exactly that triangles of a rounded mesh meet only in shared corners and edges.

A few products show that nearly all pairs of neighbours are apart by a plane
(`geosurf.kernels.search.separation`). Pairs of wide triangles are followed along their planes
(`geosurf.kernels.search.large_triangles`). Exact signs decide the rest.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise

import numpy as np

from geosurf.arrangement.broad import equal_voxels, fit_voxels
from geosurf.arrangement.threads import map_threads, n_threads
from geosurf.kernels.contacts.triangle_contact import FIRST_CODE, N_COLUMN, N_CORNER, meet_pairs
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.search.large_triangles import large_triangle_pairs
from geosurf.kernels.search.marked_voxels import have_marks, mark_voxels
from geosurf.kernels.search.separation import undecided_pairs
from geosurf.kernels.search.voxels import are_wide, fill_voxels, triangle_boxes

# voxels in its box, from which a triangle is followed along its plane; factor of the fitted edge:
# triangles at curves are longer than most, and 64 and 1 take 15 to 65 % more time
WIDE, _COARSER = 128.0, 1.7
_VOXELS_EACH, _MOST_MARKED = 64, 8_000_000  # for triangles that others are searched around
_MANY = 20_000  # narrow triangles, from which several threads search
FEW = 16  # triangles of which all pairs cost less than a search: the walls of a box have two each


def crossing_pairs(
    x: np.ndarray,
    triangles: np.ndarray,
    others: np.ndarray | None = None,
    graph: np.ndarray | None = None,
) -> np.ndarray:
    """
    Find pairs of triangles that meet elsewhere than in common corners and edges.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
        Coordinates, taken at face value.
    triangles : ndarray of int64, shape (n, 3)
        Compared with each other, except those with the same corners. None without area.
    others : ndarray of int64, shape (k, 3), optional
        Compared with `triangles`, but not with each other.
    graph : ndarray of int64, shape (n,), optional
        Number of the graph over the map that each of `triangles` is a part of, -1 for none. Two
        parts of one graph are not compared: what they have in common on the map are corners and
        edges of both. Default: all are compared.

    Returns
    -------
    ndarray of int64, shape (n_pair, 2)
        Rows of `triangles` followed by `others`, the lower one first, in order.

    Examples
    --------
    >>> x = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [1, 1, -1], [1, 1, 1], [2, 1, 1.0]])
    >>> crossing_pairs(x, np.array([[0, 1, 2], [3, 4, 5]])).tolist()
    [[0, 1]]
    """
    n_first = len(triangles)
    if others is not None and len(others):
        triangles = np.concatenate([triangles, others])

    m, w = frame_of(x, len(triangles))
    of_graph = np.full(len(triangles), -1)
    if graph is not None:
        of_graph[:n_first] = graph
    pairs = _near_pairs(x, triangles, n_first, of_graph)
    rows = np.empty((len(pairs) + 1, N_COLUMN), dtype=np.int64)
    n, _ = meet_pairs(x, triangles, pairs, m, w, 0.0, rows, np.empty(0, dtype=np.int64))
    rows = rows[:n]

    # Rows with a corner that is not a corner of both triangles: they meet elsewhere, too.
    used = np.arange(6)[None, :] < rows[:, N_CORNER, None]
    codes = rows[:, FIRST_CODE:]
    shared = ((codes >> 3) < 3) & ((codes & 7) < 3)
    return rows[(used & ~shared).any(axis=1), :2]


def near_triangles(x: np.ndarray, few: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """
    Find triangles that may meet some few others.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
    few : ndarray of int64, shape (k, 3)
    triangles : ndarray of int64, shape (n, 3)

    Returns
    -------
    ndarray of bool, shape (n,)
        False for triangles that have no point in common with any of the few.

    Examples
    --------
    >>> x = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [1, 1, -1], [1, 1, 1], [2, 1, 1], [1, 1, 9]])
    >>> near_triangles(x * 1.0, np.array([[0, 1, 2]]), np.array([[3, 4, 5], [4, 5, 6]])).tolist()
    [True, False]
    """
    if not len(few):
        return np.zeros(len(triangles), dtype=bool)
    boxes = triangle_boxes(x, few)
    n_voxel = min(_VOXELS_EACH * len(few), _MOST_MARKED)
    bounds, size, shape = equal_voxels(boxes, n_voxel)
    marks = mark_voxels(x, few, boxes, bounds, size, shape)
    near: np.ndarray = have_marks(x, triangles, bounds, size, shape, marks)
    return near


def _near_pairs(
    x: np.ndarray,
    triangles: np.ndarray,
    n_first: int,
    graph: np.ndarray,
) -> np.ndarray:
    """Pairs of triangles, the first `n_first` with each other and with all, that are not seen to
    be apart at once; in order.
    """
    if len(triangles) <= FEW:
        first, second = np.triu_indices(len(triangles), 1)
        return np.column_stack([first, second])[first < n_first]

    boxes = triangle_boxes(x, triangles)
    first_boxes = boxes if n_first == len(boxes) else boxes[:n_first]
    grid = fit_voxels(first_boxes, boxes, coarser=_COARSER)
    if grid is None:
        return np.empty((0, 2), dtype=np.int64)

    # Triangles whose boxes hold many voxels would fill them all; they are followed along their
    # planes.
    is_wide = are_wide(boxes, grid.rows_b, grid.size, grid.shape, WIDE)
    narrow, wide = grid.rows_b[~is_wide], grid.rows_b[is_wide]
    offsets, filled = fill_voxels(boxes, narrow, grid.bounds, grid.size, grid.shape)
    voxels = grid.bounds, grid.size, grid.shape, offsets, filled

    def of_narrow(first: int, last: int) -> np.ndarray:
        """Pairs of a range of voxels: as many as there is room for, again if there were more."""
        found = np.empty((1024 + int(offsets[last] - offsets[first]) // 4, 2), dtype=np.int64)
        given = x, triangles, n_first, graph, boxes, *voxels, first, last
        n = undecided_pairs(*given, found)
        if n > len(found):
            found = np.empty((n, 2), dtype=np.int64)
            undecided_pairs(*given, found)
        return found[:n]

    def of_wide() -> np.ndarray:
        """Pairs with wide triangles."""
        found: np.ndarray = large_triangle_pairs(x, triangles, boxes, wide, *voxels)
        return found[found[:, 0] < n_first]

    # voxels in parts with as many triangles each; wide triangles are one part more
    ends = [0, len(offsets) - 1]
    if len(narrow) > _MANY and n_threads() > 1:
        share = np.arange(1, 2 * n_threads()) * int(offsets[-1]) // (2 * n_threads())
        ends[1:1] = np.searchsorted(offsets, share).tolist()
    tasks: list[tuple[Callable[[], np.ndarray]]] = [(of_wide,)]
    tasks += [(partial(of_narrow, *of),) for of in pairwise(ends)]
    parts = map_threads(lambda part: part(), tasks, worth=len(ends) > 2)
    pairs = np.concatenate(parts)
    return pairs[np.lexsort(pairs.T[::-1])]
