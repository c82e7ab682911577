"""Colours of zones, faults and maps: distinct in print and for colour-blind readers.

All colours are sRGB triples from 0 to 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from geosurf.conventions.colours import FAULTS as FAULTS
from geosurf.conventions.colours import RGB as RGB
from geosurf.conventions.colours import STRATA as STRATA
from geosurf.conventions.colours import fault as fault
from geosurf.conventions.colours import rgb as rgb
from geosurf.conventions.colours import shade as shade
from geosurf.conventions.colours import stratum as stratum

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.patheffects import AbstractPathEffect


# ---- styles ----------------------------------------
# How texts, lines, areas and layers of a picture may be styled: the options of each, by name.
#
# mypy checks them, so that a misspelt option is found before a picture is drawn.


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
