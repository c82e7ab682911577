"""Draw a scene, surfaces or units in three dimensions."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from geosurf.conventions import is_number, is_word, number_text, real_numbers
from geosurf.errors import InputError
from geosurf.model import Curves, TriSurface, VoxelSearch
from geosurf.model.expected import expect, listed
from geosurf.render import palette
from geosurf.render.clip import Prism
from geosurf.render.compose import check_look, draw_picture
from geosurf.render.layers import (
    BOX_EDGES,
    Content,
    Entry,
    Layer,
    show_box,
    triangle_layer,
)
from geosurf.render.picture_style import PictureStyle, style_of
from geosurf.render.surface_layers import show_curves, show_surfaces
from geosurf.render.views import SIZE, View, view_vectors

# ---- place ----------------------------------------
# Draw a close-up of a place: the surfaces around it, clipped to a small box, and a marker.


REACH = 1 / 12  # of the larger side of all surfaces
FLATTEST = 0.25  # height of the box over its width, where surfaces are flat


def render_place(
    surfaces: Iterable[TriSurface],
    place: Sequence[float],
    path: str | os.PathLike[str],
    *,
    reach: float | None = None,
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    title: str = "Close-up",
) -> Path:
    """Draw a close-up of one place: the surfaces around it, and a marker.

    Errors of the geometry have a place: `GeometryError.place`.

    Parameters
    ----------
    surfaces : iterable of TriSurface
    place : (easting, northing, elevation)
        World coordinates [m].
    path : path-like
        A ``.png`` file; its folder is created.
    reach : float, optional
        Half the width of the close-up [m]; default: a twelfth of the extent of all surfaces.
    view, size, exaggeration
        As in `ScenePlots.view`.
    title : str

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If `place` is not a point or `reach` is not positive.
    OutputError, DependencyError
        As `ScenePlots.view`.

    Examples
    --------
    >>> import tempfile
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_place([ramp], (300, 300, 166), f"{folder}/place.png", size=(400, 250)).name
    'place.png'
    """
    view_vectors(view)
    content, box = show_place(surfaces, place, reach)
    written: Path = draw_picture(
        content, path, title=title, view=view, size=size, exaggeration=exaggeration, box=box
    )
    return written


def show_place(
    surfaces: Iterable[TriSurface], place: Sequence[float], reach: float | None
) -> tuple[Content, tuple[float, ...]]:
    """
    Return the surfaces around a place, and the box they are clipped to.

    Parameters
    ----------
    surfaces : iterable of TriSurface
        Surfaces outside the close-up are left out.
    place : (easting, northing, elevation)
        World coordinates [m].
    reach : float or None
        Half the width of the close-up [m]; default: a twelfth of the extent of all surfaces.

    Returns
    -------
    content : Content
    box : (west, east, south, north, bottom, top)
        [m]

    Raises
    ------
    InputError
        If `place` is not a point or `reach` is not positive.
    """
    x, y, z = _checked(place, reach)
    how = "pass a list of TriSurface, as in scene.surfaces"
    given = listed(surfaces, "render_place takes surfaces", how)
    for surface in given:
        expect(surface, TriSurface, "render_place takes surfaces", how)
    surfaces = [surface for surface in given if surface.n_triangle]
    if reach is None:
        # a twelfth of the largest extent of all surfaces
        bounds = np.array([surface.bounds for surface in surfaces] or [(x, x, y, y, z, z)])
        sides = bounds[:, 1:4:2].max(axis=0) - bounds[:, 0:4:2].min(axis=0)
        reach = max(float(sides.max()) * REACH, 1.0)

    # only what lies in the cube around the place, clipped to it
    low = np.array([x - reach, y - reach, z - reach])
    high = np.array([x + reach, y + reach, z + reach])
    cube, near = Prism(np.column_stack([low, high]).ravel()), []
    for surface in surfaces:
        vertices, triangles, _ = cube.triangles(surface.vertices, surface.triangles)
        if len(triangles):
            near.append(TriSurface(surface.name, surface.role, vertices, triangles))
    if near:
        # the box shrinks to the surfaces, but a flat place keeps some height
        bottom = min(min(cut.bounds[4] for cut in near), z - FLATTEST * reach)
        top = max(max(cut.bounds[5] for cut in near), z + FLATTEST * reach)
        low[2], high[2] = bottom, top

    # three lines and a legend entry show the place itself
    mark = _mark(np.array([x, y, z]), low, high)
    label = f"E {number_text(x)} N {number_text(y)}, {number_text(z)} m".replace(
        "-", "\N{MINUS SIGN}"
    )
    content = show_surfaces(near) + Content(
        (mark,), (Entry("Location", palette.ACCENT, label, "line"),)
    )
    (w, s, b), (e, n, t) = low.tolist(), high.tolist()
    return content, (w, e, s, n, b, t)


def _checked(place: Sequence[float], reach: float | None) -> tuple[float, float, float]:
    try:
        values = real_numbers(place)
    except (TypeError, ValueError):
        values = np.empty(0)

    # text, wrong lengths and NaN are refused alike, before anything is drawn
    if values.shape != (3,) or not np.isfinite(values).all():
        raise InputError(
            f"place is {place!r}, expected three finite numbers: easting, northing, elevation [m]."
        )
    if reach is not None and not (is_number(reach) and reach > 0):
        raise InputError(
            f"reach is {reach!r}, expected a length above 0 m. Leave it out for the default."
        )
    x, y, z = values.tolist()
    return x, y, z


def _mark(place: np.ndarray, low: np.ndarray, high: np.ndarray) -> Layer:
    """Three lines through a place, each a third of the length of the box."""
    # arms along the three axes, rows 0 to 2 their lower ends, rows 3 to 5 the upper ones
    arm = np.diag((high - low) / 6.0)
    points = np.concatenate([place - arm, place + arm])
    lines = np.array([[0, 3], [1, 4], [2, 5]])
    return Layer(points, lines=lines, colour=palette.ACCENT, width=4.0)


# ---- search ----------------------------------------
# Draw how the voxel search finds an intersection line: common box, voxels, candidate triangles.


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
        As `ScenePlots.view`.
    """
    content = show_search(surface_a, surface_b, search)
    if curves is not None:
        content += show_curves(curves, palette.ACCENT, 3.6, {surface_a.name, surface_b.name})
    written: Path = draw_picture(
        content, path, title=title, view=view, size=size, exaggeration=exaggeration, style=style
    )
    return written


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


