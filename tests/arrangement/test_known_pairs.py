"""A search that takes pairs of surfaces from an earlier one finds the same, to the byte."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf.arrangement import KnownPairs, find_contacts
from tests.strategies import grid, relief, sheet, soup, soups

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
