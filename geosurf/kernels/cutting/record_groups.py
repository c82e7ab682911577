"""Records by the faces that they cut: each segment and point once, in one order.

Notation
    records   int64 (n, 4): a face, the first point of a segment, its second point (-1: a point
              alone), and the plane that cuts; see `naming`
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

_FEW = 32  # records of a face that are sorted by insertion
_POINT = 31  # bits of the number of a point


@scalar
def _sort(keys, rows, n):
    """Sort the first n keys, and rows with them."""
    if n > _FEW:
        order = np.argsort(keys[:n])
        some, of = keys[:n].copy(), rows[:n].copy()
        for k in range(n):
            keys[k], rows[k] = some[order[k]], of[order[k]]
        return
    for k in range(1, n):
        key, row, j = keys[k], rows[k], k
        while j > 0 and keys[j - 1] > key:
            keys[j], rows[j] = keys[j - 1], rows[j - 1]
            j -= 1
        keys[j], rows[j] = key, row


@entry("l2 l l l -> l2 l1")
def group_records(records, low, high, n_point):
    """Records of faces `low` to `high` - 1 by face, first point and second point, each once; and
    the offsets of the faces.

    Of several with the same points, the one with the lowest plane is kept. A point is left out
    where it ends a segment of its face: contacts with more neighbours than are needed add no more
    than such points.
    """
    n_face = high - low
    # entry face + 1 counts the records of a face; sums make it the first place of each
    start = np.zeros(n_face + 1, dtype=np.int64)
    for k in range(records.shape[0]):
        if low <= records[k, 0] < high:
            start[records[k, 0] - low + 1] += 1
    most = 0
    for face in range(n_face):
        most = max(most, start[face + 1])
        start[face + 1] += start[face]
    n = start[n_face]
    by_face = np.empty(n, dtype=np.int64)
    for k in range(records.shape[0]):  # each start moves to where the next one begins
        if low <= records[k, 0] < high:
            face = records[k, 0] - low
            by_face[start[face]] = k
            start[face] += 1

    out, offsets = np.empty((n, 4), dtype=np.int64), np.empty(n + 1, dtype=np.int64)
    keys, rows = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    ends = np.full(n_point, -1, dtype=np.int64)  # the last face with a segment that ends there
    n_out = n_group = begin = 0
    for face in range(n_face):
        end = start[face]
        if begin == end:  # most faces of a change
            continue
        for k in range(begin, end):
            r = by_face[k]
            if records[r, 2] >= 0:
                ends[records[r, 1]] = ends[records[r, 2]] = face
        m = 0
        for k in range(begin, end):
            r = by_face[k]
            if records[r, 2] >= 0 or ends[records[r, 1]] != face:
                keys[m] = (records[r, 1] << _POINT) + records[r, 2] + 1
                rows[m] = r
                m += 1
        if m > 1:
            _sort(keys, rows, m)

        if m > 0:
            offsets[n_group] = n_out
            n_group += 1
        for k in range(m):
            if k > 0 and keys[k] == keys[k - 1]:
                out[n_out - 1, 3] = min(out[n_out - 1, 3], records[rows[k], 3])
                continue
            for column in range(4):
                out[n_out, column] = records[rows[k], column]
            n_out += 1
        begin = end
    offsets[n_group] = n_out
    return out[:n_out].copy(), offsets[: n_group + 1].copy()
