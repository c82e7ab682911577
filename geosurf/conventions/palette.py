"""Colours of zones and faults, for pictures and for files that store colours.

All colours are sRGB triples from 0 to 1. They are distinct in print and for colour-blind readers.
"""

from __future__ import annotations

import colorsys
from collections.abc import Iterable

from geosurf.conventions.text import grouped

RGB = tuple[float, float, float]


def rgb(code: str) -> RGB:
    """Return ``"#rrggbb"`` as three numbers in 0 to 1.

    Examples
    --------
    >>> rgb("#ff0000")
    (1.0, 0.0, 0.0)
    """
    red, green, blue = (int(code[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return red, green, blue


def hex_code(colour: Iterable[float]) -> str:
    """Return a colour as ``"#rrggbb"``.

    Examples
    --------
    >>> hex_code((1.0, 0.0, 0.0))
    '#ff0000'
    """
    return "#" + "".join(f"{round(255 * value):02x}" for value in colour)


# Neighbours in the column differ in lightness as well as in hue.
STRATA = tuple(
    rgb(code)
    for code in (
        "#e9d8ae",  # sand
        "#6f8f57",  # sage
        "#d69a4e",  # ochre
        "#4f7393",  # grey-blue
        "#e0bd6a",  # straw
        "#40594f",  # slate green
        "#c9b9b4",  # mudstone
        "#8f4a35",  # red bed
        "#b4cfda",  # limestone
        "#55505f",  # shale
    )
)

# Each colour of the column, then its shades for three blocks and more. Any two in a row, and any
# two in rows next to each other, differ for colour-blind readers, too.
SHADES = tuple(
    tuple(map(rgb, row.split()))
    for row in (
        "#e9d8ae #f5e9cb #d5caae #d3c091 #f9ebb2 #e0d08e #ead8cb #c7af93",
        "#6f8f57 #66813c #7c9d72 #64825a #5a743f #95a56a #516a49 #465e2c",
        "#d69a4e #c08e50 #e49c40 #eab36d #c4812d #fab55d #ab7128 #e2b680",
        "#4f7393 #5383ae #415e78 #64879d #5a707e #425c8c #759cbe #405a65",
        "#e0bd6a #ccaf6a #ecc25e #fed87f #c2a94b #f1d38c #d6bf88 #d5a737",
        "#40594f #556d5c #2a4638 #51716e #1f332e #678478 #518561 #6b9490",
        "#c9b9b4 #e2d1ce #b2a2a3 #c3b19c #ab988a #eeeceb #ac9376 #a87d6f",
        "#8f4a35 #9f594e #79382d #a55f3d #7a3717 #8c491a #8b4448 #692013",
        "#b4cfda #9eb9bd #d1e7f0 #a2bed8 #8ca9bb #92a0a0 #84b0d7 #6998b5",
        "#55505f #6a6573 #403c4a #636280 #302c32 #7a7992 #7a797d #908c9e",
    )
)
FAULTS = tuple(map(rgb, [
    "#8c2f2b", "#4a3f63", "#d9843b", "#a9a3d0", "#c8a27a", "#3f7d6e", "#4040bf", "#c6a9ae",
    "#7979d2", "#592d86",
]))  # fmt: skip


def stratum(index: int) -> RGB:
    """Return the colour of a horizon or zone, counted down from the youngest."""
    return STRATA[index % len(STRATA)]


def fault(index: int) -> RGB:
    """Return the colour of a fault."""
    return FAULTS[index % len(FAULTS)]


def shade(colour: RGB, step: int, n_step: int) -> RGB:
    """Return one of `n_step` shades of a colour, from lighter to darker.

    Examples
    --------
    >>> shade((0.5, 0.25, 0.25), 0, 1)
    (0.5, 0.25, 0.25)
    """
    if n_step < 2:
        return colour

    # lightness changes, hue stays: never by more than to white or black
    place = 1.0 - 2.0 * step / (n_step - 1)  # 1 for the lightest, -1 for the darkest
    hue, lightness, saturation = colorsys.rgb_to_hls(*colour)
    room = min(1.0 - lightness, lightness, 0.085)
    return colorsys.hls_to_rgb(hue, lightness + place * room, saturation)


def unit_colours(units: Iterable[tuple[str, int]]) -> dict[str, RGB]:
    """Return a colour for each unit: one for each zone, whose blocks take shades of it.

    Parameters
    ----------
    units : iterable of (str, int)
        Name and row of the zone of each unit; units with one name have one colour.

    Examples
    --------
    >>> found = unit_colours([("Top/Base F1+", 1), ("Top/Base F1-", 1), ("below Base", 2)])
    >>> found["below Base"] == stratum(2)
    True
    """
    return {
        name: _block_colour(zone, i, len(names))
        for zone, names in grouped((zone, name) for name, zone in dict.fromkeys(units)).items()
        for i, name in enumerate(names)
    }


def _block_colour(zone: int, block: int, n_block: int) -> RGB:
    """Return the colour of one of the blocks of a zone."""
    if n_block < 3:
        return shade(stratum(zone), block, n_block)

    # where the shades are used up they begin again, a little darker each time
    shades = SHADES[zone % len(SHADES)]
    turn, n_turn = block // len(shades), -(-n_block // len(shades))
    return shade(shades[block % len(shades)], turn, n_turn)


# Of pictures.
INK = rgb("#26292e")
FAINT = rgb("#5b626d")  # of text, too: contrast 6.2 on white
PAPER = (1.0, 1.0, 1.0)
CURVE = rgb("#111111")
CONTACT = rgb("#1539b8")
CLOSURE = rgb("#0b5d2e")
FLUIDS = {"oil": rgb("#1f9e4b"), "gas": rgb("#d4342c"), "": rgb("#7b4fa3")}  # on maps
ACCENT = rgb("#c8102e")
FRAME = rgb("#9aa0a8")
VOXEL = rgb("#3b6ea5")

WALL = rgb("#d4d7db")

# Elevation in map view, low to high.
ELEVATION = ("#2f4858", "#4a7285", "#7ea3a5", "#b9c9a9", "#e6dba8", "#dfb76c", "#bf8145", "#8a4b2f")
# Thickness, thin to thick: darker is thicker, also in print and for colour-blind readers.
THICKNESS = ("#f7f0cf", "#dbe3b0", "#b2d2aa", "#84bcab", "#5fa2ab", "#4886a3", "#3b6a96")
