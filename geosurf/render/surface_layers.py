"""Choose how surfaces, patches and intersection lines are shown, clipped to the model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Unpack

import numpy as np

from geosurf.conventions import counted, length_text
from geosurf.model import Curves, Patches, TriSurface
from geosurf.model.expected import expect, listed
from geosurf.render import palette
from geosurf.render.clip import Prism
from geosurf.render.colouring import Selection, elevation_bar, shades_of
from geosurf.render.layers import Content, Entry, Layer, segment_layer, triangle_layer
from geosurf.render.palette import LayerStyle
from geosurf.render.picture_style import PLAIN, PictureStyle
from geosurf.render.thin_units import most_of_each, thinned
from geosurf.render.views import SIZE

MAX_RIMMED = 200_000
EVERYTHING = Selection()
OTHER_ROLES = ("fault", "wall", "virtual")


def show_surfaces(
    surfaces: Iterable[TriSurface],
    within: Prism | None = None,
    *,
    only: Selection = EVERYTHING,
    by_elevation: bool = False,
    style: PictureStyle = PLAIN,
    size: tuple[int, int] = SIZE,
    zoom: float = 1.0,
) -> Content:
    """Return horizons in the colours of the column and faults semi-transparent.

    Horizons take colours in the given order, youngest first. With `within`, only the part inside
    the model is shown. `only` selects surfaces by name, `by_elevation` colours horizons by z. Grids
    are thinned to what a picture of some size and zoom can show.
    """
    layers: list[Layer] = []
    legend: list[Entry] = []
    coloured: list[int] = []
    n_horizon = n_fault = 0
    how = "pass scene.surfaces"
    every = listed(surfaces, "surfaces must be a list of TriSurface", how)
    most = most_of_each(len(every), size, zoom)
    for surface in every:
        expect(surface, TriSurface, "surfaces must be a list of TriSurface", how)

        # faults and horizons count their colours apart, so that a fault more changes no horizon
        colour, opacity = palette.WALL, 0.25
        if surface.role == "fault":
            colour, opacity = palette.fault(n_fault), 0.55
            n_fault += 1
        elif surface.role not in ("wall", "virtual"):
            colour, opacity = palette.stratum(n_horizon), 1.0
            n_horizon += 1

        if not only.holds(surface.name):
            continue
        colour = style.colour(surface.name, colour)

        # triangles and rim inside the model; a surface outside of it stays in the legend
        light = thinned(surface, most)
        shown = _surface_layers(light, within, colour, opacity)
        if by_elevation and surface.role not in OTHER_ROLES:
            coloured += range(len(layers), len(layers) + len(shown))
        layers += shown
        detail = surface.role
        if light.n_triangle and not shown:
            detail += ", outside the model"
        legend.append(Entry(surface.name, colour, detail, opacity=opacity))
    content = Content(tuple(layers), tuple(legend))
    return _by_elevation(content, coloured, style) if coloured else content


def _by_elevation(content: Content, rows: list[int], style: PictureStyle) -> Content:
    """Colour the triangles of some layers by their elevation, with a colour bar."""
    # horizons have the same colour at the same elevation, so their names leave the legend
    mine = [content.layers[row] for row in rows if content.layers[row].triangles is not None]
    z = np.concatenate([layer.points[:, 2] for layer in mine])
    bar = elevation_bar(float(z.min()), float(z.max()), style)
    layers = tuple(
        replace(layer, shades=shades_of(bar, layer.points[:, 2]))
        if any(layer is one for one in mine)
        else layer
        for layer in content.layers
    )
    others = tuple(entry for entry in content.legend if entry.detail.startswith(OTHER_ROLES))
    return replace(content, layers=layers, legend=others, bar=bar)


def _surface_layers(
    surface: TriSurface, within: Prism | None, colour: palette.RGB, opacity: float
) -> list[Layer]:
    """Triangles and rim of the visible part of a surface."""
    # the rim is that of the whole surface: edges where it is clipped are walls'
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
        # without its rim, a fault seen edge-on would be invisible
        ink = palette.shade(colour, 1, 2)
        layers.append(segment_layer(ends, colour=ink, width=1.2))
    return layers


def rim(triangles: np.ndarray) -> np.ndarray:
    """Return the edges (n_edge, 2) that belong to one triangle only."""
    # one number for each edge by its ends, the smaller row first: neighbours have the same
    ends = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    n = int(triangles.max(initial=0)) + 1
    keys, count = np.unique(ends.min(axis=1) * n + ends.max(axis=1), return_counts=True)
    return np.stack(np.divmod(keys[count == 1], n), axis=1)


def show_patches(
    patches: Patches,
    within: Prism | None = None,
    *,
    only: Selection = EVERYTHING,
    style: PictureStyle = PLAIN,
) -> Content:
    """Return the patches of all surfaces in alternating shades, and their intersection lines.

    With `within`, only the parts inside the model.
    """
    content = Content()

    # colours as in `show_surfaces`: one surface looks the same in all pictures
    n_horizon = n_fault = 0
    for i, source in enumerate(patches.sources):
        fault = source.role == "fault"
        virtual = source.role == "virtual"
        colour = palette.fault(n_fault) if fault else palette.stratum(n_horizon)
        colour = palette.WALL if virtual else colour
        n_fault, n_horizon = n_fault + fault, n_horizon + (not fault and not virtual)
        opacity = 0.25 if virtual or source.role == "wall" else 0.55 if fault else 1.0

        if not only.holds(source.name):
            continue
        colour = style.colour(source.name, colour)

        # one layer for each patch of the surface, in shades of its colour
        of_surface = patches.surface_of_triangle == i
        rows = np.unique(patches.patch_of_triangle[of_surface])
        layers = []
        for k, row in enumerate(rows):
            points = patches.vertices
            triangles = patches.triangles[of_surface & (patches.patch_of_triangle == row)]
            if within is not None:
                points, triangles, _ = within.triangles(points, triangles)
            if len(triangles):
                tint = palette.shade(colour, k, len(rows))
                layers.append(triangle_layer(points, triangles, colour=tint, opacity=opacity))
        entry = Entry(source.name, colour, counted(len(layers), "patch"), opacity=opacity)
        content += Content(tuple(layers), (entry,))

    # edges along curves, over all surfaces
    edges = patches.curve_edges
    if len(edges):
        ends = (
            patches.vertices[edges] if within is None else within.segments(patches.vertices, edges)
        )
        content += Content((segment_layer(ends, colour=palette.CURVE, width=2.0),))
    return content


def show_curves(
    curves: Curves,
    colour: palette.RGB = palette.CURVE,
    width: float = 2.8,
    between: set[str] | None = None,
    within: Prism | None = None,
) -> Content:
    """Return intersection lines as bold lines, with their number and length in the legend.

    With `between`, only lines of the two named surfaces; with `within`, only the parts inside
    the model.
    """
    expect(
        curves,
        Curves,
        "curves must be Curves",
        "pass scene.curves",
    )

    # pairs of names; without an order, as in `between`
    names = [{curves.names[i] for i in pair} for pair in curves.surfaces_of_curve.tolist()]
    rows = [i for i, pair in enumerate(names) if between is None or pair == between]
    if not rows:
        return Content()
    layer, lengths = _curve_layer(curves, rows, within, colour=colour, width=width)
    if not len(lengths):
        return Content()
    detail = f"{counted(len(lengths), 'line')}, {length_text(float(np.sum(lengths)))}"
    return Content((layer,), (Entry("Intersection lines", colour, detail, "line"),))


def _curve_layer(
    curves: Curves, rows: list[int], within: Prism | None, **look: Unpack[LayerStyle]
) -> tuple[Layer, np.ndarray]:
    """The layer of some curves, and the length of each that is shown [m]."""
    if within is None or within.holds(curves.points):
        lines = tuple(curves.curves[i] for i in rows)
        return Layer(curves.points, lines=lines, **look), curves.length_of_curve[rows]

    # clipped curves fall into segments: lengths are those that are shown
    parts, lengths = [np.empty((0, 2, 3))], []
    for i in rows:
        line = curves.curves[i]
        ends = within.segments(curves.points, np.stack([line[:-1], line[1:]], axis=1))
        if len(ends):
            parts.append(ends)
            steps = ends[:, 1] - ends[:, 0]
            lengths.append(float(np.linalg.norm(steps, axis=1).sum()))
    return segment_layer(np.concatenate(parts), **look), np.array(lengths)
