"""Colours of zones and faults, for pictures and for files that store colours.

All colours are sRGB triples from 0 to 1. They are distinct in print and for colour-blind readers.
"""

from __future__ import annotations

import colorsys
from collections.abc import Iterable

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
FAULTS = tuple(
    rgb(code) for code in ("#8c2f2b", "#4a3f63", "#d9843b", "#a9a3d0", "#c8a27a", "#3f7d6e")
)


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
        Name and row of the zone of each unit.

    Examples
    --------
    >>> found = unit_colours([("Top/Base F1+", 1), ("Top/Base F1-", 1), ("below Base", 2)])
    >>> found["below Base"] == stratum(2)
    True
    """
    blocks_of_zone: dict[int, list[str]] = {}
    for name, zone in units:
        blocks_of_zone.setdefault(zone, []).append(name)
    return {
        name: shade(stratum(zone), i, len(names))
        for zone, names in blocks_of_zone.items()
        for i, name in enumerate(names)
    }
