"""Units against the patches that they were carved from: they divide the box, and names fit.

Closed shells whose volumes add up to the box might still leave a gap as large as an overlap, or
have each other's names. So triangles of shells are looked up among those of the patches. Crossing
one that is no wall leaves one unit and enters another: then the number of units around a place is
the same all over the inside of the walls, and since volumes add up to the box, it is one.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from geosurf.carve.blocks import WHOLE
from geosurf.carve.column import names_of_zones
from geosurf.carve.fluids import parse_sides
from geosurf.carve.outside import box_of
from geosurf.carve.shells import unit_name
from geosurf.conventions import place
from geosurf.kernels.mesh import weld
from geosurf.model import Check, Patches, Unit, Units


@dataclass(frozen=True)
class Matched:
    """Triangles of all shells among those of the patches.

    Attributes
    ----------
    unit, surface : ndarray of int64, shape (n,)
        Unit that each triangle of a shell bounds, and the surface that it names.
    key : ndarray of int64, shape (n,)
        Equal for triangles with the same corners, of shells and of patches.
    row : ndarray of int64, shape (n,)
        The triangle of the patches with these corners on that surface; -1 if there is none.
    behind : ndarray of bool, shape (n,)
        Whether the unit lies behind it.
    turn : ndarray of bool, shape (n,)
        Which way the corners go round: two shells on both sides of a triangle differ.
    of_patches : ndarray of int64, shape (n_triangle,)
        Key of each triangle of the patches, and `turn_of_patches` which way its corners go round.
    n_key : int
    """

    unit: np.ndarray
    surface: np.ndarray
    key: np.ndarray
    row: np.ndarray
    behind: np.ndarray
    turn: np.ndarray
    of_patches: np.ndarray
    turn_of_patches: np.ndarray
    n_key: int


def numbered(patches: Patches, units: Units) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the patches and of all shells, and a number of each place, in their order."""
    x = np.concatenate([patches.local, *(unit.local for unit in units.values())])
    return x, weld(x)[0]


def matched(patches: Patches, units: Units, number: np.ndarray) -> Matched:
    """
    Look up the triangles of shells among those of the patches.

    Parameters
    ----------
    patches : Patches
    units : Units
    number : ndarray of int64
        See `numbered`.
    """
    parts = list(units.values())
    first = len(patches.local) + np.cumsum([0, *(len(part.local) for part in parts)])
    shells = [part.triangles + start for part, start in zip(parts, first.tolist(), strict=False)]
    t = number[np.concatenate([patches.triangles, *shells])]
    turn = np.sum([t[:, k] < t[:, (k + 1) % 3] for k in range(3)], axis=0) == 2
    key, n_key = weld(np.sort(t, axis=1).astype(np.float64))
    unit = np.repeat(np.arange(len(parts)), [len(part.triangles) for part in parts])
    surface = np.concatenate([np.empty(0, np.int64), *map(_surfaces, parts)])
    n, n_surface = patches.n_triangle, len(patches.sources)
    known = key[:n] * n_surface + patches.surface_of_triangle
    order = np.argsort(known, kind="stable")
    wanted = key[n:] * n_surface + surface
    at = np.minimum(np.searchsorted(known, wanted, sorter=order), n - 1)
    row = np.where(known[order[at]] == wanted, order[at], -1)
    behind = turn[n:] == turn[:n][row]
    return Matched(unit, surface, key[n:], row, behind, turn[n:], key[:n], turn[:n], n_key)


def _surfaces(unit: Unit) -> np.ndarray:
    """Surface of each triangle of a shell; -1 where that is not one for each."""
    n = len(unit.triangles)
    return unit.surface_of_triangle if len(unit.surface_of_triangle) == n else np.full(n, -1)


