"""Segments -> curves: one order for all, and a way past the search for overlaps that is safe."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from geosurf import Scene, synthetic
from geosurf.arrangement.search import find_contacts
from geosurf.intersect import intersect_surfaces
from geosurf.intersect.link import (
    are_plain,
    line_contacts,
    pairs_of_rows,
    pairs_with_areas,
    sort_places_and_segments,
    sort_segments,
    split_overlaps,
    touching_points,
)
from tests import laws
from tests.rebuild.worlds import boxed_world, world
from tests.strategies import sheet, soups


def crowded(rng):
    """Places that lie in one bucket but for one, some alike in easting, some in northing, too."""
    x = rng.integers(0, 3, (400, 3)) * [1e-9, 1.0, 1.0]
    x[:90, 0], x[:60, 1] = 0.0, 0.0
    x[7] = 1e6
    return x


PLACES = {
    **{f"{most} values": lambda rng, most=most: rng.integers(0, most, (400, 3)) * 0.7
       for most in (1, 2, 5, 1000)},
    "crowded": crowded,
    "next to each other": lambda rng: rng.integers(0, 4, (400, 3)) * 5e-324,
    "anywhere": lambda rng: rng.normal(size=(400, 3)) * 1e9,
}  # fmt: skip


@pytest.mark.parametrize("kind", PLACES)
def test_places_in_use_are_ordered_by_all_their_coordinates(rng, kind):
    x = PLACES[kind](rng)
    segments = rng.permutation(400)[:380].reshape(-1, 2)
    pair = np.zeros(len(segments), dtype=np.int64)
    places, found, of = sort_places_and_segments(x, segments, pair)
    expected, rank = np.unique(x[segments.reshape(-1)], axis=0, return_inverse=True)
    np.testing.assert_array_equal(places, expected)
    wanted = np.unique(np.sort(rank.reshape(-1, 2), axis=1), axis=0)
    np.testing.assert_array_equal(found, wanted)
    assert of.tolist() == [0] * len(wanted)


@pytest.mark.parametrize("n_point", [2, 7, 90])
def test_segments_come_once_by_pair_and_points(rng, n_point):
    segments = rng.integers(0, n_point, (500, 2))
    pair = rng.integers(0, 3, 500)
    found, of = sort_segments(segments, pair)
    expected = np.unique(np.column_stack([pair, np.sort(segments, axis=1)]), axis=0)
    np.testing.assert_array_equal(np.column_stack([of, found]), expected)


def test_no_segments_have_no_places():
    none, x = np.empty((0, 2), dtype=np.int64), np.zeros((5, 3))
    places, segments, of = sort_places_and_segments(x, none, none[:, 0])
    assert (len(places), len(segments), len(of)) == (0, 0, 0)


@settings(max_examples=50, deadline=None)
@given(soups(most=14))
def test_what_is_plain_has_no_overlaps(surfaces):
    contacts = find_contacts(surfaces)
    pairs = pairs_of_rows(contacts)
    if not are_plain(contacts):
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
        patch.setattr("geosurf.intersect.curves.are_plain", watched)
        one = intersect_surfaces(surfaces)
        patch.setattr("geosurf.intersect.curves.are_plain", lambda *_: False)
        two = intersect_surfaces(surfaces)
    assert ways == [True]
    assert one.n_curve > 0
    assert laws.curve_bytes(one) == laws.curve_bytes(two)


def test_a_wall_whose_triangles_overlap_in_a_line_is_not_plain():
    flat = sheet("Top", [(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)])
    corners = [(1, 4, -1), (5, 4, -1), (3, 4, 2), (2, 4, -1.5), (7, 4, -1), (4, 4, 2)]
    wall = type(flat)("F1", "fault", corners, [[0, 1, 2], [3, 4, 5]])
    contacts = find_contacts([flat, wall])
    assert not are_plain(contacts)


def test_two_faces_that_meet_a_third_in_the_same_segment_are_not_plain():
    flat = sheet("Top", [(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)])
    corners = [(4, 3, -1), (8, 3, -1), (6, 3, 1), (4, 1, -1), (8, 1, -1), (6, 5, 1)]
    wall = type(flat)("F1", "fault", corners, [[0, 1, 2], [3, 4, 5]])
    for surfaces in ([flat, wall], [wall, flat]):
        contacts = find_contacts(surfaces)
        assert len(np.unique(np.sort(contacts.ids[:, :2], axis=1), axis=0)) < len(contacts.rows)
        assert not are_plain(contacts)
        assert intersect_surfaces(surfaces).n_curve == 1


def test_thousands_of_segments_in_one_face_are_plain_where_the_other_surface_is_a_graph():
    world = synthetic.hills(65, n_fault=2, shape="plane")
    surfaces = Scene(world.horizons, world.faults, world.box).surfaces
    for ordered in (surfaces, surfaces[::-1]):
        contacts = find_contacts(ordered)
        a_face = np.bincount(contacts.rows[:, :2].reshape(-1)).max()
        assert a_face > 64
        assert are_plain(contacts)
    lists = [type(s)(s.name, s.role, np.asarray(s.vertices), s.triangles) for s in surfaces]
    assert not are_plain(find_contacts(lists))
    assert laws.curve_bytes(intersect_surfaces(lists)) == laws.curve_bytes(
        intersect_surfaces(surfaces)
    )
