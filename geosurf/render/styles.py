"""How texts, lines, areas and layers of a picture may be styled: the options of each, by name.

mypy checks them, so that a misspelt option is found before a picture is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from geosurf.render.palette import RGB

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.patheffects import AbstractPathEffect

Colour = RGB | tuple[float, float, float, float] | str
Dashes = str | tuple[float, tuple[float, ...]]  # "solid", or an offset and lengths on and off
Spot = Sequence[float] | np.ndarray  # two coordinates: pixels, or metres of some axes


class TextStyle(TypedDict, total=False):
    """A text at a point: alignment, weight, rotation [degrees], and its rim."""

    ha: str
    va: str
    weight: str
    fontweight: str
    rotation: float
    rotation_mode: str
    path_effects: Sequence[AbstractPathEffect]
    parse_math: bool
    zorder: float


class LineStyle(TypedDict, total=False):
    """A line: its dashes."""

    linestyle: Dashes


class AreaStyle(TypedDict, total=False):
    """An area: fill, edge [points], and the pattern of its stripes."""

    facecolor: Colour
    edgecolor: Colour
    linewidth: float
    hatch: str


class LayerStyle(TypedDict, total=False):
    """A layer of triangles or lines: see `geosurf.render.layers.Layer`."""

    colour: RGB
    opacity: float
    width: float
    sharp: bool


__all__ = ["AreaStyle", "Colour", "Dashes", "LayerStyle", "LineStyle", "Spot", "TextStyle"]
