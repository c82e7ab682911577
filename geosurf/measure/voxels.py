"""Voxels that lie in one unit: of many points most need no search."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from geosurf.kernels.location import voxel_units

SHAPE = np.array([64, 64, 256])  # horizons are nearly level: fine steps along z pay most
RIM = 0.1  # voxels between the sides of the model and the next border of voxels
BLOCK = 1 << 15  # points whose answers stay in the cache
EPS = float(np.finfo(np.float64).eps)
SLIP = 128 * EPS  # of the largest coordinate: each of 64 halvings rounds once

Finder = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Voxels:
    """The units of voxels that no surface meets.

    Attributes
    ----------
    grid : ndarray of float64, shape (6,)
        Lowest local coordinate, then voxels per metre, along each axis.
    shape : ndarray of int64, shape (3,)
    words : ndarray of int64
        Units of the voxels, as `voxel_units` packs them.
    """

    grid: np.ndarray
    shape: np.ndarray
    words: np.ndarray

    def find(self, points: np.ndarray, origin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the units of points (n, 3), and the rows of the points that are still open.

        Points are in world coordinates, and `origin` is that of the local ones.
        """
        found, open_ = np.empty(len(points), dtype=np.int32), [np.empty(0, dtype=np.int64)]
        unit, others = np.empty((2, min(BLOCK, len(points)) + 1), dtype=np.int64)
        for first in range(0, len(points), BLOCK):
            block = points[first : first + BLOCK]
            of = (block, origin, self.grid, self.shape, self.words)
            n = voxel_units.units_of_voxels(*of, unit, others)
            found[first : first + BLOCK] = unit[: len(block)]
            open_.append(others[:n] + first)
        return found, np.concatenate(open_)


def voxels_of(
    box: np.ndarray,
    grids: Iterable[tuple[np.ndarray, ...]],
    triangles: Iterable[np.ndarray],
    find_on_lines: Finder,
) -> Voxels:
    """
    Find the voxels that no surface meets, and their units.

    Parameters
    ----------
    box : ndarray of float64, shape (2, 3)
        Lowest and highest coordinates of the model, local.
    grids : iterable of tuple of ndarray
        ``x, y, places, z, column, steps`` of surfaces that share one map.
    triangles : iterable of ndarray of float64, each (n, 9)
        Corners of all other triangles between two units.
    find_on_lines : callable
        Units of vertical lines: local places on the map, and rising levels.

    Returns
    -------
    Voxels
    """
    size = np.ptp(box, axis=0)
    # a model without thickness has voxels of any height; the sides of the model lie in the
    # outermost voxels, next to the border of the next ones: few points share a voxel with them
    number = np.maximum(SHAPE - 2.0 * (1.0 - RIM), 2.0 * RIM)
    per_metre = number / np.where(size > 0.0, size, 1.0)
    low = box[0] - (1.0 - RIM) / per_metre
    grid = np.concatenate([low, per_metre])
    slip = SLIP * float(np.abs(box).max())
    met = np.zeros(SHAPE.prod(), dtype=bool)
    for arrays in grids:
        voxel_units.mark_lattice(*arrays, slip, grid, SHAPE, met)
    for corners in triangles:
        voxel_units.mark_triangles(corners, slip, grid, SHAPE, met)

    # all points of such a voxel are in one unit: that of its middle, if rounding leaves it inside
    x, y, z = (low[k] + (np.arange(SHAPE[k]) + 0.5) / per_metre[k] for k in range(3))
    feet = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    inside = find_on_lines(feet, z).ravel()
    for k, middles in enumerate((x, y, z)):
        place = np.clip((middles - grid[k]) * grid[3 + k], 0.0, SHAPE[k] - 1.0).astype(np.int64)
        lost = np.flatnonzero(place != np.arange(SHAPE[k]))
        np.moveaxis(met.reshape(SHAPE), k, 0)[lost] = True
    inside[met] = voxel_units.OPEN
    words = np.zeros(len(inside) // 4 + 1, dtype=np.int64)
    voxel_units.pack_voxels(inside, words)
    return Voxels(grid, SHAPE, words)


__all__ = ["Voxels", "voxels_of"]
