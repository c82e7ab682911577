"""Scenarios state what is uncertain; the command writes quantiles and continues what was begun."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import geosurf as gs
from geosurf.cli import main
from geosurf.ensemble import ContactLevel, DepthShift, FaultShift, Triangular, Uniform
from geosurf.ensemble.run import planned
from geosurf.errors import InputError, ScenarioError
from geosurf.report.page import PNG_SIGNATURE
from tests.ensemble.worlds import AREA, fault, layer_cake, plane
from tests.planes import scenario_tables

BOX = """
[box]
easting_m = [0, 2000]
northing_m = [0, 1500]
elevation_m = [-1300, -800]
"""
CONTACT = """
[[contacts]]
name = "OWC"
elevation_m = -1050
"""
ENSEMBLE = """
[ensemble]
n = 3
seed = 4
map_cell_m = 500
[[uncertain]]
kind = "depth shift"
of = ["Top"]
uniform = [-20, 20]
[[uncertain]]
kind = "contact shift"
of = ["OWC"]
triangular = [-9, 0, 6]
[[uncertain]]
kind = "fault position"
uniform = [-100, 100]
"""
WITHOUT_MAPS = ENSEMBLE.replace("map_cell_m = 500\n", "")
THROW = """
[[throws]]
fault = "F1"
throw_m = 20
[[uncertain]]
kind = "throw factor"
of = ["F1"]
uniform = [1, 2]
"""
TEAR = """
[tear]
trim_cells = 2
[[uncertain]]
kind = "depth error"
of = ["Top"]
sd_m = 2
range_m = 300
"""


@pytest.fixture
def write(tmp_path):
    """Write a scenario of the layer cake, with more tables."""

    def written(*more):
        horizons = {"Top": plane(-1000.0), "Base": plane(-1100.0)}
        tables = scenario_tables(tmp_path, horizons, {"F1": fault()})
        path = tmp_path / "scenario.toml"
        path.write_text("".join([tables, BOX, *more]))
        return path

    return written


@pytest.fixture
def undrawn(monkeypatch):
    """Pictures of a page are empty: `test_report` draws them."""
    monkeypatch.setattr("geosurf.render.compose.figure_bytes", lambda *_: PNG_SIGNATURE)


def test_a_scenario_gives_the_results_of_its_scene(write):
    path = write(CONTACT, ENSEMBLE)
    result = gs.run_ensemble(path).data
    scene = layer_cake(faults={"F1": fault()}, contacts={"OWC": -1050.0})
    uncertain = [
        DepthShift(("Top",), Uniform(-20.0, 20.0)),
        ContactLevel("OWC", shift=Triangular(-9.0, 0.0, 6.0)),
        FaultShift((), Uniform(-100.0, 100.0)),
    ]
    same = gs.run_ensemble(scene, 3, seed=4, uncertain=uncertain, maps=500.0).data
    assert result.sizes == same.sizes
    np.testing.assert_allclose(result.drawn, same.drawn)
    np.testing.assert_allclose(result.bulk, same.bulk, rtol=1e-9)


def test_horizons_are_thrown_again_by_the_factor(write):
    plan = planned(write(THROW), 1, (), 0, None)[0]
    for k in range(2):
        change = plan._change(k)
        throw = plan.model.build(change).sheets["Base"].cuts["F1"].throw
        expected = 20.0 * change.numbers["throw F1"]
        np.testing.assert_allclose(throw[np.isfinite(throw)], expected, atol=1e-6)


def test_where_throws_are_certain_nothing_is_thrown_again(write):
    """Realisations that move a contact have the sheets of the base case."""
    moved = '[[throws]]\nfault = "F1"\nthrow_m = 20\n[[uncertain]]\nkind = "contact shift"\n'
    path = write(CONTACT, moved + 'of = ["OWC"]\nuniform = [-9, 9]\n')
    plan = planned(path, 1, (), 0, None)[0]
    plan.start()
    base, one = plan.scene(None), plan.scene(0)
    assert all(one.sheets[name] is base.sheets[name] for name in ("Top", "Base"))
    assert not plan.run(0).reason


def test_the_command_writes_tables_and_continues_with_keys_that_are_set(
    write, undrawn, tmp_path, capsys
):
    """Tables without names are counted."""
    path, out, key = write(CONTACT, WITHOUT_MAPS), tmp_path / "out", "uncertain.1.uniform=[4, 6]"
    words = ["ensemble", str(path), "-o", str(out), "--workers", "1", "--set"]
    assert main([*words, key, "-n", "2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["settings"] == [key]
    assert main([*words, key, "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert "Reservoir model" in (out / "index.html").read_text(encoding="utf-8")
    with (out / "quantiles_total.csv").open() as file:
        rows = {row["quantity"]: row for row in csv.DictReader(file)}
    assert rows["bulk"]["n"] == "3"
    result = gs.ensemble.open_ensemble(out / "ensemble.zarr").data
    shift = result.drawn.sel(parameter="depth shift Top")
    assert ((shift >= 4.0) & (shift <= 6.0)).all()
    assert float(rows["bulk"]["P50"]) == pytest.approx(AREA * (100.0 + float(shift.median())))
    assert main([*words, "uncertain.4.uniform=[4, 6]"]) == 2
    assert "no table '4'. These tables have no names; count them" in capsys.readouterr().err


def test_the_example_of_new_can_be_run_as_an_ensemble(undrawn, tmp_path, capsys):
    assert main(["new", str(tmp_path / "field"), "--example"]) == 0
    path = tmp_path / "field" / "scenario.toml"
    text, mark, fluids = path.read_text().partition("# How much oil is in place?")
    path.write_text(text + mark + fluids.replace("\n# ", "\n"))
    words = ["ensemble", str(path), "-n", "2", "--workers", "1"]
    assert main([*words, "-o", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "2 realisations, 0 failed" in printed
    assert "STOIIP [million Sm³]" in printed
    lines = (tmp_path / "out" / "realisations.csv").read_text().splitlines()
    assert len(lines) == 1 + 2 * 3  # realisations and regions
    assert "stoiip [Sm3]" in lines[0]
    assert "porosity Top/Middle [1]" in lines[0]
    data = gs.ensemble.open_ensemble(tmp_path / "out" / "ensemble.zarr").data
    assert (data.bulk.std("realisation") > 0).any()
    # a horizon that stays was searched for in the base case only
    assert (data.torn == 3).all()
    assert not data.searched.any()


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ("", "nothing is uncertain. Add a table"),
        ('[[uncertain]]\nkind = "depth"\n', "kind is 'depth'; it must be one of"),
        ('[[uncertain]]\nkind = "depth shift"\nof = ["Tip"]\nuniform = [0, 1]\n',
         "unknown name of horizons 'Tip'; the scenario has 'Top', 'Base'"),
        ('[[uncertain]]\nkind = "depth shift"\n', "exactly one of normal, uniform, triangular"),
        ('[[uncertain]]\nkind = "depth error"\nnormal = [0, 1]\n', "takes sd_m and range_m"),
        ('[[uncertain]]\nkind = "fault dip"\nsd_m = 5\nuniform = [0, 1]\n',
         "sd_m and range_m are of a depth error"),
        ('[[uncertain]]\nkind = "throw"\nof = ["F1"]\nuniform = [0, 1]\n',
         r"fault 'F1' has no throw_m in \[\[throws\]\]"),
        (TEAR + '[[uncertain]]\nkind = "throw"\nof = ["F1"]\nuniform = [0, 1]\n',
         "by \\[tear\\], so their data determine its throw. Vary the fault instead"),
        ('[[uncertain]]\nkind = "contact level"\nuniform = [0, 1]\n', "has one name, as in of"),
        ('[[uncertain]]\nkind = "depth shift"\nuniform = [1, 0]\n', "low must be below high"),
        ("[ensemble]\nn = 0\n", "ensemble.n is 0; it must be a whole number above 0"),
    ],
)  # fmt: skip
def test_wrong_tables_are_refused(write, tables, words):
    with pytest.raises(InputError, match=words) as caught:
        gs.run_ensemble(write(tables))
    assert "kind" not in words or isinstance(caught.value, ScenarioError)


def test_a_scenario_has_its_own_uncertainties(write):
    with pytest.raises(InputError, match=r"has its own .* tables. Leave out uncertain="):
        gs.run_ensemble(write(CONTACT, ENSEMBLE), uncertain=[DepthShift("Top", 1.0)])
