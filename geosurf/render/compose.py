"""Compose a picture: layers, axes, legend, caption, file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.errors import OutputError
from geosurf.files.atomic import write_whole
from geosurf.model.expected import path_of
from geosurf.render import furniture
from geosurf.render.axes import draw_axes
from geosurf.render.layers import Content, show_box
from geosurf.render.views import aim, bounds_of, check_exaggeration, check_size

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.figure import Figure

VECTOR = (".png", ".svg", ".pdf")


def draw_picture(
    content: Content,
    path: str | os.PathLike[str],
    *,
    title: str,
    note: str = "",
    view: str,
    size: tuple[int, int],
    exaggeration: float | None,
    box: tuple[float, ...] | None = None,
    axes: bool = True,
    relief_of: tuple[float, ...] | None = None,
) -> Path:
    """Draw content with its axes, legend and caption, and write the PNG.

    Parameters
    ----------
    content : Content
    path : path-like
        A ``.png`` file; its folder is created.
    title, note : str
        Text above the picture, and the start of its caption.
    view : str
    size : (int, int)
    exaggeration : float or None
    box : (west, east, south, north, bottom, top), optional
        Box with the axes [m]; default: the bounds of the content.
    axes : bool
        Whether to draw axes; an exploded view has none.
    relief_of : (west, east, south, north, bottom, top), optional
        Box [m] for the default exaggeration; default: everything that is visible.

    Returns
    -------
    Path
    """
    path = png_path(path)
    layout = furniture.lay_out(check_size(size))
    extent = bounds_of([layer.points for layer in content.layers])
    box = extent if box is None else box
    # the view contains both the box and the content outside of it
    seen = tuple(
        (min if i % 2 == 0 else max)(a, b) for i, (a, b) in enumerate(zip(extent, box, strict=True))
    )

    # the exaggeration suits the model, also where only a part of it is shown
    stretch = check_exaggeration(exaggeration, relief_of or seen)
    camera = aim(view, seen, layout.view_size, stretch)

    from geosurf.render._plot import draw_layers

    # VTK draws the geometry; matplotlib draws all text and lines around it
    frame = show_box(box, camera.towards) if axes else Content()
    image = draw_layers((content + frame).layers, camera)
    sheet = furniture.Sheet(layout)
    sheet.paste(image)
    if axes:
        draw_axes(sheet, camera, box)
    furniture.draw_legend(sheet, content.legend, layout.height / layout.unit - 84 - 250)
    furniture.draw_compass(sheet, camera)
    furniture.draw_scale_bar(sheet, camera.metres_per_pixel)
    furniture.draw_words(sheet, title, caption(view, stretch, note))
    return save_png(sheet.png(), path)


def caption(view: str, exaggeration: float, note: str = "") -> str:
    """Return the caption of a picture.

    Examples
    --------
    >>> caption("southwest", 3.0)
    'Seen from the southwest, vertical exaggeration 3×.'
    >>> caption("top", 3.0)
    'Seen from above.'
    """
    words = "Seen from above" if view == "top" else f"Seen from the {view}"
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
