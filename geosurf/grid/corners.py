"""Depths of horizons at the corners of columns, each on its own side of the faults.

Each column is sampled along four lines inside it, at the Gauss points: what lies across a fault at
its edge does not count. Columns that no fault parts share the mean of their corners. Thicknesses
are averaged and limited, not clipped, so that their sum over all columns stays that of the samples.
"""

from __future__ import annotations

import numpy as np

from geosurf.model.grids import GAUSS

# from the values at two Gauss points of a unit interval to its ends, linearly
_TO_ENDS = np.array([[1.0 + np.sqrt(3.0), 1.0 - np.sqrt(3.0)]] * 2) / 2.0
_TO_ENDS[1] = _TO_ENDS[1, ::-1]
CORNERS = ((0, 0), (0, 1), (1, 0), (1, 1))


def gauss_feet(shape: tuple[int, int]) -> np.ndarray:
    """Places of the Gauss points of all columns, in lattice coordinates, (ny, nx, 2, 2, 2)."""
    j, i = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    feet = np.empty((*shape, 2, 2, 2))
    feet[..., 0] = (i[..., None] + GAUSS)[:, :, None, :]
    feet[..., 1] = (j[..., None] + GAUSS)[:, :, :, None]
    return feet


def to_corners(samples: np.ndarray) -> np.ndarray:
    """Values at the corners of columns, of values at their Gauss points, (..., 2, 2)."""
    return np.einsum("aj,bi,...ji->...ab", _TO_ENDS, _TO_ENDS, samples)


def limited(corners: np.ndarray) -> np.ndarray:
    """Thicknesses (..., 2, 2) with smaller differences where one is negative, and the same mean."""
    mean = corners.mean(axis=(-1, -2), keepdims=True)
    low = corners.min(axis=(-1, -2), keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(low < 0.0, mean / (mean - low), 1.0)
    # rounding may leave -1e-16: a thickness is never negative
    return np.maximum(mean + share * (corners - mean), 0.0)


def filled(samples: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Samples (..., 2, 2, n) of which those that are not valid take the mean of the others."""
    count = valid.sum(axis=(-1, -2))[..., None, None, None]
    total = np.where(valid[..., None], samples, 0.0).sum(axis=(-2, -3), keepdims=True)
    mean = total / np.maximum(count, 1)
    return np.where(valid[..., None], samples, mean)


def groups_at_nodes(apart_i: np.ndarray, apart_j: np.ndarray, used: np.ndarray) -> np.ndarray:
    """
    Group the four columns around each node by the faults between them.

    Parameters
    ----------
    apart_i : ndarray of bool, shape (ny, nx - 1)
        Whether a fault parts a column from the next along I.
    apart_j : ndarray of bool, shape (ny - 1, nx)
        The same along J.
    used : ndarray of bool, shape (ny, nx)
        Columns inside the model.

    Returns
    -------
    ndarray of int64, shape (ny + 1, nx + 1, 4)
        Group of the columns south-west, south-east, north-west and north-east of each node: the
        smallest number of a column in it; 4 for columns that are not used.
    """
    ny, nx = used.shape
    room = np.zeros((ny + 2, nx + 2), dtype=bool)
    room[1:-1, 1:-1] = used
    here = np.stack([room[:-1, :-1], room[:-1, 1:], room[1:, :-1], room[1:, 1:]], axis=-1)

    # the ring around a node: south, north (along I), west, east (along J)
    along_i = np.ones((ny + 2, nx + 1), dtype=bool)
    along_i[1:-1, 1:-1] = apart_i
    along_j = np.ones((ny + 1, nx + 2), dtype=bool)
    along_j[1:-1, 1:-1] = apart_j
    links = (
        (0, 1, along_i[:-1]), (2, 3, along_i[1:]), (0, 2, along_j[:, :-1]), (1, 3, along_j[:, 1:])
    )  # fmt: skip

    # the smallest number spreads: three rounds reach every column of a ring of four
    group = np.where(here, np.arange(4), 4)
    for _ in range(3):
        for a, b, apart in links:
            joined = ~apart & here[..., a] & here[..., b]
            both = np.minimum(group[..., a], group[..., b])
            group[..., a] = np.where(joined, both, group[..., a])
            group[..., b] = np.where(joined, both, group[..., b])
    return group


def joined(corners: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Corners (ny, nx, 2, 2, n) of which those of one group at a node share their mean."""
    ny, nx, _, _, n = corners.shape
    total, count = np.zeros((ny + 1, nx + 1, 5, n)), np.zeros((ny + 1, nx + 1, 5))
    j, i = np.meshgrid(np.arange(ny), np.arange(nx), indexing="ij")

    # the column north-east of a node (3) has its own corner (0, 0) there
    places = [(j + a, i + b, 3 - 2 * a - b, a, b) for a, b in CORNERS]
    for jj, ii, of, a, b in places:
        np.add.at(total, (jj, ii, group[jj, ii, of]), corners[:, :, a, b])
        np.add.at(count, (jj, ii, group[jj, ii, of]), 1.0)
    mean = total / np.maximum(count, 1.0)[..., None]
    out = np.empty_like(corners)
    for jj, ii, of, a, b in places:
        out[:, :, a, b] = mean[jj, ii, group[jj, ii, of]]
    return out
