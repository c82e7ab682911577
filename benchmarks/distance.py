"""How far two curves are apart: the Hausdorff distance, one way and the other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

BLOCK = 64  # segments, or points, that are looked at together
PER_SEGMENT = 8


def distance_to_segments(points: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """
    Return the distance of each point to the nearest of some segments.

    Points and segments are taken in blocks; blocks of segments that are farther than another
    block can be are left out, so that curves given in order cost little. The result is that
    of comparing everything with everything.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 3)
        [m]
    segments : ndarray of float64, shape (m, 2, 3)
        [m]; at least one.

    Returns
    -------
    ndarray of float64, shape (n,)
        [m]

    Examples
    --------
    >>> segments = np.array([[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]]])
    >>> distance_to_segments(np.array([[1.0, 2.0, 0.0], [7.0, 4.0, 0.0]]), segments)
    array([2., 5.])
    """
    low, high = _boxes(segments.reshape(-1, 3), 2 * BLOCK)
    result = np.empty(len(points))
    for start in range(0, len(points), BLOCK):
        some = points[start : start + BLOCK]
        gap = np.maximum(0.0, np.maximum(low - some.max(axis=0), some.min(axis=0) - high))
        reach = np.maximum(high, some.max(axis=0)) - np.minimum(low, some.min(axis=0))
        near = np.linalg.norm(gap, axis=1)
        wanted = np.flatnonzero(near <= np.linalg.norm(reach, axis=1).min())
        rows = (wanted[:, None] * BLOCK + np.arange(BLOCK)).ravel()
        result[start : start + BLOCK] = _all_pairs(some, segments[rows[rows < len(segments)]])
    return result


def _boxes(points: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the boxes of n points each."""
    starts = np.arange(0, len(points), n)
    return np.minimum.reduceat(points, starts), np.maximum.reduceat(points, starts)


def _all_pairs(points: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """Distance of each point to the nearest segment; every pair is measured."""
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    square = (along**2).sum(axis=1)
    offset = points[:, None] - start
    t = (offset * along).sum(axis=2) / np.where(square > 0, square, 1.0)
    foot = np.clip(t, 0.0, 1.0)[:, :, None] * along
    return np.sqrt(((offset - foot) ** 2).sum(axis=2).min(axis=1))


def distance_to_curve(
    points: np.ndarray, curve_at: Callable[[np.ndarray], np.ndarray], span: tuple[float, float]
) -> np.ndarray:
    """
    Return the distance of each point to a smooth curve that runs on and on to the north.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 3)
        Near the curve [m].
    curve_at : callable
        From northings (n,) to points of the curve (n, 3).
    span : (float, float)
        Northing of its ends.

    Returns
    -------
    ndarray of float64, shape (n,)
        [m]

    Notes
    -----
    The foot of the perpendicular, by the method of Gauss and Newton from the point's own
    northing. The true distance is not larger than what is returned.

    Examples
    --------
    >>> def line(y):
    ...     return np.stack([0 * y, y, 0 * y], axis=-1)
    >>> distance_to_curve(np.array([[3.0, 5.0, 4.0], [0.0, 12.0, 0.0]]), line, (0.0, 10.0))
    array([5., 2.])
    """
    at = np.clip(points[:, 1], *span)
    best = np.linalg.norm(points - curve_at(at), axis=1)
    for _ in range(8):
        tangent = (curve_at(at + 0.05) - curve_at(at - 0.05)) / 0.1
        gap = points - curve_at(at)
        at = np.clip(at + (gap * tangent).sum(axis=1) / (tangent**2).sum(axis=1), *span)
        best = np.minimum(best, np.linalg.norm(points - curve_at(at), axis=1))
    return best


def hausdorff(
    segments: np.ndarray, curve_at: Callable[[np.ndarray], np.ndarray], span: tuple[float, float]
) -> tuple[float, float]:
    """
    Return how far a curve of segments strays from a true one, and how far it misses it.

    Parameters
    ----------
    segments : ndarray of float64, shape (m, 2, 3)
        [m]
    curve_at, span
        As for `distance_to_curve`.

    Returns
    -------
    strays, misses : float
        Largest distance of a point on the segments (8 on each) to the true curve, and of a point
        on the true curve (4 for each segment) to the segments [m]. The Hausdorff distance is
        the larger one.

    Examples
    --------
    >>> def line(y):
    ...     return np.stack([0 * y, y, 0 * y], axis=-1)
    >>> strays, misses = hausdorff(np.array([[[1.0, 0.0, 0.0], [1.0, 8.0, 0.0]]]), line, (0, 10))
    >>> strays, round(misses, 3)
    (1.0, 2.236)
    """
    if len(segments) == 0:
        return 0.0, float("inf")
    part = np.linspace(0.0, 1.0, PER_SEGMENT)[:, None]
    start, end = segments[:, None, 0], segments[:, None, 1]
    strays = distance_to_curve((start + part * (end - start)).reshape(-1, 3), curve_at, span)
    true = curve_at(np.linspace(*span, max(4 * len(segments), 400)))
    # in order along the curve, so that blocks are small
    middle = segments.mean(axis=1)
    inorder = segments[np.argsort(middle[:, 1], kind="stable")]
    return float(strays.max()), float(distance_to_segments(true, inorder).max())
