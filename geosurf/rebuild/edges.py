"""Match half-edges, and join triangles to patches, in threads: a range for each.

Results are the same for any number of ranges (`geosurf.kernels.meshes.edges_in_ranges`).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.kernels.meshes import edges_in_ranges as kernels
from geosurf.model.pieces import FREE, PAIRED

_TRIANGLES = 20_000  # of a thread, at least: a millisecond of work, ten times what a thread costs


def find_edges(t: np.ndarray, n_point: int) -> tuple[np.ndarray, np.ndarray]:
    """
    Match all half-edges.

    Parameters
    ----------
    t : ndarray of int64, shape (n_triangle, 3)
    n_point : int

    Returns
    -------
    ring, link : ndarray of int64, shape (3 * n_triangle,)
        As `Pieces` has them; FREE for half-edges that are alone.

    Examples
    --------
    >>> ring, link = find_edges(np.array([[0, 1, 2], [2, 1, 3]]), 4)
    >>> ring.tolist()
    [0, 3, 2, 1, 4, 5]
    """
    # large arrays are made here: numpy asks for large pages, which kernels do not
    ring, link = (np.empty(3 * len(t), dtype=np.int64) for _ in range(2))
    bucket = link  # which is written when nobody needs the buckets any more
    rows = in_ranges(len(t), _TRIANGLES)
    count = np.zeros((len(rows), n_point), dtype=np.int64)
    map_threads(kernels.count_lower, [(t, *row, own) for row, own in zip(rows, count, strict=True)])
    start = kernels.begin_buckets(count)
    map_threads(
        kernels.fill_buckets,
        [(t, *row, own, bucket, ring) for row, own in zip(rows, count, strict=True)],
    )

    # by ranges of vertices with about as many half-edges each
    wanted = start[-1] * np.arange(1, len(rows)) // len(rows)
    cut = [0, *np.searchsorted(start[:-1], wanted).tolist(), len(start) - 1]
    map_threads(kernels.match_buckets, [(start, bucket, i, j, ring) for i, j in pairwise(cut)])
    map_threads(kernels.mark_alone, [(ring, 3 * i, 3 * j, FREE, PAIRED, link) for i, j in rows])
    return ring, link


def find_patches(
    surface: np.ndarray, owners: np.ndarray, ring: np.ndarray, twin: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Join triangles over edges that two distinct ones share, if the same surfaces own both.

    Parameters
    ----------
    surface, owners : ndarray of int64, shape (n_triangle,)
        Surface of each triangle, and a number for the set of surfaces that own it.
    ring : ndarray of int64, shape (3 * n_triangle,)
        As `Pieces` has it.
    twin : ndarray of int64, shape (n_triangle,) or (0,)
        The first triangle with the same corners, mostly itself. Empty if none coincide.

    Returns
    -------
    ndarray of int64, shape (n_triangle,)
        Patch of each triangle, numbered by first triangle.
    ndarray of int64
        Edges between patches, each by its last half-edge, rising: those with different owners or
        more than two triangles.
    """
    rows = in_ranges(len(surface), _TRIANGLES)
    parent = np.empty(len(surface), dtype=np.int64)
    found = map_threads(kernels.join_range, [(owners, ring, twin, *row, parent) for row in rows])
    across = np.concatenate([pairs for pairs, _ in found])
    patch = kernels.join_ranges(parent, across, surface, ring, twin)
    return patch, np.concatenate([rim for _, rim in found])
