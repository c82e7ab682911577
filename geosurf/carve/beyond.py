"""What a surface does not reach: the first surface that its open rim would meet if it went on."""

from __future__ import annotations

import numpy as np

from geosurf.model import Patches

BLOCK = 1 << 17  # triangles that are looked at together


def first_beyond(patches: Patches, middle: np.ndarray, surface: int) -> tuple[int, float] | None:
    """
    Return the surface that a rim would meet straight on, and how far away [m]; None without one.

    Parameters
    ----------
    patches : Patches
    middle : ndarray of float64, shape (3,)
        Middle of an edge of the rim, in world coordinates.
    surface : int
        Row of `patches.sources` that the rim belongs to.
    """
    at = middle - patches.origin
    own = patches.surface_of_triangle == surface
    direction = _outward(patches.local[patches.triangles[own]], at)
    others = np.flatnonzero(~own)
    best: tuple[int, float] | None = None
    for start in range(0, len(others), BLOCK):
        rows = others[start : start + BLOCK]
        away = _along(patches.local[patches.triangles[rows]], at, direction)
        k = int(np.argmin(away))
        if np.isfinite(away[k]) and (best is None or away[k] < best[1]):
            best = int(patches.surface_of_triangle[rows[k]]), float(away[k])
    return best


def _outward(corners: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Unit vector out of a surface, in its plane, at the middle of an edge."""
    ends = np.roll(corners, -1, axis=1)
    away = ((0.5 * (corners + ends) - at) ** 2).sum(axis=2)
    row, k = np.unravel_index(int(np.argmin(away)), away.shape)
    along = ends[row, k] - corners[row, k]
    out = at - corners[row, (k + 2) % 3]
    out = out - (out @ along) / (along @ along) * along
    direction: np.ndarray = out / np.linalg.norm(out)
    return direction


def _along(corners: np.ndarray, at: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Distances along a ray to triangles (n, 3, 3), infinite where it misses; to rounding.

    T. Moeller, B. Trumbore (1997), Fast, Minimum Storage Ray/Triangle Intersection.
    """
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(direction, two)
    size = np.einsum("nc,nc->n", one, p)
    parallel = size == 0.0
    size = np.where(parallel, 1.0, size)
    from_corner = at - corners[:, 0]
    u = np.einsum("nc,nc->n", from_corner, p) / size
    q = np.cross(from_corner, one)
    v = (q @ direction) / size
    t = np.einsum("nc,nc->n", two, q) / size
    # a ray through an edge may miss both of its triangles by rounding
    slack = 1e-9
    hits = ~parallel & (u >= -slack) & (v >= -slack) & (u + v <= 1.0 + slack) & (t >= 0.0)
    return np.where(hits, t, np.inf)
