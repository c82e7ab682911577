"""Find candidate pairs with equal voxels in a common box, after Lo & Wang (2004).

The global box is cut to where the two surfaces can meet, and cut again to the faces
that reach it; voxels are sized to those faces. Only faces whose boxes reach one voxel
together become candidates, each pair once. The voxel size changes the speed, never the result.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.arrangement.threads import check_pairs
from geosurf.arrangement.trees import check_surfaces
from geosurf.conventions import frame_origin, is_number
from geosurf.errors import InputError
from geosurf.kernels.search.tree import faces_in_box, fill_voxels, triangle_boxes, voxel_pairs
from geosurf.model import TriSurface, VoxelSearch

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
        a = _bounds_of(boxes_a.take(rows_a, axis=0))
        b = _bounds_of(boxes_b.take(rows_b, axis=0))
        # Lower corner of the box in both, then the upper one [m].
        cut = np.concatenate([np.maximum(a[:3], b[:3]), np.minimum(a[3:], b[3:])])
        if (cut[:3] > cut[3:]).any():
            return None

        if bounds is not None and np.array_equal(cut, bounds):
            break
        bounds = cut
        rows_a = faces_in_box(boxes_a, bounds)
        rows_b = faces_in_box(boxes_b, bounds)

    if bounds is None or len(rows_a) == 0 or len(rows_b) == 0:
        return None
    return bounds, rows_a, rows_b


def fit_voxels(
    boxes_a: np.ndarray, boxes_b: np.ndarray, size: float | None = None
) -> VoxelGrid | None:
    """Voxels for two sets of boxes, or None where they are apart.

    Parameters
    ----------
    boxes_a, boxes_b : ndarray of float64, shape (n, 6)
        Lower and upper corners of the triangles' boxes.
    size : float, optional
        Edge of the voxels [m]. Default: fitted, so that the larger surface has
        about one face for two voxels, and no voxel is much smaller than a face.

    Returns
    -------
    VoxelGrid or None
    """
    shared = shared_box(boxes_a, boxes_b)
    if shared is None:
        return None
    bounds, rows_a, rows_b = shared
    extent = bounds[3:] - bounds[:3]
    # As many voxels as faces of the larger surface, but none smaller than its usual face.
    if size is None:
        boxes, rows = (boxes_a, rows_a) if len(rows_a) >= len(rows_b) else (boxes_b, rows_b)
        larger = boxes.take(rows, axis=0)
        face = float(np.median((larger[:, 3:] - larger[:, :3]).max(axis=1)))
        wanted = max(len(rows) / _FACES_PER_VOXEL, 1.0)

        # the limit is for sizes that users choose; rounding up an axis may double the number
        wanted = min(wanted, 0.45 * _MOST_VOXELS)
        size = max(face, _size_for(extent, wanted))
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


def pairs_by_voxels(
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
    offsets, filled = fill_voxels(boxes_b, grid.rows_b, grid.bounds, grid.size, grid.shape)
    pairs = np.empty((4 * (len(grid.rows_a) + len(grid.rows_b)) + 64, 2), dtype=np.int64)
    while True:
        n = voxel_pairs(
            boxes_a, grid.rows_a, boxes_b, grid.bounds, grid.size, grid.shape, offsets, filled,
            same, pairs,
        )  # fmt: skip
        if n <= len(pairs):
            break
        check_pairs(n)
        pairs = np.empty((n, 2), dtype=np.int64)

    cost = {"voxels": grid.n_voxel, "pairs": n}
    return pairs[:n].copy(), cost


def _bounds_of(boxes: np.ndarray) -> np.ndarray:
    """Common box of some boxes."""
    low = boxes[:, :3].min(axis=0, initial=np.inf)
    return np.concatenate([low, boxes[:, 3:].max(axis=0, initial=-np.inf)])


def check_voxel_size(voxel_size: Any) -> None:
    """Refuse an edge of the search voxels that is not a length."""
    if voxel_size is not None and not (is_number(voxel_size) and voxel_size > 0):
        raise InputError(f"voxel_size is {voxel_size!r}; give a length in metres above 0.")


def search_voxels(
    first: TriSurface, second: TriSurface, voxel_size: float | None = None
) -> VoxelSearch | None:
    """What the voxels find for two surfaces, for the picture that explains the search.

    Parameters
    ----------
    first, second : TriSurface
    voxel_size : float, optional
        Edge of the voxels [m]; fitted to the data if left out.

    Returns
    -------
    VoxelSearch or None
        None where the boxes of the surfaces do not meet.
    """
    surfaces = check_surfaces((first, second))

    # The same steps as in the search, but the filled voxels are handed out as well.
    origin = frame_origin(*(s.extent for s in surfaces))
    boxes = [triangle_boxes(s.vertices - origin, s.triangles) for s in surfaces]
    grid = fit_voxels(boxes[0], boxes[1], voxel_size)
    if grid is None:
        return None
    pairs, _ = pairs_by_voxels(boxes[0], boxes[1], size=voxel_size)

    filled = []
    for rows, box in ((grid.rows_a, boxes[0]), (grid.rows_b, boxes[1])):
        offsets, _ = fill_voxels(box, rows, grid.bounds, grid.size, grid.shape)
        filled.append(np.diff(offsets) > 0)
    in_both = np.flatnonzero(filled[0] & filled[1])
    occupied = np.stack(np.unravel_index(in_both, grid.shape), axis=1)
    return VoxelSearch(
        lower=grid.bounds[:3] + origin,
        upper=grid.bounds[3:] + origin,
        n_cell=grid.shape,
        size=grid.size,
        occupied=occupied,
        faces_a=np.unique(pairs[:, 0]),
        faces_b=np.unique(pairs[:, 1]),
    )
