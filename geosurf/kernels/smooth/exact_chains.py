"""Points of exact curves, and the contacts that they come from.

Curves are sorted and linked, contacts are as the search found them. A table of points by their
coordinates joins both.

Notation
    local     points of the curves (n, 3)
    chain     rows of `local`, curve after curve; each curve as in `Curves.curves`
    contacts  `rows`, `ids`, `x`, `surface_of_face`, `key_of_face`, as in
              `geosurf.arrangement.search.Contacts`; only those that are lines are used
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.merging import short_hash
from geosurf.kernels.contacts.packed_contact import HOW, n_corner_of
from geosurf.kernels.smooth.cubic_patch import node

_MOST = 4  # contacts at a point: two, or more where a segment lies on an edge


@scalar
def _slot(x, bits, k, size):
    """First slot of point k of x in a table."""
    return (short_hash(x, bits, k) >> 8) & (size - 1)


@scalar
def _table_of(local):
    """Rows of points by their coordinates, in a table of twice as many slots; -1: free."""
    size, bits = 16, local.view(np.int64)
    while size < 2 * local.shape[0]:
        size *= 2
    table = np.full(size, -1, dtype=np.int64)
    for k in range(local.shape[0]):
        at = _slot(local, bits, k, size)
        while table[at] >= 0:
            at = (at + 1) & (size - 1)
        table[at] = k
    return table


@scalar
def _find(table, local, x, bits, k):
    """Row of the point where point k of x is; -1: none."""
    last = table.shape[0] - 1
    at = _slot(x, bits, k, table.shape[0])
    while table[at] >= 0:
        r = table[at]
        if local[r, 0] == x[k, 0] and local[r, 1] == x[k, 1] and local[r, 2] == x[k, 2]:
            return r
        at = (at + 1) & last
    return -1


@scalar
def contacts_of_points(local, x, rows, ids):
    """Up to four lines among the contacts that end at each point (n, 4); -1: none.

    No rows where an end is not among the points, or more lines meet in one.
    """
    table, bits = _table_of(local), x.view(np.int64)
    of = np.full((local.shape[0], _MOST), -1, dtype=np.int64)
    row_of = np.full(x.shape[0], -1, dtype=np.int64)  # nearly every end is that of two contacts
    for k in range(rows.shape[0]):
        if n_corner_of(rows[k, HOW]) != 2:
            continue
        for end in range(2):
            point, place = ids[k, end], 0
            r = row_of[point]
            if r < 0:
                r = row_of[point] = _find(table, local, x, bits, point)
            if r < 0:
                return of[:0]
            while place < _MOST and of[r, place] >= 0:
                place += 1
            if place == _MOST:
                return of[:0]
            of[r, place] = k
    return of


@scalar
def contact_of_segment(of, r, s):
    """The contact that ends at both points r and s; -1: none."""
    for i in range(_MOST):
        k = of[r, i]
        if k < 0:  # contacts come first
            return -1
        for j in range(_MOST):
            if k == of[s, j]:
                return k
    return -1


@scalar
def faces_of(rows, surface_of_face, k):
    """Both faces of a contact, that of the first surface first."""
    one, two = rows[k, 0], rows[k, 1]
    if surface_of_face[one] > 0:
        return two, one
    return one, two


@scalar
def is_near_hole(x, y, z, cell):
    """Whether a node is absent that interpolants of eight nodes read, in a cell or next to it."""
    n_row, n_col = z.shape
    i, j = cell // (n_col - 1), cell % (n_col - 1)
    first, last = max(min(i - 4, n_row - 9), 0), min(max(i + 5, 8), n_row - 1)
    left, right = max(min(j - 4, n_col - 9), 0), min(max(j + 5, 8), n_col - 1)
    for row in range(first, last + 1):
        for col in range(left, right + 1):
            if not math.isfinite(node(x, row, col) + node(y, row, col) + z[row, col]):
                return True
    return False


@scalar
def _join_single(near, first, last):
    """Mark a neighbour of each single marked segment, so that a point lies between two."""
    for i in range(first, last):
        if near[i] and not (i > first and near[i - 1]) and not (i + 1 < last and near[i + 1]):
            near[i + 1 if i + 1 < last else max(i - 1, first)] = True


@scalar
def trace_segments(
    xa, ya, za, xb, yb, zb, chain, offsets, of, rows, surface_of_face, key_of_face, holes
):  # fmt: skip
    """The contact of the segment from each point of the curves on, and whether it is near a hole.

    The last point of a curve has none: -1. No contacts where one cannot be found.
    """
    n = chain.shape[0]
    contact, near = np.full(n, -1, dtype=np.int64), np.zeros(n, dtype=np.bool_)
    if of.shape[0] == 0:
        return contact[:0], near
    last, said = -1, False  # most segments are in the cell of the one before
    for k in range(offsets.shape[0] - 1):
        for i in range(offsets[k], offsets[k + 1] - 1):
            contact[i] = contact_of_segment(of, chain[i], chain[i + 1])
            if contact[i] < 0:
                return contact[:0], near
            if holes == 0:
                continue
            one, two = faces_of(rows, surface_of_face, contact[i])
            cell = key_of_face[one] >> 1
            if cell != last:
                last, said = cell, is_near_hole(xa, ya, za, cell)
            near[i] = said
            if not said and zb.shape[0] > 1:
                near[i] = is_near_hole(xb, yb, zb, key_of_face[two] >> 1)
        _join_single(near, offsets[k], offsets[k + 1] - 1)
    return contact, near


@entry("d2 d2 d2 d2 d2 d2 d2 l1 l1 l2 l2 d2 l1 l1 -> b1 l")
def segments_near_holes(
    xa, ya, za, xb, yb, zb, local, chain, offsets, rows, ids, x, surface_of_face, key_of_face
):  # fmt: skip
    """Whether the segment from each point of the curves on is near a hole of a lattice, and 1; or
    0 where the contact of one cannot be found.
    """
    of = contacts_of_points(local, x, rows, ids)
    contact, near = trace_segments(
        xa, ya, za, xb, yb, zb, chain, offsets, of, rows, surface_of_face, key_of_face, 1
    )  # fmt: skip
    return near, 1 if contact.shape[0] == chain.shape[0] else 0
