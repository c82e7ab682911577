"""Broad phase and floats' share of the narrow one between grids, one of which has straight axes."""

from __future__ import annotations

import numpy as np

from geosurf.contact.tree import Tree, all_pairs
from geosurf.kernels.upright import upright_pairs
from geosurf.model import TriSurface

_ULP = 2.0**-52


def has_axes(surface: TriSurface) -> bool:
    """Whether a surface is a grid whose cells can be found by its axes."""
    return surface.lattice is not None and surface.lattice.has_rising_axes


def settled_pairs(
    surfaces: tuple[TriSurface, TriSurface], trees: tuple[Tree, Tree], origin: np.ndarray
):
    """Pairs of triangles that meet or may, and what they cost.

    Parameters
    ----------
    surfaces : (TriSurface, TriSurface)
        Lattices, at least one of them with rising axes.
    trees : (Tree, Tree)
    origin : ndarray, shape (3,)
        Of the local frame [m].

    Returns
    -------
    pairs : ndarray of int64, shape (n_pair, 3)
        Keys of both surfaces, and the codes of a contact in two points, ``64 * first + second``,
        or `geosurf.kernels.upright.OPEN`.
    cost : dict
        Numbers of cells asked, and of pairs.
    """
    swapped = not has_axes(surfaces[0])
    one, two = trees[::-1] if swapped else trees
    if len(one.nodes) == 0 or len(two.nodes) == 0:
        return np.empty((0, 3), dtype=np.int64), {"nodes": 0, "pairs": 0}
    bounds = np.stack([tree.bounds.reshape(2, 3) - origin for tree in trees])
    slip = _ULP * float(np.abs(bounds).max())
    sides = [(*of.coordinates, of.places, of.nodes, of.levels) for of in (one, two)]
    return all_pairs(
        lambda room: upright_pairs(*sides[0], *sides[1], origin, slip, swapped, room), 3
    )
