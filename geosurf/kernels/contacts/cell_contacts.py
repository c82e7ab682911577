"""How triangles of one cell meet those of a patch of another grid: heights of corners, few signs.

The height of a corner over a triangle's plane, and its distances from the triangle's edges in a
projection along an axis, are linear. So the point where an edge of another triangle passes the
plane follows from the heights of its ends, and whether it lies inside follows from two products.
All rounding bounds hold for the whole patch. Mostly both edges that pass the plane pass the face,
or one passes beyond one edge, which then ends the contact (`contact_by_heights`). Where both pass
outside, by a corner, or a sign is undecided, `decide_contact` computes the signs of
`triangle_contact`.

Notation
    c      corners in the local frame, float64 (8, 3): of a cell of the patch, then of the one cell
    v      corners (rows of c) of triangles, int64 (4, 3): 0 and 1 of the patch, 2 and 3 of the cell
    f      plane of each triangle, float64 (4, 7): see `predicates.plane_terms`
    reach  largest distance of corners of the patch from those of the one cell, by axis
    h      query for triangles 2 and 3, plane and edges: float64 (2, N_TERM)
    w      answers for corners 0 to 3: heights, then distances from each edge, float64 (4, 4)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.contacts.triangle_contact import FACE, lone_corner
from geosurf.kernels.exact.predicates import ORIENT2D_BOUND, ORIENT3D_BOUND, TINY, filtered_side
from geosurf.kernels.search.tree import N_COL, RISING, TURNED

# ---- contact table ----------------------------------------
# Codes of a contact from a table: a lookup has no branch that the processor could mispredict.
#
# The two edges at the lone corner of a triangle pass the plane of another triangle, each beyond
# some of its edges. Mostly this determines where the contact begins and ends.
#
# Notation
#     i      the lone corner of the first triangle; edge i leaves it, edge i + 2 enters it
#     side   edges of the second triangle, as bits, beyond which an edge passes; or UNKNOWN_SIDE


UNDECIDED = -2  # heights do not decide
UNKNOWN_SIDE, N_SIDE = 8, 9


@scalar
def code_of_edge(edge, of_first):
    """Code of a corner of a contact: an edge of one triangle, the face of the other."""
    return 8 * (3 + edge) + FACE if of_first else 8 * FACE + 3 + edge


@scalar
def contact_codes(swapped):
    """Results of `contact_by_heights` for each lone corner and the sides of its two edges.

    With `swapped`, codes are those of the second and the first triangle.
    """
    table = np.full(3 * N_SIDE * N_SIDE, UNDECIDED)
    for i in range(3):
        # Rows of UNKNOWN_SIDE stay UNDECIDED.
        for first in range(UNKNOWN_SIDE):
            for last in range(UNKNOWN_SIDE):
                table[(N_SIDE * i + first) * N_SIDE + last] = _codes_of_sides(
                    i, first, last, swapped
                )
    return table


@scalar
def _codes_of_sides(i, first, last, swapped):
    """Codes where edge i passes beyond the edges `first`, and edge i + 2 beyond `last`."""
    # Both beyond one edge: no contact. Both inside: two edge-face points.
    i2 = (i + 2) % 3
    if first & last != 0:
        return 0
    out = first + last
    if out == 0:
        return 64 * code_of_edge(min(i, i2), not swapped) + code_of_edge(max(i, i2), not swapped)

    # Anything but one edge passing beyond one edge needs more signs.
    if (first != 0 and last != 0) or out & (out - 1) != 0:
        return UNDECIDED

    # The edge that passes inside pierces the face. Where the other passes outside, the contact ends
    # on that edge of the second triangle.
    own, other = code_of_edge(i if last != 0 else i2, not swapped), code_of_edge(out >> 1, swapped)
    return 64 * other + own if swapped else 64 * own + other


NEEDS_EXACT = -1  # instead of the codes of a pair
# indices into h: a corner, normal, bound; axis of projection; for each edge a corner, steps, and
# the error bounds of a distance and of a product of height and distance
CORNER, NORMAL, BOUND, _AXIS, _EDGE, N_TERM = 0, 3, 6, 7, 8, 26
_OFF, _BOTH, _STEP = 4, 5, 6
_SLACK = 1.0 + 1e-9  # covers the rounding of the bounds themselves
_EPS = 2.0**-53


@scalar
def corners_of_cell(a, v, first):
    """Write the corners of both triangles of a cell into two rows of v: see `strips.corner_of`."""
    rising = a[RISING] == 1
    # Triangles 0 and 1 belong to the patch, 2 and 3 to the cell.
    for half in range(2):
        tri = half if first == 0 else 2 + half
        v[tri, 0] = first + (1 if half == 1 and not rising else 0)
        two = first + (2 if half == 1 else 1)
        three = first + (2 if half == 0 and rising else 3)
        v[tri, 1] = three if a[TURNED] == 1 else two
        v[tri, 2] = two if a[TURNED] == 1 else three


@scalar
def plane_of(c, f, tri, v):
    """Write the plane terms of a triangle; whether all its corners exist."""
    o, p, q = v[tri, 0], v[tri, 1], v[tri, 2]
    ax, ay, az = c[p, 0] - c[o, 0], c[p, 1] - c[o, 1], c[p, 2] - c[o, 2]
    bx, by, bz = c[q, 0] - c[o, 0], c[q, 1] - c[o, 1], c[q, 2] - c[o, 2]
    p0, q0 = ay * bz, az * by
    p1, q1 = az * bx, ax * bz
    p2, q2 = ax * by, ay * bx
    f[tri, 0], f[tri, 1], f[tri, 2] = p0 - q0, p1 - q1, p2 - q2
    f[tri, 3], f[tri, 4], f[tri, 5] = abs(p0) + abs(q0), abs(p1) + abs(q1), abs(p2) + abs(q2)
    f[tri, 6] = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)

    # NaN marks a missing corner.
    total = ax + ay + az + bx + by + bz
    return total == total


@scalar
def _main_axis(f, tri, slip):
    """Axis of the largest component of a normal, and its sign; 0 if undecided."""
    # The sign is certain if the component exceeds its rounding error and any slip.
    axis = 0
    for k in range(1, 3):
        axis = k if abs(f[tri, k]) > abs(f[tri, axis]) else axis
    bound = _SLACK * (ORIENT2D_BOUND * f[tri, 3 + axis] + 2.0 * slip * f[tri, 6]) + TINY
    if not abs(f[tri, axis]) > bound:
        return axis, 0
    return axis, (1 if f[tri, axis] > 0.0 else -1)


@scalar
def set_plane_query(c, f, v, tri, reach, slip, h):
    """Write the query for the plane of a triangle, with the rounding bound of its answers.

    An answer beyond the bound holds under any move of all coordinates by up to `slip`. False where
    a corner is missing.
    """
    if not plane_of(c, f, tri, v):
        return False

    # One bound for all corners of the patch, from their largest distances.
    far = reach[0] + reach[1] + reach[2]
    own = f[tri, 3] + f[tri, 4] + f[tri, 5]
    height = _largest_height(f, tri, reach)
    h[BOUND] = _SLACK * (ORIENT3D_BOUND * height + 2.0 * slip * (own + far * f[tri, 6])) + TINY
    for k in range(3):
        h[CORNER + k], h[NORMAL + k] = c[v[tri, 0], k], f[tri, k]
    return True


@scalar
def _largest_height(f, tri, reach):
    """Upper bound of the terms of a height over a triangle."""
    return reach[0] * f[tri, 3] + reach[1] * f[tri, 4] + reach[2] * f[tri, 5]


@scalar
def set_edge_query(c, f, v, tri, reach, slip, h):
    """Write the query for the edges of a triangle, in a projection; after `set_plane_query`."""
    # Orient the edges so that inside is positive.
    height, off = _largest_height(f, tri, reach), h[BOUND]
    axis, turn = _main_axis(f, tri, slip)
    h[_AXIS] = axis
    # Along the largest component of its normal, a triangle projects without collapsing.
    u, w = (axis + 1) % 3, (axis + 2) % 3
    for k in range(3):
        p, q = v[tri, k], v[tri, (k + 1) % 3]
        at = _EDGE + _STEP * k
        on, up = turn * (c[q, u] - c[p, u]), turn * (c[q, w] - c[p, w])
        h[at], h[at + 1], h[at + 2], h[at + 3] = c[p, u], c[p, w], on, up

        # Largest distance from the edge, and its rounding error.
        inside = abs(on) * reach[w] + abs(up) * reach[u]
        far = abs(on) + abs(up) + reach[u] + reach[w] + 4.0 * slip
        error = _SLACK * (ORIENT2D_BOUND * inside + 2.0 * slip * far) + TINY
        # of a difference of two products of a height and a distance
        both = height * error + off * (inside + error) + 4.0 * _EPS * height * inside
        # Without a certain direction of the normal every answer counts as undecided.
        h[at + _OFF] = np.inf if turn == 0 else error
        h[at + _BOTH] = np.inf if turn == 0 else 2.0 * _SLACK * both + TINY


@scalar
def edge_distances(c, h, w):
    """Distances of corners 0 to 3 inside each edge of a triangle, in a projection along an axis.

    False if all of them are certainly beyond one edge.
    """
    # The columns are constants, so that the loop can be specialised for each projection.
    if h[_AXIS] == 0.0:
        return _insides(c, 1, 2, h, w)
    if h[_AXIS] == 1.0:
        return _insides(c, 2, 0, h, w)
    return _insides(c, 0, 1, h, w)


@scalar
def _insides(c, u, v, h, w):
    for k in range(3):
        at = _EDGE + _STEP * k
        p, q, on, up, off = h[at], h[at + 1], h[at + 2], h[at + 3], h[at + _OFF]
        one = on * (c[0, v] - q) - up * (c[0, u] - p)
        two = on * (c[1, v] - q) - up * (c[1, u] - p)
        three = on * (c[2, v] - q) - up * (c[2, u] - p)
        four = on * (c[3, v] - q) - up * (c[3, u] - p)
        # `&` evaluates all four: branches could be mispredicted.
        if (one < -off) & (two < -off) & (three < -off) & (four < -off):
            return False
        w[1 + k, 0], w[1 + k, 1], w[1 + k, 2], w[1 + k, 3] = one, two, three, four
    return True


@scalar
def _side(c, f, tri, o, corner, slip):
    """Side of the plane of a triangle with corner o on which another corner lies, or 0."""
    cx, cy, cz = c[corner, 0] - c[o, 0], c[corner, 1] - c[o, 1], c[corner, 2] - c[o, 2]
    return filtered_side(
        cx, cy, cz, f[tri, 0], f[tri, 1], f[tri, 2], f[tri, 3], f[tri, 4], f[tri, 5], f[tri, 6],
        slip,
    )  # fmt: skip


@scalar
def _order(c, p, p1, q, q1, slip):
    """Sign that orders, on the common line, the points of edges p-p1 and q-q1; or 0."""
    ax, ay, az = c[p1, 0] - c[p, 0], c[p1, 1] - c[p, 1], c[p1, 2] - c[p, 2]
    bx, by, bz = c[q, 0] - c[p, 0], c[q, 1] - c[p, 1], c[q, 2] - c[p, 2]
    # Plane of p, p1, q; q1 lies on the side that tells which edge passes first.
    g, h = ay * bz, az * by
    r, s = az * bx, ax * bz
    u, v = ax * by, ay * bx
    span = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
    cx, cy, cz = c[q1, 0] - c[p, 0], c[q1, 1] - c[p, 1], c[q1, 2] - c[p, 2]
    return filtered_side(
        cx, cy, cz, g - h, r - s, u - v, abs(g) + abs(h), abs(r) + abs(s), abs(u) + abs(v), span,
        slip,
    )  # fmt: skip


@scalar
def _outside(w, p, q, h):
    """Edges of a triangle, as bits, beyond which an edge p-q passes its plane; or UNKNOWN_SIDE.

    The heights of p and q over the plane have opposite signs.
    """
    # Interpolate the distances at the plane, multiplied by the heights of both ends.
    one, two = abs(w[0, p]), abs(w[0, q])
    first, second, third = (
        one * w[1, q] + two * w[1, p],
        one * w[2, q] + two * w[2, p],
        one * w[3, q] + two * w[3, p],
    )
    certified = (
        (abs(first) > h[_EDGE + _BOTH])
        & (abs(second) > h[_EDGE + _STEP + _BOTH])
        & (abs(third) > h[_EDGE + 2 * _STEP + _BOTH])
    )

    # Bit k is set where the edge passes outside edge k of the triangle.
    out = (1 if first < 0.0 else 0) + (2 if second < 0.0 else 0) + (4 if third < 0.0 else 0)
    return out if certified else UNKNOWN_SIDE


@scalar
def contact_by_heights(w, v, one, h, codes_table):
    """How triangle `one` meets that of h: 0 if not, UNDECIDED, or two codes in one number.

    `codes_table` is from `contact_codes`: a table lookup has no branch to mispredict.
    """
    # All heights have to be certain; two edges pass the plane or none.
    p, q, r = v[one, 0], v[one, 1], v[one, 2]
    a, b, c = w[0, p], w[0, q], w[0, r]
    if not ((abs(a) > h[BOUND]) & (abs(b) > h[BOUND]) & (abs(c) > h[BOUND])):
        return UNDECIDED
    one_two, two_three = (a > 0.0) != (b > 0.0), (b > 0.0) != (c > 0.0)
    if not (one_two | two_three):
        return 0
    # edge k joins corner k to the next; two of them pass the plane
    if one_two & two_three:
        i, first, last = 1, _outside(w, q, r, h), _outside(w, p, q, h)
    elif one_two:
        i, first, last = 0, _outside(w, p, q, h), _outside(w, r, p, h)
    else:
        i, first, last = 2, _outside(w, r, p, h), _outside(w, q, r, h)
    return codes_table[(N_SIDE * i + first) * N_SIDE + last]


@scalar
def _apart_on(c, axis, o, p, q, r, s, t):
    """Whether triangles o p q and r s t are apart on one axis, by more than a distance."""
    low = min(c[o, axis], min(c[p, axis], c[q, axis]))
    high = max(c[o, axis], max(c[p, axis], c[q, axis]))
    least = min(c[r, axis], min(c[s, axis], c[t, axis]))
    most = max(c[r, axis], max(c[s, axis], c[t, axis]))
    return low > most or least > high


@scalar
def _boxes_apart(c, v, one, two):
    """Whether the boxes of two triangles do not meet."""
    o, p, q = v[one, 0], v[one, 1], v[one, 2]
    r, s, t = v[two, 0], v[two, 1], v[two, 2]
    return (
        _apart_on(c, 2, o, p, q, r, s, t)
        or _apart_on(c, 0, o, p, q, r, s, t)
        or _apart_on(c, 1, o, p, q, r, s, t)
    )


@scalar
def _add_codes(codes, i, i2, on_first, on_last, of_first):
    """Append the codes of a triangle's edges i and i2 through the face of the other."""
    for k in range(3):
        if (k == i and on_first) or (k == i2 and on_last):
            codes = 64 * codes + code_of_edge(k, of_first)
    return codes


