"""Which points lie inside which segments: exact, for points that are constructed, too.

Letters as in `exact`. Three points are collinear in space if they are so on two pairs of axes
(three, where they project to one point). Along a line points are in lexicographic order, and
rounding keeps it: only equal rounded coordinates have to be compared exactly.
"""

from __future__ import annotations

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.exact import exact_compare, exact_orient2d


@scalar
def _order(x, t, e, d, m, w, a, b):
    """Sign of the lexicographic order of two points: -1 if a comes first."""
    for axis in range(3):
        if x[a, axis] != x[b, axis]:
            return -1 if x[a, axis] < x[b, axis] else 1
        order = exact_compare(x, t, e, d, m, w, a, b, axis)
        if order != 0:
            return order
    return 0


@entry("d2 l2 l2 l2 l1 l1 l2 l1 -> .")
def lie_inside(x, t, e, d, m, w, rows, out):
    """out[i] = 1 if point rows[i, 0] lies on the segment of the two others and is no end of it."""
    for i in range(rows.shape[0]):
        p, a, b = rows[i, 0], rows[i, 1], rows[i, 2]
        out[i] = 0
        if (
            exact_orient2d(x, t, e, d, m, w, a, b, p, 0, 1) == 0
            and exact_orient2d(x, t, e, d, m, w, a, b, p, 1, 2) == 0
            and exact_orient2d(x, t, e, d, m, w, a, b, p, 2, 0) == 0
            and _order(x, t, e, d, m, w, a, p) * _order(x, t, e, d, m, w, p, b) > 0
        ):
            out[i] = 1
