"""Trees of boxes: no pair is missed, none comes twice, results are the voxels' to the byte."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf.arrangement import KnownPairs, find_contacts, search_voxels
from geosurf.arrangement.tree_pairs import candidate_pairs
from geosurf.arrangement.trees import tree_of
from geosurf.arrangement.voxels import fit_voxels, pairs_by_voxels
from geosurf.errors import InputError, SurfaceError
from geosurf.kernels.search.tree import triangle_boxes
from tests.strategies import grid, relief, sheet, soup, soups


def pairs_of(one, two, same=False):
    pairs, cost = candidate_pairs(tree_of(one), tree_of(two), same=same)
    assert cost["pairs"] == len(pairs)
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    return {tuple(pair) for pair in pairs.tolist()}


def meeting(one, two, same=False):
    """Pairs in contact, as found through voxels, and all pairs whose boxes meet."""
    surfaces = (one,) if same else (one, two)
    found = find_contacts(surfaces, method="voxels", self_intersections=same)
    rows = found.key_of_face[found.rows[:, :2]]
    near = all_pairs(*(triangle_boxes(s.vertices, s.triangles) for s in (one, two)))
    return {tuple(row) for row in rows.tolist()}, {tuple(p) for p in near.tolist()}


@given(soups(most=12))
def test_no_contact_is_missed(surfaces):
    one, two = surfaces
    touching, near = meeting(one, two)
    assert touching <= pairs_of(one, two) <= near


@given(soups(most=12))
def test_a_surface_with_itself(surfaces):
    one = surfaces[0]
    touching, near = meeting(one, one, same=True)
    found = pairs_of(one, one, same=True)
    assert touching <= found <= near
    assert all(a < b for a, b in found)


@pytest.mark.parametrize("power", [-356, -358, -359, -361, -1000])
def test_sizes_whose_products_underflow_are_refused(power):
    one, two = (soup(name, np.eye(3)[None] * 2.0**power) for name in "AB")
    with pytest.raises(SurfaceError, match=r"sizes from 1e-74 to 1\.2e\+18 m"):
        meeting(one, two)


@pytest.mark.parametrize("power", [-200, -230, -240, -243])
def test_no_pair_is_lost_where_products_are_near_to_underflow(power):
    """Heights of 1e-324 over bounds of 0 once told that triangles are beside each other."""
    for seed in range(25):
        corners = np.random.default_rng(seed).integers(0, 4, (8, 3, 3)).astype(float)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        corners = corners[normal.any(axis=1)] * 2.0**power
        one, two = soup("A", corners[::2]), soup("B", corners[1::2])
        touching, _ = meeting(one, two)
        assert touching <= pairs_of(one, two)


# ---- Candidate pairs against comparing all boxes with all boxes.
SIZES = (None, 0.3, 1.0, 1.7, 100.0)


def all_pairs(a, b, same=False):
    meets = (a[:, None, :3] <= b[None, :, 3:]).all(axis=2)
    meets &= (b[None, :, :3] <= a[:, None, 3:]).all(axis=2)
    pairs = np.argwhere(meets)
    return pairs[pairs[:, 0] < pairs[:, 1]] if same else pairs


def assert_all_once(a, b, size, same=False):
    pairs, cost = pairs_by_voxels(a, b, size=size, same=same)
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
def test_a_surface_with_itself_broad(a, size):
    assert_all_once(a, a, size, same=True)


def test_voxels_that_would_fill_the_memory_are_refused():
    a = np.array([[0.0, 0, 0, 1000, 1000, 1000]])
    with pytest.raises(InputError, match=r"voxel_size = 0\.001 m gives 1e\+18.*larger voxel_size"):
        fit_voxels(a, a, 1e-3)


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
    monkeypatch.setattr("geosurf.arrangement.voxels._MOST_VOXELS", 1000)
    rng = np.random.default_rng(3)
    for height in (1e-3, 1.0, 30.0, 1000.0):
        low = rng.random((5000, 3)) * (1000.0, 1000.0, height)
        boxes = np.concatenate([low, low + 1e-4], axis=1)
        assert 100 < np.prod(fit_voxels(boxes, boxes).shape) <= 1000


# ---- A search that takes pairs of surfaces from an earlier one finds the same, to the byte.
ARRAYS = ("x", "t", "surface_of_face", "key_of_face", "rows", "near", "ids", "e", "d", "records")
ORIGIN = np.zeros(3)


def search(surfaces, stored=None, **options):
    """Contacts, with what is known in a dictionary."""
    known = None
    if stored is not None:
        known = KnownPairs(stored.get, stored.__setitem__, [s.name for s in surfaces])
    return find_contacts(surfaces, origin=ORIGIN, known=known, **options)


def assert_same(one, two):
    for name in ARRAYS:
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes(), name
    assert one.cost == two.cost
    for (a, b), (c, d) in zip(one.nodes, two.nodes, strict=True):
        assert a.tobytes() + b.tobytes() == c.tobytes() + d.tobytes()


@settings(max_examples=12)
@given(
    soups(names=("A", "B", "C", "D")),
    relief("R"),
    relief("S", holes=False),
    st.permutations(range(6)),
)
def test_pairs_of_other_searches_are_pairs_of_this_one(parts, one, two, order):
    surfaces = [*parts, one, two]
    stored = {}

    # three searches of some, then all of them in another order, and once more
    for some in (surfaces[:3], surfaces[2:], surfaces[::2]):
        search(some, stored)
    n_before = len(stored)
    mixed = [surfaces[k] for k in order]
    for self_intersections in (False, True, False):
        found = search(mixed, stored, self_intersections=self_intersections)
        assert_same(found, search(mixed, self_intersections=self_intersections))
    assert len(stored) >= n_before


@pytest.mark.parametrize("voxel_size", [None, 0.75])
def test_a_far_surface_makes_rounding_coarser(voxel_size):
    """Near pairs depend on the largest coordinate of all candidates."""
    rng = np.random.default_rng(6)
    near = [grid(name, rng.normal(size=(6, 6))) for name in "AB"]
    near.append(sheet("F", [(2.3, -1, -9), (2.6, 7, -9), (2.6, 7, 9), (2.3, -1, 9)], (2, 3)))
    corners = np.array([[[1e6, 0, 0], [1e6, 1, 0], [1e6, 0, 1]]])
    turn = np.array([[-0.5, 0, 0.25], [0.5, 0, 0], [0, 0, 0]])
    far = [soup("far", corners), soup("far too", corners + turn)]
    stored = {}
    slips = set()
    for surfaces in (near, [*near, *far], near):
        options = {"voxel_size": voxel_size}
        assert_same(search(surfaces, stored, **options), search(surfaces, **options))
        slips |= {one.slip for one in stored.values()}
    assert len(slips) == 2
