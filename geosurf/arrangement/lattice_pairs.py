"""Find candidate pairs of two grids: of one survey, or one with straight axes and any other.

Lattices of one survey have common nodes on the map. What two triangles share above an edge or a
corner of the map only, the triangles above the cells on either side share as well. So between whole
cells only what lies above one triangle is a candidate, whatever the method of search (`needed`),
and can be listed without a walk (`pairs_of_one_map`). Four horizons of Drogon: 14 000 pairs in
place of 340 000.

Of other grids, the cells of one with straight axes below a cell of the other are found directly,
and floats decide clear cases.
"""

from __future__ import annotations

import numpy as np

from geosurf.arrangement.tree import Tree, all_pairs
from geosurf.kernels.contacts.aligned_grids import aligned_pairs
from geosurf.kernels.contacts.axis_grids import axis_grid_pairs
from geosurf.model import Lattice, TriSurface

_SLIP = 2.0**-48  # of the largest coordinate; above what rounding in any frame moves
_ULP = 2.0**-52
_MOST = 64  # cells of the straight grid below one of the other; beyond, trees pass by planes


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


def are_alike(lattices: tuple[Lattice, Lattice], trees: tuple[Tree, Tree]) -> bool:
    """Whether one of two grids has rising axes, and their cells are of like sizes.

    A huge flat cell lies above half a horizon: trees test its plane against their boxes.
    """
    if not any(one.has_rising_axes for one in lattices):
        return False
    if min(len(tree.nodes) for tree in trees) == 0:
        return False

    # `lattice` has straight axes; `other` is any lattice.
    one, two = (0, 1) if lattices[0].has_rising_axes else (1, 0)
    lattice, other = lattices[one], lattices[two]
    bounds = trees[two].bounds
    n_row, n_col = other.shape
    most = _MOST * (n_row - 1) * (n_col - 1)
    # The whole straight grid is small enough.
    if (len(lattice.easting) + 1) * (len(lattice.northing) + 1) <= most:
        return True  # whatever is below

    # Otherwise its cells below the box of the other one count.
    n = 1
    for axis, k in ((lattice.easting, 0), (lattice.northing, 1)):
        low, high = np.searchsorted(axis, bounds[k::3])
        n *= int(high - low) + 1
    return n <= most


def pairs_of_grids(
    surfaces: tuple[TriSurface, TriSurface], trees: tuple[Tree, Tree], origin: np.ndarray
) -> tuple[np.ndarray, dict[str, int]] | None:
    """Return `settled_pairs` of two grids of like cells, one with straight axes.

    None for other surfaces.
    """
    first, second = surfaces[0].lattice, surfaces[1].lattice
    if first is None or second is None:
        return None
    lattices = first, second
    slip = slip_of(trees, origin)
    return settled_pairs(lattices, trees, origin, slip) if are_alike(lattices, trees) else None


def slip_of(trees: tuple[Tree, Tree], origin: np.ndarray) -> float:
    """Rounding in the local frame: half a unit in the last place of the largest difference."""
    start = origin.tolist() * 2
    far = (abs(x - o) for tree in trees for x, o in zip(tree.bounds.tolist(), start, strict=True))
    return _ULP * max(far)


def settled_pairs(
    lattices: tuple[Lattice, Lattice],
    trees: tuple[Tree, Tree],
    origin: np.ndarray,
    slip: float,
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles that meet or may, and what they cost.

    Parameters
    ----------
    lattices : (Lattice, Lattice)
        As `are_alike` wants them.
    trees : (Tree, Tree)
    origin : ndarray, shape (3,)
        Of the local frame [m].
    slip : float
        By how much nodes may be off in it [m]; answers hold wherever they are.

    Returns
    -------
    pairs : ndarray of int64, shape (n_pair, 3)
        Keys of both surfaces, and the codes of a contact in two points, ``64 * first + second``,
        or `geosurf.kernels.contacts.axis_grids.OPEN`.
    cost : dict
        Numbers of cells asked, and of pairs.
    """
    # The grid with straight axes comes first; rows are swapped back by the kernel.
    swapped = not lattices[0].has_rising_axes
    one, two = trees[::-1] if swapped else trees
    sides = [(*of.coordinates, of.places, of.nodes, of.levels) for of in (one, two)]
    return all_pairs(
        lambda room: axis_grid_pairs(*sides[0], *sides[1], origin, slip, swapped, room), 3
    )