def partition(patches: Patches, units: Units, found: Matched) -> Check:
    """Each triangle of a shell is one of the surface it names, with one unit on each side of it."""
    times = np.bincount(2 * found.key + found.turn, minlength=2 * found.n_key).reshape(-1, 2)
    alone = times.sum(axis=1) == 1
    is_wall = np.isin(patches.surface_of_triangle, _rows(patches, "wall"))
    alone[found.of_patches[is_wall]] = False
    foreign = found.row < 0
    twice = times[found.key, found.turn.astype(np.int64)] > 1
    gap = alone[found.key]
    detail = f"{len(found.key)} triangles of shells, each on one side of one of a surface"
    for bad, what in (
        (foreign, "is no triangle of the surface it names"),
        (twice, "has two units on one side"),
        (gap, "has a unit on one side only, and is no wall"),
    ):
        if bad.any():
            i = int(np.flatnonzero(bad)[0])
            unit = list(units.values())[found.unit[i]]
            j = i - int(np.searchsorted(found.unit, found.unit[i]))
            where = place(unit.vertices[unit.triangles[j]].mean(axis=0))
            detail = f"{int(bad.sum())} triangles: the first, of {unit.name} at {where}, {what}"
            break
    n_bad = int((foreign | twice | gap).sum())
    return Check("units divide the box", n_bad == 0, float(n_bad), detail)


