"""Draw the frame of a map: axes, contour levels and their numbers, colour bar, north arrow."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from geosurf.render import furniture, palette
from geosurf.render.furniture import fitting, nice_step, plain_number, tick_texts, ticks

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.contour import ContourSet

N_CONTOUR = 20  # approximate number of contour intervals
NUMBERED = 120.0  # contours shorter than this get no number [design pixels]


def contour_levels(bottom: float, top: float, n: int = N_CONTOUR) -> np.ndarray:
    """Return about `n` round values that enclose a range, or one value for an empty range.

    Examples
    --------
    >>> contour_levels(-2041.0, -1985.0).tolist()[:3]
    [-2045.0, -2040.0, -2035.0]
    """
    if not top > bottom:
        return np.array([bottom])

    # multiples of a round step, one below and one above the range at least
    step = nice_step(top - bottom, n)
    return step * np.arange(math.floor(bottom / step), math.ceil(top / step) + 1)


def map_axes(
    sheet: furniture.Sheet, extent: tuple[float, float, float, float]
) -> tuple[Axes, float]:
    """Return axes in metres, as large as the layout allows, and the metres per pixel.

    The axes of a user stay where they are; they only get an equal scale in both directions.
    """
    layout, unit = sheet.layout, sheet.layout.unit
    west, east, south, north = extent
    wide, high = sheet.room

    # one scale for both directions: the longer side fills its room, the other is centred
    metres_per_pixel = max((east - west) / wide, (north - south) / high)
    width, height = (east - west) / metres_per_pixel, (north - south) / metres_per_pixel
    left, bottom = layout.left + (wide - width) / 2.0, layout.bottom + (high - height) / 2.0
    total = (layout.width, layout.height)
    place = (left / total[0], bottom / total[1], width / total[0], height / total[1])

    # matplotlib wants the rectangle as fractions of the picture
    axes = sheet.frame(place)
    axes.set_aspect("equal")
    axes.set_xlim(west, east)
    axes.set_ylim(south, north)
    points = 12.0 * unit * 72.0 / furniture.DPI
    for axis, name, low, span in (
        (axes.xaxis, "Easting [km]", west, east - west),
        (axes.yaxis, "Northing [km]", south, north - south),
    ):
        n_tick = fitting(span / metres_per_pixel, unit)
        values = ticks(low, low + span, n_tick)
        axis.set_ticks(values, tick_texts(values, 1000.0))
        axis.set_label_text(name, fontsize=points * 1.08, color=palette.INK, family=furniture.FONT)
    axes.tick_params(labelsize=points, colors=palette.INK, width=0.8, color=palette.FAINT)
    for label in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        label.set_fontfamily(furniture.FONT)
    for spine in axes.spines.values():
        spine.set_color(palette.FRAME)
    return axes, metres_per_pixel


def colours_of(codes: tuple[str, ...]) -> LinearSegmentedColormap:
    """Return a matplotlib colour map through the given colours, low to high."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("geosurf", codes)


def number_contours(sheet: furniture.Sheet, axes: Axes, lines: ContourSet) -> None:
    """Write the value of each contour on its longest line if that is long enough."""
    unit = sheet.layout.unit
    places = []
    for parts in lines.allsegs:
        # lengths along each part in pixels; short contours get no number
        pixels = [axes.transData.transform(part) for part in parts if len(part) > 1]
        lengths = [np.hypot(*np.diff(part, axis=0).T).cumsum() for part in pixels]
        if lengths and max(length[-1] for length in lengths) > NUMBERED * unit:
            # 40 % along the longest part, away from its ends
            k = max(range(len(lengths)), key=lambda k: lengths[k][-1])
            at = np.searchsorted(lengths[k], 0.4 * lengths[k][-1])
            places.append(tuple(axes.transData.inverted().transform(pixels[k][at])))
    if not places:
        return
    points = 9.5 * unit * 72.0 / furniture.DPI
    for text in axes.clabel(
        lines, fontsize=points, fmt=plain_number, inline_spacing=3, manual=places
    ):
        text.set_fontfamily(furniture.FONT)


def draw_colour_bar(
    sheet: furniture.Sheet,
    levels: np.ndarray,
    words: str,
    codes: tuple[str, ...],
    n_band: int,
    ends: tuple[float, float],
    where: str = "everywhere",
) -> None:
    """Draw the colour bar on the right, with `n_band` bands between two levels.

    `ends` are its lower and upper end in design pixels. If there is only one level, `where` names
    the part of the map that has this value.
    """
    if isinstance(sheet, furniture.UserSheet):
        sheet.colour_bar(levels, words, colours_of(codes), n_band)
        return
    layout, unit = sheet.layout, sheet.layout.unit
    left, low, high = layout.width - 250.0 * unit, ends[0] * unit, ends[1] * unit
    if len(levels) < 2:
        sheet.text((left, high), f"{where} {plain_number(levels[0])} m", 12.5)
        return
    n_band *= len(levels) - 1

    # bands overlap by 2 %, so that no white line shows between them
    colours = colours_of(codes)
    height = (high - low) / n_band
    for i in range(n_band):
        face = colours((i + 0.5) / n_band)
        corner = (left, low + i * height)
        sheet.rectangle(corner, 22.0 * unit, height * 1.02, facecolor=face, linewidth=0.0)

    # numbers at round values
    span = levels[-1] - levels[0]
    values = ticks(float(levels[0]), float(levels[-1]), 5)
    for value, number in zip(values, tick_texts(values, 1.0), strict=True):
        y = low + (high - low) * (value - levels[0]) / span
        sheet.line([(left + 22 * unit, y), (left + 28 * unit, y)], 1.0, palette.FAINT)
        sheet.text((left + 34 * unit, y), number, 12.0)
    sheet.text((left, high + 22 * unit), words, 13.0)


def draw_north(sheet: furniture.Sheet) -> None:
    """Draw the north arrow on the lower right."""
    if isinstance(sheet, furniture.UserSheet):
        return
    unit = sheet.layout.unit
    foot = np.array([sheet.layout.width - 239.0 * unit, 160.0 * unit])
    tip = foot + np.array([0.0, 62.0 * unit])
    furniture.arrow_head(sheet, foot, tip, 2.2, palette.INK)
    sheet.text(tip + np.array([0.0, 14.0 * unit]), "N", 15.0, ha="center", weight="bold")