@scalar
def decide_contact(c, f, v, one, two, slip, swapped):
    """How two triangles meet: 0 if not, NEEDS_EXACT, or two codes in one number.

    The same signs in the same order as in `triangle_contact._meet_filtered`.
    """
    # Boxes first, then sides of corners over both planes.
    if _boxes_apart(c, v, one, two) or not plane_of(c, f, one, v):
        return 0
    o, p = v[two, 0], v[one, 0]
    a0 = _side(c, f, two, o, v[one, 0], slip)
    a1 = _side(c, f, two, o, v[one, 1], slip)
    a2 = _side(c, f, two, o, v[one, 2], slip)
    # A zero means undecided here: exact signs tell touching from near.
    if a0 * a1 * a2 == 0:
        return NEEDS_EXACT
    if a0 == a1 and a1 == a2:
        return 0
    b0 = _side(c, f, one, p, v[two, 0], slip)
    b1 = _side(c, f, one, p, v[two, 1], slip)
    b2 = _side(c, f, one, p, v[two, 2], slip)
    if b0 * b1 * b2 == 0:
        return NEEDS_EXACT
    if b0 == b1 and b1 == b2:
        return 0

    # Each triangle has one lone corner; four signs order the ends on the common line.
    i, j = lone_corner(a0, a1, a2), lone_corner(b0, b1, b2)
    i2, j2 = (i + 2) % 3, (j + 2) % 3
    p, p1, p2 = v[one, i], v[one, (i + 1) % 3], v[one, i2]
    q, q1, q2 = v[two, j], v[two, (j + 1) % 3], v[two, j2]
    s11, s12 = _order(c, p, p1, q, q1, slip), _order(c, p, p1, q, q2, slip)
    s21, s22 = _order(c, p, p2, q, q1, slip), _order(c, p, p2, q, q2, slip)
    if s11 * s12 * s21 * s22 == 0:
        return NEEDS_EXACT
    # Both ends of one part come before both ends of the other: the parts do not overlap.
    if s11 == s12 and s21 == s22 and s11 == s21:
        return 0

    # Codes of the ends: edges of both triangles in the order of `triangle_contact`.
    if swapped:
        codes = _add_codes(0, j, j2, s11 != s21, s12 != s22, True)
        return _add_codes(codes, i, i2, s11 != s12, s21 != s22, False)
    codes = _add_codes(0, i, i2, s11 != s12, s21 != s22, True)
    return _add_codes(codes, j, j2, s11 != s21, s12 != s22, False)


