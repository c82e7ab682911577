"""Compose a picture: layers, axes, legend, caption, file."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import counted, is_number, number_text, palette, real_numbers
from geosurf.conventions.machine import give_back_memory, need_views
from geosurf.errors import InputError, OutputError
from geosurf.files import write_into_folder
from geosurf.model import Curves, TriSurface, VoxelSearch
from geosurf.model.expected import expect, listed, path_of
from geosurf.render.backend import draw_layers
from geosurf.render.clip import Prism
from geosurf.render.furniture import (
    draw_axes,
    draw_colour_bar,
    draw_compass,
    draw_legend,
    draw_scale_bar,
    draw_words,
)
from geosurf.render.layers import BOX_EDGES, Bar, Content, Entry, Layer, show_box, triangle_layer
from geosurf.render.overlay import DOT, POINTS, draw_names
from geosurf.render.picture_style import PictureStyle, background, style_of
from geosurf.render.sheet import Sheet, figure_bytes, lay_out, sheet_for
from geosurf.render.surface_layers import show_curves, show_surfaces
from geosurf.render.views import (
    SIZE,
    View,
    aim,
    angles_of,
    bounds_of,
    check_exaggeration,
    check_size,
    check_zoom,
    view_vectors,
    words_of,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# ---- models ----------------------------------------
# Draw a scene, surfaces or units in three dimensions.


# ---- place ----------------------------------------
# Draw a close-up of a place: the surfaces around it, clipped to a small box, and a marker.


REACH = 1 / 12  # of the larger side of all surfaces
FLATTEST = 0.25  # height of the box over its width, where surfaces are flat
DATA_INKS = (palette.INK, POINTS[0])  # of data by name


def render_place(
    surfaces: Iterable[TriSurface],
    place: Sequence[float],
    path: str | os.PathLike[str],
    *,
    reach: float | None = None,
    rim: np.ndarray | None = None,
    points: Mapping[str, np.ndarray] | None = None,
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    title: str = "Close-up",
) -> Path:
    """Draw a close-up of one place: the surfaces around it, and a marker.

    Errors of the geometry have a place: `GeometryError.place`, and some what to draw there:
    `GeometryError.close_up`.

    Parameters
    ----------
    surfaces : iterable of TriSurface
    place : (easting, northing, elevation)
        World coordinates [m].
    path : path-like
        A ``.png`` file; its folder is created.
    reach : float, optional
        Half the width of the close-up [m]; default: a twelfth of the extent of all surfaces.
    rim : array_like of float, shape (n, 2, 3), optional
        Edges of a hole [m], drawn instead of the marker.
    points : mapping of str to array_like of float, shape (m, 3), optional
        Data by name [m].
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
    content, box = show_place(surfaces, place, reach, rim, points)
    made: Path = draw_picture(
        content, path, title=title, view=view, size=size, exaggeration=exaggeration, box=box
    )
    return made


