"""What stands around a picture: axes, legend, north arrow, scale bar, caption.

Text is set by matplotlib's Agg canvas, with fonts that matplotlib brings, so
that a picture does not depend on the fonts or the settings of the machine. Pixels are
counted from the lower left.
"""

from __future__ import annotations

import io
import logging
import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from geosurf.errors import GeosurfWarning
from geosurf.model.expected import expect
from geosurf.render import palette
from geosurf.render.layers import DETAIL_ROOM, LABEL_ROOM, Entry, length_text
from geosurf.render.views import Camera, corners
from geosurf.warning import warn

FONT = "DejaVu Sans"
DPI = 100
DESIGN_HEIGHT = 800.0  # sizes below are pixels in a picture of this height
AXES = (("Easting", "km", 1000.0), ("Northing", "km", 1000.0), ("Elevation", "m", 1.0))
MISSING = "\N{REPLACEMENT CHARACTER}"  # where the font has no letter
STRIPES, STRIPE_WIDTH = "//", 4.0  # hatching of areas that show two colours
END_ON = 0.06  # an axis that looks shorter than this part of the picture gets no labels


@dataclass(frozen=True)
class Layout:
    """Where things go: the picture's size, and the rectangle that is drawn by VTK."""

    width: int
    height: int
    left: int
    bottom: int
    view_size: tuple[int, int]

    @property
    def unit(self) -> float:
        """Pixels per design pixel."""
        return min(self.height / DESIGN_HEIGHT, self.width / 1100.0)


def lay_out(size: tuple[int, int]) -> Layout:
    """Return the layout of a picture: legend on the right, caption below."""
    width, height = size
    unit = min(height / DESIGN_HEIGHT, width / 1100.0)
    left, right, bottom, top = (round(n * unit) for n in (118, 292, 112, 70))
    return Layout(width, height, left, bottom, (width - left - right, height - bottom - top))


class Sheet:
    """A sheet of paper of some pixels that texts and lines are put on."""

    def __init__(self, layout: Layout) -> None:
        figure = _figure((layout.width, layout.height))
        self.layout = layout
        self.figure = figure
        self.axes = figure.add_axes((0, 0, 1, 1))
        self.axes.set_axis_off()
        self.axes.set_zorder(2)  # above what `paste` puts down
        self.axes.set_xlim(0, layout.width)
        self.axes.set_ylim(0, layout.height)
        self.axes.patch.set_alpha(0.0)

    def paste(self, image: np.ndarray) -> None:
        """Put the drawn rectangle in its place."""
        self.figure.figimage(image, xo=self.layout.left, yo=self.layout.bottom)

    def text(self, at, words: str, size: float = 13.0, colour=palette.INK, **look) -> None:
        """Set words at a pixel; `size` is in design pixels."""
        points = size * self.layout.unit * 72.0 / DPI
        look = {"ha": "left", "va": "center", "parse_math": False, **look}
        self.axes.text(*at, words, fontsize=points, color=colour, family=FONT, **look)

    def line(self, points, width: float = 1.0, colour=palette.INK, **look) -> None:
        """Draw a line through pixels; `width` is in design pixels."""
        x, y = np.asarray(points, dtype=float).T
        points_wide = width * self.layout.unit * 72.0 / DPI
        self.axes.plot(x, y, color=colour, linewidth=points_wide, solid_capstyle="butt", **look)

    def rectangle(self, corner, width: float, height: float, **look) -> None:
        """Draw a filled rectangle from its lower left corner."""
        from matplotlib.patches import Rectangle

        edge = {"edgecolor": palette.INK, "linewidth": 0.5 * self.layout.unit}
        return self.axes.add_patch(Rectangle(corner, width, height, **{**edge, **look}))

    def png(self) -> bytes:
        """Return the sheet as a PNG file that says nothing of who made it when."""
        return figure_png(self.figure)


