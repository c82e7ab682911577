"""Vertical lines through torn horizons: grids by coordinates, as all triangles of units have it."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.measure import thickness as unit_columns
from geosurf.measure.thickness import passages


@pytest.mark.parametrize("kind", ["reverse", "X"])
def test_lines_pass_what_listed_units_have(kind, monkeypatch):
    world = gs.synthetic.torn(kind, n=41)
    scene = gs.Scene(world.horizons, world.faults, world.box, tear=True)
    units, rng = scene.units, np.random.default_rng(3)
    west, east, south, north = scene.box[:4]

    # also on nodes and on edges of cells
    axis = world.horizons["Top"].easting.values
    feet = rng.uniform([west, south], [east, north], (400, 2))
    feet[:200, 0] = rng.choice(axis[1:-1], 200)
    feet[:100, 1] = rng.choice(world.horizons["Top"].northing.values[1:-1], 100)
    middle = np.array([0.5 * (west + east), 0.5 * (south + north)])
    rows = list(range(len(units)))

    # no triangles of runs are searched
    monkeypatch.setattr(unit_columns, "_on_some", None)
    met = {}
    for some, of_units in passages(units, rows, feet, middle):
        number = np.arange(len(feet))[some]
        for u, one in enumerate(of_units):
            met[u] = sorted(
                zip(
                    number[one.foot].tolist(), one.way.tolist(), one.elevation.tolist(), strict=True
                )
            )
    assert sum(map(len, met.values())) > 2 * len(feet)
    for u, unit in enumerate(units.values()):
        one = unit_columns._of_shell(unit, feet, middle)
        listed = sorted(
            zip(one.foot.tolist(), one.way.tolist(), one.elevation.tolist(), strict=True)
        )
        assert [row[:2] for row in met[u]] == [row[:2] for row in listed]
        assert np.allclose([row[2] for row in met[u]], [row[2] for row in listed], atol=1e-9)
