"""Bound the reservoir rock below a horizon by triangles whose corners know their wall of a fault.

The horizon is the roof of the rock; faults, sides of the model and other horizons are the rest.
Units of one reservoir are one rock: what lies between them is left out. A fault parts what is on
both sides of it, so that a vertex on it is a corner of its own on each wall. Which triangles see
the same rock around an edge follows from the order of their angles, by exact signs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.errors import InputError
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.lattices.sets import pairs_of_equal
from geosurf.kernels.meshes.mesh import edge_keys, edges, join_pairs, renumbered
from geosurf.kernels.meshes.seams import DONE, NEEDS_EXACT, sort_seams
from geosurf.measure.cutoffs import level_of
from geosurf.measure.faces import check_model, row_inside
from geosurf.measure.walls import Walls
from geosurf.model import Patches, Units

ROOF, FAULT, WALL, HORIZON = range(4)  # what a triangle of the boundary is


@dataclass(frozen=True, eq=False)
class Rock:
    """Boundary of the rock below a horizon: each triangle once for each side with rock.

    Attributes
    ----------
    x : ndarray of float64, shape (n_node, 3)
        Local [m]. A vertex on a fault is a node for each wall.
    t : ndarray of int64, shape (n, 3)
        Nodes, counter-clockwise seen from outside of the rock.
    kind, surface, unit : ndarray of int64, shape (n,)
        `ROOF` ...; row of the surface; row of the unit in which the rock lies.
    passes : ndarray of int64, shape (n_pass, 4)
        Where reservoir faces reservoir across a fault that does not hold there: node, node on the
        other wall (-1 where that is no rock below the horizon), row of the fault, index of the zone
        on the other wall.
    links : ndarray of int64, shape (n_link, 2)
        Edges beside those of triangles: from leaks inside triangles to their highest corners.
    """

    x: np.ndarray
    t: np.ndarray
    kind: np.ndarray
    surface: np.ndarray
    unit: np.ndarray
    passes: np.ndarray
    links: np.ndarray

    def nodes(self, chosen: np.ndarray) -> np.ndarray:
        """Whether each node is one of some triangles, bool (n_node,)."""
        found = np.zeros(len(self.x), dtype=bool)
        found[self.t[chosen]] = True
        return found


@dataclass(frozen=True, eq=False)
class Seal:
    """A fault that holds where its shale gouge ratio is at least so large."""

    walls: Walls
    least: float

    def leaks(self, x: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangles (n, 3, 3), with their units (n, 2), that leak: rows, and highest points.

        Where the ratio is not known, the fault does not hold.
        """
        corners, row, values, _ = self.walls.divided(x, sides)
        above = values.ratio.reshape(-1, 3) - self.least
        above = np.where(np.isnan(above), -1.0, above)
        at, k = np.nonzero(above < 0.0)
        places, rows = [corners[at, k]], [row[at]]
        for a, b in ((0, 1), (1, 2), (2, 0)):  # where an edge begins to hold
            at = np.flatnonzero((above[:, a] < 0.0) != (above[:, b] < 0.0))
            share = (above[at, a] / (above[at, a] - above[at, b]))[:, None]
            places.append(corners[at, a] + share * (corners[at, b] - corners[at, a]))
            rows.append(row[at])
        place, of = np.concatenate(places), np.concatenate(rows)
        order = np.lexsort((place[:, 1], place[:, 0], -place[:, 2], of))
        leaky, first = np.unique(of[order], return_index=True)
        return leaky, place[order[first]]


def rock_below(units: Units, level: int) -> tuple[list[int], list[int]]:
    """Zones of the reservoir that follow each other below a horizon, and all others, by index."""
    zones = {unit.zone_index for unit in units.values() if unit.zone in units.reservoir}
    rock: list[int] = []
    while level + 1 + len(rock) in zones:
        rock.append(level + 1 + len(rock))
    return rock, sorted(zones - set(rock))


def roofs_of(patches: Patches, units: Units, horizon: str | None = None) -> list[str]:
    """Horizons with a zone of the reservoir directly below, or the one that is asked for.

    Raises
    ------
    InputError
        For an unknown horizon, or one without.
    """
    check_model(patches, units)
    rows = [i for i in sorted(units.rows_inside) if patches.sources[i].role == "horizon"]
    roofs = [patches.names[i] for i in rows if rock_below(units, level_of(patches, i))[0]]
    if horizon is None:
        return roofs
    row_inside(patches, units, horizon, "horizon")
    if horizon not in roofs:
        raise InputError(
            f"horizon {horizon!r} has no zone of the reservoir directly below, so nothing is "
            f"closed there. Ask for one of {roofs}, or name that zone in reservoir=."
        )
    return [horizon]


