"""What pictures look like: theme, font, colours by name, colour map; checked when it is made."""

from __future__ import annotations

import colorsys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import check_word, did_you_mean, palette
from geosurf.conventions.axes import VERTICAL
from geosurf.conventions.machine import need_plots
from geosurf.conventions.palette import RGB, rgb
from geosurf.errors import InputError
from geosurf.model.expected import expect, flag_of
from geosurf.render import artists

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# ---- theme ----------------------------------------
# Give a finished figure the background, text colours and fonts of a style.
#
# Pictures are drawn in the colours of the light theme. The dark one replaces the colours of the
# frame: text, axes, legend and arrows. Colours of data stay, so that a zone looks the same in both.
# Text of another colour is made lighter until it can be read.


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
    if style.font is not None:
        for text in figure.findobj(artists.Text):
            text.set_fontfamily(style.fonts)
    if style.dark:
        _darken(figure, frame)
    if style.transparent:
        figure.patch.set_alpha(0.0)
        for axes in figure.axes:
            axes.patch.set_alpha(0.0)


def _darken(figure: Figure, frame: Axes) -> None:
    """Replace the colours of the frame by those of the dark theme."""
    figure.set_facecolor(DARK_PAPER)
    on_data = {
        text for axes in figure.axes if axes is not frame for text in axes.texts
        if not (isinstance(text, artists.Annotation) or text.get_path_effects())
    }  # fmt: skip
    for text in figure.findobj(artists.Text):
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
    for line in frame.findobj(artists.Line2D):
        if line.get_gid() != LEGEND:
            line.set_color(_swapped(line.get_color()))
        if _contrast(artists.to_rgb(line.get_color()), DARK_PAPER) < SEEN:
            # a dark line keeps the colour that it has on the model, between light rims
            wide = line.get_linewidth() + 2.0 * RIM
            line.set_path_effects(
                [artists.withStroke(linewidth=wide, foreground=ROLES[palette.FAINT])]
            )
    for patch in frame.patches:
        if isinstance(patch, artists.Patch):
            patch.set_facecolor(_swapped(patch.get_facecolor()))
            patch.set_edgecolor(_swapped(patch.get_edgecolor()))


def _swapped(colour: Any) -> Any:
    """The dark counterpart of a colour of the frame; other colours as they are."""
    *solid, alpha = artists.to_rgba(colour)
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
    red, green, blue = artists.to_rgb(colour)
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


FONT = "DejaVu Sans"  # matplotlib ships it, so pictures do not depend on the machine
THEMES = ("light", "dark")
COLOUR_BY = ("unit", "zone", "region", "block", "contact", "z")  # of units in exploded views
OWN_MAPS = {"elevation": palette.ELEVATION, "thickness": palette.THICKNESS}
N_COLOUR = 32  # of a colour map of matplotlib, which is linear in between


