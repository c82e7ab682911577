"""Surfaces -> patches that share one vertex per point along all curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.contact.arrange import Children
from geosurf.contact.search import Contacts, find_contacts, welded_triangles
from geosurf.kernels.contact import COPLANAR, N_CORNER
from geosurf.kernels.mesh import curve_edges, edges, patches_of, weld
from geosurf.model import Patches, TriSurface, frozen
from geosurf.rebuild.repair import cut_soundly

__all__ = ["patches_from", "rebuild_surfaces"]


def rebuild_surfaces(
    surfaces: Sequence[TriSurface],
    *,
    method: str = "auto",
    voxel_size: float | None = None,
    self_intersections: bool = False,
) -> Patches:
    """
    Split surfaces along their common curves, into one welded mesh.

    Only the triangles that a curve touches are triangulated anew, with the curve as
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
        that crosses itself is split there only with `self_intersections`. Inputs that are
        degenerate up to rounding are moved to a coarser step where they break;
        ``report["largest_move"]`` says how far [m], 0 mostly, and `Patches.sources` are the
        surfaces as used.

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
    contacts, children, moves = cut_soundly(contacts)
    x, triangles, surface, parent = _joined(contacts, children)
    twin, owners = _twins(contacts, triangles, surface, parent)
    ring, n_edge = edges(triangles, len(x))
    patch, _ = patches_of(triangles, surface, owners, ring, twin)
    rim = curve_edges(triangles, owners, ring, twin, n_edge)
    report = {
        "cut_triangles": len(children.cut),
        "children": len(children.triangles),
        "constructed_points": len(children.d),
        "rounding_collisions": children.collisions,
        **moves,
    }
    return Patches(
        sources=contacts.surfaces,
        local=frozen(x, np.float64),
        origin=frozen(contacts.origin, np.float64),
        triangles=frozen(triangles, np.int64),
        surface_of_triangle=frozen(surface, np.int64),
        parent_of_triangle=frozen(parent, np.int64),
        patch_of_triangle=frozen(patch, np.int64),
        curve_edges=frozen(rim[np.lexsort(rim.T[::-1])], np.int64),
        report=report,
    )


def _joined(contacts: Contacts, children: Children):
    """All surfaces in one vertex numbering: (x, triangles, surface, parent)."""
    x, faces, surface, parent = [children.x], [], [], []
    n = len(children.x)
    surface_of_child = contacts.surface_of_face[children.parent]
    for i, source in enumerate(contacts.surfaces):
        ids = contacts.id_of_vertex[i].copy()
        new = np.flatnonzero(ids < 0)
        ids[new] = np.arange(n, n + len(new))
        n += len(new)
        x.append(source.vertices[new] - contacts.origin)
        kept = np.ones(source.n_triangle, dtype=bool)
        cut = children.cut[contacts.surface_of_face[children.cut] == i]
        kept[contacts.row_of_face[cut]] = False
        rows = np.flatnonzero(kept)
        mine = surface_of_child == i
        of = np.concatenate([rows, contacts.row_of_face[children.parent[mine]]])
        t = np.concatenate([ids[welded_triangles(source)[rows]], children.triangles[mine]])
        order = np.argsort(of, kind="stable")
        faces.append(t[order])
        parent.append(of[order])
        surface.append(np.full(len(of), i))
    x, triangles = np.concatenate(x), np.concatenate(faces)
    surface, parent = np.concatenate(surface), np.concatenate(parent)
    if children.collisions:  # distinct points in one place become one vertex
        number, count = weld(x)
        welded = np.empty((count, 3))
        welded[number[::-1]] = x[::-1]
        x, triangles = welded, number[triangles]
    mark = np.zeros(len(x), dtype=bool)
    mark[triangles] = True
    renumber = np.cumsum(mark) - 1
    return x[mark], renumber[triangles], surface, parent


def _twins(contacts: Contacts, triangles, surface, parent) -> tuple[np.ndarray, np.ndarray]:
    """Where surfaces coincide: first triangle with the same corners, and a number for the set
    of surfaces that own it (a surface's own row where there is only one).
    """
    twin, owners = np.arange(len(triangles)), surface.copy()
    rows = contacts.rows
    area = rows[(rows[:, COPLANAR] == 1) & (rows[:, N_CORNER] >= 3), :2]
    if len(area) == 0:
        return twin, owners
    faces = np.unique(area)
    candidates = []
    for i in np.unique(contacts.surface_of_face[faces]):
        mine = faces[contacts.surface_of_face[faces] == i]
        marked = np.zeros(contacts.surfaces[i].n_triangle, dtype=bool)
        marked[contacts.row_of_face[mine]] = True
        of = np.flatnonzero(surface == i)
        candidates.append(of[marked[parent[of]]])
    candidates = np.sort(np.concatenate(candidates))
    corners = np.sort(triangles[candidates], axis=1)
    _, first, inverse = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    inverse = inverse.ravel()
    twin[candidates] = candidates[first[inverse]]
    n_surface = len(contacts.surfaces)
    listed = np.zeros((len(first), n_surface), dtype=bool)
    listed[inverse, surface[candidates]] = True
    several = np.flatnonzero(listed.sum(axis=1) > 1)
    _, number = np.unique(listed[several], axis=0, return_inverse=True)
    of_set = np.full(len(first), -1, dtype=np.int64)
    of_set[several] = n_surface + number.ravel()
    shared = of_set[inverse] >= 0
    owners[candidates[shared]] = of_set[inverse[shared]]
    return twin, owners
