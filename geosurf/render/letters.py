"""Letters that the fonts of a picture lack, and scripts that matplotlib cannot lay out."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING

from geosurf.errors import GeosurfWarning
from geosurf.warning import warn

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure
    from matplotlib.text import Text

MISSING = "\N{REPLACEMENT CHARACTER}"  # for letters that the font lacks
RIGHT = ("R", "AL")  # classes of letters that run from right to left (Unicode, annex 9)


@cache
def _letters(fonts: tuple[str, ...]) -> frozenset[int]:
    """Code points that the fonts of a picture have together."""
    from matplotlib.font_manager import FontProperties, findfont, get_font

    found = (findfont(FontProperties(family=[font])) for font in fonts)
    return frozenset().union(*(get_font(path).get_charmap() for path in found))


def _texts_of(artist: Artist) -> Iterator[Text]:
    """All texts in an artist that are drawn; `findobj` would make the ticks of hidden axes."""
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.text import Text

    hidden = isinstance(artist, Axes) and not artist.axison
    for child in artist.get_children():
        if not (hidden and isinstance(child, Axis)):
            yield from _texts_of(child)
    if isinstance(artist, Text):
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
        warn(
            GeosurfWarning(
                "picture",
                "script",
                "Arabic and Hebrew names are drawn from left to right, with letters apart: this "
                "version of matplotlib cannot do otherwise.",
                "Install matplotlib 3.11 or newer; reports and files have the names as they are.",
            )
        )
    if missing:
        some = ", ".join(repr(letter) for letter in list(missing)[:5])
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        note = GeosurfWarning(
            "picture",
            "letters",
            f"Pictures show a replacement sign for letters that their font lacks: {some}{more}.",
            _remedy(missing),
        )
        warn(note)


def _joins_letters() -> bool:
    """Whether matplotlib lays out scripts that join letters or run from right to left."""
    from matplotlib import ft2font

    return hasattr(ft2font, "__libraqm_version__")


def _remedy(letters: Iterable[str]) -> str:
    """Name an installed font that has all letters; else say which kind to install."""
    from matplotlib.font_manager import fontManager, get_font

    wanted = set(map(ord, letters))
    for entry in sorted(fontManager.ttflist, key=lambda entry: entry.name):
        # the font of last resort draws a box with the code of the letter
        if "Last Resort" not in entry.name and wanted <= get_font(entry.fname).get_charmap().keys():
            return f"Set PictureStyle(font={entry.name!r}), which has them."
    return (
        "Install a font that has them, such as Noto Sans of that script, and set "
        "PictureStyle(font=...); or rename the surfaces. Reports and files have all letters."
    )
