"""What pictures look like: theme, font, colours by name, colour map; checked when it is made."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean, is_word
from geosurf.conventions.packages import need_plots
from geosurf.errors import InputError
from geosurf.model.expected import flag_of
from geosurf.render import palette
from geosurf.render.palette import RGB

FONT = "DejaVu Sans"  # matplotlib ships it, so pictures do not depend on the machine
THEMES = ("light", "dark")
COLOUR_BY = ("unit", "zone", "block", "contact", "z")  # of units in exploded views
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

    def __post_init__(self) -> None:
        if not is_word(self.theme, THEMES):
            raise InputError(
                f"theme is {self.theme!r}, expected 'light' or 'dark'."
                f"{did_you_mean(self.theme, THEMES)}"
            )
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
        import matplotlib
        from matplotlib.colors import to_hex

        found = matplotlib.colormaps[self.colour_map]
        return tuple(to_hex(found(x)) for x in np.linspace(0.0, 1.0, N_COLOUR))


def style_of(style: Any) -> PictureStyle:
    """Return the style, or the plain one for None.

    Raises
    ------
    InputError
        For anything else.
    """
    if style is None:
        return PLAIN
    if not isinstance(style, PictureStyle):
        raise InputError(
            f"style is a {type(style).__name__}, expected a PictureStyle. "
            "Pass gs.PictureStyle(theme='dark')."
        )
    return style


def _colours_of(colours: Any) -> dict[str, RGB]:
    """Colours by name as numbers."""
    how = "Give a mapping such as {'Top': '#1f77b4'}"
    if not isinstance(colours, Mapping):
        raise InputError(f"colours is a {type(colours).__name__}, expected a mapping. {how}.")
    found = {}
    for name, colour in colours.items():
        if not isinstance(name, str):
            raise InputError(f"colours has the key {name!r}, which is not a name. {how}.")
        found[name] = colour_of(colour, f"the colour of {name!r}")
    return found


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
    from matplotlib.colors import get_named_colors_mapping, to_rgb

    # numbers as text are shades of grey to matplotlib, and hardly ever meant
    usable = isinstance(colour, str | tuple | list | np.ndarray)
    if usable and not (isinstance(colour, str) and not colour.strip("0123456789.")):
        try:
            red, green, blue = to_rgb(colour)
            return float(red), float(green), float(blue)
        except (ValueError, TypeError):
            pass
    guess = did_you_mean(colour, get_named_colors_mapping()) if isinstance(colour, str) else ""
    raise InputError(
        f"{what} is {colour!r}, expected '#rrggbb', a colour name of matplotlib, or three numbers "
        f"from 0 to 1.{guess}"
    )


def _check_font(font: Any) -> None:
    """Refuse a font that is not installed."""
    need_plots()
    from matplotlib.font_manager import fontManager

    known = sorted({entry.name for entry in fontManager.ttflist})
    if not is_word(font, known):
        guess = did_you_mean(font, known) if isinstance(font, str) else ""
        raise InputError(
            f"font {font!r} is not installed. Install it, or name one of the {len(known)} fonts "
            f"that matplotlib finds.{guess}"
        )


def _check_map(name: Any) -> None:
    """Refuse an unknown colour map."""
    need_plots()
    import matplotlib

    known = (*OWN_MAPS, *matplotlib.colormaps)
    if not is_word(name, known):
        guess = did_you_mean(name, known) if isinstance(name, str) else ""
        raise InputError(
            f"colour_map is {name!r}, expected 'elevation', 'thickness' or a colour map of "
            f"matplotlib such as 'viridis'.{guess}"
        )


PLAIN = PictureStyle()  # at the end: it is checked by the functions above

__all__ = ["COLOUR_BY", "FONT", "PLAIN", "THEMES", "PictureStyle", "colour_of", "style_of"]
