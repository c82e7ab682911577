"""Which surfaces meet in the points of a mesh, against sets in Python."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.meshes.point_surfaces import codes_of_points, highest_of_points

N_POINT, N_SURFACE = 9, 4
corners = st.tuples(*3 * [st.integers(0, N_POINT - 1)])


@given(st.lists(st.tuples(corners, st.integers(0, N_SURFACE - 1)), max_size=12))
def test_surfaces_of_points_are_those_of_their_triangles(given: list) -> None:
    t = np.array([of for of, _ in given], dtype=np.int64).reshape(-1, 3)
    surface = np.array([of for _, of in given], dtype=np.int64)
    expected: list[set[int]] = [set() for _ in range(N_POINT)]
    for of, one in given:
        for point in of:
            expected[point].add(one)
    highest, several = highest_of_points(t, surface, N_POINT)
    assert highest.tolist() == [max(of, default=-1) for of in expected]
    assert several.tolist() == [len(of) > 1 for of in expected]
    codes = codes_of_points(t, surface, several, N_SURFACE)
    assert set(codes.tolist()) == {
        N_SURFACE * point + one for point, of in enumerate(expected) if len(of) > 1 for one in of
    }
