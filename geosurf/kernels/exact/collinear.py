"""Which points lie inside which segments: exact, for points that are constructed, too.

Letters as in `exact`. Three points are collinear in space if they are so on two pairs of axes
(three, where they project to one point). Along a line points are in lexicographic order, and
rounding keeps it: only equal rounded coordinates have to be compared exactly. The segment is
that of two faces: what is beside the plane of either is not on it, which costs a quarter to see.
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.bigint import clear, mul_add, sign
from geosurf.kernels.exact.exact_signs import (
    LIMBS,
    Frame,
    exact_compare,
    exact_orient2d,
    plane,
    point,
)

_POINT = 28  # units of the workspace for a point: behind it planes are kept
_SUM = 2 * _POINT


@scalar
def _order(frame, a, b):
    """Sign of the lexicographic order of two points: -1 if a comes first."""
    x = frame.x
    for axis in range(3):
        if x[a, axis] != x[b, axis]:
            return -1 if x[a, axis] < x[b, axis] else 1
        order = exact_compare(frame, a, b, axis)
        if order != 0:
            return order
    return 0


@scalar
def _is_in_planes(frame, p):
    """Whether a point lies in both of the planes that are kept in the workspace."""
    m, w = frame.m, frame.w
    n = m[LIMBS]
    lx, lw = point(frame, 0, p)
    total = 9 * n + 2
    for k in range(2):
        at = (_POINT + 9 * k) * n
        clear(w, _SUM * n, total)
        for axis in range(3):
            mul_add(w, _SUM * n, total, at + 2 * axis * n, 2 * n, 7 * axis * n, lx, 1)
        mul_add(w, _SUM * n, total, at + 6 * n, 3 * n, 21 * n, lw, -1)
        if sign(w, _SUM * n, total) != 0:
            return False
    return True


@entry("d2 l2 l2 l2 l1 l1 l2 l1 -> .")
def inside_segments(x, t, e, d, m, w, rows, out):
    """out[i] = 1 if point rows[i, 0] lies on the segment rows[i, 1:3] and is no end of it.

    The segment is that of the faces rows[i, 3:5]. Rows of one segment stand together.
    """
    frame = Frame(x, t, e, d, m, w)
    loaded = -1
    for i in range(rows.shape[0]):
        p, a, b = rows[i, 0], rows[i, 1], rows[i, 2]
        if loaded < 0 or rows[loaded, 3] != rows[i, 3] or rows[loaded, 4] != rows[i, 4]:
            plane(x, t, e, m, w, _POINT * m[LIMBS], rows[i, 3])
            plane(x, t, e, m, w, (_POINT + 9) * m[LIMBS], rows[i, 4])
            loaded = i
        out[i] = 0
        if not _is_in_planes(frame, p):
            continue
        loaded = -1  # what follows needs the room
        if (
            exact_orient2d(frame, a, b, p, 0, 1) == 0
            and exact_orient2d(frame, a, b, p, 1, 2) == 0
            and exact_orient2d(frame, a, b, p, 2, 0) == 0
            and _order(frame, a, p) * _order(frame, p, b) > 0
        ):
            out[i] = 1
