"""Which corners of the copies of torn triangles are one vertex?"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.meshes.mesh import find, join


@scalar
def _join_node(parent, element, of, count, n, corner, node):
    """Unite a corner with the element of its node; elements follow the corners."""
    if element[node] < 0:
        element[node] = count
        of[count - 3 * n] = node
        count += 1
    join(parent, corner, element[node])
    return count


@scalar
def _has_real(corners, real, copy, node):
    """Whether a node is a real corner of a copy."""
    for k in range(3):
        if real[copy, k] and corners[copy, k] == node:
            return True
    return False


@entry("l1 l2 b2 l2 b2 l -> l2 l1 l1")
def glue_copies(triangle, corners, real, across, exists, n_node):
    """Number the ghosts of torn copies: corners of copies that are glued are one.

    Two copies are glued over a common edge if an end of it is real in both.

    Parameters
    ----------
    triangle : int64 (n,)
        Of the lattice, rising: the copies of one follow each other.
    corners : int64 (n, 3)
        Its nodes.
    real : bool (n, 3)
    across : int64 (n, 3)
        The triangle beyond each edge, from a corner to the next, and whether it `exists`.
    n_node : int
        Of the lattice: ghosts are numbered from here on, as they first appear.

    Returns
    -------
    vertex : int64 (n, 3)
    anchor, node : int64 (n_ghost,)
        A real corner of the first copy that has each ghost, and the node below it.
    """
    n = triangle.shape[0]
    element = np.full(n_node, -1, dtype=np.int64)
    parent = np.arange(6 * n)
    of = np.empty(3 * n, dtype=np.int64)
    count = 3 * n
    for i in range(n):
        for k in range(3):
            # a real corner is its node; so is one that an untorn neighbour shares
            if real[i, k]:
                count = _join_node(parent, element, of, count, n, 3 * i + k, corners[i, k])
            e = 0 if k == 2 else k + 1
            if not exists[i, k]:
                continue
            first = np.searchsorted(triangle, across[i, k])
            is_whole = first == n or triangle[first] != across[i, k]
            for turn in range(2):
                here, there = (k, e) if turn == 0 else (e, k)
                if not real[i, here]:
                    continue
                if is_whole:
                    if not real[i, there]:
                        at = 3 * i + there
                        count = _join_node(parent, element, of, count, n, at, corners[i, there])
                    continue
                m = first
                while m < n and triangle[m] == across[i, k]:
                    if _has_real(corners, real, m, corners[i, here]):
                        for shared in (here, there):
                            for twin in range(3):
                                if corners[m, twin] == corners[i, shared]:
                                    join(parent, 3 * i + shared, 3 * m + twin)
                                    break
                    m += 1

    # corners with a node in their set are that node
    node_of = np.full(6 * n, -1, dtype=np.int64)
    for j in range(count - 3 * n):
        root = find(parent, 3 * n + j)
        node_of[root] = max(node_of[root], of[j])
    vertex = np.empty((n, 3), dtype=np.int64)
    number = np.full(6 * n, -1, dtype=np.int64)
    anchor, node = np.empty(3 * n, dtype=np.int64), np.empty(3 * n, dtype=np.int64)
    n_ghost = 0
    for i in range(n):
        for k in range(3):
            root = find(parent, 3 * i + k)
            if node_of[root] >= 0:
                vertex[i, k] = node_of[root]
                continue
            if number[root] < 0:
                number[root] = n_ghost
                at = 0 if real[i, 0] else 1 if real[i, 1] else 2 if real[i, 2] else 0
                anchor[n_ghost], node[n_ghost] = corners[i, at], corners[i, k]
                n_ghost += 1
            vertex[i, k] = n_node + number[root]
    return vertex, anchor[:n_ghost].copy(), node[:n_ghost].copy()
