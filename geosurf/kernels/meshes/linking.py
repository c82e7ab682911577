"""Chains of segments with equal end points, and one order for the triangles of all surfaces."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.meshes.mesh import find, join

# ---- chains ----------------------------------------
# Chains of segments with equal end points, in one canonical order.
#
# Notation
#     nodes      points of one pair of surfaces after another, each pair's increasing
#     offsets    first link of each node, and the end of the last
#     links      node at the other end of each link; partner: the same link seen from there


def link_segments(
    segments: np.ndarray, first: np.ndarray, n_point: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Chains of points: points chain by chain, offsets, and the pair of each.

    The segments of pair i are those from `first[i]` on. A chain ends where other than two segments
    of its pair meet; one that returns to its start is closed and repeats it. Order: by pair; then
    chains from points with ends or branches, by their first point, then plain loops from their
    lowest point towards its lower neighbour.
    """
    n_pair = len(first) - 1
    pair = np.repeat(np.arange(n_pair), np.diff(first))
    nodes, ends = np.unique((n_point * pair)[:, None] + segments, return_inverse=True)
    begin = np.searchsorted(nodes, n_point * np.arange(n_pair + 1))
    chains, offsets, pair_of_chain = link_nodes(np.reshape(ends, (-1, 2)), begin)
    return nodes[chains] % max(n_point, 1), offsets, pair_of_chain


@scalar
def _links_of(ends, n_node):
    """Links of all nodes: offsets, links, partner."""
    n = ends.shape[0]
    offsets = np.zeros(n_node + 1, dtype=np.int64)
    for s in range(n):
        offsets[ends[s, 0] + 1] += 1
        offsets[ends[s, 1] + 1] += 1
    for i in range(n_node):
        offsets[i + 1] += offsets[i]

    # Fill both directions of each segment.
    fill = offsets[:-1].copy()
    links = np.empty(2 * n, dtype=np.int64)
    partner = np.empty(2 * n, dtype=np.int64)
    for s in range(n):
        a, b = ends[s, 0], ends[s, 1]
        # Places of both directions know each other, so that a walk marks both as used.
        p = fill[a]
        fill[a] += 1
        q = fill[b]
        fill[b] += 1
        links[p], links[q] = b, a
        partner[p], partner[q] = q, p
    return offsets, links, partner


@scalar
def _walk(start, first, offsets, links, partner, used, out, n):
    """Follow a chain from a node along one link until a node that does not have two links."""
    out[n] = start
    n += 1
    link = first
    while True:
        used[link] = True
        used[partner[link]] = True
        node = links[link]
        out[n] = node
        n += 1
        # A loop is closed, or an end or a branch is reached.
        if node == start or offsets[node + 1] - offsets[node] != 2:
            return n

        # Of the two links take the one that does not lead back.
        onward = offsets[node]
        if onward == partner[link]:
            onward += 1
        link = onward


@entry("l2 l1 -> l1 l1 l1")
def link_nodes(ends, begin):
    """Chains of nodes, see `link_segments`: nodes chain by chain, offsets, and the pair of each.

    `ends` are the nodes of each segment; those of pair i are from `begin[i]` to `begin[i + 1]`.
    """
    n = ends.shape[0]
    offsets, links, partner = _links_of(ends, begin[begin.shape[0] - 1])
    used = np.zeros(2 * n, dtype=np.bool_)
    out, starts = np.empty(2 * n, dtype=np.int64), np.empty(n + 1, dtype=np.int64)
    pair_of_chain = np.empty(n, dtype=np.int64)
    count, size = 0, 0
    for pair in range(begin.shape[0] - 1):
        # First chains from ends and branches, then closed loops.
        for plain in range(2):
            for node in range(begin[pair], begin[pair + 1]):
                passage = offsets[node + 1] - offsets[node] == 2
                if passage != (plain == 1):
                    continue
                while True:
                    # The link to the lowest neighbour, for a canonical direction.
                    best = -1
                    for link in range(offsets[node], offsets[node + 1]):
                        if not used[link] and (best < 0 or links[link] < links[best]):
                            best = link
                    # Every link at this node is used.
                    if best < 0:
                        break
                    starts[count], pair_of_chain[count] = size, pair
                    count += 1
                    size = _walk(node, best, offsets, links, partner, used, out, size)
    starts[count] = size
    return out[:size].copy(), starts[: count + 1].copy(), pair_of_chain[:count].copy()


