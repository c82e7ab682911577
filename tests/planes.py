"""A small world as scenario files have it: two tilted planes and a fault, in a box."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import geosurf as gs
from geosurf.synthetic.world import World

INPUTS = """
[[horizons]]
name = "Top"
file = "Top.nc"

[[horizons]]
name = "Base"
file = "Base.nc"

[[faults]]
name = "F1"
file = "F1.nc"

[box]
easting_m = [0, 4000]
northing_m = [0, 3000]
elevation_m = [-2500, -1700]
"""


def write_grids(folder: Path) -> World:
    """Write the grids that `INPUTS` names; return the world that they are from."""
    world = gs.synthetic.tilted_planes(n=5)
    scenario_tables(folder, world.horizons, world.faults)
    return world


def scenario_tables(folder: Path, horizons: dict, faults: dict | None = None) -> str:
    """Write surfaces as files; the tables of a scenario that name them."""
    tables = ""
    for kind, surfaces in (("horizons", horizons), ("faults", faults or {})):
        for name, one in surfaces.items():
            file = f"{name}.ts" if isinstance(one, gs.TriSurface) else f"{name}.nc"
            gs.write(one, folder / file)
            tables += f'[[{kind}]]\nname = "{name}"\nfile = "{file}"\n'
    return tables


def between(fault: gs.TriSurface, low: float, high: float) -> gs.TriSurface:
    """The part of a plane fault between two levels, as long as it is."""
    middle = fault.vertices.mean(axis=0)
    normal = np.linalg.svd(fault.vertices - middle, full_matrices=False)[2][2]
    strike = np.array([-normal[1], normal[0], 0.0]) / np.hypot(*normal[:2])
    dip = np.cross(normal, strike)
    along = (fault.vertices - middle) @ strike
    west, east = along.min(), along.max()
    corners = [
        middle + s * strike + (z - middle[2]) / dip[2] * dip
        for s, z in ((west, low), (east, low), (east, high), (west, high))
    ]
    return gs.triangulate_fault((corners, [[0, 1, 2], [0, 2, 3]]), name=fault.name)
