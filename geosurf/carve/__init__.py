"""Patches -> closed units: zone x fault block (x fluid contact), with certified volumes.

===============  ====================================================================
sides.py         parts of surfaces, and their sides that see each other across an edge
cells.py         cells of space, and the faces between them
floating.py      pieces that touch nothing else
measures.py      volume below, areas and bounds of faces
zones.py         on which side of each horizon and contact each cell is
column.py        the rules of the column: sides -> zones
clipped.py       what these rules took away, and where
blocks.py        units of a zone, named by the sides of faults
fluids.py        units split at their fluid contacts
outside.py       which cells lie beyond the walls
shells.py        closed shells with volumes
thin.py          what to tell of units as thin as rounding
certificate.py   promises, checked anew on the result
consistent.py    of these: units against the patches
told.py          of these: names of units against the surfaces around them
around.py        what lies between units, told anew
===============  ====================================================================
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from geosurf.carve.blocks import block_order, fault_sides, name_blocks, sides_of_units
from geosurf.carve.cells import OUTSIDE, Cells, find_cells
from geosurf.carve.clipped import clipped_by
from geosurf.carve.column import apply_column, names_of_zones, zones_of
from geosurf.carve.fluids import (
    check_zones,
    contacts_of_units,
    level_of,
    not_reached,
    split_by_contacts,
)
from geosurf.carve.measures import AREA
from geosurf.carve.outside import (
    box_of,
    footprint_of,
    is_fence,
    size_of_shells,
    walls_are_a_box,
)
from geosurf.carve.shells import Shells, beside_triangles, build_unit, shells_of, unit_name
from geosurf.carve.zones import distinct_pairs, faces_between, owned_by, signatures
from geosurf.errors import InputError
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.model import FluidContact, Patches, Unit, Units, check_column
from geosurf.model.base import in_crs_of
from geosurf.model.column import Remnant
from geosurf.model.expected import expect

__all__ = ["carve_units"]


def carve_units(
    patches: Patches,
    column: Mapping[str, str] | None = None,
    contacts: Sequence[FluidContact] = (),
) -> Units:
    """
    Carve the model box into closed units, named by zone and fault block.

    Parameters
    ----------
    patches : Patches
        Of horizons (role ``"horizon"``, youngest first), faults (role ``"fault"``, any
        number), fluid contacts (role ``"contact"``) and the walls of the model (role ``"wall"``):
        those of `build_walls`, or any closed shells; what they part from the distance is inside.
    column : mapping of str to str, optional
        ``"conformable"``, ``"erosional"`` (removes what lies below), ``"base"`` (what
        lies above laps onto it and is removed below it) or ``"discontinuous"`` (both), by horizon.
        Default: all are conformable.
    contacts : sequence of FluidContact, optional
        Which contact counts in which zones and block, from the top down; see `build_contacts`.

    Returns
    -------
    Units
        Zone by zone, youngest first; in each, block by block, from the top down. Horizons
        that cross are clipped by the column, of two conformable ones the older one at the younger:
        ``report["clipped"]`` lists each, with place and amount. A fault separates
        blocks only where there is no way around it; one that dies inside leaves a slit
        (``report["slits"]``). A contact that is given for some blocks counts on these sides of
        faults (`Unit.fault_sides`); ``report["without_contact"]`` lists the units that it leaves
        out, and ``report["outside"]`` the faults that do not reach the model. Surfaces that meet
        in a point or a line but for the last digits have a unit between them:
        ``report["thin"]`` lists those that are as thin as the rounding of their corners.

    Raises
    ------
    InputError
        For an unknown rule, horizon, zone or block, or a name that two surfaces (walls aside) or
        two zones have.
    GeometryError
        If there are no walls, a horizon is not in the box, or contacts cross.
    OpenUnitError
        If a unit leaks: a horizon does not reach the walls, or has a hole, where no rule of the
        column removes it. The message gives the length of the open rim and a place.
    GeometryError
        If a surface that crosses itself, and was not split there, turns a unit inside out.
    RoundingError
        If rounding its corners to float64 turns a unit inside out.

    Notes
    -----
    Cells follow from the exact radial order of triangles around each edge (a Weiler model,
    cf. Levy 2024, arXiv 2405.12949), volumes from the divergence theorem with compensated sums.

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
    horizons, faults = (_with_role(patches, role) for role in ("horizon", "fault"))
    _refuse_namesakes(patches)
    rules = check_column([patches.names[i] for i in horizons], column)
    zone_names = names_of_zones([patches.names[i] for i in horizons])
    check_zones(contacts, zone_names)
    levels = [level_of(patches, contact) for contact in contacts]
    cells = find_cells(patches)
    signature = signatures(patches, cells, [*horizons, *levels])
    side, turns = apply_column(signature[: len(horizons)], rules)
    zone = zones_of(patches, cells, side, horizons)
    whole = _merge(patches, cells, zone)
    shells = shells_of(cells, whole)
    zone_of_unit = np.zeros(len(shells.volumes), dtype=np.int64)
    zone_of_unit[whole[1:]] = zone[1:]
    words = fault_sides(patches, cells, whole, zone_of_unit, faults)
    blocks = name_blocks(words, zone_of_unit, shells.volumes, shells.corner)
    sides_of_blocks = _FaultSides(cells, whole, faults, words)
    every = list(range(len(blocks)))
    named = _Named(zone_of_unit, blocks, [""] * len(blocks), [()] * len(blocks), every, every)
    left: dict[str, tuple[str, ...]] = {}
    if levels:
        names = [patches.names[i] for i in faults]
        zones = [zone_names[k] for k in zone_of_unit.tolist()]
        counted = contacts_of_units(contacts, zones, words, sides_of_blocks.found, names)
        left = _left_out(named, not_reached(contacts, counted, zones), zone_names)
        sides_of_level = signature[len(horizons) :]
        part, of, labels, beneath = split_by_contacts(
            patches, cells, sides_of_level, contacts, counted, whole
        )
        shells = shells_of(cells, part)
        named = _Named(
            zone_of_unit[of], [blocks[u] for u in of], labels, beneath, list(range(len(of))), of,
        )  # fmt: skip
    order = _order(named)
    units = _units(patches, shells, named, order, zone_names, sides_of_blocks)
    report = {
        "slits": _slits(patches, cells, shells, faults),
        "clipped": clipped_by(patches, cells, turns, horizons),
        "cells": cells.n_cell,
        "without_contact": left,
        "outside": _outside(patches, cells, faults),
        "thin": _thin(shells, order, units),
    }
    bounds = box_of(patches)
    lower, upper = bounds + patches.origin
    box = (lower[0], upper[0], lower[1], upper[1], lower[2], upper[2])
    footprint = volume = None
    if not walls_are_a_box(patches, bounds):
        if is_fence(patches, bounds):
            footprint = footprint_of(patches, bounds)
        else:
            footprint, volume = size_of_shells(patches.local, _outward_walls(cells))
    number = np.argsort(order)
    beside = partial(beside_triangles, shells, number)
    found = Units(units, box, report, footprint, sides=beside, enclosed=volume)
    return in_crs_of(found, [patches])


