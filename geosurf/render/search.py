"""The picture that explains the search: global box, voxels, candidate faces, curve."""

from __future__ import annotations

import itertools

import numpy as np

from geosurf.errors import InputError
from geosurf.model import TriSurface, VoxelSearch
from geosurf.model.expected import expect
from geosurf.render import palette
from geosurf.render.layers import BOX_EDGES, Content, Entry, Layer, show_box, triangle_layer

PALE = 0.32
FAULT_OPACITY = 0.7
MAX_VOXEL_SHOWN = 4000


def show_search(first: TriSurface, second: TriSurface, search: VoxelSearch) -> Content:
    """Return both surfaces as glass, and what the voxels leave of them in full colour.

    Parameters
    ----------
    first, second : TriSurface
    search : VoxelSearch

    Raises
    ------
    InputError
        If the search names faces that the surfaces do not have.
    """
    expect(search, VoxelSearch, "render_search takes a VoxelSearch", "Scene.search gives one")
    content = Content()
    pairs = ((first, search.faces_a, 0), (second, search.faces_b, 2))
    for surface, faces, place in pairs:
        faces = _checked_faces(surface, faces)
        colour = palette.stratum(place) if surface.role != "fault" else palette.fault(0)
        content += _glass_and_candidates(surface, faces, colour)
    return content + _show_voxels(search)


def _checked_faces(surface: TriSurface, faces: np.ndarray) -> np.ndarray:
    expect(surface, TriSurface, "render_search takes surfaces", "hand over those of the search")
    faces = np.asarray(faces, dtype=np.int64)
    bad = faces[(faces < 0) | (faces >= surface.n_triangle)]
    if len(bad):
        raise InputError(
            f"the search names face {bad[0]} of surface {surface.name!r}, which has "
            f"{surface.n_triangle} triangles; hand over the surfaces that were searched, in order."
        )
    return faces


def _glass_and_candidates(surface: TriSurface, faces: np.ndarray, colour: palette.RGB) -> Content:
    others = np.delete(surface.triangles, faces, axis=0)
    solid = surface.triangles[faces]
    glass = triangle_layer(surface.vertices, others, colour=colour, opacity=PALE)
    chosen = triangle_layer(
        surface.vertices,
        solid,
        colour=palette.shade(colour, 1, 2),
        opacity=FAULT_OPACITY if surface.role == "fault" else 1.0,
        sharp=True,
    )
    sides = np.unique(np.sort(solid[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    rims = Layer(surface.vertices, lines=sides, colour=palette.INK, width=0.5)
    legend = (
        Entry(surface.name, colour, f"{surface.n_triangle:,} faces", opacity=PALE),
        Entry("candidate faces", chosen.colour, f"{len(faces):,} of {surface.name}"),
    )
    layers = (*([glass] if len(others) else []), *([chosen, rims] if len(faces) else []))
    return Content(layers, legend)


def _show_voxels(search: VoxelSearch) -> Content:
    bounds = tuple(float(x) for pair in zip(search.lower, search.upper, strict=True) for x in pair)
    content = show_box(bounds, colour=palette.INK, width=1.4)
    n_cell, occupied = int(np.prod(search.n_cell)), len(search.occupied)
    if occupied:
        points, lines = voxel_edges(search)
        content += Content((Layer(points, lines=lines, colour=palette.VOXEL, width=0.8),))
    detail = f"{occupied:,} of {n_cell:,} hold both"
    legend = (
        Entry("global box", palette.INK, "where both can be", "line"),
        Entry("voxels", palette.VOXEL, detail, "line"),
    )
    return content + Content(legend=legend)


def voxel_edges(search: VoxelSearch) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) and edges (n_edge, 2) of the occupied voxels, each edge once.

    Voxels beyond the first 4000 are left out: no eye would tell them apart.
    """
    cells = np.asarray(search.occupied, dtype=np.int64).reshape(-1, 3)[:MAX_VOXEL_SHOWN]
    corners = np.array(list(itertools.product((0, 1), repeat=3)))
    nodes, number = np.unique(
        (cells[:, None, :] + corners).reshape(-1, 3), axis=0, return_inverse=True
    )
    number = number.reshape(-1, 8)
    edges = np.unique(np.sort(number[:, BOX_EDGES].reshape(-1, 2), axis=1), axis=0)
    return np.asarray(search.lower) + nodes * float(search.size), edges