# ---- column pairs ----------------------------------------
# Pairs of triangles of one cell and of the patch below or above it of a grid with axes.
#
# For rows of the patch at the height of the cell, the heights of all nodes over the planes of both
# triangles of the cell are computed. A cell of the patch with all nodes certainly above or below a
# plane is skipped, and so is one beyond an edge of the triangle. The few others are compared by
# `cell_contacts`.
#
# Notation, in addition to that of `cell_contacts` and `axis_grids`
#     box      of the cell, float64 (6,), in the world
#     heights  of nodes, float64 (4, n): two rows, this one and the last, over both planes
#     marks    of nodes, int64 (2, n): bits for above and below each plane, and the box
#     rows     lowest and highest node of each row of the patch, float64 (2, n)
#     present  which triangles of the cell have three nodes, as bits


_FIRST, _SECOND, _BOX = 3, 12, 48  # bits of marks: above and below
_ALL = _FIRST | _SECOND | _BOX  # of a missing node: it leaves the decision to the others of a cell


class AxisGrid(NamedTuple):
    """Side A: a grid with straight rising axes."""

    x: np.ndarray  # coordinates and their layout, as in `tree`
    y: np.ndarray
    z: np.ndarray
    a: np.ndarray
    nodes: np.ndarray  # its pyramid of boxes
    levels: np.ndarray
    pace_x: float  # cells per metre
    pace_y: float


