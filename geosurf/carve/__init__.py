"""Patches -> closed units: zone x fault block, with certified volumes."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from geosurf.carve.blocks import block_order, name_blocks
from geosurf.carve.cells import Cells, box_of, find_cells
from geosurf.carve.volume import volume_of
from geosurf.carve.zones import distinct_pairs, faces_between, owned_by, zones_of
from geosurf.errors import InputError, InvariantError
from geosurf.model import Patches, Unit, Units, frozen

__all__ = ["carve_units"]


def carve_units(patches: Patches) -> Units:
    """
    Carve the model box into closed units, named by zone and fault block.

    Parameters
    ----------
    patches : Patches
        Of horizons (role ``"horizon"``, youngest first), faults (role ``"fault"``, any
        number) and the six walls of the model box (role ``"wall"``, see `build_walls`).

    Returns
    -------
    Units
        Zone by zone, youngest first. The zone of a piece of space is named by the first
        horizon that it lies above; where horizons cross, the younger one cuts the older
        (listed in ``report["crossings"]``). A fault separates blocks only where there is no way
        around it; one that dies inside leaves a slit (``report["slits"]``).

    Raises
    ------
    GeometryError
        If there are no walls, or a horizon is not in the box.
    OpenUnitError
        If a unit leaks: a horizon does not reach the walls, or has a hole. The message gives
        the length of the open rim and a place.

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
    if not isinstance(patches, Patches):
        raise InputError(
            f"carve_units takes Patches, not {type(patches).__name__}; rebuild_surfaces makes them."
        )
    roles = [source.role for source in patches.sources]
    horizons = [i for i, role in enumerate(roles) if role == "horizon"]
    faults = [i for i, role in enumerate(roles) if role == "fault"]
    cells = find_cells(patches)
    zone, crossed = zones_of(patches, cells, horizons)
    unit_of_cell = _merge(cells, zone, horizons)
    sides = np.where(cells.cell_of_side > 0, unit_of_cell[cells.cell_of_side], -1)
    zone_of_unit = np.zeros(unit_of_cell.max(initial=-1) + 1, dtype=np.int64)
    zone_of_unit[unit_of_cell[1:]] = zone[1:]
    # vertices sorted by coordinates: shells and sums do not depend on the order of surfaces
    order = np.lexsort(patches.local.T[::-1])
    x, rank = patches.local[order], np.argsort(order)
    shells = [_shell(rank[cells.triangles], sides, u) for u in range(len(zone_of_unit))]
    volumes = [volume_of(x, t) for t, _ in shells]
    names = _zone_names([patches.names[i] for i in horizons])
    blocks = name_blocks(patches, cells, sides, zone_of_unit, np.array(volumes), faults)
    units = []
    for u in sorted(range(len(shells)), key=lambda u: (zone_of_unit[u], block_order(blocks[u]))):
        zone_name, zone_index = names[zone_of_unit[u]], int(zone_of_unit[u])
        owner = cells.surface_of[shells[u][1]]
        units.append(
            _unit(patches, x, shells[u][0], owner, volumes[u], zone_name, zone_index, blocks[u])
        )
    lower, upper = box_of(patches) + patches.origin
    box = (lower[0], upper[0], lower[1], upper[1], lower[2], upper[2])
    return Units(units, box, _report(patches, cells, sides, crossed, unit_of_cell, volumes, faults))


def _zone_names(horizons: list[str]) -> list[str]:
    """``above Top``, ``Top/Base``, ``below Base``."""
    if not horizons:
        return ["box"]
    between = [f"{a}/{b}" for a, b in pairwise(horizons)]
    return [f"above {horizons[0]}", *between, f"below {horizons[-1]}"]


def _merge(cells: Cells, zone: np.ndarray, horizons: list[int]) -> np.ndarray:
    """Unit of each cell: cells of one zone are one where only a clipped horizon parts them."""
    unit = np.arange(cells.n_cell + 1)
    rows = faces_between(cells)
    is_horizon = np.zeros(len(cells.triangles), dtype=bool)
    for horizon in horizons:
        is_horizon[owned_by(cells, horizon)] = True
    pairs = distinct_pairs(cells.cell_of_side[rows[is_horizon[rows]]], cells.n_cell)
    for a, b in pairs.tolist():
        if zone[a] == zone[b]:
            unit[unit == unit[b]] = unit[a]
    _, number = np.unique(unit[1:], return_inverse=True)
    return np.concatenate([[-1], number])


def _shell(triangles: np.ndarray, sides: np.ndarray, u: int):
    """Outward triangles of a unit, and their rows; slits (seen from both sides) are left out.

    Each starts at its lowest corner, and they are sorted by corners.
    """
    front, behind = sides[:, 0] == u, sides[:, 1] == u
    rows = np.flatnonzero(front != behind)
    t = triangles[rows]
    inward = front[rows]
    t[inward] = t[inward][:, [0, 2, 1]]
    first = t.argmin(axis=1)[:, None]
    t = np.take_along_axis(t, (first + np.arange(3)) % 3, axis=1)
    order = np.lexsort((t[:, 2], t[:, 1], t[:, 0]))
    return t[order], rows[order]


def _unit(patches, x, triangles, owner, volume, zone, zone_index, block) -> Unit:
    used, faces = np.unique(triangles, return_inverse=True)
    faces = faces.reshape(-1, 3)
    local = x[used]
    a, b, c = (local[faces[:, k]] for k in range(3))
    area = math.fsum(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))
    if volume <= 0:
        raise InvariantError(
            f"unit {zone} {block} has a volume of {volume:g} m3; please report this with the "
            "surfaces."
        )
    return Unit(
        name=zone if block == "whole" else f"{zone} {block}",
        zone=zone,
        zone_index=zone_index,
        block=block,
        local=frozen(local, np.float64),
        origin=patches.origin,
        triangles=frozen(faces, np.int64),
        surface_of_triangle=frozen(owner, np.int64),
        surface_names=patches.names,
        volume=volume,
        area=area,
    )


def _report(patches, cells, sides, crossed, unit_of_cell, volumes, faults) -> dict:
    """Slits of faults that die inside, and places where horizons cross."""
    slit = np.flatnonzero((sides[:, 0] == sides[:, 1]) & (sides[:, 0] >= 0))
    t = cells.triangles[slit]
    a, b, c = (patches.local[t[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    surface = cells.surface_of[slit]
    slits = {
        patches.names[i]: float(area[surface == i].sum()) for i in faults if (surface == i).any()
    }
    crossings = []
    for cell in np.flatnonzero(crossed[1:]) + 1:
        front, behind = (cells.cell_of_side[:, k] == cell for k in (0, 1))
        rows = np.flatnonzero(front != behind)
        corners = cells.triangles[rows].copy()
        corners[front[rows]] = corners[front[rows]][:, [0, 2, 1]]
        middle = patches.local[corners].mean(axis=(0, 1)) + patches.origin
        crossings.append({"volume": volume_of(patches.local, corners), "place": middle.tolist()})
    return {"slits": slits, "crossings": crossings, "cells": cells.n_cell}
