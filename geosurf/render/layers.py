"""What a picture is made of, before anything is drawn.

Layers hold world coordinates in float64 and know nothing of VTK; so what is
shown, in which colour, can be decided and tested without drawing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from geosurf.conventions import counted, is_number
from geosurf.errors import InputError
from geosurf.model import Curves, Lattice, Patches, TriSurface, Unit, Units
from geosurf.model.expected import expect, listed
from geosurf.render import palette
from geosurf.render.clip import Prism
from geosurf.render.views import corners

# More triangles than a screen has pixels show nothing more.
MAX_TRIANGLE = 1_000_000
MAX_RIMMED = 200_000
# corners of a box are numbered by their sides, in binary: two make an edge if one side differs
BOX_EDGES = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]
CREASE = math.cos(math.radians(50.0))


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
    """

    points: np.ndarray
    triangles: np.ndarray | None = None
    lines: Sequence[np.ndarray] | np.ndarray = ()
    colour: palette.RGB = palette.INK
    opacity: float = 1.0
    width: float = 1.0
    sharp: bool = False


LABEL_ROOM, DETAIL_ROOM = 21, 34  # letters that fit into the lines of the legend


@dataclass(frozen=True)
class Entry:
    """A line of the legend; `kind` is ``"area"``, ``"line"``, ``"dashes"`` or ``"heading"``.

    An area with `stripes` has stripes of that colour.
    """

    label: str
    colour: palette.RGB = palette.INK
    detail: str = ""
    kind: str = "area"
    opacity: float = 1.0
    stripes: palette.RGB | None = None


@dataclass(frozen=True, eq=False)
class Content:
    """Layers with the legend that explains them."""

    layers: tuple[Layer, ...] = ()
    legend: tuple[Entry, ...] = field(default=())

    def __add__(self, other: Content) -> Content:
        return Content(self.layers + other.layers, self.legend + other.legend)

    def moved(self, shift: np.ndarray) -> Content:
        """Return the same content, shifted by a vector [m]."""
        return replace(
            self, layers=tuple(replace(layer, points=layer.points + shift) for layer in self.layers)
        )


def triangle_layer(points: np.ndarray, triangles: np.ndarray, **look: Any) -> Layer:
    """Return a layer of triangles that holds no point but theirs."""
    used = np.zeros(len(points), dtype=bool)
    used[triangles] = True
    number = np.cumsum(used) - 1
    return Layer(points[used], number[triangles], **look)


def thinned(surface: TriSurface, max_triangle: int = MAX_TRIANGLE) -> TriSurface:
    """Return a surface that is light enough to draw.

    A gridded surface with more than `max_triangle` triangles is strided, and its own
    triangle list is never made; one without a lattice is returned as it is.

    Parameters
    ----------
    surface : TriSurface
    max_triangle : int

    Returns
    -------
    TriSurface
    """
    lattice = surface.lattice
    if lattice is None:
        return surface
    n_row, n_col = lattice.shape
    stride = math.ceil(math.sqrt(2.0 * n_row * n_col / max_triangle))
    if stride <= 1:
        return surface
    rows, columns = _strided(n_row, stride), _strided(n_col, stride)
    if lattice.easting.ndim == 1:
        easting, northing = lattice.easting[columns], lattice.northing[rows]
    else:
        nodes = np.ix_(rows, columns)
        easting, northing = lattice.easting[nodes], lattice.northing[nodes]
    elevation = lattice.elevation[np.ix_(rows, columns)]
    coarse = Lattice(easting, northing, elevation, lattice.rising, lattice.reverse)
    return TriSurface(surface.name, surface.role, lattice=coarse)


def _strided(n: int, stride: int) -> np.ndarray:
    """Every `stride`-th row and always the last, so that the border stays."""
    rows = np.arange(0, n, stride)
    return rows if rows[-1] == n - 1 else np.append(rows, n - 1)


def show_surfaces(surfaces: Iterable[TriSurface], within: Prism | None = None) -> Content:
    """Return horizons in stratigraphic colours and faults as glass.

    Horizons are coloured in the order in which they come: youngest first. With `within`, only
    what lies there is shown.
    """
    layers, legend = [], []
    n_horizon = n_fault = 0
    how = "Scene.surfaces has some"
    for surface in listed(surfaces, "surfaces are a list of TriSurface", how):
        expect(surface, TriSurface, "surfaces are a list of TriSurface", how)
        colour, opacity = palette.WALL, 0.25
        if surface.role == "fault":
            colour, opacity = palette.fault(n_fault), 0.55
            n_fault += 1
        elif surface.role != "wall":
            colour, opacity = palette.stratum(n_horizon), 1.0
            n_horizon += 1
        light = thinned(surface)
        shown = _surface_layers(light, within, colour, opacity)
        layers += shown
        detail = surface.role
        if light.n_triangle and not shown:
            detail += ", outside the model"
        legend.append(Entry(surface.name, colour, detail, opacity=opacity))
    return Content(tuple(layers), tuple(legend))


