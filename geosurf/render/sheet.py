"""A picture on which text and lines are drawn at pixels, or the axes of a user's figure.

Text is drawn by the Agg canvas of matplotlib with the font that matplotlib ships, so a picture
does not depend on the fonts or the settings of the machine. Pixels are counted from the lower
left.
"""

from __future__ import annotations

import io
import logging
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from geosurf.conventions import palette
from geosurf.conventions.machine import need_plots
from geosurf.errors import GeosurfWarning, warn, warn_of
from geosurf.model.expected import expect
from geosurf.render import artists
from geosurf.render.artists import AreaStyle, LineStyle, Spot, TextStyle
from geosurf.render.layers import SYMBOLS, Entry, Room
from geosurf.render.picture_style import FONT, PLAIN, PictureStyle, style_of
from geosurf.stopping import interrupted_later

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# ---- letters ----------------------------------------
# Letters that the fonts of a picture lack, and scripts that matplotlib cannot lay out.


MISSING = "\N{REPLACEMENT CHARACTER}"  # for letters that the font lacks
RIGHT = ("R", "AL")  # classes of letters that run from right to left (Unicode, annex 9)


@cache
def _letters(fonts: tuple[str, ...]) -> frozenset[int]:
    """Code points that the fonts of a picture have together."""
    found = (artists.findfont(artists.FontProperties(family=[font])) for font in fonts)
    return frozenset().union(*(artists.get_font(path).get_charmap() for path in found))


def _texts_of(artist: artists.Artist) -> Iterator[artists.Text]:
    """All texts in an artist that are drawn; `findobj` would make the ticks of hidden axes."""
    hidden = isinstance(artist, artists.Axes) and not artist.axison
    for child in artist.get_children():
        if not (hidden and isinstance(child, artists.Axis)):
            yield from _texts_of(child)
    if isinstance(artist, artists.Text):
        yield artist


def replace_missing_letters(figure: Figure) -> None:
    """Replace letters that the fonts lack by a sign, with one warning for all of them."""
    # all texts of the figure at once, so that there is one warning for a picture
    missing: dict[str, None] = {}
    joined = False
    for text in _texts_of(figure):
        words = text.get_text()
        joined = joined or any(unicodedata.bidirectional(letter) in RIGHT for letter in words)
        known = _letters(tuple(text.get_fontfamily()))
        lacking = {letter for letter in words if ord(letter) not in known and letter != "\n"}
        if lacking:
            text.set_text("".join(MISSING if letter in lacking else letter for letter in words))
            missing.update(dict.fromkeys(filter(lacking.__contains__, words)))
    if joined and not _joins_letters():
        warn_of(
            "picture",
            "script",
            "Arabic and Hebrew names are drawn from left to right, with letters apart: this "
            "version of matplotlib cannot do otherwise.",
            "Install matplotlib 3.11 or newer; reports and files have the names as they are.",
        )
    if missing:
        listed = ", ".join(repr(letter) for letter in list(missing)[:5])
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        note = GeosurfWarning(
            "picture",
            "letters",
            f"Pictures show a replacement sign for letters that their font lacks: {listed}{more}.",
            _remedy(missing),
        )
        warn(note)


def _joins_letters() -> bool:
    """Whether matplotlib lays out scripts that join letters or run from right to left."""
    from matplotlib import ft2font

    return hasattr(ft2font, "__libraqm_version__")


def _remedy(letters: Iterable[str]) -> str:
    """Name an installed font that has all letters; else say which kind to install."""
    wanted = set(map(ord, letters))
    for entry in sorted(artists.fontManager.ttflist, key=lambda entry: entry.name):
        # the font of last resort draws a box with the code of the letter
        known = artists.get_font(entry.fname).get_charmap()
        if "Last Resort" not in entry.name and wanted <= known.keys():
            return f"Set PictureStyle(font={entry.name!r}), which has them."
    return (
        "Install a font that has them, such as Noto Sans of that script, and set "
        "PictureStyle(font=...); or rename the surfaces. Reports and files have all letters."
    )


