"""Find candidate pairs, and decide clear cases in floats, between grids with straight axes."""

from __future__ import annotations

import numpy as np

from geosurf.arrangement.tree import Tree, all_pairs
from geosurf.kernels.contacts.axis_grids import axis_grid_pairs
from geosurf.model import TriSurface

_ULP = 2.0**-52
_MOST = 64  # cells of the straight grid below one of the other; beyond, trees pass by planes


def has_axes(surface: TriSurface) -> bool:
    """Whether a surface is a grid whose cells can be found by its axes."""
    return surface.lattice is not None and surface.lattice.has_rising_axes


def are_alike(surfaces: tuple[TriSurface, TriSurface], trees: tuple[Tree, Tree]) -> bool:
    """Whether two surfaces are grids, one with rising axes, whose cells are of like sizes.

    A huge flat cell lies above half a horizon: trees test its plane against their boxes.
    """
    first, second = surfaces[0].lattice, surfaces[1].lattice
    if first is None or second is None:
        return False
    if not any(map(has_axes, surfaces)) or min(len(tree.nodes) for tree in trees) == 0:
        return False

    # `lattice` has straight axes; `other` is any lattice.
    one, two = (0, 1) if has_axes(surfaces[0]) else (1, 0)
    lattice, other = (first, second) if one == 0 else (second, first)
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


def settled_pairs(
    surfaces: tuple[TriSurface, TriSurface], trees: tuple[Tree, Tree], origin: np.ndarray
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles that meet or may, and what they cost.

    Parameters
    ----------
    surfaces : (TriSurface, TriSurface)
        As `are_alike` wants them.
    trees : (Tree, Tree)
    origin : ndarray, shape (3,)
        Of the local frame [m].

    Returns
    -------
    pairs : ndarray of int64, shape (n_pair, 3)
        Keys of both surfaces, and the codes of a contact in two points, ``64 * first + second``,
        or `geosurf.kernels.contacts.axis_grids.OPEN`.
    cost : dict
        Numbers of cells asked, and of pairs.
    """
    # The grid with straight axes comes first; rows are swapped back by the kernel.
    swapped = not has_axes(surfaces[0])
    one, two = trees[::-1] if swapped else trees

    # Rounding in the local frame: half a unit in the last place of the largest difference.
    start = origin.tolist() * 2
    far = (abs(x - o) for tree in trees for x, o in zip(tree.bounds.tolist(), start, strict=True))
    slip = _ULP * max(far)
    sides = [(*of.coordinates, of.places, of.nodes, of.levels) for of in (one, two)]
    return all_pairs(
        lambda room: axis_grid_pairs(*sides[0], *sides[1], origin, slip, swapped, room), 3
    )
