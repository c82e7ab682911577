"""A scenario with a grid writes it, and refuses layers that mean nothing."""

import pandas as pd
import pytest

import geosurf as gs

HEAD = """
[[horizons]]
name = "Top"
file = "Top.nc"

[[horizons]]
name = "Base"
file = "Base.nc"

[output]
formats = ["csv"]
"""


@pytest.fixture
def folder(tmp_path):
    world = gs.synthetic.tilted_planes(n=5)
    for name in ("Top", "Base"):
        gs.write(world.horizons[name], tmp_path / f"{name}.nc")
    return tmp_path


def test_a_run_writes_the_grid(folder):
    words = '[grid]\ncell_m = 500\nlayers = {"Top/Base" = 3}\n'
    (folder / "scenario.toml").write_text(HEAD + words)
    scene = gs.run_scenario(folder / "scenario.toml", folder / "out", pictures=False)
    gs.write(gs.build_grid(scene, 500, {"Top/Base": 3}), folder / "mine.grdecl", name="grid")
    found = (folder / "out" / "grid.grdecl").read_bytes()
    assert found == (folder / "mine.grdecl").read_bytes()
    assert (folder / "out" / "grid.inc").is_file()


@pytest.mark.parametrize("layers", ["0", "true", "{}", "2.5"])
def test_layers_that_mean_nothing_are_refused(folder, layers):
    (folder / "scenario.toml").write_text(f"{HEAD}[grid]\nlayers = {layers}\n")
    with pytest.raises(gs.errors.ScenarioError, match=r"grid\.layers"):
        gs.run_scenario(folder / "scenario.toml", folder / "out", pictures=False)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ('layers = {"Top/Bse" = 3}', r"grid\.layers: .*Did you mean 'Top/Base'"),
        ("cell_m = [100]", r"grid\.cell_m is \[100\]; it must be a number above 0, or two"),
        ("min_dip = 120", r"grid\.min_dip is 120; it must be a number above 0 and below 90"),
    ],
)
def test_a_wrong_key_is_found_before_a_model_is_built(folder, words, message):
    (folder / "scenario.toml").write_text(f"{HEAD}[grid]\n{words}\n")
    with pytest.raises(gs.errors.ScenarioError, match=message):
        gs.scenario.read_scenario(folder / "scenario.toml")


@pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")
def test_seal_writes_the_polygons_of_all_faults_and_the_multipliers_of_the_grid(folder):
    fault = gs.synthetic.tilted_planes(n=5).faults["F1"]
    gs.write(fault, folder / "F1.nc")
    words = f'{HEAD}[[faults]]\nname = "F1"\nfile = "F1.nc"\n[seal]\nvshale = 0.3\n'
    (folder / "scenario.toml").write_text(f"{words}permeability_md = 100\n")
    with pytest.raises(gs.errors.ScenarioError, match=r"Add \[grid\]"):
        gs.scenario.read_scenario(folder / "scenario.toml")
    (folder / "scenario.toml").write_text(f"{words}permeability_md = 100\n[grid]\ncell_m = 500\n")
    out = folder / "out"
    scene = gs.run_scenario(folder / "scenario.toml", out, pictures=False)
    rows = pd.read_csv(out / "seal.csv")
    assert rows.area_m2.sum() == pytest.approx(float(scene.seal("F1", vshale=0.3).area.sum()))
    made = gs.fault_multipliers(scene, gs.build_grid(scene, 500), vshale=0.3, permeability=100)
    gs.write(made, folder / "mine.inc")
    assert (out / "grid_multipliers.inc").read_bytes() == (folder / "mine.inc").read_bytes()
