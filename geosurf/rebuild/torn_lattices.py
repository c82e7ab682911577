"""Torn sheets as lattices with gaps: what follows the contacts passes over runs, not triangles.

Contacts are found between the triangles of the list that a torn sheet is. From then on it is a
`TornLattice`, so that only triangles at faults, curves and gaps are listed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geosurf.arrangement.search import Contacts
from geosurf.model import TriSurface
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild.equal_vertices import first_of_equals


def with_torn_lattices(contacts: Contacts) -> Contacts:
    """Return contacts with torn sheets as lattices where they are, and their keys."""
    surfaces = tuple(as_lattice(surface) for surface in contacts.surfaces)
    changed = [k for k, one in enumerate(surfaces) if one is not contacts.surfaces[k]]
    if not changed:
        return contacts

    # faces are sorted by surface; keys rise with rows, so that they stay sorted
    keys, nodes = contacts.key_of_face.copy(), list(contacts.nodes)
    for k in changed:
        lattice = surfaces[k].lattice
        assert isinstance(lattice, TornLattice)
        mine = slice(*np.searchsorted(contacts.surface_of_face, (k, k + 1)))
        keys[mine] = lattice.keys_of_rows(keys[mine])
        vertices, ids = nodes[k]
        nodes[k] = lattice.node_of_vertex[vertices], ids
    return replace(contacts, surfaces=surfaces, key_of_face=keys, nodes=nodes)


def as_lattice(surface: TriSurface) -> TriSurface:
    """The same surface as a torn lattice, if it is one; remembered on it."""
    torn = surface.torn
    # vertices in one place are joined in lists only
    if torn is None or first_of_equals(surface) is not None:
        return surface
    made: TriSurface | None = surface.__dict__.get("_in_lattice")
    # a renamed twin has the same arrays, but not the same name
    if made is None or made.name != surface.name or made.role != surface.role:
        made = surface.renamed(surface.name, surface.role)
        made.__dict__.pop("_in_lattice", None)
        made.lattice = torn
        surface.__dict__["_in_lattice"] = made
    return made
