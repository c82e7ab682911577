"""Draw the frame of a picture: axes, legend, north arrow, scale bar, title and caption.

Pixels are counted from the lower left. In the axes of a user there is no frame: a legend, a colour
bar and a title take its place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import compress
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from geosurf.conventions import length_text, palette
from geosurf.conventions.axes import vertical_label, vertical_sign, vertical_words
from geosurf.model.expected import expect
from geosurf.render import artists
from geosurf.render.artists import AreaStyle, LineStyle, Spot, TextStyle
from geosurf.render.layers import (
    DETAIL_ROOM,
    LABEL_ROOM,
    SYMBOLS,
    Entry,
    shortened,
    shortened_apart,
)
from geosurf.render.picture_style import FONT, LEGEND, apply_theme, readable
from geosurf.render.sheet import STRIPE_WIDTH, STRIPES, Sheet, UserSheet
from geosurf.render.views import Camera, corners

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes


# ---- axes ----------------------------------------
# Draw the axes of the model box: round tick values, numbers and names.


IN_MAP = (("Easting", "km", 1000.0), ("Northing", "km", 1000.0))
END_ON = 0.06  # an axis shorter than this fraction of the picture gets no labels


def draw_axes(sheet: Sheet, camera: Camera, bounds: tuple[float, ...]) -> None:
    """Label the visible edges of the box."""
    offset = np.array([sheet.layout.left, sheet.layout.bottom])
    box = corners(bounds)
    pixels = camera.to_pixels(box) + offset
    middle = pixels.mean(axis=0)

    # middles of numbers written so far: axes meet at corners, where they would overlap
    taken: list[np.ndarray] = []
    for axis, (name, unit, per) in enumerate((*IN_MAP, (*vertical_words(), 1.0))):
        # the edge on the outline of the box, so that numbers stay outside of it
        edge = _outer_edge(pixels, axis, min(camera.size) * END_ON)
        if edge is None:
            continue

        # round values between its ends, as many as fit
        low, high = box[edge[0]], box[edge[1]]
        length = float(np.linalg.norm(pixels[edge[1]] - pixels[edge[0]]))
        texts_fit = fitting(length, sheet.layout.unit)
        values = ticks(low[axis], high[axis], min(texts_fit, 4 if axis == 2 else 5))
        texts = tick_texts(values, per)
        if axis == 2:
            texts = tick_texts(vertical_sign(vertical_label()) * values, per)
        part = (values - low[axis]) / (high[axis] - low[axis])

        # unit vectors in pixels: along the edge, and away from the middle of the box
        ends = pixels[list(edge)]
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        outward = np.array([along[1], -along[0]])
        if outward @ (ends.mean(axis=0) - middle) < 0.0:
            outward = -outward
        places = ends[0] + part[:, None] * (ends[1] - ends[0])

        # a picture at a larger scale shows only a part of the box
        here = _inside(sheet, places)
        _draw_axis(sheet, places[here], list(compress(texts, here)), outward, taken)
        if _inside(sheet, ends.mean(axis=0)[None])[0]:
            _name_axis(sheet, ends.mean(axis=0), f"{name} [{unit}]", along, outward, texts)


def _inside(sheet: Sheet, places: np.ndarray) -> np.ndarray:
    """Whether each pixel (n, 2) is in the rectangle of the view."""
    low = np.array([sheet.layout.left, sheet.layout.bottom])
    high = low + sheet.layout.view_size
    off = np.abs(places - 0.5 * (low + high)) - 0.5 * (high - low)
    made: np.ndarray = off.max(axis=1) <= 0.5
    return made


def _outer_edge(pixels: np.ndarray, axis: int, shortest: float) -> tuple[int, int] | None:
    """The lowest edge for horizontal axes, the leftmost for elevation; None if seen end-on."""
    # corners are numbered in binary: the edges of an axis differ in its bit only
    bit = (4, 2, 1)[axis]
    edges = [(i, i | bit) for i in range(8) if not i & bit]
    length = np.linalg.norm(pixels[edges[0][1]] - pixels[edges[0][0]])
    if length < shortest:
        return None

    # rounded, so that equal edges of a symmetric view are chosen in the same order
    middles = [pixels[list(edge)].mean(axis=0).round(3) for edge in edges]
    keys = [(m[0], m[1]) if axis == 2 else (m[1], m[0]) for m in middles]
    return edges[min(range(4), key=keys.__getitem__)]


def _draw_axis(
    sheet: Sheet, places: np.ndarray, texts: list[str], outward: np.ndarray, taken: list[np.ndarray]
) -> None:
    """Draw ticks and numbers; a number that would overlap one in `taken` is left out."""
    unit = sheet.layout.unit
    x, y = outward
    for place, words in zip(places, texts, strict=True):
        sheet.line([place, place + 6.0 * unit * outward], 1.0, palette.FAINT)
        about = place + 30.0 * unit * outward  # the middle of the number
        if any(np.hypot(*(about - other)) < 28.0 * unit for other in taken):
            continue
        taken.append(about)
        sheet.text(
            place + 11.0 * unit * outward,
            words,
            12.0,
            ha="left" if x > 0.4 else "right" if x < -0.4 else "center",
            va="bottom" if y > 0.8 else "top" if y < -0.4 else "center",
            path_effects=rim_of_words(sheet),
        )


def _name_axis(
    sheet: Sheet,
    at: np.ndarray,
    words: str,
    along: np.ndarray,
    outward: np.ndarray,
    texts: list[str],
) -> None:
    """Write the name along its axis, outside the numbers, never upside down."""
    angle = math.degrees(math.atan2(along[1], along[0]))

    # between -90 and 90 degrees: never upside down
    angle = (angle + 90.0) % 180.0 - 90.0
    # the numbers are as wide as their longest, and one line high
    wide = 7.6 * max(map(len, texts), default=0)
    distance = 25.0 + wide * abs(outward[0]) + 14.0 * abs(outward[1])
    place = at + distance * sheet.layout.unit * outward
    if abs(angle + 90.0) < 1e-6:
        angle = 90.0
    sheet.text(
        place,
        words,
        13.0,
        ha="center",
        va="center",
        path_effects=rim_of_words(sheet),
        rotation=angle,
        rotation_mode="anchor",
    )


# ---- map frame ----------------------------------------
# Draw the frame of a map: axes, contour levels and their numbers, colour bar, north arrow.


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


def map_axes(sheet: Sheet, extent: tuple[float, float, float, float]) -> tuple[Axes, float]:
    """Return axes in metres, as large as the layout allows, and the metres per pixel.

    The axes of a user stay where they are; they only get an equal scale in both directions.
    """
    layout = sheet.layout
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
    rows = [
        (axes.xaxis, "Easting [km]", west, east, 1000.0, (east - west) / metres_per_pixel),
        (axes.yaxis, "Northing [km]", south, north, 1000.0, (north - south) / metres_per_pixel),
    ]
    label_axes(sheet, axes, rows)
    return axes, metres_per_pixel


def label_axes(
    sheet: Sheet, axes: Axes, rows: Sequence[tuple[artists.Axis, str, float, float, float, float]]
) -> None:
    """Give axes round values and names: axis, name, both ends, the unit and the length [pixels]."""
    size = sheet.points(12.0)
    for axis, name, low, high, per, pixels in rows:
        values = ticks(low, high, fitting(pixels, sheet.layout.unit))
        axis.set_ticks(values, tick_texts(vertical_sign(name) * values, per))
        axis.set_label_text(name, fontsize=size * 1.08, color=palette.INK, family=FONT)
    axes.tick_params(labelsize=size, colors=palette.INK, width=0.8, color=palette.FAINT)
    for label in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        label.set_fontfamily(FONT)
    for spine in axes.spines.values():
        spine.set_color(palette.FRAME)


def thin_and_bold(levels: np.ndarray) -> tuple[tuple[np.ndarray, float], ...]:
    """Return contour levels and their widths [design pixels]: every fifth is bold."""
    bold = np.round(levels / (levels[1] - levels[0])).astype(np.int64) % 5 == 0
    return (levels[~bold], 0.35), (levels[bold], 0.9)


def colours_of(codes: tuple[str, ...]) -> artists.LinearSegmentedColormap:
    """Return a matplotlib colour map through the given colours, low to high."""
    return artists.LinearSegmentedColormap.from_list("geosurf", codes)


def number_contours(sheet: Sheet, axes: Axes, lines: artists.ContourSet, label: str) -> None:
    """Write the value of each contour on its longest line if that is long enough."""
    sign = vertical_sign(label)
    numbers = {level: plain_number(sign * level) for level in map(float, lines.levels)}
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
    points = sheet.points(DETAIL_SIZE)
    for text in axes.clabel(lines, fontsize=points, fmt=numbers, inline_spacing=3, manual=places):
        text.set_fontfamily(FONT)


def draw_colour_bar(
    sheet: Sheet,
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
    sign = vertical_sign(words)
    if isinstance(sheet, UserSheet):
        sheet.colour_bar(levels, words, colours_of(codes), n_band, sign)
        return
    layout, unit = sheet.layout, sheet.layout.unit
    left, low, high = layout.width - 250.0 * unit, ends[0] * unit, ends[1] * unit
    if len(levels) < 2:
        what, _, unit_shown = words.rstrip("]").partition(" [")
        value = plain_number(sign * levels[0])
        sheet.text((left, high), f"{what} {where}: {value} {unit_shown}", 12.5)
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
    for value, number in zip(values, tick_texts(sign * values, 1.0), strict=True):
        y = low + (high - low) * (value - levels[0]) / span
        sheet.line([(left + 22 * unit, y), (left + 28 * unit, y)], 1.0, palette.FAINT)
        sheet.text((left + 34 * unit, y), number, 12.0)
    sheet.text((left, high + 22 * unit), words, 13.0)


def frame_map(
    sheet: Sheet,
    legend: Sequence[Entry],
    levels: np.ndarray,
    metres_per_pixel: float,
    title: str,
    note: str,
    **bar: Any,
) -> None:
    """Draw what stands next to a map; `bar` has the other arguments of `draw_colour_bar`."""
    draw_legend(sheet, tuple(legend), 290.0)
    draw_colour_bar(sheet, levels, ends=(260.0, 400.0), **bar)
    draw_north(sheet)
    draw_scale_bar(sheet, metres_per_pixel, "")
    interval = ""
    if len(levels) > 1:
        step, unit = float(levels[1] - levels[0]), vertical_words()[1]
        interval = f", contour interval {length_text(step) if unit == 'm' else f'{step:g} {unit}'}"
    draw_words(sheet, title, f"Map view{interval}.{note}")


def draw_north(sheet: Sheet) -> None:
    """Draw the north arrow on the lower right."""
    if isinstance(sheet, UserSheet):
        return
    unit = sheet.layout.unit
    foot = np.array([sheet.layout.width - 239.0 * unit, 160.0 * unit])
    tip = foot + np.array([0.0, 62.0 * unit])
    arrow_head(sheet, foot, tip, 2.2, palette.INK)
    sheet.text(tip + np.array([0.0, 14.0 * unit]), "N", 15.0, ha="center", weight="bold")


# ---- ticks ----------------------------------------
# Round values for axes, contours and scale bars, and their text.


def nice_step(span: float, n: int = 5) -> float:
    """Return a round step that divides a span into about `n` parts.

    Examples
    --------
    >>> nice_step(4000.0), nice_step(730.0)
    (1000.0, 200.0)
    """
    # 1, 2, 2.5 or 5 times a power of ten: the first that is not clearly too small
    rough = span / n
    power = 10.0 ** math.floor(math.log10(rough))
    return float(next(m * power for m in (1.0, 2.0, 2.5, 5.0, 10.0) if m * power >= rough * 0.99))


def fitting(pixels: float, unit: float) -> int:
    """Return how many numbers fit an axis of some pixels, from 1 to 5; `unit` is the font scale."""
    return int(min(max(pixels / (45.0 * unit), 1.0), 5.0))


def ticks(low: float, high: float, n: int = 5) -> np.ndarray:
    """Return round values between two bounds."""
    step = nice_step(high - low, n)

    # a billionth of a step is rounding: a bound on a round value keeps it
    first = math.ceil(low / step - 1e-9)
    return step * np.arange(first, math.floor(high / step + 1e-9) + 1)


def tick_texts(values: np.ndarray, per: float) -> list[str]:
    """Return values over a unit, with as many decimals as their step needs."""
    step = abs(float(values[1] - values[0])) / per if len(values) > 1 else 1.0

    # the fewest decimals that show the step exactly
    decimals = next((d for d in range(6) if abs(round(step, d) - step) < 1e-9 * step), 6)
    texts = [f"{value / per:.{decimals}f}" for value in values + 0.0]
    return [text.replace("-", "\N{MINUS SIGN}") for text in texts]


def plain_number(value: float) -> str:
    """Return a number with a true minus sign and without trailing zeros.

    Examples
    --------
    >>> plain_number(-2050.0), plain_number(0.25)
    ('−2050', '0.25')
    """
    return f"{round(float(value), 6):g}".replace("-", "\N{MINUS SIGN}")


WIDE_ROOM = 27  # characters of a label in small letters
DETAIL_SIZE = 11.0  # of the smallest letters [design pixels]: 10 where a report shows the picture
TWO_LINES, ONE_LINE = 38.0, 18.0  # heights of an entry of the legend [design pixels]


def rim_of_words(sheet: Sheet) -> list[artists.AbstractPathEffect]:
    """Return a white rim that makes text readable on any background."""
    return [artists.withStroke(linewidth=sheet.points(3.0), foreground="white")]


def halo_text(
    sheet: Sheet,
    axes: Axes,
    at: Spot,
    words: str,
    size: float,
    colour: palette.RGB = palette.INK,
    **look: Unpack[TextStyle],
) -> None:
    """Write text centred on a point of the axes, with a white rim; pale colours become darker."""
    x, y = at
    colour = readable(colour, palette.PAPER)
    rim, points = rim_of_words(sheet), sheet.points(size)
    style: TextStyle = {
        "ha": "center", "va": "center", "parse_math": False, "path_effects": rim, **look,
    }  # fmt: skip
    axes.text(x, y, words, fontsize=points, color=colour, family=FONT, clip_on=True, **style)


def draw_symbol(sheet: Sheet, axes: Axes, at: Spot, kind: str, colour: palette.RGB) -> None:
    """Draw a symbol with a white rim at a point of the axes; `kind` is a key of `SYMBOLS`.

    Names that are placed later keep away from it.
    """
    (x, y), room = axes.transData.transform(at), 3.0 * sheet.layout.unit
    sheet.names.take((x - room, y - room, x + room, y + room))
    axes.plot(
        [at[0]], [at[1]], marker=SYMBOLS[kind], markersize=sheet.points(12.0), color=colour,
        markeredgecolor=palette.PAPER, markeredgewidth=sheet.points(1.4), linestyle="none",
        zorder=6.5,
    )  # fmt: skip


def draw_legend(sheet: Sheet, legend: tuple[Entry, ...], room: float) -> None:
    """Draw the legend in a column on the right that is `room` design pixels high."""
    if isinstance(sheet, UserSheet):
        sheet.legend(legend)
        return
    layout, unit = sheet.layout, sheet.layout.unit
    left = layout.width - 250.0 * unit
    top = layout.height - 84.0 * unit

    # entries have two lines; where they have no room, one line each; the last line counts the rest
    striped = any(entry.stripes is not None for entry in legend)  # their partner is below them
    high = TWO_LINES if striped or len(legend) * TWO_LINES <= room else ONE_LINE
    fits = max(int(room / high), 1)
    shown = legend if len(legend) <= fits else legend[: fits - 1]
    most = LABEL_ROOM if high == ONE_LINE else WIDE_ROOM
    labels = shortened_apart((entry.label for entry in legend), most)
    size = 13.5 * min(1.0, LABEL_ROOM / max(map(len, labels.values()), default=1))
    for row, entry in enumerate(shown):
        y = top - high * unit * row
        _draw_mark(sheet, entry, (left, y), 16.0 if high == TWO_LINES else 11.0)
        words = left + 38.0 * unit
        if high == ONE_LINE:
            _draw_one_line(sheet, entry, labels[entry.label], (words, y))
            continue

        # a label above, its detail below
        up = 8.0 * unit if entry.detail else 0.0
        sheet.text((words, y + up), labels[entry.label], size)
        detail = shortened(entry.detail, DETAIL_ROOM)
        sheet.text((words, y - 8.0 * unit), detail, 11.5, palette.FAINT)
    if len(shown) < len(legend):
        y = top - high * unit * len(shown)
        more = f"and {len(legend) - len(shown)} more"
        sheet.text((left + 38.0 * unit, y), more, 12.0, palette.FAINT)


def _draw_mark(sheet: Sheet, entry: Entry, at: tuple[float, float], high: float) -> None:
    """Draw the line, circle or area of an entry; `high` is in design pixels."""
    unit = sheet.layout.unit
    left, y = at
    if entry.kind in ("line", "dashes"):
        dashes: LineStyle = {"linestyle": (0, (3.0, 1.5))} if entry.kind == "dashes" else {}
        line = sheet.line([(left, y), (left + 26 * unit, y)], 3.0, entry.colour, **dashes)
        line.set_gid(LEGEND)
    elif entry.kind == "circle":
        circle = sheet.circle((left + 13 * unit, y), 5.5 * unit)
        circle.set_edgecolor(entry.colour)
    elif entry.kind in SYMBOLS:
        draw_symbol(sheet, sheet.axes, (left + 13 * unit, y), entry.kind, entry.colour)
    elif entry.kind == "area":
        look: AreaStyle = {"facecolor": (*entry.colour, max(entry.opacity, 0.35))}
        corner = (left, y - 0.5 * high * unit)
        if entry.stripes is not None:
            sheet.rectangle(corner, 26 * unit, high * unit, **look)
            look = {"facecolor": "none", "edgecolor": entry.stripes, "hatch": STRIPES}
        patch = sheet.rectangle(corner, 26 * unit, high * unit, **look)
        patch.set_hatch_linewidth(STRIPE_WIDTH)


def _draw_one_line(sheet: Sheet, entry: Entry, label: str, at: tuple[float, float]) -> None:
    """Write the label of an entry and, after it, as much of its detail as fits."""
    x, y = at
    sheet.text((x, y), label, 11.5)
    wide, _ = sheet.text_size(label, 11.5)
    rest = 205.0 * sheet.layout.unit - wide

    # whole words: a part of a number would be another number
    parts = entry.detail.split(", ")
    for n in range(len(parts), 0, -1):
        words = ", ".join(parts[:n])
        if sheet.text_size(words, DETAIL_SIZE)[0] + 8.0 * sheet.layout.unit <= rest:
            at = (x + wide + 8.0 * sheet.layout.unit, y)
            sheet.text(at, words, DETAIL_SIZE, palette.FAINT)
            return


def draw_compass(sheet: Sheet, camera: Camera) -> None:
    """Draw arrows to the north, east and up on the lower right."""
    unit = sheet.layout.unit
    at = np.array([sheet.layout.width - 190.0 * unit, 172.0 * unit])
    for name, vector in (("up", (0, 0, 1)), ("E", (1, 0, 0)), ("N", (0, 1, 0))):
        # the unit vector as the camera sees it; one that points at the viewer is left out
        arrow = np.array([camera.right @ vector, camera.up @ vector])
        if np.hypot(*arrow) < 0.2:
            continue
        north = name == "N"
        colour = palette.INK if north else palette.FAINT

        # north is bold, since it orients the map
        tip = at + 44.0 * unit * arrow
        arrow_head(sheet, at, tip, 2.2 if north else 1.3, colour)
        weight = "bold" if north else "normal"
        place = at + (44.0 + 13.0 / np.hypot(*arrow)) * unit * arrow
        sheet.text(place, name, 13.0, colour, ha="center", weight=weight)


def arrow_head(
    sheet: Sheet, start: np.ndarray, tip: np.ndarray, width: float, colour: palette.RGB
) -> None:
    """Draw an arrow from one pixel to another."""
    # a triangle at the tip, and a line to its base
    along = (tip - start) / np.hypot(*(tip - start))
    side = np.array([-along[1], along[0]])
    unit = sheet.layout.unit
    base = tip - 11.0 * unit * along
    sheet.line([start, base], width, colour)
    head = [tip, base + 4.5 * unit * side, base - 4.5 * unit * side]
    sheet.axes.add_artist(artists.Polygon(head, closed=True, facecolor=colour, edgecolor="none"))


def draw_scale_bar(
    sheet: Sheet, metres_per_pixel: float, words: str = "scale across the picture"
) -> None:
    """Draw a scale bar of round length, valid for distances parallel to the picture."""
    if isinstance(sheet, UserSheet):
        return
    unit = sheet.layout.unit

    # a round length of about 170 design pixels; half of it where that is too long
    length = nice_step(170.0 * unit * metres_per_pixel, 1)
    if length / metres_per_pixel > 210.0 * unit:
        length /= 2.0

    # two halves, dark and light, as on maps
    pixels = length / metres_per_pixel
    left, y = sheet.layout.width - 250.0 * unit, 76.0 * unit
    for i in range(2):
        face = palette.INK if i == 0 else palette.PAPER
        corner = (left + i * pixels / 2.0, y)
        sheet.rectangle(corner, pixels / 2.0, 6.0 * unit, facecolor=face)
    sheet.text((left, y - 13.0 * unit), "0", 12.0, ha="center")
    sheet.text((left + pixels, y - 13.0 * unit), length_text(length), 12.0, ha="center")
    sheet.text((left, y + 20.0 * unit), words, 11.5, palette.FAINT)


def draw_words(sheet: Sheet, title: str, caption: str) -> None:
    """Write the title above and the caption below, and apply the theme: every picture ends so."""
    layout, unit = sheet.layout, sheet.layout.unit
    expect(title, str, "title must be text", "leave it out for the default title")
    if isinstance(sheet, UserSheet):
        sheet.axes.set_title(title, loc="left", pad=22.0, parse_math=False)  # above names of faults
        return
    sheet.text((28 * unit, layout.height - 34 * unit), title, 19.0, weight="bold")
    sheet.text((28 * unit, 24 * unit), caption, 12.5, palette.FAINT)
    apply_theme(sheet.figure, sheet.axes, sheet.style)
