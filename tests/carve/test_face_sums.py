"""Sums over faces are taken from earlier ones only where these are made of the same patches."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.carve import measures
from geosurf.carve.face_sums import FaceSums


def by_hand(earlier, of_patch, after):
    """Earlier face of each face, by comparing sets of patches."""
    before = {f: {p for p, g in enumerate(earlier) if g == f} for f in set(earlier) - {-1}}
    now = {q: p for p, q in enumerate(after) if q >= 0}
    found = []
    for f in range(max(of_patch) + 1):
        mine = {now.get(p, -1) for p, g in enumerate(of_patch) if g == f}
        found.append(next((g for g, of in before.items() if of == mine), -1))
    return found


@pytest.mark.parametrize("seed", range(30))
def test_faces_of_the_same_patches_are_the_same(seed):
    rng = np.random.default_rng(seed)
    earlier = rng.permutation([*range(5), *rng.integers(-1, 5, 6)])
    # some patches go, the others keep their order among new ones
    stay = np.flatnonzero(rng.random(len(earlier)) < 0.8)
    place = np.sort(rng.permutation(len(stay) + 2)[: len(stay)])
    after = np.full(len(earlier), -1)
    after[stay] = place
    of_patch = np.full(len(stay) + 2, -1)
    of_patch[place] = rng.permutation(5)[earlier[stay]]
    of_patch[earlier_is_outside(earlier, stay, place)] = -1
    new = np.setdiff1d(np.arange(len(of_patch)), place)
    of_patch[new] = rng.integers(0, 6, len(new))
    used = np.unique(of_patch[of_patch >= 0])
    of_patch = np.where(of_patch < 0, -1, np.searchsorted(used, of_patch))

    old = FaceSums.of(earlier, 5)
    found = FaceSums.of(of_patch, len(used), old, after)
    assert found.before.tolist() == by_hand(earlier.tolist(), of_patch.tolist(), after.tolist())


def earlier_is_outside(earlier, stay, place):
    """Patches that belonged to no face."""
    return place[earlier[stay] < 0]


def test_what_is_known_is_not_summed_again():
    old = FaceSums.of(np.array([0, 1]), 2)
    old.complete("x", np.array([True, False]), lambda of: np.array([[7.0], [9.0]]))
    new = FaceSums.of(np.array([1, 0]), 2, old, np.array([1, 0]))
    asked = []

    def run(of):
        asked.append(of.tolist())
        return np.array([[1.0], [2.0]])

    found = new.complete("x", np.ones(2, dtype=bool), run)
    assert asked == [[False, True]]  # the second face was not wanted before
    assert found.tolist() == [[7.0], [2.0]]


def test_a_moved_fault_sums_a_part_of_the_model(monkeypatch):
    world = gs.synthetic.graben(n=21)
    scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2150.0})
    fault = scene.surface("F1")
    corners = fault.vertices + np.array([20.0, 0.0, 0.0])
    moved = {"F1": gs.TriSurface("F1", "fault", corners, fault.triangles)}
    _ = scene.volumes
    asked, below = [], measures.below
    monkeypatch.setattr(
        measures, "below", lambda p, of, some, z: asked.append(some.mean()) or below(p, of, some, z)
    )
    changed = scene.replace(faults=moved)
    fresh = gs.Scene(
        world.horizons, {**world.faults, **moved}, world.box, contacts={"OWC": -2150.0}
    )
    assert changed.volumes.values.tobytes() == fresh.volumes.values.tobytes()
    assert asked[0] < 0.8 * asked[1]
