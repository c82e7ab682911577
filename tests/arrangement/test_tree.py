"""Trees of boxes: no pair is missed, none comes twice, results are the voxels' to the byte."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from geosurf import rebuild_surfaces
from geosurf.arrangement.search import find_contacts
from geosurf.arrangement.tree import candidate_pairs, tree_of
from geosurf.errors import SurfaceError
from geosurf.kernels.search.tree import triangle_boxes
from tests.strategies import faulted_worlds, soup, soups

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


@given(soups(most=12))
def test_no_contact_is_missed(surfaces):
    one, two = surfaces
    touching, near = meeting(one, two)
    assert touching <= pairs_of(one, two) <= near


@settings(max_examples=30)
@given(soups(most=12))
def test_a_surface_with_itself(surfaces):
    one = surfaces[0]
    touching, near = meeting(one, one, same=True)
    found = pairs_of(one, one, same=True)
    assert touching <= found <= near
    assert all(a < b for a, b in found)


@settings(max_examples=25)
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
