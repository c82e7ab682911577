"""Draw a map of a horizon: elevation in colour, contours, intersection lines, scale, north."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import length_text, real_numbers
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model import Curves, TriSurface
from geosurf.model.expected import expect, listed
from geosurf.render import furniture, palette
from geosurf.render.clip import Prism
from geosurf.render.compose import figure_path, save_figure
from geosurf.render.map_curves import draw_curves
from geosurf.render.map_frame import (
    colours_of,
    contour_levels,
    draw_colour_bar,
    draw_north,
    map_axes,
    number_contours,
)
from geosurf.render.overlay import PictureOverlay, overlay_of
from geosurf.render.overlay_drawing import draw_on_map
from geosurf.render.picture_style import PictureStyle
from geosurf.render.remedies import draw_remedies
from geosurf.render.thin_surfaces import thinned
from geosurf.render.views import SIZE, check_size
from geosurf.render.virtual_lines import draw_virtual_walls
from geosurf.render.wells import draw_wells_on_map, tops_on_map

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAX_MAP_TRIANGLE = 250_000
N_BAND = 3  # bands of colour per contour interval


def render_map(
    surface: TriSurface,
    curves: Curves | None = None,
    *,
    path: str | os.PathLike[str],
    size: tuple[int, int] = SIZE,
    title: str | None = None,
    outline: np.ndarray | None = None,
    faults: Sequence[str] = (),
    tops: Any = None,
    hatched: TriSurface | None = None,
    remedies: Sequence[GeosurfWarning] = (),
    virtual_walls: Mapping[str, Sequence[np.ndarray]] = MappingProxyType({}),
    overlay: PictureOverlay | None = None,
    style: PictureStyle | None = None,
) -> Path:
    """Draw a map of a horizon: elevation in colour, contours, intersection lines in bold.

    Parameters
    ----------
    surface : TriSurface
    curves : Curves, optional
        Lines on the surface are drawn, with one colour per other surface.
    path : path-like
        A ``.png``, ``.svg`` or ``.pdf`` file; its folder is created.
    size : (int, int)
        Width and height in pixels.
    title : str, optional
        Default: the name of the surface.
    outline : ndarray of float64, shape (n, 2), optional
        Outline of the area that is shown: easting and northing, counter-clockwise [m].
        Default: the whole surface.
    faults : sequence of str
        Names of all faults, for the same colours as in other pictures.
    tops : xarray.Dataset, optional
        Result of `Scene.misfit`: well tops of this horizon are drawn, with name and misfit [m].
    hatched : TriSurface, optional
        The horizon with all its nodes: what `extend_horizon` continued is hatched.
    remedies : sequence of GeosurfWarning
        Places that are marked, such as ``sheet.report.remedies``: there the tear needed help.
    virtual_walls : mapping of str to sequence of ndarray of float64, each (n, 2) or (n, 3)
        Lines of virtual walls on the horizon, by their names [m]: they are dashed.
    overlay : PictureOverlay, optional
        Wells, polygons and data points that are drawn with the model.
    style : PictureStyle, optional
        Theme, font, colours by name, colour map.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the surface is empty or vertical, the curves do not include it, or `tops` is not the
        result of `Scene.misfit`.
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> dip = TriSurface("Top", "horizon", [[0, 0, -9], [900, 0, -50], [0, 900, -80]], [[0, 1, 2]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_map(dip, path=f"{folder}/map.png", size=(400, 250)).name
    'map.png'
    """
    path = figure_path(path)
    shown = plot_map(
        surface, curves, None, size=size, title=title, outline=outline, faults=faults, tops=tops,
        hatched=hatched, remedies=remedies, virtual_walls=virtual_walls, overlay=overlay,
        style=style,
    )  # fmt: skip
    return save_figure(shown, path)


def plot_map(
    surface: TriSurface,
    curves: Curves | None = None,
    ax: Axes | None = None,
    *,
    size: tuple[int, int] = SIZE,
    title: str | None = None,
    outline: np.ndarray | None = None,
    faults: Sequence[str] = (),
    tops: Any = None,
    hatched: TriSurface | None = None,
    remedies: Sequence[GeosurfWarning] = (),
    virtual_walls: Mapping[str, Sequence[np.ndarray]] = MappingProxyType({}),
    overlay: PictureOverlay | None = None,
    style: PictureStyle | None = None,
) -> Figure:
    """Draw the map of `render_map` as a figure of matplotlib, or into axes.

    Parameters
    ----------
    surface, curves, size, title, outline, faults, tops, hatched, remedies, virtual_walls, style
        As for `render_map`. `size` is that of a figure of its own.
    overlay : PictureOverlay, optional
        Wells, polygons and data points.
    ax : matplotlib.axes.Axes, optional
        Where to draw, in world coordinates [m].

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        If the surface is empty, vertical, or has no triangles inside the outline.
    """
    expect(surface, TriSurface, "a map takes a TriSurface", "pass scene.surface(name)")
    title = f"{surface.name}: elevation" if title is None else title
    faults = listed(faults, "faults must be names of faults", "give a list, as scene.fault_names")
    marks = "remedies must be warnings of tears"
    for remedy in listed(remedies, marks, "pass sheet.report.remedies"):
        expect(remedy, GeosurfWarning, marks, "pass sheet.report.remedies")
    overlay = overlay_of(overlay)
    wells = [] if tops is None else tops_on_map(tops, surface.name)
    sheet = furniture.sheet_for(ax, check_size(size), style)

    # no more triangles than the map can show
    light, within = thinned(surface, MAX_MAP_TRIANGLE), None
    if not light.n_triangle:
        raise InputError(
            f"surface {surface.name!r} has no triangles. Pass a surface with triangles."
        )
    if outline is not None:
        # a prism around the outline, high enough for all of the surface
        outline = _corners_of(outline)
        (w, s), (e, n) = np.min(outline, axis=0), np.max(outline, axis=0)
        within = Prism((w, e, s, n, light.bounds[4] - 1.0, light.bounds[5] + 1.0), outline)
        x, t, _ = within.triangles(light.vertices, light.triangles)
        if not len(t):
            raise InputError(
                f"surface {surface.name!r} lies outside the outline of the map. "
                "Leave the outline out, or check its coordinates."
            )
        light = TriSurface(surface.name, surface.role, x, t)
    west, east, south, north, bottom, top = light.bounds
    if not (east > west and north > south):
        raise InputError(
            f"surface {surface.name!r} is vertical, so its map is only a line. "
            "Draw it with render_surfaces(..., view='south') or another view."
        )
    # axes, colours and contours
    axes, metres_per_pixel = map_axes(sheet, (west, east, south, north))
    levels = contour_levels(bottom, top)
    if len(levels) > 1:
        _draw_elevation(sheet, axes, light, levels)
    note = ""
    if hatched is not None:
        expect(
            hatched, TriSurface, "hatched is a TriSurface", "pass the horizon with all its nodes"
        )
    if hatched is not None and _hatch(axes, hatched, outline):
        note = " Hatched: extrapolated, without data."

    # intersection lines, and what stands beside the map
    legend = []
    if curves is not None:
        legend = draw_curves(sheet, axes, light, curves, within, list(faults))
    legend = [*draw_virtual_walls(sheet, axes, virtual_walls, list(faults)), *legend]
    legend += draw_wells_on_map(sheet, axes, wells)
    legend += draw_on_map(sheet, axes, overlay)
    legend = [*draw_remedies(sheet, axes, remedies), *legend]
    furniture.draw_legend(sheet, tuple(legend), 290.0)
    codes = sheet.style.codes(palette.ELEVATION)
    draw_colour_bar(sheet, levels, "Elevation [m]", codes, N_BAND, (260.0, 400.0))
    draw_north(sheet)
    furniture.draw_scale_bar(sheet, metres_per_pixel, "")
    interval = f", contour interval {length_text(levels[1] - levels[0])}" if len(levels) > 1 else ""
    furniture.draw_words(sheet, title, f"Map view{interval}.{note}")
    return sheet.figure


def _hatch(
    axes: Axes,
    surface: TriSurface,
    outline: np.ndarray | None,
) -> bool:
    """Hatch the triangles with an extrapolated vertex; return whether there are some."""
    from matplotlib.patches import Polygon
    from matplotlib.tri import Triangulation

    mark = surface.vertex_data.get("extrapolated")
    if mark is None or not mark.any():
        return False
    x, y = surface.vertices[:, :2].T

    # any vertex without data: a triangle is as certain as its least certain corner
    triangles = surface.triangles[mark[surface.triangles].any(axis=1)]

    # hatches follow the contour of the mark; the area itself has no colour
    drawn = axes.tricontourf(
        Triangulation(x, y, triangles), mark.astype(float), levels=[0.01, 1.5], colors="none",
        hatches=["////"],
    )  # fmt: skip

    # the edge colour is that of the hatching; the contour line itself is not drawn
    drawn.set_edgecolor(palette.INK)
    drawn.set_linewidth(0.0)
    if outline is not None:
        drawn.set_clip_path(Polygon(np.asarray(outline), transform=axes.transData))
    return True


def _corners_of(outline: Any) -> np.ndarray:
    """Return the corners (n, 2) of the area that is shown, or raise an InputError."""
    how = "give easting and northing [m] of three corners or more, shape (n, 2)"
    try:
        corners = real_numbers(outline)
    except (TypeError, ValueError) as error:
        raise InputError(f"the outline of a map is {outline!r}; {how}.") from error
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise InputError(f"the outline of a map has shape {corners.shape}; {how}.")
    if not np.isfinite(corners).all():
        raise InputError(f"the outline of a map has values that are not finite; {how}.")
    return corners


def _draw_elevation(
    sheet: furniture.Sheet, axes: Axes, surface: TriSurface, levels: np.ndarray
) -> None:
    """Bands of colour with contour lines; every fifth line is bold."""
    from matplotlib.tri import Triangulation

    x, y, z = surface.vertices.T
    mesh = Triangulation(x, y, surface.triangles)
    bands = np.linspace(levels[0], levels[-1], (len(levels) - 1) * N_BAND + 1)
    colours = colours_of(sheet.style.codes(palette.ELEVATION))
    axes.tricontourf(mesh, z, levels=bands, cmap=colours, antialiased=False)

    # every fifth contour is bold and has a number
    step = levels[1] - levels[0]
    bold = np.round(levels / step).astype(np.int64) % 5 == 0
    unit = sheet.layout.unit
    for chosen, width in ((levels[~bold], 0.35), (levels[bold], 0.9)):
        if len(chosen):
            lines = axes.tricontour(
                mesh, z, levels=chosen, alpha=0.75,
                colors=[palette.INK], linewidths=width * unit, linestyles="solid",
            )  # fmt: skip
            if width > 0.5:
                number_contours(sheet, axes, lines)
