"""Horizons of one survey: 2-D coordinates are read and held once, and results do not show it."""

from dataclasses import fields

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.conventions import rising_diagonal
from geosurf.model import Lattice


def coordinates(rng, kind):
    """Eastings and northings: rotated, bent or folded, turned either way, or with a hole."""
    n_row, n_col = rng.integers(2, 90, 2)
    i, j = np.meshgrid(np.arange(n_row), np.arange(n_col), indexing="ij")
    angle, (step, other) = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(5.0, 60.0, 2)
    u, v = step * j, other * i * rng.choice([-1.0, 1.0])
    if kind == "bent":
        u, v = u + 0.1 * step * np.sin(i / 3.0), v + 0.1 * other * np.cos(j / 5.0)
    if kind == "folded":
        u = u + 40.0 * step * np.sin(j)
    x = 461_000.0 + u * np.cos(angle) - v * np.sin(angle)
    y = 5_931_000.0 + u * np.sin(angle) + v * np.cos(angle)
    if kind == "hole":
        x[rng.integers(n_row), rng.integers(n_col)] = np.nan
    return x, y


def heights(rng, shape):
    z = rng.normal(-2000.0, 30.0, shape)
    z[rng.random(shape) < rng.choice([0.0, 0.1])] = np.nan
    return z


@pytest.mark.parametrize("kind", ["rotated", "bent", "folded", "hole"])
@pytest.mark.parametrize("seed", range(4))
def test_a_lattice_over_the_same_map_is_like_one_of_its_own(kind, seed):
    rng = np.random.default_rng([seed, len(kind)])
    x, y = coordinates(rng, kind)
    first = Lattice(x, y, heights(rng, x.shape), rising_diagonal(x, y))
    _ = first.survey, first.right_handed
    assert first.has_map(x.copy(), y.copy())
    z = heights(rng, x.shape)
    one, other = first.with_elevation(z), Lattice(x, y, z, first.rising)
    assert one.easting is first.easting
    for key in (part.name for part in fields(other.survey)):
        assert np.array_equal(getattr(one.survey, key), getattr(other.survey, key), equal_nan=True)
    for key in ("right_handed", "map_height", "n_triangle", "whole", "is_graph"):
        assert getattr(one, key) == getattr(other, key)
    assert np.array_equal(one.places, other.places)


def test_a_map_that_differs_in_one_bit_is_another():
    x, y = coordinates(np.random.default_rng(3), "rotated")
    first = Lattice(x, y, np.zeros(x.shape))
    moved = x.copy()
    moved[len(x) // 2, 0] = np.nextafter(moved[len(x) // 2, 0], np.inf)
    assert first.has_map(x, y)
    assert not first.has_map(moved, y)
    assert not Lattice(0.0 * x, y, x).has_map(-0.0 * x, y)


def survey_of(seed, n=3):
    """Horizons over one rotated map, as `Scene` takes them."""
    rng = np.random.default_rng(seed)
    x, y = coordinates(rng, "rotated")
    found = {}
    for k in range(n):
        coords = {"easting": (("row", "col"), x.copy()), "northing": (("row", "col"), y.copy())}
        found[f"H{k}"] = xr.DataArray(
            rng.normal(-1000.0 - 300.0 * k, 5.0, x.shape), dims=("row", "col"), coords=coords,
            attrs={"positive": "up", "units": "m"},
        )  # fmt: skip
    return found


@pytest.mark.parametrize("seed", range(3))
def test_a_scene_holds_the_map_once_and_has_the_same_bytes(seed):
    horizons = survey_of(seed)
    scene = gs.Scene(horizons)
    alone = {name: gs.triangulate_horizon(one, name=name) for name, one in horizons.items()}
    other = gs.Scene(alone)
    lattices = [scene.surface(name).lattice for name in horizons]
    assert all(one.easting is lattices[0].easting for one in lattices)
    assert scene.aoi.tobytes() == other.aoi.tobytes()
    assert scene.patches.vertices.tobytes() == other.patches.vertices.tobytes()
    assert scene.patches.triangles.tobytes() == other.patches.triangles.tobytes()

    # another horizon of the survey refers to the map as well; one off it has its own
    before, deeper = scene.volumes.copy(deep=True), horizons["H1"] - 20.0
    deeper.attrs = horizons["H1"].attrs
    beside = deeper.assign_coords(easting=deeper.easting + 0.25)
    moved = scene.replace(horizons={"H1": deeper, "H2": beside})
    assert moved.surface("H1").lattice.easting is lattices[0].easting
    assert moved.surface("H2").lattice.easting[0, 0] == lattices[0].easting[0, 0] + 0.25

    # what the user does to the arrays afterwards changes nothing
    for one in horizons.values():
        one.values[:] = 0.0
        one.coords["easting"].values[:] = 0.0
    assert scene.volumes.equals(before)
    assert np.abs(lattices[0].easting).min() > 1.0
