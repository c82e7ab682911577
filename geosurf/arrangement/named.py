"""Name the points of contacts, place them, and merge those that have several names.

Names are numbered in the order of contacts, in one thread. All that follows is by ranges of points,
or by parts of those that may be equal, in threads, with the results of one.
"""

from __future__ import annotations

import numpy as np

from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.kernels.contacts.merging import close_up_points, find_suspects, merge_suspects
from geosurf.kernels.contacts.naming import name_corners
from geosurf.kernels.contacts.placing import place_points
from geosurf.kernels.exact.constructed_points import FULL
from geosurf.kernels.exact.exact_signs import EXACT_ORIENT2D, N_NAME, N_POINT, N_VERTEX

# least work of a thread: a millisecond each
_POINTS, _SUSPECTS, _CONTACTS = 20_000, 4_000, 100_000


def name_contacts(
    x: np.ndarray,
    t: np.ndarray,
    e: np.ndarray,
    d: np.ndarray,
    m: np.ndarray,
    w: np.ndarray,
    rows: np.ndarray,
    ids: np.ndarray,
) -> int:
    """
    Write the ids of all points of contact to rows of `ids`.

    Letters are those of `geosurf.kernels.contacts.naming`.

    Parameters
    ----------
    x, d : ndarray
        With room for one point per corner behind the vertices.
    t, e, m, w, rows, ids : ndarray

    Returns
    -------
    int
        The number of points, or FULL.
    """
    n = int(name_corners(x, t, e, d, m, w, rows, ids))
    if n in (FULL, 0):
        return n
    ranges = in_ranges(n, _POINTS)
    frames = [(m.copy(), w.copy()) for _ in ranges]
    map_threads(
        place_points,
        [(x, t, e, d, *own, i, j) for own, (i, j) in zip(frames, ranges, strict=True)],
    )
    _count(m, [own for own, _ in frames])

    # Corners alone: no point shares a bit with another point or with a corner.
    suspects, n_corner = find_suspects(x, t, m, rows)
    if len(suspects) == n_corner:
        return n
    same = m[N_VERTEX] + np.arange(n)
    parts = range(len(in_ranges(len(suspects), _SUSPECTS)))
    frames = [(m.copy(), w.copy()) for _ in parts]
    merged = map_threads(
        merge_suspects,
        [(x, t, e, d, *frames[k], suspects, k, len(parts), same) for k in parts],
    )
    _count(m, [own for own, _ in frames])
    if not any(merged):
        return n
    close_up_points(x, d, m, same)
    merged_ids = np.flatnonzero(ids.reshape(-1) >= m[N_VERTEX])
    flat = ids.reshape(-1)
    flat[merged_ids] = same[flat[merged_ids] - m[N_VERTEX]]
    return int(m[N_POINT])


def _count(m: np.ndarray, frames: list[np.ndarray]) -> None:
    """Add what threads have counted, each from the same counts on."""
    counts = slice(EXACT_ORIENT2D, N_NAME)
    m[counts] += sum(own[counts] - m[counts] for own in frames)
