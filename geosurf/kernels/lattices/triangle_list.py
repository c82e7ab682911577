"""A list of triangles in one pass: boxes, Morton codes, possibly degenerate ones; and its tree.

In a shuffled list, every corner is a cache miss. So each is loaded once for all purposes, and later
stages read memory in order: triangles are sorted by the Morton code of their middle with a counting
sort (linear), and the boxes of leaves grow during that sort.

Notation
    x, t     vertices (n, 3) and triangles (n, 3), rows of x
    boxes    float64 (n, 6): lower, then upper corner of each triangle
    codes    Morton codes, int64 (n,)
    order, nodes, levels   as in `tree`
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.lattice_corners import may_be_degenerate
from geosurf.kernels.search.tree import FAN, LEAF, build_above, clear_boxes, levels_of

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
