"""Compose a picture: layers, axes, legend, caption, file."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions.memory import give_back_memory
from geosurf.conventions.packages import need_views
from geosurf.errors import OutputError
from geosurf.files.atomic import write_whole
from geosurf.model.expected import expect, path_of
from geosurf.render import furniture
from geosurf.render.axes import draw_axes
from geosurf.render.layers import Bar, Content, show_box
from geosurf.render.map_frame import draw_colour_bar
from geosurf.render.overlay_drawing import draw_names
from geosurf.render.picture_style import PictureStyle, background, style_of
from geosurf.render.views import (
    SIZE,
    View,
    aim,
    angles_of,
    bounds_of,
    check_exaggeration,
    check_size,
    check_zoom,
    words_of,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
    target = None if path is None else figure_path(path)
    sheet = furniture.sheet_for(ax, check_size(size), style)
    draw(sheet, *shown, **words)
    return sheet.figure if target is None else save_figure(sheet.figure, target)


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
    layout = furniture.lay_out(check_size(size))
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

    from geosurf.render._plot import draw_layers

    # VTK draws the geometry; matplotlib draws all text and lines around it
    frame = show_box(box, camera.towards) if axes else Content()
    layers = (content + frame).layers
    give_back_memory()  # of making the layers; afterwards, of the driver
    image = draw_layers(layers, camera, background(style), style.transparent)
    give_back_memory()
    sheet = furniture.Sheet(layout, style)
    sheet.paste(image)
    if axes:
        draw_axes(sheet, camera, box)
    draw_names(sheet, camera, content.names)
    room = layout.height / layout.unit - 84 - 250
    if content.bar is not None:
        room = 280.0
        _draw_bar(sheet, content.bar)
    furniture.draw_legend(sheet, content.legend, room)
    furniture.draw_compass(sheet, camera)
    furniture.draw_scale_bar(sheet, camera.metres_per_pixel)
    furniture.draw_words(sheet, title, caption(view, stretch, note))
    return sheet.figure if target is None else save_png(sheet.png(), target)


def _draw_bar(sheet: furniture.Sheet, bar: Bar) -> None:
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
    """Write a map or diagram as PNG, SVG or PDF, as `save_png` does.

    Raises
    ------
    OutputError
        If the name has another ending, or the folder or file cannot be written.
    """
    target = figure_path(path)
    data = furniture.figure_bytes(figure, target.suffix.lower().lstrip("."))
    return _save(data, target)


def save_png(data: bytes, path: str | os.PathLike[str]) -> Path:
    """Write a picture atomically: readers see the old file or the new one, never a part.

    Raises
    ------
    OutputError
        If the name does not end in .png, or the folder or file cannot be written.
    """
    return _save(data, png_path(path))


def _save(data: bytes, target: Path) -> Path:
    """Write the file, whole or not at all."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_whole(target, data)
    except OSError as error:
        raise OutputError(
            f"{target}: the picture cannot be written ({error.strerror}). "
            "Choose a folder that you can write to."
        ) from error
    return target
