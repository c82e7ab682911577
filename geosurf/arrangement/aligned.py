"""Find candidate pairs between horizons of one survey: lattices with common nodes on the map.

What two triangles share above an edge or a corner of the map only, the triangles above the
cells on either side share as well. So between whole cells only what lies above one triangle
is a candidate, whatever the method of search (`needed`), and can be listed without a walk
(`pairs_of_one_map`). Four horizons of Drogon: 14 000 pairs in place of 340 000.
"""

from __future__ import annotations

import numpy as np

from geosurf.arrangement.tree import Tree, all_pairs
from geosurf.kernels.contacts.aligned_grids import aligned_pairs
from geosurf.model import Lattice, TriSurface

_SLIP = 2.0**-48  # of the largest coordinate; above what rounding in any frame moves


def of_one_map(one: TriSurface, two: TriSurface) -> bool:
    """Whether two surfaces are lattices with the same nodes in the map."""
    return (
        one.lattice is not None and two.lattice is not None and one.lattice.shares_map(two.lattice)
    )


def pairs_of_one_map(
    lattices: tuple[Lattice, Lattice],
    trees: tuple[Tree, Tree],
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of keys that may meet, and what they cost, as `tree.candidate_pairs` returns them.

    The lattices share their map.
    """
    one, two = lattices
    slip = _SLIP * float(max(np.abs(of.bounds).max() for of in trees))
    sides = [(of.coordinates[2], of.places, of.nodes) for of in trees]
    whole = one.whole and two.whole
    # Cells with holes need another rule. One over the height of a triangle bounds its slope.
    arguments = (*sides[0], *sides[1], trees[0].levels, whole, slip, 1.0 / one.map_height)
    return all_pairs(lambda room: aligned_pairs(*arguments, room))


def needed(one: Lattice, two: Lattice, pairs: np.ndarray) -> np.ndarray:
    """Mask of the pairs (n, 2) of keys, of lattices with one map, that add what no other pair has.

    All pairs with a cell that is not whole; else those above the same triangle of the map, or,
    where diagonals differ, above the same cell.
    """
    whole = (_whole_cells(one) & _whole_cells(two)).ravel()
    cells = pairs >> 1

    # Two keys per cell, so half of the key is the cell; with different diagonals, triangles of one
    # cell overlap on the map.
    above = pairs if one.rising == two.rising else cells
    mask: np.ndarray = ~whole[cells].all(axis=1) | (above[:, 0] == above[:, 1])
    return mask


def _whole_cells(lattice: Lattice) -> np.ndarray:
    """Mask (n_row - 1, n_col - 1) of the cells with four nodes."""
    p = lattice.present
    mask: np.ndarray = p[:-1, :-1] & p[:-1, 1:] & p[1:, :-1] & p[1:, 1:]
    return mask
