"""Segments that overlap in a line -> each part of the line once.

Neighbours in a mesh share whole edges, and their segments share whole ends. A mesh with corners in
the middle of edges, or one that crosses itself in a line of the other surface, makes a curve twice:
by segments that begin and end at different points of it. Each is split where another one of
its pair of surfaces begins or ends, or touches; equal pieces are one then. Nearness is asked of
floats with room to spare, what lies on a segment is decided exactly.
"""

from __future__ import annotations

import numpy as np

from geosurf.contact.search import ULP, Contacts
from geosurf.kernels.collinear import lie_inside

_REACH = 64 * ULP  # of the largest coordinate; rounding moves points by less than two
_LEAST = 1e-300  # so that nothing divides by 0 where all is at 0
_AT_ONCE = 4_000_000


def split_overlaps(
    contacts: Contacts, segments: np.ndarray, surfaces: np.ndarray, touching: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Split segments at the points of their pair of surfaces that lie inside them.

    Parameters
    ----------
    contacts : Contacts
    segments : ndarray of int64, shape (n, 2)
        Rows of `Contacts.x`, once a pair.
    surfaces : ndarray of int64, shape (n, 2)
        Rows of the surfaces, sorted.
    touching : ndarray of int64, shape (n_touching, 3)
        Surfaces and point of contacts in a single point.

    Returns
    -------
    segments, surfaces : ndarray of int64
        Pieces may occur more than once.
    """
    if len(segments) == 0 or len(segments) + len(touching) < 2:
        return segments, surfaces
    starts = np.flatnonzero(np.append(True, (surfaces[1:] != surfaces[:-1]).any(axis=1)))
    whole = np.ones(len(segments), dtype=bool)
    pieces, owners = [], []
    for low, high in zip(starts, np.append(starts[1:], len(segments)), strict=True):
        pair = surfaces[low]
        points = np.unique(segments[low:high])
        if len(touching):
            mine = (touching[:, :2] == pair).all(axis=1)
            points = np.union1d(points, touching[mine, 2])
        hits = _inside(contacts, segments[low:high], points)
        for row in np.unique(hits[:, 0]).tolist():
            on = hits[hits[:, 0] == row, 1]
            on = np.concatenate([segments[low + row], on])
            on = on[np.lexsort(contacts.x[on].T[::-1])]
            pieces.append(np.stack([on[:-1], on[1:]], axis=1))
            owners.append(np.tile(pair, (len(on) - 1, 1)))
            whole[low + row] = False
    return (
        np.concatenate([segments[whole], *pieces]),
        np.concatenate([surfaces[whole], *owners]),
    )


def _inside(contacts: Contacts, segments: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Rows (segment, point) of points that lie in a segment and are no end of it."""
    near = _near(contacts.x, segments, points)
    rows = np.stack([near[:, 1], *segments[near[:, 0]].T], axis=1)
    out = np.empty(len(rows), dtype=np.int64)
    if len(rows):
        m = contacts.m.copy()
        lie_inside(contacts.x, contacts.t, contacts.e, contacts.d, m, contacts.w, rows, out)
    return near[out == 1]


def _near(x: np.ndarray, segments: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Rows (segment, point) of points next to a segment that are none of its ends."""
    reach = _REACH * float(np.abs(x[points]).max(initial=0.0)) + _LEAST
    a, b = x[segments[:, 0]], x[segments[:, 1]]
    lower, upper = np.minimum(a, b) - reach, np.maximum(a, b) + reach
    # search along the axis on which segments are shortest, measured by how far points are spread
    spread = x[points].max(axis=0) - x[points].min(axis=0) + reach
    axis = int(((upper - lower).sum(axis=0) / spread).argmin())
    order = np.argsort(x[points, axis], kind="stable")
    at = x[points[order], axis]
    first = np.searchsorted(at, lower[:, axis])
    count = np.searchsorted(at, upper[:, axis], side="right") - first
    found = [np.empty((0, 2), dtype=np.int64)]
    parts = np.searchsorted(np.cumsum(count), np.arange(0, count.sum() + 1, _AT_ONCE))
    for low, high in zip(parts, np.append(parts[1:], len(count)), strict=True):
        of = np.repeat(np.arange(low, high), count[low:high])
        begin = np.cumsum(count[low:high]) - count[low:high]
        at = np.arange(len(of)) - np.repeat(begin - first[low:high], count[low:high])
        point = points[order[at]]
        keep = (point != segments[of, 0]) & (point != segments[of, 1])
        of, point = of[keep], point[keep]
        keep = ((lower[of] <= x[point]) & (x[point] <= upper[of])).all(axis=1)
        of, point = of[keep], point[keep]
        along, across = b[of] - a[of], x[point] - a[of]
        away = np.linalg.norm(np.cross(along, across), axis=1)
        keep = away <= reach * np.linalg.norm(along, axis=1)
        found.append(np.stack([of[keep], point[keep]], axis=1))
    return np.concatenate(found)
