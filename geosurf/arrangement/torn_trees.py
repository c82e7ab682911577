"""Trees of torn sheets: one of the lattice, one of the triangles at faults; no list is sorted.

Rows of a list, such as a torn sheet has, are found by two searches: in the tree that the survey of
its lattice has made, and in a small one. Triangles of the lattice that are gone are left out again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from geosurf.arrangement import tree
from geosurf.arrangement.tree import Tree
from geosurf.kernels.lattices.lattice_corners import LARGEST, SMALLEST, survey_list
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.model import TriSurface
from geosurf.model.torn_lattice import TornLattice

_KEPT = "_torn_tree"


@dataclass(frozen=True, eq=False)
class TornTree:
    """Trees over a torn sheet.

    Attributes
    ----------
    torn : TornLattice
    lattice, copies : Tree
        Over all triangles of the lattice, also those that are gone; over those at faults.
    doubted : ndarray of int64
        Rows of triangles at faults that may be flat.
    sizes : ndarray
        Of numbers at faults, see `survey_list`.
    """

    torn: TornLattice
    lattice: Tree
    copies: Tree
    doubted: np.ndarray
    sizes: np.ndarray

    @property
    def nodes(self) -> np.ndarray:
        """Boxes of the lattice: none where it is empty."""
        return self.lattice.nodes

    @cached_property
    def bounds(self) -> np.ndarray:
        """Box around all that the trees hold: lower, then upper corner."""
        boxes = np.array([one.bounds for one in (self.lattice, self.copies) if len(one.nodes)])
        return np.concatenate([boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)])

    def rows(self, part: int, keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the sheet's triangles for keys of a part, and which of them exist."""
        torn = self.torn
        if part:
            return keys + torn.n_whole, np.ones(len(keys), dtype=bool)
        if torn.nodes_are_all_there:
            return torn.rows_of_keys(keys), ~is_among(keys, torn.gone)
        rows = np.searchsorted(torn.keys[: torn.n_whole], keys)
        there = rows < torn.n_whole
        there[there] = torn.keys[rows[there]] == keys[there]
        return rows, there


AnyTree = Tree | TornTree


def tree_for(surface: TriSurface) -> AnyTree:
    """The tree of a surface; of a torn sheet over a map, of its parts. Remembered on it."""
    found: TornTree | None = surface.__dict__.get(_KEPT)
    if found is None:
        torn = surface.torn
        if surface.lattice is not None or torn is None or not torn.nodes_lie_apart:
            return tree.tree_of(surface)
        nodes = distinct(torn.copies)
        x, t = torn.places_of_nodes(nodes), np.searchsorted(nodes, torn.copies)
        boxes, codes, doubted, sizes = survey_list(x, t)
        copies = tree.tree_of_boxes(x, t, boxes, codes)
        found = TornTree(torn, tree.tree_of_lattice(torn), copies, doubted, sizes)
        surface.__dict__[_KEPT] = found
    return found


def look_at_torn(surface: TriSurface) -> tuple[np.ndarray, float, float] | None:
    """As `tree.look_at_list`, for a torn sheet over a map; None for others.

    Only triangles at faults may be flat; the smallest number is of these.
    """
    found = tree_for(surface) if surface.torn is not None else None
    if not isinstance(found, TornTree):
        return None
    rows, _ = found.rows(1, found.doubted)
    large = float(np.abs(found.torn.survey.box).max())
    if len(found.torn.copies):  # no numbers have no largest one
        large = max(large, float(found.sizes[LARGEST]))
    return rows, float(found.sizes[SMALLEST]), large


def candidate_pairs(one: AnyTree, two: AnyTree) -> tuple[np.ndarray, dict[str, int]]:
    """As `tree.candidate_pairs`, with rows of torn sheets in place of keys."""
    if isinstance(one, Tree) and isinstance(two, Tree):
        return tree.candidate_pairs(one, two)
    every, spent = [], {"nodes": 0, "pairs": 0}
    for a, b in product(*map(_parts, (one, two))):
        pairs, cost = tree.candidate_pairs(a[1], b[1])
        there = np.ones(len(pairs), dtype=bool)
        for k, (of, (part, _)) in enumerate(((one, a), (two, b))):
            if isinstance(of, TornTree):
                pairs[:, k], mine = of.rows(part, pairs[:, k])
                there &= mine
        every.append(pairs[there])
        spent["nodes"] += cost["nodes"]
        spent["pairs"] += len(every[-1])
    return np.concatenate(every), spent


def _parts(one: AnyTree) -> list[tuple[int, Tree]]:
    """The trees that a tree consists of, with their numbers."""
    return [(0, one)] if isinstance(one, Tree) else [(0, one.lattice), (1, one.copies)]