class CellQuery(NamedTuple):
    """What one cell of side B asks."""

    box: np.ndarray
    reach: np.ndarray
    origin: np.ndarray
    slip: float
    swapped: bool


class Work(NamedTuple):
    """Scratch arrays: see the notation here and in `cell_contacts`."""

    c: np.ndarray
    f: np.ndarray
    v: np.ndarray
    h: np.ndarray
    w: np.ndarray
    codes_table: np.ndarray
    heights: np.ndarray
    marks: np.ndarray
    rows: np.ndarray


@scalar
def _extremes_of_rows(z, a, at, rows):
    """Lowest and highest node of each row of the patch; NaN nodes are skipped.

    Column by column: the rows are far apart in memory, and are then loaded side by side.
    """
    n = at[1] - at[0] + 1
    for i in range(n):
        rows[0, i], rows[1, i] = np.inf, -np.inf
    # Columns outside, rows inside: see above.
    for j in range(at[2], at[3] + 1):
        start = a[6] + at[0] * a[7] + j * a[8]
        for i in range(n):
            value = z[start + i * a[7]]
            rows[0, i] = value if value < rows[0, i] else rows[0, i]
            rows[1, i] = value if value > rows[1, i] else rows[1, i]


@scalar
def _evaluate_row(grid, i, first, last, query, work):
    """Heights of the nodes of row i, columns first to last, over both planes; and their marks."""
    x, y, z, a = grid.x, grid.y, grid.z, grid.a
    origin, box = query.origin, query.box
    h, heights, marks = work.h, work.heights, work.marks
    # Two rows of scratch in turns: a row of cells needs its lower and its upper nodes.
    row = i & 1

    # Local names keep the loop free of index arithmetic, so that it is vectorised.
    x0, z0, nx, nz = h[0, CORNER], h[0, CORNER + 2], h[0, NORMAL], h[0, NORMAL + 2]
    x1, z1, mx, mz = h[1, CORNER], h[1, CORNER + 2], h[1, NORMAL], h[1, NORMAL + 2]
    far, off = h[0, BOUND], h[1, BOUND]
    ox, oz, roof, floor = origin[0], origin[2], box[5], box[2]
    level = y[i] - origin[1]
    # Northing is constant along a row: its term is computed once per plane.
    ny = (level - h[0, CORNER + 1]) * h[0, NORMAL + 1]
    my = (level - h[1, CORNER + 1]) * h[1, NORMAL + 1]
    # The loop has no branch on the data; marks are sums of selections.
    start, step = a[6] + i * a[7] + first * a[8], a[8]
    for k in range(last - first + 1):
        value = z[start + k * step]
        u, w = x[first + k] - ox, value - oz
        p = (u - x0) * nx + ny + (w - z0) * nz
        q = (u - x1) * mx + my + (w - z1) * mz
        heights[2 * row, k], heights[2 * row + 1, k] = p, q

        # Two bits per plane and for the box: above and below.
        mark = (1 if p > far else 0) + (2 if p < -far else 0)
        mark += (4 if q > off else 0) + (8 if q < -off else 0)
        mark += (16 if value > roof else 0) + (32 if value < floor else 0)
        marks[row, k] = mark if value == value else _ALL


