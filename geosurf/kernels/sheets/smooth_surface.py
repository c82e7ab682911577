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


# ---- envelope solver ----------------------------------------
# The equations of the smoothest surface in an envelope matrix: ordering, assembly and solution.
#
# A band along faults is nearly one-dimensional. Ordered by distance from its far end, as in
# Cuthill & McKee (1969), Proc. 24th Nat. Conf. ACM, 157-172, an unknown is coupled to near
# neighbours only. The Cholesky factor has no entries outside the envelope: from the first entry
# of each row to the diagonal (George & Liu 1981, Computer Solution of Large Sparse Positive
# Definite Systems).
#
# Notation
#     number   of an unknown, -1 for a known node; in the numbering of the caller
#     place    of an unknown in the elimination order
#     first    first column of each row; row i holds columns first[i] .. i in
#              lower[start[i] : start[i + 1]]


@scalar
def _neighbours(east, north):
    """Neighbours of each node: starts (n + 1,), and neighbours along all links in both directions.

    At a tip two sheets may share a neighbour, so that a node has more than four.
    """
    n = east.shape[0]
    start = np.zeros(n + 1, dtype=np.int64)
    # Each link is stored at one of its nodes and counted for both.
    for v in range(n):
        for u in (east[v], north[v]):
            if u >= 0:
                start[v + 1] += 1
                start[u + 1] += 1
    for v in range(n):
        start[v + 1] += start[v]

    # Fill both directions of each link.
    free = start[:n].copy()
    neighbours = np.empty(start[n], dtype=np.int64)
    for v in range(n):
        for u in (east[v], north[v]):
            if u >= 0:
                neighbours[free[v]], neighbours[free[u]] = u, v
                free[v] += 1
                free[u] += 1
    return start, neighbours


@scalar
def _spread(node, start, neighbours, seen, mark, queue):
    """Breadth-first order of nodes from one node, written to a queue; their number."""
    queue[0] = node
    seen[node] = mark
    count, done = 1, 0
    while done < count:
        v = queue[done]
        done += 1
        for k in range(start[v], start[v + 1]):
            u = neighbours[k]
            # Another mark for each search replaces clearing the array.
            if seen[u] != mark:
                seen[u] = mark
                queue[count] = u
                count += 1
    return count


@entry("l1 l1 l1 -> l1")
def places_in_order(east, north, number):
    """Place (n_unknown,) of each unknown: unknowns that share a difference are near each other.

    Links of known nodes count too, since differences reach across them.
    """
    n = east.shape[0]
    start, neighbours = _neighbours(east, north)
    n_unknown = 0
    for v in range(n):
        n_unknown = max(n_unknown, number[v] + 1)
    seen = np.full(n, -1, dtype=np.int64)
    queue = np.empty(n, dtype=np.int64)
    place = np.empty(n_unknown, dtype=np.int64)
    left = n_unknown
    for v in range(n):
        if seen[v] >= 0:
            continue
        # the last node found from any start is one end of the part; order all from there, reversed
        count = _spread(v, start, neighbours, seen, 2 * v, queue)
        count = _spread(queue[count - 1], start, neighbours, seen, 2 * v + 1, queue)
        for k in range(count):
            at = number[queue[k]]
            if at >= 0:
                # Places count down, which reverses the order: fill-in stays inside the envelope.
                left -= 1
                place[at] = left
    return place


@entry("l1 l1 b1 l1 d1 d1 l1 -> l1 d1 l1 d1")
def fill_envelope(east, north, square, number, value, weights, place):
    """Envelope of the energy matrix, and right-hand side (n_unknown,), both in elimination order.

    `value` holds the height where `number` is -1. See `smooth_surface` for the other arguments.
    """
    n, n_unknown = east.shape[0], place.shape[0]
    forms = np.zeros((KINDS, NODES * NODES))
    fill_forms(weights, forms)
    g, at = np.empty(NODES, dtype=np.int64), np.empty(NODES, dtype=np.int64)
    # At first each row holds its diagonal only.
    first = np.arange(n_unknown)

    # The envelope: first column of each row.
    for v in range(n):
        form = forms[nodes_of_differences(v, east, north, square, g)]
        least = _look_up(g, form, number, place, at)
        for i in range(NODES):
            if at[i] >= 0:
                first[at[i]] = min(first[at[i]], least)

    # Rows of the envelope, one after the other.
    start = np.zeros(n_unknown + 1, dtype=np.int64)
    for row in range(n_unknown):
        start[row + 1] = start[row] + row - first[row] + 1

    # Add the form of each node: unknown times unknown, or times a known height.
    lower, right = np.zeros(start[n_unknown]), np.zeros(n_unknown)
    for v in range(n):
        form = forms[nodes_of_differences(v, east, north, square, g)]
        # No unknown among the nodes: nothing to add.
        if _look_up(g, form, number, place, at) == n_unknown:
            continue
        for i in range(NODES):
            p = at[i]
            if p >= 0:
                lower[start[p + 1] - 1] += form[NODES * i + i]
            # This node does not exist, so it has no products.
            if g[i] < 0:
                continue
            # The matrix is symmetric: the lower half is enough.
            for j in range(i):
                w = form[NODES * i + j]
                q = at[j]
                if w == 0.0:
                    continue
                if p >= 0 and q >= 0:
                    row = max(p, q)
                    lower[start[row] + min(p, q) - first[row]] += w
                # A known height moves to the right-hand side.
                elif p >= 0:
                    right[p] -= w * value[g[j]]
                elif q >= 0:
                    right[q] -= w * value[g[i]]
    return first, lower, start, right


