"""Thin pieces are found as plain numpy finds them."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.kernels.thin import thin_children


def slowly(x, t, pairs, y, children, parent, reach):
    """The same in numpy, array by array."""
    a, b, c = (x[t[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    sine = np.linalg.norm(np.cross(normal[pairs[:, 0]], normal[pairs[:, 1]]), axis=1)
    flattest = np.ones(len(t))
    for side in range(2):
        np.minimum.at(flattest, pairs[:, side], sine)
    a, b, c = (y[children[:, k]] for k in range(3))
    sides = np.stack([b - a, c - b, a - c])
    longest = np.linalg.norm(sides, axis=2).max(axis=0)
    height = np.linalg.norm(np.cross(sides[0], sides[2]), axis=1) / longest
    return height * flattest[parent] / reach


@pytest.mark.parametrize("reach", [0.02, 0.1, 0.4])
def test_as_in_numpy(rng, reach):
    x, y = rng.random((40, 3)), rng.random((90, 3))
    y[:30, 2] *= 1e-3
    t = np.array([rng.permutation(40)[:3] for _ in range(25)])
    children = np.array([rng.permutation(90)[:3] for _ in range(300)])
    pairs, parent = rng.integers(0, 25, (30, 2)), rng.integers(0, 25, 300)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    ratio = slowly(x, t, pairs, y, children, parent, reach)
    clear = np.abs(ratio - 1.0) > 1e-9
    found = thin_children(x, t, pairs, y, children, parent, reach)
    assert found.any()
    assert not found.all()
    assert (found == (ratio <= 1.0))[clear].all()


def test_what_has_no_height_is_thin():
    x = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]])
    t, none = np.array([[0, 1, 2]]), np.empty((0, 2), dtype=np.int64)
    children = np.array([[0, 1, 3], [0, 0, 0], [0, 1, 2]])
    assert thin_children(x, t, none, x, children, np.zeros(3, np.int64), 0.0).tolist() == [
        True, True, False,
    ]  # fmt: skip