@dataclass(frozen=True, eq=False)
class _FaultSides:
    """Sides of faults that units lie on, found when they are first asked for; can be pickled."""

    cells: Cells
    unit_of_cell: np.ndarray
    faults: list[int]
    words: list[tuple[str, ...]]

    @cached_property
    def found(self) -> list[tuple[str, ...]]:
        """Of each unit, see `sides_of_units`."""
        return sides_of_units(self.cells, self.unit_of_cell, self.faults, self.words)

    def of(self, u: int) -> tuple[str, ...]:
        """Of one unit."""
        return self.found[u]


@dataclass(frozen=True)
class _Named:
    """Zone, block, contact interval and place in the order of each unit, and what it is part of."""

    zone: np.ndarray
    block: list[str]
    contact: list[str]
    beneath: list[tuple[str, ...]]
    rank: list[int]
    whole: list[int]


def _with_role(patches: Patches, role: str) -> list[int]:
    return [i for i, source in enumerate(patches.sources) if source.role == role]


def _refuse_namesakes(patches: Patches) -> None:
    """Refuse two surfaces of one name, but for walls: units and measures go by name."""
    seen: dict[str, str] = {}
    for source in patches.sources:
        if source.role == "wall":
            continue
        if source.name in seen:
            raise InputError(
                f"the name {source.name!r} is used by a {seen[source.name]} and by another "
                f"{source.role}. Rename one of them."
            )
        seen[source.name] = source.role


