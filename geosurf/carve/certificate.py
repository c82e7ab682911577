"""Certify a model: recompute each property from the result, with exact tests where signs matter."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from geosurf.arrangement.threads import gigabytes, in_turn, lack_of_room, map_threads, spare_threads
from geosurf.arrangement.tree_pairs import apart, candidate_pairs, pairs_of_one_map
from geosurf.arrangement.trees import Tree
from geosurf.arrangement.triangles import Group, are_graphs, crossing_between, group_of
from geosurf.carve.certificate_facts import Facts
from geosurf.carve.certificate_lines import (
    Part,
    areas_agree,
    beside_parents,
    limits_of,
    lines_of_units,
    shared_vertices,
)
from geosurf.carve.certificate_shells import count_edges, matched_lists, sizes_of, weld_lists
from geosurf.carve.shells import Shells
from geosurf.conventions import place
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import distinct, first_rows
from geosurf.kernels.meshes.checks import N_SUM, sums_of_triangles
from geosurf.kernels.meshes.mesh import edges, number_keys
from geosurf.model import Certificate, Check, Lattice, Patches, Units

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.arrangement.threads import Threads


# ---- units ----------------------------------------
# The checks of units, from the elements that they lie beside, or from the triangles of shells.


Stored = tuple[np.ndarray, np.ndarray]


def sides_of(patches: Patches, units: Units) -> Stored | None:
    """Units in front of and behind each element (n, 2), -1 outside, and the surfaces that shells
    name there; None if units are not stored by elements of these patches.
    """
    stored = [one for one in (u.__dict__.get("_shell") for u in units.values()) if one is not None]
    if not stored or len(stored) < len(units):
        return None
    shells: Shells = stored[0][0]
    rows = [u for of, u in stored if of is shells]
    cells = shells.cells
    if len(set(rows)) < len(stored) or cells.pieces is not patches.__dict__.get("pieces"):
        return None

    # numbers of shells become those of units, in their order; the last is that of the outside
    number = np.full(len(shells.volumes) + 1, -1)
    number[rows] = np.arange(len(rows))
    faces = np.concatenate([number[shells.sides], [[-1, -1]]])
    named = np.append(cells.surface_of, -1)
    return faces[cells.face_of_element], named[cells.face_of_element]


def checks_of_stored(
    facts: Facts, units: Units, stored: Stored, before: Stored | None
) -> list[Check]:
    """The checks of units that are stored by elements, and of those before slivers were merged."""
    (sides, surfaces), n = stored, len(units)
    counts, n_vertex = count_edges(
        facts.triangles, facts.ring, sides[facts.element], len(facts.local), facts.n_shared, n
    )
    for lattice in facts.lattices:
        n_vertex += lattice.count(sides[lattice.runs], counts)

    # sums of what has the same units on both sides, then of runs
    core = sides[: len(facts.pieces.triangles)] + 1
    pairs, row = number_keys(core @ [n + 1, 1])
    sums = np.zeros((len(pairs), N_SUM))
    sums_of_triangles(facts.pieces.x, facts.pieces.triangles, row, facts.level, sums)
    sums = np.concatenate([sums, *(lattice.sums[:-1] for lattice in facts.lattices)])
    beside = np.stack(np.divmod(pairs, n + 1), axis=1) - 1
    beside = np.concatenate([beside, sides[len(core) :]])
    sizes = sizes_of(facts.patches, units, sums, beside, lambda k: facts.corners_of_unit(sides, k))

    matched = facts.matched(sides, surfaces)
    parts = None if before is None else facts.matched(*before)
    shared = shared_vertices(n_vertex, [])
    return lines_of_units(facts, units, counts, sizes, shared, matched, parts)


def checks_of_lists(facts: Facts, units: Units) -> list[Check]:
    """The checks of units as they list the triangles of their shells."""
    patches, parts = facts.patches, list(units.values())
    x, number = weld_lists(patches, units)
    first = np.cumsum([0, *(len(unit.local) for unit in parts)])
    t = np.concatenate([u.triangles + k for u, k in zip(parts, first.tolist(), strict=False)])
    unit_of = np.repeat(np.arange(len(parts)), [len(unit.triangles) for unit in parts])
    listed = x[len(facts.local) :]

    # a shell has its unit behind each triangle
    sides = np.stack([np.full(len(unit_of), -1), unit_of], axis=1)
    ring, _ = edges(t, len(listed))
    counts, _ = count_edges(t, ring, sides, len(listed), len(listed), len(parts))
    sums = np.zeros((len(parts), N_SUM))
    sums_of_triangles(listed, t, unit_of, facts.level, sums)
    beside = np.stack([np.full(len(parts), -1), np.arange(len(parts))], axis=1)
    sizes = sizes_of(patches, units, sums, beside, lambda k: parts[k].local[parts[k].triangles])

    # lowest row of each number: that of a vertex of the patches, if one is there
    lowest = first_rows(number, int(number.max(initial=-1)) + 1)[number[len(facts.local) :]]
    # compared as integers: 0.0 and -0.0 are equal numbers, but not the same bytes
    known = (listed.view(np.int64) == x.view(np.int64)[lowest]).all(axis=1)
    known &= lowest < len(facts.local)
    foreign = [name for name, rows in zip(units, np.split(known, first[1:-1]), strict=True)
               if not rows.all()]  # fmt: skip
    shared = shared_vertices(len(distinct(number[len(facts.local) :])), foreign)

    matched, before = matched_lists(patches, units, number), None
    if units.unmerged is not None:
        before = matched_lists(patches, units.unmerged, weld_lists(patches, units.unmerged)[1])
    return lines_of_units(facts, units, counts, sizes, shared, matched, before)


# ---- mesh ----------------------------------------
# The checks of the mesh: triangles in runs are copies of those of their lattice.


def checks_of_mesh(facts: Facts) -> list[Check]:
    """The checks of the mesh: what crosses, and what is not a part of its input."""

    def parts() -> Iterator[Part]:
        """New triangles and the corners of their input triangles."""
        for new, parents in facts.new_triangles():
            yield facts.triangles[new], parents

    near_parents, faces_as_parents = beside_parents(facts.local, parts(), facts.patches.origin)

    # new triangles stay near their input triangle, so runs that share no corner with it are apart:
    # a corner is at most 2 L / h times as far from it as from its sides (length L, height h)
    low, high = limits_of(facts.local)
    span = 4.0 * float((high - low).sum())
    far = near_parents.value * span >= facts.height**2
    return [
        _nothing_crosses(_in_single_triangles(facts.patches) if far else facts),
        near_parents,
        faces_as_parents,
        areas_agree(facts.patches, facts.areas(), float(np.abs(facts.local).max(initial=0.0))),
    ]


def _nothing_crosses(facts: Facts) -> Check:
    """Triangles meet only in shared corners and edges: an exact test of all that are listed, and
    of those in runs that are near other surfaces. Surfaces that are graphs do not meet themselves.
    """
    x, t, surface = facts.local, facts.triangles, facts.surface_of_triangle[facts.element]
    order = np.argsort(surface, kind="stable")
    cut = np.searchsorted(surface[order], np.arange(1, len(facts.sources)))
    groups = [group_of(x, t, rows) for rows in np.split(order, cut)]
    graphs = are_graphs(x, t, surface, facts.ring, groups)
    more, surface_of_more = candidates(facts, groups)

    # those in runs get corners of their own; copies at tears lie over or below them
    rows_of_more = len(t) + np.arange(len(surface_of_more))
    t = np.concatenate([t, len(x) + np.arange(3 * len(surface_of_more)).reshape(-1, 3)])
    x, surface = (
        np.concatenate([x, more.reshape(-1, 3)]),
        np.concatenate([surface, surface_of_more]),
    )
    in_runs = [
        (i, group_of(x, t, rows_of_more[surface_of_more == i]))
        for i in distinct(surface_of_more).tolist()
    ]
    tasks = [(group_of(x, t, facts.copies_of(i)), group) for i, group in in_runs]
    every = [*enumerate(groups), *in_runs]
    far = apart([group.tree for _, group in every])
    for p, (i, first) in enumerate(every):
        tasks += [
            (first, second) for q, (j, second) in enumerate(every[:p]) if i != j and not far[p, q]
        ]
    tasks += [(group, group) for group, graph in zip(groups, graphs, strict=True) if not graph]
    bad = crossing_between(x, t, tasks)
    n = facts.n_triangle.sum()
    detail = f"{n} triangles meet only in shared corners and edges (exact test)"
    if len(bad):
        first, second = (facts.names[surface[i]] for i in bad[0])
        where = place(x[t[bad[0, 0], 0]] + facts.patches.origin)
        detail = (
            f"{len(bad)} pairs of triangles cross, the first of {first!r} and {second!r} at {where}"
        )
        if first == second:
            detail += "; the surface crosses itself: rebuild with self_intersections=True"
    return Check("surfaces meet only along shared edges", not len(bad), float(len(bad)), detail)


def candidates(facts: Facts, groups: list[Group]) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 3, 3) and surfaces of the triangles in runs that are not listed, and whose
    boxes meet those of triangles of other surfaces, or of copies at tears of their own. `groups`
    has the triangles of each surface that are listed.
    """
    lattices, origin = facts.lattices, facts.patches.origin
    corners, surfaces = [np.empty((0, 3, 3))], [np.empty(0, dtype=np.int64)]
    if not lattices:
        return corners[0], surfaces[0]

    # triangles in runs that are not listed count; others are compared one by one anyway
    free = [runs.free for runs in lattices]
    trees = [_tree_of(runs.lattice, origin) for runs in lattices]
    private = [_without(tree, runs.shared) for tree, runs in zip(trees, lattices, strict=True)]
    hit = [np.zeros(len(keys), dtype=bool) for keys in free]

    def between(i: int, j: int) -> None:
        """Mark the triangles of two lattices that are near each other."""
        first, second = (facts.sources[lattices[k].surface].lattice for k in (i, j))
        if first is not None and second is not None and first.shares_map(second):
            both = lattices[i].lattice, lattices[j].lattice
            p, q = pairs_of_one_map(both, (trees[i], trees[j]))[0].T
        else:
            p, q = candidate_pairs(trees[i], trees[j])[0].T
        near = free[i][p] & free[j][q]
        hit[i][p[near]] = hit[j][q[near]] = True

    def around(i: int, tree: Tree) -> None:
        """Mark the triangles of a lattice that are near listed ones."""
        hit[i][candidate_pairs(private[i], tree)[0][:, 0]] = True

    n, listed = len(trees), [group.tree for group in groups]
    far = apart([*trees, *listed])
    map_threads(between, [(i, j) for i, j in itertools.combinations(range(n), 2) if not far[i, j]])
    tasks = [
        (i, listed[k])
        for i, k in itertools.product(range(n), range(len(listed)))
        if k != lattices[i].surface and not far[i, n + k]
    ]

    # copies at tears lie over or below triangles of their own lattice
    for i, runs in enumerate(lattices):
        copies = group_of(facts.local, facts.triangles, facts.copies_of(runs.surface))
        tasks.append((i, copies.tree))
    map_threads(around, tasks)
    for runs, of_free, near_others in zip(lattices, free, hit, strict=True):
        keys = np.flatnonzero(near_others & of_free)
        corners.append(runs.corners(keys, origin))
        surfaces.append(np.full(len(keys), runs.surface))
    return np.concatenate(corners), np.concatenate(surfaces)


