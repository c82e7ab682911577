"""Cells whose boxes meet others: what the pyramid finds is what all pairs show."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.kernels.lattices.decimate import near_cells

NO_PLANES = np.empty((0, 4))


def boxes_over(rng, shape):
    """Boxes side by side in the map, some of them empty."""
    row, col = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    corner = np.stack([col / shape[1], row / shape[0], rng.uniform(0, 1, len(row))], axis=1)
    size = np.array([1 / shape[1], 1 / shape[0], 0.05])
    boxes = np.hstack([corner, corner + size * rng.uniform(0.5, 1.5, (len(row), 3))])
    boxes[rng.uniform(size=len(row)) < 0.1] = [np.inf] * 3 + [-np.inf] * 3
    return boxes


@pytest.mark.parametrize("seed", range(20))
def test_the_pyramid_marks_what_all_pairs_show(seed):
    rng = np.random.default_rng(seed)
    one, two = (tuple(rng.integers(1, 14, 2)) for _ in range(2))
    a, b = boxes_over(rng, one), boxes_over(rng, two)
    meet = ((a[:, None, :3] <= b[None, :, 3:]) & (b[None, :, :3] <= a[:, None, 3:])).all(axis=2)
    found = near_cells(a, *one, b, NO_PLANES)
    assert found.ravel().tolist() == meet.any(axis=1).tolist()

    # a plane far below parts all boxes, one through the middle none that it cuts
    planes = np.tile([0.0, 0.0, 1.0, -9.0], (len(b), 1))
    assert not near_cells(a, *one, b, planes).any()
    planes[:, 3] = 0.5
    cut = meet.any(axis=1) & (a[:, 2] <= 0.5) & (a[:, 5] >= 0.5)
    assert near_cells(a, *one, b, planes).ravel().tolist() == cut.tolist()
