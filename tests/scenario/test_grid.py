"""A scenario with a grid writes it, and refuses layers that mean nothing."""

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
