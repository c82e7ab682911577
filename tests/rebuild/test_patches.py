"""Surfaces split along their curves: nothing lost, nothing moved, nothing crossing."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf import TriSurface, build_walls, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.errors import InputError
from tests import laws, oracles
from tests.messages import refused
from tests.strategies import faulted_worlds, grid, relief, sheet, shuffled, soups

seeds = st.integers(0, 2**32 - 1)


def assert_meets_in_corners_and_edges(patches):
    """No two triangles have anything in common but corners and edges: all pairs, rational."""
    corners = [tuple(oracles.rational(p)) for p in patches.local[patches.triangles]]
    distinct = {frozenset(c): c for c in corners}
    low = {c: np.min([list(map(float, p)) for p in t], axis=0) for c, t in distinct.items()}
    high = {c: np.max([list(map(float, p)) for p in t], axis=0) for c, t in distinct.items()}
    for one, two in itertools.combinations(distinct, 2):
        if (low[one] > high[two]).any() or (low[two] > high[one]).any():
            continue
        met = oracles.meet_triangles(distinct[one], distinct[two])
        assert set(met) == one & two, (distinct[one], distinct[two])


def assert_true(surfaces, exact=True):
    patches = rebuild_surfaces(surfaces)
    laws.assert_on_parents(patches)
    laws.assert_shares_vertices(patches)
    assert certify(patches).ok
    if exact:
        assert_meets_in_corners_and_edges(patches)
    return patches


# two reliefs meet in points with denominators, whose rounded triangles may still not cross
@settings(max_examples=8)
@given(relief(size=2, holes=False), relief("Base", size=2))
def test_two_reliefs(one, two):
    assert_true([one, two])


@settings(max_examples=10)
@given(relief(size=2), st.integers(-1, 2), st.integers(0, 1))
def test_relief_and_fault(one, at, lean):
    corners = [(at, -1, -1), (at + 4 * lean, 3, -1), (at + 4 * lean, 3, 3), (at, -1, 3)]
    assert_true([one, sheet("F1", corners)])


@given(soups(most=2, extent=2))
def test_lattice_soups(pair):
    """Triangles that meet others of their own surface, too."""
    patches = rebuild_surfaces(pair, self_intersections=True)
    laws.assert_on_parents(patches)
    laws.assert_shares_vertices(patches)
    assert_meets_in_corners_and_edges(patches)


@given(faulted_worlds())
def test_faulted_worlds(surfaces):
    assert_true(surfaces, exact=False)


def test_untouched_triangles_stay_as_they_are():
    top = grid("Top", np.zeros((9, 9)))
    small = sheet("F1", [(4.5, 4.25, -1), (4.75, 4.25, -1), (4.75, 4.25, 1), (4.5, 4.25, 1)])
    patches = assert_true([top, small], exact=False)
    mine = patches.surface_of_triangle == 0
    parent = patches.parent_of_triangle[mine]
    children = np.bincount(parent, minlength=top.n_triangle)
    whole = np.flatnonzero(children == 1)
    assert len(whole) == top.n_triangle - 1
    rows = np.flatnonzero(mine)[np.isin(parent, whole)]
    np.testing.assert_array_equal(
        patches.vertices[patches.triangles[rows]], top.vertices[top.triangles[whole]]
    )


def test_taking_apart():
    top = grid("Top", np.zeros((5, 5)))
    wall = sheet("F1", [(1.5, 0, -1), (1.5, 4, -1), (1.5, 4, 1), (1.5, 0, 1)])
    patches = assert_true([top, wall], exact=False)
    assert patches.names == ("Top", "F1")
    assert patches.n_patch == 4
    parts = [patches.patch(i) for i in range(4)]
    assert sum(p.n_triangle for p in parts) == patches.n_triangle
    assert [p.role for p in parts] == ["horizon", "horizon", "fault", "fault"]
    west, east = sorted(parts[:2], key=lambda p: p.bounds[0])
    assert west.bounds[:4] == (0.0, 1.5, 0.0, 4.0)
    assert east.bounds[:4] == (1.5, 4.0, 0.0, 4.0)
    assert patches.surface("Top").n_triangle == patches.surface(0).n_triangle
    with pytest.raises(InputError, match=r"no surface 'F2'\. The surfaces are \['Top', 'F1'\]"):
        patches.surface("F2")
    refused(InputError, r"there is no surface 2; rows are 0 to 1", patches.surface, 2)
    refused(InputError, r"there is no patch 4; patches are 0 to 3", patches.patch, 4)


# ------------------------------------------------------------------ same answer
@given(relief(), relief("Base", holes=False), st.integers(0, 2), seeds)
def test_shuffles_change_nothing(one, two, at, seed):
    wall = sheet("F1", [(at, -1, -1), (at + 2, 4, -1), (at + 2, 4, 3), (at, -1, 3)])
    surfaces = [one, two, wall]
    straight = rebuild_surfaces(surfaces)
    rng = np.random.default_rng(seed)
    other = [shuffled(surfaces[i], rng) for i in rng.permutation(3)]
    laws.assert_same_patches(straight, rebuild_surfaces(other))


# ----------------------------------------------------------- an independent check


def test_slivers_that_a_coarser_step_closes_go():
    """Two corners an ulp apart come together when the inputs move: not an area lost, a sliver shut.

    Truncated faults have them: where they met a diagonal of the box before, and its edge.
    """
    below = np.nextafter(-1500.0, -2000.0)
    across = [[1099.14, 900, -1480], [1106.349557522124, 885.0796460176992, -1500],
              [1108.14, 900, -1500], [1117.14, 900, -1520]]  # fmt: skip
    fan = [[2960, 1494, -1520], [3000, 1489, -1520], [3000, 1500, below], [2960, 1505, -1500],
           [3000, 1500, -1500]]  # fmt: skip
    one = TriSurface("F1", "fault", across, [[0, 1, 2], [1, 3, 2]])
    two = TriSurface("F2", "fault", fan, [[0, 1, 2], [0, 2, 3], [3, 2, 4]])
    patches = rebuild_surfaces([one, two, *build_walls((0, 3000, 0, 2400, -2500, -1500))])
    assert 0 < patches.report["largest_move"] < 1e-8
    assert patches.sources[1].n_triangle == 2  # the sliver is gone, and its neighbours meet
    assert patches.surface("F1").n_triangle >= 2
    assert certify(patches).ok
