"""The equations of the smoothest surface in an envelope matrix: ordering, assembly and solution.

A band along faults is nearly one-dimensional. Ordered by distance from its far end, as in Cuthill &
McKee (1969), Proc. 24th Nat. Conf. ACM, 157-172, an unknown is coupled to near neighbours only. The
Cholesky factor has no entries outside the envelope: from the first entry of each row to the
diagonal (George & Liu 1981, Computer Solution of Large Sparse Positive Definite Systems).

Notation
    number   of an unknown, -1 for a known node; in the numbering of the caller
    place    of an unknown in the elimination order
    first    first column of each row; row i holds columns first[i] .. i in
             lower[start[i] : start[i + 1]]
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.sheets.smooth_surface import KINDS, NODES, fill_forms, nodes_of_differences


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
