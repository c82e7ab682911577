"""Certify a model: recompute each property from the result, with exact tests where signs matter."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from geosurf.arrangement.crossing import crossing_pairs
from geosurf.arrangement.memory_limit import gigabytes, lack_of_room
from geosurf.arrangement.threads import map_threads
from geosurf.carve.check_merged import merged
from geosurf.carve.check_names import named
from geosurf.carve.check_partition import matched, numbered, partition
from geosurf.carve.outside import box_of
from geosurf.carve.volume import doubtful_volume, exact_volume
from geosurf.conventions import place
from geosurf.errors import InputError
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.mesh import inverted_triangles
from geosurf.kernels.meshes.shells import are_copies, count_open_edges, sums_of_triangles
from geosurf.model import Certificate, Check, Patches, Units

VOLUME_TOLERANCE = 1e-12
EPS = 2.0**-53
ROOM = 610  # bytes per triangle: 13.9 GB for 21 million (docs/validation/results.md)
MANY = 100_000  # triangles, from which units and mesh are checked in two threads


def certify(patches: Patches, units: Units | None = None) -> Certificate:
    """
    Check the properties of a rebuilt mesh and of the units carved from it.

    Parameters
    ----------
    patches : Patches
    units : Units, optional
        Default: only the mesh is checked.

    Returns
    -------
    Certificate
        One check per property. Units are closed and oriented. Volumes add up to the box. Units
        and surfaces share their vertices. Each triangle inside the box has one unit on each side.
        The zone, block and contact of each unit match its bounding surfaces. Merged slivers are
        parts of their neighbours, and their volumes are in them. Surfaces meet only in shared edges
        and vertices (exact, on the rounded mesh). Each triangle lies on its input triangle and
        keeps its orientation (exact). Areas add up.

    Raises
    ------
    InputError
        If it needs more memory than is free: about 0.6 GB per million triangles.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> certify(rebuild_surfaces([flat, wall])).ok
    True
    """
    _refuse_if_too_large(patches.n_triangle)

    # both halves use these arrays: they are listed once, before threads start
    _ = patches.local, patches.triangles, patches.surface_of_triangle, patches.parent_of_triangle
    halves: list[tuple[Callable[[], list[Check]]]] = [(partial(_checks_of_mesh, patches),)]
    if units is not None:
        halves.insert(0, (partial(_checks_of_units, patches, units),))
    worth = patches.n_triangle > MANY
    found = map_threads(lambda half: half(), halves, worth=worth)
    return Certificate(tuple(itertools.chain.from_iterable(found)))


def _refuse_if_too_large(n_triangle: int) -> None:
    """Raise an error with numbers, before the system has to end the process."""
    needed = n_triangle * ROOM
    free = lack_of_room(needed)
    if free is not None:
        raise InputError(
            f"a certificate of {n_triangle / 1e6:.3g} million triangles needs {gigabytes(needed)} "
            f"of memory, and {gigabytes(free)} are free. Check a smaller part of the model "
            "(aoi=...), simplify the horizons (tolerance=...), or use a larger machine."
        )


def _checks_of_units(patches: Patches, units: Units) -> list[Check]:
    """Checks that read shells, not the cells that carving used."""
    x, number = numbered(patches, units)
    found = matched(patches, units, number)
    anew = _sizes(patches, units)
    divided = partition(patches, units, found)
    checks = [
        _closed(units, anew),
        _adds_up(patches, units, anew),
        _shared_vertices(patches, units, x, number),
        divided,
        named(patches, units, found, divided.passed),
    ]
    if units.unmerged is not None:
        before = numbered(patches, units.unmerged)[1]
        parts = matched(patches, units.unmerged, before)
        checks.append(merged(patches, units, found, parts))
        full = partition(patches, units.unmerged, parts)
        checks.append(named(patches, units.unmerged, parts, full.passed))
        checks[-1] = replace(checks[-1], name="names before slivers were merged match")
    return checks


def _checks_of_mesh(patches: Patches) -> list[Check]:
    """Checks of the rebuilt mesh; copies of input triangles are set apart once for three."""
    new = _new_triangles(patches)
    return [
        _nothing_crosses(patches, new[0]),
        _on_parents(patches, *new),
        _oriented(patches, *new),
        _areas(patches),
    ]


def open_edges(triangles: np.ndarray) -> tuple[int, int]:
    """Count open edges (more triangles on one side than on the other), and the Euler number."""
    # vertices - edges + triangles: 2 for a ball, 2 - 2 k for a body with k handles
    n_open, n_edge, n_vertex = count_open_edges(triangles, int(triangles.max(initial=0)) + 1)
    return n_open, n_vertex - n_edge + len(triangles)


@dataclass(frozen=True)
class _Size:
    """Volume [m3] and area [m2] of a shell, and by how much rounding may have changed the area."""

    volume: float
    area: float
    slack: float


def _sizes(patches: Patches, units: Units) -> dict[str, _Size]:
    """Sizes of shells; volumes that are small compared with the box are exact."""
    small, found = _surely_exact(patches), {}
    for name, unit in units.items():
        volume, area, products, _ = sums_of_triangles(unit.local, unit.triangles)

        # sums of pyramids are good to a part of the whole box; volumes near that error are exact
        if volume <= small:
            volume = exact_volume(unit.local, unit.triangles)
        found[name] = _Size(volume, area, 16 * EPS * products)
    return found


def _surely_exact(patches: Patches) -> float:
    """Volumes up to this one are exact sums, in `carve_units` as well as here."""
    return 0.5 * doubtful_volume(box_of(patches))


def _closed(units: Units, sizes: dict[str, _Size]) -> Check:
    """Shells have no open edges and face outward, so their volume is positive."""
    found = {name: open_edges(unit.triangles) for name, unit in units.items()}
    leaking = [name for name, (edges, _) in found.items() if edges]
    turned = [name for name in found if sizes[name].volume <= 0.0]
    euler = _euler_in_words({name: euler for name, (_, euler) in found.items()})
    detail = f"{len(found)} units, 0 open edges; {euler}"
    if leaking:
        edges = sum(edges for edges, _ in found.values())
        detail = f"{edges} open edges in {', '.join(leaking[:8])}"
    elif turned:
        detail = f"turned inside out: {', '.join(turned[:8])}"
    n_bad = len({*leaking, *turned})
    return Check("units are closed and oriented", n_bad == 0, float(n_bad), detail)


def _euler_in_words(euler: dict[str, int]) -> str:
    """The Euler number of most units (2 for a ball), and the units with another number."""
    # one number for most units, the others by name: a list of hundreds is not read
    numbers = list(euler.values())
    usual = max(sorted(set(numbers), reverse=True), key=numbers.count, default=2)
    others = [f"{name} {number}" for name, number in euler.items() if number != usual]
    more = f" and {len(others) - 8} more" if len(others) > 8 else ""
    return f"Euler number {usual}" + (f", but {', '.join(others[:8])}{more}" if others else "")


def _adds_up(patches: Patches, units: Units, anew: dict[str, _Size]) -> Check:
    """Compare volumes recomputed from the shells with the stated volumes and with the box.

    A stated volume may differ by the rounding error of prisms as high as the model, unless it is so
    small that it was summed exactly.
    """
    lower, upper = box_of(patches)
    total, box = math.fsum(size.volume for size in anew.values()), units.box_volume
    error = (total - box) / box

    # slack: rounding of an area, from the sizes of its triangles; times the height it is that of
    # prisms
    off, small, height = [], _surely_exact(patches), float(upper[2] - lower[2])
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
        f"relative difference {error:.1e}"
    )
    if off:
        detail += f"; the stated volume or area of {', '.join(off[:8])} differs from its shell"
    if moved:
        detail += "; the stated box differs from the walls"
    return Check("volumes add up to the box", passed, float(error), detail)


def _shared_vertices(patches: Patches, units: Units, x: np.ndarray, number: np.ndarray) -> Check:
    """Each corner of a shell is a vertex of the patches, bit for bit."""
    parts = [unit.local for unit in units.values()]
    n_local = len(patches.local)

    # lowest row of each number: that of a vertex of the patches, if one is there
    first = np.empty(int(number.max(initial=-1)) + 1, dtype=np.int64)
    first[number[::-1]] = np.arange(len(x))[::-1]

    # compared as integers: 0.0 and -0.0 are equal numbers, but not the same bytes
    same = x.view(np.int64)[n_local:] == x.view(np.int64)[first[number[n_local:]]]
    known = (first[number[n_local:]] < n_local) & same.all(axis=1)
    ends = np.cumsum([0] + [len(part) for part in parts])
    of = zip(units, itertools.pairwise(ends.tolist()), strict=True)
    foreign = [name for name, (start, stop) in of if not known[start:stop].all()]
    n = np.count_nonzero(np.bincount(number[n_local:]))
    detail = f"{n} vertices of units are vertices of the surfaces, bit for bit"
    if foreign:
        detail = f"corners of {', '.join(foreign[:8])} are not vertices of the surfaces"
    return Check("units share the surfaces' vertices", not foreign, float(len(foreign)), detail)


def _nothing_crosses(patches: Patches, new: np.ndarray) -> Check:
    """Triangles meet only in shared corners and edges: an exact test of all pairs.

    Two triangles of one grid need no test if none of its cells folds over on the map: all its
    triangles lie side by side there.
    """
    triangles = patches.triangles

    # the test of other pairs takes a third of the time of a test of all
    surface = patches.surface_of_triangle
    graph = np.where(_is_graph(patches)[surface], surface, -1)
    graph[new] = -1
    bad = crossing_pairs(patches.local, triangles, graph=graph)
    name = "surfaces meet only along shared edges"
    if len(bad) == 0:
        detail = f"{len(triangles)} triangles meet only in shared corners and edges (exact test)"
        return Check(name, True, 0.0, detail)
    one, two = (patches.names[patches.surface_of_triangle[i]] for i in bad[0])
    where = place(patches.vertices[triangles[bad[0, 0], 0]])
    detail = f"{len(bad)} pairs of triangles cross, the first of {one!r} and {two!r} at {where}"
    if one == two:
        detail += "; the surface crosses itself: rebuild with self_intersections=True"
    return Check(name, False, float(len(bad)), detail)


def _is_graph(patches: Patches) -> np.ndarray:
    """Whether copies of the triangles of each surface lie side by side on the map, bool (n,)."""
    found = np.zeros(len(patches.sources), dtype=bool)
    for i, source in enumerate(patches.sources):
        if source.lattice is not None:
            size = max(np.abs(source.lattice.extent).max(), np.abs(patches.origin).max())

            # local coordinates are rounded: a triangle that is higher than that does not turn over
            found[i] = source.lattice.map_height > 16 * EPS * size
    return found


def _new_triangles(patches: Patches) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the triangles that are not copies of their input triangle, and its corners (n, 3, 3).

    Copies need no check: they have the same bits.
    """
    rows, corners = [np.empty(0, dtype=np.int64)], [np.empty((0, 3, 3))]
    for i, source in enumerate(patches.sources):
        mine = np.flatnonzero(patches.surface_of_triangle == i)
        parent = patches.parent_of_triangle[mine]

        # copies have the corners of their parent, perhaps from another corner on
        copied = are_copies(
            patches.local, patches.triangles[mine], source.vertices, source.triangles, parent,
            patches.origin,
        )  # fmt: skip
        rows.append(mine[~copied])
        corners.append(source.vertices[source.triangles[parent[~copied]]] - patches.origin)
    return np.concatenate(rows), np.concatenate(corners)