@dataclass(frozen=True)
class PictureStyle:
    """The look of pictures, which all of them share.

    Parameters
    ----------
    theme : {"light", "dark"}
        Dark text on white, or light text on a dark background.
    transparent : bool
        Whether the background is transparent; text keeps the colour of the theme.
    font : str, optional
        An installed font, for names in scripts that the font of geosurf lacks, such as Chinese.
        Default: DejaVu Sans, which has Latin, Cyrillic, Greek and Arabic letters.
    colours : mapping of str to colour
        Colours of surfaces, zones and units by name: ``"#1f77b4"``, a name of matplotlib such as
        ``"teal"``, or three numbers from 0 to 1. Names that a picture does not show are ignored.
    colour_map : str, optional
        Of elevation, thickness and properties: a name of matplotlib such as ``"viridis"``,
        ``"elevation"`` or ``"thickness"``. Default: the map that suits the picture.
    vertical : {"elevation", "depth"}, optional
        What axes, contours and colour bars show. Default: depth where the scene was given
        ``positive="down"``.

    Raises
    ------
    InputError
        For an unknown theme, font, colour or colour map.
    DependencyError
        If matplotlib, which knows colours and fonts, is not installed.

    Examples
    --------
    >>> PictureStyle(theme="dark", colours={"Top": "teal"}).colours["Top"]
    (0.0, 0.5019607843137255, 0.5019607843137255)
    >>> PictureStyle(theme="drak")
    Traceback (most recent call last):
    geosurf.errors.InputError: theme is 'drak', expected 'light' or 'dark'. Did you mean 'dark'?
    """

    theme: str = "light"
    transparent: bool = False
    font: str | None = None
    colours: Mapping[str, RGB] = field(default_factory=dict)
    colour_map: str | None = None
    vertical: str | None = None

    def __post_init__(self) -> None:
        check_word(self.theme, THEMES, f"theme is {self.theme!r}, expected 'light' or 'dark'.")
        if self.vertical is not None:
            refusal = f"vertical is {self.vertical!r}, expected 'elevation' or 'depth'."
            check_word(self.vertical, VERTICAL[:2], refusal)
        # the words of a colour become numbers once, so that pictures need not look at them
        object.__setattr__(self, "transparent", flag_of(self.transparent, "transparent"))
        object.__setattr__(self, "colours", _colours_of(self.colours))
        if self.font is not None:
            _check_font(self.font)
        if self.colour_map is not None:
            _check_map(self.colour_map)

    @property
    def fonts(self) -> list[str]:
        """Fonts in the order in which letters are looked for."""
        return [FONT] if self.font in (None, FONT) else [str(self.font), FONT]

    @property
    def dark(self) -> bool:
        """Whether the background is dark."""
        return self.theme == "dark"

    def colour(self, names: str | Iterable[str], default: RGB) -> RGB:
        """Return the colour of the first name that has one."""
        names = (names,) if isinstance(names, str) else names
        return next((self.colours[name] for name in names if name in self.colours), default)

    def codes(self, default: tuple[str, ...]) -> tuple[str, ...]:
        """Return the colours of the colour map, low to high, as ``#rrggbb``."""
        if self.colour_map is None:
            return default
        if self.colour_map in OWN_MAPS:
            return OWN_MAPS[self.colour_map]
        need_plots()
        found = artists.colormaps[self.colour_map]
        return tuple(artists.to_hex(found(x)) for x in np.linspace(0.0, 1.0, N_COLOUR))


def style_of(style: Any) -> PictureStyle:
    """Return the style, or the plain one for None.

    Raises
    ------
    InputError
        For anything else.
    """
    if style is None:
        return PLAIN
    expect(
        style, PictureStyle, "style must be a PictureStyle", "pass gs.PictureStyle(theme='dark')"
    )
    made: PictureStyle = style
    return made


def _colours_of(colours: Any) -> dict[str, RGB]:
    """Colours by name as numbers."""
    how = "Give a mapping such as {'Top': '#1f77b4'}"
    if not isinstance(colours, Mapping):
        raise InputError(f"colours is a {type(colours).__name__}, expected a mapping. {how}.")
    by_name = {}
    for name, colour in colours.items():
        if not isinstance(name, str):
            raise InputError(f"colours has the key {name!r}, which is not a name. {how}.")
        by_name[name] = colour_of(colour, f"the colour of {name!r}")
    return by_name


def colour_of(colour: Any, what: str) -> RGB:
    """Return a colour as three numbers, or raise an error.

    Raises
    ------
    InputError
        If matplotlib does not know it.

    Examples
    --------
    >>> colour_of("white", "the background")
    (1.0, 1.0, 1.0)
    """
    need_plots()
    # numbers as text are shades of grey to matplotlib, and hardly ever meant
    usable = isinstance(colour, str | tuple | list | np.ndarray)
    if usable and not (isinstance(colour, str) and not colour.strip("0123456789.")):
        try:
            red, green, blue = artists.to_rgb(colour)
            return float(red), float(green), float(blue)
        except (ValueError, TypeError):
            pass
    guess = (
        did_you_mean(colour, artists.get_named_colors_mapping()) if isinstance(colour, str) else ""
    )
    raise InputError(
        f"{what} is {colour!r}, expected '#rrggbb', a colour name of matplotlib, or three numbers "
        f"from 0 to 1.{guess}"
    )


def _check_font(font: Any) -> None:
    """Refuse a font that is not installed."""
    need_plots()
    known = sorted({entry.name for entry in artists.fontManager.ttflist})
    check_word(
        font,
        known,
        f"font {font!r} is not installed. Install it, or name one of the {len(known)} fonts "
        "that matplotlib finds.",
    )


def _check_map(name: Any) -> None:
    """Refuse an unknown colour map."""
    need_plots()
    known = (*OWN_MAPS, *artists.colormaps)
    check_word(
        name,
        known,
        f"colour_map is {name!r}, expected 'elevation', 'thickness' or a colour map of "
        "matplotlib such as 'viridis'.",
    )


PLAIN = PictureStyle()  # at the end: it is checked by the functions above