# ---- merged pieces ----------------------------------------
# Put the triangles of all surfaces in one order, and number points and patches in it.
#
# The order is that of surfaces, then of keys in each. The parts of each surface come in order
# already, so one pass merges them: children of cut faces, faces that are not cut, and triangles
# that nothing meets, which are read where the surface has them.
#
# Notation
#     t        triangles, int64 (n, 3)
#     surface, key, face   where each is from: surface, key in it, and face of the contacts or -1
#     parent   face of each child, rising
#     lowest   lowest key of each run of a lattice, rising in each surface


@entry("l2 l1 l1 l2 l1 l1 l2 b1 l1 l1 l l l l l l2* l1* l1* l1* -> .")
def merge_by_face(
    child, parent, uncut, t, surface_of_face, key_of_face,
    other, taken, number, keys, number_of_surface, i, j, row, stop, triangles, surface, key, face,
):  # fmt: skip
    """Write all triangles of one surface in one order: children, faces not cut, and others.

    Parameters
    ----------
    other : int64 (n, 3)
        Triangles of the surface, of which those that are `taken` are faces of contacts; their
        points have numbers `number`. None if its other triangles are in strips.
    keys : int64 (n,)
        Their keys, rising; empty: their rows.
    number_of_surface : int
        The surface.
    i, j, row, stop : int
        Its first child, its first face that is not cut, its first row to write, and the last + 1.
    """
    n_face, n_child, n_uncut = t.shape[0], child.shape[0], uncut.shape[0]
    k = 0
    while row < stop:
        child_face = parent[i] if i < n_child else n_face
        uncut_face = uncut[j] if j < n_uncut else n_face
        next_face = min(child_face, uncut_face)

        # a triangle in no contact comes first if its place is lower
        while k < other.shape[0] and taken[k]:
            k += 1
        first = k < other.shape[0]
        if first and next_face < n_face and surface_of_face[next_face] == number_of_surface:
            place = keys[k] if keys.shape[0] else k
            first = place < key_of_face[next_face]
        surface[row] = number_of_surface
        if first:
            for c in range(3):
                triangles[row, c] = number[other[k, c]]
            key[row], face[row] = keys[k] if keys.shape[0] else k, -1
            k += 1
        elif child_face < uncut_face:
            for c in range(3):
                triangles[row, c] = child[i, c]
            key[row], face[row] = key_of_face[child_face], child_face
            i += 1
        else:
            for c in range(3):
                triangles[row, c] = t[uncut_face, c]
            key[row], face[row] = key_of_face[uncut_face], uncut_face
            j += 1
        row += 1


@entry("l1 l l1 l1 l2 l2 l1 l1 -> l1")
def number_patches(part, n_part, surface, key, linked, joined, lowest, first_run):
    """Patch of each triangle, then of each run; numbered by the first one of each in order.

    `part` are patches of triangles. A run continues the patches of triangles with a half-edge that
    is `linked` to it (half-edges and runs), and those of the runs that it is joined with.
    """
    n, n_run = part.shape[0], lowest.shape[0]
    parent = np.arange(n_part + n_run)
    for i in range(linked.shape[0]):
        join(parent, part[linked[i, 0] // 3], n_part + linked[i, 1])
    for i in range(joined.shape[0]):
        join(parent, n_part + joined[i, 0], n_part + joined[i, 1])

    node = np.empty(n + n_run, dtype=np.int64)
    node[:n] = part
    for run in range(n_run):
        node[n + run] = n_part + run

    # triangles and runs of each surface, merged by their keys; neighbours mostly have one node
    numbers = np.full(parent.shape[0], -1, dtype=np.int64)
    count = number = i = 0
    last = -1
    for s in range(first_run.shape[0] - 1):
        for run in range(first_run[s], first_run[s + 1] + 1):
            is_end = run == first_run[s + 1]
            while True:
                is_triangle = i < n and surface[i] == s and (is_end or key[i] < lowest[run])
                if not is_triangle and is_end:
                    break
                at = i if is_triangle else n + run
                if node[at] != last:
                    last = node[at]
                    root = find(parent, last)
                    if numbers[root] < 0:
                        numbers[root] = count
                        count += 1
                    number = numbers[root]
                node[at] = number
                if not is_triangle:
                    break
                i += 1
    return node
