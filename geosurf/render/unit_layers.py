"""Choose how units are shown: colours, edges, legend, and the shifts of an exploded view."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import counted, is_number, volume_text
from geosurf.errors import InputError
from geosurf.kernels.meshes.mesh import edges, ends_of, number_keys
from geosurf.model import Units
from geosurf.render import palette
from geosurf.render.colouring import Selection, colour_units
from geosurf.render.layers import Content, Entry, Layer
from geosurf.render.picture_style import PLAIN, PictureStyle
from geosurf.render.thin_units import Shell, shells_to_draw

EVERYTHING = Selection()
CREASE = math.cos(math.radians(50.0))  # edges between triangles of a larger angle are drawn


def show_units(
    units: Units,
    explode: float = 0.0,
    *,
    only: Selection = EVERYTHING,
    colour_by: Any = "unit",
    style: PictureStyle = PLAIN,
) -> Content:
    """Return the shells of units, one colour per zone and one shade per block; slivers are grey.

    Parameters
    ----------
    units : Units
    explode : float
        Gap between units, as a fraction of the size of the model box. Zones move up and
        down, blocks move sideways from the centre.
    only : Selection
        Units that are shown, by their own name or that of their zone or block.
    colour_by, style
        As for `geosurf.render.colouring.colour_units`.
    """
    parts = [only.holds(unit.name, unit.zone, unit.block) for unit in units.values()]
    shown = [unit for unit, yes in zip(units.values(), parts, strict=True) if yes]
    colouring = colour_units(units, shown, colour_by, style)
    content = Content((), colouring.legend, bar=colouring.bar)
    drawn = zip(units.values(), shells_to_draw(units), explosion(units, explode), strict=True)
    for yes, (unit, shell_of_unit, shift) in zip(parts, drawn, strict=True):
        if not yes:
            continue
        colour = colouring.colours.get(unit.name, palette.FAINT)
        points = shell_of_unit.points
        apart = by_surface(shell_of_unit)
        shell = Layer(
            apart.points, apart.triangles, colour=colour, sharp=True,
            shades=colouring.shades(apart.points),
        )  # fmt: skip
        lines = outline(shell_of_unit)
        rims = Layer(points, lines=lines, colour=palette.INK, width=0.9)
        content += Content((shell, rims)).moved(shift)
    slivers = [unit for unit in units.slivers if unit.name in {one.name for one in shown}]
    if slivers:
        total = volume_text(math.fsum(one.volume for one in slivers))
        entry = Entry(counted(len(slivers), "sliver"), palette.FAINT, f"{total} in all")
        content += Content((), (entry,))
    return content


def explosion(units: Units, explode: float) -> list[np.ndarray]:
    """Return the shift (3,) [m] of each unit in an exploded view.

    Zones move up and down in steps of `explode` times the height of the model box; the middle
    zone stays. Units of one block move together, away from the centre of the model, by
    `explode` times the distance from there to the centre of the block.
    """
    if not (is_number(explode) and explode >= 0):
        raise InputError(
            f"explode is {explode!r}, expected a fraction of the size of the box. "
            "Set a number of 0 or more, as in explode=0.3."
        )
    west, east, south, north, bottom, top = units.box

    # centre of the model on the map; of each block, from the bounds of its units
    middle = np.array([west + east, south + north]) / 2.0
    zones = sorted({unit.zone_index for unit in units.values()})
    centres: dict[str, list[np.ndarray]] = {}
    for unit in units.values():
        centres.setdefault(unit.block, []).append(np.array(unit.middle[:2]))
    shifts = []
    for unit in units.values():
        # blocks sideways, away from the centre; zones up and down, the middle one stays
        aside = explode * (np.mean(centres[unit.block], axis=0) - middle)
        step = (len(zones) - 1) / 2.0 - zones.index(unit.zone_index)
        shifts.append(np.array([*aside, explode * (top - bottom) * step]))
    return shifts


def by_surface(shell: Shell) -> Shell:
    """Return a shell whose surfaces share no points, so that each is shaded by itself.

    A horizon may end at the rim of the model in thin triangles that are nearly vertical. They would
    pass their shade on to the wall next to them.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, -1]])
    >>> roof = Shell(corners, np.array([[0, 1, 2], [0, 3, 1]]), np.array([0, 1]))
    >>> by_surface(roof).triangles.tolist()
    [[0, 2, 4], [1, 5, 3]]
    """
    n = int(shell.surface.max(initial=0)) + 1
    of_corner = shell.triangles * n + shell.surface[:, None]
    keys, number = number_keys(of_corner.ravel())
    return replace(shell, points=shell.points[keys // n], triangles=number.reshape(-1, 3))


def outline(shell: Shell, creases: bool = True) -> np.ndarray:
    """Return the edges (n_edge, 2) of a shell between two surfaces, and at sharp creases."""
    faces = shell.triangles
    p = shell.points[faces]

    # unit normals of triangles; of one without area, zero
    normals = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    size = np.linalg.norm(normals, axis=1)
    normals /= np.where(size > 0.0, size, 1.0)[:, None]

    # each half-edge with the next one of its edge
    ring, _ = edges(faces, len(shell.points))
    half = np.flatnonzero(ring > np.arange(len(ring)))
    one, two = half // 3, ring[half] // 3

    # an edge is drawn between two surfaces, or where the shell turns by a crease
    turns = shell.surface[one] != shell.surface[two]
    flat = size[one] * size[two] == 0.0
    sharp = creases & ~flat & ((normals[one] * normals[two]).sum(axis=1) < CREASE)
    ends = ends_of(faces, half[turns | sharp])
    shown: np.ndarray = ends[np.lexsort((ends[:, 1], ends[:, 0]))]
    return shown
