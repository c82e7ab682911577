"""Column, contacts and area of interest in scenario files, and pictures of what fails."""

from __future__ import annotations

import csv
import re

import numpy as np
import pytest

import geosurf as gs
from geosurf.cli import main
from geosurf.errors import OpenUnitError, ScenarioError
from geosurf.scenario import build_scene, read_scenario, run
from tests.messages import refused
from tests.planes import INPUTS, scenario_tables, write_grids

OUTPUT = """
[output]
views = []
maps = false
exploded = false
formats = ["csv"]
"""
THROWS = """
[[throws]]
fault = "F1"
throw_m = 30.0
"""
TEAR = "[tear]\ntrim_cells = 1.5\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Grids of a small world, and one that ends inside the box."""
    path = tmp_path_factory.mktemp("inputs")
    world = write_grids(path)
    gs.write(world.horizons["Top"].isel(easting=slice(0, 4)), path / "Short.nc")
    return path


def scenario(folder, more="", top="", **changes):
    text = INPUTS.replace('"Top.nc"\n', f'"Top.nc"\n{top}\n') + OUTPUT + more
    for old, new in changes.items():
        text = text.replace(f"{old}.nc", new)
    path = folder / "scenario.toml"
    path.write_text(text)
    return path


def test_all_of_it_in_one_file(folder, tmp_path):
    more = """
[slivers]
min_volume_m3 = 1e9
[[contacts]]
name = "OWC"
elevation_m = -2050.0
[[contacts]]
name = "OWC"
elevation_m = -2000.0
block = "F1+"
[aoi]
corners_m = [[100, 100], [3900, 200], [3800, 2900], [2000, 1500], [200, 2800]]
"""
    path = scenario(folder, more, 'rule = "erosional"')
    outcome = run(read_scenario(path), tmp_path / "out", pictures=False)
    assert outcome.certificate.ok
    scene = outcome.scene
    assert scene.column == {"Top": "erosional", "Base": "conformable"}
    assert scene.units.footprint < scene.units.box_volume / 799
    with (tmp_path / "out" / "volumes.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["contact"] for row in rows} >= {"above OWC", "below OWC"}
    total = sum(float(row["volume_m3"]) for row in rows)
    assert total == pytest.approx(scene.volumes.sum().item(), rel=1e-12)
    assert scene.units.volume == pytest.approx(scene.units.footprint * 800, rel=1e-12)
    page = (tmp_path / "out" / "report" / "index.html").read_text()
    assert "Slivers: units below 1000 million m³" in page
    assert "above OWC" in page


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ('[[contacts]]\nname = "OWC"', r"contacts\['OWC'\]: give either elevation_m or file"),
        ('[[contacts]]\nname = "OWC"\nelevation_m = -1\nfile = "Top.nc"', "elevation_m or file"),
        (2 * '[[contacts]]\nname = "OWC"\nelevation_m = -1\n', "is given without a block twice"),
        ("[aoi]", "aoi: give one of file, corners_m, rectangle"),
        ("[aoi]\ncorners_m = [[0, 1], [2]]", r"corners_m is .* must be three or more corners"),
        ("[slivers]\nmin_volume_m3 = -1", "it must be a number, 0 or above"),
        (TEAR + 'horizons = ["Topp"]',
         "unknown horizon 'Topp'; the scenario has 'Top', 'Base'. Did you mean 'T"),
        (TEAR + THROWS, "horizon 'Top' is torn twice: .* by the throw of 'F1'. Select"),
        ("[tear]\ntrim_cells = 0", "tear.trim_cells is 0; it must be .auto., a number above 0"),
    ],
)  # fmt: skip
def test_refusals(folder, more, words):
    refused(ScenarioError, words, lambda: read_scenario(scenario(folder, more)))


def test_what_fails_is_drawn(folder, tmp_path, capfd):
    """A horizon that ends inside the box: sentence, place and picture."""
    path = scenario(folder, Top="Short.nc")
    with pytest.raises(OpenUnitError, match="leak around horizon 'Top'") as caught:
        run(read_scenario(path), tmp_path / "none", pictures=False)
    assert caught.value.place[0] == 3000.0
    assert list((tmp_path / "none").iterdir()) == []
    assert main(["run", str(path), "-o", str(tmp_path / "out"), "--quiet"]) == 3
    said = capfd.readouterr().err
    assert re.search(r"leak around horizon 'Top'.*\n.*picture of the place: .*failure\.png", said)
    assert (tmp_path / "out" / "failure.png").stat().st_size > 5000
    good = scenario(folder)
    words = ["run", str(good), "-o", str(tmp_path / "out"), "--quiet", "--no-pictures"]
    assert main(words) == 0
    assert not (tmp_path / "out" / "failure.png").exists()


