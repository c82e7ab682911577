"""Carve the model box into closed units: the steps from patches to units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from geosurf.carve.cells import OUTSIDE, Cells, find_cells
from geosurf.carve.clipped import Clips, clipped_by
from geosurf.carve.column import apply_column, reservoir_of, zones_of
from geosurf.carve.fluids import (
    check_zones,
    contacts_of_units,
    level_of,
    not_reached,
    split_by_contacts,
)
from geosurf.carve.measures import AREA
from geosurf.carve.outside import box_of, footprint_of, is_fence, size_of_shells, walls_are_a_box
from geosurf.carve.regions import (
    faces_between_units,
    homes_of_slivers,
    shared_area,
    shared_faces,
    surfaces_of,
)
from geosurf.carve.shells import (
    CarvedUnit,
    Shells,
    beside_pieces,
    beside_triangles,
    shells_of,
    turned_inside_out,
    unit_name,
)
from geosurf.carve.zones import (
    Faults,
    block_order,
    distinct_pairs,
    faces_between,
    fault_sides,
    name_blocks,
    owned_by,
    sides_of_units,
    signatures,
)
from geosurf.conventions import length_text, place, shared_name, volume_text
from geosurf.errors import GeosurfWarning, InputError
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.model import FluidContact, Patches, Unit, Units, check_column
from geosurf.model.base import in_crs_of
from geosurf.model.column import (
    BASE,
    CONFORMABLE,
    EROSIONAL,
    Clipped,
    Remnant,
    names_of_zones,
    separators,
)
from geosurf.model.expected import expect
from geosurf.model.regions import MergedSliver, SliverSettings, sliver_settings

# ---- slivers ----------------------------------------
# Errors and warnings about slivers.


def refuse_all_slivers(units: Units) -> None:
    """Raise an error if every unit is a sliver, so that none can take them."""
    if len(units) and len(units.slivers) == len(units):
        largest = units.slivers[0]
        raise InputError(
            f"slivers: all {len(units)} units are {units.sliver_settings.rule}, so none can take "
            f"the others. The largest, {largest.name!r}, has {volume_text(largest.volume)}; give a "
            "smaller min_volume."
        )


def warnings_of_slivers(units: Units) -> tuple[GeosurfWarning, ...]:
    """
    Return a warning if slivers were to be merged, and no other unit touches them.

    Parameters
    ----------
    units : Units

    Returns
    -------
    tuple of GeosurfWarning
        At most one, with the place of the largest sliver.
    """
    if not units.sliver_settings.merge or not units.slivers:  # slivers have places: not for nothing
        return ()
    n, largest = len(units.slivers), units.slivers[0]
    total = volume_text(math.fsum(one.volume for one in units.slivers))
    what = f"{n} slivers are" if n > 1 else "One sliver is"
    warning = GeosurfWarning(
        "sliver",
        largest.name,
        f"{what} not merged, since only slivers touch {'them' if n > 1 else 'it'}: {total}, the "
        f"largest {largest.name!r}.",
        "Set a smaller limit in m³, as in slivers={'min_volume': 5000.0, 'merge': True}.",
        largest.place,
    )
    return (warning,)


# ---- thin ----------------------------------------
# Warn of units thinner than the rounding error: surfaces that almost coincide.


def warnings_of_thin_units(units: Units) -> tuple[GeosurfWarning, ...]:
    """
    Return a warning if units are thinner than the rounding error of coordinates.

    Parameters
    ----------
    units : Units

    Returns
    -------
    tuple of GeosurfWarning
        At most one, with the place of the largest thin unit.
    """
    thin = units.report.get("thin", ())
    if not thin:
        return ()
    largest = max(thin, key=lambda unit: unit.volume)
    surfaces = ", ".join(repr(name) for name in units[largest.name].bounded_by)
    what = f"Unit {largest.name!r} is"
    if len(thin) > 1:
        what = f"{len(thin)} units, of which {largest.name!r} is the largest, are"
    warning = GeosurfWarning(
        "thin unit",
        largest.name,
        f"{what} thinner than the rounding error of coordinates ({largest.volume:.1e} "
        f"m³): {surfaces} almost coincide there.",
        "Ignore such units (units.report['thin'] lists them), or round the coordinates "
        "of these surfaces and of the box: np.round(x * 1024) / 1024.",
        largest.place,
    )
    return (warning,)


# ---- order ----------------------------------------
# Warn of horizons in the wrong order: an older one above a younger one nearly everywhere.


_MOST = 0.5  # fraction of the map; smaller crossings are only listed in the report
_ZONE_MOST = 0.01  # the same where a zone from thickness has no room


def warnings_of_order(
    units: Units, zones: Mapping[str, tuple[str, str]] | None = None
) -> Iterator[GeosurfWarning]:
    """
    Yield a warning for each pair of conformable horizons with the older one mostly above.

    Pairs with a rule of the column are skipped: the rule states which horizon removes the other.
    A zone of the reservoir whose horizons coincide everywhere has a warning, too.

    Parameters
    ----------
    units : Units
    zones : mapping of str to (str, str), optional
        Horizons that zones from thickness make, and that are fitted to no other one: the zone, and
        the horizon that its thickness counts from. Where these cross others, the zone has no room.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> turned_over = dict(reversed(world.horizons.items()))
    >>> surfaces = [gs.triangulate_horizon(h, name=n) for n, h in turned_over.items()]
    >>> patches = gs.rebuild_surfaces([*surfaces, *gs.build_walls(world.box)])
    >>> (found,) = warnings_of_order(gs.carve_units(patches))
    >>> found.kind, found.subject, found.effect[:37]
    ('order', 'Top', "Horizon 'Top' lies above the younger ")
    """
    clips = units.report.get("clipped", ())
    there = {unit.zone for unit in (units.unmerged or units).values()}
    for zone in units.reservoir:
        if zone not in there and zone not in {f"{clip.by}/{clip.horizon}" for clip in clips}:
            yield GeosurfWarning(
                "order",
                zone,
                f"Zone {zone!r} has no rock: its horizons coincide, or are not in the model.",
                "Check that they were not read from one file, and that the box holds them.",
            )

    # areas of faces decide whether it is worth to measure what is clipped, with room for rounding
    if isinstance(clips, Clips):
        least = 0.99 * (_ZONE_MOST if zones else _MOST) * units.footprint
        if max(clips.areas(CONFORMABLE), default=0.0) < least:
            return
    for clip in clips:
        share = min(clip.area / units.footprint, 1.0)
        made_zones = {clip.horizon, clip.by} & set(zones or ())
        if clip.rule != CONFORMABLE or share < (_ZONE_MOST if made_zones else _MOST):
            continue
        where = "everywhere" if share > 0.995 else f"on {100 * share:.0f} % of the area"
        if zones and made_zones:
            yield _warning_of_room(clip, zones, where)
            continue
        yield GeosurfWarning(
            "order",
            clip.horizon,
            f"Horizon {clip.horizon!r} lies above the younger horizon {clip.by!r} {where}: "
            f"{volume_text(clip.volume)} between them is clipped.",
            "List horizons from the youngest to the oldest. If the values are depths, pass "
            f"positive='down'. If {clip.by!r} erodes {clip.horizon!r}, pass "
            f"column={{{clip.by!r}: 'erosional'}}.",
            clip.place,
        )


def _warning_of_room(
    clip: Clipped, zones: Mapping[str, tuple[str, str]], where: str
) -> GeosurfWarning:
    """The warning of a zone from thickness that has no room up to the next horizon."""
    down = clip.by in zones
    zone, start = zones[clip.by if down else clip.horizon]
    other = clip.horizon if down else clip.by
    side, end, rule = ("below", "base", BASE) if down else ("above", "top", EROSIONAL)
    fit = "Or make one row of zones that ends on a horizon with data: it is fitted."
    if other not in zones:
        more = {side: zone, "thickness": 10, end: other}
        fit = f"Or add a zone {more}: a row that ends on a horizon with data is fitted."
    return GeosurfWarning(
        "thickness",
        zone,
        f"Zone {zone!r} is thicker than the room between {start!r} and {other!r} {where}, by up to "
        f"{length_text(clip.thickness)} at {place(clip.place)}: {clip.horizon!r} is clipped there.",
        f"Give less thickness there. {fit} If the zone ends against {other!r}, pass "
        f"column={{{other!r}: {rule!r}}}.",
        clip.place,
    )


Box = tuple[float, float, float, float, float, float]


def carve_units(
    patches: Patches,
    column: Mapping[str, str] | None = None,
    contacts: Sequence[FluidContact] = (),
    slivers: Any = None,
    reservoir: Sequence[str] | None = None,
) -> Units:
    """
    Carve the model box into closed units, named by zone and fault block.

    Parameters
    ----------
    patches : Patches
        Patches of horizons (role ``"horizon"``, youngest first), faults (role ``"fault"``, any
        number), virtual walls that continue them (role ``"virtual"``), fluid contacts (role
        ``"contact"``) and walls (role ``"wall"``). Walls are those of `build_walls`, or any closed
        shells that enclose the model.
    column : mapping of str to str, optional
        Rule of each horizon: ``"conformable"``, ``"erosional"`` (removes older layers below it),
        ``"base"`` (younger layers lap onto it and are removed below it), ``"discontinuous"``
        (both) or ``"yielding"`` (it ends on all others). Default: all horizons are conformable.
    contacts : sequence of FluidContact, optional
        Fluid contacts with their zones and blocks, from the top down; see `build_contacts`.
    slivers : float, "merge" or mapping, optional
        Units below this volume [m3] are slivers; default: units below 1/10 000 of their zone.
        ``"merge"``, or ``{"min_volume": 5000.0, "merge": True}``, merges each into the neighbour
        with the largest shared area.
    reservoir : sequence of str, optional
        Zones that contacts without zones split, and that tables and pictures show. Default: those
        between the first and the last horizon; all zones if there are fewer than two horizons.

    Returns
    -------
    Units
        Units ordered by zone (youngest first), block, and contact interval (from the top down).

        - Where horizons cross, the column clips one of them; of two conformable horizons the
          older one ends at the younger one. ``report["clipped"]`` lists area, volume and place,
          measured when it is first read.
        - A fault separates blocks only if there is no way around it. A fault that ends inside a
          unit is a slit; ``report["slits"]`` has its area.
        - A contact of some blocks applies on these sides of faults (``Unit.fault_sides``);
          ``report["without_contact"]`` lists the units that it does not cover.
        - ``report["outside"]`` lists faults outside of the model.
        - ``report["thin"]`` lists units thinner than the rounding error of their vertices, which
          lie between surfaces that almost coincide.
        - `Units.slivers` lists slivers. Where they are merged, surfaces between the parts of a unit
          are not on its shell, `Units.merged` lists the parts, and `Units.unmerged` has the units
          before.

    Raises
    ------
    InputError
        For an unknown rule, horizon, zone or block, or if two surfaces (except walls) or two zones
        have the same name; if all units are slivers and to be merged.
    GeometryError
        If there are no walls, a horizon lies outside the box, contacts cross, or a surface that
        crosses itself turns a unit inside out.
    OpenUnitError
        If a unit leaks: a horizon ends before the walls or has a hole, and no rule of the column
        removes it there. The message gives the length of the open rim and a place.
    RoundingError
        If rounding the vertices of a unit to float64 turns it inside out.

    Notes
    -----
    Cells follow from the exact radial order of triangles around each edge (a Weiler model,
    cf. Levy 2024, arXiv 2405.12949). Volumes follow from the divergence theorem with compensated
    sums.

    Examples
    --------
    >>> from geosurf import TriSurface, build_walls, rebuild_surfaces
    >>> box = (0, 10, 0, 10, -10, 0)
    >>> corners = [[-1, -1, -4], [11, -1, -4], [11, 11, -4], [-1, 11, -4]]
    >>> top = TriSurface("Top", "horizon", corners, [[0, 1, 2], [0, 2, 3]])
    >>> units = carve_units(rebuild_surfaces([top, *build_walls(box)]))
    >>> {name: round(unit.volume, 9) for name, unit in units.items()}
    {'above Top': 400.0, 'below Top': 600.0}
    """
    expect(patches, Patches, "carve_units takes Patches", "pass the result of rebuild_surfaces")
    return carve_cells(partial(find_cells, patches), patches, column, contacts, slivers, reservoir)


def carve_cells(
    find: Callable[[], Cells],
    patches: Patches,
    column: Mapping[str, str] | None,
    contacts: Sequence[FluidContact],
    slivers: Any,
    reservoir: Sequence[str] | None,
) -> Units:
    """Return the units of `carve_units`; `find` returns the cells, which follow from patches."""
    horizons, fault_rows = (_with_role(patches, role) for role in ("horizon", "fault"))
    faults = separators(patches.names, [source.role for source in patches.sources])
    _check_names(patches)
    rules = check_column([patches.names[i] for i in horizons], column)
    zone_names = names_of_zones([patches.names[i] for i in horizons])
    within = reservoir_of(zone_names, reservoir)
    check_zones(contacts, zone_names)
    levels = [level_of(patches, contact) for contact in contacts]

    # cells of space, each with its side of all horizons and contacts; the column makes zones of it
    cells = find()
    signature = signatures(patches, cells, [*horizons, *levels])
    side, turns = apply_column(signature[: len(horizons)], rules)
    zone = zones_of(patches, cells, side, horizons)

    # a block is all cells of a zone that are connected without crossing a fault
    blocks = _blocks_of(patches, cells, _merge(patches, cells, zone), zone, faults)
    parts = _Parts.whole(blocks)

    # fluid contacts split blocks; an entry for some blocks or zones leaves others whole
    left: dict[str, list[int]] = {}
    if levels:
        zones = [zone_names[k] for k in blocks.zone.tolist()]
        applied = contacts_of_units(
            contacts, zones, blocks.words, blocks.sides.found, list(faults), within
        )
        left = not_reached(contacts, applied, zones, within)
        split = split_by_contacts(
            patches, cells, signature[len(horizons) :], contacts, applied, blocks.unit_of_cell
        )
        parts = _Parts(shells_of(cells, split[0]), *split[1:])

    # first the zone, then the block's name, then the contact interval: a stable order whatever the
    # numbers of cells
    named = _Named(patches, zone_names, within, blocks, parts)
    report = {
        "slits": slits(patches, cells, parts.shells, fault_rows),
        "clipped": clipped_by(patches, cells, turns, horizons),
        "cells": cells.n_cell,
        "without_contact": _uncovered(named, left),
        "outside": outside_faults(patches, cells, fault_rows),
    }
    settings = sliver_settings(slivers)
    units = _units(named, report, settings)
    if settings.merge and units.slivers:
        units = _without_slivers(named, units, faults, left)
    return units


def _without_slivers(
    named: _Named, units: Units, faults: Faults, left: dict[str, list[int]]
) -> Units:
    """The units, with slivers as parts of their neighbours, named as if no sliver had been."""
    refuse_all_slivers(units)
    patches, blocks, parts = named.patches, named.blocks, named.parts
    cells, names = parts.shells.cells, list(units)
    number = dict(zip(names, named.order, strict=True))
    faces = faces_between_units(parts.shells.sides)
    small = [number[sliver.name] for sliver in units.slivers]
    home = homes_of_slivers(faces, cells.sums[:, AREA], len(named.order), small, named.order)

    # cells of a sliver take zone, block and contact interval of its new unit
    unit = parts.shells.unit_of_cell
    target = np.array(home)[unit[1:]]
    stay, part = np.unique(target, return_inverse=True)
    wholes, whole = np.unique(np.array(parts.of)[target], return_inverse=True)
    zone = np.concatenate([[-1], blocks.zone[wholes[whole]]])
    inside = np.concatenate([[-1], whole])
    new_blocks = _blocks_of(patches, cells, inside, zone, faults)
    new_parts = _Parts(
        shells_of(cells, np.concatenate([[-1], part])),
        np.searchsorted(wholes, np.array(parts.of)[stay]).tolist(),
        [parts.contact[u] for u in stay],
        [parts.beneath[u] for u in stay],
    )
    renamed = _Named(patches, named.zone_names, named.reservoir, new_blocks, new_parts)

    # the report: contacts by new names, and what became of each sliver
    position = {u: k for k, u in enumerate(wholes.tolist())}
    still = {name: [position[u] for u in of if u in position] for name, of in left.items()}
    report = {**units.report, "without_contact": _uncovered(renamed, still)}
    merged, inner = [], shared_faces(faces, home)
    for sliver in units.slivers:
        u = number[sliver.name]
        if home[u] != u:
            shared = inner[u]
            into = renamed.name(int(np.searchsorted(stay, home[u])))
            merged.append(
                MergedSliver(
                    sliver.name, sliver.volume, into, surfaces_of(cells, shared),
                    shared_area(cells, shared), sliver.place,
                )
            )  # fmt: skip
    return _units(renamed, report, units.sliver_settings, merged, units)


def _extent(patches: Patches, cells: Cells) -> tuple[Box, float | None, float | None]:
    """Bounds of the walls; area on the map and volume inside unless the walls are a box."""
    bounds = box_of(patches)
    lower, upper = bounds + patches.origin
    box = (lower[0], upper[0], lower[1], upper[1], lower[2], upper[2])
    if walls_are_a_box(patches, bounds):
        return box, None, None
    if is_fence(patches, bounds):
        return box, footprint_of(patches, bounds), None
    return box, *size_of_shells(patches.local, _outward_walls(cells))


@dataclass(frozen=True, eq=False)
class _FaultSides:
    """Sides of faults that units lie on, computed on first use; can be pickled."""

    cells: Cells
    unit_of_cell: np.ndarray
    faults: Faults
    words: list[tuple[str, ...]]

    @cached_property
    def found(self) -> list[tuple[str, ...]]:
        """Sides of faults of each unit, see `sides_of_units`."""
        return sides_of_units(self.cells, self.unit_of_cell, self.faults, self.words)

    def of(self, u: int) -> tuple[str, ...]:
        """Sides of faults of one unit."""
        return self.found[u]


@dataclass(frozen=True, eq=False)
class _Blocks:
    """Units of zone and block: of each cell, their zones, names, and sides of faults."""

    unit_of_cell: np.ndarray
    zone: np.ndarray
    names: list[str]
    words: list[tuple[str, ...]]
    sides: _FaultSides
    shells: Shells
    compartment_of: list[str]


def _blocks_of(
    patches: Patches, cells: Cells, unit_of_cell: np.ndarray, zone: np.ndarray, faults: Faults
) -> _Blocks:
    """Name the blocks of units, given the unit and the zone of each cell."""
    shells, zone_of_unit, words, names = _named_blocks(cells, unit_of_cell, zone, faults)
    sides = _FaultSides(cells, unit_of_cell, faults, words)
    within = _without_virtual(patches, cells, unit_of_cell, zone, faults)
    return _Blocks(unit_of_cell, zone_of_unit, names, words, sides, shells, within)


def _named_blocks(
    cells: Cells, unit_of_cell: np.ndarray, zone: np.ndarray, faults: Faults
) -> tuple[Shells, np.ndarray, list[tuple[str, ...]], list[str]]:
    """Shells, zones, sides of faults that set them apart, and names of the blocks of cells."""
    shells = shells_of(cells, unit_of_cell)
    zone_of_unit = np.zeros(len(shells.volumes), dtype=np.int64)
    zone_of_unit[unit_of_cell[1:]] = zone[1:]
    words = fault_sides(cells, unit_of_cell, zone_of_unit, faults)
    return (
        shells,
        zone_of_unit,
        words,
        name_blocks(words, zone_of_unit, shells.volumes, shells.corner),
    )


def _without_virtual(
    patches: Patches, cells: Cells, unit_of_cell: np.ndarray, zone: np.ndarray, faults: Faults
) -> list[str]:
    """The block that each unit would be a part of without virtual walls; '' if there are none."""
    virtual = _with_role(patches, "virtual")
    n_unit = int(unit_of_cell.max(initial=-1)) + 1
    if not virtual:
        return [""] * n_unit

    # units of one zone on the two sides of a virtual wall are one
    joined = _merge(patches, cells, zone, unit_of_cell)
    own = {name: [i for i in rows if i not in virtual] for name, rows in faults.items()}
    own = {name: rows for name, rows in own.items() if rows}
    *_, names = _named_blocks(cells, joined, zone, own)
    block = np.zeros(n_unit, dtype=np.int64)
    block[unit_of_cell[1:]] = joined[1:]
    return [names[k] for k in block.tolist()]


@dataclass(frozen=True, eq=False)
class _Parts:
    """Shells of the units that fluid contacts make of blocks, the block and interval of each."""

    shells: Shells
    of: list[int]
    contact: list[str]
    beneath: list[tuple[str, ...]]

    @classmethod
    def whole(cls, blocks: _Blocks) -> _Parts:
        """Blocks that no contact splits."""
        n = len(blocks.names)
        return cls(blocks.shells, list(range(n)), [""] * n, [()] * n)


@dataclass(frozen=True, eq=False)
class _Named:
    """Units with all that names them."""

    patches: Patches
    zone_names: list[str]
    reservoir: tuple[str, ...]
    blocks: _Blocks
    parts: _Parts

    @cached_property
    def order(self) -> list[int]:
        """Units zone by zone, block by block, from the top down."""
        zone, names, of = self.blocks.zone.tolist(), self.blocks.names, self.parts.of
        places = {name: block_order(name) for name in set(names)}  # zones have blocks in common
        return sorted(range(len(of)), key=lambda u: (zone[of[u]], places[names[of[u]]], u))

    def name(self, u: int) -> str:
        """Zone, block and contact interval of one unit."""
        whole = self.parts.of[u]
        zone = self.zone_names[self.blocks.zone[whole]]
        return unit_name(zone, self.blocks.names[whole], self.parts.contact[u])

    def unit(self, u: int) -> Unit:
        """One unit with its volume."""
        patches, blocks, parts = self.patches, self.blocks, self.parts
        name, whole, volume = self.name(u), parts.of[u], parts.shells.volumes[u]
        if volume <= 0:
            raise turned_inside_out(patches, parts.shells, u, name)
        zone, sides = int(blocks.zone[whole]), partial(blocks.sides.of, whole)
        return CarvedUnit(
            (parts.shells, u), sides, name=name, zone=self.zone_names[zone], zone_index=zone,
            block=blocks.names[whole], contact=parts.contact[u], beneath=parts.beneath[u],
            compartment_of=blocks.compartment_of[whole], origin=patches.origin,
            surface_names=patches.names, volume=volume,
        )  # fmt: skip


def _with_role(patches: Patches, role: str) -> list[int]:
    """Rows of the surfaces of one role."""
    return [i for i, source in enumerate(patches.sources) if source.role == role]


def _check_names(patches: Patches) -> None:
    """Raise an error if two surfaces, except walls, have one name: units are named after them."""
    if fault := shared_name((s.role, s.name) for s in patches.sources if s.role != "wall"):
        raise InputError(fault)


def _uncovered(named: _Named, left: dict[str, list[int]]) -> dict[str, tuple[str, ...]]:
    """Names of the blocks in zones that each contact does not cover, in order."""
    zone, blocks = named.blocks.zone, named.blocks.names
    uncovered = {}
    for name, units in left.items():
        rows = sorted(units, key=lambda u: (zone[u], block_order(blocks[u]), u))
        if rows:
            uncovered[name] = tuple(unit_name(named.zone_names[zone[u]], blocks[u]) for u in rows)
    return uncovered


def _units(
    named: _Named,
    report: dict[str, Any],
    settings: SliverSettings,
    merged: Sequence[MergedSliver] = (),
    unmerged: Units | None = None,
) -> Units:
    """All units in order."""
    patches, parts, order = named.patches, named.parts, named.order
    units = [named.unit(u) for u in order]
    box, footprint, volume = _extent(patches, parts.shells.cells)
    units_of_model = Units(
        [in_crs_of(unit, [patches]) for unit in units],
        box,
        {**report, "thin": thin_units(parts.shells, order, units)},
        footprint,
        sides=partial(beside_triangles, parts.shells, np.argsort(order)),
        piece_sides=partial(beside_pieces, parts.shells, np.argsort(order)),
        enclosed=volume,
        slivers=settings,
        merged=merged,
        unmerged=unmerged,
        reservoir=named.reservoir,
    )
    return in_crs_of(units_of_model, [patches])


def _outward_walls(cells: Cells) -> np.ndarray:
    """Triangles with the outside on one side, oriented towards it: rows of `Patches.local`."""
    # listed triangle by triangle: shells of any shape need each of them
    full = cells.in_full
    front, behind = (full.cell_of_side[:, k] == OUTSIDE for k in (0, 1))

    # triangles that see the outside behind them face inward: two corners swapped, all look outward
    t = full.patches.triangles[full.row]
    return np.concatenate([t[front & ~behind], t[behind & ~front][:, [0, 2, 1]]])


def _merge(
    patches: Patches, cells: Cells, zone: np.ndarray, units: np.ndarray | None = None
) -> np.ndarray:
    """Unit of each cell, -1 outside: cells of one zone are joined where no fault separates them.

    With the units that virtual walls separate: these are joined across virtual walls.
    """
    separates = np.zeros(len(cells.surface_of), dtype=bool)

    # horizons and contacts part zones and intervals, never blocks
    for i, source in enumerate(patches.sources):
        passed = ("horizon", "contact") if units is None else ("horizon", "contact", "virtual")
        if source.role not in passed:
            separates[owned_by(cells, i)] = True

    # across horizons and contacts, never across faults and walls, cells of one zone are one unit:
    # a clipped horizon or a contact that does not count parts nothing
    rows = faces_between(cells)
    pairs = distinct_pairs(cells.cell_of_side[rows[~separates[rows]]], cells.n_cell)
    pairs = pairs[zone[pairs[:, 0]] == zone[pairs[:, 1]]]
    if units is not None:
        _, first = np.unique(units[1:], return_index=True)
        cell = np.arange(1, cells.n_cell + 1)
        pairs = np.concatenate([pairs, np.stack([cell, 1 + first[units[1:]]], axis=1)])
    root = join_pairs(pairs, cells.n_cell + 1)

    # units are numbered without gaps; the outside has none
    _, number = np.unique(root[1:], return_inverse=True)
    return np.concatenate([[-1], number])


# ---- findings that the report of units lists: slits, thin units, faults outside of the model ----


def outside_faults(patches: Patches, cells: Cells, faults: list[int]) -> tuple[str, ...]:
    """Return the names of the faults that touch no cell inside the walls."""
    # all its faces see the outside on both sides
    return tuple(
        patches.names[i]
        for i in faults
        if not (cells.cell_of_side[owned_by(cells, i)] != OUTSIDE).any()
    )


def thin_units(shells: Shells, order: list[int], units: list[Unit]) -> tuple[Remnant, ...]:
    """Return units thinner than the rounding error of their vertices, in order."""
    thin = []
    for u, unit in zip(order, units, strict=True):
        if u in shells.thin:
            thin.append(Remnant(unit.name, unit.volume, unit.middle))
    return tuple(thin)


def slits(patches: Patches, cells: Cells, shells: Shells, faults: list[int]) -> dict[str, float]:
    """Return the area [m2] of each fault with one unit on both sides."""
    # one unit on both sides, and it is not the outside
    slit = (shells.sides[:, 0] == shells.sides[:, 1]) & (shells.sides[:, 0] >= 0)
    slit_rows = {}
    for i in faults:
        faces = owned_by(cells, i)
        slit_rows[i] = faces[slit[faces]]

    # only these are measured, and all at once: most models have none
    wanted = [rows for rows in slit_rows.values() if len(rows)]
    if not wanted:
        return {}
    areas = cells.sums[np.concatenate(wanted), AREA]
    parts = np.split(areas, np.cumsum([len(rows) for rows in wanted])[:-1])
    names = [patches.names[i] for i in faults if len(slit_rows[i])]
    return {n: math.fsum(part.ravel().tolist()) for n, part in zip(names, parts, strict=True)}
