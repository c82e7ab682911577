"""Put the triangles of all surfaces in one order, as `merged_pieces` does, given earlier pieces.

Triangles of faces that are cut alike are the same in both, in the same order. They are copied
from the earlier pieces, with new numbers of faces and points; only what has changed is new.

Letters as in `merged_pieces`; a 0 marks what is of the earlier pieces, and
    new_face  face that each earlier face of the contacts is now, or -1
    changed   faces that are cut again, if anything cuts them
    point     number that each point of the earlier pieces has now, or -1
    after     for each earlier triangle the one that it is now, or -1
    blocks    rows (n, 3): first earlier triangle, the triangle that it is now, how many follow
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

FIRST0, FIRST_NOW, COUNT = 0, 1, 2  # of `blocks`
_END = np.iinfo(np.int64).max  # above all keys


@scalar
def longer(rows):
    """The same rows, with room for as many more."""
    found = np.empty((2 * rows.shape[0], rows.shape[1]), dtype=np.int64)
    found[: rows.shape[0]] = rows
    return found


@scalar
def _stays(face0, new_face, changed, i):
    """Whether an earlier triangle is of a face that is cut alike."""
    if face0[i] < 0:
        return False
    face = new_face[face0[i]]
    return face >= 0 and not changed[face]


@entry("l1 l l l1 b1 -> l")
def count_staying(face0, low, high, new_face, changed):
    """How many earlier triangles, of `low` to `high` - 1, are of faces that are cut alike."""
    n = 0
    for i in range(low, high):
        n += 1 if _stays(face0, new_face, changed, i) else 0
    return n


@scalar
def _key_of_next(rows, i, surface_of_face, key_of_face, of):
    """Key of the face of entry i, or `_END` if it is of another surface."""
    if i >= rows.shape[0] or surface_of_face[rows[i]] != of:
        return _END
    return key_of_face[rows[i]]


@scalar
def _append(blocks, n, i, row):
    """Add a pair of triangles to blocks; returns these, and how many they are."""
    if (
        n > 0
        and blocks[n - 1, FIRST0] + blocks[n - 1, COUNT] == i
        and blocks[n - 1, FIRST_NOW] + blocks[n - 1, COUNT] == row
    ):
        blocks[n - 1, COUNT] += 1
        return blocks, n
    if n == blocks.shape[0]:
        blocks = longer(blocks)
    blocks[n, FIRST0], blocks[n, FIRST_NOW], blocks[n, COUNT] = i, row, 1
    return blocks, n + 1


@scalar
def _write_kept(
    t0, key0, face0, new_face, changed, point, i, high, bound, of, row,
    triangles, surface, key, face, after,
):  # fmt: skip
    """Copy earlier triangles in a row, while their faces stay and their keys are below a bound.

    Returns the first earlier triangle, and the first row, behind them.
    """
    while i < high and key0[i] < bound and _stays(face0, new_face, changed, i):
        for c in range(3):
            triangles[row, c] = point[t0[i, c]]
        surface[row], key[row], face[row] = of, key0[i], new_face[face0[i]]
        after[i] = row
        i += 1
        row += 1
    return i, row


@entry("l2 l1 l1 l1 l1 b1 l l l2 l1 l1 l2 l1 l1 l2 b1 l1 l1 l l l l l l2 l1 l1 l1 l1 -> l2")
def carry_by_face(
    t0, key0, face0, point, new_face, changed, i0, high0, child, parent, uncut, t,
    surface_of_face, key_of_face, other, taken, number, keys, of, i, j, row, stop,
    triangles, surface, key, face, after,
):  # fmt: skip
    """Write all triangles of one surface in one order; returns their `blocks`.

    Parameters
    ----------
    t0, key0, face0, point, new_face, changed, i0, high0
        The earlier pieces; the surface has triangles `i0` to `high0` - 1 of them.
    child, parent, uncut
        Of faces that have changed.
    t, surface_of_face, key_of_face, other, taken, number, keys, of, i, j, row, stop
        As `merge_by_face` takes them.
    triangles, surface, key, face, after
        Written; `after` of triangles that are gone is not.
    """
    blocks, n_block, k = np.empty((256, 3), dtype=np.int64), 0, 0
    while row < stop:
        while k < other.shape[0] and taken[k]:
            k += 1
        of_other = _END
        if k < other.shape[0]:
            of_other = keys[k] if keys.shape[0] else k
        of_child = _key_of_next(parent, i, surface_of_face, key_of_face, of)
        of_uncut = _key_of_next(uncut, j, surface_of_face, key_of_face, of)

        # what nothing meets in the earlier pieces stays if nothing meets it now
        while i0 < high0:
            if face0[i0] < 0:
                if key0[i0] >= of_other:
                    break
            elif _stays(face0, new_face, changed, i0):
                break
            i0 += 1
        bound = min(of_other, of_child, of_uncut)
        if i0 < high0 and face0[i0] >= 0 and key0[i0] < bound:
            low0, low = i0, row
            i0, row = _write_kept(
                t0, key0, face0, new_face, changed, point, i0, high0, bound, of, row,
                triangles, surface, key, face, after,
            )  # fmt: skip
            blocks, n_block = _append(blocks, n_block, low0, low)
            blocks[n_block - 1, COUNT] += row - low - 1
            continue
        surface[row], key[row] = of, bound
        if bound == of_other:
            for c in range(3):
                triangles[row, c] = number[other[k, c]]
            face[row] = -1
            if i0 < high0 and face0[i0] < 0 and key0[i0] == bound:
                after[i0] = row
                blocks, n_block = _append(blocks, n_block, i0, row)
                i0 += 1
            k += 1
        elif bound == of_child:
            for c in range(3):
                triangles[row, c] = child[i, c]
            face[row] = parent[i]
            i += 1
        else:
            for c in range(3):
                triangles[row, c] = t[uncut[j], c]
            face[row] = uncut[j]
            j += 1
        row += 1
    return blocks[:n_block].copy()