def test_the_hanging_wall_takes_its_share_and_ellipses_have_a_centre(folder):
    """What the keys say is what `throw_horizon` and `EllipticThrow` are told."""
    more = """
[[throws]]
fault = "F1"
horizons = ["Top"]
throw_m = 30.0
hanging_wall = 0.25
[[throws]]
fault = "F1"
horizons = ["Base"]
elliptic_m = 20.0
half_length_m = 9000
half_height_m = 900
centre_along_m = 0
centre_elevation_m = -1900
"""
    scene = build_scene(read_scenario(scenario(folder, more)))
    fault = scene.surface("F1")
    grids = {name: gs.read_horizon(folder / f"{name}.nc") for name in ("Top", "Base")}
    ellipse = gs.EllipticThrow(20.0, 9000, 900, (0, -1900))
    by_hand = {
        "Top": gs.throw_horizon(grids["Top"], [fault], {"F1": 30.0}, hanging_wall={"F1": 0.25}),
        "Base": gs.throw_horizon(grids["Base"], [fault], {"F1": ellipse}),
    }
    for name, sheet in by_hand.items():
        assert scene.sheets[name].surface.vertices.tobytes() == sheet.surface.vertices.tobytes()


def test_picked_horizons_of_a_scenario_are_torn(folder, tmp_path):
    """The planes of this world have no throw: torn or not, volumes are nearly the same."""
    told = []
    path = scenario(folder, TEAR + 'horizons = ["Top"]')
    outcome = run(read_scenario(path), tmp_path / "out", pictures=False, progress=told.append)
    plain = build_scene(read_scenario(scenario(folder)))
    assert outcome.certificate.ok
    assert list(outcome.scene.sheets) == ["Top"]
    assert outcome.scene.sheets["Top"].report.trim == 1.5
    for name, unit in plain.units.items():
        assert outcome.scene.units[name].volume == pytest.approx(unit.volume, rel=1e-3)
    assert any(re.match(r"tear +Top +at F1 ", line) for line in told)
    starts = [line for line in told if re.match(r"tear +Top +1 of \d+ \.\.\.$", line)]
    assert starts, "the console names the horizon before it is torn"
    assert told.index(starts[0]) < min(n for n, line in enumerate(told) if " at F1 " in line)
    page = (tmp_path / "out" / "report" / "index.html").read_text(encoding="utf-8")
    section = page[page.index("<h2>Reports of torn") : page.index("<h2>Certificate")]
    assert "trim 1.5 cells" in section
    assert 'id="fault-1">F1</h3>' in page
    assert "Throw and heave of torn" in page


BOTH = """
[tear]
horizons = ["Top"]
trim_cells = {F1 = 2.0}
noise_m = 0.5
keep_outliers = true
[[throws]]
fault = "F1"
horizons = ["Base"]
profile_m = [[0.0, 40.0], [900.0, 55.0]]
reach_m = 2000.0
direction = "mean"
"""


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("[tear]\n", {"tear": True}),
        ("[tear]\ntrim_cells = 2.5\nnoise_m = 0.0", {"tear": {"trim": 2.5, "noise": 0.0}}),
        ("[[throws]]\nfault = 'F1'\nthrow_m = 40.0", {"throws": {"F1": 40.0}}),
        (
            BOTH,
            {
                "tear": {
                    "trim": {"F1": 2.0}, "noise": 0.5, "keep_outliers": True, "horizons": ["Top"],
                },
                "throws": {
                    "F1": {
                        "throw": [[0.0, 40.0], [900.0, 55.0]], "horizons": ["Base"],
                        "reach": 2000.0, "direction": "mean",
                    }
                },
            },
        ),
    ],
)  # fmt: skip
def test_scenarios_and_scenes_tear_alike(tmp_path, table, words):
    """The same volumes, sheets, box, warnings and certificate."""
    world = gs.synthetic.torn("through", n=41)
    top, faults = world.horizons["Top"], world.faults
    horizons = {"Top": top, "Base": (0.0 * top - 1900.0).assign_attrs(top.attrs)}
    path = tmp_path / "scenario.toml"
    path.write_text(scenario_tables(tmp_path, horizons, faults) + table)
    one, two = build_scene(read_scenario(path)), gs.Scene(horizons, faults, **words)
    assert list(one.sheets) == list(two.sheets)
    assert one.box == two.box
    assert one.volumes.equals(two.volumes)
    assert str(one.check()) == str(two.check())
    assert one.warnings == two.warnings
    for name, sheet in one.sheets.items():
        assert sheet.surface.vertices.tobytes() == two.sheets[name].surface.vertices.tobytes()


