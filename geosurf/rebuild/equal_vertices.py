"""Find vertices of one surface in the same place; most surfaces have none."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.meshes.mesh import (
    weld,
)
from geosurf.model import TriSurface
from geosurf.model.torn_lattice import TornLattice


def has_strips(surface: TriSurface) -> bool:
    """Whether a surface is a lattice no two nodes of which are one point."""
    if surface.lattice is None:
        return False
    return surface.lattice.is_graph or first_of_equals(surface) is None


def first_of_equals(surface: TriSurface) -> np.ndarray | None:
    """For each vertex the first one in the same place; None if all differ. Remembered.

    Meshes in parts (GOCAD TFACE) repeat the vertices on their seams, and so does a lattice
    that closes in a ring.
    """
    if "_first_of_equals" not in surface.__dict__:
        first = None
        if _some_may_be_equal(surface):
            # The first vertex in each place: later rows are overwritten by earlier ones.
            number, count = weld(surface.vertices)
            lead = np.empty(count, dtype=np.int64)
            lead[number[::-1]] = np.arange(surface.n_vertex)[::-1]
            first = lead[number] if count < surface.n_vertex else None
        surface.__dict__["_first_of_equals"] = first
    return surface.__dict__["_first_of_equals"]


def _some_may_be_equal(surface: TriSurface) -> bool:
    """Whether points may be equal: if not, one sum of their coordinates tells them all apart.

    A sort of numbers takes a fifth of the time of a table of points.
    """
    lattice = surface.lattice
    if lattice is None:
        if surface.torn is not None and surface.torn.nodes_lie_apart:
            over = surface.torn.node_of_ghost
            if over is not None:
                return _ghosts_meet(surface.torn, over)
        x, y, z = surface.vertices.T
    else:
        x, y = lattice.horizontal()
        z = lattice.elevation
        if _rows_are_apart(x, y, z):
            return False

    # Coefficients of the plastic number: sums of grid coordinates do not repeat by chance.
    keys = (x + 0.7548776662466927 * y + 0.5698402909980532 * z).ravel()
    keys = np.sort(keys[np.isfinite(keys)])
    return bool((keys[1:] == keys[:-1]).any())


def _ghosts_meet(torn: TornLattice, over: np.ndarray) -> bool:
    """Whether a ghost has the height of its node, or of another ghost `over` the same node."""
    z = torn.ghosts[:, 2]
    if (z == torn.elevation.ravel()[over]).any():
        return True
    order = np.lexsort((z, over))
    over, z = over[order], z[order]
    return bool(((over[1:] == over[:-1]) & (z[1:] == z[:-1])).any())


def _rows_are_apart(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> bool:
    """Whether each row of nodes lies above or below the row before, and runs one way in the map.

    So do the rows of a fault that is extruded along its strike: 0.1 ms instead of 1.4 for a sort.
    """
    low, high = z.min(axis=1), z.max(axis=1)
    if not ((low[:-1] > high[1:]).all() or (high[:-1] < low[1:]).all()):
        return False

    steps = x[:, 1:] - x[:, :-1], y[:, 1:] - y[:, :-1]
    return any(bool((step > 0).all() or (step < 0).all()) for step in steps)
