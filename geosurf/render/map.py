"""A horizon in map view: elevation in colour, contour lines, curves, scale, north."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from geosurf.conventions import real_numbers
from geosurf.errors import InputError
from geosurf.model import Curves, TriSurface
from geosurf.model.expected import expect
from geosurf.render import furniture, palette
from geosurf.render.clip import Prism
from geosurf.render.layers import Entry, length_text, thinned

MAX_MAP_TRIANGLE = 250_000
N_CONTOUR = 20  # contour intervals, about
NUMBERED = 120.0  # contours shorter than this get no number [design pixels]
N_BAND = 3  # bands of colour per contour interval


def draw_map(
    surface: TriSurface,
    curves: Curves | None,
    size: tuple[int, int],
    title: str,
    outline: np.ndarray | None = None,
    faults: Sequence[str] = (),
) -> bytes:
    """Return the map of a surface as a PNG file.

    Parameters
    ----------
    surface : TriSurface
    curves : Curves or None
        Those that lie on the surface are drawn.
    size : (int, int)
        Pixels.
    title : str
    outline : ndarray of float64, shape (n, 2), optional
        Around what is shown.
    faults : sequence of str
        Names that have the colours of faults in that order; other lines are dark grey then.

    Returns
    -------
    bytes

    Raises
    ------
    InputError
        If the surface has no triangles inside the outline, or is seen edge-on from above.
    """
    layout = furniture.lay_out(size)
    light, within = thinned(surface, MAX_MAP_TRIANGLE), None
    if not light.n_triangle:
        raise InputError(f"surface {surface.name!r} has no triangles, so there is no map of it.")
    if outline is not None:
        outline = _corners_of(outline)
        (w, s), (e, n) = np.min(outline, axis=0), np.max(outline, axis=0)
        within = Prism((w, e, s, n, light.bounds[4] - 1.0, light.bounds[5] + 1.0), outline)
        x, t, _ = within.triangles(light.vertices, light.triangles)
        if not len(t):
            raise InputError(
                f"surface {surface.name!r} has nothing inside the outline of the map. "
                "Leave the outline out, or check its coordinates."
            )
        light = TriSurface(surface.name, surface.role, x, t)
    west, east, south, north, bottom, top = light.bounds
    if not (east > west and north > south):
        raise InputError(
            f"surface {surface.name!r} is vertical: from above it is a line. "
            "Draw it with render_surfaces and view='south' or another one."
        )
    sheet = furniture.Sheet(layout)
    axes, metres_per_pixel = map_axes(sheet, (west, east, south, north))
    levels = contour_levels(bottom, top)
    if len(levels) > 1:
        _draw_elevation(sheet, axes, light, levels)
    legend = []
    if curves is not None:
        legend = _draw_curves(sheet, axes, light, curves, within, list(faults))
    furniture.draw_legend(sheet, tuple(legend), 290.0)
    draw_colour_bar(sheet, levels, "Elevation [m]", palette.ELEVATION, N_BAND, (260.0, 400.0))
    draw_north(sheet)
    furniture.draw_scale_bar(sheet, metres_per_pixel, "")
    interval = f", contour interval {length_text(levels[1] - levels[0])}" if len(levels) > 1 else ""
    furniture.draw_words(sheet, title, f"Map view{interval}.")
    return sheet.png()


def _corners_of(outline: Any) -> np.ndarray:
    """Corners (n, 2) of what is shown, or an InputError."""
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


def contour_levels(bottom: float, top: float, n: int = N_CONTOUR) -> np.ndarray:
    """Return about `n` round values that enclose a range; one only, where it has no width.

    Examples
    --------
    >>> contour_levels(-2041.0, -1985.0).tolist()[:3]
    [-2045.0, -2040.0, -2035.0]
    """
    if not top > bottom:
        return np.array([bottom])
    step = furniture.nice_step(top - bottom, n)
    return step * np.arange(math.floor(bottom / step), math.ceil(top / step) + 1)


def map_axes(sheet: furniture.Sheet, extent: tuple[float, float, float, float]):
    """Return axes in local metres, as large as the layout allows; and metres per pixel."""
    layout, unit = sheet.layout, sheet.layout.unit
    west, east, south, north = extent
    wide, high = layout.view_size
    metres_per_pixel = max((east - west) / wide, (north - south) / high)
    width, height = (east - west) / metres_per_pixel, (north - south) / metres_per_pixel
    left, bottom = layout.left + (wide - width) / 2.0, layout.bottom + (high - height) / 2.0
    total = (layout.width, layout.height)
    place = (left / total[0], bottom / total[1], width / total[0], height / total[1])
    axes = sheet.figure.add_axes(place)
    axes.set_xlim(0.0, east - west)
    axes.set_ylim(0.0, north - south)
    points = 12.0 * unit * 72.0 / furniture.DPI
    for axis, name, low, span in (
        (axes.xaxis, "Easting [km]", west, east - west),
        (axes.yaxis, "Northing [km]", south, north - south),
    ):
        n_tick = furniture.fitting(sheet, span / metres_per_pixel)
        values = furniture.ticks(low, low + span, n_tick)
        axis.set_ticks(values - low, furniture.tick_texts(values, 1000.0))
        axis.set_label_text(name, fontsize=points * 1.08, color=palette.INK, family=furniture.FONT)
    axes.tick_params(labelsize=points, colors=palette.INK, width=0.8, color=palette.FAINT)
    for label in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        label.set_family(furniture.FONT)
    for spine in axes.spines.values():
        spine.set_color(palette.FRAME)
    return axes, metres_per_pixel


def colours_of(codes: tuple[str, ...]):
    """Return a colour map of matplotlib's through some colours, low to high."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("geosurf", codes)


