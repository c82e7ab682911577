"""Lattices with one map: what is left out never meets, results are the voxels' to the byte."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf import TriSurface, intersect_surfaces, rebuild_surfaces
from geosurf.arrangement.search import ULP, find_contacts
from geosurf.arrangement.tree import needed, pairs_of_one_map, tree_of
from geosurf.model import Lattice
from tests import laws
from tests.strategies import as_list

TURN = np.array([[3.0, -4.0], [4.0, 3.0]]) / 5.0


def horizon(name, z, *, rising=True, turned=False, corner=(0.0, 0.0)):
    """A horizon over unit cells, or over cells turned by about 53 degrees."""
    z = np.asarray(z, dtype=float)
    y, x = (np.arange(n, dtype=float) for n in z.shape)
    x, y = x + corner[0], y + corner[1]
    if turned:
        x, y = np.einsum("ij,jkl->ikl", TURN, np.stack(np.meshgrid(x, y)))
    return TriSurface(name, "horizon", lattice=Lattice(x, y, z, rising=rising))


@st.composite
def of_one_map_horizons(draw, n_row=4, n_col=4, n=2):
    """Horizons with whole heights, holes and either diagonal over one map."""
    turned = draw(st.booleans())
    made = []
    for name in "ABC"[:n]:
        z = np.array(
            draw(st.lists(st.integers(0, 2), min_size=n_row * n_col, max_size=n_row * n_col))
        )
        z = z.astype(float)
        z[draw(st.lists(st.integers(1, n_row * n_col - 1), max_size=2))] = np.nan
        surface = horizon(name, z.reshape(n_row, n_col), rising=draw(st.booleans()), turned=turned)
        if surface.n_triangle:
            made.append(surface)
    return made


def listed(one, two):
    """Pairs as listed for one map."""
    pairs, _ = pairs_of_one_map((one.lattice, two.lattice), (tree_of(one), tree_of(two)))
    found = {tuple(row) for row in pairs.tolist()}
    assert len(found) == len(pairs)
    return found


def assert_one_result(surfaces):
    """Curves and patches by trees and by voxels are the same bytes, and lists have the same curves.

    Lattices leave out the same pairs by either method; lists leave out none, so that they tell
    whether what was left out was needed.
    """
    meshes = [as_list(s) for s in surfaces]
    one, two = (intersect_surfaces(surfaces, method=m) for m in ("tree", "voxels"))
    lists = intersect_surfaces(meshes, method="voxels")
    for other in (two, lists):
        assert laws.curve_bytes(one) == laws.curve_bytes(other)
    one, two = (rebuild_surfaces(surfaces, method=m) for m in ("tree", "voxels"))
    laws.assert_same_bytes(one, two)
    lists = rebuild_surfaces(meshes, method="voxels")
    if one.report["moved_vertices"] == lists.report["moved_vertices"] == 0:
        assert laws.pieces_by_name(one) == laws.pieces_by_name(lists)


@given(of_one_map_horizons())
def test_results_are_the_voxels_to_the_byte(surfaces):
    assert_one_result(surfaces)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("holes", [0, 40])
def test_blocks_and_their_rims(rng, turned, holes):
    """More than one block of cells; holes on both sides of the seams between blocks."""
    made = []
    for name in "AB":
        z = rng.integers(0, 30, (21, 19)).astype(float)
        z[rng.integers(0, 21, holes), rng.integers(0, 19, holes)] = np.nan
        made.append(horizon(name, z, turned=turned))
    assert_one_result(made)


@settings(max_examples=40)
@given(of_one_map_horizons())
def test_the_list_has_all_that_meet_and_no_more_than_is_needed(surfaces):
    if len(surfaces) == 2:
        one, two = surfaces
        contacts = find_contacts(surfaces, method="voxels")
        meeting = contacts.key_of_face[contacts.rows[:, :2]]
        found = listed(one, two)
        assert {tuple(row) for row in meeting.tolist()} <= found
        assert needed(one.lattice, two.lattice, np.array(sorted(found)).reshape(-1, 2)).all()


@settings(max_examples=40)
@given(of_one_map_horizons())
def test_near_pairs_above_one_triangle_are_kept(surfaces):
    """What rounding could make meet stays a candidate, however little apart it is."""
    if len(surfaces) < 2:
        return
    one, two = surfaces
    z = two.lattice.elevation
    largest = max(np.abs(s.extent).max() for s in surfaces)
    lifted = TriSurface(
        "B", "horizon",
        lattice=Lattice(
            two.lattice.easting, two.lattice.northing, z + ULP * largest, rising=two.lattice.rising
        ),
    )  # fmt: skip
    by_voxels = find_contacts((one, lifted), method="voxels")
    near = by_voxels.key_of_face[by_voxels.near]
    assert {tuple(row) for row in near.tolist()} <= listed(one, lifted)
