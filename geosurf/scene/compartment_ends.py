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
from geosurf.conventions import area_text, counted, place, toml_key
from geosurf.errors import GeometryError, GeosurfWarning
from geosurf.faults.virtual.edges import areas_of, edge_keys, edges_of, pieces_between, rows_of
from geosurf.faults.virtual.walls import Wall
from geosurf.model import Patches
from geosurf.model.compartments import BOUNDARY, EITHER, ENDS, NEAREST, VirtualWall, virtual_name
from geosurf.rebuild import drop_triangles
from geosurf.scene.fault_tails import edges_above_and_below, on_tails, warnings_of_tails

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
    if not compartments:
        return patches, (), ()
    cells = find_cells(patches)
    stays = np.ones(patches.n_triangle, dtype=bool)
    for wall in walls:
        rows = rows_of(patches, virtual_name(wall.fault))
        inside = (cells.beside(rows)[1] != OUTSIDE).any(axis=1)
        stays[rows] = False
        stays[_connected(patches, rows[inside], wall, walls)] = True
    patches = drop_triangles(patches, stays)

    # sides anew: beyond its target, a wall may have cut off cells that are none
    cells, parts = find_cells(patches), []
    stays = np.ones(patches.n_triangle, dtype=bool)
    for wall in walls:
        rows = rows_of(patches, virtual_name(wall.fault))
        parts += _measured(patches, wall, compartments)
        beside = cells.beside(rows)[1]
        around = rows[beside[:, 0] == beside[:, 1]]
        if len(around):
            of_tail = on_tails(patches, cells, wall, around, walls)
            if not of_tail.all():
                raise _way_around(patches, wall, around[~of_tail], compartments)
            stays[around] = False
    if not stays.all():
        patches = drop_triangles(patches, stays)
        parts = [part for wall in walls for part in _measured(patches, wall, compartments)]
    warnings = warnings_of_tails(patches, compartments)
    if any(compartments[one.fault].get(one.side) == NEAREST for one in parts):
        warnings = (warning_of_walls(parts, compartments), *warnings)
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
        f"Name its target: compartments={{{longest.fault!r}: {{{longest.side!r}: 'boundary'}}}}; "
        f'in a scenario, {toml_key(longest.fault)} = {{{longest.side} = "boundary"}} in '
        "[compartments]. scene.virtual_walls lists all.",
        longest.place,
    )


def _connected(patches: Patches, rows: np.ndarray, wall: Wall, walls: Sequence[Wall]) -> np.ndarray:
    """The triangles of a wall from which a way in the wall leads to its fault, across no other."""
    faults = [source.name for source in patches.sources if source.role == "fault"]
    targets = {part.target for part in wall.parts}

    # it stops at all faults, and at what is above and below its targets: other walls it may cross
    stops = [edges_of(patches, faults)]
    for other in walls:
        if other.fault in targets:
            stops.append(edges_above_and_below(patches, other))

    # neighbours across an edge on which none of these lies are one piece
    keys = edge_keys(patches, rows)
    piece = pieces_between(keys, np.concatenate(stops))

    # pieces that have an edge on the rim of the fault
    on_rim = np.isin(keys, edges_of(patches, [wall.fault])).any(axis=1)
    found: np.ndarray = rows[np.isin(piece, piece[on_rim])]
    return found


def _way_around(
    patches: Patches, wall: Wall, rows: np.ndarray, compartments: Compartments
) -> GeometryError:
    """State where a wall has the same space on both sides, and what may be missing."""
    areas = areas_of(patches, rows)
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


def _measured(patches: Patches, wall: Wall, compartments: Compartments) -> list[VirtualWall]:
    """The parts of a wall with their areas and with what they end at."""
    rows = rows_of(patches, virtual_name(wall.fault))
    strip = wall.strip_of_triangle[patches.parent_of_triangle[rows]]
    areas = areas_of(patches, rows)
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
    keys = edge_keys(patches, rows)
    if part.target == BOUNDARY:
        names = [source.name for source in patches.sources if source.role == "wall"]
    else:
        names = [part.target, virtual_name(part.target)]
    if np.isin(keys, edges_of(patches, names)).any():
        return part
    met = [
        source.name
        for source in patches.sources
        if source.role == "fault" and source.name != part.fault
        if np.isin(keys, edges_of(patches, [source.name])).any()
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


__all__ = ["end_virtual_walls"]
