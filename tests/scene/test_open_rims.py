"""Surfaces of other packages whose rims stop short: each is named, with the place and the gap."""

from __future__ import annotations

import ast

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import OpenUnitError

BOX = (0, 1000, 0, 1000, -2500, -500)


def sheet(z, x=(-50, 1050), y=(-50, 1050), steps=9):
    """Vertices and triangles of a level sheet."""
    xs, ys = np.meshgrid(np.linspace(*x, steps), np.linspace(*y, steps))
    rows = np.arange(steps * steps).reshape(steps, steps)
    a, b, c, d = rows[:-1, :-1], rows[:-1, 1:], rows[1:, 1:], rows[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return np.stack([xs.ravel(), ys.ravel(), np.full(xs.size, float(z))], axis=1), faces


def halves(z, gap):
    """A horizon that stops before a fault at x = 500, on both sides."""
    (v, t), (w, u) = sheet(z, (-50, 500 - gap)), sheet(z - 100, (500 + gap, 1050))
    return np.concatenate([v, w]), np.concatenate([t, u + len(v)])


def wall(y=(-60, 1060), z=(-3000, 0), steps=9):
    """A vertical fault at x = 500."""
    v, t = sheet(500, y, z, steps)
    return v[:, [2, 0, 1]], t


HORIZONS = {"Top": sheet(-1000), "Base": sheet(-1500)}


@pytest.mark.parametrize(
    ("horizon", "place", "gap"),
    [
        (halves(-1000, 5), r"\(E 495, ", "ends 5 m before fault 'F1' there"),
        (sheet(-1000, (30, 1050)), r"\(E 30, ", "ends 30 m before the west side of the model"),
    ],
)
def test_a_horizon_that_stops_short_is_named_with_its_gap(horizon, place, gap):
    scene = gs.Scene({"Top": horizon, "Base": sheet(-1500)}, {"F1": wall()}, BOX)
    with pytest.raises(OpenUnitError, match=rf"leak around horizon 'Top': .*{place}.*It {gap}"):
        _ = scene.units


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
@pytest.mark.parametrize("gap", [0.5, 12])
def test_a_fault_that_stops_short_of_a_side_is_named_with_its_gap(gap):
    scene = gs.Scene(HORIZONS, {"F1": wall((-60, 1000 - gap))}, BOX)
    (found,) = (one for one in scene.warnings if one.kind == "rim")
    assert found.subject == "F1"
    assert f"ends {gap:g} m before the north side of the model box" in found.effect
    assert np.allclose(found.place[:2], (500, 1000 - gap))
    assert [unit for unit in scene.units if "F1" in unit] == []  # units go around it
    # the remedy that it prints
    fault = scene.surface("F1")
    whole = gs.extend_fault(fault, BOX, sides="strike").surface
    again = scene.replace(faults={"F1": whole})
    assert not again.warnings
    box = ast.literal_eval(found.remedy.split("box=")[-1].removesuffix("."))
    assert 1000 - gap * 1.2 < box[3] < 1000 - gap
    assert len(scene.replace(box=box).units) == len(again.units)
    assert len(again.units) == 2 * len(scene.units)
