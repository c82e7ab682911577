"""A small world as scenario files have it: two tilted planes and a fault, in a box."""

from __future__ import annotations

from pathlib import Path

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
    for name, surface in {**world.horizons, **world.faults}.items():
        gs.write(surface, folder / f"{name}.nc")
    return world