@scalar
def _look_up(g, form, number, place, at):
    """Write the places of the ten nodes of a node, -1 for known and missing ones; the least one."""
    least = place.shape[0]
    for i in range(NODES):
        # a form without second and third differences has three nodes
        k = number[g[i]] if form[NODES * i + i] != 0.0 else -1
        at[i] = place[k] if k >= 0 else -1
        if k >= 0:
            least = min(least, at[i])
    return least


@entry("l1 d1* l1 -> l")
def factorise(first, lower, start):
    """Cholesky factor of an envelope matrix, in place; the row with a pivot <= 0, or -1."""
    for i in range(first.shape[0]):
        # Entry (i, j) is at at + j: rows are stored from their first column on.
        at = start[i] - first[i]
        for j in range(first[i], i):
            low = max(first[i], first[j])
            below = start[j] - first[j]

            # Row by row: inner products inside the common envelope.
            total = lower[at + j]
            for k in range(low, j):
                total -= lower[at + k] * lower[below + k]
            lower[at + j] = total / lower[below + j]
        pivot = lower[at + i]
        for k in range(first[i], i):
            pivot -= lower[at + k] * lower[at + k]
        # Written so that NaN fails too.
        if not pivot > 0.0:
            return i
        lower[at + i] = np.sqrt(pivot)
    return -1


@entry("l1 d1 l1 d1 -> d1")
def substitute(first, lower, start, right):
    """Solution (n,) by forward and back substitution with a factor of `factorise`."""
    n = first.shape[0]
    x = right.copy()

    # Forward, then backward substitution.
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


@entry("l1 d1 l1 l1 l1 d1 l1 -> l1 d1 l1")
def add_squares(first, lower, start, row, column, weight, place):
    """Envelope with squares of linear forms added, extended as needed.

    Row k has weights row[k] .. row[k + 1] at distinct unknowns `column`.
    """
    n = first.shape[0]
    wide = first.copy()

    # Extend the envelope to the least place of each form.
    for r in range(row.shape[0] - 1):
        least = n
        for k in range(row[r], row[r + 1]):
            least = min(least, place[column[k]])
        for k in range(row[r], row[r + 1]):
            p = place[column[k]]
            wide[p] = min(wide[p], least)
    begin = np.zeros(n + 1, dtype=np.int64)
    for i in range(n):
        begin[i + 1] = begin[i] + i - wide[i] + 1
    out = np.zeros(begin[n])

    # Copy the old rows, then add the squares.
    for i in range(n):
        at = begin[i] + first[i] - wide[i]
        for k in range(start[i + 1] - start[i]):
            out[at + k] = lower[start[i] + k]
    for r in range(row.shape[0] - 1):
        for k in range(row[r], row[r + 1]):
            p = place[column[k]]
            # Each pair of unknowns once; its place is in the row of the later one.
            for m in range(row[r], k + 1):
                q = place[column[m]]
                high = max(p, q)
                out[begin[high] + min(p, q) - wide[high]] += weight[k] * weight[m]
    return wide, out, begin


# ---- graph distance ----------------------------------------
# Distance of each node of a lattice graph from a set of nodes, in links.
#
# `east` and `north` are the neighbours of each node, -1 where the link is cut or missing; no node
# is the neighbour of two nodes in one direction.


@entry("l1 l1 b1 l -> l1")
def steps_from(east, north, start, longest):
    """Number of links (n,) from each node to the nearest of `start`, at most `longest`."""
    n = east.shape[0]

    # Links in all four directions.
    neighbours = np.full((n, 4), -1, dtype=np.int64)
    for v in range(n):
        if east[v] >= 0:
            neighbours[v, 0] = east[v]
            neighbours[east[v], 1] = v
        if north[v] >= 0:
            neighbours[v, 2] = north[v]
            neighbours[north[v], 3] = v

    # Breadth-first search from all start nodes at once.
    # Nodes that are never reached stay at `longest`.
    steps = np.full(n, longest, dtype=np.int64)
    queue = np.empty(n, dtype=np.int64)
    count = done = 0
    for v in range(n):
        if start[v]:
            steps[v] = 0
            queue[count] = v
            count += 1
    while done < count:
        v = queue[done]
        done += 1
        ahead = steps[v] + 1
        for k in range(4):
            u = neighbours[v, k]
            # Nodes come in order of their distance, so the first visit is final.
            if u >= 0 and ahead < steps[u]:
                steps[u] = ahead
                queue[count] = u
                count += 1
    return steps
