"""Certify a model: recompute each property from the result, with exact tests where signs matter."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np

from geosurf.arrangement.threads import gigabytes, lack_of_room, map_threads, spare_threads
from geosurf.arrangement.tree import (
    Tree,
    apart,
    candidate_pairs,
    of_one_map,
    pairs_of_one_map,
    tree_of_list,
)
from geosurf.arrangement.triangles import crossing_pairs
from geosurf.carve.certificate_elements import matched, numbered
from geosurf.carve.certificate_facts import Facts, sides_of
from geosurf.carve.certificate_lines import (
    CROSSES,
    EPS,
    MANY,
    SHARED,
    Half,
    Part,
    Size,
    areas_agree,
    beside_parents,
    crosses_not,
    graphs_of,
    is_graph,
    limits_of,
    lines_of,
    lines_of_units,
    shared_in_words,
    surely_exact,
)
from geosurf.carve.measures import exact_volume
from geosurf.conventions import place
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import first_rows
from geosurf.kernels.meshes.shells import copies_of_parents, count_open_edges, sums_of_triangles
from geosurf.model import Certificate, Check, Lattice, Patches, TriSurface, Units
from geosurf.model.pieces import Pieces, Strips

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.arrangement.threads import Threads


# ---- by runs ----------------------------------------
# The checks of a certificate without a list of all triangles: see `facts`.


Stored = tuple[np.ndarray, np.ndarray]


def same_runs(one: Patches, two: Patches) -> bool:
    """Whether all that the arrays of both are made of has the same bytes, runs for triangles."""
    first, second = (patches.__dict__.get("pieces") for patches in (one, two))
    if first is None or second is None:
        return False

    def arrays(patches: Patches, pieces: Pieces) -> Iterator[np.ndarray]:
        yield from (patches.curve_edges, pieces.origin, pieces.first_run)
        yield from (getattr(pieces, of) for of in ("x", "triangles", "surface", "key", "patch"))
        for strips in pieces.strips:
            if strips is not None:
                of = ("places", "absent", "runs", "start", "nodes", "points")
                yield from (getattr(strips, name) for name in of)

    same = [s is None for s in first.strips] == [s is None for s in second.strips]
    same = same and len(one.sources) == len(two.sources)
    both = zip(one.sources, two.sources, first.strips, strict=True) if same else ()
    same = same and all(_same_nodes(p, q, strips) for p, q, strips in both)
    pairs = zip(arrays(one, first), arrays(two, second), strict=True) if same else ()
    return bool(same) and all(np.array_equal(p, q) and p.tobytes() == q.tobytes() for p, q in pairs)


def _same_nodes(p: TriSurface, q: TriSurface, strips: Strips | None) -> bool:
    """Whether two sources are one; or equal grids, such as those whose nodes a repair has moved."""
    a, b = p.lattice, q.lattice
    if p is q or a is b:
        return True
    if a is None and b is None:  # without runs, all its points and triangles are in the pieces
        return strips is None
    if a is None or b is None or (a.rising, a.turned) != (b.rising, b.turned):
        return False
    both = zip(a.coordinates, b.coordinates, strict=True)
    return bool((a.places == b.places).all()) and all(x.tobytes() == y.tobytes() for x, y in both)


def checks_by_runs(
    patches: Patches, units: Units | None = None, spare: Threads | None = None
) -> list[Check] | None:
    """The checks of a certificate, without a list of all triangles; None where one is needed.

    The names and details are those of checks by triangles, if they pass. Threads of `spare` take a
    part of them, when they are free.
    """
    sides = None if units is None else sides_of(patches, units)
    before = None
    if units is not None and units.unmerged is not None:
        before = sides_of(patches, units.unmerged)
        if before is None:
            return None
    if units is not None and sides is None:
        return None
    facts = Facts.of(patches)
    if facts is None:
        return None
    halves: list[Half] = [partial(_mesh_by_runs, facts)]
    if units is not None and sides is not None:
        halves.insert(0, partial(_units_by_runs, facts, units, sides, before))
    return lines_of(halves, spare)


def _units_by_runs(
    facts: Facts, units: Units, stored: Stored, before: Stored | None
) -> list[Check] | None:
    """The checks of units; `stored` as from `sides_of`, `before` those of the units unmerged."""
    patches, elements = facts.patches, facts.elements
    sides, surfaces = stored
    n = len(units)
    counts, n_vertex, alone = facts.counts(sides, n)
    if not alone:
        return None
    sums, small, anew = facts.sizes(sides, n), surely_exact(patches), {}
    for k, name in enumerate(units):
        volume = (sums[k, 0] + sums[k, 1]) / 6.0
        if volume <= small:
            x = facts.corners_of_unit(sides, k).reshape(-1, 3)
            volume = exact_volume(x, np.arange(len(x)).reshape(-1, 3))
        anew[name] = Size(volume, 0.5 * (sums[k, 2] + sums[k, 3]), 16 * EPS * sums[k, 4])
    euler = counts[:, 0] - counts[:, 1] + sums[:, 5].astype(np.int64)
    edges = dict(zip(units, zip(counts[:, 2].tolist(), euler.tolist(), strict=True), strict=True))
    found = facts.matched(sides, surfaces)
    shared = Check(SHARED, True, 0.0, shared_in_words(n_vertex))
    parts = None if before is None else facts.matched(*before)
    return lines_of_units(patches, elements, units, edges, anew, shared, found, parts)


def _mesh_by_runs(facts: Facts) -> list[Check] | None:
    """The checks of the mesh: triangles in runs are copies of those of their lattice."""
    patches, elements = facts.patches, facts.elements
    pieces = patches.pieces
    x = elements.local
    rows = []

    def parts() -> Iterator[Part]:
        """New triangles and the corners of their input triangles, and note which they are."""
        for new, parents in facts.new_triangles():
            rows.append(new)
            yield pieces.triangles[new], parents

    near_parents, faces_as_parents = beside_parents(pieces.x, parts(), patches.origin)

    # new triangles stay near their input triangle, so runs that share no corner with it are apart:
    # a corner is at most 2 L / h times as far from it as from its sides (length L, height h)
    low, high = limits_of(x)
    span = 4.0 * float((high - low).sum())
    if near_parents.value * span >= facts.heights**2:
        return None

    # all that is listed, and of runs what is near other surfaces
    more, surface = candidates(facts)
    t, of_listed = elements.triangles, elements.surface_of_triangle[elements.element]
    if len(more):
        own = np.arange(len(x), len(x) + 3 * len(more)).reshape(-1, 3)
        x, t = np.concatenate([x, more.reshape(-1, 3)]), np.concatenate([t, own])
    surface = np.concatenate([of_listed, surface]) if len(more) else of_listed
    flat = is_graph(patches)
    for one in facts.lattices:
        flat[one.surface] = one.graph  # of a torn one all but the copies
    graph = np.where(flat[surface], surface, -1)
    graph[np.concatenate([*rows, *map(facts.copies_of, facts.lattices)])] = -1
    n_bad = len(crossing_pairs(x, t, graph=graph))
    crosses = crosses_not(int(elements.n_triangle.sum()))
    if n_bad:
        crosses = Check(CROSSES, False, float(n_bad), f"{n_bad} pairs of triangles cross")
    return [
        crosses,
        near_parents,
        faces_as_parents,
        areas_agree(patches, facts.areas(), float(np.abs(elements.local).max(initial=0.0))),
    ]


# ---- triangles in runs that are near other surfaces: a certificate compares them one by one, too -


def candidates(facts: Facts) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 3, 3) and surfaces of the triangles in runs that are not listed, and whose
    boxes meet those of triangles of other surfaces, or of copies at tears of their own.
    """
    lattices, origin = facts.lattices, facts.patches.origin
    of = [facts.patches.sources[one.surface] for one in lattices]

    # triangles in runs that are not listed count; others are compared one by one anyway
    free = [one.unlisted() for one in lattices]
    trees = [_tree_of(one.lattice, origin) for one in lattices]
    hit = [np.zeros(len(some), dtype=bool) for some in free]

    def between(i: int, j: int) -> None:
        """Mark the triangles of two lattices that are near each other."""
        if of_one_map(of[i], of[j]):
            both = lattices[i].lattice, lattices[j].lattice
            p, q = pairs_of_one_map(both, (trees[i], trees[j]))[0].T
        else:
            p, q = candidate_pairs(trees[i], trees[j])[0].T
        near = free[i][p] & free[j][q]
        hit[i][p[near]] = hit[j][q[near]] = True

    def beside(i: int, other: Tree) -> None:
        """Mark the triangles of a lattice that are near listed ones."""
        hit[i][candidate_pairs(trees[i], other)[0][:, 0]] = True

    here = range(len(trees))
    of_lattices = [one.surface for one in lattices]
    map_threads(between, _near(trees, of_lattices, itertools.combinations(here, 2)))

    # triangles that are listed, surface by surface: trees of all would take twice their memory
    listed, of_listed = facts.elements, facts.elements.surface_of_triangle[facts.elements.element]
    order = np.argsort(of_listed, kind="stable")
    cut = np.searchsorted(of_listed[order], np.arange(len(facts.patches.sources) + 1))
    surfaces = np.flatnonzero(np.diff(cut)).tolist()

    def around(surface: int) -> None:
        """Mark the triangles of lattices that are near the listed triangles of a surface."""
        some = listed.triangles.take(order[cut[surface] : cut[surface + 1]], axis=0)
        tree = tree_of_list(listed.local, some)
        pairs = [(i, len(trees)) for i in here]
        for i, _ in _near([*trees, tree], [*of_lattices, surface], pairs):
            beside(i, tree)

    def around_copies(i: int, copies: np.ndarray) -> None:
        """Mark the triangles of a torn lattice that are near its own copies: over or below them."""
        beside(i, tree_of_list(listed.local, listed.triangles[copies]))

    map_threads(around, [(surface,) for surface in surfaces])
    copies = [(i, facts.copies_of(lattices[i])) for i in here]
    map_threads(around_copies, [(i, rows) for i, rows in copies if len(rows)])
    corners, of_corners = [np.empty((0, 3, 3))], [np.empty(0, dtype=np.int64)]
    for one, of_free, found in zip(lattices, free, hit, strict=True):
        some = np.flatnonzero(found & of_free)
        corners.append(one.corners(some, origin))
        of_corners.append(np.full(len(some), one.surface))
    return np.concatenate(corners), np.concatenate(of_corners)


