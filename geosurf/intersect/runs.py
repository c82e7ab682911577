"""Join overlapping collinear segments of one face to runs, each part of the line once.

Thousands of slivers may cut a face along one line, each over a part of it. What lies in a run is
looked for once, not in each of them. Which ones to compare is decided by floats: those of one
direction and offset, each with that one of the earlier ones that reaches farthest. That they
overlap is decided exactly; where floats miss a pair, segments stay apart, and the answer is the
same.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geosurf.kernels.meshes.mesh import join_pairs

MANY = 32  # segments of a face, from which it is worth it
_ALIKE = 1e-6  # of directions, and of offsets by the largest coordinate


def join_runs(
    x: np.ndarray,
    segments: np.ndarray,
    lines: np.ndarray,
    lie_inside: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> tuple[np.ndarray, np.ndarray] | None:
    """Runs of segments that overlap.

    Parameters
    ----------
    x : ndarray of float64, shape (n, 3)
    segments : ndarray of int64, shape (n_segment, 2)
        Rows of `x`.
    lines : ndarray of int64, shape (n_line, 2)
        Group and segment, sorted.
    lie_inside : callable
        Whether points lie in segments, from rows of `segments` and of `x`.

    Returns
    -------
    runs : ndarray of int64, shape (n_run, 2)
        Their ends, rows of `x`; a segment that is alone is as it was.
    run_of : ndarray of int64, shape (n_segment,)
        None instead of both if none overlap.
    """
    many = lines[np.bincount(lines[:, 0])[lines[:, 0]] >= MANY]
    if len(many) == 0:
        return None

    low, high, first, last, cluster, order = _along(x, segments, many)
    segment = many[order, 1]
    farthest = _farthest(cluster, last)

    # Segments that begin before the one that reaches farthest has ended may overlap it (floats).
    some = np.flatnonzero((farthest >= 0) & (first < last[farthest]))
    one, two = segment[some], segment[farthest[some]]
    start, end, begin, stop = low[some], high[some], low[farthest[some]], high[farthest[some]]

    # Exactly: they share an end, or an end of one lies inside the other.
    meet = (start == begin) | lie_inside(two, start)
    meet &= (end == stop) | lie_inside(two, end) | lie_inside(one, stop)
    if not meet.any():
        return None

    # Overlaps are transitive: classes of segments that overlap are the runs.
    root = join_pairs(np.stack([one[meet], two[meet]], axis=1), len(segments))
    leads, run_of = np.unique(root, return_inverse=True)

    # each coordinate rises or falls along a run, as it does along its first segment
    way = np.sign(x[segments[root, 1]] - x[segments[root, 0]])
    of, points = np.repeat(run_of, 2), segments.ravel()
    order = np.lexsort((*(np.repeat(way, 2, axis=0) * x[points]).T, of))
    ends = np.searchsorted(of[order], np.arange(len(leads) + 1))
    runs = np.stack([points[order[ends[:-1]]], points[order[ends[1:] - 1]]], axis=1)
    alone = np.bincount(run_of) == 1
    runs[alone] = segments[leads[alone]]

    # The ends of the line decide its coordinates; a run of one segment keeps its order of ends.
    return runs, run_of


def _along(x: np.ndarray, segments: np.ndarray, many: np.ndarray) -> tuple[np.ndarray, ...]:
    """Ends of segments along their lines, where those are, the line of each, and their order."""
    # Unit directions, turned so that their largest component rises: parallel lines are alike.
    a, b = segments[many[:, 1]].T
    way = x[b] - x[a]
    way /= np.maximum(np.linalg.norm(way, axis=1), 1e-300)[:, None]
    leading = way[np.arange(len(way)), np.abs(way).argmax(axis=1)]
    turned = leading < 0
    way[turned] *= -1
    a, b = np.where(turned, b, a), np.where(turned, a, b)

    # Positions along the line [m], and the foot of the origin on it: (direction, foot) names a
    # line.
    first, last = (x[a] * way).sum(axis=1), (x[b] * way).sum(axis=1)
    size = float(np.abs(x[segments]).max()) + 1e-300
    offset = x[a] - first[:, None] * way
    keys = np.concatenate([np.round(way / _ALIKE), np.round(offset / (_ALIKE * size))], axis=1)

    # By face, line and position; a cluster is one line of one face, up to the rounding of keys.
    order = np.lexsort((first, *keys.T, many[:, 0]))
    keys = np.column_stack([many[:, 0], keys])[order]
    cluster = np.cumsum(np.append(False, (keys[1:] != keys[:-1]).any(axis=1)))
    return a[order], b[order], first[order], last[order], cluster, order


def _farthest(cluster: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Of those before each one in its cluster the one that reaches farthest; -1 for the first."""
    # A running maximum over ranks is one over ends, as clusters have rising ranks.
    by_end = np.lexsort((last, cluster))
    rank = np.empty(len(by_end), dtype=np.int64)
    rank[by_end] = np.arange(len(by_end))
    before = np.append(-1, by_end[np.maximum.accumulate(rank)][:-1])
    return np.where(np.append(-1, cluster[:-1]) == cluster, before, -1)