def bounded_rock(
    patches: Patches, units: Units, horizon: str, passed: Mapping[int, Seal | None]
) -> Rock:
    """
    Bound the rock below a horizon.

    Parameters
    ----------
    patches, units : Patches, Units
    horizon : str
    passed : mapping of int to Seal or None
        Rows of the faults that do not hold where reservoir faces reservoir, or only by their seal.

    Returns
    -------
    Rock
    """
    row = row_inside(patches, units, horizon, "horizon")
    level, listed = level_of(patches, row), list(units.values())
    zones, others = rock_below(units, level)
    rows_with = {
        role: [i for i, source in enumerate(patches.sources) if source.role == role]
        for role in ("horizon", "fault", "wall")
    }

    # of triangles with the same corners the first stands for the others
    pieces, element = patches.pieces, patches.pieces.expanded.element
    core = np.flatnonzero(element < len(pieces.triangles))
    row_of = np.empty(len(pieces.triangles), dtype=np.int64)
    row_of[element[core]] = core
    twin, first = (row_of[passed_to] for passed_to in pieces.coinciding)

    def on(rows: Sequence[int]) -> np.ndarray:
        """Whether each triangle, or one that coincides with it, is of some surfaces."""
        found = np.isin(patches.surface_of_triangle, rows)
        found[first[found[twin]]] = True
        return found

    # the boundary: one side in rock, or a fault in it
    zone = np.array([*(unit.zone_index for unit in listed), -1])
    inside = np.append(np.isin(zone[:-1], zones), False)[units.sides]
    is_fault = on(rows_with["fault"])
    keep = inside.any(axis=1) & (is_fault | ~inside.all(axis=1))
    keep[twin] = False
    rows = np.flatnonzero(keep)
    t, inside, sides = patches.triangles[rows], inside[rows], units.sides[rows]
    surface, is_fault = patches.surface_of_triangle[rows], is_fault[rows]
    younger = (~inside & (zone[sides] <= level)).any(axis=1)  # above the roof
    kind = np.where(np.isin(surface, rows_with["wall"]), WALL, HORIZON)
    kind[is_fault] = FAULT
    kind[on([row])[rows] & younger] = ROOF

    # nodes: vertices, but on faults one for each fan of triangles that see the same rock
    at_fault = np.zeros(len(patches.local), dtype=bool)
    at_fault[t[is_fault]] = True
    near = np.flatnonzero(at_fault[t.T].any(axis=0))
    key = np.repeat(t[:, None], 2, axis=1)
    fans = _fans(patches.local, t[near], inside[near], is_fault[near]) + len(at_fault)
    key[near] = np.where(at_fault[key[near]], fans, key[near])
    part, side = np.nonzero(inside)
    used, nodes = renumbered(key[part, side])
    point = np.empty(len(used), dtype=np.int64)
    point[nodes] = t[part]

    # what faces this rock or another reservoir across a fault
    number = np.full(inside.shape, -1)
    number[part, side] = np.arange(len(part))
    across = zone[sides[part, 1 - side]]
    leaks = np.flatnonzero(
        is_fault[part] & np.isin(surface[part], list(passed)) & np.isin(across, [*zones, *others])
    )
    other = number[part[leaks], 1 - side[leaks]]
    there = np.where((other >= 0)[:, None], nodes[other], -1)
    passed_to = np.stack([surface[part[leaks]], across[leaks]], axis=1)
    turned = np.where((side == 0)[:, None], nodes[:, ::-1], nodes)
    rock = Rock(
        patches.local[point], turned, kind[part], surface[part], sides[part, side],
        np.column_stack([nodes[leaks].ravel(), there.ravel(), np.repeat(passed_to, 3, axis=0)]),
        np.empty((0, 2), dtype=np.int64),
    )  # fmt: skip
    for row, seal in passed.items():
        if seal is not None:
            at_fault_row = np.flatnonzero(passed_to[:, 0] == row)
            which = part[leaks[at_fault_row]]
            leaky, place = seal.leaks(patches.local[t[which]], sides[which])
            at_fault_row = at_fault_row[leaky]
            top = rock.x[nodes[leaks[at_fault_row]], 2].argmax(axis=1)
            ends = np.stack([nodes[leaks[at_fault_row], top], there[at_fault_row, top]])
            rock = _with_leaks(rock, row, place, ends, passed_to[at_fault_row])
    return rock


