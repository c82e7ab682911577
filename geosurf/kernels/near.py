"""From pairs of blocks whose boxes meet to pairs of patches that are not apart.

A block of 8 x 8 cells, and each quarter of it, lies in its box and in a slab across its own
diagonals; blocks, then quarters, are compared by boxes and by both normals, then cells by
the other quarter's slab. Control nets are made only for cells that are near, once each.

Letters as in `pyramid`; s rows (11,) of a block or quarter: box, normal, least
and largest along it.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.patch import cell_net
from geosurf.kernels.pyramid import BLOCK, SLACK, apart, separated, span_along

_HALF = BLOCK // 2
_PARTS = 5  # a block and its quarters


@scalar
def _span(x, y, z, c, block, part, p, q, r):
    """Bounds of p x + q y + r z over a part of a block, or a triangle."""
    if z.shape[0] == 1:
        low, high = np.inf, -np.inf
        for k in range(3):
            value = p * c[block, k, 0] + q * c[block, k, 1] + r * c[block, k, 2]
            low, high = min(low, value - SLACK), max(high, value + SLACK)
        return low, high
    r0, r1, c0, c1 = _cells_of(z, block, part)
    return span_along(x, y, z, r0, r1, c0, c1, p, q, r)


@scalar
def _cells_of(z, block, part):
    """First and last row and column of the cells of a block (part 0) or a quarter; maybe none."""
    n_row, n_col = z.shape[0] - 1, z.shape[1] - 1
    across = (n_col + BLOCK - 1) // BLOCK
    r0, c0, size = block // across * BLOCK, block % across * BLOCK, BLOCK
    if part > 0:
        size = _HALF
        r0 += (part - 1) // 2 * _HALF
        c0 += (part - 1) % 2 * _HALF
    return r0, min(r0 + size, n_row), c0, min(c0 + size, n_col)


@scalar
def _normal_of(x, y, z, c, block, part):
    """Across the diagonals of a part, or across a triangle; not of unit length."""
    if z.shape[0] == 1:
        t = c[block]
        ux, uy, uz = t[1, 0] - t[0, 0], t[1, 1] - t[0, 1], t[1, 2] - t[0, 2]
        vx, vy, vz = t[2, 0] - t[0, 0], t[2, 1] - t[0, 1], t[2, 2] - t[0, 2]
    else:
        r0, r1, c0, c1 = _cells_of(z, block, part)
        k = 0 if x.shape[0] == 1 else r0
        m = 0 if x.shape[0] == 1 else r1
        ux, vx = x[m, c1] - x[k, c0], x[m, c0] - x[k, c1]
        k = 0 if y.shape[1] == 1 else c0
        m = 0 if y.shape[1] == 1 else c1
        uy, vy = y[r1, m] - y[r0, k], y[r1, k] - y[r0, m]
        uz, vz = z[r1, c1] - z[r0, c0], z[r1, c0] - z[r0, c1]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@scalar
def _describe(x, y, z, c, block, part, s):
    """Fill s of a part; the box of a part without cells is empty."""
    for k in range(3):
        s[k], s[3 + k], s[6 + k] = np.inf, -np.inf, np.nan
    s[9], s[10] = -np.inf, np.inf
    if z.shape[0] == 1:
        if part > 1:
            return
    else:
        r0, r1, c0, c1 = _cells_of(z, block, part)
        if r0 >= r1 or c0 >= c1:
            return
    if part > 0:  # boxes of whole blocks have been compared
        s[0], s[3] = _span(x, y, z, c, block, part, 1.0, 0.0, 0.0)
        s[1], s[4] = _span(x, y, z, c, block, part, 0.0, 1.0, 0.0)
        s[2], s[5] = _span(x, y, z, c, block, part, 0.0, 0.0, 1.0)
    p, q, r = _normal_of(x, y, z, c, block, part)
    size = math.sqrt(p * p + q * q + r * r)
    if size > 0.0:
        s[6], s[7], s[8] = p / size, q / size, r / size
        s[9], s[10] = _span(x, y, z, c, block, part, s[6], s[7], s[8])


@scalar
def _describe_to(x, y, z, c, block, known, wanted, s, place):
    """Describe the first parts of a block that are not known yet; how many are known now."""
    for part in range(known, wanted):
        _describe(x, y, z, c, block, part, s[place * _PARTS + part])
    return max(known, wanted)


@scalar
def _beyond(x, y, z, c, block, part, slab):
    """Whether a part is outside of another one's slab."""
    if not math.isfinite(slab[6]):
        return False
    low, high = _span(x, y, z, c, block, part, slab[6], slab[7], slab[8])
    return low > slab[10] or high < slab[9]