DPI = 100
DESIGN_HEIGHT = 800.0  # sizes below are pixels in a picture of this height
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
    """A blank picture on which text and lines are drawn at pixel positions.

    `names` has the places that names next to lines and wells have taken.
    """

    def __init__(self, layout: Layout, style: PictureStyle = PLAIN) -> None:
        figure = _figure((layout.width, layout.height))
        self.layout = layout
        self.style = style
        self.names = Room()
        self.figure = figure
        self.axes = figure.add_axes((0, 0, 1, 1))
        self.axes.set_axis_off()
        self.axes.set_zorder(2)  # above the image of `paste`
        self.axes.set_xlim(0, layout.width)
        self.axes.set_ylim(0, layout.height)
        self.axes.patch.set_alpha(0.0)

    def points(self, size: float) -> float:
        """Return a size in points, as matplotlib takes it; `size` is in design pixels."""
        return size * self.layout.unit * 72.0 / DPI

    def paste(self, image: np.ndarray) -> None:
        """Place the image that VTK drew."""
        self.figure.add_artist(pasted(image, self.layout.left, self.layout.bottom))

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
        style: TextStyle = {"ha": "left", "va": "center", "parse_math": False, **look}
        self.axes.text(x, y, words, fontsize=self.points(size), color=colour, family=FONT, **style)

    def line(
        self,
        points: Sequence[Spot],
        width: float = 1.0,
        colour: palette.RGB = palette.INK,
        **look: Unpack[LineStyle],
    ) -> artists.Line2D:
        """Draw a line through pixels; `width` is in design pixels."""
        x, y = np.asarray(points, dtype=float).T
        wide = self.points(width)
        (line,) = self.axes.plot(x, y, color=colour, linewidth=wide, solid_capstyle="butt", **look)
        return line

    def rectangle(
        self, corner: tuple[float, float], width: float, height: float, **look: Unpack[AreaStyle]
    ) -> artists.Rectangle:
        """Draw a filled rectangle from its lower left corner."""
        edge = 0.5 * self.layout.unit
        style: AreaStyle = {"edgecolor": palette.INK, "linewidth": edge, **look}
        patch = artists.Rectangle(corner, width, height, **style)
        self.axes.add_artist(patch)  # `add_patch` would look for the extent of the axes
        return patch

    def circle(self, centre: Spot, radius: float) -> artists.Circle:
        """Draw a white circle with a dark rim around a pixel."""
        x, y = centre
        rim = self.points(1.6)
        circle = artists.Circle((x, y), radius, facecolor="white", edgecolor="black", linewidth=rim)
        self.axes.add_artist(circle)
        return circle

    def text_size(self, words: str, size: float, weight: str = "normal") -> tuple[float, float]:
        """Return width and height of a text [pixels]; `size` is in design pixels."""
        points = self.points(size)
        font = artists.FontProperties(family=self.style.fonts, size=points, weight=weight)

        # matplotlib's renderer has no types
        renderer: Any = artists.RendererAgg(1, 1, DPI)  # type: ignore[no-untyped-call]
        wide, high, _ = renderer.get_text_width_height_descent(words, font, False)
        return float(wide), float(high)

    @property
    def room(self) -> tuple[float, float]:
        """Width and height for a map or a diagram [pixels]."""
        return self.layout.view_size

    def frame(self, place: tuple[float, float, float, float]) -> Axes:
        """Return new axes: left, bottom, width and height as fractions of the picture."""
        return self.figure.add_axes(place)


