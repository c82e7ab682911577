"""Corners and normals of the triangles of a lattice, all at once.

Letters as in `strips`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, corner_of, key_at, load
from geosurf.kernels.search.tree import (
    FAN,
    LEAF,
    N_COL,
    N_ROW,
    RISING,
    TURNED,
    build_above,
    clear_boxes,
    levels_of,
)

# error of each component of a cross product, relative to its terms (less than 4 rounding units),
# and an absolute bound for underflow
_ROUNDING = 8 * 2.0**-52
_UNDERFLOW = 1e-290


@scalar
def may_be_degenerate(ax, ay, az, bx, by, bz):
    """Whether a triangle with edges a and b may have zero area, within rounding."""
    xp, xm, yp, ym, zp, zm = ay * bz, az * by, az * bx, ax * bz, ax * by, ay * bx
    # Each component is a difference of two products. None of them differs from zero by more than
    # rounding: only exact arithmetic can tell.
    return (
        abs(xp - xm) <= _ROUNDING * (abs(xp) + abs(xm)) + _UNDERFLOW
        and abs(yp - ym) <= _ROUNDING * (abs(yp) + abs(ym)) + _UNDERFLOW
        and abs(zp - zm) <= _ROUNDING * (abs(zp) + abs(zm)) + _UNDERFLOW
    )


@entry("d1 d1 d1 l1 -> d1 l1")
def lattice_normals(p, q, r, a):
    """Sum of all normals (length: area) and of areas, and the keys of possibly degenerate
    triangles.

    Triangles without three nodes are left out, and none is turned.
    """
    out = np.zeros(4)
    suspects = np.empty(64, dtype=np.int64)
    n = 0
    for key in range(2 * max(a[N_ROW] - 1, 0) * max(a[N_COL] - 1, 0)):
        i, j = corner_of(a, key, 0)
        x, y, z = load(p, a, 0, i, j), load(q, a, 1, i, j), load(r, a, 2, i, j)
        # The edges from corner 0 to the other two corners.
        i, j = corner_of(a, key, 1)
        ax, ay, az = load(p, a, 0, i, j) - x, load(q, a, 1, i, j) - y, load(r, a, 2, i, j) - z
        i, j = corner_of(a, key, 2)
        bx, by, bz = load(p, a, 0, i, j) - x, load(q, a, 1, i, j) - y, load(r, a, 2, i, j) - z

        # NaN marks a missing node.
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        if not (nx + ny + nz == nx + ny + nz):
            continue
        out[0] += 0.5 * nx
        out[1] += 0.5 * ny
        out[2] += 0.5 * nz
        out[3] += 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
        if may_be_degenerate(ax, ay, az, bx, by, bz):
            if n == suspects.shape[0]:
                larger = np.empty(2 * n, dtype=np.int64)
                larger[:n] = suspects
                suspects = larger
            suspects[n] = key
            n += 1
    return out, suspects[:n].copy()


@entry("l1 l1 -> l2")
def lattice_corners(a, keys):
    """Nodes (row by row) of triangles by key."""
    out = np.empty((keys.shape[0], 3), dtype=np.int64)
    n_col = a[N_COL]
    for i in range(keys.shape[0]):
        # Corners 0, 1, 2, 3 around the cell: 0 1 2 + 0 2 3 where diagonals rise, else 0 1 3 + 1 2
        # 3.
        cell = keys[i] >> 1
        low = cell + cell // (n_col - 1)  # one node more than cells in each row
        high = low + n_col
        # Where diagonals rise, both triangles have corner 0 and 2, else 1 and 3.
        if a[RISING] == 1:
            first, second, third = low, low + 1, high + 1
            if keys[i] & 1 == 1:
                second, third = high + 1, high
        else:
            first, second, third = low, low + 1, high
            if keys[i] & 1 == 1:
                first, second, third = low + 1, high + 1, high
        out[i, 0] = first
        out[i, 1] = third if a[TURNED] == 1 else second
        out[i, 2] = second if a[TURNED] == 1 else third
    return out


@entry("d1 d1 d1 l1 l1 -> d2")
def lattice_nodes(p, q, r, a, nodes):
    """World coordinates of nodes, counted row by row."""
    out = np.empty((nodes.shape[0], 3))
    n_col = a[N_COL]
    i = 0
    for k in range(nodes.shape[0]):
        j = nodes[k] - i * n_col
        if not 0 <= j < n_col:  # most are in the previous row: divisions are slow
            i = nodes[k] // n_col
            j = nodes[k] - i * n_col
        out[k, 0] = load(p, a, 0, i, j)
        out[k, 1] = load(q, a, 1, i, j)
        out[k, 2] = load(r, a, 2, i, j)
    return out


# ---- triangle list ----------------------------------------
# A list of triangles in one pass: boxes, Morton codes, possibly degenerate ones; and its tree.
#
# In a shuffled list, every corner is a cache miss. So each is loaded once for all purposes, and
# later stages read memory in order: triangles are sorted by the Morton code of their middle with
# a counting sort (linear), and the boxes of leaves grow during that sort.
#
# Notation
#     x, t     vertices (n, 3) and triangles (n, 3), rows of x
#     boxes    float64 (n, 6): lower, then upper corner of each triangle
#     codes    Morton codes, int64 (n,)
#     order, nodes, levels   as in `tree`


_MOST_BITS = 8  # of a code, for each axis
_BATCH = 256  # triangles whose corners are loaded together
SMALLEST, LARGEST = 0, 1


@scalar
def _reach(x):
    """Lower and upper corner of all vertices; smallest non-zero and largest absolute coordinate."""
    box = np.array([np.inf, np.inf, np.inf, -np.inf, -np.inf, -np.inf])
    small = np.inf
    for i in range(x.shape[0]):
        for k in range(3):
            # Zero has no size; NaN comparisons change nothing.
            value = x[i, k]
            size = abs(value) if value != 0.0 else np.inf
            box[k] = value if value < box[k] else box[k]
            box[3 + k] = value if value > box[3 + k] else box[3 + k]
            small = size if size < small else small
    large = 0.0
    for k in range(6):
        large = max(large, abs(box[k]))
    return box, small, large


@scalar
def _bits_for(n):
    """Bits of a code for each axis: about as many cells as triangles."""
    # Cells of the code grid: 8**bits.
    bits = 1
    while bits < _MOST_BITS and (1 << (3 * bits)) < n:
        bits += 1
    return bits


@scalar
def spread_bits(v):
    """Bits of v < 2**10 at every third place."""
    # Spread bits by doubling their distance (Morton 1966).
    v = (v | (v << 16)) & 0x030000FF
    v = (v | (v << 8)) & 0x0300F00F
    v = (v | (v << 4)) & 0x030C30C3
    return (v | (v << 2)) & 0x09249249


@scalar
def _ends(p, q, r):
    """Least and greatest of three numbers; selections avoid branch mispredictions."""
    low = p if p < q else q
    high = q if p < q else p
    low = r if r < low else low
    high = r if r > high else high
    return low, high


@scalar
def _fetch(x, t, first, last, corners):
    """Load the corners of some triangles. Nothing else is in this loop, so that misses overlap."""
    for i in range(first, last):
        for k in range(3):
            at = t[i, k]
            corners[i - first, 3 * k] = x[at, 0]
            corners[i - first, 3 * k + 1] = x[at, 1]
            corners[i - first, 3 * k + 2] = x[at, 2]


@entry("d2 l2 -> d2 l1 l1 d1")
def survey_list(x, t):
    """Boxes, codes, possibly degenerate rows, smallest and largest absolute coordinate."""
    n = t.shape[0]

    # Scale of the Morton codes: the longest side of the common box.
    box, small, large = _reach(x)
    top = (1 << _bits_for(n)) - 1
    span = max(box[3] - box[0], max(box[4] - box[1], box[5] - box[2]))
    # Without extent, or with too much of it, all codes are 0 and triangles stay in their order.
    scale = (top + 1) / span if 1e-290 < span < 1e290 else 0.0
    boxes = np.empty((n, 6), dtype=np.float64)
    codes = np.empty(n, dtype=np.int64)
    suspects = np.empty(n, dtype=np.int64)  # untouched pages cost nothing
    m = 0
    corners = np.empty((_BATCH, 9))
    for first in range(0, n, _BATCH):
        last = min(first + _BATCH, n)
        _fetch(x, t, first, last, corners)
        for i in range(first, last):
            k = i - first
            px, py, pz = corners[k, 0], corners[k, 1], corners[k, 2]
            qx, qy, qz = corners[k, 3], corners[k, 4], corners[k, 5]
            rx, ry, rz = corners[k, 6], corners[k, 7], corners[k, 8]

            # Box of the triangle, and the code of its middle.
            lx, ux = _ends(px, qx, rx)
            ly, uy = _ends(py, qy, ry)
            lz, uz = _ends(pz, qz, rz)
            boxes[i, 0], boxes[i, 1], boxes[i, 2] = lx, ly, lz
            boxes[i, 3], boxes[i, 4], boxes[i, 5] = ux, uy, uz
            # The highest coordinate would get a cell of its own: `top` bounds it.
            code = 0
            if scale > 0.0:
                u = min(int((0.5 * (lx + ux) - box[0]) * scale), top)
                v = min(int((0.5 * (ly + uy) - box[1]) * scale), top)
                w = min(int((0.5 * (lz + uz) - box[2]) * scale), top)
                code = spread_bits(u) | (spread_bits(v) << 1) | (spread_bits(w) << 2)
            codes[i] = code

            # Possibly degenerate triangles are tested exactly later.
            if may_be_degenerate(qx - px, qy - py, qz - pz, rx - px, ry - py, rz - pz):
                suspects[m] = i
                m += 1
    return boxes, codes, suspects[:m].copy(), np.array([small, large])


@entry("d2 l1 -> l1 d2 l2")
def build_list_tree(boxes, codes):
    """Triangles in the order of their codes (equal ones by row), boxes of all nodes, and levels."""
    n = codes.shape[0]

    # Counting sort by code.
    # Entry c + 1 counts code c. After the sums, start[c] is the first place of code c.
    start = np.zeros((1 << (3 * _bits_for(n))) + 1, dtype=np.int64)
    for i in range(n):
        start[codes[i] + 1] += 1
    for c in range(1, start.shape[0]):
        start[c] += start[c - 1]

    # Leaves first, then all levels above.
    levels, n_node = levels_of(1, (n + LEAF - 1) // LEAF, 1, FAN)
    nodes = np.empty((n_node, 6), dtype=np.float64)
    clear_boxes(nodes, 0, levels[0, 2])
    order = np.empty(n, dtype=np.int64)
    for i in range(n):
        # The leaf of a place grows while triangles are placed.
        place = start[codes[i]]
        start[codes[i]] = place + 1
        # Placing in row order makes equal codes keep that order: the result is unique.
        order[place] = i
        leaf = place // LEAF
        for k in range(3):
            low, high = boxes[i, k], boxes[i, 3 + k]
            nodes[leaf, k] = low if low < nodes[leaf, k] else nodes[leaf, k]
            nodes[leaf, 3 + k] = high if high > nodes[leaf, 3 + k] else nodes[leaf, 3 + k]
    build_above(nodes, levels, 1, FAN)
    return order, nodes, levels


# ---- strip triangles ----------------------------------------
# Runs of a lattice as triangles and points again: each array is written once, in its final order.
#
# The order is that of keys: cut triangles (`cut`, their keys increasing) and those of runs
# alternate. New points are the nodes of runs that no cut triangle has, increasing.
#
# Notation, in addition to that of `strips` (a, runs, start)
#     nodes, points  nodes that have a point already, and its index
#     id_of_node     point of each node; -1 where runs have no such node
#     places         run of each place in one strip; -1 where there is none


_WANTED = -2


@scalar
def _mark_triangle(a, row, place, id_of_node):
    key = key_at(a, row, place)
    for corner in range(3):
        i, j = corner_of(a, key, corner)
        id_of_node[i * a[N_COL] + j] = _WANTED


@entry("l1 l2 l1 l1 l -> l1 l")
def number_nodes(a, runs, nodes, points, n):
    """Point of each node that runs have, new ones from n on; and the number of points then."""
    n_col = a[N_COL]
    id_of_node = np.full(a[N_ROW] * n_col, -1, dtype=np.int64)
    for i in range(runs.shape[0]):
        row, first, last = runs[i, ROW], runs[i, FIRST], runs[i, LAST]

        # The ends of a run may be half cells; between them cells are whole.
        _mark_triangle(a, row, first, id_of_node)
        _mark_triangle(a, row, last, id_of_node)
        # nodes between whole cells; places 2 c and 2 c + 1 are cell c
        low, high = row * n_col + (first + 1) // 2, row * n_col + (last + 1) // 2
        if high > low:
            id_of_node[low : high + 1] = _WANTED
            id_of_node[low + n_col : high + n_col + 1] = _WANTED

    # Nodes with a point keep it, the others get new ones.
    for k in range(nodes.shape[0]):
        id_of_node[nodes[k]] = points[k]
    for k in range(id_of_node.shape[0]):
        if id_of_node[k] == _WANTED:
            id_of_node[k] = n
            n += 1
    return id_of_node, n


@scalar
def _fill_places(a, runs, first, last, places):
    # What no run covers stays -1: cut triangles and missing ones.
    places[:] = -1
    for i in range(first, last):
        places[runs[i, FIRST] : runs[i, LAST] + 1] = i


@entry("l1 l2 l1 l1 l2 l1 l2* -> .")
def write_triangles(a, runs, start, cut, corners, id_of_node, t):
    """Corners of cut triangles and of those of runs, in the order of keys."""
    n_col = a[N_COL]
    # A turned lattice lists corners 1 and 2 of each triangle in the other order.
    rising = a[RISING] == 1
    two, three = (2, 1) if a[TURNED] == 1 else (1, 2)
    places = np.empty(2 * (n_col - 1), dtype=np.int64)
    n, m = 0, 0
    for row in range(start.shape[0] - 1):
        _fill_places(a, runs, start[row], start[row + 1], places)
        for col in range(n_col - 1):
            low = row * n_col + col
            for half in range(2):
                key = 2 * (row * (n_col - 1) + col) + half

                # Cut triangles of this key come first.
                while m < cut.shape[0] and cut[m] == key:
                    t[n, 0], t[n, 1], t[n, 2] = corners[m, 0], corners[m, 1], corners[m, 2]
                    m += 1
                    n += 1
                # Along the strip, the halves of a cell come in the other order where diagonals
                # rise.
                if places[2 * col + (1 - half if rising else half)] < 0:
                    continue
                # corners 0, 1, 2, 3 around the cell: 0 1 2 + 0 2 3, or 0 1 3 + 1 2 3
                if half == 0:
                    u, v, w = low, low + 1, low + n_col + (1 if rising else 0)
                elif rising:
                    u, v, w = low, low + n_col + 1, low + n_col
                else:
                    u, v, w = low + 1, low + n_col + 1, low + n_col
                t[n, 0], t[n, two], t[n, three] = id_of_node[u], id_of_node[v], id_of_node[w]
                n += 1
    # those of a torn sheet at its faults, whose keys follow
    for k in range(m, cut.shape[0]):
        t[n, 0], t[n, 1], t[n, 2] = corners[k, 0], corners[k, 1], corners[k, 2]
        n += 1


@entry("l1 l2 l1 l1 l1 l l1* l1* -> .")
def write_labels(a, runs, start, cut, elements, first_run, keys, out):
    """Keys and elements of the same triangles; runs are the elements `first_run` and on."""
    n_col = a[N_COL]
    rising = a[RISING] == 1
    places = np.empty(2 * (n_col - 1), dtype=np.int64)
    n, m = 0, 0
    for row in range(start.shape[0] - 1):
        _fill_places(a, runs, start[row], start[row + 1], places)
        for k in range(2 * (n_col - 1)):
            key = 2 * row * (n_col - 1) + k
            # The order of `write_triangles`: cut triangles of a key first, then the one of a run.
            while m < cut.shape[0] and cut[m] == key:
                keys[n], out[n] = key, elements[m]
                m += 1
                n += 1
            run = places[k ^ 1 if rising else k]
            if run >= 0:
                keys[n], out[n] = key, first_run + run
                n += 1
    for k in range(m, cut.shape[0]):
        keys[n], out[n] = cut[k], elements[k]
        n += 1
