"""Candidate pairs of two lattices with the same nodes in the map: horizons of one survey.

If no two points of a lattice share a map position, and another lattice has the same nodes, then
triangles can only meet above what they share in the map: their own triangle, one of its edges, or a
corner. What they share above an edge or a corner is also shared by the triangles of the cells on
either side, if these exist. So each cell is compared with itself only, except next to holes. A tree
would return thirteen times as many pairs (Drogon's horizons).

Letters as in `tree`; z, s elevations of the two lattices, flat.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.tree import BLOCK, N_COL, N_ROW, RISING, append_pair

_LEAST_STEP = 0.5  # of the mean step along a row or column,
_MOST_ASIDE = 0.2  # and how far a step may stray to the side
_PLAIN_ANGLE = 1e-6  # sine between rows and columns below which no bound is given
_ROUNDING = 2.0**-49  # of the largest coordinate: 16 units in the last place, for a few sums
# indices into what `map_frame` finds
HEIGHT, STEPS, OFF, FRAME_SIZE = 0, 1, 5, 6


@scalar
def _first_uneven(p, q, a, det, ux, uy, vx, vy):
    """First node with a step far from the mean one, or -1; in the frame of the mean steps."""
    n_row, n_col = a[N_ROW], a[N_COL]
    rx, ry, cx, cy = vy / det, -vx / det, -uy / det, ux / det  # rows of the inverse of M
    for i in range(n_row):
        for j in range(n_col):
            x, y = p[a[0] + i * a[1] + j * a[2]], q[a[3] + i * a[4] + j * a[5]]
            if j < n_col - 1:
                sx = p[a[0] + i * a[1] + (j + 1) * a[2]] - x
                sy = q[a[3] + i * a[4] + (j + 1) * a[5]] - y
                along, aside = rx * sx + ry * sy, cx * sx + cy * sy
                # Written so that NaN fails too: a hole leaves the map without a bound.
                if not (along >= _LEAST_STEP and abs(aside) <= _MOST_ASIDE):
                    return i * n_col + j
            if i < n_row - 1:
                sx = p[a[0] + (i + 1) * a[1] + j * a[2]] - x
                sy = q[a[3] + (i + 1) * a[4] + j * a[5]] - y
                along, aside = cx * sx + cy * sy, rx * sx + ry * sy
                if not (along >= _LEAST_STEP and abs(aside) <= _MOST_ASIDE):
                    return i * n_col + j
    return -1


@scalar
def _usable(det, ux, uy, vx, vy):
    """Whether the frame of mean steps is finite, and not nearly a line."""
    u, v = np.sqrt(ux * ux + uy * uy), np.sqrt(vx * vx + vy * vy)
    return abs(det) > _PLAIN_ANGLE * u * v and u + v < 1e300


@scalar
def _farthest(p, q, a, ux, uy, vx, vy):
    """Largest distance of a node from even steps [m], rounding included; all are numbers."""
    x0, y0 = p[a[0]], q[a[3]]
    most, size = 0.0, 0.0
    for i in range(a[N_ROW]):
        for j in range(a[N_COL]):
            x, y = p[a[0] + i * a[1] + j * a[2]], q[a[3] + i * a[4] + j * a[5]]
            dx, dy = (x - x0) - (j * ux + i * vx), (y - y0) - (j * uy + i * vy)
            most = max(most, dx * dx + dy * dy)
            size = max(size, max(abs(x), abs(y)))
    return np.sqrt(most) * (1.0 + 1e-9) + _ROUNDING * size


@entry("d1 d1 l1 -> d1")
def map_frame(p, q, a):
    """Steps of a grid in the map, and a proof that the map is one to one: see `FRAME_SIZE`.

    HEIGHT   lower bound of the height [m] of triangles in the map; 0: nothing is proven
    STEPS    mean steps along columns (x, y), then along rows
    OFF      no node is farther [m] from the first one and these steps; infinite if not proven

    In the frame of the mean steps M along rows and columns, each step must stay near its own axis.
    Then every gradient has a positive definite symmetric part, and a piecewise linear map of a
    rectangle with such gradients is strictly monotone, hence one to one.
    """
    frame = np.zeros(FRAME_SIZE)
    frame[OFF] = np.inf
    n_row, n_col = a[N_ROW], a[N_COL]
    if n_row < 2 or n_col < 2:
        return frame
    last_row, last_col = n_row - 1, n_col - 1

    # Mean steps along columns (u) and rows (v).
    ux = (p[a[0] + last_col * a[2]] - p[a[0]]) / last_col
    uy = (q[a[3] + last_col * a[5]] - q[a[3]]) / last_col
    vx = (p[a[0] + last_row * a[1]] - p[a[0]]) / last_row
    vy = (q[a[3] + last_row * a[4]] - q[a[3]]) / last_row
    det = ux * vy - uy * vx
    u, v = np.sqrt(ux * ux + uy * uy), np.sqrt(vx * vx + vy * vy)

    # A frame that is nearly a line, or not finite, gives no bound.
    if not _usable(det, ux, uy, vx, vy):
        return frame
    if _first_uneven(p, q, a, det, ux, uy, vx, vy) >= 0:
        return frame
    # heights in the frame of M are above 0.3 (steps of 0.5, at most 0.2 sideways); M shrinks
    # lengths by its smaller singular value at most, which is above |det| / (u + v)
    frame[HEIGHT] = 0.3 * abs(det) / (u + v)
    frame[STEPS], frame[STEPS + 1], frame[STEPS + 2], frame[STEPS + 3] = ux, uy, vx, vy
    frame[OFF] = _farthest(p, q, a, ux, uy, vx, vy)
    return frame


@scalar
def _half(c, rising, half):
    """Heights of one triangle, from those of a `_cell`."""
    if rising == 1:
        return (c[0], c[2], c[3]) if half == 1 else (c[0], c[1], c[2])
    return (c[1], c[2], c[3]) if half == 1 else (c[0], c[1], c[3])


@scalar
def _cell(z, a, row, col):
    """Heights of the nodes around a cell: (0, 0) (0, 1) (1, 1) (1, 0)."""
    at = a[6] + row * a[7] + col * a[8]
    return z[at], z[at + a[8]], z[at + a[7] + a[8]], z[at + a[7]]


@scalar
def _mark_whole_cells(z, a, s, b, first_row, first_col, full):
    """Mark the cells of a block and around it that have all four nodes in both lattices.

    ``full[i, j]`` is cell ``(first_row - 1 + i, first_col - 1 + j)``; cells outside are not used.
    """
    for row in range(max(first_row - 1, 0), min(first_row + BLOCK + 1, a[N_ROW] - 1)):
        for col in range(max(first_col - 1, 0), min(first_col + BLOCK + 1, a[N_COL] - 1)):
            c, d = _cell(z, a, row, col), _cell(s, b, row, col)
            total = c[0] + c[1] + c[2] + c[3] + d[0] + d[1] + d[2] + d[3]
            # A missing node makes the total NaN, which differs from itself.
            full[row - first_row + 1, col - first_col + 1] = total == total


@scalar
def _above_one_triangle(c, d, rising, key, slip, steepness, pairs, n):
    """The pairs above each half of a cell whose heights do not exclude a contact."""
    for half in range(2):
        u, v, w = _half(c, rising, half)
        e, f, g = _half(d, rising, half)
        # Both triangles have the same corners in the map. So their difference in height is linear,
        # and its extremes are at the corners.
        low, high = min(u - e, min(v - f, w - g)), max(u - e, max(v - f, w - g))
        if low > slip or high < -slip:
            # excluded, unless a move of all coordinates by `slip` could change it
            span = max(u, max(v, w)) - min(u, min(v, w)) + max(e, max(f, g)) - min(e, min(f, g))
            near = slip * (1.0 + steepness * span)
            if low > near or high < -near:
                continue
        n = append_pair(pairs, n, key + half, key + half)
    return n


@scalar
def _all_pairs(c, rising_c, key_c, d, rising_d, key_d, pairs, n):
    """Pairs of two cells with overlapping heights; triangles without all nodes are left out."""
    for half in range(2):
        u, v, w = _half(c, rising_c, half)
        for other in range(2):
            # Two diagonals divide the cell differently: elevations of whole triangles are compared.
            e, f, g = _half(d, rising_d, other)
            total = u + v + w + e + f + g
            if (
                total == total
                and min(u, min(v, w)) <= max(e, max(f, g))
                and min(e, min(f, g)) <= max(u, max(v, w))
            ):
                n = append_pair(pairs, n, key_c + half, key_d + other)
    return n


@scalar
def _pairs_at_holes(z, a, s, b, full, first_row, first_col, row, col, pairs, n):
    """Pairs of a cell of the first lattice with the cells around it, where one has a hole."""
    n_row, n_col = a[N_ROW] - 1, a[N_COL] - 1
    c = _cell(z, a, row, col)
    is_full = full[row - first_row + 1, col - first_col + 1]
    for i in range(max(row - 1, 0), min(row + 2, n_row)):
        for j in range(max(col - 1, 0), min(col + 2, n_col)):
            # Two whole cells share only what the comparison above each cell covers.
            if (is_full and full[i - first_row + 1, j - first_col + 1]) or (i == row and j == col):
                continue
            key, other = 2 * (row * n_col + col), 2 * (i * n_col + j)
            n = _all_pairs(c, a[RISING], key, _cell(s, b, i, j), b[RISING], other, pairs, n)
    return n


@scalar
def _block_reach(nodes, i, j, levels, rim):
    """Lowest and highest elevation of a block and of `rim` blocks around it."""
    n_row, n_col = levels[0, 1], levels[0, 2]
    low, high = np.inf, -np.inf
    for k in range(max(i - rim, 0), min(i + rim + 1, n_row)):
        for m in range(max(j - rim, 0), min(j + rim + 1, n_col)):
            low = min(low, nodes[k * n_col + m, 2])
            high = max(high, nodes[k * n_col + m, 5])
    return low, high


@entry("d1 l1 d2 d1 l1 d2 l2 b d d l2* -> l l")
def aligned_pairs(z, a, na, s, b, nb, levels, whole, slip, steepness, pairs):
    """Candidate pairs of triangles, while `pairs` has capacity; their number, blocks visited.

    The two lattices have one map and trees of one window (`levels`). With `whole`, neither has a
    hole. A pair above one triangle of the map is left out only if no move of coordinates by `slip`
    can make it meet; `steepness` is the inverse of the smallest height of a triangle in the map.
    """
    n = 0
    visited = 0
    rim = 0 if whole else 1
    # Without holes this stays as it is: every cell is whole.
    full = np.ones((BLOCK + 2, BLOCK + 2), dtype=np.bool_)
    for i in range(levels[0, 1]):
        for j in range(levels[0, 2]):
            visited += 1

            # Skip a block whose elevations are apart by more than a move could bridge.
            low, high = _block_reach(na, i, j, levels, 0)
            lower, upper = _block_reach(nb, i, j, levels, rim)
            near = slip * (1.0 + steepness * ((high - low) + (upper - lower)))
            if not (low <= upper + near and lower <= high + near):
                continue
            first_row, first_col = BLOCK * i, BLOCK * j
            if not whole:
                _mark_whole_cells(z, a, s, b, first_row, first_col, full)
            for row in range(first_row, min(first_row + BLOCK, a[N_ROW] - 1)):
                for col in range(first_col, min(first_col + BLOCK, a[N_COL] - 1)):
                    key = 2 * (row * (a[N_COL] - 1) + col)
                    c, d = _cell(z, a, row, col), _cell(s, b, row, col)

                    # With the same diagonal, triangles are compared one to one, else all pairs of
                    # the cell.
                    if full[row - first_row + 1, col - first_col + 1] and a[RISING] == b[RISING]:
                        n = _above_one_triangle(c, d, a[RISING], key, slip, steepness, pairs, n)
                    else:
                        n = _all_pairs(c, a[RISING], key, d, b[RISING], key, pairs, n)
                    if not whole:
                        n = _pairs_at_holes(
                            z, a, s, b, full, first_row, first_col, row, col, pairs, n
                        )  # fmt: skip
    return n, visited


# ---- near segments ----------------------------------------
# Which points are so near a segment that they may lie on it? Group by group.
#
# A group holds the segments of one face and the points known to lie in the face, sorted along the
# widest axis of their box: a segment looks at those beside it.
#
# Notation
#     x             coordinates, float64 (n, 3)
#     segments      rows of x (n, 2); points: rows of x (m,)
#     first_segment, first_point      start of each group, and the end of the last
#     reach         [m], at least 0: points farther from a line are not near


FEW = 16  # points


@scalar
def is_near_segment(x, a, b, p, reach):
    """Whether point p, not an end of segment a-b, is within reach of it."""
    if p == a or p == b:
        return False

    # Box test first.
    for k in range(3):
        low, high = min(x[a, k], x[b, k]), max(x[a, k], x[b, k])
        if x[p, k] < low - reach or x[p, k] > high + reach:
            return False

    # Squared distance from the line, times the squared length, by a cross product.
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    vx, vy, vz = x[p, 0] - x[a, 0], x[p, 1] - x[a, 1], x[p, 2] - x[a, 2]
    wx, wy, wz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    away, along = wx * wx + wy * wy + wz * wz, ux * ux + uy * uy + uz * uz
    # Both sides multiplied by the squared length: no division, also at length 0.
    most = reach * reach * along
    return away <= most or most < 1e-280  # squares of tiny numbers underflow: count as near


@entry("d2 l2 l1 l1 l1 d l2* -> l")
def points_near_segments(x, segments, first_segment, points, first_point, reach, pairs):
    """Write pairs (segment, point): rows of `segments` and of x; their number.

    The ends of a segment are not listed with it. Pairs beyond the capacity are counted only.
    """
    n = 0
    for group in range(first_segment.shape[0] - 1):
        start, stop = first_segment[group], first_segment[group + 1]
        low, high = first_point[group], first_point[group + 1]
        if low == high or start == stop:
            continue

        # the few points of most groups need no order
        if high - low <= FEW:
            for s in range(start, stop):
                for i in range(low, high):
                    if is_near_segment(x, segments[s, 0], segments[s, 1], points[i], reach):
                        n = append_pair(pairs, n, s, points[i])
            continue

        # along the widest axis of the points, a segment has few beside it
        axis, widest = 0, -1.0
        for k in range(3):
            least, most = x[points[low], k], x[points[low], k]
            for i in range(low, high):
                least, most = min(least, x[points[i], k]), max(most, x[points[i], k])
            if most - least > widest:
                axis, widest = k, most - least
        along = np.empty(high - low)
        for i in range(low, high):
            along[i - low] = x[points[i], axis]
        order = np.argsort(along)
        along = along[order]
        for s in range(start, stop):
            a, b = segments[s, 0], segments[s, 1]
            one, two = min(x[a, axis], x[b, axis]), max(x[a, axis], x[b, axis])
            for i in range(np.searchsorted(along, one - reach), high - low):
                if along[i] > two + reach:
                    break
                p = points[low + order[i]]
                if is_near_segment(x, a, b, p, reach):
                    n = append_pair(pairs, n, s, p)
    return n