@scalar
def _load_patch_cell(x, y, z, a, i, j, origin, c):
    """Load the corners of a cell of the patch into the first four rows of c."""
    at = a[6] + i * a[7] + j * a[8]
    c[0, 0] = c[3, 0] = x[j] - origin[0]
    c[1, 0] = c[2, 0] = x[j + 1] - origin[0]
    c[0, 1] = c[1, 1] = y[i] - origin[1]
    c[2, 1] = c[3, 1] = y[i + 1] - origin[1]
    c[0, 2], c[1, 2] = z[at] - origin[2], z[at + a[8]] - origin[2]
    c[2, 2], c[3, 2] = z[at + a[7] + a[8]] - origin[2], z[at + a[7]] - origin[2]


@scalar
def _add_pair(pairs, n, key_a, key_b, codes, swapped):
    # Beyond the capacity pairs are only counted; the caller repeats with larger arrays.
    if n < pairs.shape[0]:
        pairs[n, 0] = key_b if swapped else key_a
        pairs[n, 1] = key_a if swapped else key_b
        pairs[n, 2] = codes
    return n + 1


@scalar
def _pairs_of_cell(work, row, k, other, key_a, key_b, query, pairs, n):
    """Pairs of both triangles of a loaded cell of the patch and one of the cell, 2 + `other`."""
    slip, swapped = query.slip, query.swapped
    c, f, v, h, w, codes_table, heights = (
        work.c,
        work.f,
        work.v,
        work.h,
        work.w,
        work.codes_table,
        work.heights,
    )

    # Heights of the four corners, counter-clockwise.
    # The lower row of nodes is the one of parity row & 1.
    low, high = 2 * (row & 1) + other, 2 - 2 * (row & 1) + other
    w[0, 0], w[0, 1] = heights[low, k], heights[low, k + 1]
    w[0, 2], w[0, 3] = heights[high, k + 1], heights[high, k]
    # All four corners beyond one edge: neither triangle of the patch can meet this one.
    if not edge_distances(c, h[other], w):
        return n
    for half in range(2):
        codes = contact_by_heights(w, v, half, h[other], codes_table)
        if codes == UNDECIDED:
            codes = decide_contact(c, f, v, half, 2 + other, slip, swapped)
        if codes != 0:
            n = _add_pair(pairs, n, key_a + half, key_b + other, codes, swapped)
    return n