def _figure(size: tuple[int, int]):
    """An empty white figure of some pixels, known to no global state.

    While matplotlib looks for fonts and folders for the first time it talks about
    it; that is of no use to people who asked for a picture.
    """
    logger = logging.getLogger("matplotlib")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    finally:
        logger.setLevel(level)
    figure = Figure(figsize=(size[0] / DPI, size[1] / DPI), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def figure_png(figure) -> bytes:
    """Return a figure as the bytes of a PNG file."""
    _replace_missing_letters(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, facecolor="white", metadata={"Software": None})
    return buffer.getvalue()


@cache
def _letters() -> frozenset[int]:
    """Code points that the font of pictures has."""
    from matplotlib.font_manager import FontProperties, findfont, get_font

    return frozenset(get_font(findfont(FontProperties(family=FONT))).get_charmap())


def _replace_missing_letters(figure) -> None:
    """Put a sign in the place of letters that the font lacks, with one warning for all of them."""
    from matplotlib.text import Text

    known, missing = _letters() | {ord("\n")}, {}
    for text in figure.findobj(Text):
        words = text.get_text()
        lacking = {letter for letter in words if ord(letter) not in known}
        if lacking:
            text.set_text("".join(MISSING if letter in lacking else letter for letter in words))
            missing.update(dict.fromkeys(filter(lacking.__contains__, words)))
    if missing:
        some = ", ".join(repr(letter) for letter in list(missing)[:5])
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        note = GeosurfWarning(
            "picture",
            "letters",
            f"Pictures show a replacement sign for letters that {FONT}, their font, lacks: "
            f"{some}{more}.",
            "Rename what should be readable in pictures; reports and files keep all letters.",
        )
        warn(note)


def nice_step(span: float, n: int = 5) -> float:
    """Return a round step that divides a span into about `n` parts.

    Examples
    --------
    >>> nice_step(4000.0), nice_step(730.0)
    (1000.0, 200.0)
    """
    rough = span / n
    power = 10.0 ** math.floor(math.log10(rough))
    return float(next(m * power for m in (1.0, 2.0, 2.5, 5.0, 10.0) if m * power >= rough * 0.99))


def fitting(sheet: Sheet, pixels: float) -> int:
    """Return how many numbers fit an axis of some pixels: from 1 to 5."""
    return int(min(max(pixels / (45.0 * sheet.layout.unit), 1.0), 5.0))


def ticks(low: float, high: float, n: int = 5) -> np.ndarray:
    """Return round values between two bounds."""
    step = nice_step(high - low, n)
    first = math.ceil(low / step - 1e-9)
    return step * np.arange(first, math.floor(high / step + 1e-9) + 1)


def tick_texts(values: np.ndarray, per: float) -> list[str]:
    """Return values over a unit, with as many decimals as their step needs."""
    step = float(values[1] - values[0]) / per if len(values) > 1 else 1.0
    decimals = next((d for d in range(6) if abs(round(step, d) - step) < 1e-9 * step), 6)
    texts = [f"{value / per:.{decimals}f}" for value in values + 0.0]
    return [text.replace("-", "\N{MINUS SIGN}") for text in texts]


def plain_number(value: float) -> str:
    """Return a number with a true minus and no digits that say nothing.

    Examples
    --------
    >>> plain_number(-2050.0), plain_number(0.25)
    ('−2050', '0.25')
    """
    return f"{round(float(value), 6):g}".replace("-", "\N{MINUS SIGN}")


def rim_of_words(unit: float) -> list:
    """Return a white rim that keeps words readable on whatever is behind them."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=3.0 * unit * 72.0 / DPI, foreground="white")]


def halo_text(sheet: Sheet, axes, at, words: str, size: float, colour=palette.INK, **look) -> None:
    """Set words in the middle of a place on axes, on a white rim that keeps them readable."""
    per = sheet.layout.unit * 72.0 / DPI
    rim = rim_of_words(sheet.layout.unit)
    look = {"ha": "center", "va": "center", "parse_math": False, **look}
    axes.text(
        *at, words, fontsize=size * per, color=colour, family=FONT, path_effects=rim, clip_on=True,
        **look,
    )  # fmt: skip


def draw_axes(sheet: Sheet, camera: Camera, bounds: tuple[float, ...]) -> None:
    """Label the edges of the box that no part of the model hides."""
    offset = np.array([sheet.layout.left, sheet.layout.bottom])
    box = corners(bounds)
    pixels = camera.to_pixels(box) + offset
    middle = pixels.mean(axis=0)
    taken: list[np.ndarray] = []
    for axis, (name, unit, per) in enumerate(AXES):
        edge = _outer_edge(pixels, axis, min(camera.size) * END_ON)
        if edge is None:
            continue
        low, high = box[edge[0]], box[edge[1]]
        texts_fit = fitting(sheet, float(np.linalg.norm(pixels[edge[1]] - pixels[edge[0]])))
        values = ticks(low[axis], high[axis], min(texts_fit, 4 if axis == 2 else 5))
        texts = tick_texts(values, per)
        part = (values - low[axis]) / (high[axis] - low[axis])
        ends = pixels[list(edge)]
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        outward = np.array([along[1], -along[0]])
        if outward @ (ends.mean(axis=0) - middle) < 0.0:
            outward = -outward
        places = ends[0] + part[:, None] * (ends[1] - ends[0])
        _draw_axis(sheet, places, texts, outward, taken)
        _name_axis(sheet, ends.mean(axis=0), f"{name} [{unit}]", along, outward, texts)


def _outer_edge(pixels: np.ndarray, axis: int, shortest: float) -> tuple[int, int] | None:
    """The lowest edge for horizontal axes, the leftmost for elevation; None if seen end-on."""
    bit = (4, 2, 1)[axis]
    edges = [(i, i | bit) for i in range(8) if not i & bit]
    length = np.linalg.norm(pixels[edges[0][1]] - pixels[edges[0][0]])
    if length < shortest:
        return None
    middles = [pixels[list(edge)].mean(axis=0).round(3) for edge in edges]
    keys = [(m[0], m[1]) if axis == 2 else (m[1], m[0]) for m in middles]
    return edges[min(range(4), key=keys.__getitem__)]


def _draw_axis(
    sheet: Sheet,
    places: np.ndarray,
    texts: list[str],
    outward: np.ndarray,
    taken: list[np.ndarray],
) -> None:
    """Ticks and numbers; a number that would run into one in `taken` is left out."""
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
            path_effects=rim_of_words(unit),
        )


def _name_axis(
    sheet: Sheet,
    at: np.ndarray,
    words: str,
    along: np.ndarray,
    outward: np.ndarray,
    texts: list[str],
) -> None:
    """Write the name along its axis, beyond the numbers, never upside down."""
    angle = math.degrees(math.atan2(along[1], along[0]))
    angle = (angle + 90.0) % 180.0 - 90.0
    # the numbers are as wide as their longest, and one line high
    wide = 7.6 * max(map(len, texts), default=0)
    distance = 25.0 + wide * abs(outward[0]) + 14.0 * abs(outward[1])
    place = at + distance * sheet.layout.unit * outward
    if abs(angle + 90.0) < 1e-6:
        angle = 90.0
    look = {"rotation": angle, "rotation_mode": "anchor"}
    rims = rim_of_words(sheet.layout.unit)
    sheet.text(place, words, 13.0, ha="center", va="center", path_effects=rims, **look)


def draw_legend(sheet: Sheet, legend: tuple[Entry, ...], room: float) -> None:
    """List what is shown, in a column on the right that is `room` design pixels high."""
    layout, unit = sheet.layout, sheet.layout.unit
    left = layout.width - 250.0 * unit
    top = layout.height - 84.0 * unit
    fits = max(int(room / 38.0), 1)
    shown = legend if len(legend) <= fits else legend[: fits - 1]
    for row, entry in enumerate(shown):
        y = top - 38.0 * unit * row
        if entry.kind in ("line", "dashes"):
            look = {"linestyle": (0, (3.0, 1.5))} if entry.kind == "dashes" else {}
            sheet.line([(left, y), (left + 26 * unit, y)], 3.0, entry.colour, **look)
        elif entry.kind == "area":
            look = {"facecolor": (*entry.colour, max(entry.opacity, 0.35))}
            if entry.stripes is not None:
                sheet.rectangle((left, y - 8 * unit), 26 * unit, 16 * unit, **look)
                look = {"facecolor": "none", "edgecolor": entry.stripes, "hatch": STRIPES}
            patch = sheet.rectangle((left, y - 8 * unit), 26 * unit, 16 * unit, **look)
            patch.set_hatch_linewidth(STRIPE_WIDTH)
        words = left + 38.0 * unit
        high = 8.0 * unit if entry.detail else 0.0
        sheet.text((words, y + high), shortened(entry.label), 13.5)
        detail = shortened(entry.detail, DETAIL_ROOM)
        sheet.text((words, y - 8.0 * unit), detail, 11.5, palette.FAINT)
    if len(shown) < len(legend):
        y = top - 38.0 * unit * len(shown)
        more = f"and {len(legend) - len(shown)} more"
        sheet.text((left + 38.0 * unit, y), more, 12.0, palette.FAINT)


def shortened(words: str, most: int = LABEL_ROOM) -> str:
    """Return words that fit the legend: names that differ at their end go on doing so.

    Examples
    --------
    >>> shortened("a horizon with a very long name")
    'a horizon…long name'
    >>> shortened("UpperVolantis/LowerVolantis")
    'Upper…ntis/Lower…ntis'
    """
    if len(words) <= most:
        return words
    parts = words.split("/")
    if len(parts) == 2 and min(map(len, parts)) > most // 2:
        return "/".join(shortened(part, most // 2) for part in parts)
    return f"{words[: most // 2].rstrip()}…{words[-(most // 2 - 1) :].lstrip()}"


def draw_compass(sheet: Sheet, camera: Camera) -> None:
    """Show where north, east and up are, on the lower right."""
    unit = sheet.layout.unit
    at = np.array([sheet.layout.width - 190.0 * unit, 172.0 * unit])
    for name, vector in (("up", (0, 0, 1)), ("E", (1, 0, 0)), ("N", (0, 1, 0))):
        arrow = np.array([camera.right @ vector, camera.up @ vector])
        if np.hypot(*arrow) < 0.2:
            continue
        north = name == "N"
        colour = palette.INK if north else palette.FAINT
        tip = at + 44.0 * unit * arrow
        arrow_head(sheet, at, tip, 2.2 if north else 1.3, colour)
        weight = "bold" if north else "normal"
        place = at + (44.0 + 13.0 / np.hypot(*arrow)) * unit * arrow
        sheet.text(place, name, 13.0, colour, ha="center", weight=weight)


def arrow_head(sheet: Sheet, start, tip, width: float, colour) -> None:
    """Draw an arrow from one pixel to another."""
    from matplotlib.patches import Polygon

    start, tip = np.asarray(start, dtype=float), np.asarray(tip, dtype=float)
    along = (tip - start) / np.hypot(*(tip - start))
    side = np.array([-along[1], along[0]])
    unit = sheet.layout.unit
    base = tip - 11.0 * unit * along
    sheet.line([start, base], width, colour)
    head = [tip, base + 4.5 * unit * side, base - 4.5 * unit * side]
    sheet.axes.add_patch(Polygon(head, closed=True, facecolor=colour, edgecolor="none"))


def draw_scale_bar(sheet: Sheet, metres_per_pixel: float, words: str = "across the view") -> None:
    """Draw a bar of round length, true for distances across the view."""
    unit = sheet.layout.unit
    length = nice_step(170.0 * unit * metres_per_pixel, 1)
    if length / metres_per_pixel > 210.0 * unit:
        length /= 2.0
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
    """Write the title above and the caption below."""
    layout, unit = sheet.layout, sheet.layout.unit
    expect(title, str, "title takes text", "leave it out for one that says what is shown")
    sheet.text((28 * unit, layout.height - 34 * unit), title, 19.0, weight="bold")
    sheet.text((28 * unit, 24 * unit), caption, 12.5, palette.FAINT)
