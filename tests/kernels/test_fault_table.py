"""Values on a mesh: bit for bit those of the triangle that numpy finds each point deepest in."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.sheets.fault_trace import values_on_triangles

INSIDE = -1e-9


def best(plane, values, triangles, point):
    """Value of the last of the triangles that a point is deepest in; NaN outside of all."""
    a, b, c = plane[triangles].transpose(1, 0, 2)
    one, two, to = b - a, c - a, point - a
    det = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    with np.errstate(all="ignore"):
        v = (to[:, 0] * two[:, 1] - to[:, 1] * two[:, 0]) / det
        w = (one[:, 0] * to[:, 1] - one[:, 1] * to[:, 0]) / det
        weight = np.stack([1.0 - v - w, v, w], axis=1)
    least = np.where(det == 0.0, -np.inf, weight.min(axis=1))
    i = len(least) - 1 - int(least[::-1].argmax())
    return float((weight[i] * values[triangles[i]]).sum()) if least[i] >= INSIDE else np.nan


@given(st.integers(0, 2**32 - 1))
def test_a_point_takes_the_triangle_that_it_is_deepest_in(seed):
    # whole numbers: points on edges and corners, in several triangles at once, and without area
    rng = np.random.default_rng(seed)
    plane = rng.integers(0, 5, (12, 2)).astype(float)
    values = rng.normal(size=12)
    triangles = rng.integers(0, 12, (15, 3))
    points = np.concatenate([rng.integers(0, 5, (20, 2)), rng.uniform(-0.5, 4.5, (20, 2))])
    starts = np.array([0, 6, 15])
    rows, block = rng.permutation(40)[:30], rng.integers(0, 2, 30)
    out = np.full(40, np.nan)
    values_on_triangles(
        plane, values, triangles, starts, np.arange(15), points, rows, block, INSIDE, out
    )
    expected = np.full(40, np.nan)
    for row, b in zip(rows, block, strict=True):
        listed = triangles[starts[b] : starts[b + 1]]
        expected[row] = best(plane, values, listed, points[row])
    assert np.array_equal(out, expected, equal_nan=True)
