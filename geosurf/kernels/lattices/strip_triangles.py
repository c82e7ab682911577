"""Runs of a lattice as triangles and points again: each array is written once, in its final order.

The order is that of keys: cut triangles (`cut`, their keys increasing) and those of runs alternate.
New points are the nodes of runs that no cut triangle has, increasing.

Notation, in addition to that of `strips` (a, runs, start)
    nodes, points  nodes that have a point already, and its index
    id_of_node     point of each node; -1 where runs have no such node
    places         run of each place in one strip; -1 where there is none
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, corner_of, key_at
from geosurf.kernels.search.tree import N_COL, N_ROW, RISING, TURNED

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