@scalar
def _number(of_block, block, count):
    """Place of a block among those in use, and how many are."""
    if of_block[block] < 0:
        of_block[block] = count
        return count, count + 1
    return of_block[block], count


@scalar
def _net_box(net, box):
    for axis in range(3):
        low, high = np.inf, -np.inf
        for k in range(4):
            for col in range(4):
                value = net[k, col, axis]
                if value < low:
                    low = value
                if value > high:
                    high = value
        box[axis], box[3 + axis] = low - SLACK, high + SLACK


@scalar
def _cells_in(x, y, z, c, block, part, slab, first, rows, nets, boxes, whole, cells, n, out, half):
    """Rows of the cells of a part that are near a slab, into `out`; counts of them and of nets.

    `rows`: of each cell of each block in use, from `first` on; nets are made where there are none.
    """
    count = 0
    if z.shape[0] == 1:
        if rows[first] < 0:
            t = c[block]
            for k in range(4):
                for col in range(4):
                    p, q = col / 3.0, k / 3.0
                    for axis in range(3):
                        nets[n, k, col, axis] = (
                            t[0, axis]
                            + p * (t[1, axis] - t[0, axis])
                            + p * q * (t[2, axis] - t[1, axis])
                        )
            whole[n], cells[n], rows[first] = 1, block, n
            _net_box(nets[n], boxes[n])
            n += 1
        out[0] = rows[first]
        return 1, n
    r0, r1, c0, c1 = _cells_of(z, block, part)
    for i in range(r0, r1):
        for j in range(c0, c1):
            at = first + i % BLOCK * BLOCK + j % BLOCK
            if math.isfinite(slab[6]):
                low, high = span_along(x, y, z, i, i + 1, j, j + 1, slab[6], slab[7], slab[8])
                if low > slab[10] or high < slab[9]:
                    continue
            if rows[at] < 0:
                whole[n] = cell_net(x, y, z, i, j, nets[n], half)
                cells[n], rows[at] = i * (z.shape[1] - 1) + j, n
                _net_box(nets[n], boxes[n])
                n += 1
            out[count] = rows[at]
            count += 1
    return count, n


@scalar
def _used(rows, nets, whole, cells, pairs, side, n):
    """Renumber one column of pairs by first use; the patches in use."""
    place = np.full(n, -1, dtype=np.int64)
    count = 0
    for k in range(pairs.shape[0]):
        row = pairs[k, side]
        if place[row] < 0:
            place[row] = count
            rows[count] = row
            count += 1
        pairs[k, side] = place[row]
    kept, flags, names = (
        np.empty((count, 4, 4, 3)),
        np.empty(count, dtype=np.int64),
        np.empty(count, dtype=np.int64),
    )
    for k in range(count):
        kept[k], flags[k], names[k] = nets[rows[k]], whole[rows[k]], cells[rows[k]]
    return names, kept, flags