def _on_parents(patches: Patches, rows: np.ndarray, parent: np.ndarray) -> Check:
    """Distance of each corner from the plane of its input triangle, and beyond the sides of it."""
    size = np.ptp(parent, axis=1).max(axis=1)  # of each parent: products of tiny sides underflow
    a, b, c = (parent[:, k] / size[:, None] for k in range(3))
    normal = np.cross(b - a, c - a)
    width = np.maximum(np.linalg.norm(normal, axis=1), EPS**2)  # by its size; small for slivers
    unit = normal / width[:, None]
    off = np.zeros(len(parent))

    # distance from the parent's plane, and how far each corner is beyond its three edges
    for k in range(3):
        point = patches.local[patches.triangles[rows, k]] / size[:, None]
        off = np.maximum(off, np.abs(np.einsum("ij,ij->i", point - a, unit)))
        for p, q in ((a, b), (b, c), (c, a)):
            inward = np.cross(unit, q - p)
            inward /= np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), EPS**2)
            off = np.maximum(off, -np.einsum("ij,ij->i", point - p, inward))
    off *= size
    span = float(
        np.ptp(patches.local, axis=0).max(initial=0) + np.abs(patches.local).max(initial=0)
    )

    # the rounding of a coordinate of this size, with room
    bound = 1e-12 * max(span, 1.0)
    # the plane of a sliver has a larger rounding error
    passed = bool((off <= bound + 16 * EPS * size / width).all())
    far = float(off.max(initial=0.0))
    detail = f"largest distance from the input triangle {far:.1e} m (bound {bound:.1e} m)"
    return Check("triangles lie on their input triangles", passed, far, detail)


