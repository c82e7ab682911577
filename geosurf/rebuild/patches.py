"""Rebuild surfaces as patches that share one vertex per point along all curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.arrangement.arrange import Children
from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.model import Patches, TriSurface
from geosurf.model.pieces import Pieces
from geosurf.rebuild.assemble import assemble
from geosurf.rebuild.repair import cut_soundly
from geosurf.rebuild.torn_lattices import with_torn_lattices


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
