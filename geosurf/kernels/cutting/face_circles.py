"""Circles through the local points of a face: whether a fourth one is inside, ties included.

Letters as in `delaunay`, and the same order of questions as in `signs`: doubles, names,
double-doubles, integers.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.cutting.cached_predicates import kept_compare, kept_incircle
from geosurf.kernels.cutting.face_signs import (
    AXIS,
    N_STATE,
    TINY_DOUBLED,
    add_local,
    difference,
    lower,
    refine,
    turn,
)
from geosurf.kernels.cutting.symbolic import KNOWN, made_alike
from geosurf.kernels.exact.double_double import dd_add, dd_minor, dd_mul
from geosurf.kernels.exact.predicates import INCIRCLE_BOUND, TINY, sure_sign


@scalar
def in_circle(x, t, e, d, m, w, q, f, s, a, b, c, o):
    """Whether o is inside the circle of a, b, c; a tie goes to the lowest of the four."""
    sign = plain_circle(f, a, b, c, o)
    if sign == 0:
        return in_circle_closely(x, t, e, d, m, w, q, f, s, a, b, c, o)
    return sign > 0


@scalar
def in_circle_closely(x, t, e, d, m, w, q, f, s, a, b, c, o):
    """Whether o is inside the circle of a, b, c, where doubles cannot tell."""
    sign = _circle_closely(x, t, e, d, m, w, q, f, s, a, b, c, o)
    if sign != 0:
        return sign > 0
    # the edge to flip is a-b, the other diagonal c-o
    kept = a if lower(x, t, e, d, m, w, q, f, s, a, b) else b
    other = c if lower(x, t, e, d, m, w, q, f, s, c, o) else o
    return lower(x, t, e, d, m, w, q, f, s, other, kept)


@scalar
def plain_circle(f, a, b, c, o):
    """Sign > 0 where o is inside the circle of counter-clockwise a, b, c; 0 if doubles cannot tell.

    With one array, as `plain_turn`.
    """
    au, av = f[a, 0] - f[o, 0], f[a, 1] - f[o, 1]
    bu, bv = f[b, 0] - f[o, 0], f[b, 1] - f[o, 1]
    cu, cv = f[c, 0] - f[o, 0], f[c, 1] - f[o, 1]
    la, lb, lc = au * au + av * av, bu * bu + bv * bv, cu * cu + cv * cv
    p, r = bu * cv, cu * bv
    g, y = cu * av, au * cv
    i, j = au * bv, bu * av
    det = la * (p - r) + lb * (g - y) + lc * (i - j)
    size = la * (abs(p) + abs(r)) + lb * (abs(g) + abs(y)) + lc * (abs(i) + abs(j))
    slip = f[a, 2] + f[b, 2] + f[c, 2] + f[o, 2]
    bound = INCIRCLE_BOUND * size
    if slip > 0.0:
        z = max(max(abs(au), abs(av)), max(max(abs(bu), abs(bv)), max(abs(cu), abs(cv))))
        bound += _incircle_slip(z, slip)
    return sure_sign(det, bound) if size > TINY else 0


@scalar
def _circle_closely(x, t, e, d, m, w, q, f, s, a, b, c, o):
    """Side of the circle that doubles cannot tell: by names, by double-doubles, by integers."""
    if _rectangle(x, t, e, d, m, w, q, f, s, a, b, c, o):
        return 0
    sign = _incircle_doubled(x, t, e, d, m, q, f, s, a, b, c, o)
    if sign == 0:
        sign = kept_incircle(x, t, e, d, m, w, q, s, a, b, c, o)
    return sign


@scalar
def _incircle_slip(z, slip):
    """Error of the determinant where differences of size <= z are off by less than slip.

    Twelve terms of degree four in these differences.
    """
    return (
        1.1
        * slip
        * (z * (z * (48.0 * z + 72.0 * slip) + 48.0 * slip * slip) + 12.0 * slip * slip * slip)
    )


@scalar
def _rectangle(x, t, e, d, m, w, q, f, s, a, b, c, o):
    """Whether a-b and c-o are the diagonals of a rectangle along the axes.

    Model grids are full of them. Equal coordinates are cheaper to prove than one circle.
    """
    one, two = (c, o) if f[a, 0] == f[c, 0] else (o, c)  # `one` has the first coordinate of a
    if f[a, 0] != f[one, 0] or f[b, 0] != f[two, 0] or f[a, 1] != f[two, 1] or f[b, 1] != f[one, 1]:
        return False
    return (
        _equal(x, t, e, d, m, w, q, f, s, a, one, 0)
        and _equal(x, t, e, d, m, w, q, f, s, b, two, 0)
        and _equal(x, t, e, d, m, w, q, f, s, a, two, 1)
        and _equal(x, t, e, d, m, w, q, f, s, b, one, 1)
    )


@scalar
def _equal(x, t, e, d, m, w, q, f, s, a, b, second):
    """Whether coordinates that are equal once rounded, U or V, are equal."""
    if f[a, 3 + second] == 0.0 and f[b, 3 + second] == 0.0:
        return True
    if made_alike(x, t, e, d, m, q, s, a, b, second):
        return True
    return kept_compare(x, t, e, d, m, w, q, s, a, b, second) == 0


@scalar
def _incircle_doubled(x, t, e, d, m, q, f, s, a, b, c, o):
    """Sign of the determinant in double-doubles, 0 if they cannot be sure.

    The arithmetic errs by less than 2**-95 of the terms: products of four factors, each off by
    2**-100 at most, and their sums. Points are off as `refine` says.
    """
    refine(x, t, e, d, m, q, f, s, a)
    refine(x, t, e, d, m, q, f, s, b)
    refine(x, t, e, d, m, q, f, s, c)
    refine(x, t, e, d, m, q, f, s, o)
    au, aul, av, avl = difference(f, a, o)
    bu, bul, bv, bvl = difference(f, b, o)
    cu, cul, cv, cvl = difference(f, c, o)
    one, one_low = dd_minor(bu, bul, cv, cvl, cu, cul, bv, bvl)
    two, two_low = dd_minor(cu, cul, av, avl, au, aul, cv, cvl)
    three, three_low = dd_minor(au, aul, bv, bvl, bu, bul, av, avl)
    la, lal = dd_minor(au, aul, au, aul, av, avl, -av, -avl)
    lb, lbl = dd_minor(bu, bul, bu, bul, bv, bvl, -bv, -bvl)
    lc, lcl = dd_minor(cu, cul, cu, cul, cv, cvl, -cv, -cvl)
    det, low = dd_mul(la, lal, one, one_low)
    more, more_low = dd_mul(lb, lbl, two, two_low)
    det, low = dd_add(det, low, more, more_low)
    more, more_low = dd_mul(lc, lcl, three, three_low)
    det, low = dd_add(det, low, more, more_low)
    size = la * (abs(bu * cv) + abs(cu * bv))
    size += lb * (abs(cu * av) + abs(au * cv))
    size += lc * (abs(au * bv) + abs(bu * av))
    slip = f[a, 7] + f[b, 7] + f[c, 7] + f[o, 7]
    z = max(max(abs(au), abs(av)), max(max(abs(bu), abs(bv)), max(abs(cu), abs(cv))))
    bound = 2.0**-95 * size + _incircle_slip(z, slip)
    return sure_sign(det, bound) if size > TINY_DOUBLED else 0


@entry("d2 l2 l2 l2 l1 l1 l1 l l2 l2 -> .")
def sign_rows(x, t, e, d, m, w, ids, axis, rows, out):
    """Turn of ids[rows[i, :3]]; side of the circle of these on which the fourth is, and whether
    `in_circle` puts it inside, both 0 where they do not turn left.

    The points lie in one plane that is not upright on the axis. For tests.
    """
    q = np.empty((ids.shape[0], 8), dtype=np.int32)
    f = np.empty((ids.shape[0], 8), dtype=np.float64)
    s = np.zeros(N_STATE, dtype=np.int64)
    s[AXIS], s[KNOWN] = axis, -1
    for i in range(ids.shape[0]):
        add_local(x, t, e, d, m, q, f, s, ids[i], 0)
    for i in range(rows.shape[0]):
        a, b, c, o = rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3]
        out[i, 0] = turn(x, t, e, d, m, w, q, f, s, a, b, c)
        out[i, 1] = out[i, 2] = 0
        if out[i, 0] > 0:
            out[i, 1] = plain_circle(f, a, b, c, o)
            if out[i, 1] == 0:
                out[i, 1] = _circle_closely(x, t, e, d, m, w, q, f, s, a, b, c, o)
            if in_circle(x, t, e, d, m, w, q, f, s, a, b, c, o):
                out[i, 2] = 1
