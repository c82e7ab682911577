"""Triangles that are left out around some few others do not meet any of them."""

import numpy as np
import pytest

from geosurf.arrangement.triangles import crossing_pairs, near_triangles
from geosurf.kernels.search.voxels import triangle_boxes


def soup(rng, n, size):
    """Random triangles of some size in a box of 100 m: points and rows."""
    middle = rng.uniform(0.0, 100.0, (n, 1, 3))
    corners = middle + rng.uniform(-size, size, (n, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)


@pytest.mark.parametrize("seed", range(4))
def test_what_crosses_some_few_triangles_is_near_them(seed):
    rng = np.random.default_rng(seed)
    parts = [soup(rng, 40, 1.0), soup(rng, 6, 60.0), soup(rng, 4000, 2.0), soup(rng, 40, 50.0)]
    # flat walls lie on the bounds of the search
    wall = np.array([[0.0, 0, 0], [0, 100, 0], [0, 100, 100], [0, 0, 100]])
    parts.insert(2, (wall, np.array([[0, 1, 2], [0, 2, 3]])))
    first = np.cumsum([0] + [len(x) for x, _ in parts])
    x = np.concatenate([x for x, _ in parts])
    few, others = (
        np.concatenate([parts[k][1] + first[k] for k in of]) for of in ((0, 1, 2), (3, 4))
    )

    near = near_triangles(x, few, others)
    pairs = crossing_pairs(x, few, others)
    met = pairs[(pairs[:, 0] < len(few)) & (pairs[:, 1] >= len(few)), 1] - len(few)
    assert len(np.unique(met)) > 20
    assert near[met].all()
    # and most of those that no box of a narrow one reaches are left out
    assert near.mean() < 0.9


def test_touching_at_a_face_of_the_bounds_is_near():
    x = np.array([[0.0, 0, 0], [8, 0, 0], [0, 8, 0], [8, 0, 4], [9, 0, 4], [9, 1, 4], [8, 0, 0]])
    few, others = np.array([[0, 1, 2]]), np.array([[3, 4, 6], [3, 4, 5]])
    assert triangle_boxes(x, others)[0, 0] == 8.0
    assert near_triangles(x, few, others).tolist() == [True, False]


def test_nothing_is_near_nothing():
    x, t = soup(np.random.default_rng(0), 5, 1.0)
    assert not near_triangles(x, t[:0], t).any()
