"""Horizons without data in a block beside a fault: refused by name, or carried on."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeometryError

CELL = 40.0
X, Y = np.arange(-200.0, 4201.0, CELL), np.arange(-200.0, 1801.0, CELL)
BOX = (0, 4000, 0, 1600, -2000, -1400)


def wall(name, east, lean=-0.5):
    """A fault that is at an easting where elevation is -1700 m."""
    corners = [
        (east + (z + 1700.0) * lean, y, z)
        for y, z in ((-900, -2300), (2900, -2300), (2900, -1200), (-900, -1200))
    ]
    return gs.TriSurface(name, "fault", np.array(corners, float), [[0, 1, 2], [0, 2, 3]])


def level_where(there):
    """A level grid with data at some eastings only."""
    z = np.where(there, -1700.0, np.nan) + 0.0 * Y[:, None]
    return xr.DataArray(z, {"northing": Y, "easting": X}, attrs={"units": "m", "positive": "up"})


@pytest.mark.parametrize("west", [True, False])
@pytest.mark.parametrize("lean", [-0.5, 0.0, 0.5])
@pytest.mark.parametrize("short", [50.0, 130.0, 500.0])
def test_data_that_end_before_a_fault_are_refused_or_carried_on(short, lean, west):
    """Both gave a sheet that ended there, and a model that leaked."""
    fault = wall("F1", 2003.0, lean)
    grid = level_where(2003.0 - short > X if west else 2003.0 + short < X)
    side = r"'F1\+'" if west == (lean <= 0) else "'F1-'"
    if lean == 0.0:
        side = "'F1[+-]'"
    with pytest.raises(
        GeometryError, match=rf"'H' has no data in the block {side}: .*fill_empty_blocks=True"
    ):
        gs.tear_horizon(grid, {"F1": fault}, name="H", trim=1.5)
    sheet = gs.tear_horizon(grid, {"F1": fault}, name="H", trim=1.5, fill_empty_blocks=True)
    assert sheet.report.filled_blocks[0]["over"] == "F1"
    if short < 100.0:
        assert len(gs.Scene({"H": sheet}, {"F1": fault}, BOX).units) == 4


def test_a_block_between_two_faults():
    faults = {"F1": wall("F1", 1203.0), "F2": wall("F2", 2803.0)}
    for there in ((X < 1150) | (X > 2850), X < 1150):
        with pytest.raises(GeometryError, match=r"'H' has no data in the block .*'F1\+'"):
            gs.tear_horizon(level_where(there), faults, name="H", trim=1.5)
        sheet = gs.tear_horizon(
            level_where(there), faults, name="H", trim=1.5, fill_empty_blocks=True
        )
        if there[-1]:
            assert len(gs.Scene({"H": sheet}, faults, BOX).units) == 6


def test_a_fault_beyond_the_lattice_or_far_from_the_data_is_noted_only():
    for grid, east in ((level_where(X < 9e9), 4300.0), (level_where(X < 1000.0), 3003.0)):
        sheet = gs.tear_horizon(grid, {"F1": wall("F1", east, 0.0)}, name="H", trim=1.5)
        assert "Fault 'F1' does not meet the horizon." in str(sheet.report)
