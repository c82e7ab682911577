"""Faults that end at horizons: an unconformity above them, a detachment below them.

Everything is split first, with whole faults. Then the triangles of a fault that lie on the other
side of the horizon are dropped, so that the fault ends exactly on their common curve. Sides are
those of the zones (`geosurf.carve.column`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.arrangement import find_contacts
from geosurf.carve.cells import OUTSIDE, Cells, find_cells
from geosurf.carve.column import FaultSides, HorizonSides, horizon_sides, outside_of_model
from geosurf.conventions import area_text, counted, length_text, place, toml_key
from geosurf.errors import GeometryError, GeosurfWarning
from geosurf.faults.dangling import areas_of, edge_keys, edges_of, model_of, pieces_between, rows_of
from geosurf.faults.distance import closest_approach
from geosurf.faults.rules import Rule, part_in_words
from geosurf.faults.virtual_walls import Wall, build_virtual_walls
from geosurf.measure.section import chains_of
from geosurf.model import Patches, TriSurface
from geosurf.model.column import BOUNDARY, EITHER, ENDS, NEAREST, VirtualWall, virtual_name
from geosurf.model.excerpt import CloseUp
from geosurf.model.network import Truncation
from geosurf.rebuild import drop_triangles, patches_from
from geosurf.scene.inputs import Box, SceneInputs
from geosurf.scene.memory import Memory

# ---- virtual walls ----------------------------------------
# Virtual walls of compartments, before they are cut at their targets.


def find_virtual_walls(
    inputs: SceneInputs,
    memory: Memory,
    faults: Sequence[TriSurface],
    box: Box,
    aoi: np.ndarray | None,
) -> list[Wall]:
    """
    Return the virtual walls of a scene, from memory if they are there.

    Parameters
    ----------
    inputs : SceneInputs
        With `compartments`.
    memory : Memory
    faults : sequence of TriSurface
        As the model has them.
    box : (west, east, south, north, bottom, top)
    aoi : ndarray of float64, shape (n, 2), or None
        Corners of the area of the model.
    """
    stated = str(inputs.compartments)
    keys = (*map(memory.key_of, faults), stated, box, None if aoi is None else aoi.tobytes())

    def make() -> list[Wall]:
        """Split all faults, which shows where each of them dies."""
        split = patches_from(find_contacts(faults, origin=np.zeros(3)))
        return build_virtual_walls(split, faults, inputs.compartments, model_of(box, aoi))

    return memory.get_or_compute(
        "virtual walls", counted(len(inputs.compartments), "fault"), ("virtual", *keys), make,
        lambda walls: counted(len(walls), "wall"), again=False,
    )  # fmt: skip


def lines_on(patches: Patches, horizon: str) -> dict[str, list[np.ndarray]]:
    """
    Return where virtual walls meet a horizon.

    Parameters
    ----------
    patches : Patches
    horizon : str

    Returns
    -------
    dict of str to list of ndarray of float64, each (n, 3)
        World coordinates along each line, by name of the virtual wall [m].
    """
    on = edges_of(patches, [horizon])
    lines = {}
    for name in (one.name for one in patches.sources if one.role == "virtual"):
        keys = np.intersect1d(edges_of(patches, [name]), on)
        edges = np.stack(np.divmod(keys, len(patches.local)), axis=1)
        lines[name] = [patches.vertices[line] for line in chains_of(edges, patches.local)]
    return lines


Ends = tuple[Patches, tuple[Truncation, ...], tuple[GeosurfWarning, ...]]


def end_at_horizons(
    patches: Patches,
    column: Mapping[str, str],
    rules: Sequence[Rule],
    branches: Sequence[Rule] = (),
) -> Ends:
    """
    Drop the parts of faults beyond the horizons that they end at.

    Parameters
    ----------
    patches : Patches
        Of horizons, faults, fluid contacts and walls.
    column : mapping of str to str
        Rules of the horizons, as for `carve_units`.
    rules : sequence of Rule
        Each with a horizon as its main surface.
    branches : sequence of Rule
        Faults that end at faults, which may lose their main fault beyond a horizon.

    Returns
    -------
    patches : Patches
        Without these parts.
    truncations : tuple of Truncation
        In the order of the rules.
    warnings : tuple of GeosurfWarning
        Of faults that have lost their main fault.

    Raises
    ------
    GeometryError
        If a horizon does not cover a fault (with the place), a fault does not reach it (with the
        gap), has no part on the side that stays, or offsets it.
    """
    sides = horizon_sides(patches, column)
    keep = np.ones(patches.n_triangle, dtype=bool)
    truncations: list[Truncation] = []
    for fault in dict.fromkeys(rule.fault for rule in rules):
        rules_of_fault = [rule for rule in rules if rule.fault == fault]
        sides_at = [_checked(sides, rule) for rule in rules_of_fault]
        rows, inside = sides_at[0].rows, sides_at[0].inside

        # one rule after the other: each reports what the earlier ones have left
        left = np.ones(len(rows), dtype=bool)
        for rule, at_horizon in zip(rules_of_fault, sides_at, strict=True):
            stays = inside & ~(
                at_horizon.within | (at_horizon.above if rule.keep == "below" else at_horizon.below)
            )
            stays |= outside_of_model(patches, at_horizon, stays, rule.main)
            truncations.append(_truncation(patches, rule, at_horizon, left, left & stays))
            left &= stays
        if not (left & inside).any():
            raise _nothing_left(patches, rules_of_fault, rows[inside])
        keep[rows[~left]] = False
    lost = [_lost_main(patches, keep, branch, rules) for branch in branches]
    return drop_triangles(patches, keep), tuple(truncations), tuple(filter(None, lost))


def _lost_main(
    patches: Patches, keep: np.ndarray, branch: Rule, rules: Sequence[Rule]
) -> GeosurfWarning | None:
    """Warn of a fault that goes on where the fault that it ends at is gone."""
    of = patches.surface_of_triangle
    mine, main = (of == patches.names.index(name) for name in (branch.fault, branch.main))
    some = (mine & keep, main & keep, main & ~keep)
    edges, still, gone = (edge_keys(patches, np.flatnonzero(rows)) for rows in some)
    a, b = np.divmod(np.setdiff1d(np.intersect1d(edges, gone), still), len(patches.local))
    length = np.linalg.norm(patches.local[b] - patches.local[a], axis=1)
    if len(length) == 0:
        return None
    at = 0.5 * (patches.local[a] + patches.local[b])[length.argmax()] + patches.origin
    ends = [rule for rule in rules if rule.fault == branch.main]
    words = f"({branch.main!r}, {branch.keep!r}), ({ends[0].main!r}, {ends[0].keep!r})"
    return GeosurfWarning(
        "fault network",
        branch.fault,
        f"Fault {branch.fault!r} ends at {branch.main!r}, which ends at {ends[0].main!r}: "
        f"beyond that horizon {branch.fault!r} goes on and ends inside the model, on "
        f"{length_text(math.fsum(length))}.",
        f"Let it end at the horizon as well: truncations={{{branch.fault!r}: ({words})}}.",
        tuple(at),
    )


def _checked(sides: HorizonSides, rule: Rule) -> FaultSides:
    """Where a fault lies at a horizon, if each of its triangles lies on one side."""
    patches = sides.patches
    at_horizon = sides.of_fault(rule.fault, rule.main)
    names = (rule.fault, rule.main)
    if not at_horizon.inside.any():
        raise GeometryError(
            f"nothing of fault {rule.fault!r} lies in the model, so that it cannot end at horizon "
            f"{rule.main!r} there. Leave the rule out, or enlarge the box.",
            surfaces=names,
        )

    # around an open rim the horizon has no sides
    if at_horizon.unknown.any():
        doubt = patches.local[patches.triangles[at_horizon.rows[at_horizon.unknown]]].reshape(-1, 3)
        rim = sides.open_rim(rule.main, doubt)
        at = doubt.mean(axis=0) + patches.origin if rim is None else rim[1]
        where = "" if rim is None else f": {rim[0]:.6g} m of its rim are open inside the model"
        raise GeometryError(
            f"fault {rule.fault!r} cannot end at horizon {rule.main!r}, which does not cover all "
            f"of it{where}, nearest at {place(at)}. Continue the horizon: "
            f"extend_horizon(..., fill_holes=True); or shrink the box to it.",
            place=at,
            surfaces=names,
        )

    # a horizon that ends on the fault is offset by it
    offset = at_horizon.above & at_horizon.below & ~at_horizon.within
    if offset.any():
        at = _middle(patches, at_horizon.rows[offset])
        raise GeometryError(
            f"horizon {rule.main!r} is offset by fault {rule.fault!r} at {place(at)}, so that the "
            f"fault cannot end there. Give {rule.main!r} as it is where {rule.fault!r} does not "
            "cut it, or leave the rule out.",
            place=at,
            surfaces=names,
        )
    beyond = at_horizon.above if rule.keep == "below" else at_horizon.below
    if not (beyond | at_horizon.within).any() and not _meets(patches, rule, at_horizon.rows):
        raise _too_short(patches, rule, at_horizon)
    return at_horizon


def _meets(patches: Patches, rule: Rule, rows: np.ndarray) -> bool:
    """Whether a fault has a vertex in common with a horizon."""
    other = patches.surface_of_triangle == patches.names.index(rule.main)
    return bool(np.isin(patches.triangles[rows], patches.triangles[other]).any())


def _too_short(patches: Patches, rule: Rule, at_horizon: FaultSides) -> GeometryError:
    """State how far a fault stays off the horizon that it is to end at, and where."""
    other = np.flatnonzero(patches.surface_of_triangle == patches.names.index(rule.main))
    inside = patches.triangles[at_horizon.rows[at_horizon.inside]]
    gap = closest_approach(patches.local, inside, patches.triangles[other])
    at = gap.at + patches.origin
    remedy = (
        "Leave the rule out: it does not reach the horizon, even extended."
        if rule.extend
        else f"Extend it: truncations={{{rule.fault!r}: ({rule.main!r}, {rule.keep!r}, True)}}; or "
        "leave the rule out."
    )
    return GeometryError(
        f"fault {rule.fault!r} ends {gap.distance:.6g} m short of horizon {rule.main!r}, nearest "
        f"at {place(at)}, and cannot end there. {remedy}",
        place=at,
        surfaces=(rule.fault, rule.main),
    )


def _nothing_left(patches: Patches, rules: Sequence[Rule], rows: np.ndarray) -> GeometryError:
    """State that a fault has no part where it is to stay."""
    at = _middle(patches, rows)
    where = " and ".join(part_in_words(rule) for rule in rules)
    fault = rules[0].fault
    return GeometryError(
        f"fault {fault!r} has no part {where}: nothing would be left of it. It lies around "
        f"{place(at)}; keep the other part, or leave the fault out.",
        place=at,
        surfaces=(fault, *(rule.main for rule in rules)),
    )


def _middle(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """The middle of the largest of some triangles."""
    largest = rows[areas_of(patches, rows).argmax()]
    middle: np.ndarray = patches.local[patches.triangles[largest]].mean(axis=0) + patches.origin
    return middle


def _truncation(
    patches: Patches, rule: Rule, at_horizon: FaultSides, before: np.ndarray, after: np.ndarray
) -> Truncation:
    """Areas of a fault that one rule keeps and drops, and the length of its new end."""
    area = areas_of(patches, at_horizon.rows)
    gone = before & ~after

    # it ends where something is gone, or where its rim lay on the horizon already
    edges, times = np.unique(edge_keys(patches, at_horizon.rows[after]), return_counts=True)
    main = np.flatnonzero(patches.surface_of_triangle == patches.names.index(rule.main))
    main = main[
        np.isin(patches.triangles[main], patches.triangles[at_horizon.rows]).sum(axis=1) > 1
    ]
    ends = edges[(times == 1) & np.isin(edges, edge_keys(patches, main))]
    left, lost = (
        edge_keys(patches, at_horizon.rows[some & at_horizon.inside]) for some in (after, gone)
    )
    ends = np.union1d(np.intersect1d(ends, left), np.intersect1d(left, lost))
    a, b = np.divmod(ends, len(patches.local))
    return Truncation(
        rule.fault,
        rule.main,
        rule.keep,
        "-" if rule.keep == "below" else "+",
        kept_area=math.fsum(area[after]),
        dropped_area=math.fsum(area[gone]),
        coinciding_area=math.fsum(area[gone & at_horizon.within]),
        apart_area=0.0,
        length=math.fsum(np.linalg.norm(patches.local[b] - patches.local[a], axis=1)),
    )


def edges_above_and_below(patches: Patches, wall: Wall) -> np.ndarray:
    """Edges of the vertical parts of a virtual wall."""
    upright = [k for k, part in enumerate(wall.parts) if part.side not in ENDS]
    at = rows_of(patches, virtual_name(wall.fault))
    of_strip = wall.strip_of_triangle[patches.parent_of_triangle[at]]
    return edge_keys(patches, at[np.isin(of_strip, upright)]).ravel()


def on_tails(
    patches: Patches, cells: Cells, wall: Wall, around: np.ndarray, walls: Sequence[Wall]
) -> np.ndarray:
    """
    Return which triangles of a virtual wall lie on tails of its fault.

    Parameters
    ----------
    patches : Patches
    cells : Cells
        Of the patches.
    wall : Wall
    around : ndarray of int64, shape (n,)
        Triangles of the wall that have the same cell on their two sides.
    walls : sequence of Wall
        Of all faults: vertical parts of other ones end a tail, as their faults do.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    fault = rows_of(patches, wall.fault)
    beside = cells.beside(fault)[1]
    inside = (beside != OUTSIDE).any(axis=1)
    divides = inside & (beside[:, 0] != beside[:, 1])
    if not divides.any():
        return np.zeros(len(around), dtype=bool)

    # the fault and its wall as one sheet, cut where others cross it
    rows = np.concatenate([fault[inside & ~divides], around])
    keys = edge_keys(patches, rows)
    faults = [source.name for source in patches.sources if source.role == "fault"]
    others = edges_of(patches, [name for name in faults if name != wall.fault])
    upright = [edges_above_and_below(patches, other) for other in walls if other is not wall]
    piece = pieces_between(keys, np.unique(np.concatenate([others, *upright])))

    # the fault itself, not its wall, reaches what each end of a tail is to be joined to
    strip = np.full(len(rows), -1)
    strip[len(rows) - len(around) :] = wall.strip_of_triangle[patches.parent_of_triangle[around]]
    is_tail = np.zeros(len(rows), dtype=bool)
    for number in np.unique(piece):
        in_piece = piece == number
        ends = [wall.parts[k] for k in np.unique(strip[in_piece & (strip >= 0)])]
        targets = {part.target for part in ends if part.side in ENDS}
        is_tail |= in_piece & all(
            np.isin(
                keys[in_piece & (strip < 0)], edges_of(patches, [name, virtual_name(name)])
            ).any()
            for name in targets
        )
    return is_tail[len(rows) - len(around) :]


