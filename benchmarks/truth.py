"""What is right, by means that share nothing with the engine: plain numpy, slow and obvious."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

AT_ONCE = 1_000_000  # pairs of a cell and a triangle


def curve_of_grid(
    easting: np.ndarray, northing: np.ndarray, elevation: np.ndarray, corners: np.ndarray
) -> tuple[float, int]:
    """
    Return length and number of segments of the curve of a regular grid and some triangles.

    Each triangle is compared with both halves of all cells that its box covers. In floats:
    for grids and triangles in general position.

    Parameters
    ----------
    easting, northing : ndarray of float64, shape (n_col,), (n_row,)
        Equally spaced, increasing [m].
    elevation : ndarray of float64, shape (n_row, n_col)
        [m]; cells are split from south-west to north-east.
    corners : ndarray of float64, shape (n_triangle, 3, 3)
        [m]

    Returns
    -------
    length : float
        [m]
    n_segment : int

    Examples
    --------
    >>> x = np.arange(4.0)
    >>> wall = np.array([[[-1, 0.3, -9], [9, 0.3, -9], [4, 0.3, 9.0]]])
    >>> curve_of_grid(x, x, np.zeros((4, 4)), wall)
    (1.5, 3)
    """
    origin = np.array([easting[0], northing[0], 0.0])
    step = (
        (easting[-1] - easting[0]) / (len(easting) - 1),
        (northing[-1] - northing[0]) / (len(northing) - 1),
    )
    x, y = easting - origin[0], northing - origin[1]
    local = corners - origin
    flat = local[
        (local[:, :, 2].min(axis=1) <= elevation.max())
        & (local[:, :, 2].max(axis=1) >= elevation.min())
    ]
    length, count = [], 0
    for triangle, i, j in _near_cells(flat, step, elevation.shape):
        t = flat[triangle]
        z = np.stack([elevation[i + a, j + b] for a, b in ((0, 0), (0, 1), (1, 1), (1, 0))], axis=1)
        low, high = t[:, :, 2].min(axis=1), t[:, :, 2].max(axis=1)
        keep = (z.min(axis=1) <= high) & (z.max(axis=1) >= low)
        t, i, j, z = t[keep], i[keep], j[keep], z[keep]
        xs = np.stack([x[j], x[j + 1], x[j + 1], x[j]], axis=1)
        ys = np.stack([y[i], y[i], y[i + 1], y[i + 1]], axis=1)
        cell = np.stack([xs, ys, z], axis=2)
        for half in ((0, 1, 2), (0, 2, 3)):
            found = _shared_lengths(cell[:, half], t)
            length.append(math.fsum(found))
            count += int((found > 0).sum())
    return math.fsum(length), count


def _near_cells(
    corners: np.ndarray, step: tuple[float, float], shape: tuple[int, int]
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Triangles, rows and columns of the cells that their boxes cover, some at once."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    j0, j1 = (np.floor(bound[:, 0] / step[0]).astype(np.int64) for bound in (low, high))
    i0, i1 = (np.floor(bound[:, 1] / step[1]).astype(np.int64) for bound in (low, high))
    j0, i0 = np.maximum(j0, 0), np.maximum(i0, 0)
    j1, i1 = np.minimum(j1, shape[1] - 2), np.minimum(i1, shape[0] - 2)
    wide, tall = np.maximum(j1 - j0 + 1, 0), np.maximum(i1 - i0 + 1, 0)
    ends = np.cumsum(wide * tall)
    total = int(ends[-1]) if len(ends) else 0
    for start in range(0, total, AT_ONCE):
        k = np.arange(start, min(start + AT_ONCE, total))
        triangle = np.searchsorted(ends, k, side="right")
        inside = k - (ends - wide * tall)[triangle]
        yield (
            triangle,
            i0[triangle] + inside // wide[triangle],
            j0[triangle] + inside % wide[triangle],
        )


def _shared_lengths(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Length of the segment that each pair of triangles (n, 3, 3) shares; 0 for none."""
    normal = np.cross(B[:, 1] - B[:, 0], B[:, 2] - B[:, 0])
    side = ((A - B[:, :1]) * normal[:, None]).sum(axis=2)
    crosses = (side.min(axis=1) < 0) & (side.max(axis=1) > 0)
    lengths = np.zeros(len(A))
    A, B, side, normal = A[crosses], B[crosses], side[crosses], normal[crosses]
    # the corner that is alone on its side, first
    above = side > 0
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (side < 0).argmax(axis=1))
    turn = (alone[:, None] + np.arange(3)) % 3
    A = np.take_along_axis(A, turn[:, :, None], axis=1)
    side = np.take_along_axis(side, turn, axis=1)
    ends = [
        A[:, 0] + (side[:, 0] / (side[:, 0] - side[:, k]))[:, None] * (A[:, k] - A[:, 0])
        for k in (1, 2)
    ]
    first, last = np.zeros(len(A)), np.ones(len(A))
    for k in range(3):
        inward = np.cross(normal, B[:, (k + 1) % 3] - B[:, k])
        p, q = (((end - B[:, k]) * inward).sum(axis=1) for end in ends)
        at = p / np.where(p == q, 1.0, p - q)
        first = np.where((p < 0) & (q > 0), np.maximum(first, at), first)
        last = np.where((p > 0) & (q < 0), np.minimum(last, at), last)
        last = np.where((p <= 0) & (q <= 0), -1.0, last)
    lengths[crosses] = np.maximum(last - first, 0.0) * np.linalg.norm(ends[1] - ends[0], axis=1)
    return lengths


def areas(corners: np.ndarray) -> np.ndarray:
    """Return the area of each triangle (n, 3, 3) [m2].

    Examples
    --------
    >>> areas(np.array([[[0, 0, 0], [2, 0, 0], [0, 2, 0.0]]]))
    array([2.])
    """
    edges = corners[:, 1:] - corners[:, :1]
    return 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)


def is_closed(triangles: np.ndarray) -> bool:
    """Return whether each edge of a shell is used as often one way as the other.

    Parameters
    ----------
    triangles : ndarray of int, shape (n, 3)

    Returns
    -------
    bool

    Examples
    --------
    >>> tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    >>> is_closed(tetrahedron), is_closed(tetrahedron[:3])
    (True, False)
    """
    n = np.int64(triangles.max(initial=0)) + 1
    a = triangles.astype(np.int64).ravel()
    b = np.roll(triangles.astype(np.int64), -1, axis=1).ravel()
    return bool((np.sort(a * n + b) == np.sort(b * n + a)).all())


def volume_below_grid(
    easting: np.ndarray, northing: np.ndarray, elevation: np.ndarray, bottom: float
) -> float:
    """Return the volume between a level and a grid of triangles, whichever way cells are split
    from south-west to north-east [m3].

    Examples
    --------
    >>> volume_below_grid(np.arange(3.0), np.arange(2.0), np.ones((2, 3)), -1.0)
    4.0
    """
    z = elevation - bottom
    a, b, c, d = z[:-1, :-1], z[:-1, 1:], z[1:, 1:], z[1:, :-1]
    cell = np.diff(northing)[:, None] * np.diff(easting)[None, :]
    return math.fsum((cell * (2 * a + 2 * c + b + d) / 6).ravel())
