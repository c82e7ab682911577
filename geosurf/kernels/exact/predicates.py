"""Orientation predicates: a floating-point filter first, exact integers where it cannot decide.

The sign that is returned is always the sign of the exact determinant of the input coordinates.

Sign conventions
    orient2d(a, b, c)      > 0 where a, b, c turn counter-clockwise on axes (u, v)
    orient3d(a, b, c, o)   > 0 where o sees a, b, c counter-clockwise: (b-a) x (c-a) . (o-a) > 0

The filters and their error bounds are those of Shewchuk (1997), section 4, bounds A.
Letters as in `exact_signs`.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.errors import SurfaceError
from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.bigint import BITS, clear, mul_add, sign
from geosurf.kernels.exact.exact_signs import (
    LIMBS,
    N_META,
    N_VERTEX,
    NEAR,
    SCALE,
    Frame,
    exact_compare,
    exact_normal_axis,
    exact_orient2d,
    exact_orient2d_vertices,
    exact_orient3d,
    plane,
    point,
    workspace,
)

_EPS = 2.0**-53
ORIENT2D_BOUND = (3.0 + 16.0 * _EPS) * _EPS
ORIENT3D_BOUND = (7.0 + 56.0 * _EPS) * _EPS
INCIRCLE_BOUND = (10.0 + 96.0 * _EPS) * _EPS
TINY = 1e-270  # below it products may underflow, and error bounds do not hold
MAX_BITS = 980
# For input of constructed points: products of three coordinates and their rounding errors are
# normal numbers, so that the error bounds of doubles and double-doubles hold.
MAX_SCALE = 300
MIN_COORDINATE = 1e-74  # has all of its 53 digits above 2**-MAX_SCALE
MAX_COORDINATE = 2.0**60
VALID_SIZES = (
    f"exact arithmetic takes 0 and sizes from {MIN_COORDINATE:g} to "
    f"{MAX_COORDINATE:.2g} m. Set numbers that mean zero to zero"
)
_BLOCK = 256  # coordinates that are tested together


@scalar
def certified_sign(value, bound):
    """Sign of a number with an error of at most `bound`; 0 where the bound allows both signs."""
    # Comparisons with NaN are false: an overflow counts as undecided.
    if value > bound:
        return 1
    return -1 if -value > bound else 0


@scalar
def orient2d(x, m, w, a, b, c, u, v):
    """Sign of the turn of three *vertices* on axes (u, v)."""
    # The filter.
    left = (x[b, u] - x[a, u]) * (x[c, v] - x[a, v])
    right = (x[b, v] - x[a, v]) * (x[c, u] - x[a, u])
    # Shewchuk's bound A, relative to the sum of both products.
    det = left - right
    size = abs(left) + abs(right)
    sign = certified_sign(det, ORIENT2D_BOUND * size) if size > TINY else 0
    if sign != 0:
        return sign

    # Three points on a line of the grid: zero without long integers.
    if (x[a, u] == x[b, u] and x[b, u] == x[c, u]) or (x[a, v] == x[b, v] and x[b, v] == x[c, v]):
        return 0
    return exact_orient2d_vertices(x, m, w, a, b, c, u, v)


@scalar
def plane_terms(x, a, b, c):
    """Normal of vertices a, b, c, the magnitudes of its terms, and a span: input of `side_of`."""
    ax, ay, az = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    bx, by, bz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]

    # Each component of the normal is a difference of two products.
    p, q = ay * bz, az * by
    r, s = az * bx, ax * bz
    g, h = ax * by, ay * bx
    span = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
    return p - q, r - s, g - h, abs(p) + abs(q), abs(r) + abs(s), abs(g) + abs(h), span


@scalar
def filtered_side(cx, cy, cz, n0, n1, n2, s0, s1, s2, span, slip):
    """Side of a plane on which a point lies, at c from one of its points; 0 if undecided.

    `n0` to `span` are `plane_terms`. A side other than 0 stays the same under any move of all
    coordinates by up to `slip`.
    """
    det = cx * n0 + cy * n1 + cz * n2
    size = abs(cx) * s0 + abs(cy) * s1 + abs(cz) * s2
    reach = abs(cx) + abs(cy) + abs(cz)

    # Rounding errors, and how far the determinant changes if every coordinate moves by `slip`.
    bound = ORIENT3D_BOUND * size + 2.0 * slip * (s0 + s1 + s2 + reach * span)
    return certified_sign(det, bound) if size > TINY else 0


@scalar
def side_of(x, m, w, a, b, c, o, terms, slip):
    """Sign of the side of the plane of vertices a, b, c on which vertex o lies.

    A sign that could change if all coordinates moved by up to `slip` is computed exactly. It is
    counted in ``m[NEAR]`` where it is not zero.
    """
    n0, n1, n2, s0, s1, s2, span = terms
    cx, cy, cz = x[o, 0] - x[a, 0], x[o, 1] - x[a, 1], x[o, 2] - x[a, 2]
    side = filtered_side(cx, cy, cz, n0, n1, n2, s0, s1, s2, span, slip)
    if side != 0:
        return side

    # Points on a plane across an axis (a wall, a contact, a row of a grid) need no integers.
    for k in range(3):
        if x[a, k] == x[o, k] and x[b, k] == x[o, k] and x[c, k] == x[o, k]:
            return 0
    if coplanar_by_zeros(x, a, b, c, o):
        return 0
    sign = exact_orient3d(x, m, w, a, b, c, o)

    # Not on the plane, but so near that a move of the points could change the side: the caller
    # finds such pairs by this counter.
    if sign != 0:
        m[NEAR] += 1
    return sign


@scalar
def coplanar_by_zeros(x, a, b, c, o):
    """Whether each term of the determinant of four vertices contains a factor zero.

    Extruded surfaces have many such vertices; this test saves the exact determinant. It is exact:
    a difference of doubles is zero only for equal numbers (gradual underflow).
    """
    ax, ay, az = x[b, 0] != x[a, 0], x[b, 1] != x[a, 1], x[b, 2] != x[a, 2]
    bx, by, bz = x[c, 0] != x[a, 0], x[c, 1] != x[a, 1], x[c, 2] != x[a, 2]
    n0 = (ay and bz) or (az and by)
    n1 = (az and bx) or (ax and bz)
    n2 = (ax and by) or (ay and bx)
    for p in (a, b, c):  # the height over the plane is the same from any of its points
        if not (
            (n0 and x[o, 0] != x[p, 0])
            or (n1 and x[o, 1] != x[p, 1])
            or (n2 and x[o, 2] != x[p, 2])
        ):
            return True
    return False


@scalar
def orient3d(x, m, w, a, b, c, o, slip):
    """Sign of the side on which vertex o lies of the plane of vertices a, b, c."""
    return side_of(x, m, w, a, b, c, o, plane_terms(x, a, b, c), slip)


@scalar
def normal_axis(x, m, w, a, b, c):
    """Axis of the largest component of a normal, and its sign; the first axis wins ties."""
    ax, ay, az = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    bx, by, bz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    n0, n1, n2 = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    size = max(
        abs(ay * bz) + abs(az * by), max(abs(az * bx) + abs(ax * bz), abs(ax * by) + abs(ay * bx))
    )

    # The largest component, and the second largest: the filter needs their gap.
    axis = 0
    best = abs(n0)
    second = 0.0
    value = n0
    if abs(n1) > best:
        second = best
        axis, best, value = 1, abs(n1), n1
    else:
        second = abs(n1)
    if abs(n2) > best:
        second = best
        axis, best, value = 2, abs(n2), n2
    else:
        second = max(second, abs(n2))

    # Both components may be off by their bound, so the gap has to exceed several of them.
    if size > TINY and best - second > 4.0 * ORIENT2D_BOUND * size:
        return axis, (1 if value > 0 else -1)
    return exact_normal_axis(x, m, w, a, b, c)


@scalar
def _lowest_bit(value):
    """Exponent of the lowest bit of a double that is not zero."""
    fraction, exponent = math.frexp(value)
    mantissa = abs(int(fraction * 9007199254740992.0))
    # A number & its negative is its lowest set bit.
    return exponent - 53 + math.frexp(float(mantissa & -mantissa))[1] - 1


@scalar
def _all_multiples(x, first, last, unit, limit):
    """Whether x[first:last] are below a limit and multiples of 1 / unit, a power of two from 1.

    Short and without branches, so that the loop is vectorised.
    """
    bad = 0
    for i in range(first, last):
        bad += int(not (abs(x[i]) < limit and x[i] * unit == np.floor(x[i] * unit)))
    return bad == 0


@entry("d1 -> l l")
def scale_of(x):
    """Least k such that all coordinates are multiples of 2**-k, and their bits at that k.

    Returns (k, bits); bits = -1 if a coordinate is not finite. Blocks of numbers are skipped where
    none is larger or has a lower bit than those before.
    """
    low = 4000
    high = -4000
    bits = x.view(np.int64)
    powers = np.zeros(2, dtype=np.float64)  # 2**-low and 2**high, where they are normal numbers
    exponents = powers.view(np.int64)

    # Skip a block that cannot change the result.
    for first in range(0, x.shape[0], _BLOCK):
        last = min(first + _BLOCK, x.shape[0])
        if -1000 < low <= 0 and high < 1000:
            # A power of two as bits: only the exponent field, which is biased by 1023.
            exponents[0], exponents[1] = (1023 - low) << 52, (1023 + high) << 52
            if _all_multiples(x, first, last, powers[0], powers[1]):
                continue

        # Read exponent and mantissa from the bits of each number.
        for i in range(first, last):
            exponent = (bits[i] >> 52) & 0x7FF
            mantissa = bits[i] & 0xFFFFFFFFFFFFF
            if exponent == 0x7FF:
                # infinite, or not a number
                return 0, -1
            if exponent == 0:
                if mantissa == 0:
                    continue
                exponent = math.frexp(x[i])[1] + 1022  # below the least normal number
            high = max(high, exponent - 1022)
            below = low - exponent + 1075  # digits of the number that are below 2**low
            if below > 0 and (below > 52 or mantissa & ((1 << below) - 1) != 0):
                low = min(low, _lowest_bit(x[i]))

    # All numbers are zero.
    if high == -4000:
        return 0, 1
    return -low, high - low


@entry("d2 l2 l1 l1* -> l1")
def flat_triangles(x, t, m, w):
    """Rows of the triangles whose area is exactly zero."""
    flat = np.empty(t.shape[0], dtype=np.int64)
    n = 0
    for i in range(t.shape[0]):
        # A normal without a largest component is zero: so is the area.
        axis, _ = normal_axis(x, m, w, t[i, 0], t[i, 1], t[i, 2])
        if axis < 0:
            flat[n] = i
            n += 1
    return flat[:n].copy()


def frame_of(x: np.ndarray, n_triangle: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return the integers `m` and the limb workspace `w` for coordinates (n, d)."""
    k, bits = scale_of(np.ravel(x))
    if bits < 0:
        raise SurfaceError("a coordinate is not finite; leave out nodes that are undefined.")
    if bits > MAX_BITS:
        raise SurfaceError(
            f"coordinates span {bits} binary digits, from tiny to huge; {VALID_SIZES}."
        )

    # Three bits to spare for sums of differences.
    m = np.zeros(N_META, dtype=np.int64)
    m[N_VERTEX] = len(x)
    m[1] = n_triangle
    m[LIMBS] = (bits + 3 + BITS - 1) // BITS
    m[SCALE] = k
    return m, workspace(m[LIMBS])


@entry("d2 l2 l1* l1* l1* -> .")
def orient2d_rows(x, rows, m, w, out):
    """out[i] = turn of the vertices rows[i] on axes (0, 1)."""
    for i in range(rows.shape[0]):
        out[i] = orient2d(x, m, w, rows[i, 0], rows[i, 1], rows[i, 2], 0, 1)


@entry("d2 l2 l1* l1* l1* -> .")
def orient3d_rows(x, rows, m, w, out):
    """out[i] = side of vertex rows[i, 3] of the plane of the first three."""
    for i in range(rows.shape[0]):
        out[i] = orient3d(x, m, w, rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3], 0.0)


# ---- collinear ----------------------------------------
# Which points lie inside which segments: an exact test, also for constructed points.
#
# Letters as in `exact_signs`. Three points are collinear in space if their projections on two pairs
# of axes are collinear (on three pairs, where they project to one point). Points of a line are in
# lexicographic order, and rounding preserves it: only equal rounded coordinates need an exact
# comparison. A segment is given with its two faces. A point off the plane of either face is
# rejected first, for a quarter of the cost.


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
