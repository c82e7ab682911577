"""Virtual walls in the arrangement: cut at the first fault that they meet; they have to separate.

A wall is built farther than its target (see `geosurf.faults.virtual`). Here the parts beyond are
dropped, so that it shares vertices with its target. What is left must have two cells of space on
its two sides everywhere: otherwise there is a way around it, and that is an error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.carve.cells import OUTSIDE, find_cells
from geosurf.conventions import area_text, counted, place
from geosurf.errors import GeometryError, GeosurfWarning
from geosurf.faults.virtual.walls import Wall
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.model import Patches
from geosurf.model.compartments import BOUNDARY, EITHER, ENDS, NEAREST, VirtualWall, virtual_name
from geosurf.rebuild import drop_triangles

Compartments = Mapping[str, Mapping[str, str]]


def end_virtual_walls(
    patches: Patches, walls: Sequence[Wall], compartments: Compartments
) -> tuple[Patches, tuple[VirtualWall, ...], tuple[GeosurfWarning, ...]]:
    """
    Drop what of virtual walls lies beyond their targets.

    Parameters
    ----------
    patches : Patches
        Of horizons, faults, virtual walls, fluid contacts and walls of the model.
    walls : sequence of Wall
    compartments : mapping of str to mapping of str to str
        As from `read_compartments`.

    Returns
    -------
    patches : Patches
    parts : tuple of VirtualWall
        With their areas, by fault and side.
    warnings : tuple of GeosurfWarning
        Of joins that geosurf chose.

    Raises
    ------
    GeometryError
        If there is a way around a wall, or it meets another fault before its target.
    """
    if not walls:
        return patches, (), ()
    cells = find_cells(patches)
    stays = np.ones(patches.n_triangle, dtype=bool)
    for wall in walls:
        rows = _rows(patches, virtual_name(wall.fault))
        inside = (cells.beside(rows)[1] != OUTSIDE).any(axis=1)
        stays[rows] = False
        stays[_connected(patches, rows[inside], wall, walls)] = True
    patches = drop_triangles(patches, stays)

    # sides anew: beyond its target, a wall may have cut off cells that are none
    cells, parts = find_cells(patches), []
    for wall in walls:
        rows = _rows(patches, virtual_name(wall.fault))
        parts += _measured(patches, rows, wall, compartments)
        beside = cells.beside(rows)[1]
        around = rows[beside[:, 0] == beside[:, 1]]
        if len(around):
            raise _way_around(patches, wall, around, compartments)
    chosen = any(compartments[one.fault].get(one.side) == NEAREST for one in parts)
    warnings = (warning_of_walls(parts, compartments),) if chosen else ()
    return patches, tuple(parts), warnings


def warning_of_walls(parts: Sequence[VirtualWall], compartments: Compartments) -> GeosurfWarning:
    """Warn of the joins that geosurf chose, with the longest of them."""
    chosen = [
        part
        for part in parts
        if part.side in ENDS and compartments[part.fault].get(part.side) == NEAREST
    ]
    longest = max(chosen, key=lambda part: part.length)
    return GeosurfWarning(
        "virtual wall",
        longest.fault,
        f"Compartments end at {counted(len(chosen), 'virtual wall')}, each by the shortest join, "
        f"not by data; the longest: {longest}.",
        f"Name its target: compartments={{{longest.fault!r}: {{{longest.side!r}: 'boundary'}}}}. "
        "scene.virtual_walls lists all.",
        longest.place,
    )


def _rows(patches: Patches, name: str) -> np.ndarray:
    """Triangles of a surface; none if the arrangement does not have it."""
    if name not in patches.names:
        return np.empty(0, dtype=np.int64)
    return np.flatnonzero(patches.surface_of_triangle == patches.names.index(name))


def _keys(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """A number for each edge of some triangles, int64 (n, 3)."""
    t = patches.triangles[rows]
    ends = np.stack([t, np.roll(t, -1, axis=1)], axis=2)
    keys: np.ndarray = ends.min(axis=2) * len(patches.local) + ends.max(axis=2)
    return keys


def _of_faults(patches: Patches, names: Sequence[str]) -> np.ndarray:
    """Edges of some surfaces, each once."""
    rows = [_rows(patches, name) for name in names]
    return np.unique(_keys(patches, np.concatenate([np.empty(0, dtype=np.int64), *rows])))


def _connected(patches: Patches, rows: np.ndarray, wall: Wall, walls: Sequence[Wall]) -> np.ndarray:
    """The triangles of a wall from which a way in the wall leads to its fault, across no other."""
    faults = [source.name for source in patches.sources if source.role == "fault"]
    targets = {part.target for part in wall.parts}

    # it stops at all faults, and at what is above and below its targets: other walls it may cross
    stops = [_of_faults(patches, faults)]
    for other in walls:
        if other.fault in targets:
            upright = [k for k, part in enumerate(other.parts) if part.side not in ENDS]
            at = _rows(patches, virtual_name(other.fault))
            of_strip = other.strip_of_triangle[patches.parent_of_triangle[at]]
            stops.append(_keys(patches, at[np.isin(of_strip, upright)]).ravel())

    # neighbours across an edge on which none of these lies are one piece
    keys = _keys(patches, rows)
    free = np.flatnonzero(~np.isin(keys, np.concatenate(stops)).ravel())
    order = free[np.argsort(keys.ravel()[free], kind="stable")]
    same = keys.ravel()[order][1:] == keys.ravel()[order][:-1]
    pairs = np.stack([order[:-1][same] // 3, order[1:][same] // 3], axis=1)
    piece = join_pairs(pairs, len(rows))

    # pieces that have an edge on the rim of the fault
    on_rim = np.isin(keys, _of_faults(patches, [wall.fault])).any(axis=1)
    found: np.ndarray = rows[np.isin(piece, piece[on_rim])]
    return found


def _way_around(
    patches: Patches, wall: Wall, rows: np.ndarray, compartments: Compartments
) -> GeometryError:
    """State where a wall has the same space on both sides, and what may be missing."""
    areas = _areas(patches, rows)
    largest = rows[int(areas.argmax())]
    at = patches.local[patches.triangles[largest]].mean(axis=0) + patches.origin
    name = wall.fault
    missing = sorted(
        {part.target for part in wall.parts} - {*compartments, BOUNDARY, "top", "base"}
    )
    left = [end for end in ENDS if not {end, EITHER} & {*compartments[name]}]
    if missing:
        what = f"fault {missing[0]!r}, at which it ends, dies inside the model"
        how = f"compartments={{{name!r}: ..., {missing[0]!r}: True}}"
    elif left:
        what = f"its {left[0]} stays open"
        how = f"compartments={{{name!r}: True}}"
    elif len(compartments) < sum(source.role == "fault" for source in patches.sources):
        what = "another fault that bounds the compartment dies inside the model"
        how = "compartments=True"
    else:
        return GeometryError(
            f"there is a way around fault {name!r} and its virtual wall near {place(at)}: "
            f"{area_text(math.fsum(areas))} of the wall have the same space on both sides. Its "
            f"target ends short of it there. Leave {name!r} out of compartments, name another "
            f"target, or let faults that nearly meet end at each other: truncations=...",
            place=at,
            surfaces=(name,),
        )
    return GeometryError(
        f"there is a way around fault {name!r} and its virtual wall near {place(at)}: "
        f"{area_text(math.fsum(areas))} of the wall have the same space on both sides, because "
        f"{what}. Continue it as well: {how}.",
        place=at,
        surfaces=(name, *missing),
    )


def _measured(
    patches: Patches, rows: np.ndarray, wall: Wall, compartments: Compartments
) -> list[VirtualWall]:
    """The parts of a wall with their areas and with what they end at."""
    strip = wall.strip_of_triangle[patches.parent_of_triangle[rows]]
    areas = _areas(patches, rows)
    found: dict[Any, VirtualWall] = {}
    for k, part in enumerate(wall.parts):
        area = math.fsum(areas[strip == k])
        if area == 0.0:
            continue  # all of it lies outside of the model
        if part.side in ENDS:
            word = compartments[part.fault].get(part.side, "")
            part = _ended(patches, rows[strip == k], part, word)

        # parts above and below a fault are one each
        key = (part.side, part.target, part.place if part.side in ENDS else None)
        known = found.get(key)
        longest = part if known is None or part.length > known.length else known
        found[key] = replace(longest, area=area + (known.area if known else 0.0))
    return list(found.values())


def _ended(patches: Patches, rows: np.ndarray, part: VirtualWall, word: str) -> VirtualWall:
    """A part with what it ends at; an error if that is another fault than the wanted one."""
    keys = _keys(patches, rows)
    if part.target == BOUNDARY:
        names = [source.name for source in patches.sources if source.role == "wall"]
    else:
        names = [part.target, virtual_name(part.target)]
    if np.isin(keys, _of_faults(patches, names)).any():
        return part
    met = [
        source.name
        for source in patches.sources
        if source.role == "fault" and source.name != part.fault
        if np.isin(keys, _of_faults(patches, [source.name])).any()
    ]
    if not met:
        return part  # it ends inside a cell, which is an error of its own
    if word == NEAREST:
        return replace(part, target=met[0])
    raise GeometryError(
        f"on the shortest way from fault {part.fault!r} ({part.side}) to {part.target!r} lies "
        f"{' and '.join(map(repr, met))}: the wall ends there. Join it to that: "
        f"compartments={{{part.fault!r}: {{{part.side!r}: {met[0]!r}}}}}.",
        place=part.place,
        surfaces=(part.fault, *met),
    )


def _areas(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """Area of some triangles [m2]."""
    a, b, c = (patches.local[patches.triangles[rows, k]] for k in range(3))
    areas: np.ndarray = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return areas


__all__ = ["end_virtual_walls"]