def _with_leaks(
    rock: Rock, fault: int, place: np.ndarray, ends: np.ndarray, beyond: np.ndarray
) -> Rock:
    """Let a fault be passed at the highest leak of each triangle only, from a node on each wall.

    Rock leads from such a node up to the highest corner of its triangle, one of `ends` (2, n).
    """
    here, there = ends
    n, facing = len(rock.x), np.flatnonzero(there >= 0)
    node, across = n + np.arange(len(place)), np.full(len(place), -1)
    across[facing] = n + len(place) + np.arange(len(facing))
    links = [np.stack([node, here], 1), np.stack([across[facing], there[facing]], 1)]
    others = rock.passes[rock.passes[:, 2] != fault]
    return replace(
        rock,
        x=np.concatenate([rock.x, place, place[facing]]),
        passes=np.concatenate([others, np.column_stack([node, across, beyond])]),
        links=np.concatenate([rock.links, *links]),
    )


def _fans(x: np.ndarray, t: np.ndarray, inside: np.ndarray, is_fault: np.ndarray) -> np.ndarray:
    """Number of the fan of each corner on each side of triangles, int64 (n, 2, 3).

    Corners are of one fan if a way through rock leads from one to the other around their vertex.
    """
    used, t = renumbered(t)
    x, key, corners = x[used], edge_keys(t, len(used)), t.ravel()
    at = np.isin(key, key[np.repeat(is_fault, 3)])
    half = np.arange(len(key)).reshape(-1, 3)
    ends = np.stack([half.ravel(), half[:, [1, 2, 0]].ravel()], axis=1)  # of each half-edge
    falls = corners[ends[:, 0]] > corners[ends[:, 1]]
    ends[falls] = ends[falls, ::-1]

    # around an edge that no fault has, all see the same rock, each from the side where rock is
    plain = pairs_of_equal(key, np.flatnonzero(~at))
    seen = [ends[halves] + 3 * (halves // 3 + inside[halves // 3, 1])[:, None] for halves in plain]
    pairs = [np.stack(seen, axis=2).reshape(-1, 2)]

    # at a fault, in the order of their angles: each sees the next one
    faults = np.flatnonzero(at)
    start, seams, first = _in_order(x, t, faults[np.unique(key[faults], return_index=True)[1]])
    onward = np.arange(1, len(seams) + 1)
    onward[start[1:] - 1] = start[:-1]
    (before, bit), (after, side) = np.divmod(seams, 2), np.divmod(seams[onward], 2)
    rock = np.flatnonzero(inside[before, 1 - bit] & inside[after, side])
    at_ends = corners[ends[np.repeat(first, np.diff(start))[rock]]]
    for k in range(2):
        faced = [
            6 * halves + 3 * which + (t[halves] == at_ends[:, k, None]).argmax(axis=1)
            for halves, which in ((before[rock], 1 - bit[rock]), (after[rock], side[rock]))
        ]
        pairs.append(np.stack(faced, axis=1))
    return join_pairs(np.concatenate(pairs), 6 * len(t)).reshape(-1, 2, 3)


def _in_order(
    x: np.ndarray, t: np.ndarray, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles around edges by angle: see `geosurf.kernels.meshes.seams`; and these edges."""
    ring, every, px = edges(t, len(x))[0], np.arange(len(t)), x[t].reshape(-1, 3)
    pt, part = np.arange(len(px)).reshape(-1, 3), np.zeros(len(t), dtype=np.int64)
    m = w = np.empty(0, dtype=np.int64)
    while True:
        start, seams = np.empty(len(first) + 1, np.int64), np.empty(len(px), np.int64)
        failed = sort_seams(x, t, ring, first, part, every, px, pt, m, w, start, seams)
        if failed == DONE:
            return start, seams[: start[-1]], first
        if failed == NEEDS_EXACT:
            m, w = frame_of(px)
        else:  # rounding has put two triangles into one half-plane: nothing is joined there
            first = first[first != failed]
