"""Findings that the report of units lists: slits, thin units, faults outside of the model."""

from __future__ import annotations

import math

import numpy as np

from geosurf.carve.cells import OUTSIDE, Cells
from geosurf.carve.measures import AREA
from geosurf.carve.shells import Shells
from geosurf.carve.zones import owned_by
from geosurf.model import Patches, Unit
from geosurf.model.column import Remnant


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
    found = []
    for u, unit in zip(order, units, strict=True):
        if u in shells.thin:
            found.append(Remnant(unit.name, unit.volume, unit.middle))
    return tuple(found)


def slits(patches: Patches, cells: Cells, shells: Shells, faults: list[int]) -> dict[str, float]:
    """Return the area [m2] of each fault with one unit on both sides."""
    # one unit on both sides, and it is not the outside
    slit = (shells.sides[:, 0] == shells.sides[:, 1]) & (shells.sides[:, 0] >= 0)
    found = {}
    for i in faults:
        mine = owned_by(cells, i)
        found[i] = mine[slit[mine]]

    # only these are measured, and all at once: most models have none
    wanted = [rows for rows in found.values() if len(rows)]
    if not wanted:
        return {}
    areas = cells.extent_of(np.concatenate(wanted))[:, AREA]
    parts = np.split(areas, np.cumsum([len(rows) for rows in wanted])[:-1])
    names = [patches.names[i] for i in faults if len(found[i])]
    return {n: math.fsum(part.ravel().tolist()) for n, part in zip(names, parts, strict=True)}
