"""Group units of one zone into blocks, named by the faults that separate them.

A fault separates two units of a zone if one of them touches only its front (``+``, the side
its normal points into: the hanging wall of a dipping fault) and the other only its back
(``-``). Whether they face each other does not matter: throw may bring other zones between.

So a name has only the sides that separate units of one zone. One block may be ``F1+ F2-`` in a
zone and ``F2-`` in the next, which F1 has left. The side of a fault that a unit lies on does not
depend on zones: from a unit on the ``+`` side of F1, no way leads to the back of F1 but through F1.

A virtual wall continues a fault, and has the same front: names do not distinguish the two.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.zones import own_sides, pairs_of_faces
from geosurf.kernels.meshes.mesh import join_pairs

WHOLE = "whole"
Faults = Mapping[str, Sequence[int]]  # surfaces of each fault: its own, and its virtual wall
# volumes that agree to this many digits are one: rounding shall not rank them
DIGITS = 9


def _touched(
    cells: Cells, unit_of_cell: np.ndarray, fault: Sequence[int], n_unit: int
) -> np.ndarray:
    """Whether each unit touches front and back of a fault, bool (n_unit, 2); slits apart."""
    # a triangle with one unit on both sides is a slit: it separates nothing
    sides = unit_of_cell[np.concatenate([own_sides(cells, i)[2] for i in fault])]
    sides = sides[sides[:, 0] != sides[:, 1]]
    touched = np.zeros((n_unit, 2), dtype=bool)
    for side in range(2):
        units = sides[:, side]
        touched[units[units >= 0], side] = True
    return touched


def in_words(name: str) -> list[tuple[int, int, str]]:
    """Key that sorts names as people do: F2 before F10.

    Examples
    --------
    >>> sorted(["F10", "F2", "Main"], key=in_words)
    ['F2', 'F10', 'Main']
    """
    return [
        (0, int(part), "") if part.isdecimal() else (1, 0, part)
        for part in re.split(r"(\d+)", name)
        if part
    ]


def fault_sides(
    cells: Cells,
    unit_of_cell: np.ndarray,
    zone: np.ndarray,
    faults: Faults,
) -> list[tuple[str, ...]]:
    """Sides of faults that set each unit apart in its zone: ``("F1+", "F2-")``, by name."""
    words: list[list[str]] = [[] for _ in zone]

    # by name, so that words of a block come in the order in which people read them
    for fault in sorted(faults, key=in_words):
        touched = _touched(cells, unit_of_cell, faults[fault], len(zone))
        front = touched[:, 0] & ~touched[:, 1]
        back = touched[:, 1] & ~touched[:, 0]

        # zones with units in front and others behind: a fault that separates two zones only is no
        # part of a name
        n_zone = int(zone.max(initial=-1)) + 1
        parts = np.bincount(zone[front], minlength=n_zone) * np.bincount(
            zone[back], minlength=n_zone
        )
        for u in np.flatnonzero((front | back) & (parts > 0)[zone]).tolist():
            words[u].append(fault + ("+" if front[u] else "-"))
    return [tuple(word) for word in words]


def sides_of_units(
    cells: Cells,
    unit_of_cell: np.ndarray,
    faults: Faults,
    words: Sequence[tuple[str, ...]],
) -> list[tuple[str, ...]]:
    """
    Sides of faults that each unit lies on: those that name it, and those it cannot leave.

    Parameters
    ----------
    cells : Cells
    unit_of_cell : ndarray of int64, shape (n_cell + 1,)
    faults : mapping of str to sequence of int
        Surfaces of each fault: its own, and its virtual wall.
    words : sequence of tuple of str
        Of each unit, see `fault_sides`.

    Returns
    -------
    list of tuple of str
        By name of the fault. A fault with a way around it (it dies inside the model, or ends at
        another fault) has sides only where it separates units of a zone.
    """
    found = [set(word) for word in words]

    # a merged unit is one space: a way leads through the fault that parted it before
    cell = np.arange(1, cells.n_cell + 1)
    _, first = np.unique(unit_of_cell[1:], return_index=True)
    within = np.stack([cell, 1 + first[unit_of_cell[1:]]], axis=1)
    pairs, pair_of_face = pairs_of_faces(cells.cell_of_side, cells.n_cell)
    count = np.bincount(pair_of_face[pair_of_face >= 0], minlength=len(pairs))
    for fault, surfaces in faults.items():
        of = [own_sides(cells, i) for i in surfaces]
        mine, sides = (np.concatenate([one[k] for one in of]) for k in (0, 2))

        # all faces but those of the fault: cells that they link are one region
        own = pair_of_face[np.unique(mine)]
        left = count - np.bincount(own[own >= 0], minlength=len(pairs))
        region = join_pairs(np.concatenate([pairs[left > 0], within]), cells.n_cell + 1)
        seen = np.zeros((2, cells.n_cell + 1), dtype=bool)  # from its front, from its back
        for side in range(2):
            beside = sides[:, side]
            seen[side, region[beside[beside > 0]]] = True
        for side, sign in enumerate("+-"):
            # the region sees one side of the fault only: there is no way around
            alone = seen[side] & ~seen[1 - side]
            for u in np.unique(unit_of_cell[1:][alone[region[1:]]]).tolist():
                if u >= 0:
                    found[u].add(fault + sign)
    # by name first: F1 and F01 have one key
    rank = {side: k for k, side in enumerate(sorted(sorted(set().union(*found)), key=in_words))}
    return [tuple(sorted(sides, key=rank.__getitem__)) for sides in found]


def name_blocks(
    words: Sequence[tuple[str, ...]],
    zone: np.ndarray,
    volume: Sequence[float],
    corner: Callable[[int], tuple[float, ...]],
) -> list[str]:
    """Block name of each unit; the same in every zone for the same sides of faults.

    Units of a zone that no fault separates are numbered: ``F1+``, ``F1+ #2``. The largest
    comes first, of equal ones the one farthest west, south, down.

    Parameters
    ----------
    words : sequence of tuple of str
        Of each unit, see `fault_sides`.
    zone : ndarray of int64
    volume : sequence of float
    corner : callable
        Of a unit, (float, float, float): its western, southern and lower bound; asked where
        names do not decide.

    Returns
    -------
    list of str
    """
    names = [" ".join(word) or WHOLE for word in words]
    groups: dict[tuple[int, str], list[int]] = {}
    for u, name in enumerate(names):
        groups.setdefault((int(zone[u]), name), []).append(u)

    def size_then_place(u: int) -> tuple[float, ...]:
        """Larger ones first, then those farther west, south, down."""
        # by size, then by place: numbers of cells do not rank units of equal volume
        return (-float(f"{volume[u]:.{DIGITS}g}"), *corner(u))

    for (_, name), units in groups.items():
        if len(units) == 1:
            continue
        for rank, u in enumerate(sorted(units, key=size_then_place)[1:], start=2):
            names[u] = f"{name} #{rank}"
    return names


def block_order(name: str) -> tuple[object, ...]:
    """Key that sorts block names: ``F1+``, ``F1+ #2``, ... ``F1+ #10``."""
    base, _, rank = name.partition(" #")
    return in_words(base), int(rank or 1)
