"""Blocks of two lattices whose boxes meet: what both pyramids find is what all pairs show."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.kernels.smooth.near_blocks import near_blocks, shift_near

NO_LEVELS, NO_PLANES = np.empty((0, 3), dtype=np.int64), np.empty((0, 4))


def levels_of(n_row, n_col):
    """Offset, rows and columns of each level, the finest first."""
    found, total = [], 0
    while True:
        found.append((total, n_row, n_col))
        total += n_row * n_col
        if n_row * n_col == 1:
            return np.array(found, dtype=np.int64)
        n_row, n_col = (n_row + 1) // 2, (n_col + 1) // 2


def boxes_over(rng, shape):
    """Boxes side by side in the map, some of them empty."""
    row, col = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    corner = np.stack([col / shape[1], row / shape[0], rng.uniform(0, 1, len(row))], axis=1)
    size = np.array([1 / shape[1], 1 / shape[0], 0.05])
    boxes = np.hstack([corner, corner + size * rng.uniform(0.5, 1.5, (len(row), 3))])
    boxes[rng.uniform(size=len(row)) < 0.1] = [np.inf] * 3 + [-np.inf] * 3
    return boxes


@pytest.mark.parametrize("seed", range(20))
def test_both_pyramids_mark_what_all_pairs_show(seed):
    rng = np.random.default_rng(seed)
    one, two = (tuple(rng.integers(1, 14, 2)) for _ in range(2))
    a, b = boxes_over(rng, one), boxes_over(rng, two)
    meet = ((a[:, None, :3] <= b[None, :, 3:]) & (b[None, :, :3] <= a[:, None, 3:])).all(axis=2)
    for levels in (levels_of(*two), NO_LEVELS):
        found = near_blocks(a, levels_of(*one), b, levels, NO_PLANES)
        assert found[0].tolist() == meet.any(axis=1).tolist()
        assert found[1].tolist() == meet.any(axis=0).tolist()


@pytest.mark.parametrize("seed", range(8))
def test_nodes_of_near_blocks_and_those_around_are_shifted(seed):
    rng = np.random.default_rng(seed)
    shape, cells = rng.integers(9, 60, 2), 8
    blocks = -(-(shape - 1) // cells)
    near = rng.uniform(size=blocks) < 0.15
    z, out = rng.normal(size=shape), np.zeros(shape)
    shift_near(z, 0.5, near, cells, out)
    wanted = np.zeros(shape)
    for i, j in np.argwhere(near):
        part = tuple(slice(max(k - 1, 0) * cells, (k + 2) * cells + 1) for k in (i, j))
        wanted[part] = z[part] - 0.5
    assert out.tobytes() == wanted.tobytes()
