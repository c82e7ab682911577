"""Large triangles of faults, divided until they bend with the pillars."""

from __future__ import annotations

import numpy as np

LONGEST = 1.5  # cells, on the map
MOST = 400_000


def refined(
    x: np.ndarray, triangles: np.ndarray, shape: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """
    Divide triangles into four until they are about as small as cells.

    Parameters
    ----------
    x : ndarray of float64, shape (n, 3)
        In lattice coordinates.
    triangles : ndarray of int64, shape (m, 3)
    shape : (int, int)
        Rows and columns of the lattice: what lies outside of it stays as it is.

    Returns
    -------
    (ndarray, ndarray)
        Vertices and triangles. Neighbours are divided at the same places, or one of them is not:
        rays between columns do not need a closed surface.
    """
    corners, done = x[triangles], []
    limit = np.array(shape[::-1])
    while len(corners):
        flat = corners[..., :2]
        size = np.ptp(flat, axis=1).max(axis=1)
        near = (flat.max(axis=1) > -1).all(axis=1) & (flat.min(axis=1) < limit + 1).all(axis=1)
        split = (size > LONGEST) & near
        if 4 * int(split.sum()) > MOST:
            split[:] = False
        done.append(corners[~split])
        a, b, c = corners[split].transpose(1, 0, 2)
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
    found = np.concatenate(done).reshape(-1, 3)
    return found, np.arange(len(found)).reshape(-1, 3)
