"""Determine on which side of each horizon and fluid contact each cell lies.

A cell in front of a horizon (its upper side) is above it, one behind it is below; both
hold across any other horizon, so that cells which do not touch a horizon learn from
their neighbours above and below; across faults only cells that have no such neighbour
(throw brings rock above next to rock below), and where faults cross next to a horizon by
where it would be (see `geosurf.carve.zones`). A cell that touches both sides, around
a rim that is open, is on neither. That is a leak only where the column asks
(see `geosurf.carve.column`): a horizon may end in what a younger one has eroded.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.outside import box_of
from geosurf.conventions import grouped
from geosurf.conventions.axes import FOOT, vertical_words
from geosurf.errors import GeometryError
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.model import Patches, TriSurface
from geosurf.model.surfaces import Sector

ABOVE, BELOW, UNKNOWN = 1, -1, 0


def faces_between(cells: Cells) -> np.ndarray:
    """Faces with different cells in front and behind."""
    return np.flatnonzero(cells.cell_of_side[:, 0] != cells.cell_of_side[:, 1])


def upper_sides(patches: Patches, cells: Cells, surface: int) -> tuple[np.ndarray, np.ndarray]:
    """Faces of a horizon, and (cell above, cell below) of each, int64 (n, 2)."""
    mine, way, sides = own_sides(cells, surface)
    return mine, sides if (way * cells.flat[mine]).sum() >= 0 else sides[:, ::-1]


def owned_by(cells: Cells, surface: int) -> np.ndarray:
    """Faces of a surface, those that it shares with others included; each once."""
    return distinct(own_sides(cells, surface)[0])


def own_sides(cells: Cells, surface: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Faces of a surface, those that it shares with others included, as it is turned itself.

    Parameters
    ----------
    cells : Cells
    surface : int

    Returns
    -------
    mine, way : ndarray of int64, shape (n,)
        Faces, rising, and 1 where the surface has its front on that of the face, -1 where it was
        given the other way round. A face that a surface is folded onto twice is there both ways.
    sides : ndarray of int64, shape (n, 2)
        Cell in front of the surface and behind it.
    """
    # column rules, zones and blocks ask for the same surfaces hundreds of times
    if surface not in cells.own:
        cells.own[surface] = _own_sides(cells, surface)
    return cells.own[surface]


