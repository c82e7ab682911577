"""Rebuild surfaces as patches that share one vertex per point along all curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geosurf.arrangement.arrange import Children
from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.model import Patches, TriSurface
from geosurf.model.pieces import Pieces
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild.assemble import assemble
from geosurf.rebuild.equal_vertices import first_of_equals
from geosurf.rebuild.repair import cut_soundly


def rebuild_surfaces(
    surfaces: Sequence[TriSurface],
    *,
    method: str = "auto",
    voxel_size: float | None = None,
    self_intersections: bool = False,
) -> Patches:
    """
    Split surfaces along their common curves, into one welded mesh.

    Only the triangles that a curve touches are triangulated again, with the curve as
    constraint. Surfaces that meet share one vertex for each point, and where they coincide
    over an area they share the triangles. Each triangle remembers the one it came from.

    Parameters
    ----------
    surfaces : sequence of TriSurface
        Any number. Vertices in metres.
    method, voxel_size, self_intersections
        As for `intersect_surfaces`.

    Returns
    -------
    Patches
        `Patches.surface` takes the mesh apart by surface, `Patches.patch` by patch. A surface
        that crosses itself is split there only with `self_intersections`, or if triangles do so
        that meet another surface, which shares their vertices then. Inputs that are
        degenerate up to rounding are moved to a coarser step where they break;
        ``report["largest_move"]`` says how far [m], 0 mostly, and `Patches.sources` are the
        surfaces as used, without slivers that a move shuts.

    Raises
    ------
    SurfaceError
        If a surface is empty or has triangles without area.
    RoundingError
        If the exact result cannot be held in float64: names the place.

    Notes
    -----
    Each cut face gets the constrained Delaunay triangulation of its points and segments, all
    decisions exact on points that are known by what makes them (Attene 2020, Levy 2024).
    Ties are broken by the points themselves, so that faces which overlap agree.

    Examples
    --------
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> patches = rebuild_surfaces([flat, wall])
    >>> patches.n_patch, len(patches.curve_edges), patches.surface("Top").n_triangle
    (3, 1, 3)
    """
    contacts = find_contacts(
        surfaces, method=method, voxel_size=voxel_size, self_intersections=self_intersections
    )
    return patches_from(contacts)


def patches_from(contacts: Contacts) -> Patches:
    """Cut the faces of known contacts and weld everything into patches."""
    contacts, children, moves, (pieces, rim, n_child) = cut_soundly(contacts, _assembled)
    report = {
        "cut_triangles": len(children.cut),
        "children": n_child,
        "constructed_points": len(children.d),
        "rounding_collisions": children.collisions,
        **moves,
    }
    return Patches.of_pieces(pieces, None, report, rim=rim)


def _assembled(contacts: Contacts, children: Children) -> tuple[Pieces, np.ndarray, int]:
    return assemble(with_torn_lattices(contacts), children)


# ---- torn sheets as lattices with gaps: what follows the contacts passes over runs, not triangles
#
# Contacts are found between the triangles of the list that a torn sheet is. From then on it is a
# `TornLattice`, so that only triangles at faults, curves and gaps are listed.


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
