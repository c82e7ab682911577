"""Well tops in scenario files: misfits in the report, horizons tied to them, torn or not."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.cli import main
from geosurf.scenario import build_scene, read_scenario

TEXT = """
[[horizons]]
name = "Top"
file = "Top.nc"
[[faults]]
name = "F1"
file = "F1.nc"
{more}
[tops]
file = "tops.csv"
positive = "down"
{tie}
[box]
easting_m = [50, 950]
northing_m = [50, 950]
elevation_m = [-2100, -1500]
[output]
views = []
exploded = false
maps = false
thickness = false
allan = false
sections_m = []
formats = ["csv"]
"""

WELLS = """
[wells]
files = ["s.csv"]
heads = "heads.csv"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A smeared horizon, its fault, and tops of both walls with known misfits."""
    path = tmp_path_factory.mktemp("tops")
    world = gs.synthetic.torn("through", n=41)
    gs.write(world.horizons["Top"], path / "Top.nc")
    gs.write(world.faults["F1"], path / "F1.nc")
    points = world.truth["points"]
    rows = [int(np.hypot(*(points[:, :2] - at).T).argmin()) for at in ((250, 500), (760, 480))]
    lines = ["Well,Surface,X,Y,TVDSS"]
    for k, (x, y, z) in enumerate(points[rows].tolist()):
        lines.append(f"W{k},Top,{x},{y},{-z + 8.0 * (-1) ** k}")
    lines += ["W3,Topp,250,500,1800", "W4,Top,250,500,-999"]
    (path / "tops.csv").write_text("\n".join(lines) + "\n")
    return path


def scenario(folder, tie="", more=""):
    """A scenario with some settings of its tops."""
    path = folder / "scenario.toml"
    path.write_text(TEXT.format(tie=tie, more=more))
    return path


@pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")
@pytest.mark.parametrize("more", ["", "[tear]"])
def test_horizons_are_tied_torn_or_not(folder, more):
    plain = build_scene(read_scenario(scenario(folder, more=more)))
    tied = build_scene(read_scenario(scenario(folder, "tie = true\nrange_m = 300", more)))
    before, after = plain.misfit(), tied.misfit()
    np.testing.assert_allclose(before.misfit[:2], [8.0, -8.0], atol=0.2)
    assert np.abs(after.misfit[:2]).max() <= 0.1
    assert after.status.values.tolist() == ["found", "found", "unknown horizon"]
    kinds = [(warning.kind, warning.subject) for warning in tied.warnings]
    assert kinds == [("tops", "Topp")]
    assert bool(tied.sheets) == bool(more)


def test_the_command_line_lists_misfits_and_what_is_not_used(folder, tmp_path, capsys):
    path = scenario(folder, "tie = true", "[tear]" + WELLS)
    (folder / "s.csv").write_text("Well,MD,Inc,Azi\nW5,0,0,0\nW5,2500,0,0\n")
    (folder / "heads.csv").write_text("Well,X,Y,KB\nW5,300,400,25\n")
    assert main(["run", str(path), "-o", str(tmp_path / "out"), "--no-pictures"]) == 0
    said = capsys.readouterr()
    assert said.err.count("'Top' in well 'W4' (line 5) has undefined z") == 1
    assert said.err.count("1 well top of 'Topp' (wells W3)") == 1
    assert said.err.count("the default range") == 1
    page = (tmp_path / "out" / "report" / "index.html").read_text(encoding="utf-8")
    assert "Well tops and the model" in page
    assert "tied to well tops: 2 of 2 tops" in page
    rows = (tmp_path / "out" / "wells.csv").read_text(encoding="utf-8").splitlines()
    assert [row.split(",")[0] for row in rows[1:]] == ["W5"] * (len(rows) - 1)
