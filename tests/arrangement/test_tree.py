"""Trees of boxes: no pair is missed, none comes twice, results are the voxels' to the byte."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf import TriSurface, rebuild_surfaces
from geosurf.arrangement.search import find_contacts
from geosurf.arrangement.tree import candidate_pairs, pairs_of_some, tree_of
from geosurf.errors import SurfaceError
from geosurf.kernels.lattices.lattice_corners import build_list_tree, survey_list
from geosurf.kernels.search.voxels import triangle_boxes
from geosurf.model import Lattice
from tests.strategies import faulted_worlds, grid, sheet, soup, soups

BYTES = ("local", "triangles", "surface_of_triangle", "parent_of_triangle", "patch_of_triangle")


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
    a, b = (triangle_boxes(s.vertices, s.triangles) for s in (one, two))
    near = (a[:, None, :3] <= b[None, :, 3:]).all(axis=2)
    near &= (b[None, :, :3] <= a[:, None, 3:]).all(axis=2)
    return {tuple(row) for row in rows.tolist()}, {tuple(p) for p in np.argwhere(near).tolist()}


@settings(max_examples=60, deadline=None)
@given(soups(most=12))
def test_no_contact_is_missed(surfaces):
    one, two = surfaces
    touching, near = meeting(one, two)
    assert touching <= pairs_of(one, two) <= near


@settings(max_examples=30, deadline=None)
@given(soups(most=12))
def test_a_surface_with_itself(surfaces):
    one = surfaces[0]
    touching, near = meeting(one, one, same=True)
    found = pairs_of(one, one, same=True)
    assert touching <= found <= near
    assert all(a < b for a, b in found)


@settings(max_examples=30, deadline=None)
@given(soups(most=12), st.integers(0, 2**12 - 1))
def test_some_triangles_of_a_surface_with_all_of_it(surfaces, bits):
    one = surfaces[0]
    some = np.array([bits >> k & 1 == 1 for k in range(one.n_triangle)])
    touching, near = meeting(one, one, same=True)
    rows, cost = pairs_of_some(one, tree_of(one), some)
    found = {tuple(pair) for pair in rows.tolist()}
    assert cost["pairs"] == len(found) == len(rows)
    assert {(a, b) for a, b in touching if some[a] or some[b]} <= found <= near
    assert all(a < b and (some[a] or some[b]) for a, b in found)


@settings(max_examples=25, deadline=None)
@given(faulted_worlds())
def test_trees_and_voxels_give_the_same_bytes(world):
    one = rebuild_surfaces(world, method="tree")
    two = rebuild_surfaces(world, method="voxels")
    for name in BYTES:
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()


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


def test_the_tree_of_a_grid_is_that_of_its_survey(rng):
    """Whatever asks, and however often: no copy, and none for another diagonal."""
    lattice = Lattice(np.arange(50.0), np.arange(40.0), rng.normal(size=(40, 50)))
    nodes = lattice.survey.nodes
    top = TriSurface("Top", "horizon", lattice=lattice)
    twin = TriSurface("Top", "horizon", lattice=lattice.turned_as(not lattice.rising, None))
    assert tree_of(top) is tree_of(top)
    assert tree_of(top).nodes is tree_of(twin).nodes is nodes


def test_a_huge_flat_face_reaches_only_what_its_plane_passes(rng):
    top = grid("Top", rng.uniform(0, 1, (65, 65)))
    fault = sheet("F1", [(10.3, -1, -40), (10.3, 65, -40), (55.1, 65, 40), (55.1, -1, 40)])
    by_voxels = find_contacts([top, fault], method="voxels").cost
    by_tree = find_contacts([top, fault], method="tree").cost
    assert by_tree["pairs_meeting"] == by_voxels["pairs_meeting"] > 60
    assert by_tree["pairs_tested"] < by_voxels["pairs_tested"] / 10


def test_a_fault_of_one_cell_reaches_no_more_than_its_two_triangles(rng):
    axis = np.arange(129.0)
    z = Lattice(axis, axis, rng.uniform(0, 1, (129, 129)))
    top = TriSurface("Top", "horizon", lattice=z)
    nodes = np.array([[[10.3, -1, -40], [60.3, 130, -40]], [[55.1, -1, 40], [99.1, 130, 40.0]]])
    cell = TriSurface("F1", "fault", lattice=Lattice(*np.moveaxis(nodes, 2, 0), True, False))
    pair = TriSurface("F1", "fault", cell.vertices, cell.triangles)
    costs = [find_contacts([top, fault]).cost for fault in (cell, pair)]
    assert costs[0]["pairs_tested"] == costs[1]["pairs_tested"] > 100
    assert costs[0]["nodes"] <= 2 * costs[1]["nodes"]


@pytest.mark.parametrize("n", [1, 7, 8, 9, 64, 65, 513])
def test_every_triangle_is_in_its_leaf_and_every_node_in_its_parent(rng, n):
    x = rng.integers(0, 50, (3 * n, 3)).astype(float)
    t = rng.permutation(3 * n).reshape(-1, 3)
    boxes, codes, _, _ = survey_list(x, t)
    np.testing.assert_array_equal(boxes, triangle_boxes(x, t))
    order, nodes, levels = build_list_tree(boxes, codes)
    np.testing.assert_array_equal(order, np.argsort(codes, kind="stable"))
    assert levels[-1].tolist() == [len(nodes) - 1, 1, 1]
    for k, row in enumerate(order):
        assert (nodes[k // 8, :3] <= boxes[row, :3]).all()
        assert (nodes[k // 8, 3:] >= boxes[row, 3:]).all()
    np.testing.assert_array_equal(nodes[-1], [*boxes[:, :3].min(0), *boxes[:, 3:].max(0)])
