"""Children of faces that an earlier arrangement cut alike: taken from there, with new numbers.

Scenes that differ in one input have most contacts in common. A face whose contacts are all of
surfaces that both have is cut as before, so only the others are cut. This saves work, and never
changes a result: where points come in another order, all faces are cut again.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.arrange import Children, cut_contacts
from geosurf.arrangement.search import Contacts
from geosurf.kernels.cutting.unchanged_faces import (
    changed_faces,
    merge_children,
    places_among,
)


@dataclass(frozen=True, eq=False)
class Earlier:
    """An arrangement, as what later ones take from it.

    Attributes
    ----------
    keys : tuple of hashable
        One of each surface, which stands for its triangles.
    origin, surface_of_face, key_of_face, nodes, rows, ids, x, d, n_vertex
        As `Contacts` has them.
    triangles, parent, cut, doubtful
        As `Children` has them.
    n_point : int
        Points of the children; those beyond `x` are crossings.
    """

    keys: tuple[Hashable, ...]
    origin: np.ndarray
    surface_of_face: np.ndarray
    key_of_face: np.ndarray
    nodes: list[tuple[np.ndarray, np.ndarray]]
    rows: np.ndarray
    ids: np.ndarray
    x: np.ndarray
    d: np.ndarray
    n_vertex: int
    triangles: np.ndarray
    parent: np.ndarray
    cut: np.ndarray
    doubtful: np.ndarray
    n_point: int

    @classmethod
    def of(cls, keys: Sequence[Hashable], contacts: Contacts, children: Children) -> Earlier:
        """Return what later arrangements need of one; nothing that it holds is kept by views."""
        # a child has a row, but arrays of children and points have room for more
        return cls(
            tuple(keys), contacts.origin, contacts.surface_of_face, contacts.key_of_face,
            contacts.nodes, contacts.rows, contacts.ids, contacts.x.copy(), contacts.d.copy(),
            contacts.n_vertex, children.triangles.copy(), children.parent.copy(), children.cut,
            children.doubtful, len(children.x),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Unchanged:
    """What two arrangements have in common.

    Attributes
    ----------
    face, point : ndarray of int64
        New number of each earlier face and point of the contacts, or -1; both rise.
    changed : ndarray of bool, shape (n_face,)
        New faces that have to be cut, if anything cuts them.
    """

    face: np.ndarray
    point: np.ndarray
    changed: np.ndarray


def compare(before: Earlier, contacts: Contacts, keys: Sequence[Hashable]) -> Unchanged | None:
    """Find what two arrangements have in common; None if that is nothing, or its order differs.

    Parameters
    ----------
    before : Earlier
    contacts : Contacts
        Of the new arrangement, in the same frame.
    keys : sequence of hashable
        One of each of its surfaces.
    """
    pairs = _common(before.keys, keys)
    same_frame = before.origin.tobytes() == contacts.origin.tobytes()

    # faces of one plane cut each other along edge planes, which have numbers of their own
    flat = before.ids.shape[1] != 2 or contacts.ids.shape[1] != 2
    if not pairs or not same_frame or flat:
        return None

    # faces by their keys, vertices by their nodes: both rise within a surface
    n0, n = len(before.key_of_face), len(contacts.key_of_face)
    face = np.full(n0, -1, dtype=np.int64)
    point = np.full(len(before.x), -1, dtype=np.int64)
    common0, common = np.zeros(n0, dtype=bool), np.zeros(n, dtype=bool)
    cut0, cut = (
        np.searchsorted(of, np.arange(len(held) + 1))
        for of, held in ((before.surface_of_face, before.keys), (contacts.surface_of_face, keys))
    )
    for i, j in pairs:
        part0, part = slice(cut0[i], cut0[i + 1]), slice(cut[j], cut[j + 1])
        common0[part0] = common[part] = True
        place = places_among(before.key_of_face[part0], contacts.key_of_face[part])
        face[part0] = np.where(place < 0, -1, place + cut[j])

        (nodes0, ids0), (nodes, ids) = before.nodes[i], contacts.nodes[j]
        place = places_among(nodes0, nodes)
        found = np.flatnonzero(place >= 0)
        point[ids0[found]] = ids[place[found]]

    changed, ordered = changed_faces(
        before.rows, before.ids, before.x, before.d, common0, face, point,
        contacts.rows, contacts.ids, contacts.x, contacts.d, common,
        before.n_vertex, contacts.n_vertex,
    )  # fmt: skip
    if not ordered:
        return None

    # crossings get their numbers in the order of faces: all that have any are cut again
    if before.n_point > len(before.x):
        crossed = face[before.parent[(before.triangles >= len(before.x)).any(axis=1)]]
        changed[crossed[crossed >= 0]] = True
    return Unchanged(face, point, changed)


def _common(one: Sequence[Hashable], other: Sequence[Hashable]) -> list[tuple[int, int]]:
    """Places of what two sequences have in common; none if its order differs, or keys are twice."""
    place = {key: j for j, key in enumerate(other)}
    if len(place) < len(other) or len(set(one)) < len(one):
        return []
    pairs = [(i, place[key]) for i, key in enumerate(one) if key in place]
    later = [j for _, j in pairs]
    return pairs if later == sorted(later) else []


def cut_changed(old: Earlier, contacts: Contacts, same: Unchanged) -> Children:
    """Return the children of all faces, of which only those that have changed are cut.

    Raises
    ------
    InvariantError
        As `cut_contacts`.
    """
    # `take` is many times as fast as an index in brackets where rows are short
    records = contacts.records
    new = cut_contacts(contacts, records.take(np.flatnonzero(same.changed[records[:, 0]]), axis=0))
    triangles, parent, doubtful = merge_children(
        old.triangles, old.parent, old.doubtful, same.face, same.point, same.changed,
        new.triangles, new.parent, new.doubtful,
    )  # fmt: skip

    cut = same.face[old.cut]
    cut = cut[cut >= 0]
    cut = np.sort(np.concatenate([cut[~same.changed[cut]], new.cut]))
    return Children(new.x, new.d, triangles, parent, cut, doubtful, new.collisions, new.m)


__all__ = ["Earlier", "Unchanged", "compare", "cut_changed"]
