"""The exact test that triangles of a rounded mesh meet in common corners and edges only."""

from __future__ import annotations

import numpy as np

from geosurf.contact.broad import candidate_pairs, fit_voxels
from geosurf.kernels.contact import FIRST_CODE, N_COLUMN, N_CORNER, meet_pairs
from geosurf.kernels.predicates import frame_of
from geosurf.kernels.voxels import fill_voxels, triangle_boxes
from geosurf.kernels.wide import wide_pairs

WIDE = 64.0  # voxels in its box, from which a triangle is followed along its plane


def crossing_pairs(
    x: np.ndarray, triangles: np.ndarray, others: np.ndarray | None = None
) -> np.ndarray:
    """
    Find pairs of triangles that meet elsewhere than in common corners and edges.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
        Coordinates, taken at face value.
    triangles : ndarray of int64, shape (n, 3)
        Compared with each other, each set of corners once. None without area.
    others : ndarray of int64, shape (k, 3), optional
        Compared with `triangles`, but not with each other.

    Returns
    -------
    ndarray of int64, shape (n_pair, 2)
        Rows of `triangles` followed by `others`.

    Examples
    --------
    >>> x = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [1, 1, -1], [1, 1, 1], [2, 1, 1.0]])
    >>> crossing_pairs(x, np.array([[0, 1, 2], [3, 4, 5]])).tolist()
    [[0, 1]]
    """
    boxes = triangle_boxes(x, triangles)
    pairs = _near_pairs(x, triangles, boxes)
    if others is not None and len(others):
        more, _ = candidate_pairs(boxes, triangle_boxes(x, others))
        pairs = np.concatenate([pairs, more + np.array([0, len(triangles)])])
        triangles = np.concatenate([triangles, others])
    m, w = frame_of(x, len(triangles))
    rows = np.empty((len(pairs) + 1, N_COLUMN), dtype=np.int64)
    n, _ = meet_pairs(x, triangles, pairs, m, w, 0.0, rows, np.empty(0, dtype=np.int64))
    rows = rows[:n]
    used = np.arange(6)[None, :] < rows[:, N_CORNER, None]
    codes = rows[:, FIRST_CODE:]
    shared = ((codes >> 3) < 3) & ((codes & 7) < 3)
    return rows[(used & ~shared).any(axis=1), :2]


def _near_pairs(x: np.ndarray, triangles: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Pairs (n, 2) that may meet: by boxes, and along its plane for each that is far wider."""
    grid = fit_voxels(boxes, boxes)
    if grid is None:
        return np.empty((0, 2), dtype=np.int64)
    steps = np.floor((boxes[:, 3:] - boxes[:, :3]) / grid.size) + 1.0
    is_wide = np.zeros(len(boxes), dtype=bool)
    is_wide[grid.rows_a] = steps[grid.rows_a].prod(axis=1) > WIDE
    if not is_wide.any():
        return candidate_pairs(boxes, boxes, same=True)[0]
    narrow = np.flatnonzero(~is_wide)
    pairs, _ = candidate_pairs(boxes[narrow], boxes[narrow], same=True)
    offsets, filled = fill_voxels(boxes, narrow, grid.bounds, grid.size, grid.shape)
    more = wide_pairs(
        x, triangles, boxes, np.flatnonzero(is_wide), grid.bounds, grid.size, grid.shape, offsets,
        filled,
    )  # fmt: skip
    return np.concatenate([narrow[pairs], more])