@entry("d2 d2 d2 d2 d2 d2 d3 l2 l l -> l1 l1 d4 d4 l1 l1 l2")
def near_patches(xa, ya, za, xb, yb, zb, c, pairs, n_block_a, n_block_b):
    """Patches of two sides that are not apart, for pairs (n, 2) of blocks whose boxes meet.

    Returns cells, nets (n, 4, 4, 3) and `whole` (1: cubic or triangle; 0: lacks nodes) of both
    sides, and pairs of rows of them. A block of b is a triangle where zb has one row.
    """
    of_a = np.full(n_block_a, -1, dtype=np.int64)
    of_b = np.full(n_block_b, -1, dtype=np.int64)
    na, nb = 0, 0
    for k in range(pairs.shape[0]):
        _, na = _number(of_a, pairs[k, 0], na)
        _, nb = _number(of_b, pairs[k, 1], nb)
    room_b = BLOCK * BLOCK if zb.shape[0] > 1 else 1
    sa, sb = np.empty((na * _PARTS, 11)), np.empty((nb * _PARTS, 11))
    known_a, known_b = np.zeros(na, dtype=np.int64), np.zeros(nb, dtype=np.int64)
    rows_a = np.full(na * BLOCK * BLOCK, -1, dtype=np.int64)
    rows_b = np.full(nb * room_b, -1, dtype=np.int64)
    # as large as can be: memory that is never touched costs nothing
    nets_a, boxes_a = np.empty((len(rows_a), 4, 4, 3)), np.empty((len(rows_a), 6))
    nets_b, boxes_b = np.empty((len(rows_b), 4, 4, 3)), np.empty((len(rows_b), 6))
    whole_a, cells_a = np.empty_like(rows_a), np.empty_like(rows_a)
    whole_b, cells_b = np.empty_like(rows_b), np.empty_like(rows_b)
    here, there = np.empty(_HALF * _HALF, dtype=np.int64), np.empty(_HALF * _HALF, dtype=np.int64)
    half = np.empty((4, 4))
    none = np.zeros(4)
    out = np.empty((256, 2), dtype=np.int64)
    n, count_a, count_b = 0, 0, 0
    for k in range(pairs.shape[0]):
        g, h = pairs[k]
        u, v = of_a[g], of_b[h]
        known_a[u] = _describe_to(xa, ya, za, c, g, known_a[u], 1, sa, u)
        known_b[v] = _describe_to(xb, yb, zb, c, h, known_b[v], 1, sb, v)
        p, q = u * _PARTS, v * _PARTS
        if _beyond(xa, ya, za, c, g, 0, sb[q]):
            continue
        if _beyond(xb, yb, zb, c, h, 0, sa[p]):
            continue
        known_a[u] = _describe_to(xa, ya, za, c, g, known_a[u], _PARTS, sa, u)
        known_b[v] = _describe_to(xb, yb, zb, c, h, known_b[v], _PARTS, sb, v)
        for i in range(1, _PARTS):
            p = u * _PARTS + i
            for j in range(1, _PARTS):
                q = v * _PARTS + j
                if (
                    apart(sa[p], sb[q], none)
                    or _beyond(xa, ya, za, c, g, i, sb[q])
                    or _beyond(xb, yb, zb, c, h, j, sa[p])
                ):
                    continue
                in_a, count_a = _cells_in(
                    xa, ya, za, c, g, i, sb[q], u * BLOCK * BLOCK, rows_a, nets_a, boxes_a, whole_a,
                    cells_a, count_a, here, half,
                )  # fmt: skip
                in_b, count_b = _cells_in(
                    xb, yb, zb, c, h, j, sa[p], v * room_b, rows_b, nets_b, boxes_b, whole_b,
                    cells_b, count_b, there, half,
                )  # fmt: skip
                for e in range(in_a):
                    a = here[e]
                    if apart(boxes_a[a], sb[q], none):
                        continue
                    for f in range(in_b):
                        b = there[f]
                        if apart(boxes_a[a], boxes_b[b], none) or separated(nets_a[a], nets_b[b]):
                            continue
                        if n == out.shape[0]:
                            more = np.empty((2 * n, 2), dtype=np.int64)
                            more[:n] = out
                            out = more
                        out[n] = a, b
                        n += 1
    out = out[:n].copy()
    names_a, kept_a, flags_a = _used(rows_a, nets_a, whole_a, cells_a, out, 0, count_a)
    names_b, kept_b, flags_b = _used(rows_b, nets_b, whole_b, cells_b, out, 1, count_b)
    return names_a, names_b, kept_a, kept_b, flags_a, flags_b, out
