"""Draw the frame of a picture: axes, legend, north arrow, scale bar, title and caption.

Pixels are counted from the lower left. In the axes of a user there is no frame: a legend, a colour
bar and a title take its place.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Unpack

import numpy as np

from geosurf.conventions import length_text
from geosurf.model.expected import expect
from geosurf.render import palette
from geosurf.render.layers import DETAIL_ROOM, Entry
from geosurf.render.names import shortened, shortened_apart
from geosurf.render.palette import AreaStyle, LineStyle, Spot, TextStyle
from geosurf.render.picture_style import FONT, LEGEND, apply_theme, readable
from geosurf.render.sheet import (
    DPI,
    STRIPE_WIDTH,
    STRIPES,
    Layout,
    Sheet,
    UserSheet,
    figure_bytes,
    lay_out,
    sheet_for,
)
from geosurf.render.views import Camera

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.patheffects import AbstractPathEffect


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
    step = float(values[1] - values[0]) / per if len(values) > 1 else 1.0

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


TWO_LINES, ONE_LINE = 38.0, 18.0  # heights of an entry of the legend [design pixels]


def rim_of_words(unit: float) -> list[AbstractPathEffect]:
    """Return a white rim that makes text readable on any background."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=3.0 * unit * 72.0 / DPI, foreground="white")]


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
    per = sheet.layout.unit * 72.0 / DPI
    rim = rim_of_words(sheet.layout.unit)
    style: TextStyle = {
        "ha": "center", "va": "center", "parse_math": False, "path_effects": rim, **look,
    }  # fmt: skip
    axes.text(x, y, words, fontsize=size * per, color=colour, family=FONT, clip_on=True, **style)


def draw_legend(sheet: Sheet, legend: tuple[Entry, ...], room: float) -> None:
    """Draw the legend in a column on the right that is `room` design pixels high."""
    if isinstance(sheet, UserSheet):
        sheet.legend(legend)
        return
    layout, unit = sheet.layout, sheet.layout.unit
    left = layout.width - 250.0 * unit
    top = layout.height - 84.0 * unit

    # entries have two lines; where they have no room, one line each; the last line counts the rest
    high = TWO_LINES if len(legend) * TWO_LINES <= room else ONE_LINE
    fits = max(int(room / high), 1)
    shown = legend if len(legend) <= fits else legend[: fits - 1]
    labels = shortened_apart(entry.label for entry in legend)
    for row, entry in enumerate(shown):
        y = top - high * unit * row
        _draw_mark(sheet, entry, (left, y), 16.0 if high == TWO_LINES else 11.0)
        words = left + 38.0 * unit
        if high == ONE_LINE:
            _draw_one_line(sheet, entry, labels[entry.label], (words, y))
            continue

        # a label above, its detail below
        up = 8.0 * unit if entry.detail else 0.0
        sheet.text((words, y + up), labels[entry.label], 13.5)
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
        if sheet.text_size(words, 10.0)[0] + 8.0 * sheet.layout.unit <= rest:
            sheet.text((x + wide + 8.0 * sheet.layout.unit, y), words, 10.0, palette.FAINT)
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
    from matplotlib.patches import Polygon

    # a triangle at the tip, and a line to its base
    along = (tip - start) / np.hypot(*(tip - start))
    side = np.array([-along[1], along[0]])
    unit = sheet.layout.unit
    base = tip - 11.0 * unit * along
    sheet.line([start, base], width, colour)
    head = [tip, base + 4.5 * unit * side, base - 4.5 * unit * side]
    sheet.axes.add_artist(Polygon(head, closed=True, facecolor=colour, edgecolor="none"))


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


__all__ = [
    "DPI",
    "FONT",
    "STRIPES",
    "STRIPE_WIDTH",
    "Layout",
    "Sheet",
    "UserSheet",
    "arrow_head",
    "draw_compass",
    "draw_legend",
    "draw_scale_bar",
    "draw_words",
    "figure_bytes",
    "halo_text",
    "lay_out",
    "rim_of_words",
    "sheet_for",
    "shortened",
]
