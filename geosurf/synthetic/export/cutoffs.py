"""Cut-off lines and throw of the field, sector by sector."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geosurf.synthetic.export.geology import Geology, Horizon, reach
from geosurf.synthetic.torn_faults import exists

ALONG = 5.0  # between points of a line [m]
MARGIN = 200.0  # of lines beyond the grids [m]
MOST_ROUNDS = 60
CLOSE = 1e-9  # [m]

Signs = tuple[int, ...]


class Wall(NamedTuple):
    """A wall of a fault in one sector: places of its cut-off, and where the sector exists."""

    signs: Signs
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    there: np.ndarray


@lru_cache(maxsize=128)
def walls(
    geology: Geology, horizon: Horizon, name: str, sign: int
) -> tuple[np.ndarray, list[Wall]]:
    """Distances along strike, and the cut-offs of a wall (1 hanging, -1 foot) in each sector."""
    fault, which = geology.faults[name], list(geology.faults).index(name)
    first, last = reach(fault, MARGIN)
    s = np.linspace(first, last, int((last - first) / ALONG) + 1)
    found = []

    # one line for each sector that touches this wall
    for signs in _relevant(geology, horizon, name, s):
        if signs[which] != sign:
            continue
        x, y, z = _meeting(geology, horizon, name, signs, s)

        # 0 for the fault itself: on its own plane the side is undecided
        others = tuple(0 if k == which else v for k, v in enumerate(signs))
        found.append(Wall(signs, x, y, z, exists(geology.faults, others, x, y, z)))
    return s, found


def cutoff_line(
    geology: Geology, horizon: Horizon, name: str, wall: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Distance along strike, x, y, z of a cut-off line wherever its wall exists."""
    s, sectors = walls(geology, horizon, name, 1 if wall == "+" else -1)

    # sectors take turns along the fault; sorted by s they make one line
    parts = [np.stack([s, w.x, w.y, w.z])[:, w.there] for w in sectors]
    line = np.concatenate(parts, axis=1)
    s, x, y, z = line[:, np.argsort(line[0], kind="stable")]
    return s, x, y, z


def throw_line(geology: Geology, horizon: Horizon, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Throw at distances along strike; NaN where the walls are not in the same sector."""
    s, hanging = walls(geology, horizon, name, 1)
    which = list(geology.faults).index(name)
    throw = np.full(len(s), np.nan)
    for foot in walls(geology, horizon, name, -1)[1]:
        for hang in hanging:
            # a footwall and a hanging wall face each other if they agree on all other faults; 0 is
            # no side
            pairs = [
                p for k, p in enumerate(zip(foot.signs, hang.signs, strict=True)) if k != which
            ]
            if all(a == b or not a or not b for a, b in pairs):
                both = foot.there & hang.there
                throw = np.where(both, foot.z - hang.z, throw)
    return s, throw


def _relevant(geology: Geology, horizon: Horizon, name: str, s: np.ndarray) -> list[Signs]:
    """Sectors that differ along a fault: others that die elsewhere move nothing there."""
    fault = geology.faults[name]
    x, y = fault.place(s, fault.across(s, horizon.level))
    near = []

    # faults that are far away do not split the sheets of this one: fewer sectors to solve
    for key, other in geology.faults.items():
        along, r = other.along_across(x, y)
        close = (np.abs(along) < other.half + MARGIN) & (np.abs(r) < other.half + 2 * MARGIN)
        near.append(key == name or bool(close.any()))
    signs = [
        tuple(v if here else 0 for v, here in zip(row, near, strict=True))
        for row in geology.sectors
    ]
    return list(dict.fromkeys(signs))


def _meeting(
    geology: Geology, horizon: Horizon, name: str, signs: Signs, s: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where a fault meets the sheet of a sector: the slope of both makes a contraction."""
    fault = geology.faults[name]
    z = np.full(len(s), horizon.level)

    # fixed point: fault at this elevation, sheet there, and again; the sheet is much flatter than
    # the fault
    for _ in range(MOST_ROUNDS):
        x, y = fault.place(s, fault.across(s, z))
        last, z = z, geology.sheet(horizon, signs, x, y)
        if np.abs(z - last).max() < CLOSE:
            return x, y, z
    raise AssertionError(f"cut-offs of {horizon.name} at {name} do not converge")
