"""The equations of the smoothest surface: squared differences on a graph of lattice nodes.

Minimised over the unknown heights u, all others fixed, in units of cells:

    E = |D3 u|^2 + a^2 |D2 u|^2 + e^2 |D1 u|^2

Dk holds all k-th differences with the multinomial weights of the continuous energies: 1, sqrt(3)
for the third, 1, sqrt(2) for the second ones. A difference exists only if all nodes of its block
exist and all links inside it, diagonals too, are uncut: that alone gives the natural conditions
of a free plate at faults, boundaries and holes. `east` and `north` are the neighbours of each
node, -1 where the link is cut or missing; `square` is true where both diagonals of the block
north-east of a node are uncut.

All differences that start at a node v and go east and north use ten nodes. The set of differences
that exist is one of 512 kinds; the sum of their squares is a quadratic form of the ten heights,
tabulated for each kind. So each node adds one small matrix.

Third differences: third-order smoothness in the sense of Wahba (1990), Spline Models for
Observational Data, on a lattice as Briggs (1974), Geophysics 39, 39-48.

Notation
    g        the ten nodes of v, as rows of the graph, -1 where there is none: v, one, two and three
             to the east (1 2 3), to the north (4 5 6), one each way (7), two and one (8), one and
             two (9)
    kind     bits 0 1 2: nodes 1 2 3 are there; 3 4 5: nodes 4 5 6; 6: the block at v is whole;
             7: the one east of it, too; 8: the one north of it, too
    forms    the matrix (10, 10) of each kind, row by row
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

SLOTS = 64
DIAGONAL = 24
NODES = 10
KINDS = 512


@scalar
def _block(v, east, north, square):
    """North-east node of the block at v, if the block is whole; -1 otherwise."""
    if v < 0 or not square[v] or east[v] < 0 or north[v] < 0:
        return -1

    # Both ways around the block have to end at one node.
    one, two = north[east[v]], east[north[v]]
    return one if one == two else -1


@scalar
def nodes_of_differences(v, east, north, square, g):
    """Write the ten nodes of v, and return the kind of their differences."""
    kind = 0
    # -1 until a link shows that the node exists.
    for i in range(NODES):
        g[i] = -1
    g[0] = v
    for k in range(3):
        # Three steps east and three north, as far as links exist.
        before = g[k]
        if before >= 0 and east[before] >= 0:
            g[1 + k] = east[before]
            kind |= 1 << k
        before = g[3 + k] if k > 0 else v
        if before >= 0 and north[before] >= 0:
            g[4 + k] = north[before]
            kind |= 8 << k

    # The blocks north-east of v, of its east and of its north neighbour.
    g[7] = _block(v, east, north, square)
    if g[7] >= 0:
        kind |= 64
        # Two whole blocks side by side carry a mixed third difference.
        if g[2] >= 0 and _block(g[1], east, north, square) >= 0:
            g[8] = north[g[2]]
            kind |= 128
        if g[5] >= 0 and _block(g[4], east, north, square) >= 0:
            g[9] = east[g[5]]
            kind |= 256
    return kind


@scalar
def _add_square(form, nodes, weights, n, scale):
    """Add the square of one difference to a quadratic form."""
    for i in range(n):
        for j in range(n):
            form[NODES * nodes[i] + nodes[j]] += scale * scale * weights[i] * weights[j]


@scalar
def fill_forms(weights, forms):
    """Fill the forms of all kinds; `weights` as in `normal_equations`."""
    # Weights of differences: binomial along an axis, then mixed second and third ones.
    first = np.array([-1.0, 1.0])
    second = np.array([1.0, -2.0, 1.0])
    third = np.array([-1.0, 3.0, -3.0, 1.0])
    twist = np.array([1.0, -1.0, -1.0, 1.0])
    ramp = np.array([1.0, -2.0, 1.0, -1.0, 2.0, -1.0])
    corner = np.array([0, 1, 4, 7])
    lines = np.array([[0, 1, 2, 3], [0, 4, 5, 6]])
    ramps = np.array([[0, 1, 2, 4, 7, 8], [0, 4, 5, 1, 7, 9]])
    e, a, c, wx, wy = weights
    for kind in range(KINDS):
        form = forms[kind]
        for axis in range(2):
            w, w2 = (wx, wy) if axis == 0 else (wy, wx)

            # Differences along one axis, of order one to three.
            line, present = lines[axis], kind >> (3 * axis)
            if present & 1:
                _add_square(form, line, first, 2, e * w)
            if present & 3 == 3:
                _add_square(form, line, second, 3, a * w * w)
            if present & 7 == 7:
                _add_square(form, line, third, 4, c * w * w * w)
            # The mixed third difference, which needs both blocks.
            if kind & 64 and kind & (128 << axis):
                _add_square(form, ramps[axis], ramp, 6, c * np.sqrt(3.0) * w * w * w2)
        if kind & 64:
            _add_square(form, corner, twist, 4, a * np.sqrt(2.0) * wx * wy)


@entry("l1 l1 b1 l2 l1 d1 -> d2 l2")
def normal_equations(east, north, square, cell, unknown, weights):
    """Matrix (n_unknown, SLOTS) of the energy, and its columns, -1 for none.

    There is a slot for each of the 49 places that a difference reaches, the others are for places
    with two nodes. `cell` (n, 2) row and column of each node, `unknown` its number or -1;
    `weights`: e, a, 1 (0: no such differences), and h/dx, h/dy for cells that are not square.
    """
    n = east.shape[0]
    n_unknown = 0
    for v in range(n):
        n_unknown = max(n_unknown, unknown[v] + 1)
    matrix = np.zeros((n_unknown, SLOTS))
    column = np.full((n_unknown, SLOTS), -1, dtype=np.int64)
    forms = np.zeros((KINDS, NODES * NODES))
    fill_forms(weights, forms)
    g = np.empty(NODES, dtype=np.int64)

    # The slot of a neighbour follows from its position relative to the node.
    place = np.empty(n, dtype=np.int64)  # of a slot, in the order of rows of seven
    # A difference reaches three nodes to either side: rows of seven places.
    for v in range(n):
        place[v] = 7 * cell[v, 0] + cell[v, 1]
        if unknown[v] >= 0:
            column[unknown[v], DIAGONAL] = unknown[v]
    for v in range(n):
        form = forms[nodes_of_differences(v, east, north, square, g)]
        for i in range(NODES):
            p = unknown[g[i]] if g[i] >= 0 else -1
            if p < 0:
                continue
            for j in range(NODES):
                w = form[NODES * i + j]
                if w == 0.0 or unknown[g[j]] < 0:
                    continue
                q = unknown[g[j]]
                slot = DIAGONAL + place[g[j]] - place[g[i]]
                # two sheets may have a node at one position: then the next free slot
                while column[p, slot] >= 0 and column[p, slot] != q:
                    slot = (slot + 1) % SLOTS
                matrix[p, slot] += w
                column[p, slot] = q
    return matrix, column


@entry("l1 l1 b1 d2 d1 -> d2")
def energy_gradient(east, north, square, heights, weights):
    """Derivatives (n, k) of half the energy by all heights (n, k), for k surfaces at once."""
    n, k = heights.shape
    out = np.zeros((n, k))
    forms = np.zeros((KINDS, NODES * NODES))
    fill_forms(weights, forms)
    g = np.empty(NODES, dtype=np.int64)
    for v in range(n):
        # Add the form of each node times its ten heights.
        form = forms[nodes_of_differences(v, east, north, square, g)]
        for i in range(NODES):
            for j in range(NODES):
                w = form[NODES * i + j]
                if w != 0.0:
                    for s in range(k):
                        out[g[i], s] += w * heights[g[j], s]
    return out
