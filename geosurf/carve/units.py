"""Carve the model box into closed units: the steps from patches to units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from geosurf.carve.blocks import block_order, fault_sides, name_blocks, sides_of_units
from geosurf.carve.cells import OUTSIDE, Cells, find_cells
from geosurf.carve.clipped import clipped_by
from geosurf.carve.column import apply_column, names_of_zones, zones_of
from geosurf.carve.findings import outside_faults, slits, thin_units
from geosurf.carve.fluids import (
    check_zones,
    contacts_of_units,
    level_of,
    not_reached,
    split_by_contacts,
)
from geosurf.carve.outside import (
    box_of,
    footprint_of,
    is_fence,
    size_of_shells,
    walls_are_a_box,
)
from geosurf.carve.shells import Shells, beside_triangles, build_unit, shells_of, unit_name
from geosurf.carve.zones import distinct_pairs, faces_between, owned_by, signatures
from geosurf.conventions import shared_name
from geosurf.errors import InputError
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.model import FluidContact, Patches, Unit, Units, check_column
from geosurf.model.base import in_crs_of
from geosurf.model.expected import expect

Box = tuple[float, float, float, float, float, float]


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
        Patches of horizons (role ``"horizon"``, youngest first), faults (role ``"fault"``, any
        number), fluid contacts (role ``"contact"``) and walls (role ``"wall"``). Walls are those
        of `build_walls`, or any closed shells that enclose the model.
    column : mapping of str to str, optional
        Rule of each horizon: ``"conformable"``, ``"erosional"`` (removes older layers below it),
        ``"base"`` (younger layers lap onto it and are removed below it) or ``"discontinuous"``
        (both). Default: all horizons are conformable.
    contacts : sequence of FluidContact, optional
        Fluid contacts with their zones and blocks, from the top down; see `build_contacts`.

    Returns
    -------
    Units
        Units ordered by zone (youngest first), block, and contact interval (from the top down).

        - Where horizons cross, the column clips one of them; of two conformable horizons the
          older one ends at the younger one. ``report["clipped"]`` lists area, volume and place.
        - A fault separates blocks only if there is no way around it. A fault that ends inside a
          unit is a slit; ``report["slits"]`` has its area.
        - A contact of some blocks applies on these sides of faults (``Unit.fault_sides``);
          ``report["without_contact"]`` lists the units that it does not cover.
        - ``report["outside"]`` lists faults outside of the model.
        - ``report["thin"]`` lists units thinner than the rounding error of their vertices, which
          lie between surfaces that almost coincide.

    Raises
    ------
    InputError
        For an unknown rule, horizon, zone or block, or if two surfaces (except walls) or two zones
        have the same name.
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
    horizons, faults = (_with_role(patches, role) for role in ("horizon", "fault"))
    _check_names(patches)
    rules = check_column([patches.names[i] for i in horizons], column)
    zone_names = names_of_zones([patches.names[i] for i in horizons])
    check_zones(contacts, zone_names)
    levels = [level_of(patches, contact) for contact in contacts]

    # cells of space, each with its side of all horizons and contacts; the column makes zones of it
    cells = find_cells(patches)
    signature = signatures(patches, cells, [*horizons, *levels])
    side, turns = apply_column(signature[: len(horizons)], rules)
    zone = zones_of(patches, cells, side, horizons)

    # a block is all cells of a zone that are connected without crossing a fault
    # unit of each cell, int64 (n_cell + 1,), -1 for cell 0, which is the outside
    whole = _merge(patches, cells, zone)
    shells = shells_of(cells, whole)
    zone_of_unit = np.zeros(len(shells.volumes), dtype=np.int64)
    zone_of_unit[whole[1:]] = zone[1:]

    # sides of faults that part the blocks of one zone: they name the blocks
    words = fault_sides(patches, cells, whole, zone_of_unit, faults)
    blocks = name_blocks(words, zone_of_unit, shells.volumes, shells.corner)
    sides_of_blocks = _FaultSides(cells, whole, faults, words)
    rows = list(range(len(blocks)))

    # rows of the whole units; `of` maps parts to them once contacts have split them
    named = _Named(zone_of_unit, blocks, [""] * len(blocks), [()] * len(blocks), rows, rows)

    # fluid contacts split blocks; an entry for some blocks or zones leaves others whole
    uncovered: dict[str, tuple[str, ...]] = {}
    if levels:
        names = [patches.names[i] for i in faults]
        zones = [zone_names[k] for k in zone_of_unit.tolist()]
        applied = contacts_of_units(contacts, zones, words, sides_of_blocks.found, names)
        uncovered = _uncovered(named, not_reached(contacts, applied, zones), zone_names)
        part, of, labels, beneath = split_by_contacts(
            patches, cells, signature[len(horizons) :], contacts, applied, whole
        )
        shells = shells_of(cells, part)
        named = _Named(
            zone_of_unit[of], [blocks[u] for u in of], labels, beneath, list(range(len(of))), of,
        )  # fmt: skip

    # first the zone, then the block's name, then the contact interval: a stable order whatever the
    # numbers of cells
    order = _order(named)
    units = _units(patches, shells, named, order, zone_names, sides_of_blocks)
    report = {
        "slits": slits(patches, cells, shells, faults),
        "clipped": clipped_by(patches, cells, turns, horizons),
        "cells": cells.n_cell,
        "without_contact": uncovered,
        "outside": outside_faults(patches, cells, faults),
        "thin": thin_units(shells, order, units),
    }

    # None stands for what follows from the box; other walls are measured
    box, footprint, volume = _extent(patches, cells)
    beside = partial(beside_triangles, shells, np.argsort(order))
    found = Units(units, box, report, footprint, sides=beside, enclosed=volume)
    return in_crs_of(found, [patches])


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
    faults: list[int]
    words: list[tuple[str, ...]]

    @cached_property
    def found(self) -> list[tuple[str, ...]]:
        """Sides of faults of each unit, see `sides_of_units`."""
        return sides_of_units(self.cells, self.unit_of_cell, self.faults, self.words)

    def of(self, u: int) -> tuple[str, ...]:
        """Sides of faults of one unit."""
        return self.found[u]


@dataclass(frozen=True)
class _Named:
    """Zone, block, contact interval and rank of each unit, and the whole unit it is a part of."""

    zone: np.ndarray
    block: list[str]
    contact: list[str]
    beneath: list[tuple[str, ...]]
    rank: list[int]
    whole: list[int]


def _with_role(patches: Patches, role: str) -> list[int]:
    """Rows of the surfaces of one role."""
    return [i for i, source in enumerate(patches.sources) if source.role == role]


def _check_names(patches: Patches) -> None:
    """Raise an error if two surfaces, except walls, have one name: units are named after them."""
    if fault := shared_name((s.role, s.name) for s in patches.sources if s.role != "wall"):
        raise InputError(fault)


def _order(named: _Named) -> list[int]:
    """Units zone by zone, block by block, from the top down."""
    return sorted(
        range(len(named.block)),
        key=lambda u: (named.zone[u], block_order(named.block[u]), named.rank[u]),
    )


def _uncovered(
    named: _Named, left: dict[str, list[int]], zone_names: list[str]
) -> dict[str, tuple[str, ...]]:
    """Names of the units that each contact does not cover, in order."""
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
    """Triangles with the outside on one side, oriented towards it: rows of `Patches.local`."""
    # listed triangle by triangle: shells of any shape need each of them
    full = cells.in_full
    front, behind = (full.cell_of_side[:, k] == OUTSIDE for k in (0, 1))

    # triangles that see the outside behind them face inward: two corners swapped, all look outward
    t = full.patches.triangles[full.row]
    return np.concatenate([t[front & ~behind], t[behind & ~front][:, [0, 2, 1]]])


def _merge(patches: Patches, cells: Cells, zone: np.ndarray) -> np.ndarray:
    """Unit of each cell, -1 outside: cells of one zone are joined where no fault separates them."""
    separates = np.zeros(len(cells.surface_of), dtype=bool)

    # horizons and contacts part zones and intervals, never blocks
    for i, source in enumerate(patches.sources):
        if source.role not in ("horizon", "contact"):
            separates[owned_by(cells, i)] = True

    # across horizons and contacts, never across faults and walls, cells of one zone are one unit:
    # a clipped horizon or a contact that does not count parts nothing
    rows = faces_between(cells)
    pairs = distinct_pairs(cells.cell_of_side[rows[~separates[rows]]], cells.n_cell)
    root = join_pairs(pairs[zone[pairs[:, 0]] == zone[pairs[:, 1]]], cells.n_cell + 1)

    # units are numbered without gaps; the outside has none
    _, number = np.unique(root[1:], return_inverse=True)
    return np.concatenate([[-1], number])