def _tree_of(lattice: Lattice, origin: np.ndarray) -> Tree:
    """The boxes of a lattice in the local frame: rounding keeps the order of numbers."""
    x, y, z = (part - origin[k] for k, part in enumerate(lattice.coordinates))
    survey = lattice.survey
    nodes = survey.nodes - np.concatenate([origin, origin])
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    return Tree((x, y, z), lattice.places, *none, nodes, survey.levels)


def _without(tree: Tree, nodes: np.ndarray) -> Tree:
    """The tree of a lattice without the triangles at some nodes, bool (n_node,)."""
    x, y, z = tree.coordinates
    return replace(tree, coordinates=(x, y, np.where(nodes.reshape(z.shape), np.nan, z)))


MANY = 100_000  # triangles, from which units and mesh are checked in two threads
ROOM_OF_RUN = 1000  # bytes of a second run and of checks, per triangle that curves touch
ROOM = 610  # bytes per triangle: 13.9 GB for 21 million (docs/validation/results.md)
SAME = "two runs give the same bytes"


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
        If the checks need more memory than is free: about 0.6 GB per million triangles that are
        in no run of a grid.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> certify(rebuild_surfaces([flat, wall])).ok
    True
    """
    with spare_threads(patches.n_triangle > MANY) as spare:
        return Certificate(tuple(_checks(patches, units, spare)))


def _checks(
    patches: Patches, units: Units | None = None, spare: Threads | None = None
) -> list[Check]:
    """The checks of `certify`; threads of `spare` take a part of them."""
    stored = before = None
    if units is not None:
        stored = sides_of(patches, units)
        before = None if units.unmerged is None else sides_of(patches, units.unmerged)
    by_elements = units is None or (stored and (before or units.unmerged is None))
    _refuse_if_too_large(_n_listed(patches) if by_elements else patches.n_triangle)
    facts = Facts.of(patches) if by_elements else None
    halves = []
    if facts is not None and units is not None and stored:
        halves.append(partial(checks_of_stored, facts, units, stored, before))

    # runs that do not fit, and shells of their own: every triangle is a run of one
    if facts is None:
        facts = _in_single_triangles(patches)
        if units is not None:
            halves.append(partial(checks_of_lists, facts, units))
    halves.append(partial(checks_of_mesh, facts))
    return list(itertools.chain.from_iterable(in_turn(halves, spare)))


def _in_single_triangles(patches: Patches) -> Facts:
    """The facts of patches of which every triangle is a run of one."""
    _refuse_if_too_large(patches.n_triangle)
    facts = Facts.of(patches.changed())
    assert facts is not None  # there are no runs
    return facts


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
    with spare_threads(patches.n_triangle > MANY) as spare:
        # side by side only where the memory holds both; else the second run is after the checks
        if spare is None or lack_of_room(_n_listed(patches) * ROOM_OF_RUN) is not None:
            checks = _checks(patches, units, spare=spare)
            return Certificate((*checks, same_bytes(patches, rebuild())))
        repeated = spare.submit(lambda: same_bytes(patches, rebuild()))
        checks = _checks(patches, units, spare=spare)
        return Certificate((*checks, repeated.result()))


def _n_listed(patches: Patches) -> int:
    """Number of triangles in no run."""
    pieces = patches.__dict__.get("pieces")
    return patches.n_triangle if pieces is None else len(pieces.triangles)


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


def same_bytes(first_run: Patches, second_run: Patches) -> Check:
    """Check that two runs gave the same bytes, runs for the triangles of grids.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> same_bytes(rebuild_surfaces([flat]), rebuild_surfaces([flat])).passed
    True
    """
    first, second = _arrays_of(first_run), _arrays_of(second_run)
    differ = [name for name in first if not _are_same(first[name], second[name])]
    detail = f"{', '.join(differ)} differ" if differ else f"{len(first)} arrays equal, byte by byte"
    return Check(SAME, not differ, float(len(differ)), detail)


def _arrays_of(patches: Patches) -> dict[str, list[np.ndarray]]:
    """What the arrays of patches are made of, by their names."""
    pieces = patches.pieces
    strips = [part for part in pieces.strips if part is not None]
    names = ("places", "absent", "runs", "start", "nodes", "points")
    lattices = [s.lattice for s in patches.sources if s.lattice is not None] if strips else []
    return {
        "local": [pieces.origin, pieces.x, *(x for part in lattices for x in part.coordinates)],
        "triangles": [
            pieces.triangles,
            *(getattr(part, name) for part in strips for name in names),
        ],
        "surface_of_triangle": [pieces.surface, pieces.first_run],
        "parent_of_triangle": [pieces.key],
        "patch_of_triangle": [pieces.patch],
        "curve_edges": [patches.curve_edges],
    }


def _are_same(arrays: list[np.ndarray], others: list[np.ndarray]) -> bool:
    """Whether arrays have the same bytes, each as its partner."""
    return len(arrays) == len(others) and all(
        one is two or (one.shape == two.shape and one.tobytes() == two.tobytes())
        for one, two in zip(arrays, others, strict=True)
    )
