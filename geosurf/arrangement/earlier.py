"""Children of faces that an earlier arrangement cut alike: taken from there, with new numbers.

Scenes that differ in one input have most contacts in common. A face whose contacts are all of
surfaces that both have is cut as before, so only the others are cut. This saves work, and never
changes a result: where points come in another order, all faces are cut again.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.arrangement.arrange import Children, cut_contacts
from geosurf.arrangement.search import Contacts
from geosurf.kernels.cutting.unchanged_faces import changed_faces, mark_crossed, places_among
from geosurf.model.pieces import Pieces


@dataclass(eq=False)
class Kept:
    """Pieces that were made of an arrangement, and what later ones take from them.

    Attributes
    ----------
    pieces : Pieces
    face : ndarray of int64, shape (n_triangle,)
        Face of the contacts that each triangle is of, or -1.
    id_of_point : ndarray of int64, shape (n_point,), or None
        Number of each point among those of the children, or above these; None where several points
        of the children are one.
    linked : ndarray of int64, shape (n, 2)
        Half-edges that are alone, and the runs behind them.
    rim : ndarray of int64
        Last half-edges of the edges between patches, rising.
    n_child : int
        How many of the triangles are parts of faces that were cut.
    came : Origin, or None
        Earlier pieces that these come from, until cells have been found.
    seams : (ndarray, ndarray), or None
        Triangles around each edge where cells meet, in order, once cells have been found.
    one_way : bool
        Whether no triangles coincide and each patch faces one way, once that is known.
    sums : FaceSums, or None
        Sums over the faces of the cells, once these have been found.
    """

    pieces: Pieces
    face: np.ndarray
    id_of_point: np.ndarray | None
    linked: np.ndarray
    rim: np.ndarray
    n_child: int
    came: Origin | None = None
    seams: tuple[np.ndarray, np.ndarray] | None = None
    one_way: bool = False
    sums: Any = None


@dataclass(frozen=True, eq=False)
class Origin:
    """Where pieces come from.

    Attributes
    ----------
    before : Kept
    after : ndarray of int64
        Triangle that each earlier triangle is now, or -1.
    halves : ndarray of int64
        Half-edges whose edges have changed, rising.
    ring, link : ndarray of int64
        As `Pieces` has them, of these half-edges by their rows: a ring leads to a row, too.
    patch : ndarray of int64
        Patch that each earlier patch is now, or -1 if it lost or gained something.
    """

    before: Kept
    after: np.ndarray
    halves: np.ndarray
    ring: np.ndarray
    link: np.ndarray
    patch: np.ndarray


@dataclass(frozen=True, eq=False)
class Earlier:
    """An arrangement, as what later ones take from it.

    Attributes
    ----------
    keys : tuple of hashable
        One of each surface, which stands for its triangles.
    origin, t, surface_of_face, key_of_face, nodes, rows, near, ids, x, d, n_vertex, slip
        As `Contacts` has them.
    pairs : list of (int, int)
        Pairs of surfaces that were searched.
    cut, n_thin, largest
        As `Children` has them.
    n_point : int
        Points of the children; those beyond `x` are crossings.
    collisions : int
        Distinct points that rounding put in one place.
    kept : Kept
    """

    keys: tuple[Hashable, ...]
    origin: np.ndarray
    t: np.ndarray
    surface_of_face: np.ndarray
    key_of_face: np.ndarray
    nodes: list[tuple[np.ndarray, np.ndarray]]
    rows: np.ndarray
    near: np.ndarray
    ids: np.ndarray
    x: np.ndarray
    d: np.ndarray
    n_vertex: int
    slip: float
    pairs: list[tuple[int, int]]
    cut: np.ndarray
    n_point: int
    collisions: int
    n_thin: int
    largest: float
    kept: Kept

    @classmethod
    def of(
        cls,
        keys: Sequence[Hashable],
        contacts: Contacts,
        children: Children,
        kept: Kept,
    ) -> Earlier:
        """Return what later arrangements need of one; nothing that it holds is kept by views."""
        # arrays of points that were made anew have room for more
        return cls(
            tuple(keys), contacts.origin, contacts.t, contacts.surface_of_face,
            contacts.key_of_face, contacts.nodes, contacts.rows, contacts.near, contacts.ids,
            _alone(contacts.x), _alone(contacts.d), contacts.n_vertex, contacts.slip,
            contacts.options["pairs"], children.cut, len(children.x), children.collisions,
            children.n_thin, children.largest, kept,
        )  # fmt: skip


def _alone(array: np.ndarray) -> np.ndarray:
    """An array that owns its memory: a copy of a part of a larger one."""
    return array if array.base is None else array.copy()


@dataclass(frozen=True, eq=False)
class Unchanged:
    """What two arrangements have in common.

    Attributes
    ----------
    surface, face, point : ndarray of int64
        New number of each earlier surface, face and point of the contacts, or -1; all rise.
    changed : ndarray of bool, shape (n_face,)
        New faces that have to be cut, if anything cuts them.
    """

    surface: np.ndarray
    face: np.ndarray
    point: np.ndarray
    changed: np.ndarray


@dataclass(frozen=True, eq=False)
class Carried:
    """An earlier arrangement, and what a new one has in common with it.

    Attributes
    ----------
    earlier : Earlier
    same : Unchanged
    edges : bool
        Whether edges are carried over, too: to match all of them costs less where most change.
    """

    earlier: Earlier
    same: Unchanged
    edges: bool = True

    def children(self) -> tuple[np.ndarray, np.ndarray]:
        """Triangles and parents of all children that are carried over, by parent."""
        kept, same = self.earlier.kept, self.same
        assert kept.id_of_point is not None  # else nothing is carried over
        is_cut = np.zeros(len(same.face) + 1, dtype=bool)  # the last one for face -1
        is_cut[self.earlier.cut] = (same.face >= 0)[self.earlier.cut]
        changed = np.append(same.changed, True)[same.face]
        is_cut[:-1] &= ~changed
        rows = np.flatnonzero(is_cut[kept.face])
        ids = kept.id_of_point[kept.pieces.triangles[rows]]
        return same.point[ids], same.face[kept.face[rows]]


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
    place_of_surface = common_rows(before, keys, contacts.origin)
    if place_of_surface is None or contacts.ids.shape[1] != 2 or before.kept.id_of_point is None:
        return None
    pairs = [(i, j) for i, j in enumerate(place_of_surface.tolist()) if j >= 0]

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

    return with_crossings(before, Unchanged(place_of_surface, face, point, changed))


def with_crossings(before: Earlier, same: Unchanged) -> Unchanged:
    """The same, with all faces changed that have crossings: these are numbered as they come."""
    if before.n_point > len(before.x):
        kept = before.kept
        of = kept.pieces.triangles, kept.face, kept.id_of_point
        mark_crossed(*of, len(before.x), same.face, same.changed)
    return same


def common_rows(before: Earlier, keys: Sequence[Hashable], origin: np.ndarray) -> np.ndarray | None:
    """New row of each earlier surface, or -1; None if none has one, or their order differs."""
    # faces of one plane cut each other along edge planes, which have numbers of their own
    if before.origin.tobytes() != origin.tobytes() or before.ids.shape[1] != 2:
        return None
    new = {key: j for j, key in enumerate(keys)}
    if len(new) < len(keys) or len(set(before.keys)) < len(before.keys):
        return None
    place = np.array([new.get(key, -1) for key in before.keys], dtype=np.int64)
    both = place[place >= 0]
    return place if len(both) and (np.diff(both) > 0).all() else None


def cut_changed(
    contacts: Contacts, carried: Carried, records: np.ndarray | None = None
) -> Children:
    """Return the children of faces that have changed, which `records` cut; `cut` are all faces that
    are cut.

    Raises
    ------
    InvariantError
        As `cut_contacts`.
    """
    same = carried.same
    if records is None:
        records = contacts.records_of(same.changed)
    new = cut_contacts(contacts, records)
    is_cut = np.zeros(len(contacts.t) + 1, dtype=bool)  # the last one for face -1
    is_cut[same.face[carried.earlier.cut]] = True
    is_cut[:-1] &= ~same.changed
    is_cut[new.cut] = True
    new.cut = np.flatnonzero(is_cut[:-1])
    return new


__all__ = [
    "Carried", "Earlier", "Kept", "Origin", "Unchanged", "common_rows", "compare", "cut_changed",
    "with_crossings",
]  # fmt: skip
