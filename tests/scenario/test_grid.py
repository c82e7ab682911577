"""A scenario with a grid writes it, and refuses layers that mean nothing."""

import pandas as pd
import pytest

import geosurf as gs
from geosurf.errors import ScenarioError
from geosurf.scenario import read_scenario
from tests.messages import refused
from tests.planes import scenario_tables

WORLD = gs.synthetic.tilted_planes(n=5)


def scenario(folder, words, faults=None):
    """A scenario of two horizons, and perhaps their fault."""
    tables = scenario_tables(folder, WORLD.horizons, faults)
    (folder / "scenario.toml").write_text(f'{tables}[output]\nformats = ["csv"]\n{words}\n')
    return folder / "scenario.toml"


def test_a_run_writes_the_grid(tmp_path):
    path = scenario(tmp_path, '[grid]\ncell_m = 500\nlayers = {"Top/Base" = 3}')
    scene = gs.run_scenario(path, tmp_path / "out", pictures=False)
    gs.write(gs.build_grid(scene, 500, {"Top/Base": 3}), tmp_path / "mine.grdecl", name="grid")
    found = (tmp_path / "out" / "grid.grdecl").read_bytes()
    assert found == (tmp_path / "mine.grdecl").read_bytes()
    assert (tmp_path / "out" / "grid.inc").is_file()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        *((f"layers = {layers}", r"grid\.layers") for layers in ("0", "true", "{}", "2.5")),
        ('layers = {"Top/Bse" = 3}', r"grid\.layers: .*Did you mean 'Top/Base'"),
        ("cell_m = [100]", r"grid\.cell_m is \[100\]; it must be a number above 0, or two"),
        ("min_dip = 120", r"grid\.min_dip is 120; it must be a number above 0 and below 90"),
    ],
)
def test_a_wrong_key_is_found_before_a_model_is_built(tmp_path, words, message):
    refused(ScenarioError, message, read_scenario, scenario(tmp_path, f"[grid]\n{words}"))


@pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")
def test_seal_writes_the_polygons_of_all_faults_and_the_multipliers_of_the_grid(tmp_path):
    words, out = "[seal]\nvshale = 0.3\npermeability_md = 100", tmp_path / "out"
    path = scenario(tmp_path, words, WORLD.faults)
    refused(ScenarioError, r"Add \[grid\]", read_scenario, path)
    path = scenario(tmp_path, f"{words}\n[grid]\ncell_m = 500", WORLD.faults)
    scene = gs.run_scenario(path, out, pictures=False)
    rows = pd.read_csv(out / "seal.csv")
    assert rows.area_m2.sum() == pytest.approx(float(scene.seal("F1", vshale=0.3).area.sum()))
    made = gs.fault_multipliers(scene, gs.build_grid(scene, 500), vshale=0.3, permeability=100)
    gs.write(made, tmp_path / "mine.inc")
    assert (out / "grid_multipliers.inc").read_bytes() == (tmp_path / "mine.inc").read_bytes()