def _surface_layers(surface: TriSurface, within: Prism | None, colour, opacity) -> list[Layer]:
    """Triangles and rim of a surface, of what is shown of it."""
    points, triangles = surface.vertices, surface.triangles
    walls = np.empty((0, 2), dtype=np.int64)
    edges = rim(triangles) if len(triangles) <= MAX_RIMMED else walls
    ends = points[edges]
    if within is not None and len(triangles):
        ends = within.segments(points, edges)
        points, triangles, walls = within.triangles(points, triangles)
    if not len(triangles):
        return []
    layers = [triangle_layer(points, triangles, colour=colour, opacity=opacity)]
    ends = np.concatenate([ends, points[walls]])
    if len(ends) > 0 and len(triangles) <= MAX_RIMMED:
        # a fault seen edge-on would not be seen at all
        ink = palette.shade(colour, 1, 2)
        layers.append(segment_layer(ends, colour=ink, width=1.2))
    return layers


def segment_layer(ends: np.ndarray, **look: Any) -> Layer:
    """Return a layer of lines from their ends (n, 2, 3)."""
    lines = np.arange(2 * len(ends)).reshape(-1, 2)
    return Layer(ends.reshape(-1, 3), lines=lines, **look)


def rim(triangles: np.ndarray) -> np.ndarray:
    """Return the edges (n_edge, 2) that belong to one triangle only."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    return unique[count == 1]


def show_curves(
    curves: Curves,
    colour: palette.RGB = palette.CURVE,
    width: float = 2.8,
    between: set[str] | None = None,
    within: Prism | None = None,
) -> Content:
    """Return the curves as bold lines, with their number and length in the legend.

    With `between`, only those of the two surfaces of these names; with `within`, only what of
    them lies there.
    """
    expect(curves, Curves, "curves takes Curves", "scene.curves and intersect_surfaces are some")
    names = [{curves.names[i] for i in pair} for pair in curves.surfaces_of_curve.tolist()]
    rows = [i for i, pair in enumerate(names) if between is None or pair == between]
    if not rows:
        return Content()
    layer, lengths = _curve_layer(curves, rows, within, colour=colour, width=width)
    if not len(lengths):
        return Content()
    detail = f"{counted(len(lengths), 'curve')}, {length_text(float(np.sum(lengths)))}"
    return Content((layer,), (Entry("Intersections", colour, detail, "line"),))


def _curve_layer(curves: Curves, rows, within: Prism | None, **look: Any) -> tuple[Layer, Any]:
    """The layer of some curves, and the length of each that is shown [m]."""
    if within is None or within.holds(curves.points):
        lines = tuple(curves.curves[i] for i in rows)
        return Layer(curves.points, lines=lines, **look), curves.length_of_curve[rows]
    parts, lengths = [np.empty((0, 2, 3))], []
    for i in rows:
        line = curves.curves[i]
        ends = within.segments(curves.points, np.stack([line[:-1], line[1:]], axis=1))
        if len(ends):
            parts.append(ends)
            lengths.append(float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()))
    return segment_layer(np.concatenate(parts), **look), lengths


def show_box(
    bounds: tuple[float, ...],
    towards: np.ndarray | None = None,
    colour: palette.RGB = palette.FRAME,
    width: float = 1.0,
) -> Content:
    """Return the edges of a box as thin lines, without those in front of the model.

    Parameters
    ----------
    bounds : (west, east, south, north, bottom, top)
        [m].
    towards : ndarray of float64, shape (3,), optional
        Where the eye is; the edges at the nearest corner are left out.
    colour, width
        Of the lines.
    """
    box = corners(bounds)
    edges = BOX_EDGES
    if towards is not None and (np.abs(towards) > 1e-9).all():
        nearest = (towards > 0.0) @ (4, 2, 1)
        edges = [edge for edge in edges if nearest not in edge]
    return Content((Layer(box, lines=np.array(edges), colour=colour, width=width),))


def show_outline(ring: np.ndarray, level: float) -> Content:
    """Return the rim (n, 2) of an area of interest at a level, as a thin line."""
    points = np.column_stack([ring, np.full(len(ring), level)])
    there = np.arange(len(ring))
    lines = np.stack([there, np.roll(there, -1)], axis=1)
    look = {"colour": palette.FAINT, "width": 1.2}
    return Content(
        (Layer(points, lines=lines, **look),),
        (Entry("Area of interest", kind="line", colour=palette.FAINT),),
    )


def show_units(units: Units, explode: float = 0.0) -> Content:
    """Return the shells of units, one colour per zone and one shade per block.

    Parameters
    ----------
    units : Units
    explode : float
        How far units are drawn apart, as a part of the size of the model box: zones
        upwards by their thickness, blocks sideways from the middle.
    """
    shades = _shades(list(units.values()))
    content = Content()
    for unit, shift in zip(units.values(), explosion(units, explode), strict=True):
        colour = shades[unit.name]
        shell = Layer(unit.vertices, unit.triangles, colour=colour, sharp=True)
        rims = Layer(unit.vertices, lines=outline(unit), colour=palette.INK, width=0.9)
        entry = Entry(**_words_of(unit), colour=colour)
        content += Content((shell, rims), (entry,)).moved(shift)
    return content


def _words_of(unit: Unit) -> dict[str, str]:
    """Both lines of the legend: names that are too long for one give the second their end."""
    volume = volume_text(unit.volume)
    end = unit.name[len(unit.zone) :].strip()
    if len(unit.name) <= LABEL_ROOM or not end:
        return {"label": unit.name, "detail": volume}
    return {"label": unit.zone, "detail": f"{end}, {volume}"}


def show_patches(patches: Patches, within: Prism | None = None) -> Content:
    """Return the patches of all surfaces, neighbours in different shades, and their curves.

    With `within`, only what of them lies there.
    """
    content = Content()
    n_horizon = n_fault = 0
    for i, source in enumerate(patches.sources):
        fault = source.role == "fault"
        colour = palette.fault(n_fault) if fault else palette.stratum(n_horizon)
        n_fault, n_horizon = n_fault + fault, n_horizon + (not fault)
        opacity = 0.25 if source.role == "wall" else 0.55 if fault else 1.0
        of_surface = patches.surface_of_triangle == i
        rows = np.unique(patches.patch_of_triangle[of_surface])
        layers = []
        for k, row in enumerate(rows):
            points = patches.vertices
            triangles = patches.triangles[of_surface & (patches.patch_of_triangle == row)]
            if within is not None:
                points, triangles, _ = within.triangles(points, triangles)
            if len(triangles):
                look = {"colour": palette.shade(colour, k, len(rows)), "opacity": opacity}
                layers.append(triangle_layer(points, triangles, **look))
        entry = Entry(source.name, colour, counted(len(layers), "patch"), opacity=opacity)
        content += Content(tuple(layers), (entry,))
    edges = patches.curve_edges
    if len(edges):
        ends = (
            patches.vertices[edges] if within is None else within.segments(patches.vertices, edges)
        )
        content += Content((segment_layer(ends, colour=palette.CURVE, width=2.0),))
    return content


def _shades(units: list[Unit]) -> dict[str, palette.RGB]:
    blocks_of_zone: dict[int, list[str]] = {}
    for unit in units:
        blocks_of_zone.setdefault(unit.zone_index, []).append(unit.name)
    return {
        name: palette.shade(palette.stratum(zone), i, len(names))
        for zone, names in blocks_of_zone.items()
        for i, name in enumerate(names)
    }


def explosion(units: Units, explode: float) -> list[np.ndarray]:
    """Return the shift (3,) [m] of each unit in an exploded view.

    Zones move up and down: a step of `explode` times the height of the model box for each
    zone, the middle one stays. Units of one block move together: away from the middle
    of the model, by `explode` times the distance to the middle of the block.
    """
    if not (is_number(explode) and explode >= 0):
        raise InputError(
            f"units are to be drawn {explode!r} apart; give a part of the size of the box, 0 or "
            "more."
        )
    west, east, south, north, bottom, top = units.box
    middle = np.array([west + east, south + north]) / 2.0
    zones = sorted({unit.zone_index for unit in units.values()})
    centres: dict[str, list[np.ndarray]] = {}
    for unit in units.values():
        low, high = unit.vertices.min(axis=0), unit.vertices.max(axis=0)
        centres.setdefault(unit.block, []).append((low + high)[:2] / 2.0)
    shifts = []
    for unit in units.values():
        aside = explode * (np.mean(centres[unit.block], axis=0) - middle)
        step = (len(zones) - 1) / 2.0 - zones.index(unit.zone_index)
        shifts.append(np.array([*aside, explode * (top - bottom) * step]))
    return shifts


def outline(unit: Unit) -> np.ndarray:
    """Return the edges (n_edge, 2) of a shell between two surfaces, or where it turns sharply."""
    faces = unit.triangles
    p = unit.local[faces]
    normals = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, size, out=np.zeros_like(normals), where=size > 0.0)
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    face_of_edge = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, face_of_edge = edges[order], face_of_edge[order]
    twins = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    one, two = face_of_edge[twins], face_of_edge[twins + 1]
    turns = unit.surface_of_triangle[one] != unit.surface_of_triangle[two]
    flat = size[one, 0] * size[two, 0] == 0.0
    sharp = ~flat & ((normals[one] * normals[two]).sum(axis=1) < CREASE)
    return edges[twins[turns | sharp]]


def length_text(metres: float) -> str:
    """Return a length as people write it.

    Examples
    --------
    >>> length_text(12_345.0), length_text(820.0)
    ('12.3 km', '820 m')
    """
    return f"{metres / 1000.0:.3g} km" if metres >= 1000.0 else f"{metres:.3g} m"


def volume_text(cubic_metres: float) -> str:
    """Return a volume as reservoir people write it: in millions of cubic metres.

    Examples
    --------
    >>> volume_text(1.234e9), volume_text(5.6e6), volume_text(1200.0)
    ('1,234 Mm³', '5.6 Mm³', '1,200 m³')
    """
    if abs(cubic_metres) < 1e5:
        return f"{cubic_metres:,.0f} m³"
    millions = cubic_metres / 1e6
    return f"{millions:,.0f} Mm³" if millions >= 100.0 else f"{millions:.3g} Mm³"