@scalar
def _set_plane_queries(c, f, v, reach, slip, h):
    """Set the queries of both triangles of the cell; which of them exist, as bits."""
    present = 0
    for other in range(2):
        if set_plane_query(c, f, v, 2 + other, reach, slip, h[other]):
            present |= 1 << other
        else:
            # A missing triangle: with a zero normal and bound, no node is marked above or below.
            h[other, : BOUND + 1] = 0.0
    return present


@scalar
def _pairs_of_row(grid, i, first, last, present, key_b, query, work, asked, pairs, n):
    """Pairs of the cells of row i of the patch; and the triangles whose edge queries are set."""
    x, y, z, a = grid.x, grid.y, grid.z, grid.a
    reach, origin, slip = query.reach, query.origin, query.slip
    c, f, v, h, marks = work.c, work.f, work.v, work.h, work.marks
    # Bits that both nodes of a column share; the right column of a cell is the left one of the
    # next.
    right = marks[0, 0] & marks[1, 0]
    for k in range(last - first):
        # A bit that all four corners share excludes the cell.
        left, right = right, marks[0, k + 1] & marks[1, k + 1]
        both = left & right
        near = (1 if both & _FIRST == 0 else 0) + (2 if both & _SECOND == 0 else 0)
        near &= present
        if near == 0 or both & _BOX != 0:
            continue

        # Compare with both triangles of the cell; edge queries are set on first use.
        _load_patch_cell(x, y, z, a, i, first + k, origin, c)
        key_a = 2 * (i * (a[N_COL] - 1) + first + k)
        for other in range(2):
            bit = 1 << other
            if near & bit == 0:
                continue
            if asked & bit == 0:
                set_edge_query(c, f, v, 2 + other, reach, slip, h[other])
                asked |= bit
            n = _pairs_of_cell(work, i, k, other, key_a, key_b, query, pairs, n)
    return n, asked


