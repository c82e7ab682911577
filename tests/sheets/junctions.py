"""Three upright faults that meet in one line: blocks are level, so throw is known up to it.

Three half planes that share an edge, a bent main fault with a branch at its bend, and a straight
main fault with a branch, in turn, at random azimuths, places and throws; all share the vertices of
the line in which they meet, so that no fault stops short of it by a rounding.
"""

from __future__ import annotations

import numpy as np

import geosurf as gs
from tests.grids import gridded

CELL = 40.0
KINDS = ("half planes", "bent main fault", "straight main fault")


def wall(name, *trace):
    """An upright fault along a line in the map."""
    corners = [[*p, z] for p in trace for z in (-2300.0, -1200.0)]
    faces = []
    for a in range(0, 2 * len(trace) - 2, 2):
        faces += [[a, a + 2, a + 3], [a, a + 3, a + 1]]
    return gs.TriSurface(name, "fault", np.array(corners), faces)


def junction(kind: str, rng: np.random.Generator):
    """Grid, faults, the point where they meet, azimuths of three rays, and throw of each ray."""
    middle = np.array([2003.0, 1502.0]) + rng.uniform(-300.0, 300.0, 2)
    first = rng.uniform(0.0, 360.0)
    turns = np.array([180.0, rng.uniform(230.0, 310.0)])
    if kind != "straight main fault":
        turns = np.array([rng.uniform(70.0, 150.0), rng.uniform(215.0, 290.0)])
    azimuth = np.append(first, first + turns) % 360.0
    level = rng.permutation([0.0, -40.0, -80.0])
    x, y = np.arange(-200.0, 4201.0, CELL), np.arange(-200.0, 3201.0, CELL)
    px, py = np.meshgrid(x, y)
    turn = (np.degrees(np.arctan2(px - middle[0], py - middle[1])) - first) % 360.0
    z = -1600.0 + np.select([turn < turns[0], turn < turns[1]], level[:2], level[2])
    grid = gridded(z, x, y)
    a, b, c = (
        middle + 4000.0 * np.array([np.sin(np.radians(t)), np.cos(np.radians(t))]) for t in azimuth
    )
    faults = [wall("F1", a, middle, b), wall("F3", middle, c)]
    if kind == "half planes":
        faults = [wall("F1", middle, a), wall("F2", middle, b), wall("F3", middle, c)]
    throw = np.abs(level - np.roll(level, 1))  # ray k lies between blocks k - 1 and k
    return grid, {fault.name: fault for fault in faults}, middle, azimuth, throw


def misses(sheet, middle, azimuth, throw) -> tuple[float, float]:
    """Largest miss of throw from half a cell of the junction on, in the largest; beyond six."""
    worst = [0.0, 0.0]
    for cut in sheet.cuts.values():
        away = cut.stations[:, :2] - middle
        far = np.hypot(*away.T) / CELL
        inside = (np.abs(cut.stations[:, :2] - (2000.0, 1500.0)) < (2100.0, 1600.0)).all(axis=1)
        turn = np.degrees(np.arctan2(*away.T))
        off = np.abs((turn[:, None] - azimuth + 180.0) % 360.0 - 180.0)
        true = throw[off.argmin(axis=1)]
        miss = np.abs(np.abs(cut.throw) - true) / throw.max()
        miss = np.where(np.isnan(miss), 1.0, miss)
        for k, least in enumerate((0.5, 6.0)):
            worst[k] = max(worst[k], miss[inside & (far > least)].max(initial=0.0))
    return worst[0], worst[1]