class UserSheet(Sheet):
    """Axes of a user's figure: a map or a diagram goes into them, with a legend of its own.

    Nothing is drawn at pixels of the figure, which may hold other axes.
    """

    def __init__(self, axes: Axes, style: PictureStyle = PLAIN) -> None:
        self.style = style
        self.names = Room()
        # a design pixel is a pixel at 100 per inch: words have the size of usual figures
        self.layout = lay_out((1100, 800))
        self.figure = axes.figure  # type: ignore[assignment]
        self.axes = axes

    @property
    def room(self) -> tuple[float, float]:
        """Width and height of the axes [pixels]."""
        extent = self.axes.get_window_extent()
        return extent.width, extent.height

    def frame(self, place: tuple[float, float, float, float]) -> Axes:
        """Return the axes, wherever they are."""
        return self.axes

    def legend(self, entries: Sequence[Entry]) -> None:
        """Add a legend with an entry for each line and area."""
        handles: list[artists.Line2D | artists.Patch] = []
        for entry in entries:
            label = f"{entry.label}: {entry.detail}" if entry.detail else entry.label
            if entry.kind in ("line", "dashes"):
                line = artists.Line2D([], [], color=entry.colour, label=label)
                line.set_linestyle("dashed" if entry.kind == "dashes" else "solid")
                handles.append(line)
            elif entry.kind == "circle" or entry.kind in SYMBOLS:
                ring = artists.Line2D([], [], color=entry.colour, label=label, linestyle="none")
                ring.set(marker=SYMBOLS.get(entry.kind, "o"))
                if entry.kind == "circle":
                    ring.set(markerfacecolor="none")
                handles.append(ring)
            else:
                face = (*entry.colour, max(entry.opacity, 0.35))
                patch = artists.Patch(facecolor=face, edgecolor=palette.INK, label=label)
                if entry.kind == "heading":
                    patch = artists.Patch(facecolor="none", edgecolor="none", label=label)
                if entry.stripes is not None:
                    patch.set(edgecolor=entry.stripes, hatch=STRIPES)
                handles.append(patch)
        if handles:
            self.axes.legend(handles=handles, loc="best", fontsize="small", framealpha=0.8)

    def colour_bar(
        self, levels: np.ndarray, words: str, colours: artists.Colormap, n_band: int, sign: float
    ) -> None:
        """Add a colour bar next to the axes, with `n_band` bands between two levels."""
        if len(levels) > 1:
            bands = np.linspace(levels[0], levels[-1], (len(levels) - 1) * n_band + 1)
            shown = artists.ScalarMappable(artists.BoundaryNorm(bands, colours.N), colours)
            ticks = levels[:: max(1, len(levels) // 5)].tolist()
            bar = self.figure.colorbar(shown, ax=self.axes, label=words, ticks=ticks)
            if sign < 0:
                bar.set_ticks(ticks, labels=[f"{sign * tick:g}" for tick in ticks])


def sheet_for(axes: Axes | None, size: tuple[int, int], style: PictureStyle | None = None) -> Sheet:
    """Return a sheet of its own of a size [pixels], or one for the axes of a user.

    Raises
    ------
    DependencyError
        If matplotlib is not installed.
    """
    need_plots()
    style = style_of(style)
    if axes is None:
        return Sheet(lay_out(size), style)
    check_axes(axes)
    return UserSheet(axes, style)


def check_axes(axes: Any) -> None:
    """Refuse what is not axes of matplotlib.

    Raises
    ------
    InputError
    """
    need_plots()
    expect(axes, artists.Axes, "ax must be axes of matplotlib", "pass ax=figure.subplots()")


def pasted(image: np.ndarray, left: int, bottom: int) -> artists.Artist:
    """
    Return pixels as a part of a figure, in which they are drawn as they are.

    `Figure.figimage` would sample them, which takes 100 bytes for each.

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width, 3 or 4)
        The first row is the top.
    left, bottom : int
        Where the lower left corner is [pixels].

    Returns
    -------
    matplotlib.artist.Artist
    """

    class Pasted(artists.Artist):
        """An image whose pixels are those of the figure."""

        def __reduce__(self) -> tuple[Any, ...]:
            return pasted, (image, left, bottom), self.__getstate__()

        def draw(self, renderer: Any) -> None:
            # renderers take four channels, the lowest row first
            opaque = np.full((*image.shape[:2], 4), 255, dtype=np.uint8)
            opaque[..., : image.shape[2]] = image[::-1]
            context = renderer.new_gc()
            renderer.draw_image(context, left, bottom, opaque)
            context.restore()

    return Pasted()


@contextmanager
def quiet_matplotlib() -> Iterator[None]:
    """Suppress what matplotlib logs at its first import: its cache of fonts and its folders.

    One thread at a time: of two, the second one would restore what the first one has set.
    """
    logger = logging.getLogger("matplotlib")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def _figure(size: tuple[int, int]) -> Figure:
    """An empty white figure, independent of the global state of pyplot."""
    with quiet_matplotlib():
        inches = (size[0] / DPI, size[1] / DPI)
        figure = artists.Figure(figsize=inches, dpi=DPI, facecolor="white")
        artists.FigureCanvasAgg(figure)
    # notebooks show it without pyplot
    figure._repr_png_ = partial(figure_bytes, figure, "png")  # type: ignore[attr-defined]
    return figure


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """Return a figure as the bytes of a file, without metadata that change: png, svg or pdf."""
    replace_missing_letters(figure)
    buffer = io.BytesIO()
    metadata = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}

    # names inside an SVG file are random numbers unless they have a salt
    with artists.rc_context({"svg.hashsalt": "geosurf"}), interrupted_later():
        figure.savefig(buffer, format=kind, dpi=DPI, facecolor="auto", metadata=metadata[kind])
    return buffer.getvalue()
