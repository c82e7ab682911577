"""Propose regions: blocks of the zones of a field that lie on each other."""

from __future__ import annotations

import math

import numpy as np

from geosurf.carve.measures import AREA
from geosurf.carve.neighbours import Faces, faces_between_units, homes_of_slivers, rounded_sum
from geosurf.carve.shells import Shells
from geosurf.carve.zones import owned_by
from geosurf.model import Units
from geosurf.model.regions import LEAST, Proposal, nine_digits


def propose_regions(units: Units) -> list[Proposal]:
    """
    Put the blocks of all zones of a field into regions.

    Two blocks of different zones share the horizon area between them. In order of falling area,
    what contains the two becomes one region, unless a zone would then have two blocks in it; pieces
    of one block (``F1+``, ``F1+ #2``) count as one. Regions below 1/1000 of the reservoir then
    become parts of others: of the one with which they share most horizon area, or, without any, of
    the one that they touch most across faults. Areas are sums over the faces of the model.

    Parameters
    ----------
    units : Units
        As carved, with all zones.

    Returns
    -------
    list of Proposal
        The largest volume in the reservoir first. They have the zones between the first and the
        last horizon, and those of the reservoir.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.graben(n=9)
    >>> units = gs.Scene(world.horizons, world.faults, world.box).units
    >>> [list(proposal.blocks) for proposal in propose_regions(units)][0]
    [('Top/Middle', 'F1+ F2+'), ('Middle/Base', 'F1+ F2+')]
    """
    listed = list(units.values())
    ends = 0, max((unit.zone_index for unit in listed), default=0)
    of_unit = [
        (unit.zone, unit.block)
        if unit.zone in units.reservoir or unit.zone_index not in ends
        else None
        for unit in listed
    ]
    blocks = [block for block in dict.fromkeys(of_unit) if block is not None]
    if not blocks:
        return []

    # faces between blocks: all of them, and those on a horizon that no fault has as well
    shells: Shells = listed[0].__dict__["_shell"][0]
    number = np.full(len(listed) + 1, -1)
    for unit, block in zip(listed, of_unit, strict=True):
        if block is not None:
            number[unit.__dict__["_shell"][1]] = blocks.index(block)
    every, area = _shared(shells, number[shells.sides])
    horizon = {pair: rows[~_on_fault(shells)[rows]].tolist() for pair, rows in every.items()}
    home = _matched(blocks, horizon, area)

    # regions that are too small become parts of others
    volume: list[list[float]] = [[] for _ in blocks]
    inside: list[list[float]] = [[] for _ in blocks]
    for unit, block in zip(listed, of_unit, strict=True):
        if block is not None:
            k = blocks.index(block)
            volume[k].append(unit.volume)
            inside[k] += [unit.volume] if unit.zone in units.reservoir else []

    def size(region: int) -> float:
        """Volume of a region in the reservoir [m3]."""
        return math.fsum(v for k, of in enumerate(inside) if home[k] == region for v in of)

    least = LEAST * math.fsum(v for of in inside for v in of)
    small = {region for region in set(home) if size(region) < least}
    before = home
    for faces in (horizon, {pair: rows.tolist() for pair, rows in every.items()}):
        between: Faces = {}
        for pair, rows in faces.items():
            one, two = sorted(home[k] for k in pair)
            if one != two and rows:
                between.setdefault((one, two), []).extend(rows)
        to = homes_of_slivers(between, area, len(blocks), small, range(len(blocks)))
        home = [to[region] for region in home]
        small &= set(home)

    found = []
    for region in sorted(set(home), key=lambda one: (-nine_digits(size(one)), home.index(one))):
        rows = [k for k in range(len(blocks)) if home[k] == region]
        held = {blocks[k]: math.fsum(volume[k]) for k in rows}
        remnants = tuple(blocks[k] for k in rows if before[k] != region)
        found.append(Proposal(held, remnants, size(region)))
    return found


def _shared(
    shells: Shells, sides: np.ndarray
) -> tuple[dict[tuple[int, int], np.ndarray], np.ndarray]:
    """Faces between each pair of blocks, and the area of each face, as numbers to be added [m2]."""
    faces = {pair: np.array(rows) for pair, rows in faces_between_units(sides).items()}
    area = np.zeros((len(sides), 2))
    if faces:
        rows = np.concatenate(list(faces.values()))
        area[rows] = shells.cells.extent_of(rows)[:, AREA]
    return faces, area


def _on_fault(shells: Shells) -> np.ndarray:
    """Whether each face is on a fault or a virtual wall, bool (n_face,)."""
    cells = shells.cells
    found = np.zeros(len(cells.surface_of), dtype=bool)
    for i, source in enumerate(cells.patches.sources):
        if source.role in ("fault", "virtual"):
            found[owned_by(cells, i)] = True
    return found


def _matched(blocks: list[tuple[str, str]], horizon: Faces, area: np.ndarray) -> list[int]:
    """The region of each block, as the number of one of its blocks."""
    home = list(range(len(blocks)))
    words = {k: {zone: block.partition(" #")[0]} for k, (zone, block) in enumerate(blocks)}
    shared = {pair: rounded_sum(area[rows]) for pair, rows in horizon.items() if rows}
    for pair in sorted(shared, key=lambda pair: (-shared[pair], pair)):
        one, two = (home[k] for k in pair)
        alike = all(words[one].get(zone, word) == word for zone, word in words[two].items())
        if one != two and alike:
            words[one] |= words.pop(two)
            home = [one if region == two else region for region in home]
    return home