def show_place(
    surfaces: Iterable[TriSurface],
    place: Sequence[float],
    reach: float | None,
    rim: np.ndarray | None = None,
    points: Mapping[str, np.ndarray] | None = None,
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
    rim, points
        As in `render_place`.

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

    # the hole, or three lines, and a legend entry show the place itself
    mark = _mark(np.array([x, y, z]), low, high) if rim is None or not len(rim) else _edges(rim)
    label = f"E {number_text(x)} N {number_text(y)}, {number_text(z)} m".replace(
        "-", "\N{MINUS SIGN}"
    )
    name = "Location" if rim is None or not len(rim) else "Hole"
    content = show_surfaces(near) + Content((mark,), (Entry(name, palette.ACCENT, label, "line"),))
    for ink, (name, every) in zip(DATA_INKS, (points or {}).items(), strict=False):
        data = np.asarray(every, dtype=np.float64).reshape(-1, 3)
        data = data[((data >= low) & (data <= high)).all(axis=1)]
        if len(data):
            entry = Entry(name, ink, counted(len(data), "point"), "circle")
            content += Content((Layer(data, colour=ink, width=DOT, dots=True),), (entry,))
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


def _edges(rim: np.ndarray) -> Layer:
    """Edges (n, 2, 3) as lines."""
    points = np.asarray(rim, dtype=np.float64).reshape(-1, 3)
    lines = np.arange(len(points)).reshape(-1, 2)
    return Layer(points, lines=lines, colour=palette.ACCENT, width=6.0)


# ---- search ----------------------------------------
# Draw how the voxel search finds an intersection line: common box, voxels, candidate triangles.


PALE = 0.32
FAULT_OPACITY = 0.7
MAX_VOXEL_SHOWN = 4000


def show_search(
    first: TriSurface, second: TriSurface, search: VoxelSearch, curves: Curves
) -> Content:
    """Return how the voxel search finds an intersection line: few triangles remain to be tested.

    Both surfaces are semi-transparent, their candidate triangles solid, and the lines red.

    Parameters
    ----------
    first, second : TriSurface
        Surfaces of the search.
    search : VoxelSearch
    curves : Curves
    """
    content = Content()
    pairs = ((first, search.faces_a, 0), (second, search.faces_b, 2))
    for surface, faces, place in pairs:
        colour = palette.stratum(place) if surface.role != "fault" else palette.fault(0)
        content += _glass_and_candidates(surface, faces, colour)
    content += _show_voxels(search)
    return content + show_curves(curves, palette.ACCENT, 3.6, {first.name, second.name})


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


N_BAND = 4  # of a colour bar, between two of its values
VECTOR = (".png", ".svg", ".pdf")


def plotted(
    draw: Callable[..., None],
    *shown: Any,
    ax: Axes | None = None,
    path: str | os.PathLike[str] | None = None,
    size: tuple[int, int] = SIZE,
    style: PictureStyle | None = None,
    **words: Any,
) -> Any:
    """
    Draw a map or a diagram into a new figure, or into axes; write it, if there is a path.

    Parameters
    ----------
    draw : callable
        Such as `draw_map`: takes a sheet, `shown` and `words`.
    *shown
        What is drawn.
    ax : matplotlib.axes.Axes, optional
        Where to draw [m]. Default: a new figure.
    path : path-like, optional
        A ``.png``, ``.svg`` or ``.pdf`` file; its folder is created.
    size : (int, int)
        Of a new figure [pixels].
    style : PictureStyle, optional
        Theme, font, colours by name, colour map. The theme is for a new figure.
    **words
        Options of `draw`.

    Returns
    -------
    matplotlib.figure.Figure or pathlib.Path
        The path of the file, if there is one.

    Raises
    ------
    OutputError
        If the file cannot be written, or is of another kind.
    """
    sheet = sheet_for(ax, size, style)
    draw(sheet, *shown, **words)
    return sheet.figure if path is None else save_figure(sheet.figure, path)


def draw_picture(
    content: Content,
    path: str | os.PathLike[str] | None,
    *,
    title: str,
    note: str = "",
    view: View,
    size: tuple[int, int],
    exaggeration: float | None,
    zoom: float = 1.0,
    style: PictureStyle | None = None,
    box: tuple[float, ...] | None = None,
    axes: bool = True,
    relief_of: tuple[float, ...] | None = None,
) -> Any:
    """Draw content with its axes, legend and caption; write the PNG, if there is a path.

    Parameters
    ----------
    content : Content
    path : path-like or None
        A ``.png`` file; its folder is created. None: the figure is returned.
    title, note : str
        Text above the picture, and the start of its caption.
    view : str or (float, float)
    size : (int, int)
    exaggeration : float or None
    zoom : float
        2 shows the middle at twice the scale.
    style : PictureStyle, optional
    box : (west, east, south, north, bottom, top), optional
        Box with the axes [m]; default: the bounds of the content.
    axes : bool
        Whether to draw axes; an exploded view has none.
    relief_of : (west, east, south, north, bottom, top), optional
        Box [m] for the default exaggeration; default: everything that is visible.

    Returns
    -------
    Path or matplotlib.figure.Figure
    """
    need_views()
    target = None if path is None else png_path(path)
    layout = lay_out(check_size(size))
    extent = bounds_of([layer.points for layer in content.layers])
    box = extent if box is None else box
    # the view contains both the box and the content outside of it
    seen = tuple(
        (min if i % 2 == 0 else max)(a, b) for i, (a, b) in enumerate(zip(extent, box, strict=True))
    )

    # the exaggeration suits the model, also where only a part of it is shown
    stretch = check_exaggeration(exaggeration, relief_of or seen)
    camera = aim(view, seen, layout.view_size, stretch, check_zoom(zoom))
    style = style_of(style)

    # VTK draws the geometry; matplotlib draws all text and lines around it
    frame = show_box(box, camera.towards) if axes else Content()
    layers = (content + frame).layers
    give_back_memory()  # of making the layers; afterwards, of the driver
    image = draw_layers(layers, camera, background(style), style.transparent)
    give_back_memory()
    sheet = Sheet(layout, style)
    sheet.paste(image)
    if axes:
        draw_axes(sheet, camera, box)
    draw_names(sheet, camera, content.names)
    room = layout.height / layout.unit - 84 - 250
    if content.bar is not None:
        room = 280.0
        _draw_bar(sheet, content.bar)
    draw_legend(sheet, content.legend, room)
    draw_compass(sheet, camera)
    draw_scale_bar(sheet, camera.metres_per_pixel)
    draw_words(sheet, title, caption(view, stretch, note))
    return sheet.figure if target is None else save_figure(sheet.figure, target)


def _draw_bar(sheet: Sheet, bar: Bar) -> None:
    """Draw the colour bar between the legend and the arrows."""
    levels = np.array(bar.levels)
    if len(levels) < 2:
        unit = sheet.layout.unit
        at = (sheet.layout.width - 250.0 * unit, 400.0 * unit)
        sheet.text(at, f"{bar.words}: {bar.levels[0]:.4g}", 13.0)
        return
    draw_colour_bar(sheet, levels, bar.words, bar.codes, N_BAND, (275.0, 400.0))


def check_look(view: Any, size: Any, zoom: Any, title: Any, path: Any) -> None:
    """Refuse what a view in three dimensions cannot have, before anything is computed.

    Raises
    ------
    InputError, OutputError
    DependencyError
        If matplotlib or pyvista is not installed.
    """
    need_views()
    angles_of(view)
    check_size(size)
    check_zoom(zoom)
    if path is not None:
        png_path(path)
    if title is not None:
        expect(title, str, "title must be text", "leave it out for the default title")


def caption(view: View, exaggeration: float, note: str = "") -> str:
    """Return the caption of a picture.

    Examples
    --------
    >>> caption("southwest", 3.0)
    'Seen from the southwest, vertical exaggeration 3×.'
    >>> caption("top", 3.0)
    'Seen from above.'
    """
    words = f"Seen from {words_of(view)}"
    if view != "top":
        stretched = f"vertical exaggeration {exaggeration:g}×"
        words += f", {stretched if exaggeration != 1.0 else 'true to scale'}"
    return f"{note} {words}.".strip()


def png_path(path: Any) -> Path:
    """Return the path of a view in three dimensions, or raise an error before it is drawn.

    Raises
    ------
    InputError
        If it is not a path.
    OutputError
        If the name does not end in .png.
    """
    target = path_of(path, "a picture")
    if target.suffix.lower() != ".png":
        raise OutputError(f"{target}: pictures are PNG files. Use a file name that ends in .png.")
    return target


def figure_path(path: Any) -> Path:
    """Return the path of a map or diagram, or raise an error before anything is drawn.

    Raises
    ------
    InputError
        If it is not a path.
    OutputError
        If the name does not end in .png, .svg or .pdf.
    """
    target = path_of(path, "a picture")
    if target.suffix.lower() not in VECTOR:
        raise OutputError(
            f"{target}: maps and diagrams are PNG, SVG or PDF files. Use a file name that ends in "
            f"{', '.join(VECTOR[:-1])} or {VECTOR[-1]}."
        )
    return target


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a picture as PNG, SVG or PDF: readers see the old file or the new one, never a part.

    Raises
    ------
    OutputError
        If the name has another ending, or the folder or file cannot be written.
    """
    target = figure_path(path)
    data = figure_bytes(figure, target.suffix.lower().lstrip("."))
    return write_into_folder(target, data, "the picture")
