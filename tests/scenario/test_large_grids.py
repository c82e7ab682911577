"""Scenarios with large grids, which are opened first: a run has the results of grids in memory."""

from __future__ import annotations

import pytest
import xarray as xr

import geosurf as gs
from geosurf.carve import shells
from geosurf.errors import GeosurfWarning, InputError, ScenarioError
from geosurf.read import netcdf
from geosurf.scenario import output
from geosurf.triangulate import stored
from tests.planes import scenario_tables

pytest.importorskip("zarr")
pytest.importorskip("h5netcdf")

BODY = """
[[horizons]]
name = "Top"
file = "field.zarr"
variable = "Top"

[[horizons]]
name = "Base"
file = "base.nc"

[[faults]]
name = "F1"
file = "F1.nc"

[output]
views = ["southwest"]
maps = false
sections_m = []
size_px = [320, 240]
"""


@pytest.fixture
def path(tmp_path):
    world = gs.synthetic.tilted_planes(n=31)
    for name, fault in world.faults.items():
        gs.write(fault, tmp_path / f"{name}.nc")
    grids = xr.Dataset({name: grid.drop_attrs(deep=False) for name, grid in world.horizons.items()})
    for grid in grids.values():
        grid.attrs |= {"units": "m", "positive": "up"}
    grids.chunk({"northing": 7, "easting": 11}).to_zarr(tmp_path / "field.zarr", consolidated=False)
    grids.Base.to_netcdf(tmp_path / "base.nc", engine="h5netcdf")
    file = tmp_path / "scenario.toml"
    file.write_text(BODY)
    return file


def test_law_a_run_has_the_results_of_grids_in_memory(path, tmp_path, monkeypatch):
    gs.run_scenario(path, tmp_path / "memory")
    monkeypatch.setattr(netcdf, "LARGE", 100)  # grids of more than 100 nodes are large
    monkeypatch.setattr(netcdf, "PART", 8)
    monkeypatch.setattr(stored, "BAND", 100)
    gs.run_scenario(path, tmp_path / "store")
    one, two = (
        {
            file.relative_to(tmp_path / folder).as_posix(): file.read_bytes()
            for file in (tmp_path / folder).rglob("*")
            if file.is_file()
        }
        for folder in ("memory", "store")
    )
    assert set(one) == set(two)
    same = [name for name in two if name != "report/index.html"]
    assert len(same) > 6
    assert [name for name in same if one[name] != two[name]] == []


def test_lists_that_memory_does_not_hold_are_left_out_or_refused(tmp_path, monkeypatch):
    world = gs.synthetic.tilted_planes(n=9)
    scenario_tables(tmp_path, world.horizons, world.faults)
    path = tmp_path / "scenario.toml"
    body = BODY.replace('file = "field.zarr"\nvariable = "Top"', 'file = "Top.nc"')
    body = body.replace("base.nc", "Base.nc")
    monkeypatch.setattr(output, "lack_of_room", lambda needed: 9_000_000)

    # formats that nobody asked for are left out, those that somebody asked for are refused
    path.write_text(body)
    with pytest.warns(GeosurfWarning, match=r"'units.vtm' was not written.* while 0.0 GB are free"):
        gs.run_scenario(path, tmp_path / "out", pictures=False)
    assert (tmp_path / "out" / "volumes.csv").is_file()
    assert not (tmp_path / "out" / "units.vtm").exists()
    path.write_text(body + 'formats = ["vtm", "ml"]\n')
    with pytest.raises(ScenarioError, match=r"'vtm', 'ml', which list all.*tolerance_m = 1\.0"):
        gs.run_scenario(path, tmp_path / "out", pictures=False)

    # a tolerance would be refused where horizons are torn
    path.write_text(body.replace("sections_m", "exploded = false\nsections_m") + "[tear]\n")
    with pytest.warns(GeosurfWarning, match=r"free. Give grids with fewer nodes; or leave"):
        gs.run_scenario(path, tmp_path / "out", pictures=False)

    # the same in Python: volumes need no lists
    scene = gs.Scene(world.horizons, world.faults, world.box)
    monkeypatch.setattr(shells, "lack_of_room", lambda needed: 9_000_000)
    assert float(scene.volumes.sum()) > 0
    with pytest.raises(InputError, match=r"triangles of the units need .* are free\. Volumes"):
        _ = next(iter(scene.units.values())).triangles
