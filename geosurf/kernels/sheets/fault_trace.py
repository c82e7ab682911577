"""Trace of a fault on a gridded horizon: the zero line of the fault's height above the grid.

Each triangle of the fault is split into four, `depth` times; the line is straight in the smallest
triangles (marching triangles). Only triangles that the horizon can meet are refined: the lowest and
highest node below a triangle bound the horizon. For large triangles they are read from blocks of 8
x 8 nodes, and of 2 x 2, 4 x 4 .. such blocks, so that the cost follows the line.

Notation
    grid       heights of the horizon, NaN where undefined; bilinear in each cell
    low, high  bounds of blocks, all levels one after the other
    levels     rows (first block, rows of blocks, columns of blocks) for each level
    i, j, k    position of a corner in a triangle: integers with the sum 2**depth
    name       of a crossed edge, two numbers: (-1 - edge, place along it) on an edge of the fault's
               triangles, (triangle, place in it) inside one. Neighbours compute the same name.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

# ---- fault table ----------------------------------------
# Values at points of a plane on a mesh in it: in the triangle of a block that holds each best.
#
# Notation
#     plane           places of the vertices, float64 (n_vertex, 2); values there (n_vertex,)
#     triangles       int64 (n, 3)
#     starts, items   triangles listed by blocks: those of block b are ``items[starts[b]]`` ..
#                     ``items[starts[b + 1] - 1]``
#     rows, block     points that lie in a block with triangles, and that block
#     u, v, w         weights of the corners of a triangle at a point, 1 in sum


@entry("d2 d1 l2 l1 l1 d2 l1 l1 d d1* -> .")
def values_on_triangles(
    plane, values, triangles, starts, items, points, rows, block, inside, out
):  # fmt: skip
    """Write linear interpolation at points; no other entry of `out` is written.

    A point is in a triangle if no weight is below `inside`. Of several it takes the one that it is
    deepest in, the last of those where it is equally deep. Triangles without area hold nothing.
    """
    for k in range(rows.shape[0]):
        px, py = points[rows[k], 0], points[rows[k], 1]
        best = inside
        for i in range(starts[block[k]], starts[block[k] + 1]):
            a, b, c = triangles[items[i], 0], triangles[items[i], 1], triangles[items[i], 2]
            one_x, one_y = plane[b, 0] - plane[a, 0], plane[b, 1] - plane[a, 1]
            two_x, two_y = plane[c, 0] - plane[a, 0], plane[c, 1] - plane[a, 1]
            det = one_x * two_y - one_y * two_x
            if det == 0.0:
                continue

            # Cheap first: most triangles of a block fail on their first weight.
            to_x, to_y = px - plane[a, 0], py - plane[a, 1]
            v = (to_x * two_y - to_y * two_x) / det
            if v < best:
                continue
            w = (one_x * to_y - one_y * to_x) / det
            u = 1.0 - v - w
            least = min(u, min(v, w))
            if least >= best:
                best = least
                out[rows[k]] = u * values[a] + v * values[b] + w * values[c]


BLOCK = 3  # nodes of the smallest blocks: 2**3 each way
DIRECT = 4  # up to so many nodes each way are read directly
MARGIN = 1e-9  # relative: bilinear values are rounded


@entry("d2 -> d1 d1 l2")
def block_bounds(grid):
    """Lowest and highest node of each block, inf and -inf if none; and the levels."""
    n_row, n_col = grid.shape

    # Count levels and blocks.
    rows, cols, n_level, total = (n_row + 7) >> BLOCK, (n_col + 7) >> BLOCK, 1, 0
    total = rows * cols
    while rows * cols > 1:
        rows, cols = (rows + 1) >> 1, (cols + 1) >> 1
        total += rows * cols
        n_level += 1
    low, high = np.full(total, np.inf), np.full(total, -np.inf)
    levels = np.zeros((n_level, 3), dtype=np.int64)
    rows, cols = (n_row + 7) >> BLOCK, (n_col + 7) >> BLOCK
    levels[0, 1], levels[0, 2] = rows, cols

    # The finest blocks, then each level from the one below.
    for i in range(n_row):
        for j in range(n_col):
            z = grid[i, j]
            # Comparisons with NaN are false: holes bound nothing.
            at = (i >> BLOCK) * cols + (j >> BLOCK)
            if z < low[at]:
                low[at] = z
            if z > high[at]:
                high[at] = z
    for level in range(1, n_level):
        first = levels[level - 1, 0]
        start = first + rows * cols
        wide = cols
        tall, rows, cols = rows, (rows + 1) >> 1, (cols + 1) >> 1
        levels[level, 0], levels[level, 1], levels[level, 2] = start, rows, cols
        for i in range(tall):
            for j in range(wide):
                at, of = start + (i >> 1) * cols + (j >> 1), first + i * wide + j
                low[at] = min(low[at], low[of])
                high[at] = max(high[at], high[of])
    return low, high, levels


@scalar
def _meets(grid, low, high, levels, sx, sy, p, q, r):
    """Whether a triangle can meet the horizon: bounds of the nodes below it against its own."""
    n_row, n_col = grid.shape

    # Rows and columns of the nodes below the triangle.
    c0 = max(int(np.floor(min(p[0], q[0], r[0]) / sx)), 0)
    c1 = min(int(np.floor(max(p[0], q[0], r[0]) / sx)) + 1, n_col - 1)
    r0 = max(int(np.floor(min(p[1], q[1], r[1]) / sy)), 0)
    r1 = min(int(np.floor(max(p[1], q[1], r[1]) / sy)) + 1, n_row - 1)
    # Outside of the grid.
    if c0 > c1 or r0 > r1:
        return False
    bottom, top = min(p[2], q[2], r[2]), max(p[2], q[2], r[2])
    lowest, highest = np.inf, -np.inf
    if c1 - c0 < DIRECT and r1 - r0 < DIRECT:
        for i in range(r0, r1 + 1):
            for j in range(c0, c1 + 1):
                z = grid[i, j]
                if z < lowest:
                    lowest = z
                if z > highest:
                    highest = z
    else:
        # Choose a level on which few blocks cover the triangle.
        level, shift = 0, BLOCK
        while level + 1 < levels.shape[0] and (
            (c1 >> shift) - (c0 >> shift) > 2 or (r1 >> shift) - (r0 >> shift) > 2
        ):
            level += 1
            shift += 1
        first, wide = levels[level, 0], levels[level, 2]
        for i in range(r0 >> shift, (r1 >> shift) + 1):
            for j in range(c0 >> shift, (c1 >> shift) + 1):
                lowest = min(lowest, low[first + i * wide + j])
                highest = max(highest, high[first + i * wide + j])
    # Only holes below the triangle.
    if lowest > highest:
        return False
    # Bilinear values lie between the nodes, except for rounding.
    margin = MARGIN * max(abs(lowest), abs(highest))
    return bottom <= highest + margin and top >= lowest - margin


@entry("d2 d1 d1 l2 d1 d2 l2 -> b1")
def may_meet(grid, low, high, levels, stretch, points, faces):
    """Whether each triangle (n, 3) of a fault can meet the horizon."""
    meets = np.zeros(faces.shape[0], dtype=np.bool_)
    for f in range(faces.shape[0]):
        p, q, r = points[faces[f, 0]], points[faces[f, 1]], points[faces[f, 2]]
        meets[f] = _meets(grid, low, high, levels, stretch[0], stretch[1], p, q, r)
    return meets


@scalar
def _above(grid, sx, sy, p):
    """Height above the horizon, NaN where it is undefined."""
    n_row, n_col = grid.shape
    x, y = p[0] / sx, p[1] / sy
    if not (x >= 0 and x <= n_col - 1 and y >= 0 and y <= n_row - 1):
        return np.nan

    # Bilinear interpolation; the last row and column belong to the last cell.
    j, i = min(int(np.floor(x)), n_col - 2), min(int(np.floor(y)), n_row - 2)
    s, t = x - j, y - i
    below = grid[i, j] * (1 - s) + grid[i, j + 1] * s
    over = grid[i + 1, j] * (1 - s) + grid[i + 1, j + 1] * s
    return p[2] - (below * (1 - t) + over * t)


@scalar
def _zero(p, q, up, uq, out, at):
    """Write the point between p and q at height 0, the same from either side."""
    # Order the ends, so that both neighbours compute the same bits.
    for c in range(3):
        if p[c] != q[c]:
            if p[c] > q[c]:
                p, q, up, uq = q, p, uq, up
            break
    # The heights have different signs, so the divisor is not zero.
    f = up / (up - uq)
    for c in range(3):
        out[at + c] = p[c] + f * (q[c] - p[c])


@scalar
def _name(f, a, b, whole, edges, forward, names, at):
    """Write the name of the edge between corners a and b (i, j) of a small triangle of f."""
    # Third barycentric numbers; an edge on the side of the triangle has one in common.
    ka, kb = whole - a[0] - a[1], whole - b[0] - b[1]
    # Both ends on one side of the fault's triangle: the neighbour names the point alike.
    if ka == 0 and kb == 0:
        side, start, end = 0, a[1], b[1]
    elif a[0] == 0 and b[0] == 0:
        side, start, end = 1, ka, kb
    elif a[1] == 0 and b[1] == 0:
        side, start, end = 2, a[0], b[0]
    else:
        # The sum of both ends is different for each inner edge.
        names[at] = f
        names[at + 1] = (a[0] + b[0]) * (2 * whole + 1) + a[1] + b[1]
        return
    # Counted from the lower vertex of the edge, whichever way this triangle runs along it.
    place = min(start, end) if forward[f, side] else whole - max(start, end)
    names[at] = -1 - edges[f, side]
    names[at + 1] = place


@scalar
def _take(xyz, ij, p, a, m, b):
    """Copy the corners of a triangle, and compute the middles of its edges."""
    for c in range(3):
        for d in range(3):
            # Copy, since the stack is overwritten by the quarters.
            p[c, d] = xyz[c, d]
        for d in range(2):
            a[c, d] = ij[c, d]
    for c in range(3):
        e = (c + 1) % 3
        for d in range(3):
            m[c, d] = 0.5 * (p[c, d] + p[e, d])
        for d in range(2):
            b[c, d] = (a[c, d] + a[e, d]) >> 1


@scalar
def _take_part(part, p, a, m, b, xyz, ij):
    """Corners of a quarter of a triangle: that at corner 0, 1 or 2, or the middle one (3)."""
    for c in range(3):
        is_corner = part != 3 and c == part
        # other corners are the middles of edges to that corner
        side = c if part == 3 else (part if c == (part + 1) % 3 else c)
        for d in range(3):
            xyz[c, d] = p[c, d] if is_corner else m[side, d]
        for d in range(2):
            ij[c, d] = a[c, d] if is_corner else b[side, d]


@scalar
def _piece(h, p, a, whole, f, edges, forward, names, places):
    """Write where the zero line enters and leaves a small triangle; False if it does not.

    `h` are the heights of its corners `p` above the horizon.
    """
    # The line ends at holes of the horizon.
    if np.isnan(h[0]) or np.isnan(h[1]) or np.isnan(h[2]):
        return False

    # The corners between which the height changes its sign.
    rises = falls = -1
    for c in range(3):
        e = (c + 1) % 3
        if h[c] < 0 and h[e] >= 0:
            rises = c
        if h[c] >= 0 and h[e] < 0:
            falls = c
    # All heights have one sign: around a triangle there is no rise without a fall.
    if rises < 0:
        return False
    for turn in range(2):
        c = rises if turn == 0 else falls
        e = (c + 1) % 3
        _name(f, a[c], a[e], whole, edges, forward, names, 2 * turn)
        _zero(p[c], p[e], h[c], h[e], places, 3 * turn)
    names[4] = f
    return True


@scalar
def _height_of(part, c, h, k):
    """Height of a corner of a quarter, from those of corners `h` and middles `k`."""
    if part == 3:
        return k[c]
    if c == part:
        return h[c]
    return k[part if c == (part + 1) % 3 else c]


@entry("d2 d1 d1 l2 d1 d2 l2 l2 b2 l -> l2 d2")
def zero_line_pieces(grid, low, high, levels, stretch, points, faces, edges, forward, depth):
    """Pieces of the line: names of entry and exit points (n, 5), and their positions (n, 6).

    Columns of the names: entry (2), exit (2), triangle of the fault. Around a triangle the line
    enters where the height increases, so that the front of the fault is on its left. `edges` (n, 3)
    number the edges of triangles; `forward`: the edge starts at its lower vertex.
    """
    sx, sy = stretch[0], stretch[1]
    whole = 1 << depth
    size = 256
    names = np.empty((size, 5), dtype=np.int64)
    places = np.empty((size, 6))
    n = 0
    # Depth first: at most four parts of each level are on the stack.
    xyz = np.empty((4 * depth + 4, 3, 3))
    ij = np.empty((4 * depth + 4, 3, 2), dtype=np.int64)
    deep = np.empty(4 * depth + 4, dtype=np.int64)
    p, m = np.empty((3, 3)), np.empty((3, 3))
    a, b = np.empty((3, 2), dtype=np.int64), np.empty((3, 2), dtype=np.int64)
    h, k, g = np.empty(3), np.empty(3), np.empty(3)
    for f in range(faces.shape[0]):
        # Put the triangle itself on the stack if it can meet the horizon.
        for c in range(3):
            for d in range(3):
                xyz[0, c, d] = points[faces[f, c], d]
            for d in range(2):
                ij[0, c, d] = whole if c == d else 0
        deep[0] = 0
        left = 1 if _meets(grid, low, high, levels, sx, sy, xyz[0, 0], xyz[0, 1], xyz[0, 2]) else 0
        while left > 0:  # every triangle on the stack can meet the horizon
            left -= 1
            level = deep[left]
            _take(xyz[left], ij[left], p, a, m, b)

            # Split into quarters and push those that can meet the horizon.
            if level + 1 < depth:
                for part in range(4):  # a corner each, and the middle
                    _take_part(part, p, a, m, b, xyz[left], ij[left])
                    deep[left] = level + 1
                    t = xyz[left]
                    if _meets(grid, low, high, levels, sx, sy, t[0], t[1], t[2]):
                        left += 1
                continue
            # Room for the pieces of four quarters.
            if n + 4 > size:
                names = np.concatenate((names, np.empty_like(names)))
                places = np.concatenate((places, np.empty_like(places)))
                size *= 2
            for c in range(3):
                h[c] = _above(grid, sx, sy, p[c])
            # Only with depth 0: the triangle itself is the smallest.
            if level == depth:
                if _piece(h, p, a, whole, f, edges, forward, names[n], places[n]):
                    n += 1
                continue

            # Heights at the corners; at the last level but one also at the middles.
            for c in range(3):
                k[c] = _above(grid, sx, sy, m[c])
            for part in range(3, -1, -1):  # in the order in which a stack would return them
                for c in range(3):
                    g[c] = _height_of(part, c, h, k)
                _take_part(part, p, a, m, b, xyz[left], ij[left])
                if _piece(g, xyz[left], ij[left], whole, f, edges, forward, names[n], places[n]):
                    n += 1
    return names[:n].copy(), places[:n].copy()
