"""Segments -> curves: one order for all, and a way past the search for overlaps that is safe."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from geosurf import Scene, synthetic
from geosurf.contact.search import find_contacts
from geosurf.intersect import intersect_surfaces
from geosurf.intersect.collinear import split_overlaps
from geosurf.intersect.link import (
    are_plain,
    line_contacts,
    pairs_of_rows,
    pairs_with_areas,
    touching_points,
)
from geosurf.kernels.linking import break_ties, rank_places, sort_segments
from tests import laws
from tests.rebuild.worlds import boxed_world, world
from tests.strategies import sheet, soups


@pytest.mark.parametrize("most", [1, 2, 5, 1000])
def test_places_are_ordered_by_all_their_coordinates(rng, most):
    x = rng.integers(0, most, (400, 3)) * 0.7
    order = np.argsort(x[:, 0])
    break_ties(x, order)
    np.testing.assert_array_equal(x[order], x[np.lexsort(x.T[::-1])])
    rank, first = rank_places(x, order)
    places, expected = np.unique(x, axis=0, return_inverse=True)
    np.testing.assert_array_equal(rank, expected.reshape(-1))
    np.testing.assert_array_equal(x[first], places)


@pytest.mark.parametrize("n_point", [2, 7, 90])
def test_segments_come_once_by_pair_and_points(rng, n_point):
    segments = rng.integers(0, n_point, (500, 2))
    pair = rng.integers(0, 3, 500)
    found, of = sort_segments(segments, pair, n_point, 3)
    expected = np.unique(np.column_stack([pair, np.sort(segments, axis=1)]), axis=0)
    np.testing.assert_array_equal(np.column_stack([of, found]), expected)


@settings(max_examples=50, deadline=None)
@given(soups(most=14))
def test_what_is_plain_has_no_overlaps(surfaces):
    contacts = find_contacts(surfaces)
    pairs = pairs_of_rows(contacts)
    if not are_plain(contacts, pairs):
        return
    segments, of = line_contacts(contacts, pairs)
    assert len(segments) == len(contacts.rows)
    assert len(touching_points(contacts, pairs)) == 0
    assert len(pairs_with_areas(contacts, pairs)) == 0
    after, _ = split_overlaps(contacts, segments, of, np.empty((0, 3), dtype=np.int64))
    np.testing.assert_array_equal(after, segments)


def surfaces_of(name):
    world = getattr(synthetic, name)(n=17)
    return Scene(world.horizons, world.faults, world.box).surfaces


PLAIN = {
    surfaces_of: ("waves", "hills", "graben", "faulted", "torn"),
    world: (12, 31, 41, 46, 51),
    boxed_world: (0, 16, 18, 21, 41, 49),
}


@pytest.mark.parametrize(
    ("make", "name"), [(make, name) for make, names in PLAIN.items() for name in names]
)
def test_both_ways_give_the_same_bytes(make, name):
    surfaces, ways = make(name), []

    def watched(*arguments):
        ways.append(are_plain(*arguments))
        return ways[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("geosurf.intersect.are_plain", watched)
        one = intersect_surfaces(surfaces)
        patch.setattr("geosurf.intersect.are_plain", lambda *_: False)
        two = intersect_surfaces(surfaces)
    assert ways == [True]
    assert one.n_curve > 0
    assert laws.curve_bytes(one) == laws.curve_bytes(two)


def test_a_wall_whose_triangles_overlap_in_a_line_is_not_plain():
    flat = sheet("Top", [(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)])
    corners = [(1, 4, -1), (5, 4, -1), (3, 4, 2), (2, 4, -1.5), (7, 4, -1), (4, 4, 2)]
    wall = type(flat)("F1", "fault", corners, [[0, 1, 2], [3, 4, 5]])
    contacts = find_contacts([flat, wall])
    assert not are_plain(contacts, pairs_of_rows(contacts))
