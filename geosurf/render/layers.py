"""Choose what a picture shows: layers of triangles and lines with their legend.

Layers have world coordinates in float64 and do not depend on VTK, so tests can check the
content and the colours of a picture without drawing it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Unpack

import numpy as np

from geosurf.render import palette
from geosurf.render.palette import LayerStyle
from geosurf.render.views import corners

# corners of a box are numbered by their sides, in binary: two make an edge if one side differs
BOX_EDGES = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]


@dataclass(frozen=True, eq=False)
class Layer:
    """Triangles or lines in one colour.

    Attributes
    ----------
    points : ndarray of float64, shape (n_point, 3)
        World coordinates [m].
    triangles : ndarray of int64, shape (n_triangle, 3), or None
    lines : sequence of ndarray of int64
        Rows of `points`, in order; an array (n_line, 2) for single edges.
    colour : (red, green, blue)
    opacity : float
    width : float
        Of lines, in pixels.
    sharp : bool
        Whether creases between triangles stay sharp.
    shades : ndarray of float64, shape (n_point, 3), or None
        A colour for each point, in place of `colour`.
    dots : bool
        Whether points are drawn as dots that are `width` pixels wide.
    """

    points: np.ndarray
    triangles: np.ndarray | None = None
    lines: Sequence[np.ndarray] | np.ndarray = ()
    colour: palette.RGB = palette.INK
    opacity: float = 1.0
    width: float = 1.0
    sharp: bool = False
    shades: np.ndarray | None = None
    dots: bool = False


LABEL_ROOM, DETAIL_ROOM = 21, 34  # characters that fit into a line of the legend


@dataclass(frozen=True)
class Entry:
    """An entry of the legend; `kind` is ``"area"``, ``"line"``, ``"dashes"``, ``"circle"`` or
    ``"heading"``.

    An area with `stripes` has stripes of that colour.
    """

    label: str
    colour: palette.RGB = palette.INK
    detail: str = ""
    kind: str = "area"
    opacity: float = 1.0
    stripes: palette.RGB | None = None


@dataclass(frozen=True)
class Bar:
    """A colour bar: what it measures, its colours from low to high, and its round values."""

    words: str
    codes: tuple[str, ...]
    levels: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Content:
    """Layers, their legend, names at points of the world (easting, northing, elevation), a bar."""

    layers: tuple[Layer, ...] = ()
    legend: tuple[Entry, ...] = field(default=())
    names: tuple[tuple[str, tuple[float, float, float]], ...] = ()
    bar: Bar | None = None

    def __add__(self, other: Content) -> Content:
        return Content(
            self.layers + other.layers,
            self.legend + other.legend,
            self.names + other.names,
            self.bar or other.bar,
        )

    def moved(self, shift: np.ndarray) -> Content:
        """Return the content shifted by a vector [m]."""
        return replace(
            self, layers=tuple(replace(layer, points=layer.points + shift) for layer in self.layers)
        )


def triangle_layer(points: np.ndarray, triangles: np.ndarray, **look: Unpack[LayerStyle]) -> Layer:
    """Return a layer of triangles without unused points."""
    # number (n_point,): new row of each point that a triangle uses
    used = np.zeros(len(points), dtype=bool)
    used[triangles] = True
    number = np.cumsum(used) - 1
    return Layer(points[used], number[triangles], **look)


def segment_layer(ends: np.ndarray, **look: Unpack[LayerStyle]) -> Layer:
    """Return a layer of lines from their ends (n, 2, 3)."""
    # each segment has two points of its own: rows 2 i and 2 i + 1
    lines = np.arange(2 * len(ends)).reshape(-1, 2)
    return Layer(ends.reshape(-1, 3), lines=lines, **look)


def show_box(
    bounds: tuple[float, ...],
    towards: np.ndarray | None = None,
    colour: palette.RGB = palette.FRAME,
    width: float = 1.0,
) -> Content:
    """Return the edges of a box as thin lines, except those in front of the model.

    Parameters
    ----------
    bounds : (west, east, south, north, bottom, top)
        [m].
    towards : ndarray of float64, shape (3,), optional
        Direction to the viewer; the edges at the nearest corner are left out.
    colour, width
        Of the lines.
    """
    box = corners(bounds)
    edges = BOX_EDGES
    if towards is not None and (np.abs(towards) > 1e-9).all():
        # the corner that is nearest to the viewer, by its binary number: its three edges would run
        # in front of the model
        nearest = (towards > 0.0) @ (4, 2, 1)
        edges = [edge for edge in edges if nearest not in edge]
    return Content((Layer(box, lines=np.array(edges), colour=colour, width=width),))


def show_outline(ring: np.ndarray, level: float) -> Content:
    """Return the outline (n, 2) of an area of interest at an elevation, as a thin line."""
    points = np.column_stack([ring, np.full(len(ring), level)])
    there = np.arange(len(ring))
    lines = np.stack([there, np.roll(there, -1)], axis=1)
    return Content(
        (Layer(points, lines=lines, colour=palette.FAINT, width=1.2),),
        (Entry("Area of interest", kind="line", colour=palette.FAINT),),
    )
