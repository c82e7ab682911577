"""Faces in contact, with the vertices that they use, out of all faces that are candidates.

Numbers keep their order. Letters as in `packed_contact`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry
from geosurf.kernels.contacts.packed_contact import TRIANGLE_A, TRIANGLE_B


@entry("l2* l2* l -> l1 l")
def number_faces(rows, near, n_face):
    """New number of each face in contacts or near pairs, or -1, and how many; both get them."""
    number = np.full(n_face, -1, dtype=np.int64)
    for k in range(rows.shape[0]):
        number[rows[k, TRIANGLE_A]] = number[rows[k, TRIANGLE_B]] = 0
    for k in range(near.shape[0]):
        number[near[k, 0]] = number[near[k, 1]] = 0
    n = 0
    for face in range(n_face):
        if number[face] == 0:
            number[face] = n
            n += 1
    for k in range(rows.shape[0]):
        rows[k, TRIANGLE_A] = number[rows[k, TRIANGLE_A]]
        rows[k, TRIANGLE_B] = number[rows[k, TRIANGLE_B]]
    for k in range(near.shape[0]):
        near[k, 0], near[k, 1] = number[near[k, 0]], number[near[k, 1]]
    return number, n


@entry("l2 l1 l1 l1 l l2* l1* l1* -> l1 l1")
def select_faces(t, surface, key, number, n_vertex, new_t, new_surface, new_key):
    """Write the faces that have a number; returns the new number of each vertex that these use, or
    -1, and those vertices.
    """
    of_vertex = np.full(n_vertex, -1, dtype=np.int64)
    for face in range(t.shape[0]):
        if number[face] >= 0:
            for c in range(3):
                of_vertex[t[face, c]] = 0
    used = np.empty(n_vertex, dtype=np.int64)
    n = 0
    for v in range(n_vertex):
        if of_vertex[v] == 0:
            of_vertex[v], used[n] = n, v
            n += 1
    for face in range(t.shape[0]):
        at = number[face]
        if at >= 0:
            for c in range(3):
                new_t[at, c] = of_vertex[t[face, c]]
            new_surface[at], new_key[at] = surface[face], key[face]
    return of_vertex, used[:n].copy()
