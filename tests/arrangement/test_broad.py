"""Candidate pairs against comparing all boxes with all boxes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf import intersect_surfaces
from geosurf.arrangement import search_voxels
from geosurf.arrangement.candidates import candidate_pairs, fit_voxels
from geosurf.arrangement.search import find_contacts
from geosurf.errors import InputError
from geosurf.kernels.search.tree import triangle_boxes
from tests.strategies import grid, sheet

SIZES = (None, 0.3, 1.0, 1.7, 100.0)


def all_pairs(a, b, same=False):
    meets = (a[:, None, :3] <= b[None, :, 3:]).all(axis=2)
    meets &= (b[None, :, :3] <= a[:, None, 3:]).all(axis=2)
    pairs = np.argwhere(meets)
    return pairs[pairs[:, 0] < pairs[:, 1]] if same else pairs


def assert_all_once(a, b, size, same=False):
    pairs, cost = candidate_pairs(a, b, size=size, same=same)
    found = pairs[np.lexsort(pairs.T[::-1])]
    np.testing.assert_array_equal(found, all_pairs(a, b, same))
    assert cost["pairs"] == len(pairs)
    return cost


@st.composite
def boxes(draw):
    corners = draw(
        st.lists(
            st.tuples(*[st.integers(0, 6)] * 3, *[st.integers(0, 3)] * 3), min_size=1, max_size=12
        )
    )
    corners = np.array(corners, dtype=float)
    return np.hstack([corners[:, :3], corners[:, :3] + corners[:, 3:]])


@given(boxes(), boxes(), st.sampled_from(SIZES))
def test_any_boxes_and_any_voxel_size(a, b, size):
    assert_all_once(a, b, size)


@given(boxes(), st.sampled_from(SIZES))
def test_a_surface_with_itself(a, size):
    assert_all_once(a, a, size, same=True)


def test_voxels_that_would_fill_the_memory_are_refused():
    a = np.array([[0.0, 0, 0, 1000, 1000, 1000]])
    with pytest.raises(InputError, match=r"voxel_size = 0\.001 m gives 1e\+18.*larger voxel_size"):
        fit_voxels(a, a, 1e-3)


@pytest.mark.parametrize("size", [0.0, -1.0, np.nan, np.inf])
def test_sizes_that_make_no_sense_are_refused(size):
    top = grid("Top", np.zeros((3, 3)))
    with pytest.raises(InputError, match="voxel"):
        find_contacts([top, top.renamed("Base")], voxel_size=size)


def test_unknown_methods_are_refused():
    top = grid("Top", np.zeros((3, 3)))
    with pytest.raises(InputError, match=r"method is 'octree', expected one of \('auto'"):
        intersect_surfaces([top, top], method="octree")


def test_search_for_the_picture(rng):
    top = grid("Top", rng.integers(0, 3, (9, 9)))
    wall = sheet("F1", [(3.5, -1, -1), (3.5, 9, -1), (5.5, 9, 3), (5.5, -1, 3)], (4, 8))
    found = search_voxels(top, wall)
    boxes = [triangle_boxes(s.vertices, s.triangles) for s in (top, wall)]
    pairs = all_pairs(*boxes)
    np.testing.assert_array_equal(found.faces_a, np.unique(pairs[:, 0]))
    np.testing.assert_array_equal(found.faces_b, np.unique(pairs[:, 1]))
    assert (found.occupied >= 0).all()
    assert (found.occupied < found.n_cell).all()
    assert len(found.occupied) > 0
    assert search_voxels(top, sheet("F2", [(50, 0, 0), (50, 1, 0), (50, 1, 1), (50, 0, 1)])) is None


def test_the_size_that_is_chosen_is_never_refused(monkeypatch):
    """Large models have more faces than voxels may be; flat ones round an axis up."""
    monkeypatch.setattr("geosurf.arrangement.candidates._MOST_VOXELS", 1000)
    rng = np.random.default_rng(3)
    for height in (1e-3, 1.0, 30.0, 1000.0):
        low = rng.random((5000, 3)) * (1000.0, 1000.0, height)
        boxes = np.concatenate([low, low + 1e-4], axis=1)
        grid = fit_voxels(boxes, boxes)
        assert 100 < np.prod(grid.shape) <= 1000
