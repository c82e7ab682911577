"""Circles through the local points of a face: is a fourth point inside? Ties are broken uniquely.

Letters as in `delaunay`. The stages are those of `face_signs`: doubles, definitions,
double-doubles, integers.
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.cutting.cached_predicates import cached_compare, cached_incircle
from geosurf.kernels.cutting.face_signs import (
    TINY_DD,
    difference,
    precedes,
    refine_point,
)
from geosurf.kernels.cutting.symbolic import equal_by_construction
from geosurf.kernels.exact.double_double import dd_add, dd_minor, dd_mul
from geosurf.kernels.exact.predicates import INCIRCLE_BOUND, TINY, certified_sign


@scalar
def in_circle(frame, points, a, b, c, o):
    """Whether o is inside the circle of a, b, c; a tie is decided by the lowest of the four."""
    f = points.f
    sign = filtered_circle(f, a, b, c, o)
    if sign == 0:
        return exact_in_circle(frame, points, a, b, c, o)
    return sign > 0


@scalar
def exact_in_circle(frame, points, a, b, c, o):
    """Whether o is inside the circle of a, b, c, where doubles are undecided."""
    sign = exact_circle(frame, points, a, b, c, o)
    if sign != 0:
        return sign > 0
    # the current diagonal is a-b, the other one c-o
    # A tie: the diagonal at the lowest point wins.
    lowest_end = a if precedes(frame, points, a, b) else b
    other = c if precedes(frame, points, c, o) else o
    return precedes(frame, points, other, lowest_end)


@scalar
def filtered_circle(f, a, b, c, o):
    """Sign > 0 where o is inside the circle of counter-clockwise a, b, c; 0 if undecided.

    With a single array, for the same reason as `filtered_turn`.
    """
    # The determinant relative to o, which removes one row.
    au, av = f[a, 0] - f[o, 0], f[a, 1] - f[o, 1]
    bu, bv = f[b, 0] - f[o, 0], f[b, 1] - f[o, 1]
    cu, cv = f[c, 0] - f[o, 0], f[c, 1] - f[o, 1]
    la, lb, lc = au * au + av * av, bu * bu + bv * bv, cu * cu + cv * cv
    p, r = bu * cv, cu * bv
    g, y = cu * av, au * cv
    i, j = au * bv, bu * av
    det = la * (p - r) + lb * (g - y) + lc * (i - j)
    size = la * (abs(p) + abs(r)) + lb * (abs(g) + abs(y)) + lc * (abs(i) + abs(j))

    # The bound: rounding of the arithmetic, then errors of the points.
    # Vertices have no error, so most faces skip this term.
    slip = f[a, 2] + f[b, 2] + f[c, 2] + f[o, 2]
    bound = INCIRCLE_BOUND * size
    if slip > 0.0:
        z = max(max(abs(au), abs(av)), max(max(abs(bu), abs(bv)), max(abs(cu), abs(cv))))
        bound += _incircle_slip(z, slip)
    return certified_sign(det, bound) if size > TINY else 0


@scalar
def exact_circle(frame, points, a, b, c, o):
    """Side of the circle where doubles are undecided: definitions, double-doubles, integers."""
    # Four points of a grid lie on one circle: proven without the determinant.
    if _rectangle(frame, points, a, b, c, o):
        return 0
    sign = _incircle_dd(frame, points, a, b, c, o)
    if sign == 0:
        sign = cached_incircle(frame, points, a, b, c, o)
    return sign


@scalar
def _incircle_slip(z, slip):
    """Error of the determinant for differences of size <= z with errors below slip.

    It has twelve terms of degree four in these differences.
    """
    return (
        1.1
        * slip
        * (z * (z * (48.0 * z + 72.0 * slip) + 48.0 * slip * slip) + 12.0 * slip * slip * slip)
    )


@scalar
def _rectangle(frame, points, a, b, c, o):
    """Whether a-b and c-o are the diagonals of an axis-parallel rectangle.

    Model grids contain many; equal coordinates are cheaper to prove than one circle.
    """
    f = points.f
    # Which of c, o shares the first coordinate with a, by rounded values.
    one, two = (c, o) if f[a, 0] == f[c, 0] else (o, c)  # `one` has the first coordinate of a
    if f[a, 0] != f[one, 0] or f[b, 0] != f[two, 0] or f[a, 1] != f[two, 1] or f[b, 1] != f[one, 1]:
        return False
    return (
        _equal(frame, points, a, one, 0)
        and _equal(frame, points, b, two, 0)
        and _equal(frame, points, a, two, 1)
        and _equal(frame, points, b, one, 1)
    )


@scalar
def _equal(frame, points, a, b, second):
    """Whether coordinates U or V with equal rounded values are equal."""
    f = points.f
    # Neither has an error on this axis: equal doubles are equal numbers.
    if f[a, 3 + second] == 0.0 and f[b, 3 + second] == 0.0:
        return True
    if equal_by_construction(frame, points, a, b, second):
        return True
    return cached_compare(frame, points, a, b, second) == 0


@scalar
def _incircle_dd(frame, points, a, b, c, o):
    """Sign of the determinant in double-doubles, 0 if undecided.

    The arithmetic has an error of less than 2**-95 of the terms: products of four factors, each
    with an error of at most 2**-100, and their sums. Errors of the points are those of
    `refine_point`.
    """
    f = points.f
    refine_point(frame, points, a)
    refine_point(frame, points, b)
    refine_point(frame, points, c)
    refine_point(frame, points, o)

    # Differences, minors and squared lengths, then their three products.
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

    # Bound of the determinant from the sizes of all terms.
    # The terms are larger than their sum; the bound has to follow the terms.
    size = la * (abs(bu * cv) + abs(cu * bv))
    size += lb * (abs(cu * av) + abs(au * cv))
    size += lc * (abs(au * bv) + abs(bu * av))
    slip = f[a, 7] + f[b, 7] + f[c, 7] + f[o, 7]
    z = max(max(abs(au), abs(av)), max(max(abs(bu), abs(bv)), max(abs(cu), abs(cv))))
    bound = 2.0**-95 * size + _incircle_slip(z, slip)
    return certified_sign(det, bound) if size > TINY_DD else 0
