"""Draw the frame of a picture: axes, legend, north arrow, scale bar, title and caption.

Text is drawn by the Agg canvas of matplotlib with the font that matplotlib ships, so a picture
does not depend on the fonts or the settings of the machine. Pixels are counted from the lower
left.
"""

from __future__ import annotations

import io
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Unpack

import numpy as np

from geosurf.conventions import length_text
from geosurf.errors import GeosurfWarning
from geosurf.model.expected import expect
from geosurf.render import palette
from geosurf.render.layers import DETAIL_ROOM, LABEL_ROOM, Entry
from geosurf.render.styles import AreaStyle, LineStyle, Spot, TextStyle
from geosurf.render.ticks import nice_step
from geosurf.render.views import Camera
from geosurf.warning import warn

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle, Rectangle
    from matplotlib.patheffects import AbstractPathEffect

FONT = "DejaVu Sans"
DPI = 100
DESIGN_HEIGHT = 800.0  # sizes below are pixels in a picture of this height
MISSING = "\N{REPLACEMENT CHARACTER}"  # for letters that the font lacks
STRIPES, STRIPE_WIDTH = "//", 4.0  # hatching of areas with two colours


@dataclass(frozen=True)
class Layout:
    """Size of the picture, and the rectangle that VTK draws."""

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
    """A blank picture on which text and lines are drawn at pixel positions."""

    def __init__(self, layout: Layout) -> None:
        figure = _figure((layout.width, layout.height))
        self.layout = layout
        self.figure = figure
        self.axes = figure.add_axes((0, 0, 1, 1))
        self.axes.set_axis_off()
        self.axes.set_zorder(2)  # above the image of `paste`
        self.axes.set_xlim(0, layout.width)
        self.axes.set_ylim(0, layout.height)
        self.axes.patch.set_alpha(0.0)

    def paste(self, image: np.ndarray) -> None:
        """Place the image that VTK drew."""
        self.figure.figimage(image, xo=self.layout.left, yo=self.layout.bottom)

    def text(
        self,
        at: Spot,
        words: str,
        size: float = 13.0,
        colour: palette.RGB = palette.INK,
        **look: Unpack[TextStyle],
    ) -> None:
        """Write text at a pixel; `size` is in design pixels."""
        x, y = at
        points = size * self.layout.unit * 72.0 / DPI
        style: TextStyle = {"ha": "left", "va": "center", "parse_math": False, **look}
        self.axes.text(x, y, words, fontsize=points, color=colour, family=FONT, **style)

    def line(
        self,
        points: Sequence[Spot],
        width: float = 1.0,
        colour: palette.RGB = palette.INK,
        **look: Unpack[LineStyle],
    ) -> None:
        """Draw a line through pixels; `width` is in design pixels."""
        x, y = np.asarray(points, dtype=float).T
        points_wide = width * self.layout.unit * 72.0 / DPI
        self.axes.plot(x, y, color=colour, linewidth=points_wide, solid_capstyle="butt", **look)

    def rectangle(
        self,
        corner: tuple[float, float],
        width: float,
        height: float,
        **look: Unpack[AreaStyle],
    ) -> Rectangle:
        """Draw a filled rectangle from its lower left corner."""
        from matplotlib.patches import Rectangle

        edge = 0.5 * self.layout.unit
        style: AreaStyle = {"edgecolor": palette.INK, "linewidth": edge, **look}
        patch = Rectangle(corner, width, height, **style)
        self.axes.add_patch(patch)
        return patch

    def circle(self, centre: Spot, radius: float) -> Circle:
        """Draw a white circle with a dark rim around a pixel."""
        from matplotlib.patches import Circle

        x, y = centre
        width = 1.6 * self.layout.unit * 72.0 / DPI
        circle = Circle((x, y), radius, facecolor="white", edgecolor="black", linewidth=width)
        self.axes.add_patch(circle)
        return circle

    def png(self) -> bytes:
        """Return the sheet as a PNG file without metadata: equal sheets give equal bytes."""
        return figure_png(self.figure)


def _figure(size: tuple[int, int]) -> Figure:
    """An empty white figure, independent of the global state of pyplot.

    The first import of matplotlib logs messages about fonts and folders, which are suppressed
    here.
    """
    # matplotlib reports on its font cache when first imported: nothing that a user can act on
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