def test_a_horizon_of_a_scenario_is_continued_and_filled(tmp_path):
    world = gs.synthetic.tilted_planes(n=21)
    top, base = world.horizons["Top"], world.horizons["Base"][2:-2, 3:-1].copy()
    base[4:7, 8:10] = np.nan
    text = scenario_tables(tmp_path, {"Top": top, "Base": base})
    path = tmp_path / "model.toml"
    path.write_text(text)
    with pytest.raises(gs.errors.InputError, match=r"1 hole: in 'Base' .*fill_holes = true"):
        gs.run_scenario(path, tmp_path / "out", pictures=False)
    path.write_text(f"{text}extend_m = 1000.0\nfill_holes = true\n")
    with pytest.warns(gs.GeosurfWarning, match="'Base' is extrapolated over"):
        scene = gs.run_scenario(path, tmp_path / "out", pictures=False)
    assert scene.box[:4] == pytest.approx((0, 4000, 0, 3000), abs=1.0)
    assert scene.coverage["Top"] > 0.9

    # points become a grid first
    xy = np.random.default_rng(2).uniform(0.0, 3000.0, (4000, 2))
    xy = xy[np.hypot(xy[:, 0] - 1200.0, xy[:, 1] - 1500.0) > 550.0]
    np.savetxt(tmp_path / "Top.xyz", np.column_stack([xy, 0.02 * xy[:, 0] - 1000.0]))
    entry = '[[horizons]]\nname = "Top"\nfile = "Top.xyz"\npositive = "up"\nfill_holes = true\n'
    path.write_text(f"{entry}[tear]\n")
    with pytest.warns(gs.GeosurfWarning, match="'Top' is extrapolated over"):
        assert len(gs.run_scenario(path, tmp_path / "out", pictures=False).units) == 2


def test_a_fault_ends_at_a_horizon(folder, tmp_path):
    rule = '[[truncations]]\nfault = "F1"\nmain = "Base"\nkeep = "above"\n'
    path = scenario(folder, f'{rule}[tear]\nhorizons = ["Top"]\n')
    outcome = run(read_scenario(path), tmp_path / "out", pictures=False)
    made = outcome.scene
    assert outcome.certificate.ok
    assert made.units["below Base"].block == "whole"
    assert made.cutoffs("Base", "F1")
    assert "F1" in made.sheets["Top"].cuts
    page = (tmp_path / "out" / "report" / "index.html").read_text()
    assert "above (+)" in page

    path = scenario(folder, rule.replace("above", "footwall"))
    refused(ScenarioError, r"ends at horizon 'Base' and keeps 'footwall'", read_scenario, path)
    path = scenario(folder, rule + "[tolerance_m]")
    path.write_text("tolerance_m = 5\n" + path.read_text().replace("[tolerance_m]", ""))
    refused(ScenarioError, r"tolerance_m = 5 cannot be combined.*'F1'", read_scenario, path)
    throw = '[[throws]]\nfault = "F1"\nhorizons = ["Base"]\nthrow_m = 50\n'
    path = scenario(folder, rule + throw)
    refused(ScenarioError, r"ends 'F1' at a horizon before it reaches 'Base'", read_scenario, path)
    path = scenario(folder, rule + throw.replace('horizons = ["Base"]\n', ""))
    made = build_scene(read_scenario(path))
    assert {name: list(one.cuts) for name, one in made.sheets.items()} == {"Top": ["F1"]}
    assert "F1" not in made.units["below Base"].block
