"""The checks of a certificate without a list of all triangles: see `facts`."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from geosurf.arrangement.crossing import crossing_pairs
from geosurf.arrangement.lattice_pairs import of_one_map, pairs_of_one_map
from geosurf.arrangement.threads import map_threads
from geosurf.arrangement.tree import Tree, apart, tree_of_list
from geosurf.carve.certificate.checks import (
    CROSSES,
    EPS,
    SHARED,
    Part,
    Size,
    areas_agree,
    beside_parents,
    crosses_not,
    is_graph,
    limits_of,
    shared_in_words,
    surely_exact,
)
from geosurf.carve.certificate.facts import Facts, sides_of
from geosurf.carve.certificate.lines import Half, lines_of, lines_of_units
from geosurf.carve.volume import exact_volume
from geosurf.kernels.lattices.unlisted_triangles import mark_near, unlisted_boxes
from geosurf.model import Check, Lattice, Patches, TriSurface, Units
from geosurf.model.pieces import Pieces, Strips

if TYPE_CHECKING:
    from concurrent.futures import Executor

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
    patches: Patches, units: Units | None = None, spare: Executor | None = None
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


_NONE = np.empty(0, dtype=bool)


def candidates(facts: Facts) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 3, 3) and surfaces of the triangles in runs that are not listed, and whose
    boxes meet those of triangles of other surfaces, or of copies at tears of their own.
    """
    lattices, origin = facts.lattices, facts.patches.origin
    of = [facts.patches.sources[one.surface] for one in lattices]

    # triangles in runs that are not listed count; others are compared one by one anyway
    free = [one.unlisted() for one in lattices]
    trees = [_tree_of(one.lattice, origin, f) for one, f in zip(lattices, free, strict=True)]
    hit = [np.zeros(len(some), dtype=bool) for some in free]

    def between(i: int, j: int) -> None:
        """Mark the triangles of two lattices that are near each other."""
        one, two = lattices[i], lattices[j]
        if not of_one_map(of[i], of[j]):
            beside(i, trees[j], free[j], hit[j])
            return
        whole = [_tree_of_all(of.lattice, origin) for of in (one, two)]
        p, q = pairs_of_one_map((one.lattice, two.lattice), (whole[0], whole[1]))[0].T
        both = (one.run_of(p) >= 0) & (two.run_of(q) >= 0)
        hit[i][p[both]] = hit[j][q[both]] = True

    def beside(i: int, other: Tree, free_: np.ndarray, hit_: np.ndarray) -> None:
        """Mark the triangles of a lattice that are near another surface."""
        tree = trees[i]
        mark_near(
            *tree.coordinates, tree.places, tree.nodes, tree.levels, free[i], hit[i],
            *other.arguments(), free_, hit_,
        )  # fmt: skip

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
            beside(i, tree, _NONE, _NONE)

    def around_copies(i: int, copies: np.ndarray) -> None:
        """Mark the triangles of a torn lattice that are near its own copies: over or below them."""
        beside(i, tree_of_list(listed.local, listed.triangles[copies]), _NONE, _NONE)

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


def _tree_of(lattice: Lattice, origin: np.ndarray, free: np.ndarray) -> Tree:
    """The boxes around some triangles of a lattice in the local frame."""
    x, y, z = (part - origin[k] for k, part in enumerate(lattice.coordinates))
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    given = (x, y, z), lattice.places, *none
    return Tree(*given, *unlisted_boxes(x, y, z, lattice.places, free))


def _tree_of_all(lattice: Lattice, origin: np.ndarray) -> Tree:
    """The boxes of a lattice in the local frame: rounding keeps the order of numbers."""
    x, y, z = (part - origin[k] for k, part in enumerate(lattice.coordinates))
    survey = lattice.survey
    nodes = survey.nodes - np.concatenate([origin, origin])
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    return Tree((x, y, z), lattice.places, *none, nodes, survey.levels)
