"""Put the triangles of all surfaces in one order, and number points and patches in it.

The order is that of surfaces, then of keys in each. Its parts come in order already, so one pass
merges them: children of cut faces, faces that are not cut, and triangles that nothing meets.

Notation
    t        triangles, int64 (n, 3)
    surface, key, face   where each is from: surface, key in it, and face of the contacts or -1
    parent   face of each child, rising
    lowest   lowest key of each run of a lattice, rising in each surface
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.meshes.mesh import find, join


@entry("l2 l1 l1 l2 l1 l1 l2 l1 l1 -> l2 l1 l1 l1")
def merge_by_face(
    child, parent, uncut, t, surface_of_face, key_of_face, other, other_surface, other_key
):
    """Children of faces, faces that are not cut, and others in no contact, in one order."""
    n_face, n = t.shape[0], child.shape[0] + uncut.shape[0] + other.shape[0]
    triangles = np.empty((n, 3), dtype=np.int64)
    surface, key = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    face = np.empty(n, dtype=np.int64)
    i = j = k = 0
    for row in range(n):
        one = parent[i] if i < child.shape[0] else n_face
        two = uncut[j] if j < uncut.shape[0] else n_face
        of = min(one, two)

        # a triangle in no contact comes first if its place is lower
        first = k < other.shape[0]
        if first and of < n_face:
            s = surface_of_face[of]
            first = other_surface[k] < s or (
                other_surface[k] == s and other_key[k] < key_of_face[of]
            )
        if first:
            for c in range(3):
                triangles[row, c] = other[k, c]
            surface[row], key[row], face[row] = other_surface[k], other_key[k], -1
            k += 1
            continue
        surface[row], key[row], face[row] = surface_of_face[of], key_of_face[of], of
        if one < two:
            for c in range(3):
                triangles[row, c] = child[i, c]
            i += 1
        else:
            for c in range(3):
                triangles[row, c] = t[of, c]
            j += 1
    return triangles, surface, key, face


@entry("l2 l -> l1 l")
def number_used(t, n):
    """Number of each of n points among those that triangles use, or -1; and how many these are.

    The triangles are written with the new numbers.
    """
    number = np.full(n, -1, dtype=np.int64)
    for i in range(t.shape[0]):
        for c in range(3):
            number[t[i, c]] = 0
    count = 0
    for p in range(n):
        if number[p] == 0:
            number[p] = count
            count += 1
    if count < n:
        for i in range(t.shape[0]):
            for c in range(3):
                t[i, c] = number[t[i, c]]
    return number, count


@scalar
def _number_of(parent, numbers, element, count):
    """Number of the set of an element, a new one if it has none; and how many there are."""
    root = find(parent, element)
    if numbers[root] < 0:
        numbers[root] = count
        count += 1
    return numbers[root], count


@entry("l1 l l1 l1 l1 l2 l1 l1 -> l1")
def number_patches(part, n_part, surface, key, link, joined, lowest, first_run):
    """Patch of each triangle, then of each run; numbered by the first one of each in order.

    `part` are patches of triangles. A run continues the patch of a triangle that is linked to it,
    and those of the runs that it is joined with.
    """
    n, n_run = part.shape[0], lowest.shape[0]
    parent = np.arange(n_part + n_run)
    for half in range(link.shape[0]):
        if link[half] >= 0:
            join(parent, part[half // 3], n_part + link[half])
    for i in range(joined.shape[0]):
        join(parent, n_part + joined[i, 0], n_part + joined[i, 1])

    # triangles and runs of each surface, merged by their keys
    numbers = np.full(n_part + n_run, -1, dtype=np.int64)
    out = np.empty(n + n_run, dtype=np.int64)
    i = count = 0
    for s in range(first_run.shape[0] - 1):
        for run in range(first_run[s], first_run[s + 1] + 1):
            last = run == first_run[s + 1]
            while i < n and surface[i] == s and (last or key[i] < lowest[run]):
                out[i], count = _number_of(parent, numbers, part[i], count)
                i += 1
            if not last:
                out[n + run], count = _number_of(parent, numbers, n_part + run, count)
    return out
