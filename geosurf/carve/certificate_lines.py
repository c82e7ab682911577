"""The lines of a certificate in their order, and halves of them in threads that are free."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from geosurf.arrangement.threads import in_turn
from geosurf.carve.certificate_elements import Elements, Matched, partition
from geosurf.carve.certificate_names import named
from geosurf.carve.measures import doubtful_volume
from geosurf.carve.outside import box_of
from geosurf.conventions import place, volume_text
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.lattices.sets import first_rows
from geosurf.kernels.meshes.mesh import inverted_triangles
from geosurf.kernels.meshes.shells import distances_from_parents
from geosurf.model import Check, Patches, Units

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.arrangement.threads import Threads


MANY = 100_000  # triangles, from which units and mesh are checked in two threads
Half = Callable[[], list[Check] | None]


def lines_of_units(
    patches: Patches,
    elements: Patches | Elements,
    units: Units,
    edges: dict[str, tuple[int, int]],
    sizes: dict[str, Size],
    shared: Check,
    found: Matched,
    parts: Matched | None,
) -> list[Check]:
    """The lines of units from their facts, which runs or triangles gave.

    `edges` are open edges and Euler number of each unit. `found` has the triangles of the
    patches that its shell has, `parts` the same of units before slivers were merged.
    """
    divided = partition(elements, units, found)
    lines = [
        closed(edges, sizes),
        adds_up(patches, units, sizes),
        shared,
        divided,
        named(elements, units, found, divided.passed),
    ]
    if units.unmerged is None or parts is None:
        return lines

    # units as they were before slivers were merged have names of their own
    lines.append(merged(patches, units, found, parts))
    full = partition(elements, units.unmerged, parts)
    names = named(elements, units.unmerged, parts, full.passed)
    return [*lines, replace(names, name="names before slivers were merged match")]


def lines_of(halves: list[Half], spare: Threads | None) -> list[Check] | None:
    """Lines of all halves in their order, or None if one half has no answer."""
    found = in_turn(halves, spare)
    whole = [half for half in found if half is not None]
    return list(itertools.chain.from_iterable(whole)) if len(whole) == len(found) else None


# ---- check merged slivers: each unit is the union of its parts, and nothing is lost ------
#
# The shells of units before and after are compared triangle by triangle. Where two parts of a unit
# met, the triangles between them are gone; all other triangles are there as before.


MOST = 8  # slivers that are listed
ROUNDING = 2.0**-48  # of the model's volume: what sums over faces may differ by


def merged(patches: Patches, units: Units, found: Matched, before: Matched) -> Check:
    """Each unit is the union of its parts, each sliver touches them, and volumes add up.

    Parameters
    ----------
    patches : Patches
    units : Units
        With `Units.unmerged`.
    found, before : Matched
        Triangles of the units, and of those before slivers were merged.
    """
    unmerged = units.unmerged
    assert unmerged is not None
    wrong: list[str] = []
    names, old = list(units), list(unmerged)
    into = {one.name: one.into for one in units.merged}
    small = {one.name for one in unmerged.slivers}
    wrong += [name for name, to in into.items() if name not in small or to not in units]
    home = _homes(units, unmerged, found, before, into)
    wrong += [old[u] for u in np.flatnonzero(home < 0).tolist()]
    if not wrong:
        wrong += [names[u] for u in _differ(found, before, home)]
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
    units: Units, unmerged: Units, found: Matched, before: Matched, into: dict[str, str]
) -> np.ndarray:
    """Number of the unit that each unit before is a part of now; -1 if it is not found.

    Slivers state it. Others may have another name now, since fault sides that only slivers had are
    gone: a triangle that they share with their unit tells.
    """
    number = {name: k for k, name in enumerate(units)}
    home = np.full(len(unmerged), -1)
    _, now, then = np.intersect1d(_codes(found), _codes(before), return_indices=True)
    home[before.unit[then]] = found.unit[now]
    for u, name in enumerate(unmerged):
        if name in into:
            home[u] = number.get(into[name], -1)
    return home


def _codes(found: Matched) -> np.ndarray:
    """One number for each triangle of a shell and the side of it that the unit is on."""
    return 2 * first_rows(found.of_patches, found.n_key)[found.key] + found.turn


def _differ(found: Matched, before: Matched, home: np.ndarray) -> list[int]:
    """Units with other triangles than their parts have on the outside."""
    turn = before.turn.astype(np.int64)
    beside = np.full((before.n_key, 2), -1)
    beside[before.key, turn] = home[before.unit]
    outer = beside[before.key, 0] != beside[before.key, 1]
    n = int(home.max(initial=0)) + 1
    want = _codes(before)[outer] * n + home[before.unit[outer]]
    differ = np.setxor1d(want, _codes(found) * n + found.unit)
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
EPS = 2.0**-53
CROSSES = "surfaces meet only along shared edges"
SHARED = "units share the surfaces' vertices"
Part = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Size:
    """Volume [m3] and area [m2] of a shell, and by how much rounding may have changed the area."""

    volume: float
    area: float
    slack: float


def surely_exact(patches: Patches) -> float:
    """Volumes up to this one are exact sums, in `carve_units` as well as here."""
    return 0.5 * doubtful_volume(box_of(patches))


def closed(found: dict[str, tuple[int, int]], sizes: dict[str, Size]) -> Check:
    """Shells have no open edges and face outward, so their volume is positive."""
    leaking = [name for name, (edges, _) in found.items() if edges]
    turned = [name for name in found if sizes[name].volume <= 0.0]
    euler = euler_in_words({name: euler for name, (_, euler) in found.items()})
    detail = f"{len(found)} units, 0 open edges; {euler}"
    if leaking:
        edges = sum(edges for edges, _ in found.values())
        detail = f"{edges} open edges in {', '.join(leaking[:8])}"
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


def shared_in_words(n: int | np.integer) -> str:
    """How many vertices units share with surfaces."""
    return f"{n} vertices of units are vertices of the surfaces, bit for bit"


def crosses_not(n: int) -> Check:
    """The check that n triangles pass."""
    detail = f"{n} triangles meet only in shared corners and edges (exact test)"
    return Check(CROSSES, True, 0.0, detail)


def is_graph(patches: Patches) -> np.ndarray:
    """Whether copies of the triangles of each surface lie side by side on the map, bool (n,)."""
    found = np.zeros(len(patches.sources), dtype=bool)
    for i, source in enumerate(patches.sources):
        if source.lattice is not None:
            size = max(np.abs(source.lattice.extent).max(), np.abs(patches.origin).max())

            # local coordinates are rounded: a triangle that is higher than that does not turn over
            found[i] = source.lattice.map_height > 16 * EPS * size
    return found


def limits_of(x: np.ndarray) -> np.ndarray:
    """Lower and upper corner of points (2, 3): axis by axis, since numpy is slow along short rows.

    Examples
    --------
    >>> limits_of(np.array([[0.0, 5, 2], [3, 4, 1]])).tolist()
    [[0.0, 4.0, 1.0], [3.0, 5.0, 2.0]]
    """
    found: np.ndarray = np.array([[of.min(), of.max()] for of in x.T]).T
    return found


def graphs_of(patches: Patches, new: np.ndarray) -> np.ndarray:
    """Number of the graph over the map that each triangle is a part of, (n,); -1 for none.

    Copies of the triangles of a grid whose cells do not fold over lie side by side there.
    `new` are rows of triangles that are not copies.
    """
    surface = patches.surface_of_triangle
    graph = np.where(is_graph(patches)[surface], surface, -1)
    graph[new] = -1
    return graph


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
    span = 0.0
    if len(local):
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
    found: np.ndarray = inverted_triangles(x, t, of, np.arange(len(t)), m, w)
    return found


def areas_agree(patches: Patches, found: list[tuple[float, float, float]], largest: float) -> Check:
    """Compare areas, given that of each surface, that of its input, and the sum of all sides."""
    worst, passed, step = 0.0, True, EPS * largest
    for i, (area, before, rim) in enumerate(found):
        before -= patches.report.get("dropped_area", {}).get(i, 0.0)  # beyond faults
        difference = abs(area - before)
        passed &= difference <= 1e-12 * before + 4 * step * rim
        worst = max(worst, difference / before if before else 0.0)
    detail = f"largest relative difference {worst:.1e}"
    return Check("areas add up", bool(passed), worst, detail)