def figure_png(figure: Figure) -> bytes:
    """Return a figure as the bytes of a PNG file."""
    _replace_missing_letters(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, facecolor="white", metadata={"Software": None})
    return buffer.getvalue()


@cache
def _letters() -> frozenset[int]:
    """Code points of the font of pictures."""
    from matplotlib.font_manager import FontProperties, findfont, get_font

    return frozenset(get_font(findfont(FontProperties(family=FONT))).get_charmap())


def _replace_missing_letters(figure: Figure) -> None:
    """Replace letters that the font lacks by a sign, with one warning for all of them."""
    from matplotlib.text import Text

    # all texts of the figure at once, so that there is one warning for a picture
    known = _letters() | {ord("\n")}
    missing: dict[str, None] = {}
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
            f"Pictures show a replacement sign for letters that the font {FONT} lacks: "
            f"{some}{more}.",
            "Rename the surfaces to make them readable; reports and files have all letters.",
        )
        warn(note)


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
    """Write text centred on a point of the axes, with a white rim."""
    x, y = at
    per = sheet.layout.unit * 72.0 / DPI
    rim = rim_of_words(sheet.layout.unit)
    style: TextStyle = {
        "ha": "center", "va": "center", "parse_math": False, "path_effects": rim, **look,
    }  # fmt: skip
    axes.text(x, y, words, fontsize=size * per, color=colour, family=FONT, clip_on=True, **style)


def draw_legend(sheet: Sheet, legend: tuple[Entry, ...], room: float) -> None:
    """Draw the legend in a column on the right that is `room` design pixels high."""
    layout, unit = sheet.layout, sheet.layout.unit
    left = layout.width - 250.0 * unit
    top = layout.height - 84.0 * unit

    # 38 design pixels for each entry; the last line counts those that have no room
    fits = max(int(room / 38.0), 1)
    shown = legend if len(legend) <= fits else legend[: fits - 1]
    for row, entry in enumerate(shown):
        y = top - 38.0 * unit * row
        if entry.kind in ("line", "dashes"):
            dashes: LineStyle = {"linestyle": (0, (3.0, 1.5))} if entry.kind == "dashes" else {}
            sheet.line([(left, y), (left + 26 * unit, y)], 3.0, entry.colour, **dashes)
        elif entry.kind == "circle":
            circle = sheet.circle((left + 13 * unit, y), 5.5 * unit)
            circle.set_edgecolor(entry.colour)
        elif entry.kind == "area":
            look: AreaStyle = {"facecolor": (*entry.colour, max(entry.opacity, 0.35))}
            if entry.stripes is not None:
                sheet.rectangle((left, y - 8 * unit), 26 * unit, 16 * unit, **look)
                look = {"facecolor": "none", "edgecolor": entry.stripes, "hatch": STRIPES}
            patch = sheet.rectangle((left, y - 8 * unit), 26 * unit, 16 * unit, **look)
            patch.set_hatch_linewidth(STRIPE_WIDTH)

        # a label above, its detail below
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
    """Return text short enough for the legend; both the start and the end of a name remain.

    Examples
    --------
    >>> shortened("a horizon with a very long name")
    'a horizon…long name'
    >>> shortened("UpperVolantis/LowerVolantis")
    'Upper…ntis/Lower…ntis'
    """
    if len(words) <= most:
        return words

    # zones are named by two horizons: each of them is shortened by itself
    parts = words.split("/")
    if len(parts) == 2 and min(map(len, parts)) > most // 2:
        return "/".join(shortened(part, most // 2) for part in parts)
    return f"{words[: most // 2].rstrip()}…{words[-(most // 2 - 1) :].lstrip()}"


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
    sheet.axes.add_patch(Polygon(head, closed=True, facecolor=colour, edgecolor="none"))


def draw_scale_bar(
    sheet: Sheet, metres_per_pixel: float, words: str = "scale across the picture"
) -> None:
    """Draw a scale bar of round length, valid for distances parallel to the picture."""
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
    """Write the title above and the caption below."""
    layout, unit = sheet.layout, sheet.layout.unit
    expect(title, str, "title must be text", "leave it out for the default title")
    sheet.text((28 * unit, layout.height - 34 * unit), title, 19.0, weight="bold")
    sheet.text((28 * unit, 24 * unit), caption, 12.5, palette.FAINT)
