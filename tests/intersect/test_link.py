"""Segments -> curves: one order for all, and a way past the search for overlaps that is safe."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from geosurf import Scene, synthetic
from geosurf.arrangement.search import find_contacts
from geosurf.intersect import intersect_surfaces
from geosurf.intersect.link import (
    are_plain,
    line_contacts,
    pairs_of_rows,
    pairs_with_areas,
    split_overlaps,
    touching_points,
)
from tests import laws
from tests.rebuild.worlds import boxed_world, world
from tests.strategies import soups


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