@scalar
def pairs_in_columns(grid, at, key_b, query, work, pairs, n):
    """Pairs of triangles of a loaded cell of B and the cells of A below or above it, `at`."""
    z, a = grid.z, grid.a
    box, reach, slip = query.box, query.reach, query.slip
    c, f, v, h, rows = work.c, work.f, work.v, work.h, work.rows

    # Triangles that exist (-1: unknown), those with edge queries, last evaluated row.
    present, asked, last_row = (-1, 0, -1)
    first, last = at[2], at[3]
    _extremes_of_rows(z, a, at, rows)
    for i in range(at[0], at[1]):
        # Skip rows of cells above or below the box.
        k = i - at[0]
        low, high = min(rows[0, k], rows[0, k + 1]), max(rows[1, k], rows[1, k + 1])
        if not (low <= box[5] and box[2] <= high):
            continue
        # Planes are set up for the first row that is near, which most cells never reach.
        if present < 0:
            present = _set_plane_queries(c, f, v, reach, slip, h)
        if present == 0:
            return n

        # Neighbouring rows of cells share a row of nodes.
        if last_row != i:
            _evaluate_row(grid, i, first, last, query, work)
        _evaluate_row(grid, i + 1, first, last, query, work)
        last_row = i + 1
        n, asked = _pairs_of_row(grid, i, first, last, present, key_b, query, work, asked, pairs,
        n)  # fmt: skip
    return n
