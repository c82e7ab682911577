"""Data of one horizon and its faults -> a torn mesh that ends on them, by the smallest remedy.

First the faults are taken as they are. If a hole is next to the upper or lower rim of a fault, the
fault is extended there, each time by twice as much, and the horizon is torn again. What is still
open after that is closed at any cost (`geosurf.sheets.mesh.repairs`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.conventions import rising_diagonal
from geosurf.errors import GeosurfError
from geosurf.model import TriSurface
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.empty_blocks import refuse_empty_blocks
from geosurf.sheets.heights.grid_solver import GridSolver
from geosurf.sheets.heights.inputs import Trims
from geosurf.sheets.heights.missing import continued, missing_blocks, refuse_missing
from geosurf.sheets.heights.passes import Rebuilt, rebuild, solver_of
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.scattered import Scattered
from geosurf.sheets.mesh.build import Built, build
from geosurf.sheets.mesh.carry_on import carry_on_by, ghosts_by_picks
from geosurf.sheets.mesh.overlap_points import ghosts_by_points
from geosurf.sheets.mesh.repairs import NO_REPAIRS, Repairs
from geosurf.sheets.mesh.too_short import VERTICAL, Short, extended, too_short

REACH = 4.0  # cells from the upper or lower rim of a fault within which a hole is a matter of that
LEAST = 0.5  # of its height by which a fault is extended along its dip at first
MOST = 4.0  # and at most


@dataclass(frozen=True)
class Extended:
    """A fault that was extended because a sheet leaves it above or below.

    Attributes
    ----------
    fault : str
    sides : frozenset of {"up", "down"}
    distance : float
        Along its dip [m].
    place : ndarray (3,)
        Where the sheet left it [m].
    """

    fault: str
    sides: frozenset[str]
    distance: float
    place: np.ndarray


@dataclass(frozen=True, eq=False)
class Closed:
    """A torn mesh, and what it took to close it.

    Attributes
    ----------
    picks : Picks or Scattered
        With blocks that were filled.
    rebuilt : Rebuilt
    built : Built
        Open only if no remedy closes it.
    faults : tuple of TriSurface
        As given, or extended.
    extensions : tuple of Extended
    trims, given_trims : Trims
        In use, and as they were at first.
    filled : list of dict
        Blocks at faults without data that were filled.
    """

    picks: Picks | Scattered
    rebuilt: Rebuilt
    built: Built
    faults: tuple[TriSurface, ...]
    extensions: tuple[Extended, ...]
    trims: Trims
    given_trims: Trims
    filled: list[dict]


def close(
    picks: Picks | Scattered,
    faults: Sequence[TriSurface],
    trims: Trims,
    noise: float | None,
    fill_empty_blocks: bool,
    given_trims: Trims,
    known_short: Collection[int] = (),
) -> Closed:
    """Rebuild heights, tear the mesh, and close it.

    `known_short` are numbers of faults that are extended up and down from the start.

    Raises
    ------
    GeometryError
        If a block has no data.
    """
    # faults that are known to be short are extended before the first attempt
    given, found = tuple(faults), dict[int, Extended]()
    surfaces = given
    short = {k: Short(frozenset(VERTICAL), given[k].vertices.mean(axis=0)) for k in known_short}
    more = _longer(given, short, found)
    while True:
        # each round extends faults next to holes, twice as far as before; MOST ends it
        found |= {k: one for k, (one, _) in more.items()}
        surfaces = tuple(more[k][1] if k in more else one for k, one in enumerate(surfaces))
        filled_picks, rebuilt, filled = _rebuilt(picks, surfaces, trims, noise, fill_empty_blocks)
        refuse_empty_blocks(filled_picks, rebuilt.state, [surface.name for surface in surfaces])
        built = _built(filled_picks, rebuilt, surfaces, False)
        short = too_short(built.cut.holes, surfaces, REACH * picks.frame.cell)
        more = _longer(given, short, found) if built.is_open else {}
        if not more:
            break

    if built.is_open:
        built = _built(filled_picks, rebuilt, surfaces, True, built.repairs)
    return Closed(
        filled_picks, rebuilt, built, surfaces, tuple(found.values()), trims, given_trims, filled
    )


def _longer(
    given: Sequence[TriSurface], short: dict[int, Short], before: dict[int, Extended]
) -> dict[int, tuple[Extended, TriSurface]]:
    """Faults to extend, by number: the list entry and the surface; none that cannot be longer."""
    found: dict[int, tuple[Extended, TriSurface]] = {}
    for number, one in short.items():
        fault, old = given[number], before.get(number)
        height = fault.bounds[5] - fault.bounds[4]
        distance = LEAST * height if old is None else 2.0 * old.distance
        if distance > MOST * height:
            continue

        # from the fault as given, not from its last extension: dip lines are continued once
        sides = one.sides | (frozenset() if old is None else old.sides)
        place = one.place if old is None else old.place
        try:
            surface = extended(fault, sides, distance)
        except GeosurfError:  # its dip lines cross there: another remedy has to do
            continue
        found[number] = Extended(fault.name, sides, distance, place), surface
    return found


def _rebuilt(
    picks: Picks | Scattered,
    surfaces: Sequence[TriSurface],
    trims: Trims,
    noise: float | None,
    fill_empty_blocks: bool,
) -> tuple[Picks | Scattered, Rebuilt, list[dict]]:
    """Heights of all nodes, once more where blocks at a fault without data were filled.

    Returns the picks with those blocks, the heights, and notes of the blocks.
    """
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]
    rebuilt = rebuild(solver_of(picks, meshes, trims, noise, fill_empty_blocks))

    # blocks at a fault without data are known only once heights have shown which nodes stay empty
    missing = missing_blocks(picks, rebuilt.state, meshes)
    filled: list[dict] = []
    if missing and fill_empty_blocks:
        picks, filled = continued(picks, missing)
        rebuilt = rebuild(solver_of(picks, meshes, trims, noise, fill_empty_blocks))
        missing = missing_blocks(picks, rebuilt.state, meshes)
    refuse_missing(picks, missing)
    return picks, rebuilt, filled


def _built(
    picks: Picks | Scattered,
    rebuilt: Rebuilt,
    surfaces: Sequence[TriSurface],
    at_any_cost: bool,
    start: Repairs = NO_REPAIRS,
) -> Built:
    """The torn mesh, with ghosts on the sheets of their walls."""
    rising = rising_diagonal(picks.frame.easting, picks.frame.northing)
    solver, weight = rebuilt.solver, rebuilt.solver.noise.weight
    if isinstance(picks, Scattered):
        known = ghosts_by_points(picks, weight)
    else:
        assert isinstance(solver, GridSolver)
        known = ghosts_by_picks(picks, weight, solver.grid.mark)
    carry_on = carry_on_by(picks.frame, weight, known)
    again = rebuilt.torn_between
    return build(
        picks, rebuilt.state, surfaces, rising, carry_on, again, at_any_cost, start
    )  # fmt: skip
