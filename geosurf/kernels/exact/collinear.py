"""Which points lie inside which segments: an exact test, also for constructed points.

Letters as in `exact_signs`. Three points are collinear in space if their projections on two pairs
of axes are collinear (on three pairs, where they project to one point). Points of a line are in
lexicographic order, and rounding preserves it: only equal rounded coordinates need an exact
comparison. A segment is given with its two faces. A point off the plane of either face is
rejected first, for a quarter of the cost.
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

_POINT = 28  # units of the workspace for a point; planes are stored after it
_SUM = 2 * _POINT


@scalar
def _order(frame, a, b):
    """Sign of the lexicographic order of two points: -1 if a comes first."""
    x = frame.x
    for axis in range(3):
        # Rounding preserves order: only equal coordinates need exact comparison.
        if x[a, axis] != x[b, axis]:
            return -1 if x[a, axis] < x[b, axis] else 1
        order = exact_compare(frame, a, b, axis)
        if order != 0:
            return order
    return 0


@scalar
def _is_in_planes(frame, p):
    """Whether a point lies in both planes that the workspace holds."""
    m, w = frame.m, frame.w
    n = m[LIMBS]

    # n . X - offset * W is zero for a point of the plane.
    lx, lw = point(frame, 0, p)
    total = 9 * n + 2
    for k in range(2):
        at = (_POINT + 9 * k) * n
        clear(w, _SUM * n, total)
        for axis in range(3):
            # A normal has 2 n limbs per component, the offset 3 n (see `plane`).
            mul_add(w, _SUM * n, total, at + 2 * axis * n, 2 * n, 7 * axis * n, lx, 1)
        mul_add(w, _SUM * n, total, at + 6 * n, 3 * n, 21 * n, lw, -1)
        if sign(w, _SUM * n, total) != 0:
            return False
    return True


@entry("d2 l2 l2 l2 l1* l1* l2 l1* -> .")
def inside_segments(x, t, e, d, m, w, rows, out):
    """out[i] = 1 if point rows[i, 0] lies inside segment rows[i, 1:3], its ends excluded.

    The segment is that of the faces rows[i, 3:5]. Rows of one segment have to be adjacent.
    """
    frame = Frame(x, t, e, d, m, w)
    loaded = -1
    for i in range(rows.shape[0]):
        # Planes are loaded once for adjacent rows with the same faces.
        p, a, b = rows[i, 0], rows[i, 1], rows[i, 2]
        if loaded < 0 or rows[loaded, 3] != rows[i, 3] or rows[loaded, 4] != rows[i, 4]:
            plane(x, t, e, m, w, _POINT * m[LIMBS], rows[i, 3])
            plane(x, t, e, m, w, (_POINT + 9) * m[LIMBS], rows[i, 4])
            loaded = i

        # Cheap rejection first: off the plane of either face.
        out[i] = 0
        if not _is_in_planes(frame, p):
            continue
        loaded = -1  # the following signs overwrite the planes

        # On one pair of axes the segment may project to a point, so all three pairs have to agree.
        # Then p lies between the ends in lexicographic order.
        if (
            exact_orient2d(frame, a, b, p, 0, 1) == 0
            and exact_orient2d(frame, a, b, p, 1, 2) == 0
            and exact_orient2d(frame, a, b, p, 2, 0) == 0
            and _order(frame, a, p) * _order(frame, p, b) > 0
        ):
            out[i] = 1
