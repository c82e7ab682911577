"""The smoothest surface through data: sums of squared differences on a graph of lattice nodes.

Minimised over the unknown heights u, all others fixed, in units of cells:

    E = |D3 u|^2 + a^2 |D2 u|^2 + e^2 |D1 u|^2

Dk holds all k-th differences with the multinomial weights of the continuous energies: 1, sqrt(3)
for the third, 1, sqrt(2) for the second ones. A difference exists only if all nodes of its block
exist and all links inside it, diagonals too, are uncut: that alone gives the natural conditions
of a free plate at faults, rims and holes. `east` and `north` are the neighbours of each node, -1
where the link is cut or missing; `square` tells that both diagonals of the block north-east of a
node are uncut.

The matrix has one row per unknown and a slot for each of the 49 places that a difference reaches;
the others are for places with two nodes. It is solved by Cholesky's method on the envelope: a
band along faults is nearly one-dimensional. Third differences: third-order smoothness in the
sense of Wahba (1990), Spline Models for Observational Data, on a lattice as Briggs
(1974), Geophysics 39, 39-48.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar

SLOTS = 64
DIAGONAL = 24


@scalar
def _step(neighbour, v):
    return neighbour[v] if v >= 0 else -1


@scalar
def _line(neighbour, v, g):
    """Up to four nodes in a line, from v on; their number."""
    g[0] = v
    n = 1
    while n < 4 and _step(neighbour, g[n - 1]) >= 0:
        g[n] = neighbour[g[n - 1]]
        n += 1
    return n


@scalar
def _block(v, east, north, square):
    """North-east node of the block at v, if the block is whole; -1 otherwise."""
    if v < 0 or not square[v] or east[v] < 0 or north[v] < 0:
        return -1
    one, two = north[east[v]], east[north[v]]
    return one if one == two else -1


@scalar
def _add(nodes, weights, n, scale, unknown, value, place, matrix, column, right, number):
    """Add one squared difference to the normal equations."""
    some = False
    for i in range(n):
        number[i] = unknown[nodes[i]]
        some |= number[i] >= 0
    if not some:
        return
    for i in range(n):
        p = number[i]
        if p < 0:
            continue
        wi = scale * weights[i]
        first = DIAGONAL - place[nodes[i]]
        for j in range(n):
            w = wi * scale * weights[j]
            q = number[j]
            if q < 0:
                right[p] -= w * value[nodes[j]]
                continue
            slot = first + place[nodes[j]]
            # two sheets may have a node at one place: the next free slot then
            while column[p, slot] >= 0 and column[p, slot] != q:
                slot = (slot + 1) % SLOTS
            matrix[p, slot] += w
            column[p, slot] = q


@entry("l1 l1 b1 l2 l1 d1 d1 -> d2 l2 d1")
def normal_equations(east, north, square, cell, unknown, value, weights):
    """Matrix (n_unknown, SLOTS), its columns (-1 none) and right side.

    `cell` (n, 2) row and column of each node, `unknown` its number or -1 (then `value` holds);
    `weights`: e, a, 1 (0: no such differences), and h/dx, h/dy for cells that are not square.
    """
    n = east.shape[0]
    n_unknown = 0
    for v in range(n):
        n_unknown = max(n_unknown, unknown[v] + 1)
    matrix = np.zeros((n_unknown, SLOTS))
    column = np.full((n_unknown, SLOTS), -1, dtype=np.int64)
    column[:, DIAGONAL] = np.arange(n_unknown)
    right = np.zeros(n_unknown)
    first = np.array([-1.0, 1.0])
    second = np.array([1.0, -2.0, 1.0])
    third = np.array([-1.0, 3.0, -3.0, 1.0])
    twist = np.array([1.0, -1.0, -1.0, 1.0])
    ramp = np.array([1.0, -2.0, 1.0, -1.0, 2.0, -1.0])
    e, a, c, wx, wy = weights
    g, number = np.empty(6, dtype=np.int64), np.empty(6, dtype=np.int64)
    place = np.empty(n, dtype=np.int64)  # of a slot, in the order of rows of seven
    for v in range(n):
        place[v] = 7 * cell[v, 0] + cell[v, 1]
    for v in range(n):
        for way in range(2):
            along, across = (east, north) if way == 0 else (north, east)
            w, w2 = (wx, wy) if way == 0 else (wy, wx)
            length = _line(along, v, g)
            if length > 1:
                _add(g, first, 2, e * w, unknown, value, place, matrix, column, right, number)
            if length > 2 and a != 0.0:
                _add(g, second, 3, a * w * w, unknown, value, place, matrix, column, right, number)
            if c == 0.0:
                continue
            if length > 3:
                scale = c * w * w * w
                _add(g, third, 4, scale, unknown, value, place, matrix, column, right, number)
            if (
                length > 2
                and _block(v, east, north, square) >= 0
                and _block(g[1], east, north, square) >= 0
            ):
                for i in range(3):
                    g[3 + i] = across[g[i]]
                scale = c * np.sqrt(3.0) * w * w * w2
                _add(g, ramp, 6, scale, unknown, value, place, matrix, column, right, number)
        corner = _block(v, east, north, square)
        if corner >= 0 and a != 0.0:
            g[0], g[1], g[2], g[3] = v, east[v], north[v], corner
            scale = a * np.sqrt(2.0) * wx * wy
            _add(g, twist, 4, scale, unknown, value, place, matrix, column, right, number)
    return matrix, column, right


@entry("l1 d1 l1 -> l")
def factorise(first, lower, start):
    """Cholesky factor of an envelope matrix, in place; the row that is not positive, or -1.

    Row i holds columns first[i] .. i in lower[start[i] : start[i + 1]].
    """
    for i in range(first.shape[0]):
        at = start[i] - first[i]
        for j in range(first[i], i):
            low = max(first[i], first[j])
            below = start[j] - first[j]
            total = lower[at + j]
            for k in range(low, j):
                total -= lower[at + k] * lower[below + k]
            lower[at + j] = total / lower[below + j]
        pivot = lower[at + i]
        for k in range(first[i], i):
            pivot -= lower[at + k] * lower[at + k]
        if not pivot > 0.0:
            return i
        lower[at + i] = np.sqrt(pivot)
    return -1


@entry("l1 d1 l1 d1 -> d1")
def substitute(first, lower, start, right):
    """Solution (n,) for a factor of `factorise`."""
    n = first.shape[0]
    x = right.copy()
    for i in range(n):
        at = start[i] - first[i]
        for k in range(first[i], i):
            x[i] -= lower[at + k] * x[k]
        x[i] /= lower[at + i]
    for i in range(n - 1, -1, -1):
        at = start[i] - first[i]
        x[i] /= lower[at + i]
        for k in range(first[i], i):
            x[k] -= lower[at + k] * x[i]
    return x
