"""Triangles in runs that are near other surfaces: a certificate compares them one by one, too."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.arrangement.aligned import of_one_map, pairs_of_one_map
from geosurf.arrangement.threads import map_threads
from geosurf.arrangement.tree import Tree, apart, separated_by_tops, tree_of_list
from geosurf.carve.certificate.facts import Facts, LatticeRuns
from geosurf.kernels.lattices.unlisted_triangles import mark_near, unlisted_boxes


def candidates(facts: Facts) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 3, 3) and surfaces of the triangles in runs that are not listed, and whose
    boxes meet those of triangles of other surfaces.
    """
    lattices, sources, origin = facts.lattices, facts.patches.sources, facts.patches.origin

    # triangles in runs that are not listed count; others are compared one by one anyway
    free = [_unlisted(one) for one in lattices]
    trees = [_tree_of_free(one, origin, of) for one, of in zip(lattices, free, strict=True)]
    hit = [np.zeros(len(of), dtype=bool) for of in free]

    def between(i: int, j: int) -> None:
        """Mark the triangles of two lattices that are near each other."""
        one, two = lattices[i], lattices[j]
        if not of_one_map(sources[one.surface], sources[two.surface]):
            beside(i, trees[j], free[j], hit[j])
            return
        whole = [_tree_of_lattice(of, origin) for of in (one, two)]
        p, q = pairs_of_one_map((one.lattice, two.lattice), (whole[0], whole[1]))[0].T
        both = (one.label[p] >= 0) & (two.label[q] >= 0)
        hit[i][p[both]] = hit[j][q[both]] = True

    def beside(i: int, other: Tree, free_: np.ndarray, hit_: np.ndarray) -> None:
        """Mark the triangles of a lattice that are near another surface."""
        tree = trees[i]
        mark_near(
            *tree.coordinates, tree.places, tree.nodes, tree.levels, free[i], hit[i],
            *other.arguments(), free_, hit_,
        )  # fmt: skip

    near = _near(trees, [one.surface for one in lattices], len(trees))
    map_threads(between, near)

    # triangles that are listed, surface by surface
    listed, of_listed = facts.elements, facts.elements.surface_of_triangle[facts.elements.element]
    lists, surfaces = [], []
    for i in np.unique(of_listed).tolist():
        some = listed.triangles.take(np.flatnonzero(of_listed == i), axis=0)
        lists.append(tree_of_list(listed.local, some))
        surfaces.append(i)
    of = [*(one.surface for one in lattices), *surfaces]
    near = [pair for pair in _near([*trees, *lists], of, len(trees)) if pair[1] >= len(trees)]
    none = np.empty(0, dtype=bool)
    map_threads(beside, [(i, lists[j - len(trees)], none, none) for i, j in near])
    corners, of_corners = [np.empty((0, 3, 3))], [np.empty(0, dtype=np.int64)]
    for one, of_free, found in zip(lattices, free, hit, strict=True):
        some = np.flatnonzero(found & of_free)
        corners.append(one.corners(some, origin))
        of_corners.append(np.full(len(some), one.surface))
    return np.concatenate(corners), np.concatenate(of_corners)


def _near(trees: Sequence[Tree], surface: list[int], n_first: int) -> list[tuple[int, int]]:
    """Pairs of trees of different surfaces, the first below `n_first`, whose boxes meet."""
    far = apart(list(trees))
    pairs = [
        (i, j) for i in range(n_first) for j in range(i + 1, len(trees))
        if surface[i] != surface[j] and not far[i, j]
    ]  # fmt: skip
    if not pairs:
        return []
    beyond = separated_by_tops(list(trees), np.array(pairs))
    return [pair for pair, is_far in zip(pairs, beyond.tolist(), strict=True) if not is_far]


def _unlisted(one: LatticeRuns) -> np.ndarray:
    """Whether each triangle of a lattice is in a run, and not listed."""
    found: np.ndarray = one.label >= 0
    found[one.listed] = False
    return found


def _tree_of_free(one: LatticeRuns, origin: np.ndarray, free: np.ndarray) -> Tree:
    """The boxes around some triangles of a lattice in the local frame."""
    x, y, z = (part - origin[k] for k, part in enumerate(one.lattice.coordinates))
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    return Tree(
        (x, y, z), one.lattice.places, *none,
        *unlisted_boxes(x, y, z, one.lattice.places, free),
    )  # fmt: skip


def _tree_of_lattice(one: LatticeRuns, origin: np.ndarray) -> Tree:
    """The boxes of a lattice in the local frame: rounding keeps the order of numbers."""
    x, y, z = (part - origin[k] for k, part in enumerate(one.lattice.coordinates))
    survey = one.lattice.survey
    nodes = survey.nodes - np.concatenate([origin, origin])
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    return Tree((x, y, z), one.lattice.places, *none, nodes, survey.levels)
