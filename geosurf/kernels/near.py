"""From pairs of blocks whose boxes meet to pairs of patches that are not apart.

A block of 8 x 8 cells, each quarter of it and each cell lies in its box and in a slab across its
own diagonals. Blocks are compared by slabs, quarters by boxes and slabs, then cells: by the other
quarter, then with each other. Control nets are made only for cells that are near, once each.

Letters as in `pyramid`; s facts (11,) of a block, quarter or net: box, normal, least and largest
along it.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.patch import cell_net
from geosurf.kernels.pyramid import BLOCK, SLACK, net_normal, shadow, span_along
from geosurf.kernels.quarters import HALF, N_FACT, PARTS, beyond, cells_of, clear, describe_to

_PAIRS = np.array([(i, j) for i in range(1, PARTS) for j in range(1, PARTS)])  # of quarters


# ---- nets --------------------------------------------------------------------------------


@scalar
def _outside(net, slab):
    """Whether a net is outside of a slab."""
    if not math.isfinite(slab[6]):
        return False
    low, high = shadow(net, slab[6], slab[7], slab[8])
    return low > slab[10] + SLACK or slab[9] > high + SLACK


@scalar
def _net_facts(net, s):
    """Box of a net, and its slab."""
    for axis in range(3):
        low, high = np.inf, -np.inf
        for k in range(4):
            for col in range(4):
                value = net[k, col, axis]
                if value < low:
                    low = value
                if value > high:
                    high = value
        s[axis], s[3 + axis] = low - SLACK, high + SLACK
    s[6], s[7], s[8] = net_normal(net)
    s[9], s[10] = shadow(net, s[6], s[7], s[8])


@scalar
def _triangle_net(t, net):
    """A triangle as the patch (s, t) = (p (1 - q), p q)."""
    for k in range(4):
        for col in range(4):
            p, q = col / 3.0, k / 3.0
            for axis in range(3):
                net[k, col, axis] = (
                    t[0, axis] + p * (t[1, axis] - t[0, axis]) + p * q * (t[2, axis] - t[1, axis])
                )


@scalar
def _make_net(x, y, z, c, block, i, j, net, s, mark, half):
    """Net and facts of cell (i, j), or of a triangle; `mark`: its number, whether it is whole."""
    if z.shape[0] > 1:
        mark[0] = i * (z.shape[1] - 1) + j
        mark[1] = cell_net(x, y, z, i, j, net, half)
    else:
        _triangle_net(c[block], net)
        mark[0], mark[1] = block, 1
    _net_facts(net, s)


@scalar
def _nets_in(x, y, z, c, block, part, slab, rows, nets, facts, marks, n, out, half):
    """Rows of the cells of a part that are near another part, into `out`; how many, and nets.

    `rows` (64,) of the cells of the block; nets are made where there are none.
    """
    count = 0
    r0, r1, c0, c1 = 0, 1, 0, 1
    lattice = z.shape[0] > 1
    if lattice:
        r0, r1, c0, c1 = cells_of(z, block, part)
    for i in range(r0, r1):
        for j in range(c0, c1):
            at = i % BLOCK * BLOCK + j % BLOCK if lattice else 0
            if rows[at] < 0:
                if lattice and math.isfinite(slab[6]):
                    low, high = span_along(x, y, z, i, i + 1, j, j + 1, slab[6], slab[7], slab[8])
                    if low > slab[10] or high < slab[9]:
                        continue
                _make_net(x, y, z, c, block, i, j, nets[n], facts[n], marks[n], half)
                rows[at] = n
                n += 1
            k = rows[at]
            if not clear(facts[k], slab) and not _outside(nets[k], slab):
                out[count] = k
                count += 1
    return count, n


@scalar
def _meet_nets(here, n_here, nets_a, facts_a, there, n_there, nets_b, facts_b, out, n):
    """Append the pairs of some nets of a with some of b that are not apart."""
    for e in range(n_here):
        a = here[e]
        for g in range(n_there):
            b = there[g]
            if (
                clear(facts_a[a], facts_b[b])
                or _outside(nets_a[a], facts_b[b])
                or _outside(nets_b[b], facts_a[a])
            ):
                continue
            if n == out.shape[0]:
                more = np.empty((2 * n, 2), dtype=np.int64)
                more[:n] = out
                out = more
            out[n, 0], out[n, 1] = a, b
            n += 1
    return out, n


# ---- all pairs ---------------------------------------------------------------------------


@scalar
def _numbered(pairs, side, n_block):
    """Place of each block among those in use (-1: none), and how many are."""
    places, count = np.full(n_block, -1, dtype=np.int64), 0
    for k in range(pairs.shape[0]):
        if places[pairs[k, side]] < 0:
            places[pairs[k, side]] = count
            count += 1
    return places, count


@scalar
def _used(nets, marks, pairs, side, n):
    """Renumber one column of pairs by first use; cells, nets and `whole` of the patches in use."""
    place, rows, count = np.full(n, -1, dtype=np.int64), np.empty(n, dtype=np.int64), 0
    for k in range(pairs.shape[0]):
        row = pairs[k, side]
        if place[row] < 0:
            place[row], rows[count] = count, row
            count += 1
        pairs[k, side] = place[row]
    names, kept = np.empty(count, dtype=np.int64), np.empty((count, 4, 4, 3))
    flags = np.empty(count, dtype=np.int64)
    for k in range(count):
        kept[k], names[k], flags[k] = nets[rows[k]], marks[rows[k], 0], marks[rows[k], 1]
    return names, kept, flags


@scalar
def _near_blocks(xa, ya, za, xb, yb, zb, c, g, h, known_a, known_b, sa, sb, u, v):
    """Whether no slab of two blocks parts them; their quarters are described then."""
    known_a[u] = describe_to(xa, ya, za, c, g, known_a[u], 1, sa, u)
    known_b[v] = describe_to(xb, yb, zb, c, h, known_b[v], 1, sb, v)
    if beyond(xa, ya, za, c, g, 0, sb[v * PARTS]) or beyond(xb, yb, zb, c, h, 0, sa[u * PARTS]):
        return False
    known_a[u] = describe_to(xa, ya, za, c, g, known_a[u], PARTS, sa, u)
    known_b[v] = describe_to(xb, yb, zb, c, h, known_b[v], PARTS, sb, v)
    return True


@entry("d2 d2 d2 d2 d2 d2 d3 l2 l l -> l1 l1 d4 d4 l1 l1 l2")
def near_patches(xa, ya, za, xb, yb, zb, c, pairs, n_block_a, n_block_b):
    """Patches of two sides that are not apart, for pairs (n, 2) of blocks whose boxes meet.

    Returns cells, nets (n, 4, 4, 3) and `whole` (1: cubic or triangle; 0: lacks nodes) of both
    sides, and pairs of rows of them. A block of b is a triangle where zb has one row.
    """
    of_a, na = _numbered(pairs, 0, n_block_a)
    of_b, nb = _numbered(pairs, 1, n_block_b)
    room_b = BLOCK * BLOCK if zb.shape[0] > 1 else 1
    sa, sb = np.empty((na * PARTS, N_FACT)), np.empty((nb * PARTS, N_FACT))
    known_a, known_b = np.zeros(na, dtype=np.int64), np.zeros(nb, dtype=np.int64)
    rows_a = np.full((na, BLOCK * BLOCK), -1, dtype=np.int64)
    rows_b = np.full((nb, room_b), -1, dtype=np.int64)
    # as large as can be: memory that is never touched costs nothing
    nets_a, facts_a = np.empty((rows_a.size, 4, 4, 3)), np.empty((rows_a.size, N_FACT))
    nets_b, facts_b = np.empty((rows_b.size, 4, 4, 3)), np.empty((rows_b.size, N_FACT))
    marks_a = np.empty((rows_a.size, 2), dtype=np.int64)
    marks_b = np.empty((rows_b.size, 2), dtype=np.int64)
    here, there = np.empty(HALF * HALF, dtype=np.int64), np.empty(HALF * HALF, dtype=np.int64)
    half, out = np.empty((4, 4)), np.empty((256, 2), dtype=np.int64)
    n, count_a, count_b = 0, 0, 0
    for k in range(pairs.shape[0]):
        g, h = pairs[k, 0], pairs[k, 1]
        u, v = of_a[g], of_b[h]
        if not _near_blocks(xa, ya, za, xb, yb, zb, c, g, h, known_a, known_b, sa, sb, u, v):
            continue
        for i, j in _PAIRS:
            s, t = sa[u * PARTS + i], sb[v * PARTS + j]
            if clear(s, t) or beyond(xa, ya, za, c, g, i, t) or beyond(xb, yb, zb, c, h, j, s):
                continue
            n_here, count_a = _nets_in(
                xa, ya, za, c, g, i, t, rows_a[u], nets_a, facts_a, marks_a, count_a, here, half
            )
            n_there, count_b = _nets_in(
                xb, yb, zb, c, h, j, s, rows_b[v], nets_b, facts_b, marks_b, count_b, there, half
            )
            out, n = _meet_nets(
                here, n_here, nets_a, facts_a, there, n_there, nets_b, facts_b, out, n
            )
    out = out[:n].copy()
    names_a, kept_a, flags_a = _used(nets_a, marks_a, out, 0, count_a)
    names_b, kept_b, flags_b = _used(nets_b, marks_b, out, 1, count_b)
    return names_a, names_b, kept_a, kept_b, flags_a, flags_b, out
