"""Triangles in runs that are near other surfaces: a certificate compares them one by one, too."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence

import numpy as np

from geosurf.arrangement.lattice_pairs import of_one_map, pairs_of_one_map
from geosurf.arrangement.threads import map_threads
from geosurf.arrangement.tree import Tree, apart, tree_of_list
from geosurf.carve.certificate.facts import Facts
from geosurf.kernels.lattices.unlisted_triangles import mark_near, unlisted_boxes
from geosurf.model import Lattice

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
