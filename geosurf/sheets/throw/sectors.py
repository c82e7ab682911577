"""Horizons at faults that cross: which cut-offs there are, and the wedges that have no horizon.

Where two faults cross closer to a horizon than their throws, the horizon is cut away from one or
two of the four wedges, and may end on one of the faults only. Both follow from the movement: rock
of any wall is known everywhere.
"""

from __future__ import annotations

from itertools import combinations, product

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.model import frozen
from geosurf.model.sectors import Sector
from geosurf.sheets.throw.attempt import Attempt
from geosurf.sheets.throw.movement import Movement

LEVELS = 65  # elevations at which faults are looked at, over what the horizon can reach
STATIONS = 513  # places along strike, at most


def cutoffs_to_expect(best: Attempt, fault: int, wall: float) -> np.ndarray:
    """Places (n, 3), from the corner, where the horizon ends on a fault from one wall, 1 hanging.

    Walls of all other faults are those of the place: what these cut away does not count.
    """
    movement = best.movement
    xyz, shape = _on_fault(movement, fault)
    walls = movement.in_hanging_walls(xyz[:, :2], xyz[:, 2])
    walls[fault] = wall
    heights, _ = movement.heights_at(best.branches, xyz[:, :2], walls)
    above = (xyz[:, 2] - heights).reshape(shape)
    other = walls.reshape(-1, *shape)

    # between two levels of the same walls the fault goes through the horizon
    same = (other[:, :, 1:] == other[:, :, :-1]).all(axis=0)
    with np.errstate(invalid="ignore"):
        through = above[:, 1:] * above[:, :-1] <= 0.0
    row, at = np.nonzero(same & through)
    found: np.ndarray = xyz.reshape(*shape, 3)[row, at]
    return found


def too_coarse(best: Attempt, fault: int, places: np.ndarray) -> GeometryError | None:
    """The error where a wedge at a fault is narrower than a cell; None where none is so narrow.

    `places` (n, 3) are on the fault: cut-offs that the sheet should have.
    """
    movement = best.movement
    cell, name, horizon = movement.frame.cell, movement.faults[fault].name, movement.picks.name
    found: tuple[float, int, int] | None = None
    for k in range(len(movement.slips)):
        far = np.abs(movement.distance(k, places[:, :2], places[:, 2]))
        if k != fault and best.branches.acts[k] and far.max() < cell:
            at = int(far.argmax())
            found = min(found or (np.inf, 0, 0), (float(far[at]), k, at))
    if found is None:
        return None
    width, other, at = found
    where = places[at] + np.append(movement.frame.corner, 0.0)
    names = name, movement.faults[other].name
    return GeometryError(
        f"horizon {horizon!r} is {width:.3g} m wide between faults {names[0]!r} and {names[1]!r} "
        f"at {place(where)}, and cells of {cell:.3g} m have no node there. Give the horizon on "
        f"cells of {0.9 * width:.2g} m, as from its .interp(easting=..., northing=...), or move a "
        "fault.",
        place=where,
        surfaces=(horizon, *names),
    )


def sectors_of(best: Attempt) -> tuple[Sector, ...]:
    """The wedges between faults that cross so close to the horizon that one may be without it."""
    movement, frame = best.movement, best.movement.frame
    found = []
    for pair in combinations(range(len(movement.slips)), 2):
        if not all(best.branches.acts[k] for k in pair) or not _is_close(best, *pair):
            continue
        unclear = _beside_others(movement, pair)
        for first, second in product((True, False), repeat=2):
            walls = best.walls.copy()
            walls[pair[0]], walls[pair[1]] = float(first), float(second)
            heights, _ = movement.heights_at(best.branches, movement.xy, walls)
            heights[unclear] = np.nan
            found.append(
                Sector(
                    faults=(movement.faults[pair[0]].name, movement.faults[pair[1]].name),
                    front=(first, second),
                    corner=frozen(frame.corner, np.float64),
                    step=frozen(frame.step, np.float64),
                    elevation=frozen(heights.reshape(frame.shape), np.float64),
                    rising=movement.rising,
                )
            )
    return tuple(found)


def _reach(movement: Movement) -> tuple[float, float]:
    """Lowest and highest elevation that the horizon can have [m]."""
    most = sum(movement.largest) + movement.frame.cell
    return float(movement.picks.z.min()) - most, float(movement.picks.z.max()) + most


def _on_fault(movement: Movement, fault: int) -> tuple[np.ndarray, tuple[int, int]]:
    """Places (n, 3) on a fault, from the corner, as stations (rows) and levels (columns)."""
    section = movement.slips[fault].section
    low, high = _reach(movement)
    low, high = max(low, float(section.z[0])), min(high, float(section.z[1]))
    n = int(np.clip(np.ceil(section.length / movement.frame.cell) + 1, 2, STATIONS))
    shape = (n, LEVELS)
    s, z = (
        part.ravel()
        for part in np.meshgrid(
            np.linspace(0.0, section.length, n), np.linspace(low, high, LEVELS), indexing="ij"
        )
    )
    return np.column_stack([section.places(s, section.across(s, z)), z]), shape


def _is_close(best: Attempt, one: int, two: int) -> bool:
    """Whether two faults cross within a cell of the horizon in one wedge, or between two wedges."""
    movement = best.movement
    xyz, shape = _on_fault(movement, one)
    section = movement.slips[two].section
    s, _ = section.of(xyz[:, :2])
    inside = (s >= 0.0) & (s <= section.length)
    inside &= (xyz[:, 2] >= section.z[0]) & (xyz[:, 2] <= section.z[1])
    far = np.where(inside, movement.distance(two, xyz[:, :2], xyz[:, 2]), np.nan).reshape(shape)

    # along each line down the fault: where it passes from one wall of the other to the next
    with np.errstate(invalid="ignore"):
        row, at = np.nonzero(far[:, 1:] * far[:, :-1] <= 0.0)
    if len(row) == 0:
        return False
    a, b = np.abs(far[row, at]), np.abs(far[row, at + 1])
    share = np.divide(a, a + b, out=np.full_like(a, 0.5), where=a + b > 0)[:, None]
    grid = xyz.reshape(*shape, 3)
    crossing = grid[row, at] + share * (grid[row, at + 1] - grid[row, at])

    # the horizon in all four wedges there
    walls = movement.in_hanging_walls(crossing[:, :2], crossing[:, 2])
    above = []  # by how much [m]
    for front in product((1.0, 0.0), repeat=2):
        walls[one], walls[two] = front
        heights, _ = movement.heights_at(best.branches, crossing[:, :2], walls)
        above.append(heights - crossing[:, 2])

    # within a cell: a piece that is narrower may have no node, and be missing as well
    cell = movement.frame.cell
    return bool(((np.max(above, axis=0) > -cell) & (np.min(above, axis=0) < cell)).any())


def _beside_others(movement: Movement, pair: tuple[int, int]) -> np.ndarray:
    """Nodes (n,) over or under which another fault passes: there its wall depends on the depth."""
    unclear = np.zeros(len(movement.xy), dtype=bool)
    for k, slip in enumerate(movement.slips):
        if k in pair:
            continue
        levels = np.linspace(slip.section.z[0], slip.section.z[1], 17)
        sides = [
            movement.distance(k, movement.xy, np.full(len(movement.xy), z)) > 0.0 for z in levels
        ]
        unclear |= np.any(sides, axis=0) & ~np.all(sides, axis=0)
    return unclear