def warnings_of_tails(
    patches: Patches, compartments: Mapping[str, Mapping[str, str]]
) -> tuple[GeosurfWarning, ...]:
    """
    Return a warning for each fault of compartments of which a part divides nothing.

    Parameters
    ----------
    patches : Patches
        With the virtual walls as they end.
    compartments : mapping of str to mapping of str to str

    Returns
    -------
    tuple of GeosurfWarning

    Raises
    ------
    GeometryError
        If no part of a fault divides anything.
    """
    cells, warnings = find_cells(patches), []
    for name in (one for one in compartments if compartments[one]):
        rows = rows_of(patches, name)
        beside = cells.beside(rows)[1]
        inside = (beside != OUTSIDE).any(axis=1)
        around = rows[inside & (beside[:, 0] == beside[:, 1])]
        if not len(around):
            continue
        areas, at = areas_of(patches, around), _middle(patches, around)
        how = f"compartments={{{name!r}: {{'start': 'boundary', 'end': 'boundary'}}}}"
        if len(around) == inside.sum():
            raise GeometryError(
                f"fault {name!r} divides nothing: there is a way around it near {place(at)}. "
                f"Continue it to the boundary: {how}; or leave it out of compartments.",
                place=at,
                surfaces=(name,),
            )
        warnings.append(
            GeosurfWarning(
                "virtual wall",
                name,
                f"{area_text(math.fsum(areas))} of fault {name!r} near {place(at)} divides "
                "nothing: the fault dies there beyond a fault that it crosses.",
                f"If it separates regions there, continue it: {how}; in a scenario, "
                f'{name} = "boundary" in [compartments].',
                tuple(at.tolist()),
            )
        )
    return tuple(warnings)


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
        f"Compartments end at {counted(len(chosen), 'virtual wall')}, each by the shortest join "
        f"that separates, not by data; the longest: {longest}.",
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
    areas, at, name = areas_of(patches, rows), _middle(patches, rows), wall.fault
    faults = (source for source in patches.sources if source.role == "fault")
    corners = patches.local[patches.triangles[rows]].reshape(-1, 3)
    shown = CloseUp((*faults, wall.surface), float(np.ptp(corners, axis=0).max()))
    missing = sorted(
        {part.target for part in wall.parts} - {*compartments, BOUNDARY, "top", "base"}
    )
    left = [end for end in ENDS if not {end, EITHER} & {*compartments[name]}]

    def in_scenario(fault: str) -> str:
        """What continues a fault at both ends."""
        return f'in a scenario, {toml_key(fault)} = "nearest" in [compartments]'

    if missing:
        what = f"fault {missing[0]!r}, at which it ends, dies inside the model"
        how = f"compartments={{{name!r}: ..., {missing[0]!r}: True}}; {in_scenario(missing[0])}"
    elif left:
        what = f"its {left[0]} stays open"
        how = f"compartments={{{name!r}: True}}; {in_scenario(name)}"
    elif len(compartments) < sum(source.role == "fault" for source in patches.sources):
        what = "another fault that bounds the compartment dies inside the model"
        how = "compartments=True; in a scenario, list all faults in [compartments]"
    else:
        return GeometryError(
            f"there is a way around fault {name!r} and its virtual wall near {place(at)}: "
            f"{area_text(math.fsum(areas))} of the wall have the same space on both sides. There "
            f"is a way around what it ends at, too. Leave {name!r} out of compartments, name "
            "another target, or let faults that nearly meet end at each other: truncations=...",
            place=at,
            surfaces=(name,),
            close_up=shown,
        )
    return GeometryError(
        f"there is a way around fault {name!r} and its virtual wall near {place(at)}: "
        f"{area_text(math.fsum(areas))} of the wall have the same space on both sides, because "
        f"{what}. Continue it as well: {how}.",
        place=at,
        surfaces=(name, *missing),
        close_up=shown,
    )


def _measured(patches: Patches, wall: Wall, compartments: Compartments) -> list[VirtualWall]:
    """The parts of a wall with their areas and with what they end at."""
    rows = rows_of(patches, virtual_name(wall.fault))
    strip = wall.strip_of_triangle[patches.parent_of_triangle[rows]]
    areas = areas_of(patches, rows)
    measured: dict[Any, VirtualWall] = {}
    for k, part in enumerate(wall.parts):
        area = math.fsum(areas[strip == k])
        if area == 0.0:
            continue  # all of it lies outside of the model
        if part.side in ENDS:
            word = compartments[part.fault].get(part.side, "")
            part = _ended(patches, rows[strip == k], part, word)

        # parts above and below a fault are one each
        key = (part.side, part.target, part.place if part.side in ENDS else None)
        known = measured.get(key)
        longest = part if known is None or part.length > known.length else known
        measured[key] = replace(longest, area=area + (known.area if known else 0.0))
    return list(measured.values())


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
