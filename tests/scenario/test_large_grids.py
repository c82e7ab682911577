"""Scenarios with large grids, which are opened first: a run has the results of grids in memory."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr

import geosurf as gs
from geosurf.carve import shells
from geosurf.cli import main
from geosurf.errors import GeosurfWarning, InputError, ScenarioError
from geosurf.read import netcdf
from geosurf.scenario import output, read_scenario, run
from geosurf.scene import scene as scenes
from geosurf.scene.result_cache import ResultCache
from geosurf.sheets import tear
from geosurf.triangulate import grids as grids_room
from tests.folders import bytes_in
from tests.planes import INPUTS, scenario_tables

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
exploded = false
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
    monkeypatch.setattr(grids_room, "BAND", 100)
    gs.run_scenario(path, tmp_path / "store")
    one, two = (files(tmp_path / folder) for folder in ("memory", "store"))
    assert len(one) > 6
    assert [name for name in one | two if one.get(name) != two.get(name)] == []


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
    path.write_text(body + "[tear]\n")
    with pytest.warns(GeosurfWarning, match=r"free. Give grids with fewer nodes; or leave"):
        gs.run_scenario(path, tmp_path / "out", pictures=False)

    # the same in Python: volumes need no lists
    scene = gs.Scene(world.horizons, world.faults, world.box)
    monkeypatch.setattr(shells, "lack_of_room", lambda needed: 9_000_000)
    assert float(scene.volumes.sum()) > 0
    with pytest.raises(InputError, match=r"triangles of the units need .* are free\. Volumes"):
        _ = next(iter(scene.units.values())).triangles


# ---- `cache_dir`: later commands give the same results and redo only what changed.
OUTPUT = """
[output]
views = []
exploded = false
allan = false
sections_m = []
size_px = [300, 200]
formats = ["csv", "vtm"]
[tear]
trim_cells = 1.5
[[contacts]]
name = "OWC"
elevation_m = -2050.0
"""
TITLE = 'title = "Planes"\n'


def files(out: Path) -> dict[str, bytes]:
    """All results but the page, which has the log of the run."""
    return {name: data for name, data in bytes_in(out).items() if not name.endswith(".html")}


@pytest.fixture
def counts(monkeypatch):
    """How often each of these was done."""
    done = dict.fromkeys(("tear", "check"), 0)

    def count(name, module, function):
        inner = getattr(module, function)

        def counted(*args, **words):
            done[name] += 1
            return inner(*args, **words)

        monkeypatch.setattr(module, function, counted)

    count("tear", tear, "tear_from")
    count("check", scenes, "certify_repeated")
    return done


def test_a_second_run_redoes_only_what_changed(inputs, tmp_path, counts):
    def results(body: str, cache: Path | None) -> tuple[dict[str, bytes], dict[str, int]]:
        """Files of one run, and how often it did what."""
        counts.update(dict.fromkeys(counts, 0))
        (inputs / "scenario.toml").write_text(body)
        out = tmp_path / "out"
        scenario = read_scenario(inputs / "scenario.toml")
        assert run(scenario, out, pictures=False, cache_dir=cache).certificate.ok
        return files(out), dict(counts)

    base, cache = TITLE + INPUTS + OUTPUT, tmp_path / "cache"
    plain = results(base, None)
    assert plain[1] == {"tear": 2, "check": 1}
    assert results(base, cache) == plain
    assert results(base, cache) == (plain[0], {"tear": 0, "check": 0})

    # another contact: horizons stay
    moved = base.replace("-2050.0", "-2040.0")
    assert results(moved, cache) == (results(moved, None)[0], {"tear": 0, "check": 1})
    assert results(base.replace("Planes", "Ramps"), cache)[1] == {"tear": 0, "check": 0}


def test_commands_share_a_folder(inputs, tmp_path, counts, capsys):
    # realisations move horizons: their data are of another kind than those that a run reads
    uncertain = '[[uncertain]]\nkind = "depth shift"\nnormal = [0.0, 5.0]\n'
    path = inputs / "shared.toml"
    path.write_text(TITLE + INPUTS + OUTPUT + uncertain)
    plain = gs.run_ensemble(path, 2, progress=False)
    cache = ["--cache-dir", str(tmp_path / "cache")]
    assert main(["check", str(path), *cache]) == 0
    answers = [capsys.readouterr().out]
    done = dict(counts)
    assert main(["check", str(path), *cache]) == 0
    answers.append(capsys.readouterr().out)
    assert (
        main(["render", str(path), "-o", str(tmp_path / "s.png"), "--section", "0,9 9,9", *cache])
        == 0
    )
    assert main(["run", str(path), "-o", str(tmp_path / "r"), "--only", "report", *cache]) == 0
    there = set((tmp_path / "cache").iterdir())
    found = gs.run_ensemble(path, 2, progress=False, cache_dir=tmp_path / "cache")
    # two horizons of two realisations are torn, and of the base case as planned; none is searched
    # for, and they are nobody else's
    assert counts == {**done, "tear": done["tear"] + 6}
    assert set((tmp_path / "cache").iterdir()) == there
    assert answers[0] == answers[1]
    assert found.data.bulk.values.tobytes() == plain.data.bulk.values.tobytes()
    with pytest.raises(InputError, match="cache_dir= is for the path of a scenario"):
        gs.run_ensemble(
            run(read_scenario(path), tmp_path / "o", pictures=False).scene, 2, cache_dir=tmp_path
        )


def test_a_certificate_that_fails_is_not_stored(tmp_path):
    cache = ResultCache(tmp_path)
    for count in (1, 2):
        cache.get_or_compute("certificate", ("model",), lambda: False, keep=lambda ok: ok)
        assert cache.n_made == count
