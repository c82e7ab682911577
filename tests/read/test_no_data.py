"""Marks of no data in wells, sticks and polygons: refused with their place, in every unit."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.conventions.checks import NO_DATA
from geosurf.errors import GeosurfError

STRONG = [mark for mark in NO_DATA if mark != 999.0]


@pytest.mark.parametrize("unit", ["m", "ft"])
@pytest.mark.parametrize("mark", [sign * mark for mark in STRONG for sign in (1, -1)])
def test_law_no_mark_becomes_a_place(tmp_path, mark, unit):
    (tmp_path / "lines.csv").write_text(f"X,Y,Z,POLY_ID\n0,0,-100,1\n10,0,{mark!r},1\n9,9,-100,1\n")
    with pytest.raises(GeosurfError, match=r"point 2 of line 1 has .* mark of no data"):
        gs.read_polygons(tmp_path / "lines.csv", positive="up", length_unit=unit)
    (tmp_path / "wells.csv").write_text(
        f"Well,X,Y,TVDSS\nA,1000,1000,-25\nA,1000,1000,500\nA,1000,1000,{mark!r}\nA,1000,1000,900\n"
    )
    with pytest.raises(GeosurfError, match=r"line 4: well 'A' has .* mark of no data"):
        gs.read_wells(tmp_path / "wells.csv", positive="down", length_unit=unit)
    scale = {"m": 1.0, "ft": 0.3048}[unit]
    stick = [[0.0, 500, -1000], [0, 520, mark * scale], [0, 560, -1600]]
    with pytest.raises(GeosurfError, match=r"point 2 of stick 1 has .* mark of no data"):
        gs.FaultSticks("F", [np.add(stick[0], [[9, 0, 0], [9, 9, -9]]), np.array(stick)])


def test_law_measured_places_are_no_marks():
    """Whole numbers, 999 m and 9999 ft among them, are depths; only 999 999 999 is none."""
    z = np.concatenate([-np.arange(0.0, 9000.0), -0.3048 * np.arange(9000.0, 10100.0)])
    z = z[z != -999.25]
    gs.FaultSticks(
        "F", [np.column_stack([0 * z, 0 * z, z]), np.column_stack([0 * z + 9, 0 * z, z])]
    )
    with pytest.raises(GeosurfError, match=r"has 999"):
        gs.FaultSticks("F", [[[0, 0, -9], [-999, -999, -999]]])


def test_a_path_longer_than_its_measured_depth_is_refused(tmp_path):
    (tmp_path / "w.csv").write_text(
        "Well,X,Y,TVDSS,MD\nA,0,0,-25,0\nA,0,0,500,525\nA,0,0,-1000,800\nA,0,0,1200,1225\n"
    )
    with pytest.raises(GeosurfError, match=r"line 4: well 'A' goes 1500 m while .* by 275 m"):
        gs.read_wells(tmp_path / "w.csv", positive="down")
