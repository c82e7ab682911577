"""Draw how the voxel search finds an intersection line: common box, voxels, candidate triangles."""

from __future__ import annotations

import itertools
import os
from pathlib import Path

import numpy as np

from geosurf.conventions import number_text
from geosurf.errors import InputError
from geosurf.model import Curves, TriSurface, VoxelSearch
from geosurf.model.expected import expect
from geosurf.render import palette
from geosurf.render.compose import draw_picture
from geosurf.render.layers import BOX_EDGES, Content, Entry, Layer, show_box, triangle_layer
from geosurf.render.picture_style import PictureStyle
from geosurf.render.surface_layers import show_curves
from geosurf.render.views import SIZE

PALE = 0.32
FAULT_OPACITY = 0.7
MAX_VOXEL_SHOWN = 4000


def render_search(
    surface_a: TriSurface,
    surface_b: TriSurface,
    search: VoxelSearch,
    curves: Curves | None,
    path: str | os.PathLike[str],
    *,
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    title: str = "Voxel search for intersection lines",
    style: PictureStyle | None = None,
) -> Path:
    """Draw how the voxel search finds an intersection line: few triangles remain to be tested.

    Parameters
    ----------
    surface_a, surface_b : TriSurface
        Surfaces of the search, drawn semi-transparent; their candidate triangles are solid.
    search : VoxelSearch
    curves : Curves or None
        The intersection lines, drawn in red.
    path : path-like
        A ``.png`` file; its folder is created.
    view, size, exaggeration, title, style
        As in `render_surfaces`.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the search does not belong to these surfaces.
    OutputError, DependencyError
        As `render_scene`.
    """
    content = show_search(surface_a, surface_b, search)
    if curves is not None:
        content += show_curves(curves, palette.ACCENT, 3.6, {surface_a.name, surface_b.name})
    return draw_picture(
        content, path, title=title, view=view, size=size, exaggeration=exaggeration, style=style
    )


def show_search(first: TriSurface, second: TriSurface, search: VoxelSearch) -> Content:
    """Return both surfaces semi-transparent and their candidate triangles in full colour.

    Parameters
    ----------
    first, second : TriSurface
    search : VoxelSearch

    Raises
    ------
    InputError
        If the search refers to triangles that the surfaces do not have.
    """
    expect(search, VoxelSearch, "render_search takes a VoxelSearch", "pass scene.search(a, b)")
    content = Content()
    pairs = ((first, search.faces_a, 0), (second, search.faces_b, 2))
    for surface, faces, place in pairs:
        faces = _checked_faces(surface, faces)
        colour = palette.stratum(place) if surface.role != "fault" else palette.fault(0)
        content += _glass_and_candidates(surface, faces, colour)
    return content + _show_voxels(search)


def _checked_faces(surface: TriSurface, faces: np.ndarray) -> np.ndarray:
    expect(surface, TriSurface, "render_search takes surfaces", "pass those of the search")
    faces = np.asarray(faces, dtype=np.int64)
    bad = faces[(faces < 0) | (faces >= surface.n_triangle)]
    if len(bad):
        raise InputError(
            f"the search refers to triangle {bad[0]} of surface {surface.name!r}, which has only "
            f"{surface.n_triangle} triangles. Pass the surfaces of the search in the same order."
        )
    return faces


def _glass_and_candidates(surface: TriSurface, faces: np.ndarray, colour: palette.RGB) -> Content:
    # all triangles pale; candidates on top, with their edges
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

    # each edge once, however many candidates share it
    sides = np.unique(np.sort(solid[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    rims = Layer(surface.vertices, lines=sides, colour=palette.INK, width=0.5)
    legend = (
        Entry(surface.name, colour, f"{number_text(surface.n_triangle)} triangles", opacity=PALE),
        Entry("Candidate triangles", chosen.colour, f"{number_text(len(faces))} of {surface.name}"),
    )
    layers = (*([glass] if len(others) else []), *([chosen, rims] if len(faces) else []))
    return Content(layers, legend)


def _show_voxels(search: VoxelSearch) -> Content:
    bounds = tuple(float(x) for pair in zip(search.lower, search.upper, strict=True) for x in pair)
    content = show_box(bounds, colour=palette.INK, width=1.4)

    # voxels that hold triangles of both surfaces, of all those in the common box
    n_cell, occupied = int(np.prod(search.n_cell)), len(search.occupied)
    if occupied:
        points, lines = voxel_edges(search)
        content += Content((Layer(points, lines=lines, colour=palette.VOXEL, width=0.8),))
    detail = f"{number_text(occupied)} of {number_text(n_cell)} with both"
    legend = (
        Entry("Common box", palette.INK, "overlap of both bounds", "line"),
        Entry("Voxels", palette.VOXEL, detail, "line"),
    )
    return content + Content(legend=legend)


def voxel_edges(search: VoxelSearch) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) and distinct edges (n_edge, 2) of the occupied voxels.

    Only the first 4000 voxels are drawn: more could not be distinguished.
    """
    # cells (n, 3) -> their eight corners, each once; the twelve edges of each, each once
    cells = np.asarray(search.occupied, dtype=np.int64).reshape(-1, 3)[:MAX_VOXEL_SHOWN]
    corners = np.array(list(itertools.product((0, 1), repeat=3)))
    nodes, number = np.unique(
        (cells[:, None, :] + corners).reshape(-1, 3), axis=0, return_inverse=True
    )

    # number (n, 8): row of each corner of each voxel
    number = number.reshape(-1, 8)
    edges = np.unique(np.sort(number[:, BOX_EDGES].reshape(-1, 2), axis=1), axis=0)
    return np.asarray(search.lower) + nodes * float(search.size), edges
