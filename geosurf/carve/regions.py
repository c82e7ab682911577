"""Propose regions: blocks of the zones of a field that lie on each other."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.measures import AREA
from geosurf.carve.shells import Shells
from geosurf.carve.zones import DIGITS, in_words, owned_by
from geosurf.conventions import grouped
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
    block_of_unit = [
        (unit.zone, unit.block)
        if unit.zone in units.reservoir or unit.zone_index not in ends
        else None
        for unit in listed
    ]
    blocks = [block for block in dict.fromkeys(block_of_unit) if block is not None]
    if not blocks:
        return []

    # faces between blocks: all of them, and those on a horizon that no fault has as well
    shells: Shells = listed[0].__dict__["_shell"][0]
    number = np.full(len(listed) + 1, -1)
    for unit, block in zip(listed, block_of_unit, strict=True):
        if block is not None:
            number[unit.__dict__["_shell"][1]] = blocks.index(block)
    every, area = _shared(shells, number[shells.sides])
    horizon = {pair: rows[~_on_fault(shells)[rows]].tolist() for pair, rows in every.items()}
    home = _matched(blocks, horizon, area)

    # regions that are too small become parts of others
    volume: list[list[float]] = [[] for _ in blocks]
    inside: list[list[float]] = [[] for _ in blocks]
    for unit, block in zip(listed, block_of_unit, strict=True):
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
            first, second = sorted(home[k] for k in pair)
            if first != second and rows:
                between.setdefault((first, second), []).extend(rows)
        to = homes_of_slivers(between, area, len(blocks), small, range(len(blocks)))
        home = [to[region] for region in home]
        small &= set(home)

    proposals = []
    for region in sorted(
        set(home), key=lambda first: (-nine_digits(size(first)), home.index(first))
    ):
        rows = [k for k in range(len(blocks)) if home[k] == region]
        held = {blocks[k]: math.fsum(volume[k]) for k in rows}
        remnants = tuple(blocks[k] for k in rows if before[k] != region)
        proposals.append(Proposal(held, remnants, size(region)))
    return proposals


def _shared(
    shells: Shells, sides: np.ndarray
) -> tuple[dict[tuple[int, int], np.ndarray], np.ndarray]:
    """Faces between each pair of blocks, and the area of each face, as numbers to be added [m2]."""
    faces = {pair: np.array(rows) for pair, rows in faces_between_units(sides).items()}
    area = np.zeros((len(sides), 2))
    if faces:
        rows = np.concatenate(list(faces.values()))
        area[rows] = shells.cells.sums[rows, AREA]
    return faces, area


def _on_fault(shells: Shells) -> np.ndarray:
    """Whether each face is on a fault or a virtual wall, bool (n_face,)."""
    cells = shells.cells
    on_fault = np.zeros(len(cells.surface_of), dtype=bool)
    for i, source in enumerate(cells.patches.sources):
        if source.role in ("fault", "virtual"):
            on_fault[owned_by(cells, i)] = True
    return on_fault


def _matched(blocks: list[tuple[str, str]], horizon: Faces, area: np.ndarray) -> list[int]:
    """The region of each block, as the number of one of its blocks."""
    home = list(range(len(blocks)))
    words = {k: {zone: block.partition(" #")[0]} for k, (zone, block) in enumerate(blocks)}
    shared = {pair: rounded_sum(area[rows]) for pair, rows in horizon.items() if rows}
    for pair in sorted(shared, key=lambda pair: (-shared[pair], pair)):
        first, second = (home[k] for k in pair)
        alike = all(words[first].get(zone, word) == word for zone, word in words[second].items())
        if first != second and alike:
            words[first] |= words.pop(second)
            home = [first if region == second else region for region in home]
    return home


# ---- neighbours ----------------------------------------
# Units that share faces, and which neighbour a small one becomes a part of.
#
# Units are the nodes of a graph, and the area that two of them share is the weight of the edge. A
# sliver goes to the neighbour with the largest shared area among those that are not slivers. One
# that touches only slivers waits until some of these have gone, and follows them.


Faces = dict[tuple[int, int], list[int]]


def faces_between_units(sides: np.ndarray) -> Faces:
    """Rows of the faces between each pair of units, lower number first.

    Parameters
    ----------
    sides : ndarray of int64, shape (n, 2)
        Unit in front of and behind each face; -1 outside.

    Examples
    --------
    >>> faces_between_units(np.array([[1, 0], [0, 0], [-1, 1], [0, 1]]))
    {(0, 1): [0, 3]}
    """
    inner = (sides >= 0).all(axis=1) & (sides[:, 0] != sides[:, 1])
    rows = np.flatnonzero(inner)
    pairs = map(tuple, np.sort(sides[rows], axis=1).tolist())
    return grouped(zip(pairs, rows.tolist(), strict=True))


def homes_of_slivers(
    faces: Faces, area: np.ndarray, n_unit: int, small: Collection[int], order: Sequence[int]
) -> list[int]:
    """
    Unit that each unit becomes a part of; others stay their own.

    Parameters
    ----------
    faces : dict
        See `faces_between_units`.
    area : ndarray of float64, shape (n_face, k)
        Area of each face, as numbers to be added [m2].
    n_unit : int
    small : collection of int
        The slivers.
    order : sequence of int
        All units by name; of equal areas the first counts. Areas that agree to nine digits are
        equal, so that rounding does not decide.

    Returns
    -------
    list of int
        A sliver that no way leads from to any other unit stays its own.

    Examples
    --------
    Unit 1 touches 0 and 2; unit 2, a sliver as well, touches only 1:

    >>> homes_of_slivers({(0, 1): [0], (1, 2): [1]}, np.array([[4.0], [9.0]]), 3, {1, 2}, range(3))
    [0, 0, 0]
    """
    home = list(range(n_unit))
    rank = {u: k for k, u in enumerate(order)}
    left = set(small)
    while left:
        # faces of each sliver that is left with what is no sliver, or is a part of such a unit
        around: dict[int, dict[int, list[int]]] = {u: {} for u in left}
        for pair, rows in faces.items():
            for u, v in (pair, pair[::-1]):
                if u in left and home[v] not in left:
                    around[u].setdefault(home[v], []).extend(rows)

        # all at once: the order of slivers does not matter
        moves = {}
        for u, beside in around.items():
            if beside:
                shared = {v: rounded_sum(area[rows]) for v, rows in beside.items()}
                moves[u] = min(shared, key=lambda v: (-shared[v], rank[v]))
        if not moves:
            break
        for u, v in moves.items():
            home[u] = v
        left -= set(moves)
    return home


def rounded_sum(area: np.ndarray) -> float:
    """A sum of areas, to nine digits."""
    return float(f"{math.fsum(area.ravel().tolist()):.{DIGITS}g}")


def shared_faces(faces: Faces, home: Sequence[int]) -> dict[int, list[int]]:
    """Rows of the faces between each unit and the other parts of the unit that it is a part of.

    Examples
    --------
    >>> shared_faces({(0, 1): [0, 3], (1, 2): [4]}, [0, 0, 2])
    {0: [0, 3], 1: [0, 3]}
    """
    shared: dict[int, list[int]] = {}
    for pair, rows in faces.items():
        if home[pair[0]] == home[pair[1]]:
            for u in pair:
                shared.setdefault(u, []).extend(rows)
    return shared


def surfaces_of(cells: Cells, faces: Sequence[int]) -> tuple[str, ...]:
    """Names of the surfaces that own some faces, sorted."""
    found = {int(cells.surface_of[row]) for row in faces}
    found |= {other for row in faces for other, _ in cells.also.get(row, ())}
    return tuple(sorted((cells.patches.names[i] for i in found), key=in_words))


def shared_area(cells: Cells, faces: Sequence[int]) -> float:
    """Area of some faces [m2]."""
    return math.fsum(cells.sums[np.array(faces, dtype=np.int64), AREA].ravel().tolist())
