"""Contacts from an earlier arrangement are those of a search of all pairs, to the byte."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest

from geosurf.arrangement import KnownPairs, find_changed_contacts, find_contacts
from geosurf.errors import GeosurfError
from geosurf.rebuild.patches import patches_from
from geosurf.triangulate import build_walls
from tests.strategies import BOX, grid, sheet

ARRAYS = ("x", "t", "surface_of_face", "key_of_face", "rows", "near", "ids", "e", "d", "records")
ORIGIN = np.zeros(3)
OPTIONS = {"origin": ORIGIN, "voxel_size": None, "self_intersections": False}


def assert_same(one, two):
    for name in ARRAYS:
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes(), name
    assert one.m[:6].tolist() == two.m[:6].tolist()
    assert one.slip == two.slip
    assert sorted(one.options["pairs"]) == two.options["pairs"]
    for (a, b), (c, d) in zip(one.nodes, two.nodes, strict=True):
        assert a.tobytes() + b.tobytes() == c.tobytes() + d.tobytes()


FINE = 1 / 512


def surface_of(rng, kind, name, step):
    """A horizon or a fault on multiples of a step: on large steps points and edges coincide.

    On fine ones few do, since heights and places of faults are any multiples; 0 is any number.
    """
    if kind == "horizon":
        level = int(rng.integers(0, 5))
        relief = rng.normal(0, 0.6, (7, 7))
        if step:
            most = 6 if step > FINE else 600
            relief = rng.integers(-most, most + 1, (7, 7)) * step
        return grid(name, level + relief, corner=(-1.0, -1.0))
    off = rng.normal(0, 0.1, 2)
    if step:
        off = rng.integers(-60, 61, 2) * step if step <= FINE else 0.0
    x, shift = rng.choice(9, 2, replace=False) / 2.0 + off
    low, high = sorted(rng.choice([-5.0, 0.0, 2.0, 4.0, 9.0], 2, replace=False))
    return sheet(name, [(x, -1, low), (x, 5, low), (shift, 5, high), (shift, -1, high)])


@pytest.mark.parametrize("step", [0.0, FINE, 1 / 8, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_contacts_of_a_changed_scene_are_those_of_a_new_one(seed, step):
    rng = np.random.default_rng([84, seed, int(8 * step)])
    kinds = ["horizon"] * 3 + ["fault"] * 4
    scene = [surface_of(rng, kind, f"S{k}", step) for k, kind in enumerate(kinds)]
    walls = build_walls(BOX, None)
    stored, n_carried = {}, 0
    for k in range(12):
        if k % 5 == 4:  # one surface goes, another one moves or comes back
            scene[-1] = None
        elif k:
            at = int(rng.integers(len(scene)))
            scene[at] = surface_of(rng, kinds[at], f"S{at}", step)
        surfaces = [one for one in scene if one is not None] + walls
        keys = [(one.name, one.vertices.tobytes()) for one in surfaces]
        known = KnownPairs(stored.get, stored.__setitem__, keys)
        found = find_changed_contacts(surfaces, known, **OPTIONS)
        assert_same(found, find_contacts(surfaces, **OPTIONS))
        if found.carried is not None:
            n_carried += 1
            assert not found.carried.same.changed.all()
        with suppress(GeosurfError):
            patches_from(found, known)
    # large steps bring points of several pairs to one place, and then all pairs are searched
    assert n_carried >= 3 or step > FINE
