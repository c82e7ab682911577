"""A run prints each warning once on stderr, and lists all of them first in what it writes."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import geosurf as gs
from geosurf.cli import main

WORDS = "Fault 'Out' lies 500 m east of the model box and is left out: it divides nothing."
SCENARIO = """
[[horizons]]
name = "Top"
file = "Top.nc"
[[faults]]
name = "In"
file = "In.ts"
[[faults]]
name = "Out"
file = "Out.ts"
[box]
easting_m = [0, 5000]
northing_m = [0, 4000]
elevation_m = [-2600, -1800]
"""


@pytest.fixture
def scenario(tmp_path):
    gs.write(gs.synthetic.graben(n=9).horizons["Top"], tmp_path / "Top.nc")
    for name, x in (("In", 2500), ("Out", 5500)):
        wall = [(x, -500, -3000), (x, 4500, -3000), (x, 4500, -1000), (x, -500, -1000)]
        fault = gs.TriSurface(name, "fault", np.array(wall, float), [[0, 1, 2], [0, 2, 3]])
        gs.write(fault, tmp_path / f"{name}.ts")
    (tmp_path / "s.toml").write_text(SCENARIO)
    return tmp_path / "s.toml"


def test_once_on_stderr_and_first_in_the_files(scenario, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", str(scenario), "-o", str(out), "--no-pictures", "--quiet"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"geosurf: warning: {WORDS} If it belongs to the model, enlarge")
    page = (out / "report" / "index.html").read_text(encoding="utf-8")
    assert page.index("<h2>Warnings</h2>") == page.index("<h2>")
    assert "is left out: it divides nothing." in page
    lines = (out / "certificate.txt").read_text(encoding="utf-8").splitlines()
    assert lines[2].startswith(f"Warning: {WORDS}")


@pytest.mark.parametrize("command", ["check", "report"])
def test_other_commands_print_it_too(command, scenario, tmp_path, capsys):
    more = ["-o", str(tmp_path / "out"), "--no-pictures", "--quiet"] if command == "report" else []
    assert main([command, str(scenario), *more]) == 0
    assert capsys.readouterr().err.count(WORDS) == 1


def test_filters_of_the_user_are_left_as_they_were(scenario):
    before = list(warnings.filters), warnings.showwarning
    main(["check", str(scenario)])
    assert (list(warnings.filters), warnings.showwarning) == before


def test_in_python_it_is_a_warning(scenario, tmp_path):
    with pytest.warns(gs.GeosurfWarning, match="'Out' lies 500 m east") as issued:
        scene = gs.run_scenario(scenario, tmp_path / "out", pictures=False)
    assert [one.message for one in issued] == list(scene.warnings)