def _oriented(patches: Patches, rows: np.ndarray, parent: np.ndarray) -> Check:
    """Triangles have the orientation of their input triangles: an exact test."""
    x = np.concatenate([patches.local, parent.reshape(-1, 3)])
    of = np.arange(len(patches.local), len(x)).reshape(-1, 3)
    m, w = frame_of(x)
    bad = inverted_triangles(x, patches.triangles[rows], of, np.arange(len(rows)), m, w)
    detail = f"orientation of {len(rows)} new triangles tested exactly; all others are copies"
    if len(bad):
        where = place(patches.vertices[patches.triangles[rows[bad[0]], 0]])
        detail = f"{len(bad)} triangles are turned over or flat, the first at {where}"
    return Check(
        "triangles keep the orientation of their input", len(bad) == 0, float(len(bad)), detail
    )


def _areas(patches: Patches) -> Check:
    """The parts of each surface have its area, within the rounding error of their corners."""
    worst, passed = 0.0, True
    step = EPS * float(np.abs(patches.local).max(initial=0.0))
    for i, source in enumerate(patches.sources):
        mine = patches.surface_of_triangle == i
        _, area, _, rim = sums_of_triangles(patches.local, patches.triangles[mine])
        before = sums_of_triangles(source.vertices - patches.origin, source.triangles)[1]
        before -= patches.report.get("dropped_area", {}).get(i, 0.0)  # beyond faults
        difference = abs(area - before)
        passed &= difference <= 1e-12 * before + 4 * step * rim
        worst = max(worst, difference / before if before else 0.0)
    detail = f"largest relative difference {worst:.1e}"
    return Check("areas add up", bool(passed), worst, detail)


def same_bytes(one: Patches, two: Patches) -> Check:
    """Check that two runs gave the same bytes.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> same_bytes(rebuild_surfaces([flat]), rebuild_surfaces([flat])).passed
    True
    """
    names = (
        "local", "triangles", "surface_of_triangle", "parent_of_triangle", "patch_of_triangle",
        "curve_edges",
    )  # fmt: skip
    differ = [n for n in names if getattr(one, n).tobytes() != getattr(two, n).tobytes()]
    detail = f"{', '.join(differ)} differ" if differ else f"{len(names)} arrays equal, byte by byte"
    return Check("two runs give the same bytes", not differ, float(len(differ)), detail)
