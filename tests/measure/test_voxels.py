"""Voxels that no surface meets: every point gets the unit that a search finds for it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import GeometryError
from geosurf.kernels.location.voxel_units import OPEN
from geosurf.measure import sample, voxels
from geosurf.measure.locate import locator_of
from tests.measure.test_sample import corners_and_middles, gridded_worlds
from tests.strategies import faulted_worlds

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
SHAPES = st.tuples(*[st.integers(1, 9)] * 3)


def on_borders(found, rng, n):
    """Points on the borders of voxels and one step next to them, some of them far outside."""
    cells = rng.integers(-2, found.shape + 3, (n, 3))
    places = found.grid[:3] + cells / found.grid[3:]
    return places + rng.integers(-1, 2, (n, 3)) * np.maximum(np.spacing(places), 2.0**-50)


@st.composite
def models(draw):
    """Units of a small world of triangles or of grids."""
    try:
        if draw(st.booleans()):
            return draw(gridded_worlds()).units
        return gs.carve_units(gs.rebuild_surfaces(draw(faulted_worlds())))
    except GeometryError:
        reject()


@settings(max_examples=40, deadline=None)
@given(models(), SHAPES, st.integers(0, 2**32 - 1))
def test_law_points_have_the_units_that_a_search_finds(units, shape, seed):
    rng = np.random.default_rng(seed)
    before, voxels.SHAPE = voxels.SHAPE, np.array(shape)
    try:
        locator = locator_of(units)
        found = locator.voxels
    finally:
        voxels.SHAPE = before
    local = np.concatenate([corners_and_middles(units, rng, 150), on_borders(found, rng, 150)])
    points = local + locator.origin
    assert locator.find(points, found).tolist() == locator.find(points).tolist()


def test_most_voxels_of_a_model_are_in_one_unit_and_many_points_use_them(monkeypatch):
    world = gs.synthetic.faulted_reservoir(n=41)
    scene = gs.Scene(world.horizons, world.faults, world.box)
    low, high = np.reshape(world.box, (3, 2)).T
    points = low + np.random.default_rng(1).random((20_000, 3)) * (high - low)
    few = scene.sample(points, codes=True)
    made = []
    monkeypatch.setattr(sample, "MANY", 1000)
    monkeypatch.setattr(voxels, "SHAPE", np.array([64, 64, 64]))
    make = voxels.voxels_of
    monkeypatch.setattr(
        "geosurf.measure.locate.voxels_of", lambda *of: made.append(make(*of)) or made[-1]
    )
    many = scene.sample(points, codes=True)
    assert many.identical(few)
    found, others = made[0].find(points, locator_of(scene.units).origin)
    assert len(others) < 0.2 * len(points)
    assert set(np.unique(found)) == {OPEN, *range(len(scene.units))}
    assert scene.sample(points, codes=True).identical(few)
    assert len(made) == 1
