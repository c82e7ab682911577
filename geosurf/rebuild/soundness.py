"""Find triangles that could cross after rounding; only those need an exact test.

Constructed points move by half a unit in the last place, e; nothing else moves. Two pieces
of faces that meet at an angle can cross away from what they share only within about e / sin of
their common line; so one of them, or a neighbour, is thinner than that. Pieces of faces that do
not meet can cross only if the signs that keep them apart could change by such a move, and
those pairs were noted when the signs were taken (`Contacts.near`). Which signs are taken depends
on how candidates are searched and contacts are found; so the pairs that were noted are judged again
by their corners alone (`kernels.sure`). What remains is the same for any search, and so is what a
repair moves. Thin pieces and near pairs are few (none in most scenes) and are compared with all
around them.
"""

from __future__ import annotations

import numpy as np

from geosurf.arrangement.arrange import Children
from geosurf.arrangement.crossing import crossing_pairs, near_triangles
from geosurf.arrangement.search import ULP, Contacts
from geosurf.kernels.contacts.stable_pairs import unstable_pairs
from geosurf.kernels.cutting.thin_pieces import thin_children
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.search.voxels import triangle_boxes

_SAFETY = 1024.0


def crossing_faces(contacts: Contacts, children: Children) -> np.ndarray:
    """Faces (rows of `Contacts.t`) with pieces that cross another triangle once rounded."""
    thin, near = _suspects(contacts, children)
    if len(thin) == 0 and len(near) == 0:
        return thin

    t, parent = children.triangles, children.parent
    if children.collisions:  # distinct points in one place are one vertex of the result
        number, _ = weld(children.x)
        t = np.unique(number, return_index=True)[1][number][t]

    # Children, then the faces that were not cut: all triangles of the result that matter.
    uncut = np.ones(len(contacts.t), dtype=bool)
    uncut[children.cut] = False
    uncut = np.flatnonzero(uncut)
    pieces = np.concatenate([t, contacts.t[uncut]])
    face = np.concatenate([parent, uncut])

    # Only triangles that are thin, or near others, can cross after rounding.
    suspect = _of_near_pairs(contacts, near, children.x, pieces, face)
    suspect[thin] = True
    if not suspect.any():
        return thin

    # Neighbours of suspects share their moved points.
    touched = np.zeros(len(children.x), dtype=bool)
    touched[pieces[suspect]] = True
    suspect[: len(t)] |= touched[t].any(axis=1)

    # Others that are apart from all suspects cannot cross them.
    close = suspect | near_triangles(children.x, pieces[suspect], pieces)
    pieces, face, suspect = pieces[close], face[close], suspect[close]

    # Twins of an overlap would cross in their whole area: each triangle once.
    once = _once(pieces, suspect)
    mine, others = once[suspect[once]], once[~suspect[once]]
    pairs = crossing_pairs(children.x, pieces[mine], pieces[others])
    return face[np.concatenate([mine, others])[pairs.ravel()]]


def _suspects(contacts: Contacts, children: Children) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the thin children, and near pairs of faces."""
    # Rounding scales with the largest coordinate. Constructed points lie in faces that are cut, so
    # it is that of those; which others are kept depends on the search.
    largest = float(np.abs(contacts.x[contacts.t[children.cut]]).max(initial=0.0))
    faces = contacts.x, contacts.t, contacts.m.copy(), contacts.w, contacts.rows
    of = children.x, children.triangles, children.parent
    # thinner than what rounding can do, given the flattest contact
    return thin_children(*faces, *of, _SAFETY * ULP * largest), near_pairs(contacts)


def near_pairs(contacts: Contacts) -> np.ndarray:
    """Near pairs (n, 2) of faces that rounding could change: the same for any search."""
    if len(contacts.near) == 0:
        return contacts.near

    keys = np.unique(_keys_of(contacts, contacts.near))
    pairs = np.stack(np.divmod(keys, len(contacts.t)), axis=1)

    # contacts are far more than near pairs: each is looked up among these
    met = _keys_of(contacts, contacts.rows)
    at = np.minimum(np.searchsorted(keys, met), len(keys) - 1)
    meet = np.zeros(len(keys), dtype=bool)
    meet[at[keys[at] == met]] = True

    # Pairs that meet stay in contact; only the relation of the others can change.
    m, w = contacts.m.copy(), contacts.w
    return pairs[unstable_pairs(contacts.x, contacts.t, m, w, pairs, meet, ULP)]


def _keys_of(contacts: Contacts, pairs: np.ndarray) -> np.ndarray:
    """One number for each pair of faces, the lower face first: numbers rise as pairs do."""
    one, two = pairs[:, 0], pairs[:, 1]
    keys: np.ndarray = np.minimum(one, two) * len(contacts.t) + np.maximum(one, two)
    return keys


def _of_near_pairs(
    contacts: Contacts, pairs: np.ndarray, x: np.ndarray, pieces: np.ndarray, face: np.ndarray
) -> np.ndarray:
    """Whether pieces are of faces in near pairs, and their boxes reach the other face."""
    suspect = np.zeros(len(pieces), dtype=bool)
    if len(pairs) == 0:
        return suspect

    # Rows of `pieces` by face, with offsets.
    order = np.argsort(face, kind="stable")
    start = np.searchsorted(face[order], np.arange(len(contacts.t) + 1))
    one, other = np.concatenate([pairs, pairs[:, ::-1]]).T

    # All pieces of one face against the other face of the pair.
    count = start[one + 1] - start[one]
    first = np.cumsum(count) - count
    piece = order[np.repeat(start[one] - first, count) + np.arange(count.sum())]

    # A piece away from the other face cannot cross it.
    boxes = triangle_boxes(x, pieces)[piece]
    reach = np.repeat(triangle_boxes(contacts.x, contacts.t)[other], count, axis=0)
    meets = (boxes[:, :3] <= reach[:, 3:]) & (reach[:, :3] <= boxes[:, 3:])
    suspect[piece[meets.all(axis=1)]] = True
    return suspect


def _once(triangles: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Rows with each set of corners once; rows in `first` are preferred."""
    corners = np.sort(triangles, axis=1)
    n = int(corners.max(initial=0)) + 1
    order = np.argsort(~first, kind="stable")
    if n < 2_000_000:  # three numbers in one key
        key = (corners[:, 0] * n + corners[:, 1]) * n + corners[:, 2]
        return order[np.unique(key[order], return_index=True)[1]]
    return order[np.unique(corners[order], axis=0, return_index=True)[1]]
