"""Find candidate pairs, and decide clear cases in floats, between grids with straight axes."""

from __future__ import annotations

import numpy as np

from geosurf.arrangement.straight import straightened
from geosurf.arrangement.tree import Tree, all_pairs, tree_of_lattice
from geosurf.kernels.contacts.axis_grids import axis_grid_pairs
from geosurf.model import Lattice, TriSurface

_ULP = 2.0**-52
_MOST = 64  # cells of the straight grid below one of the other; beyond, trees pass by planes


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
    """Return `settled_pairs` of two grids of like cells, one with straight axes or even steps.

    None for other surfaces.
    """
    first, second = surfaces[0].lattice, surfaces[1].lattice
    if first is None or second is None:
        return None
    lattices = first, second
    slip = slip_of(trees, origin)
    if any(one.has_rising_axes for one in lattices):
        return settled_pairs(lattices, trees, origin, slip) if are_alike(lattices, trees) else None

    # rotated grids with even steps have straight axes in a frame of their own
    found = straightened(lattices, trees, origin, slip)
    if found is None:
        return None
    lattices, origin, slip = found
    trees = tree_of_lattice(lattices[0]), tree_of_lattice(lattices[1])
    return (
        settled_pairs(lattices, trees, origin, slip, slip) if are_alike(lattices, trees) else None
    )


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
    wide: float = 0.0,
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
    wide : float
        By how much they may be off in the map before that [m].

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
        lambda room: axis_grid_pairs(*sides[0], *sides[1], origin, slip, wide, swapped, room), 3
    )