def render_surfaces(
    surfaces: Iterable[TriSurface],
    curves: Curves | None = None,
    *,
    path: str | os.PathLike[str],
    view: View = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    zoom: float = 1.0,
    colour_by: str = "surface",
    title: str = "Surfaces",
    style: PictureStyle | None = None,
) -> Path:
    """Draw surfaces and, optionally, their intersection lines.

    Parameters
    ----------
    surfaces : iterable of TriSurface
        Horizons from the youngest to the oldest; they take the colours of the column in this order.
    curves : Curves, optional
    path : path-like
        A ``.png`` file; its folder is created.
    view, size, exaggeration, zoom, style
        As in `ScenePlots.view`.
    colour_by : {"surface", "z"}
        Horizons in colours of their own, or by elevation with a colour bar.
    title : str

    Returns
    -------
    Path

    Raises
    ------
    InputError, OutputError, DependencyError
        As `ScenePlots.view`.

    Examples
    --------
    >>> import tempfile
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_surfaces([ramp], path=f"{folder}/ramp.png", size=(400, 250)).name
    'ramp.png'
    """
    check_look(view, size, zoom, title, path)
    style = style_of(style)
    if not is_word(colour_by, ("surface", "z")):
        raise InputError(f"colour_by is {colour_by!r}, expected 'surface' or 'z'.")
    content = show_surfaces(
        surfaces, by_elevation=colour_by == "z", style=style, size=size, zoom=zoom
    )
    if curves is not None:
        content += show_curves(curves)
    written: Path = draw_picture(
        content, path, title=title, view=view, size=size, exaggeration=exaggeration, zoom=zoom,
        style=style,
    )  # fmt: skip
    return written
