"""Give a finished figure the background, text colours and fonts of a style.

Pictures are drawn in the colours of the light theme. The dark one replaces the colours of the
frame: text, axes, legend and arrows. Colours of data stay, so that a zone looks the same in both.
Text of another colour is made lighter until it can be read.
"""

from __future__ import annotations

import colorsys
from typing import TYPE_CHECKING, Any

from geosurf.render import palette
from geosurf.render.palette import RGB, rgb
from geosurf.render.picture_style import PictureStyle

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DARK_PAPER = rgb("#16191d")
ROLES = {  # light -> dark
    palette.INK: rgb("#e4e7eb"),
    palette.FAINT: rgb("#a3abb5"),
    palette.FRAME: rgb("#6d747d"),
    palette.PAPER: DARK_PAPER,
    palette.CONTACT: rgb("#7d9bff"),
}
LEGEND = "legend"  # marks lines that have the colour of data
CONTRAST = 4.5  # of text against the background (WCAG 2.1, AA)
SEEN, RIM = 2.0, 0.9  # least contrast of a line without rims, and their width [points]
NEAR = 0.005  # colours this near are the same: matplotlib stores some of them in 8 bits


def background(style: PictureStyle) -> RGB:
    """Return the colour of the background, also where it is transparent."""
    return DARK_PAPER if style.dark else palette.PAPER


def apply_theme(figure: Figure, frame: Axes, style: PictureStyle) -> None:
    """Apply a style to a figure of geosurf.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    frame : matplotlib.axes.Axes
        The axes of the whole sheet: legend, arrows and scale bar. Lines and areas of other axes
        are data, and keep their colours.
    style : PictureStyle
    """
    from matplotlib.text import Text

    if style.font is not None:
        for text in figure.findobj(Text):
            text.set_fontfamily(style.fonts)
    if style.dark:
        _darken(figure, frame)
    if style.transparent:
        figure.patch.set_alpha(0.0)
        for axes in figure.axes:
            axes.patch.set_alpha(0.0)


def _darken(figure: Figure, frame: Axes) -> None:
    """Replace the colours of the frame by those of the dark theme."""
    from matplotlib.colors import to_rgb
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.patheffects import withStroke
    from matplotlib.text import Annotation, Text

    figure.set_facecolor(DARK_PAPER)
    on_data = {
        text for axes in figure.axes if axes is not frame for text in axes.texts
        if not (isinstance(text, Annotation) or text.get_path_effects())
    }  # fmt: skip
    for text in figure.findobj(Text):
        # numbers of contours stand on the colours of data, which stay
        if text in on_data:
            continue
        text.set_color(readable(_swapped(text.get_color())))
        for effect in text.get_path_effects() or ():
            # white rims become dark ones; matplotlib has no public way to do so
            vars(effect)["_gc"]["foreground"] = DARK_PAPER
    for axes in figure.axes:
        axes.set_facecolor(DARK_PAPER)
        for spine in axes.spines.values():
            spine.set_edgecolor(_swapped(spine.get_edgecolor()))
        for axis in (axes.xaxis, axes.yaxis):
            for tick in (*axis.get_ticklines(), *axis.get_minorticklines()):
                tick.set_color(_swapped(tick.get_color()))
    # legend, arrows and scale bar; a line that frames an area of the legend is part of it
    for line in frame.findobj(Line2D):
        if line.get_gid() != LEGEND:
            line.set_color(_swapped(line.get_color()))
        if _contrast(to_rgb(line.get_color()), DARK_PAPER) < SEEN:
            # a dark line keeps the colour that it has on the model, between light rims
            wide = line.get_linewidth() + 2.0 * RIM
            line.set_path_effects([withStroke(linewidth=wide, foreground=ROLES[palette.FAINT])])
    for patch in frame.patches:
        if isinstance(patch, Patch):
            patch.set_facecolor(_swapped(patch.get_facecolor()))
            patch.set_edgecolor(_swapped(patch.get_edgecolor()))


def _swapped(colour: Any) -> Any:
    """The dark counterpart of a colour of the frame; other colours as they are."""
    from matplotlib.colors import to_rgba

    *solid, alpha = to_rgba(colour)
    for light, dark in ROLES.items():
        if alpha > 0.0 and max(abs(a - b) for a, b in zip(light, solid, strict=True)) < NEAR:
            return (*dark, alpha)
    return colour


def readable(colour: Any, paper: RGB = DARK_PAPER) -> RGB:
    """Return a colour, lighter on dark paper or darker on light paper until it can be read.

    Examples
    --------
    >>> readable((1.0, 1.0, 1.0))
    (1.0, 1.0, 1.0)
    >>> min(readable((0.2, 0.1, 0.1))) > 0.4
    True
    >>> max(readable((0.7, 0.6, 0.8), palette.PAPER)) < 0.7
    True
    """
    from matplotlib.colors import to_rgb

    red, green, blue = to_rgb(colour)
    step = 0.02 if _luminance(paper) < 0.5 else -0.02
    while _contrast((red, green, blue), paper) < CONTRAST:
        hue, lightness, saturation = colorsys.rgb_to_hls(red, green, blue)
        red, green, blue = colorsys.hls_to_rgb(hue, lightness + step, saturation)
    return red, green, blue


def _contrast(one: RGB, other: RGB) -> float:
    """Ratio of the luminances of two colours, from 1 to 21 (WCAG 2.1)."""
    high, low = sorted((_luminance(one), _luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def _luminance(colour: RGB) -> float:
    linear = [x / 12.92 if x <= 0.03928 else ((x + 0.055) / 1.055) ** 2.4 for x in colour]
    return sum(w * x for w, x in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


__all__ = ["LEGEND", "apply_theme", "background", "readable"]