def named(patches: Patches, units: Units, found: Matched, divided: bool) -> Check:
    """Zones, blocks and contacts in names are those that the surfaces around each unit tell.

    What sets blocks apart is told by all units of a zone: only where these are `divided`, see
    `partition`.
    """
    parts = list(units.values())
    wrong = [unit.name for unit in parts if not _spelt(patches, unit)]
    upward = _upward(patches)
    wrong += [parts[u].name for u in _in_other_zones(patches, parts, found, upward)]
    shell, surface, behind = _on_surfaces(patches, found)
    codes = (surface * len(parts) + found.unit[shell]) * 2 + behind
    for code in np.unique(codes).tolist():
        (one, u), back = divmod(code // 2, len(parts)), code % 2 == 1
        if patches.names[one] + ("+" if back else "-") in parts[u].lies_on:
            wrong.append(parts[u].name)
    if divided:
        wrong += _in_other_blocks(patches, parts, found, (shell, surface, behind))
    wrong += _contacts_apart(patches, parts, found, upward)
    wrong = list(dict.fromkeys(wrong))
    detail = f"{len(parts)} units lie in the zones and on the sides of faults that name them"
    if wrong:
        detail = f"surfaces around {', '.join(wrong[:8])} tell another zone, block or contact"
    return Check("units are where their names say", not wrong, float(len(wrong)), detail)


def _on_surfaces(patches: Patches, found: Matched) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Each triangle of a shell, each surface that it lies on, whether the unit is behind that.

    Where surfaces coincide a shell names one of them, and each is turned its own way.
    """
    times = np.bincount(found.of_patches, minlength=found.n_key)
    once = np.flatnonzero((found.row >= 0) & (times[found.key] <= 1))
    several = np.flatnonzero(times[found.key] > 1)
    rows = np.flatnonzero(times[found.of_patches] > 1)
    rows = rows[np.argsort(found.of_patches[rows], kind="stable")]
    start = np.searchsorted(found.of_patches[rows], found.key[several])
    count = times[found.key[several]]
    nth = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    row = np.concatenate([found.row[once], rows[np.repeat(start, count) + nth]])
    shell = np.concatenate([once, np.repeat(several, count)])
    behind = found.turn[shell] == found.turn_of_patches[row]
    return shell, patches.surface_of_triangle[row], behind


def _in_other_blocks(
    patches: Patches,
    parts: list[Unit],
    found: Matched,
    on: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> Iterable[str]:
    """Units whose block has other sides of faults than those that set it apart in its zone.

    These are told anew by all triangles of shells: a fault sets apart what touches only its front
    from what touches only its back. Fluid contacts part no blocks.
    """
    blocks = dict.fromkeys((unit.zone, unit.block) for unit in parts)
    number = {block: k for k, block in enumerate(blocks)}
    of_unit = np.array([number[unit.zone, unit.block] for unit in parts], dtype=np.int64)
    zones = list(dict.fromkeys(unit.zone for unit in parts))
    zone = np.array([zones.index(of) for of, _ in blocks], dtype=np.int64)
    beside = np.full((found.n_key, 2), -1)
    beside[found.key, found.turn.astype(np.int64)] = of_unit[found.unit]
    shell, surface, behind = on
    inside = beside[found.key[shell]]
    apart = inside[:, 0] != inside[:, 1]  # others are slits
    touched = np.zeros((len(patches.sources), len(blocks), 2), dtype=bool)
    of = of_unit[found.unit[shell[apart]]]
    touched[surface[apart], of, behind[apart].astype(np.int64)] = True
    told: list[set[str]] = [set() for _ in blocks]
    faults = _rows(patches, "fault")
    for fault in faults:
        alone = touched[fault] & ~touched[fault][:, ::-1]
        both = np.isin(zone, zone[alone[:, 0]]) & np.isin(zone, zone[alone[:, 1]])
        for block, side in np.argwhere(alone & both[:, None]).tolist():
            told[block].add(patches.names[fault] + "+-"[side])
    names = [patches.names[i] for i in faults]
    said = [_sides_said(block, names) for _, block in blocks]
    for unit, k in zip(parts, of_unit.tolist(), strict=True):
        if said[k] != told[k]:
            yield unit.name


def _sides_said(block: str, faults: list[str]) -> frozenset[str] | None:
    """Sides of faults in the name of a block; None if it is made of something else."""
    name = re.sub(r" #\d+$", "", block)
    return frozenset() if name == WHOLE else parse_sides(name, faults)


def _rows(patches: Patches, role: str) -> list[int]:
    return [i for i, source in enumerate(patches.sources) if source.role == role]


def _spelt(patches: Patches, unit: Unit) -> bool:
    """Whether a name is made of zone, block and contact, and these of names that there are."""
    horizons, faults = ([patches.names[i] for i in _rows(patches, r)] for r in ("horizon", "fault"))
    zones = names_of_zones(horizons)
    sides = _sides_said(unit.block, faults)
    return (
        unit.name == unit_name(unit.zone, unit.block, unit.contact)
        and 0 <= unit.zone_index < len(zones)
        and unit.zone == zones[unit.zone_index]
        and sides is not None
        and sides <= set(unit.lies_on)
    )


def _upward(patches: Patches) -> np.ndarray:
    """Whether the front of each surface looks up, in the bounds of the walls."""
    lower, upper = box_of(patches)
    a, b, c = (patches.local[patches.triangles[:, k]] for k in range(3))
    inside = np.all([((p >= lower) & (p <= upper)).all(axis=1) for p in (a, b, c)], axis=0)
    rise = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    of = patches.surface_of_triangle
    return np.bincount(of[inside], rise[inside], minlength=len(patches.sources)) >= 0.0


def _in_other_zones(
    patches: Patches, parts: list[Unit], found: Matched, upward: np.ndarray
) -> list[int]:
    """Units above a horizon in a zone below it, or the other way round.

    Where horizons coincide, the column may have taken away all but one.
    """
    horizons = _rows(patches, "horizon")
    zone = np.array([unit.zone_index for unit in parts])[found.unit]
    open_ = np.flatnonzero(np.isin(found.surface, horizons) & (found.row >= 0))
    for rank, i in enumerate(horizons):
        rows = np.flatnonzero(patches.surface_of_triangle == i)
        turn = np.zeros(found.n_key, dtype=np.int64)
        turn[found.of_patches[rows]] = 1 + found.turn_of_patches[rows]
        turn = turn[found.key[open_]]
        below = (turn == 1 + found.turn[open_]) == upward[i]
        open_ = open_[(turn == 0) | (below != (zone[open_] > rank))]
    return np.unique(found.unit[open_]).tolist()


def _contacts_apart(
    patches: Patches, parts: list[Unit], found: Matched, upward: np.ndarray
) -> Iterable[str]:
    """Names of units that a fluid contact parts, where these do not say so."""
    mine = np.flatnonzero(np.isin(found.surface, _rows(patches, "contact")) & (found.row >= 0))
    below = found.behind[mine] == upward[found.surface[mine]]
    order = np.lexsort((below, found.key[mine]))  # above, then below
    mine, below = mine[order], below[order]
    two = np.flatnonzero(found.key[mine[1:]] == found.key[mine[:-1]])
    pairs = np.stack([found.unit[mine[two]], found.unit[mine[two + 1]]], axis=1)
    for u, v in np.unique(pairs, axis=0).tolist():  # above, below
        high, low = parts[u], parts[v]
        same = (high.zone, high.block) == (low.zone, low.block) and high.contact != low.contact
        if not same or _begins(high, "below ") or _begins(low, "above "):
            yield from (high.name, low.name)


def _begins(unit: Unit, word: str) -> bool:
    """Whether a unit is the lowest or uppermost of its block; names may hold the word, too."""
    return unit.contact.startswith(word) and "/" not in unit.contact
