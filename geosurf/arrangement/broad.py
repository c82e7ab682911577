"""Find candidate pairs with equal voxels in a common box, after Lo & Wang (2004).

The global box is cut to where the two surfaces can meet, and cut again to the faces
that reach it; voxels are sized to those faces. Only faces whose boxes reach one voxel
together become candidates, each pair once. The voxel size changes the speed, never the result.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.memory_limit import check_pairs
from geosurf.errors import InputError
from geosurf.kernels.search import voxels

_FACES_PER_VOXEL = 0.5  # of the larger surface; flat between 0.2 and 2 on horizons and faults
_MOST_VOXELS = 8_000_000


@dataclass(frozen=True)
class VoxelGrid:
    """Equal voxels of edge `size` over a box, and the candidate faces of both surfaces."""

    bounds: np.ndarray
    size: float
    shape: np.ndarray
    rows_a: np.ndarray
    rows_b: np.ndarray

    @property
    def n_voxel(self) -> int:
        """Number of voxels."""
        return int(np.prod(self.shape))


def shared_box(
    boxes_a: np.ndarray, boxes_b: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """The box where two sets of boxes can meet, and the rows that reach it.

    Cut three times: faces that reach the box shrink what the others can meet. None where
    the surfaces are apart.
    """
    rows_a, rows_b = np.arange(len(boxes_a)), np.arange(len(boxes_b))
    if boxes_a is boxes_b and len(boxes_a):  # they meet everywhere
        return _bounds_of(boxes_a), rows_a, rows_a
    bounds: np.ndarray | None = None
    for _ in range(3):
        if len(rows_a) == 0 or len(rows_b) == 0:
            return None
        one = _bounds_of(boxes_a.take(rows_a, axis=0))
        two = _bounds_of(boxes_b.take(rows_b, axis=0))
        # Lower corners of the meet in the first three columns, upper ones in the last three [m].
        cut = np.concatenate([np.maximum(one[:3], two[:3]), np.minimum(one[3:], two[3:])])
        if (cut[:3] > cut[3:]).any():
            return None

        if bounds is not None and np.array_equal(cut, bounds):
            break
        bounds = cut
        rows_a = voxels.faces_in_box(boxes_a, bounds)
        rows_b = voxels.faces_in_box(boxes_b, bounds)

    if bounds is None or len(rows_a) == 0 or len(rows_b) == 0:
        return None
    return bounds, rows_a, rows_b


def fit_voxels(
    boxes_a: np.ndarray, boxes_b: np.ndarray, size: float | None = None, coarser: float = 1.0
) -> VoxelGrid | None:
    """Voxels for two sets of boxes, or None where they are apart.

    Parameters
    ----------
    boxes_a, boxes_b : ndarray of float64, shape (n, 6)
        Lower and upper corners of the triangles' boxes.
    size : float, optional
        Edge of the voxels [m]. Default: fitted, so that the larger surface has
        about one face for two voxels, and no voxel is much smaller than a face.
    coarser : float
        The fitted edge is multiplied by this.

    Returns
    -------
    VoxelGrid or None
    """
    found = shared_box(boxes_a, boxes_b)
    if found is None:
        return None
    bounds, rows_a, rows_b = found
    extent = bounds[3:] - bounds[:3]
    # As many voxels as faces of the larger surface, but none smaller than its usual face.
    if size is None:
        of, rows = (boxes_a, rows_a) if len(rows_a) >= len(rows_b) else (boxes_b, rows_b)
        sides = of.take(rows, axis=0)
        face = float(np.median((sides[:, 3:] - sides[:, :3]).max(axis=1)))
        wanted = max(len(rows) / _FACES_PER_VOXEL, 1.0)

        # the limit is for sizes that users choose; rounding up an axis may double the number
        wanted = min(wanted, 0.45 * _MOST_VOXELS)
        size = coarser * max(face, _size_for(extent, wanted))
    size = float(size)

    # Boxes that meet in a point have no extent.
    if size <= 0.0:
        size = max(float(extent.max()), 1.0)

    with np.errstate(over="ignore"):  # more than can be counted is more than there may be
        shape = np.maximum(np.ceil(extent / size), 1.0)
        n_voxel = np.prod(shape)
    if n_voxel > _MOST_VOXELS:
        raise InputError(
            f"voxel_size = {size:g} m gives {n_voxel:.3g} voxels; the limit is "
            f"{_MOST_VOXELS}. Choose a larger voxel_size, or leave it out."
        )
    return VoxelGrid(bounds, size, shape.astype(np.int64), rows_a, rows_b)


def equal_voxels(boxes: np.ndarray, n_voxel: int) -> tuple[np.ndarray, float, np.ndarray]:
    """Bounds (6,) of some boxes, and the edge [m] and shape (3,) of about `n_voxel` voxels there.

    Examples
    --------
    >>> equal_voxels(np.array([[0, 0, 0, 4.0, 4, 4]]), 8)[1:]
    (2.0, array([2, 2, 2]))
    """
    bounds = _bounds_of(boxes)
    extent = bounds[3:] - bounds[:3]
    size = _size_for(extent, n_voxel) or max(float(extent.max()), 1.0)
    return bounds, size, np.maximum(np.ceil(extent / size), 1.0).astype(np.int64)


def _size_for(extent: np.ndarray, n_voxel: float) -> float:
    """Edge of cubes, about `n_voxel` of which fill a box that may be flat."""
    sides = np.sort(extent)[::-1]
    for n_axis in (3, 2, 1):
        # A flat box is filled with squares, a line with intervals: no axis gets less than one
        # voxel.
        used = sides[:n_axis]
        if used[-1] > 0:
            size = (np.prod(used) / n_voxel) ** (1.0 / n_axis)
            if n_axis == 1 or size <= used[-1]:
                return float(size)
    return 0.0


def candidate_pairs(
    boxes_a: np.ndarray, boxes_b: np.ndarray, *, size: float | None = None, same: bool = False
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles whose boxes meet.

    Returns
    -------
    pairs : ndarray of int64, shape (n_pair, 2)
        Rows of `boxes_a` and of `boxes_b`. With `same`, the lower row first.
    cost : dict
        Numbers of voxels, of candidate faces and of candidate pairs.
    """
    grid = fit_voxels(boxes_a, boxes_b, size)
    if grid is None:
        return np.empty((0, 2), dtype=np.int64), {"voxels": 0, "pairs": 0}

    # Voxels hold the faces of the second surface; those of the first are looked up in them.
    offsets, filled = voxels.fill_voxels(boxes_b, grid.rows_b, grid.bounds, grid.size, grid.shape)
    pairs = np.empty((4 * (len(grid.rows_a) + len(grid.rows_b)) + 64, 2), dtype=np.int64)
    while True:
        n = voxels.voxel_pairs(
            boxes_a, grid.rows_a, boxes_b, grid.bounds, grid.size, grid.shape, offsets, filled,
            same, pairs,
        )  # fmt: skip
        if n <= len(pairs):
            break
        check_pairs(n)
        pairs = np.empty((n, 2), dtype=np.int64)

    cost = {
        "voxels": grid.n_voxel,
        "pairs": n,
    }
    return pairs[:n].copy(), cost


def _bounds_of(boxes: np.ndarray) -> np.ndarray:
    """Common box of some boxes."""
    low = boxes[:, :3].min(axis=0, initial=np.inf)
    return np.concatenate([low, boxes[:, 3:].max(axis=0, initial=-np.inf)])