def _draw_elevation(sheet, axes, surface: TriSurface, levels: np.ndarray) -> None:
    """Bands of colour with contour lines; every fifth line is bold."""
    from matplotlib.tri import Triangulation

    west, _, south, *_ = surface.bounds
    x, y, z = surface.vertices.T
    mesh = Triangulation(x - west, y - south, surface.triangles)
    bands = np.linspace(levels[0], levels[-1], (len(levels) - 1) * N_BAND + 1)
    axes.tricontourf(mesh, z, levels=bands, cmap=colours_of(palette.ELEVATION), antialiased=False)
    step = levels[1] - levels[0]
    bold = np.round(levels / step).astype(np.int64) % 5 == 0
    unit = sheet.layout.unit
    for chosen, width in ((levels[~bold], 0.35), (levels[bold], 0.9)):
        if len(chosen):
            look = {"colors": [palette.INK], "linewidths": width * unit, "linestyles": "solid"}
            lines = axes.tricontour(mesh, z, levels=chosen, alpha=0.75, **look)
            if width > 0.5:
                number_contours(sheet, axes, lines)


def number_contours(sheet: furniture.Sheet, axes, lines) -> None:
    """Write the value of each contour on its longest line, where that is long enough."""
    unit = sheet.layout.unit
    places = []
    for parts in lines.allsegs:
        pixels = [axes.transData.transform(part) for part in parts if len(part) > 1]
        lengths = [np.hypot(*np.diff(part, axis=0).T).cumsum() for part in pixels]
        if lengths and max(length[-1] for length in lengths) > NUMBERED * unit:
            k = max(range(len(lengths)), key=lambda k: lengths[k][-1])
            at = np.searchsorted(lengths[k], 0.4 * lengths[k][-1])
            places.append(tuple(axes.transData.inverted().transform(pixels[k][at])))
    if not places:
        return
    points = 9.5 * unit * 72.0 / furniture.DPI
    look = {"fmt": furniture.plain_number, "inline_spacing": 3, "manual": places}
    for text in axes.clabel(lines, fontsize=points, **look):
        text.set_family(furniture.FONT)