def _near(
    trees: Sequence[Tree], surface: list[int], pairs: Iterable[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Those of some pairs of trees that are of different surfaces, and whose boxes meet."""
    far = apart(list(trees))
    return [(i, j) for i, j in pairs if surface[i] != surface[j] and not far[i, j]]


def _tree_of(lattice: Lattice, origin: np.ndarray) -> Tree:
    """The boxes of a lattice in the local frame: rounding keeps the order of numbers."""
    x, y, z = (part - origin[k] for k, part in enumerate(lattice.coordinates))
    survey = lattice.survey
    nodes = survey.nodes - np.concatenate([origin, origin])
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    return Tree((x, y, z), lattice.places, *none, nodes, survey.levels)


# ---- by triangles ----------------------------------------
# The checks of a certificate from all triangles, with what is wrong and where.


def checks_by_triangles(
    patches: Patches, units: Units | None = None, spare: Threads | None = None
) -> list[Check]:
    """Check all triangles of shells and of the mesh; threads of `spare` take a part of it."""
    # both halves use these arrays: they are listed once, before threads start
    _ = patches.local, patches.triangles, patches.surface_of_triangle, patches.parent_of_triangle
    halves: list[Half] = [partial(_checks_of_mesh, patches)]
    if units is not None:
        halves.insert(0, partial(_checks_of_units, patches, units))
    return lines_of(halves, spare) or []


def _checks_of_units(patches: Patches, units: Units) -> list[Check]:
    """Checks that read shells, not the cells that carving used."""
    x, number = numbered(patches, units)
    found = matched(patches, units, number)
    anew = _sizes(patches, units)
    edges = {name: open_edges(unit.triangles) for name, unit in units.items()}
    shared = _shared_vertices(patches, units, x, number)

    parts = None
    if units.unmerged is not None:
        parts = matched(patches, units.unmerged, numbered(patches, units.unmerged)[1])
    return lines_of_units(patches, patches, units, edges, anew, shared, found, parts)


def _checks_of_mesh(patches: Patches) -> list[Check]:
    """Checks of the rebuilt mesh; copies of input triangles are set apart once for three."""
    new = _new_triangles(patches)
    return [
        _nothing_crosses(patches, new[0]),
        *beside_parents(patches.local, [(patches.triangles[new[0]], new[1])], patches.origin),
        _areas(patches),
    ]


def open_edges(triangles: np.ndarray) -> tuple[int, int]:
    """Count open edges (more triangles on one side than on the other), and the Euler number."""
    # vertices - edges + triangles: 2 for a ball, 2 - 2 k for a body with k handles
    n_open, n_edge, n_vertex = count_open_edges(triangles, int(triangles.max(initial=0)) + 1)
    return n_open, n_vertex - n_edge + len(triangles)


def _sizes(patches: Patches, units: Units) -> dict[str, Size]:
    """Sizes of shells; volumes that are small compared with the box are exact."""
    small, found = surely_exact(patches), {}
    for name, unit in units.items():
        volume, area, products, _ = sums_of_triangles(unit.local, unit.triangles)

        # sums of pyramids are good to a part of the whole box; volumes near that error are exact
        if volume <= small:
            volume = exact_volume(unit.local, unit.triangles)
        found[name] = Size(volume, area, 16 * EPS * products)
    return found


def _shared_vertices(patches: Patches, units: Units, x: np.ndarray, number: np.ndarray) -> Check:
    """Each corner of a shell is a vertex of the patches, bit for bit."""
    parts = [unit.local for unit in units.values()]
    n_local = len(patches.local)

    # lowest row of each number: that of a vertex of the patches, if one is there
    first = first_rows(number, int(number.max(initial=-1)) + 1)

    # compared as integers: 0.0 and -0.0 are equal numbers, but not the same bytes
    same = x.view(np.int64)[n_local:] == x.view(np.int64)[first[number[n_local:]]]
    known = (first[number[n_local:]] < n_local) & same.all(axis=1)
    ends = np.cumsum([0] + [len(part) for part in parts])
    of = zip(units, itertools.pairwise(ends.tolist()), strict=True)
    foreign = [name for name, (start, stop) in of if not known[start:stop].all()]
    n = np.count_nonzero(np.bincount(number[n_local:]))
    detail = shared_in_words(n)
    if foreign:
        detail = f"corners of {', '.join(foreign[:8])} are not vertices of the surfaces"
    return Check(SHARED, not foreign, float(len(foreign)), detail)


def _nothing_crosses(patches: Patches, new: np.ndarray) -> Check:
    """Triangles meet only in shared corners and edges: an exact test of all pairs.

    Two triangles of one grid need no test if none of its cells folds over on the map: all its
    triangles lie side by side there.
    """
    triangles = patches.triangles

    # the test of other pairs takes a third of the time of a test of all
    bad = crossing_pairs(patches.local, triangles, graph=graphs_of(patches, new))
    if len(bad) == 0:
        return crosses_not(len(triangles))
    one, two = (patches.names[patches.surface_of_triangle[i]] for i in bad[0])
    where = place(patches.vertices[triangles[bad[0, 0], 0]])
    detail = f"{len(bad)} pairs of triangles cross, the first of {one!r} and {two!r} at {where}"
    if one == two:
        detail += "; the surface crosses itself: rebuild with self_intersections=True"
    return Check(CROSSES, False, float(len(bad)), detail)


def _new_triangles(patches: Patches) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the triangles that are not copies of their input triangle, and its corners (n, 3, 3).

    Copies need no check: they have the same bits.
    """
    rows, corners = [np.empty(0, dtype=np.int64)], [np.empty((0, 3, 3))]
    for i, source in enumerate(patches.sources):
        mine = np.flatnonzero(patches.surface_of_triangle == i)
        parent = patches.parent_of_triangle[mine]

        # copies have the corners of their parent, perhaps from another corner on
        of = source.vertices[source.triangles[parent]] - patches.origin
        copied = copies_of_parents(patches.local, patches.triangles[mine], of.reshape(-1, 9))
        rows.append(mine[~copied])
        corners.append(of[~copied])
    return np.concatenate(rows), np.concatenate(corners)


def _areas(patches: Patches) -> Check:
    """The parts of each surface have its area, within the rounding error of their corners."""
    found = []
    for i, source in enumerate(patches.sources):
        mine = patches.surface_of_triangle == i
        _, area, _, rim = sums_of_triangles(patches.local, patches.triangles[mine])
        before = sums_of_triangles(source.vertices - patches.origin, source.triangles)[1]
        found.append((area, before, rim))
    return areas_agree(patches, found, float(np.abs(patches.local).max(initial=0.0)))


ROOM_OF_RUN = 1000  # bytes of a second run and of checks, per triangle that curves touch
ROOM = 610  # bytes per triangle: 13.9 GB for 21 million (docs/validation/results.md)
SAME = "two runs give the same bytes"
_EQUAL = "{} arrays equal, byte by byte"
WAYS = ("runs", "triangles")


def certify(
    patches: Patches, units: Units | None = None, *, by: Literal["runs", "triangles"] = "runs"
) -> Certificate:
    """
    Check the properties of a rebuilt mesh and of the units carved from it.

    Parameters
    ----------
    patches : Patches
    units : Units, optional
        Default: only the mesh is checked.
    by : {"runs", "triangles"}
        Triangles of grids that no curve touches are checked row by row, or one by one as they are
        written to files. All of them are checked one by one where the rows do not show that a
        property holds.

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
        If `by` is unknown. If a check of all triangles needs more memory than is free: about 0.6 GB
        per million triangles.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> certify(rebuild_surfaces([flat, wall])).ok
    True
    """
    if by not in WAYS:
        raise InputError(f"by is {by!r}; expected one of {WAYS}.")
    with spare_threads(patches.n_triangle > MANY) as spare:
        return Certificate(tuple(_checks(patches, units, by, spare)))


def _checks(
    patches: Patches, units: Units | None, by: str = "runs", spare: Threads | None = None
) -> list[Check]:
    """The checks of `certify`; threads of `spare` take a part of them."""
    if by == "runs":
        checks = checks_by_runs(patches, units, spare)

        # what is wrong where is a matter of single triangles, if they fit in memory
        if checks is not None and all(check.passed for check in checks):
            return checks
    _refuse_if_too_large(patches.n_triangle)
    return checks_by_triangles(patches, units, spare)


def certify_repeated(patches: Patches, units: Units, rebuild: Callable[[], Patches]) -> Certificate:
    """
    Check a model, and that a second run of its rebuild gives the same bytes.

    Parameters
    ----------
    patches : Patches
    units : Units
    rebuild : callable
        Splits the surfaces of the patches again, from nothing. In large models it shares the cores
        with the checks, where the memory that is free holds both.

    Returns
    -------
    Certificate
        The lines of `certify`, then that of the second run.

    Raises
    ------
    InputError
        As `certify`.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes()
    >>> one, two = (gs.Scene(world.horizons, world.faults, world.box) for _ in range(2))
    >>> certify_repeated(one.patches, one.units, lambda: two.patches).ok
    True
    """
    pieces = patches.__dict__.get("pieces")
    n_listed = patches.n_triangle if pieces is None else len(pieces.triangles)
    with spare_threads(patches.n_triangle > MANY) as spare:
        # side by side only where the memory holds both; else the second run is after the checks
        if spare is None or lack_of_room(n_listed * ROOM_OF_RUN) is not None:
            checks = _checks(patches, units, spare=spare)
            return Certificate((*checks, same_bytes(patches, rebuild())))
        repeated = spare.submit(lambda: same_bytes(patches, rebuild()))
        checks = _checks(patches, units, spare=spare)
        return Certificate((*checks, repeated.result()))


def _refuse_if_too_large(n_triangle: int) -> None:
    """Raise an error with numbers, before the system has to end the process."""
    needed = n_triangle * ROOM
    free = lack_of_room(needed)
    if free is not None:
        raise InputError(
            f"a certificate of {n_triangle / 1e6:.3g} million triangles needs {gigabytes(needed)} "
            f"of memory, and {gigabytes(free)} are free. Check a smaller part of the model "
            "(aoi=...), simplify horizons (triangulate_horizon(..., tolerance=...)), or use a "
            "larger machine."
        )


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
    if same_runs(one, two):
        return Check(SAME, True, 0.0, _EQUAL.format(len(names)))
    differ = [n for n in names if getattr(one, n).tobytes() != getattr(two, n).tobytes()]
    detail = f"{', '.join(differ)} differ" if differ else _EQUAL.format(len(names))
    return Check(SAME, not differ, float(len(differ)), detail)
