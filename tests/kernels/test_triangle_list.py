"""Lists of triangles, looked at once: what is found, against asking for one thing at a time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf import TriSurface, intersect_surfaces
from geosurf.arrangement.tree import look_at_list, tree_of
from geosurf.errors import SurfaceError
from geosurf.kernels.lattices.lattice_corners import LARGEST, SMALLEST, survey_list
from geosurf.triangulate.mesh import find_zero_area


@st.composite
def lists(draw) -> tuple[np.ndarray, np.ndarray]:
    """Triangles over few whole places, many of them flat."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(1, 40))
    x = rng.integers(-2, 3, (n + 2, 3)) * draw(st.sampled_from([1.0, 0.1, 1e-3, 1e7]))
    return x + draw(st.sampled_from([0.0, 0.3, 5e6])), rng.integers(0, n + 2, (n, 3))


@given(lists())
def test_law_whatever_is_flat_is_in_doubt(listed):
    x, t = listed
    _, _, doubted, sizes = survey_list(x, t)
    flat = find_zero_area(x[t])
    assert set(flat.tolist()) <= set(doubted.tolist())
    nonzero = np.abs(x[x != 0.0])
    assert sizes[SMALLEST] == nonzero.min(initial=np.inf)
    assert sizes[LARGEST] == nonzero.max(initial=0.0)


def far_square(size: float) -> TriSurface:
    x = size * np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    return TriSurface("Top", "horizon", x, [[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize("size", [5e-324, 1e-300, 1.0, 1e300, 1.7e308])
def test_codes_hold_for_any_size(size):
    surface = far_square(size)
    boxes, codes, _, _ = survey_list(surface.vertices, surface.triangles)
    assert boxes.max() == size
    assert (codes >= 0).all()
    assert sorted(tree_of(surface).order.tolist()) == [0, 1]


WALL = TriSurface("F1", "fault", [[0.5, -9, -9], [0.5, 9, -9], [0.5, 0, 9.0]], [[0, 1, 2]])
REFUSED = {
    "huge": ([[0.0, 0, 0], [1e19, 0, 0], [0, 1, 0]], r"'Top' has a coordinate of 1e\+19 m"),
    "flat": (
        [[0.0, 0, 0], [1, 1, 0], [3, 3, 0]],
        r"'Top': 1 of 1 triangles have no area, the first is triangle 0 at \(E .*Remove",
    ),
    "too many digits": (
        [[5e-324, 0, 0], [1, 0, 0], [0, 1, 0]],
        r"'Top': coordinates span \d+ binary digits.*Set numbers that mean zero to zero",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused_is_refused_each_time(case):
    corners, sentence = REFUSED[case]
    surface = TriSurface("Top", "horizon", corners, [[0, 1, 2]])
    for _ in range(2):
        with pytest.raises(SurfaceError, match=sentence):
            intersect_surfaces([surface, WALL])


def test_a_sliver_that_floats_doubt_is_kept():
    """Its area is a rounding unit; exact arithmetic sees it."""
    x = np.array([[0.0, 0, 0], [1 + 2.0**-52, 1, 0], [3, 3, 0]])
    surface = TriSurface("Top", "horizon", x, [[0, 1, 2]])
    doubted, _, _ = look_at_list(surface)
    assert doubted.tolist() == [0]
    assert intersect_surfaces([surface, WALL]).curves is not None


def test_boxes_do_not_stay():
    surface = TriSurface("Top", "horizon", [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    for method in ("tree", "voxels"):
        twin = TriSurface("Top", "horizon", surface.vertices, surface.triangles)
        intersect_surfaces([twin, WALL], method=method)
        assert "_listed" not in twin.__dict__
