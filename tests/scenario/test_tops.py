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


# ---- Scenarios in time: read, turned into depth, and varied.
TOML = """
positive = "down"
length_unit = "ms"
time = "two-way"
{velocity}
[tear]

[[horizons]]
name = "Top"
file = "top.poi"

[[faults]]
name = "F1"
file = "F1.ts"

[[contacts]]
name = "OWC"
elevation_m = -1700.0

[[uncertain]]
kind = "velocity factor"
of = ["above Top"]
normal = [1.0, 0.01]
"""
VELOCITY = '[velocity]\n"above Top" = 1950.0\nelsewhere = {v0 = 1500.0, k = 0.4}'


@pytest.fixture(scope="module")
def in_time(tmp_path_factory):
    world, in_time = gs.synthetic.torn("normal", n=41), tmp_path_factory.mktemp("time")
    rows = (f"{x} {y} {-z}" for x, y, z in world.truth["points"])
    (in_time / "top.poi").write_text("\n".join(rows) + "\n999.0 999.0 999.0\n")
    fault = gs.triangulate_fault(world.faults["F1"], name="F1")
    lines = ["GOCAD TSurf 1", "HEADER {", "name:F1", "}", "TFACE"]
    lines += [f"VRTX {k} {x} {y} {-z}" for k, (x, y, z) in enumerate(fault.vertices, 1)]
    lines += ["TRGL {} {} {}".format(*t) for t in fault.triangles + 1]
    (in_time / "F1.ts").write_text("\n".join([*lines, "END", ""]))
    return in_time


def test_a_scenario_in_time_is_the_scene_in_depth_and_its_ensemble(in_time):
    (in_time / "s.toml").write_text(TOML.format(velocity=VELOCITY))
    scene = gs.run_scenario(in_time / "s.toml", in_time / "out", pictures=False)
    points = gs.read_points(in_time / "top.poi", positive="down", length_unit="m")
    fault = gs.read_fault(in_time / "F1.ts", positive="down", length_unit="m")
    found = points.elevation.values
    given = gs.Scene(
        {"Top": np.column_stack([points.easting, points.northing, found])},
        {"F1": (fault.vertices, fault.triangles)},
        time="two-way", positive="up", length_unit="ms", tear=True,
        velocity={"above Top": 1950.0, "elsewhere": {"v0": 1500.0, "k": 0.4}},
    )  # fmt: skip
    assert scene.surface("Top").bounds[4:] == pytest.approx(given.surface("Top").bounds[4:])
    assert set(scene.units) >= {"above Top above OWC"} or scene.contacts
    ensemble = gs.run_ensemble(in_time / "s.toml", 2, workers=1)
    assert len(set(ensemble.data.drawn.values.ravel().tolist())) == 2


def test_time_and_velocity_belong_together(in_time):
    (in_time / "no.toml").write_text(TOML.format(velocity=""))
    with pytest.raises(gs.errors.ScenarioError, match="belong together"):
        gs.run_scenario(in_time / "no.toml", in_time / "out")


def test_tops_of_a_scenario_give_its_velocities(in_time):
    rows = ["well,horizon,easting,northing,elevation"]
    rows += [f"W{x},Top,{x},500,{z}" for x, z in ((150, -1700.0), (850, -1790.0))]
    (in_time / "tops.csv").write_text("\n".join([*rows, ""]))
    velocity = '[tops]\nfile = "tops.csv"\npositive = "up"\nlength_unit = "m"\n'
    velocity += '[velocity]\nwells = "tops"\nelsewhere = 2500.0'
    (in_time / "t.toml").write_text(TOML.partition("[[uncertain]]")[0].format(velocity=velocity))
    scene = gs.run_scenario(in_time / "t.toml", in_time / "out_t", pictures=False)
    np.testing.assert_allclose(scene.misfit().misfit.values, np.zeros(2), atol=1e-6)
