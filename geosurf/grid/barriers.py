"""Which faults lie between neighbouring columns: rays between the middles of their cells.

A ray along I is a vertical line of a frame whose axes have changed places, so that the exact signs
of `geosurf.measure.columns` decide whether it meets a fault. A fault parts two columns if the ray
between them crosses it an odd number of times. Middles lie at different elevations: the way from
one to the next is vertical, then a ray, then vertical again, so that ways around a node agree on
what is on which side.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.measure.columns import cross_columns
from geosurf.model.grids import GAUSS

AXES = ((1, 2, 0), (0, 2, 1))  # of a ray along I, along J: the two across it, then along it


def faults_between(
    faults: Sequence[tuple[np.ndarray, np.ndarray]], middle: np.ndarray, inside: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Find the faults between the middles of neighbouring columns.

    Parameters
    ----------
    faults : sequence of (ndarray, ndarray)
        Vertices in lattice coordinates (n, 3) and triangles (m, 3) of each fault.
    middle : ndarray of float64, shape (n_level, ny, nx)
        Elevation of the middle of each column at each level [m].
    inside : ndarray of bool, shape (ny, nx)
        Columns inside the model.

    Returns
    -------
    (ndarray of bool, ndarray of bool)
        Along I (n_fault, n_level, ny, nx - 1) and along J (n_fault, n_level, ny - 1, nx).
    """
    level, ny, nx = middle.shape
    _, j, i = np.meshgrid(*map(np.arange, (level, ny, nx)), indexing="ij")
    place = np.stack([i + 0.5, j + 0.5, middle], axis=-1)

    # the ray lies at the mean elevation of both
    rays_i = place[:, :, :-1].copy()
    rays_i[..., 2] = 0.5 * (middle[:, :, :-1] + middle[:, :, 1:])
    rays_j = place[:, :-1].copy()
    rays_j[..., 2] = 0.5 * (middle[:, :-1] + middle[:, 1:])
    open_i, open_j = inside[:, :-1] & inside[:, 1:], inside[:-1] & inside[1:]
    found_i, found_j = [], []
    for x, triangles in faults:
        apart_i = _crossed(x, triangles, rays_i, open_i, 0)
        apart_j = _crossed(x, triangles, rays_j, open_j, 1)
        below = Below(x, triangles, inside)
        here = below(middle)
        for end in (slice(None, -1), slice(1, None)):
            # of both columns: from the middle to the height of the ray
            z = middle.copy()
            z[:, :, end] = rays_i[..., 2]
            apart_i ^= (below(z) ^ here)[:, :, end]
            z = middle.copy()
            z[:, end] = rays_j[..., 2]
            apart_j ^= (below(z) ^ here)[:, end]
        found_i.append(apart_i & open_i)
        found_j.append(apart_j & open_j)
    return (
        np.array(found_i, dtype=bool).reshape(len(faults), level, ny, nx - 1),
        np.array(found_j, dtype=bool).reshape(len(faults), level, ny - 1, nx),
    )


class Below:
    """Whether a fault is crossed an odd number of times below a point of the line of a column."""

    def __init__(self, x: np.ndarray, triangles: np.ndarray, inside: np.ndarray) -> None:
        j, i = np.nonzero(inside)
        feet = np.stack([i + 0.5, j + 0.5], axis=1)
        found = cross_columns(x, triangles, feet, np.zeros(2))
        self.column, self.elevation = np.flatnonzero(inside)[found.foot], found.elevation

    def __call__(self, z: np.ndarray) -> np.ndarray:
        """Of elevations (n_level, ny, nx)."""
        flat = z.reshape(len(z), -1)
        odd = np.zeros(flat.shape, dtype=np.int64)
        for k, one in enumerate(flat):
            lower = self.elevation < one[self.column]
            odd[k] = np.bincount(self.column[lower], minlength=flat.shape[1])
        return (odd % 2 == 1).reshape(z.shape)


def own_side(
    faults: Sequence[tuple[np.ndarray, np.ndarray]], middle: np.ndarray, inside: np.ndarray
) -> np.ndarray:
    """
    Return which Gauss points of a column lie on the side of its middle of all faults.

    Parameters
    ----------
    faults : sequence of (ndarray, ndarray)
    middle : ndarray of float64, shape (ny, nx)
        Elevation [m].
    inside : ndarray of bool, shape (ny, nx)

    Returns
    -------
    ndarray of bool, shape (ny, nx, 2, 2)
        Last axes along J and I.
    """
    ny, nx = middle.shape
    j, i = np.meshgrid(np.arange(ny), np.arange(nx), indexing="ij")
    half = 0.5 - GAUSS[0]
    same = np.ones((ny, nx, 2, 2), dtype=bool)
    for x, triangles in faults:
        for b in range(2):
            # from the middle along J, then along I: one crossing after the other
            start = np.stack([i + 0.5, j + (GAUSS[0], 0.5)[b], middle], axis=-1)
            first = _crossed(x, triangles, start, inside, 1, half)
            for a in range(2):
                start = np.stack([i + (GAUSS[0], 0.5)[a], j + GAUSS[b], middle], axis=-1)
                same[:, :, b, a] &= first == _crossed(x, triangles, start, inside, 0, half)
    return same


def _crossed(
    x: np.ndarray,
    triangles: np.ndarray,
    start: np.ndarray,
    open_at: np.ndarray,
    along: int,
    length: float = 1.0,
) -> np.ndarray:
    """Whether rays along an axis cross a fault an odd number of times."""
    across = list(AXES[along])
    low, high = x.min(axis=0), x.max(axis=0)
    near = open_at & (start >= low - 1.0).all(axis=-1) & (start <= high + 1.0).all(axis=-1)
    rays = start[near]
    found = cross_columns(
        np.ascontiguousarray(x[:, across]), triangles, rays[:, across[:2]].copy(), np.zeros(2)
    )
    first = rays[found.foot, along]
    hit = (found.elevation >= first) & (found.elevation < first + length)
    out = np.zeros(start.shape[:-1], dtype=bool)
    out[near] = np.bincount(found.foot[hit], minlength=len(rays)) % 2 == 1
    return out
