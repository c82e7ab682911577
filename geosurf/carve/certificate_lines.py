"""The lines of a certificate from their facts, in their order."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from geosurf.carve.certificate_facts import Facts
from geosurf.carve.certificate_names import named
from geosurf.carve.certificate_shells import (
    EPS,
    EXCESS,
    OPEN,
    VERTICES,
    Matched,
    Size,
    surely_exact,
)
from geosurf.carve.outside import box_of
from geosurf.conventions import place, volume_text
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.lattices.sets import first_rows
from geosurf.kernels.meshes.checks import distances_from_parents
from geosurf.kernels.meshes.mesh import inverted_triangles
from geosurf.model import Check, Patches, Units


def lines_of_units(
    facts: Facts,
    units: Units,
    counts: np.ndarray,
    sizes: dict[str, Size],
    shared: Check,
    matched: Matched,
    parts: Matched | None,
) -> list[Check]:
    """The lines of units from their facts.

    `counts` as of `count_edges`. `matched` has the triangles of the patches that its shell has,
    `parts` the same of units before slivers were merged.
    """
    divided = partition(facts, units, matched)
    lines = [
        closed(counts, sizes),
        adds_up(facts.patches, units, sizes),
        shared,
        divided,
        named(facts, units, matched, divided.passed),
    ]
    if units.unmerged is None or parts is None:
        return lines

    # units as they were before slivers were merged have names of their own
    lines.append(merged(units, matched, parts))
    full = partition(facts, units.unmerged, parts)
    names = named(facts, units.unmerged, parts, full.passed)
    return [*lines, replace(names, name="names before slivers were merged match")]


# ---- partition ----------------------------------------
# Check that units fill the box without gaps or overlaps.
#
# Closed shells with the volume of the box could still have a gap as large as an overlap. Therefore
# the triangles of shells are looked up among those of the patches. Each one that is not a wall must
# have one unit on each side. Then the number of units at a point is the same everywhere inside the
# walls, and it is one because volumes add up to the box.


def partition(facts: Facts, units: Units, matched: Matched) -> Check:
    """Each triangle of a shell is a triangle of its surface, with one unit on each side."""
    times = np.bincount(2 * matched.key + matched.turn, minlength=2 * matched.n_key).reshape(-1, 2)
    alone = times.sum(axis=1) == 1
    is_wall = np.isin(facts.surface_of_triangle, facts.rows_of("wall"))
    alone[matched.of_patches[is_wall]] = False
    foreign = matched.row < 0
    twice = times[matched.key, matched.turn.astype(np.int64)] > 1
    gap = alone[matched.key]
    detail = (
        f"{matched.size.sum()} triangles of units; each triangle inside has one unit on each side"
    )
    for bad, what in (
        (foreign, "is not a triangle of its surface"),
        (twice, "has two units on one side"),
        (gap, "has a unit on one side only and is not a wall"),
    ):
        if bad.any():
            i = int(np.flatnonzero(bad)[0])
            where = f"of {list(units)[matched.unit[i]]} at {place(matched.middle_of(i))}"
            detail = f"{matched.size[bad].sum()} triangles: the first, {where}, {what}"
            break
    n_bad = int(matched.size[foreign | twice | gap].sum())
    return Check("units fill the box without overlap", n_bad == 0, float(n_bad), detail)


# ---- check merged slivers: each unit is the union of its parts, and nothing is lost ------
#
# The shells of units before and after are compared triangle by triangle. Where two parts of a unit
# met, the triangles between them are gone; all other triangles are there as before.


MOST = 8  # slivers that are listed
ROUNDING = 2.0**-48  # of the model's volume: what sums over faces may differ by


def merged(units: Units, matched: Matched, before: Matched) -> Check:
    """Each unit is the union of its parts, each sliver touches them, and volumes add up.

    Parameters
    ----------
    units : Units
        With `Units.unmerged`.
    matched, before : Matched
        Triangles of the units, and of those before slivers were merged.
    """
    unmerged = units.unmerged
    assert unmerged is not None
    wrong: list[str] = []
    names, old = list(units), list(unmerged)
    into = {sliver.name: sliver.into for sliver in units.merged}
    small = {sliver.name for sliver in unmerged.slivers}
    wrong += [name for name, to in into.items() if name not in small or to not in units]
    home = _homes(units, unmerged, matched, before, into)
    wrong += [old[u] for u in np.flatnonzero(home < 0).tolist()]
    if not wrong:
        wrong += [names[u] for u in _differ(matched, before, home)]
        wrong += [old[u] for u in _apart(before, home, {old.index(name) for name in into})]
        slack = ROUNDING * units.box_volume
        for k, unit in enumerate(units.values()):
            parts = [unmerged[old[u]].volume for u in np.flatnonzero(home == k).tolist()]
            if abs(math.fsum(parts) - unit.volume) > slack:
                wrong.append(unit.name)
    wrong = list(dict.fromkeys(wrong))
    name = "merged slivers are parts of their neighbours"
    if wrong:
        return Check(name, False, float(len(wrong)), f"not so for {', '.join(wrong[:MOST])}")
    return Check(name, True, 0.0, _in_words(units, unmerged))


def _in_words(units: Units, unmerged: Units) -> str:
    """What was merged into what, with volumes, and that none of the volume is lost."""
    listed = [f"{m.name} ({volume_text(m.volume)}) into {m.into}" for m in units.merged[:MOST]]
    more = len(units.merged) - MOST
    difference = (units.volume - unmerged.volume) / units.box_volume
    return (
        f"{units.merged_in_words}: {'; '.join(listed)}{f'; and {more} more' if more > 0 else ''}; "
        f"relative difference of the sum of all units {difference:.1e}"
    )


def _homes(
    units: Units, unmerged: Units, matched: Matched, before: Matched, into: dict[str, str]
) -> np.ndarray:
    """Number of the unit that each unit before is a part of now; -1 if it is not found.

    Slivers state it. Others may have another name now, since fault sides that only slivers had are
    gone: a triangle that they share with their unit tells.
    """
    number = {name: k for k, name in enumerate(units)}
    home = np.full(len(unmerged), -1)
    _, now, then = np.intersect1d(_codes(matched), _codes(before), return_indices=True)
    home[before.unit[then]] = matched.unit[now]
    for u, name in enumerate(unmerged):
        if name in into:
            home[u] = number.get(into[name], -1)
    return home


def _codes(matched: Matched) -> np.ndarray:
    """One number for each triangle of a shell and the side of it that the unit is on."""
    return 2 * first_rows(matched.of_patches, matched.n_key)[matched.key] + matched.turn


def _differ(matched: Matched, before: Matched, home: np.ndarray) -> list[int]:
    """Units with other triangles than their parts have on the outside."""
    turn = before.turn.astype(np.int64)
    beside = np.full((before.n_key, 2), -1)
    beside[before.key, turn] = home[before.unit]
    outer = beside[before.key, 0] != beside[before.key, 1]
    n = int(home.max(initial=0)) + 1
    want = _codes(before)[outer] * n + home[before.unit[outer]]
    differ = np.setxor1d(want, _codes(matched) * n + matched.unit)
    return np.unique(differ % n).tolist()


def _apart(before: Matched, home: np.ndarray, slivers: set[int]) -> list[int]:
    """Slivers that share no triangle with another part of their unit."""
    beside = np.full((before.n_key, 2), -1)
    beside[before.key, before.turn.astype(np.int64)] = before.unit
    inner = beside[(beside >= 0).all(axis=1)]
    one, two = home[inner].T
    return sorted(slivers - set(inner[one == two].ravel().tolist()))


# ---- checks ----------------------------------------
# Checks of a certificate from their facts, whether triangles or runs gave them.


VOLUME_TOLERANCE = 1e-12
Part = tuple[np.ndarray, np.ndarray]


def closed(counts: np.ndarray, sizes: dict[str, Size]) -> Check:
    """Shells have no open edges and face outward, so their volume is positive."""
    n_open = dict(zip(sizes, counts[:, OPEN].tolist(), strict=True))
    leaking = [name for name in sizes if n_open[name]]
    turned = [name for name in sizes if sizes[name].volume <= 0.0]

    # vertices - edges + triangles: 2 for a ball, 2 - 2 k for a body with k handles; edges of a
    # shell have two triangles each, but for those that were counted
    n = np.array([size.n_triangle for size in sizes.values()], dtype=np.int64)
    euler = counts[:, VERTICES] - (3 * n + counts[:, EXCESS]) // 2 + n
    words = euler_in_words(dict(zip(sizes, euler.tolist(), strict=True)))
    detail = f"{len(sizes)} units, 0 open edges; {words}"
    if leaking:
        detail = f"{sum(n_open.values())} open edges in {', '.join(leaking[:8])}"
    elif turned:
        detail = f"turned inside out: {', '.join(turned[:8])}"
    n_bad = len({*leaking, *turned})
    return Check("units are closed and oriented", n_bad == 0, float(n_bad), detail)


def euler_in_words(euler: dict[str, int]) -> str:
    """The Euler number of most units (2 for a ball), and the units with another number."""
    # one number for most units, the others by name: a list of hundreds is not read
    numbers = list(euler.values())
    usual = max(sorted(set(numbers), reverse=True), key=numbers.count, default=2)
    others = [f"{name} {number}" for name, number in euler.items() if number != usual]
    more = f" and {len(others) - 8} more" if len(others) > 8 else ""
    return f"Euler number {usual}" + (f", but {', '.join(others[:8])}{more}" if others else "")


def adds_up(patches: Patches, units: Units, anew: dict[str, Size]) -> Check:
    """Compare volumes recomputed from the shells with the stated volumes and with the box.

    A stated volume may differ by the rounding error of prisms as high as the model, unless it is so
    small that it was summed exactly.
    """
    lower, upper = box_of(patches)
    total, box = math.fsum(size.volume for size in anew.values()), units.box_volume
    error = (total - box) / box

    # slack: rounding of an area, from the sizes of its triangles; times the height it is that of
    # prisms
    off, small, height = [], surely_exact(patches), float(upper[2] - lower[2])
    for name, unit in units.items():
        size = anew[name]
        bound = VOLUME_TOLERANCE * size.volume
        if size.volume > small:
            bound += size.slack * height
        if abs(size.volume - unit.volume) > bound or abs(size.area - unit.area) > size.slack:
            off.append(name)

    # the box that units state, against the walls
    world = np.stack([lower, upper], axis=1) + patches.origin[:, None]
    moved = units.box != tuple(world.ravel().tolist())
    passed = abs(error) <= VOLUME_TOLERANCE and not off and not moved
    detail = (
        f"sum of units {total / 1e6:.15g} million m³, box {box / 1e6:.15g} million m³, "
        f"relative difference {abs(error):.1e}"
    )
    if off:
        detail += f"; the stated volume or area of {', '.join(off[:8])} differs from its shell"
    if moved:
        detail += "; the stated box differs from the walls"
    return Check("volumes add up to the box", passed, float(error), detail)


def shared_vertices(n: int, foreign: list[str]) -> Check:
    """Each corner of a shell is a vertex of the patches, bit for bit, but for `foreign` units."""
    detail = f"{n} vertices of units are vertices of the surfaces, bit for bit"
    if foreign:
        detail = f"corners of {', '.join(foreign[:8])} are not vertices of the surfaces"
    name = "units share the surfaces' vertices"
    return Check(name, not foreign, float(len(foreign)), detail)


def limits_of(x: np.ndarray) -> np.ndarray:
    """Lower and upper corner of points (2, 3), 0 without points.

    Examples
    --------
    >>> limits_of(np.array([[0.0, 5, 2], [3, 4, 1]])).tolist()
    [[0.0, 4.0, 1.0], [3.0, 5.0, 2.0]]
    """
    if not len(x):
        return np.zeros((2, 3))
    # axis by axis, since numpy is slow along short rows
    return np.array([[of.min(), of.max()] for of in x.T]).T


def beside_parents(local: np.ndarray, parts: Iterable[Part], origin: np.ndarray) -> list[Check]:
    """Check that new triangles lie on their input triangles, and keep the orientation of these.

    The first is a distance of each corner from the plane and the sides of its input triangle, the
    second an exact test.

    Parameters
    ----------
    local : ndarray of float64, shape (n_vertex, 3)
    parts : iterable of (ndarray of int64 (n, 3), ndarray of float64 (n, 3, 3))
        New triangles as rows of `local`, and the corners of their input triangles, part by part: so
        that not all corners are in memory at once.
    origin : ndarray of float64, shape (3,)
    """
    low, high = limits_of(local)
    span = float((high - low).max() + max(np.abs(low).max(), np.abs(high).max()))

    # the rounding of a coordinate of this size, with room
    bound = 1e-12 * max(span, 1.0)
    near, far, n, n_bad, where = True, 0.0, 0, 0, ""
    for t, parent in parts:
        off, slack = distances_from_parents(local, t, parent.reshape(-1, 9))

        # the plane of a sliver has a larger rounding error
        near &= bool((off <= bound + 16 * EPS * slack).all())
        far = max(far, float(off.max(initial=0.0)))
        bad = _turned_over(local, t, parent)
        if len(bad) and not n_bad:
            where = place(local[t[bad[0], 0]] + origin)
        n, n_bad = n + len(t), n_bad + len(bad)

    detail = f"largest distance from the input triangle {far:.1e} m (bound {bound:.1e} m)"
    lie = Check("triangles lie on their input triangles", near, far, detail)
    detail = f"orientation of {n} new triangles tested exactly; all others are copies"
    if n_bad:
        detail = f"{n_bad} triangles are turned over or flat, the first at {where}"
    name = "triangles keep the orientation of their input"
    return [lie, Check(name, n_bad == 0, float(n_bad), detail)]


def _turned_over(local: np.ndarray, t: np.ndarray, parent: np.ndarray) -> np.ndarray:
    """Rows of triangles that do not face as their input triangles do."""
    # corners of each triangle, then of each input triangle: a part costs what it is
    x = np.concatenate([local.take(t.ravel(), axis=0), parent.reshape(-1, 3)])
    t, of = np.split(np.arange(len(x)).reshape(-1, 3), 2)
    m, w = frame_of(x)
    return inverted_triangles(x, t, of, np.arange(len(t)), m, w)


def areas_agree(patches: Patches, areas: list[tuple[float, float, float]], largest: float) -> Check:
    """Compare areas, given that of each surface, that of its input, and the sum of all sides."""
    worst, passed, step = 0.0, True, EPS * largest
    for i, (area, before, rim) in enumerate(areas):
        dropped = patches.report.get("dropped_area", {}).get(i, 0.0)  # beyond faults
        difference = abs(area + dropped - before)
        passed &= difference <= 1e-12 * before + 4 * step * rim
        worst = max(worst, difference / before if before else 0.0)
    detail = f"largest relative difference {worst:.1e}"
    return Check("areas add up", bool(passed), worst, detail)
