"""Find where a surface that meets another one also meets itself, and cut it there too.

Two surfaces share the vertices of their curves, and the triangles of an area, only if both are cut
alike there. Whatever meets one of them there meets the other as well, and cuts both, except the
sheets of a surface itself: without `self_intersections` these cut only the other one. So a
surface is searched for contacts with itself if two of its triangles, both of which meet another
surface, meet each other elsewhere than in common corners and edges.
"""

from __future__ import annotations

import numpy as np

from geosurf.arrangement.crossing import crossing_pairs
from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.kernels.contacts.packed_contact import mark_met


def with_own_contacts(contacts: Contacts) -> Contacts:
    """The contacts, with those of surfaces with themselves that sharing vertices asks for."""
    # Faces that meet another surface.
    of, n_face = contacts.surface_of_face, len(contacts.t)
    met = mark_met(contacts.rows, of, np.arange(n_face), n_face)
    before = _met_before(contacts)
    searched = {tuple(pair) for pair in contacts.options["pairs"]}
    more = []
    for i, surface in enumerate(contacts.surfaces):
        # A graph over the map cannot meet itself.
        is_graph = surface.lattice is not None and surface.lattice.is_graph
        if is_graph or (i, i) in searched:
            continue
        # A quick exact test of those faces alone: the full search follows only if some cross.
        start, stop = np.searchsorted(of, (i, i + 1))
        t, is_met, known = contacts.t[start:stop], met[start:stop], before[start:stop]
        faces, others = t[is_met & ~known], t[is_met & known]
        several = len(faces) and len(faces) + len(others) > 1
        if several and len(crossing_pairs(contacts.x, faces, others)):
            more.append((i, i))

    if not more:
        return contacts
    pairs = [*contacts.options["pairs"], *more]
    return find_contacts(contacts.surfaces, **{**contacts.options, "pairs": pairs})


def _met_before(contacts: Contacts) -> np.ndarray:
    """Faces of which an earlier arrangement has found that no two of one surface cross."""
    if contacts.carried is None:
        return np.zeros(len(contacts.t), dtype=bool)
    old, face = contacts.carried.earlier, contacts.carried.same.face
    known: np.ndarray = mark_met(old.rows, old.surface_of_face, face, len(contacts.t))
    return known
