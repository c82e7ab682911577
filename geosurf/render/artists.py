"""What pictures consist of: names of matplotlib, imported for the first picture; their options."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from geosurf.conventions.palette import RGB
from geosurf.lazy import lazily

if TYPE_CHECKING:  # pragma: no cover - the same names for type checkers
    from matplotlib import colormaps as colormaps
    from matplotlib import rc_context as rc_context
    from matplotlib.artist import Artist as Artist
    from matplotlib.axes import Axes as Axes
    from matplotlib.axis import Axis as Axis
    from matplotlib.backends.backend_agg import FigureCanvasAgg as FigureCanvasAgg
    from matplotlib.backends.backend_agg import RendererAgg as RendererAgg
    from matplotlib.cm import ScalarMappable as ScalarMappable
    from matplotlib.collections import LineCollection as LineCollection
    from matplotlib.collections import PolyCollection as PolyCollection
    from matplotlib.collections import QuadMesh as QuadMesh
    from matplotlib.colors import BoundaryNorm as BoundaryNorm
    from matplotlib.colors import Colormap as Colormap
    from matplotlib.colors import LinearSegmentedColormap as LinearSegmentedColormap
    from matplotlib.colors import get_named_colors_mapping as get_named_colors_mapping
    from matplotlib.colors import to_hex as to_hex
    from matplotlib.colors import to_rgb as to_rgb
    from matplotlib.colors import to_rgba as to_rgba
    from matplotlib.contour import ContourSet as ContourSet
    from matplotlib.figure import Figure as Figure
    from matplotlib.font_manager import FontProperties as FontProperties
    from matplotlib.font_manager import findfont as findfont
    from matplotlib.font_manager import fontManager as fontManager
    from matplotlib.font_manager import get_font as get_font
    from matplotlib.lines import Line2D as Line2D
    from matplotlib.patches import Circle as Circle
    from matplotlib.patches import Patch as Patch
    from matplotlib.patches import PathPatch as PathPatch
    from matplotlib.patches import Polygon as Polygon
    from matplotlib.patches import Rectangle as Rectangle
    from matplotlib.path import Path as Path
    from matplotlib.patheffects import AbstractPathEffect as AbstractPathEffect
    from matplotlib.patheffects import withStroke as withStroke
    from matplotlib.text import Annotation as Annotation
    from matplotlib.text import Text as Text
    from matplotlib.tri import Triangulation as Triangulation
else:
    __getattr__, __all__ = lazily(__name__)

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