def _draw_curves(
    sheet, axes, surface, curves: Curves, within: Prism | None, faults: list[str]
) -> list[Entry]:
    """Bold lines for the curves on a surface: faults have their colours, beside them all else is
    dark grey. Where no faults are named each surface has a colour.
    """
    from matplotlib.collections import LineCollection

    name = surface.name
    expect(curves, Curves, "curves takes Curves", "scene.curves and intersect_surfaces are some")
    if name not in curves.names:
        raise InputError(
            f"the curves know no surface {name!r}; they are those of {list(curves.names)}."
        )
    west, _, south, *_ = surface.bounds
    row = curves.names.index(name)
    met = (
        curves.names[k] for pair in curves.surfaces_of_curve.tolist() if row in pair for k in pair
    )
    order = faults or list(dict.fromkeys(other for other in met if other != name))
    colours = {
        other: palette.fault(order.index(other)) if other in order else palette.INK
        for other in curves.names
    }
    others: dict[int, float] = {}
    longest: dict[int, tuple] = {}
    width = 2.6 * sheet.layout.unit * 72.0 / furniture.DPI
    for i, pair in enumerate(curves.surfaces_of_curve.tolist()):
        if row not in pair:
            continue
        line = curves.points[curves.curves[i]]
        ends = np.stack([line[:-1], line[1:]], axis=1)
        if within is not None:
            ends = within.segments(line, np.arange(len(line) - 1)[:, None] + np.arange(2))
        if not len(ends):
            continue
        other = pair[0] if pair[1] == row else pair[1]
        length = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
        others[other] = others.get(other, 0.0) + length
        colour = colours[curves.names[other]]
        shown = LineCollection(ends[:, :, :2] - (west, south), colors=[colour], linewidths=width)
        shown.set_capstyle("round")
        axes.add_collection(shown, autolim=False)
        if length > longest.get(other, (0.0,))[0]:
            longest[other] = (length, ends[len(ends) // 3, 0, :2] - (west, south))
    for other, (_, at) in longest.items():
        x, y = axes.transData.transform(at)
        at = axes.transData.inverted().transform((x + 9.0 * sheet.layout.unit, y))
        colour = palette.shade(colours[curves.names[other]], 1, 2)
        look = {"ha": "left", "fontweight": "bold"}
        furniture.halo_text(sheet, axes, at, curves.names[other], 11.5, colour, **look)
    return [
        Entry(f"with {name}", colours[name], length_text(length), "line")
        for name, length in ((curves.names[k], length) for k, length in others.items())
    ]


def draw_colour_bar(
    sheet: furniture.Sheet,
    levels: np.ndarray,
    words: str,
    codes: tuple[str, ...],
    n_band: int,
    ends: tuple[float, float],
    where: str = "everywhere",
) -> None:
    """Draw a value against its colour, on the right; `n_band` bands between two levels.

    `ends` are its lower and upper end, in design pixels. Where there is one level only, `where`
    says for which part of the map that holds.
    """
    layout, unit = sheet.layout, sheet.layout.unit
    left, low, high = layout.width - 250.0 * unit, ends[0] * unit, ends[1] * unit
    if len(levels) < 2:
        sheet.text((left, high), f"{where} {furniture.plain_number(levels[0])} m", 12.5)
        return
    n_band *= len(levels) - 1
    colours = colours_of(codes)
    height = (high - low) / n_band
    for i in range(n_band):
        face = {"facecolor": colours((i + 0.5) / n_band), "linewidth": 0.0}
        sheet.rectangle((left, low + i * height), 22.0 * unit, height * 1.02, **face)
    span = levels[-1] - levels[0]
    values = furniture.ticks(float(levels[0]), float(levels[-1]), 5)
    for value, number in zip(values, furniture.tick_texts(values, 1.0), strict=True):
        y = low + (high - low) * (value - levels[0]) / span
        sheet.line([(left + 22 * unit, y), (left + 28 * unit, y)], 1.0, palette.FAINT)
        sheet.text((left + 34 * unit, y), number, 12.0)
    sheet.text((left, high + 22 * unit), words, 13.0)


def draw_north(sheet: furniture.Sheet) -> None:
    """Draw an arrow to the north, on the lower right."""
    unit = sheet.layout.unit
    foot = np.array([sheet.layout.width - 239.0 * unit, 160.0 * unit])
    tip = foot + np.array([0.0, 62.0 * unit])
    furniture.arrow_head(sheet, foot, tip, 2.2, palette.INK)
    sheet.text(tip + np.array([0.0, 14.0 * unit]), "N", 15.0, ha="center", weight="bold")
