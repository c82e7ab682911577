"""Large grids are read in threads: surfaces, warnings and errors are those of one thread."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import xarray as xr

from geosurf import Scene
from geosurf.errors import HorizonError
from geosurf.scene import surfaces

BOX = (100.0, 900.0, 100.0, 900.0, -700.0, 100.0)


def grid(level, spike=0.0):
    """A grid of nodes 50 m apart; a spike is warned of, a mark of absent values refused."""
    at = np.arange(21) * 50.0
    z = level + 5.0 * np.sin(at / 300.0)[:, None] + 5.0 * np.cos(at / 200.0)
    z[3, 4] += spike
    there = {"northing": at, "easting": at}
    units = {"positive": "up", "units": "m"}
    return xr.DataArray(z, there, ("northing", "easting"), attrs=units)


def built(monkeypatch, n_thread, horizons):
    """Volumes, steps and warnings of a scene that is read in so many threads."""
    monkeypatch.setenv("GEOSURF_THREADS", str(n_thread))
    monkeypatch.setattr(surfaces, "_LARGE", 0)
    scene = Scene(horizons, {}, BOX)
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        volumes = scene.volumes.values.tolist()
    steps = [(step.stage, step.subject, step.outcome) for step in scene.steps]
    return volumes, steps, scene.warnings


def test_surfaces_steps_and_warnings_are_those_of_one_thread(monkeypatch):
    horizons = {"Top": grid(-100.0), "Middle": grid(-300.0, 150.0), "Base": grid(-500.0)}
    one, two = (built(monkeypatch, n, horizons) for n in (1, 2))
    assert one == two
    assert [note.subject for note in one[2]] == ["Middle"]


def test_a_refused_grid_is_refused_in_its_turn(monkeypatch):
    horizons = {"Top": grid(-100.0), "Middle": grid(-300.0, 1e30), "Base": grid(-500.0, 1e30)}
    found = []
    for n in (1, 2):
        with pytest.raises(HorizonError) as caught:
            built(monkeypatch, n, horizons)
        found.append(str(caught.value))
    assert found[0] == found[1]
    assert "Middle" in found[0]


def test_a_grid_that_is_changed_afterwards_does_not_change_the_scene(monkeypatch):
    monkeypatch.setenv("GEOSURF_THREADS", "2")
    monkeypatch.setattr(surfaces, "_LARGE", 0)
    horizons = {"Top": grid(-100.0), "Base": grid(-500.0)}
    scene = Scene(horizons, {}, BOX)
    assert scene.patches is not None
    horizons["Top"] += 50.0
    assert float(scene.surface("Top").vertices[:, 2].max()) < -80.0