def _own_sides(cells: Cells, surface: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`own_sides`, found anew."""
    # faces of its own, then those where it coincides with an earlier surface
    first = np.flatnonzero(cells.surface_of == surface)
    shared = [
        (face, turn)
        for face, listed in cells.also.items()
        for other, turn in listed
        if other == surface
    ]
    faces, ways = np.array(shared, dtype=np.int64).reshape(-1, 2).T
    owned = np.concatenate([first, faces])
    turn = np.concatenate([np.ones(len(first), dtype=np.int64), ways])

    # rising by face, so that the order of surfaces does not matter; then seen from its own front
    order = np.lexsort((turn, owned))
    owned, turn = owned[order], turn[order]
    sides = cells.cell_of_side[owned]
    return owned, turn, np.where(turn[:, None] > 0, sides, sides[:, ::-1])


def distinct_pairs(pairs: np.ndarray, n_cell: int) -> np.ndarray:
    """Pairs of cells inside the box, lower first, each once."""
    # one whole number for both orders of a pair; 0 is the outside, which is no neighbour
    low, high = pairs.min(axis=1, initial=n_cell), pairs.max(axis=1, initial=0)
    keys = distinct((low * (n_cell + 1) + high)[low > 0])
    return np.stack(np.divmod(keys, n_cell + 1), axis=1)


def pairs_of_faces(sides: np.ndarray, n_cell: int) -> tuple[np.ndarray, np.ndarray]:
    """The same pairs, and the row of that of each face (n,); -1 where it has none inside."""
    low, high = sides.min(axis=1, initial=n_cell), sides.max(axis=1, initial=0)
    inside = low > 0
    keys, rows = np.unique((low * (n_cell + 1) + high)[inside], return_inverse=True)
    of_face = np.full(len(sides), -1)
    of_face[inside] = rows.ravel()
    return np.stack(np.divmod(keys, n_cell + 1), axis=1), of_face


def signatures(patches: Patches, cells: Cells, level: Sequence[int]) -> np.ndarray:
    """
    Side of each surface that each cell is on: ABOVE, BELOW, or UNKNOWN.

    Parameters
    ----------
    patches : Patches
    cells : Cells
    level : sequence of int
        Surfaces that lie flat, more or less: horizons and fluid contacts.

    Returns
    -------
    ndarray of int64, shape (n_surface, n_cell + 1)
        Column 0 is the outside, UNKNOWN.

    Raises
    ------
    GeometryError
        If a surface is not in the box, or not inside the walls.
    """
    signature = np.zeros((len(level), cells.n_cell + 1), dtype=np.int64)
    between = faces_between(cells)
    flat = np.zeros(len(cells.surface_of), dtype=bool)
    # horizons go on through virtual walls, which have no throw
    virtual = [k for k, source in enumerate(patches.sources) if source.role == "virtual"]
    for surface in (*level, *virtual):
        flat[own_sides(cells, surface)[0]] = True
    level_faces = between[flat[between]]
    for k, surface in enumerate(level):
        sides = upper_sides(patches, cells, surface)[1]
        if len(sides) == 0:
            raise _not_reached(patches, surface)
        if not sides.any():
            raise _beyond(patches, surface)

        # cells that the surface touches from above and from below know their side at once
        touched = np.zeros((2, cells.n_cell + 1), dtype=bool)
        touched[0, sides[:, 0]] = touched[1, sides[:, 1]] = True
        touched[:, 0] = False
        side = np.where(touched[0], ABOVE, np.where(touched[1], BELOW, UNKNOWN))
        # around a rim that is open both sides are one: nothing can be told, nothing is passed on
        torn = touched[0] & touched[1]
        side[torn] = UNKNOWN

        # the others take it from neighbours: first across other horizons and contacts, which lie
        # parallel to it, and virtual walls; then across faults where all blocks around agree
        links = _links(cells, level_faces, surface, torn)
        _spread(side, links)
        across = _links(cells, between, surface, torn)
        _agree(side, links, across)

        # blocks around that do not agree: a horizon that throw moved knows where it would be
        unknown = (side == UNKNOWN) & ~torn
        unknown[0] = False
        known = sides_by_sectors(patches, cells, surface, unknown)
        if known:
            side[list(known)] = list(known.values())
            _spread(side, links)
            _agree(side, links, across)
        signature[k] = side
    return signature


def _not_reached(patches: Patches, surface: int) -> GeometryError:
    """State where a surface is, where the box is, and whether the one holds depths."""
    source = patches.sources[surface]
    b, t = source.bounds[4:]
    (west, south, bottom), (east, north, top) = (box_of(patches) + patches.origin).tolist()
    hint = f"Enlarge the box, or leave the {source.role} out."
    if t < bottom or b > top:
        if b <= -bottom and t >= -top:
            hint = (
                "Elevation is positive up. If its values are depths, pass positive='down', and "
                "use negative elevations in the box."
            )
        elif vertical_words()[1] == "m" and bottom <= FOOT * b and FOOT * t <= top:
            hint = (
                f"If its elevations are in feet ({FOOT * b:.0f} to {FOOT * t:.0f} m), pass "
                f"length_unit='ft'. Otherwise enlarge the box, or leave the {source.role} out."
            )
    return GeometryError(
        f"{_extent_of(source)} does not reach the model box ({west:.0f} to {east:.0f}, "
        f"{south:.0f} to {north:.0f}, {bottom:.0f} to {top:.0f}). {hint}",
        surfaces=(source.name,),
    )


def _extent_of(source: TriSurface) -> str:
    """What a surface is called, and where it is in whole metres."""
    w, e, s, n, b, t = (round(value) for value in source.bounds)
    return (
        f"{source.role} {source.name!r} (easting {w} to {e}, northing {s} to {n}, "
        f"elevation {b} to {t})"
    )


def _beyond(patches: Patches, surface: int) -> GeometryError:
    """State where a surface is that lies in the bounds of the walls, and outside of them."""
    source = patches.sources[surface]
    return GeometryError(
        f"{_extent_of(source)} lies outside the area of interest, although inside its "
        f"bounds. Enlarge the area, or leave the {source.role} out.",
        surfaces=(source.name,),
    )


def _links(cells: Cells, faces: np.ndarray, surface: int, torn: np.ndarray) -> np.ndarray:
    """Pairs of cells with one of some faces between them that is not of the surface."""
    others = np.ones(len(cells.surface_of), dtype=bool)
    others[own_sides(cells, surface)[0]] = False
    links = distinct_pairs(cells.cell_of_side[faces[others[faces]]], cells.n_cell)
    return links[~torn[links].any(axis=1)]


def _spread(values: np.ndarray, links: np.ndarray) -> None:
    """Carry +1 and -1 over links to cells that have 0: the nearest value counts, round by round."""
    while True:
        known = values[links] != 0
        edge = known[:, 0] != known[:, 1]
        rows, first = links[edge], known[edge, 0]
        if not len(rows):
            return
        values[rows[first, 1]] = values[rows[first, 0]]
        values[rows[~first, 0]] = values[rows[~first, 1]]


def _agree(values: np.ndarray, links: np.ndarray, across: np.ndarray) -> None:
    """
    Give cells that have 0 what all blocks around them say, if they say the same.

    Throw parts what is above from what is below, so that faults carry only what nothing else
    tells: to stacks of cells, joined by `links`, that the surface is not in.
    """
    # stacks: cells between which only horizons and contacts lie
    stack = join_pairs(links, len(values))
    while True:
        # across each fault, from a cell that knows its side to one that does not
        known = values[across] != 0
        rows = np.flatnonzero(known[:, 0] != known[:, 1])
        giver = across[rows, np.where(known[rows, 0], 0, 1)]
        taker = stack[across[rows, np.where(known[rows, 0], 1, 0)]]

        # a stack takes a side only if no neighbour has the other one
        high, low = np.zeros((2, len(values)), dtype=bool)
        high[taker[values[giver] > 0]] = low[taker[values[giver] < 0]] = True
        agreed = np.where(high & ~low, ABOVE, np.where(low & ~high, BELOW, UNKNOWN))[stack]
        new = (values == 0) & (agreed != 0)
        new[0] = False
        if not new.any():
            return
        values[new] = agreed[new]


# ---- cells without any piece of a horizon: on which side of it they lie, by where it would be ----
#
# Where two faults cross closer to a horizon than their throws, a wedge between them has no piece
# of it, and the wedges next to it lie on both sides. A horizon that throw moved states where it
# would be in that wedge (`geosurf.model.sheets`). It is not in the cell, which topology shows
# exactly; so all corners of the cell lie on one side of where it would be. Corners on both sides
# mean that the horizon ought to be there: the cell stays unknown, which is refused.


ROUNDING = 1e-9  # metres: a corner as near as this to where the horizon would be says nothing


def sides_by_sectors(
    patches: Patches, cells: Cells, surface: int, unknown: np.ndarray
) -> dict[int, int]:
    """
    Return the side of cells that follows from where a horizon would be.

    Parameters
    ----------
    patches : Patches
    cells : Cells
    surface : int
        Row of `patches.sources`.
    unknown : ndarray of bool, shape (n_cell + 1,)
        Cells that the horizon does not touch, and whose neighbours lie on both sides.

    Returns
    -------
    dict of int to int
        By cell: 1 above, -1 below. Cells about which nothing is known are left out.
    """
    sectors = patches.sources[surface].sectors
    if not sectors or not unknown.any():
        return {}
    full = cells.in_full
    touched = {
        name: _touched_zones(patches, full, name) for sector in sectors for name in sector.faults
    }
    decided = {}
    for cell in np.flatnonzero(unknown).tolist():
        rows = (full.cell_of_side == cell).any(axis=1)
        corners = full.x[np.unique(full.triangles[rows])] + patches.origin
        far = [
            corners[:, 2] - sector.at(corners[:, :2])
            for sector in sectors
            if _is_in(cell, sector, touched)
        ]
        if not far:
            continue
        away = np.concatenate(far)
        above, below = bool((away > ROUNDING).any()), bool((away < -ROUNDING).any())
        if above != below:
            decided[cell] = 1 if above else -1
    return decided


def _touched_zones(patches: Patches, full: Cells, name: str) -> np.ndarray:
    """Whether each cell touches front and back of a fault, bool (n_cell + 1, 2); slits apart."""
    out = np.zeros((full.n_cell + 1, 2), dtype=bool)
    if name not in patches.names:
        return out
    sides = full.cell_of_side[full.surface_of == patches.names.index(name)]
    sides = sides[sides[:, 0] != sides[:, 1]]
    out[sides[:, 0], 0] = out[sides[:, 1], 1] = True
    return out


def _is_in(cell: int, sector: Sector, touched: dict[str, np.ndarray]) -> bool:
    """Whether a cell lies on the sides of both faults that a sector is on, and on no other."""
    return all(
        touched[name][cell].tolist() == [front, not front]
        for name, front in zip(sector.faults, sector.front, strict=True)
    )


# ---- blocks ----------------------------------------
# Group units of one zone into blocks, named by the faults that separate them.
#
# A fault separates two units of a zone if one of them touches only its front (``+``, the side
# its normal points into: the hanging wall of a dipping fault) and the other only its back
# (``-``). Whether they face each other does not matter: throw may bring other zones between.
#
# So a name has only the sides that separate units of one zone. One block may be ``F1+ F2-`` in a
# zone and ``F2-`` in the next, which F1 has left. The side of a fault that a unit lies on does
# not depend on zones: from a unit on the ``+`` side of F1, no way leads to the back of F1 but
# through F1.
#
# A virtual wall continues a fault, and has the same front: names do not distinguish the two.


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
    cells: Cells, unit_of_cell: np.ndarray, zone: np.ndarray, faults: Faults
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
    cells: Cells, unit_of_cell: np.ndarray, faults: Faults, words: Sequence[tuple[str, ...]]
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
    sides_by_unit = [set(word) for word in words]

    # a merged unit is one space: a way leads through the fault that parted it before
    cell = np.arange(1, cells.n_cell + 1)
    _, first = np.unique(unit_of_cell[1:], return_index=True)
    within = np.stack([cell, 1 + first[unit_of_cell[1:]]], axis=1)
    pairs, pair_of_face = pairs_of_faces(cells.cell_of_side, cells.n_cell)
    count = np.bincount(pair_of_face[pair_of_face >= 0], minlength=len(pairs))
    for fault, surfaces in faults.items():
        of = [own_sides(cells, i) for i in surfaces]
        faces, sides = (np.concatenate([one[k] for one in of]) for k in (0, 2))

        # all faces but those of the fault: cells that they link are one region
        own = pair_of_face[np.unique(faces)]
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
                    sides_by_unit[u].add(fault + sign)
    # by name first: F1 and F01 have one key
    rank = {
        side: k for k, side in enumerate(sorted(sorted(set().union(*sides_by_unit)), key=in_words))
    }
    return [tuple(sorted(sides, key=rank.__getitem__)) for sides in sides_by_unit]


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
    groups = grouped(((int(zone[u]), name), u) for u, name in enumerate(names))

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