def _order(named: _Named) -> list[int]:
    """Units zone by zone, block by block, from the top down."""
    return sorted(
        range(len(named.block)),
        key=lambda u: (named.zone[u], block_order(named.block[u]), named.rank[u]),
    )


def _left_out(
    named: _Named, left: dict[str, list[int]], zone_names: list[str]
) -> dict[str, tuple[str, ...]]:
    """Names of the units that each contact does not reach, in order."""
    found = {}
    for name, units in left.items():
        rows = [u for u in _order(named) if u in set(units)]
        found[name] = tuple(unit_name(zone_names[named.zone[u]], named.block[u]) for u in rows)
    return found


def _units(
    patches: Patches,
    shells: Shells,
    named: _Named,
    order: list[int],
    zone_names: list[str],
    fault_sides: _FaultSides,
) -> list[Unit]:
    """All units in order."""
    units = (
        build_unit(
            patches,
            shells,
            u,
            zone=zone_names[named.zone[u]],
            zone_index=int(named.zone[u]),
            block=named.block[u],
            contact=named.contact[u],
            beneath=named.beneath[u],
            sides=partial(fault_sides.of, named.whole[u]),
        )
        for u in order
    )
    return [in_crs_of(unit, [patches]) for unit in units]


def _outward_walls(cells: Cells) -> np.ndarray:
    """Triangles that have the outside on one side, turned to it: rows of `Patches.local`."""
    full = cells.in_full
    front, behind = (full.cell_of_side[:, k] == OUTSIDE for k in (0, 1))
    t = full.patches.triangles[full.row]
    return np.concatenate([t[front & ~behind], t[behind & ~front][:, [0, 2, 1]]])


def _merge(patches: Patches, cells: Cells, zone: np.ndarray) -> np.ndarray:
    """Unit of each cell, -1 outside: cells of one zone are one where no fault parts them."""
    parting = np.zeros(len(cells.surface_of), dtype=bool)
    for i, source in enumerate(patches.sources):
        if source.role not in ("horizon", "contact"):
            parting[owned_by(cells, i)] = True
    rows = faces_between(cells)
    pairs = distinct_pairs(cells.cell_of_side[rows[~parting[rows]]], cells.n_cell)
    root = join_pairs(pairs[zone[pairs[:, 0]] == zone[pairs[:, 1]]], cells.n_cell + 1)
    _, number = np.unique(root[1:], return_inverse=True)
    return np.concatenate([[-1], number])


def _outside(patches: Patches, cells: Cells, faults: list[int]) -> tuple[str, ...]:
    """Names of the faults that no cell inside the walls has beside it."""
    return tuple(
        patches.names[i]
        for i in faults
        if not (cells.cell_of_side[owned_by(cells, i)] != OUTSIDE).any()
    )


def _thin(shells: Shells, order: list[int], units: list[Unit]) -> tuple[Remnant, ...]:
    """Units that are as thin as the rounding of their corners, in order."""
    found = []
    for u, unit in zip(order, units, strict=True):
        if u in shells.thin:
            low, high = unit.vertices.min(axis=0), unit.vertices.max(axis=0)
            east, north, up = (0.5 * (low + high)).tolist()
            found.append(Remnant(unit.name, unit.volume, (east, north, up)))
    return tuple(found)


def _slits(patches: Patches, cells: Cells, shells: Shells, faults: list[int]) -> dict[str, float]:
    """Area of each fault that has one unit on both sides, as one that dies inside [m2]."""
    slit = (shells.sides[:, 0] == shells.sides[:, 1]) & (shells.sides[:, 0] >= 0)
    found = {}
    for i in faults:
        mine = owned_by(cells, i)
        mine = mine[slit[mine]]
        if len(mine):  # areas are added up for those that there are
            found[patches.names[i]] = math.fsum(cells.extent[mine, AREA].ravel().tolist())
    return found
