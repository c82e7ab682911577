"""Fault polygons and other lines of a model as files for mapping."""

from __future__ import annotations

import csv

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import OutputError


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.graben(n=5)
    return gs.Scene(world.horizons, world.faults, world.box)


def rings_of(lines):
    points = np.stack([lines[axis].values for axis in ("easting", "northing", "elevation")], axis=1)
    return np.split(points, np.cumsum(lines["count"].values)[:-1])


def test_fault_polygons_come_back_from_pol_and_csv(scene, tmp_path):
    lines = scene.fault_polygons("Top")
    for name in ("a.pol", "a.csv"):
        written = gs.write(lines, tmp_path / name)
        found = gs.read_polygons(written[0], positive="up")
        assert len(found) == lines.sizes["line"] == 2
        for ring, part in zip(found, rings_of(lines), strict=True):
            np.testing.assert_array_equal(ring, np.concatenate([part, part[:1]]))
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {(row["POLY_ID"], row["FAULT"]) for row in rows} == {("1", "F1"), ("2", "F2")}
    assert set(rows[0]) == {"X", "Y", "Z", "POLY_ID", "FAULT", "PART", "MAP_AREA", "KIND"}


def test_what_is_no_file_says_what_is(scene, tmp_path):
    with pytest.raises(
        OutputError, match=r"suffixes .epc\. Or write its scene.units, scene.curves or"
    ):
        gs.write(scene, tmp_path / "a.vtm")
    world = gs.synthetic.torn("normal", n=21)
    sheet = gs.tear_horizon(world.horizons["Top"], world.faults, name="Top")
    with pytest.raises(
        OutputError, match=r"write an object of type Sheet;.*write scene.patches.surface\(name\)"
    ):
        gs.write(sheet, tmp_path / "a.ts")
