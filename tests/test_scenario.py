"""Scenario files: what they may say, what comes out, and what a wrong one is told."""

# ruff: noqa: E501 - the wrong scenarios are a table, one case per line

from __future__ import annotations

import csv
import hashlib
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import (
    DependencyError,
    GeometryError,
    GeosurfWarning,
    OpenUnitError,
    OutputError,
    ScenarioError,
)
from geosurf.scenario import read_scenario, run, run_scenario
from geosurf.scenario.keys import BoxRanges, OutputSettings, Scenario
from geosurf.scenario.page import scenario_page
from tests.planes import INPUTS, write_grids

ROOT = Path(__file__).resolve().parents[1]

TITLE = 'title = "Tilted planes"\n'
OUTPUT = """
[output]
views = ["southwest"]
search = ["Top", "F1"]
size_px = [400, 260]
"""
BODY = TITLE + INPUTS + OUTPUT


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the grids of a small world."""
    folder = tmp_path_factory.mktemp("inputs")
    write_grids(folder)
    return folder


@pytest.fixture
def scenario(inputs: Path, tmp_path: Path):
    """A function that writes a scenario, with words exchanged, beside the grids."""

    def make(*changes: tuple[str, str], body: str = BODY) -> Path:
        for old, new in changes:
            assert old in body
            body = body.replace(old, new)
        path = inputs / f"{hashlib.sha256(body.encode()).hexdigest()[:12]}.toml"
        path.write_text(body, encoding="utf-8")
        return path

    return make


def digests(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


# ---- what comes out ------------------------------------------------------------------


def test_a_run_writes_everything_and_a_second_run_the_same_bytes(scenario, tmp_path):
    out, lines = tmp_path / "out", []
    scene = run_scenario(scenario(), out, progress=lines.append)
    first = digests(out)
    assert set(first) == {
        *("units.vtm", "curves.vtp", "volumes.csv", "volumes.nc", "certificate.txt"),
        *("pictures/view_southwest.png", "pictures/units_exploded.png", "pictures/search.png"),
        *("pictures/map_00_Top.png", "pictures/map_01_Base.png", "report/index.html"),
        *("pictures/isochore_00_Top_Base.png", "pictures/allan_00_F1.png"),
        *("pictures/section_00.png", "pictures/section_01.png"),
        *(f"units/{path.name}" for path in (out / "units").iterdir()),
    }
    assert len(list((out / "units").iterdir())) == len(scene.units) == 6
    with (out / "volumes.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    volumes = [float(row["volume_m3"]) for row in rows]
    assert sum(volumes) == pytest.approx(4000 * 3000 * 800, rel=1e-12)
    assert {line.split()[0] for line in lines} >= {"read", "rebuild", "carve", "check", "draw"}
    assert all(line.endswith(" s") for line in lines)
    assert (out / "report" / "index.html").read_text(encoding="utf-8").count("<img") == 9

    run_scenario(scenario(), out)
    assert digests(out) == first


def test_faults_are_extended_and_truncated_as_the_scenario_says(scenario, inputs, tmp_path):
    short = gs.TriSurface(
        "F2", "fault", [[2500, 1000, -1800], [3000, 1000, -1800], [3000, 1000, -2300]], [[0, 1, 2]]
    )
    gs.write(short, inputs / "F2.ts")
    more = """
[[faults]]
name = "F2"
file = "F2.ts"
extend = ["strike", "up", "down"]

[[truncations]]
fault = "F2"
main = "F1"
keep = "hanging wall"

[box]"""
    path = scenario(("[box]", more), ('search = ["Top", "F1"]', 'formats = ["csv"]'))
    scene = run_scenario(path, tmp_path / "out", pictures=False)
    assert {type(a).__name__ for a in scene.fault_actions} == {"Extension", "Truncation"}
    assert len({u.block for u in scene.units.values()}) == 3
    page = (tmp_path / "out" / "report" / "index.html").read_text(encoding="utf-8")
    assert "Faults: what was extended and truncated" in page
    assert "hanging wall (+)" in page
    around = scenario(("[box]", more.replace('main = "F1"', 'main = "F2"')))
    with pytest.raises(
        ScenarioError, match=r"\.toml: truncations go round in a circle: F2 ends at"
    ):
        read_scenario(around)


def test_results_of_an_earlier_run_do_not_survive_and_other_files_do(scenario, tmp_path):
    out = tmp_path / "out"
    run_scenario(scenario(("size_px", "maps = true\nsize_px")), out)
    (out / "notes.txt").write_text("mine")
    (out / "pictures" / "mine.png").write_text("mine")
    without_fault = scenario(
        ('[[faults]]\nname = "F1"\nfile = "F1.nc"\n', ""),
        ('search = ["Top", "F1"]', 'formats = ["vtm", "csv"]'),
    )
    run_scenario(without_fault, out, pictures=False)
    assert set(digests(out)) == {
        *("units.vtm", "volumes.csv", "certificate.txt", "report/index.html"),
        *("units/000_above_Top.vtp", "units/001_Top_Base.vtp", "units/002_below_Base.vtp"),
        *("notes.txt", "pictures/mine.png"),
    }


def test_a_run_that_fails_leaves_the_results_that_were_there(scenario, tmp_path):
    out = tmp_path / "out"
    run_scenario(scenario(), out, pictures=False)
    before = digests(out)
    with pytest.raises(OpenUnitError, match=r"horizon 'Top'.*rim.*Shrink the box"):
        run_scenario(scenario(("[0, 4000]", "[-500, 4000]")), out)
    after = digests(out)
    after.pop("failure.png", None)  # beside the results, where pictures can be drawn
    assert after == before


def test_without_opengl_maps_and_everything_else_are_there(scenario, tmp_path, monkeypatch):
    findings = [("pictures", False, "pictures cannot be drawn without a screen.")]
    monkeypatch.setattr("geosurf.scene.pictures.doctor", lambda: findings)
    with pytest.warns(GeosurfWarning, match="Only maps"):
        outcome = run(read_scenario(scenario()), tmp_path / "out")
    (note,) = outcome.scene.warnings
    assert note.effect == (
        "Only maps and diagrams were drawn: pictures cannot be drawn without a screen."
    )
    drawn = sorted(path.name for path in (tmp_path / "out" / "pictures").iterdir())
    assert [name.partition("_")[0] for name in drawn] == [
        *("allan", "isochore", "map", "map", "section", "section"),
    ]
    assert outcome.certificate.ok


@pytest.mark.parametrize(
    ("error", "reason"),
    {
        "of geosurf": (GeometryError("fault 'F1' is flat."), "fault 'F1' is flat."),
        "foreign": (ZeroDivisionError("division"), "ZeroDivisionError: division. This is a fault"),
        "memory": (MemoryError(), "there is not enough memory for it."),
    }.values(),
    ids=str,
)
def test_an_error_of_one_picture_costs_no_other_result(
    scenario, tmp_path, monkeypatch, error, reason
):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr("geosurf.scene.pictures.render_allan", fail)
    path, out = scenario(("views = [", "exploded = false\nviews = [")), tmp_path / "out"
    with pytest.warns(GeosurfWarning, match=r"'allan_00_F1\.png' was not drawn") as caught:
        run_scenario(path, out)
    (note,) = (one.message for one in caught)
    assert (note.kind, note.subject) == ("picture", "allan_00_F1.png")
    assert reason in note.effect
    assert note.remedy.endswith("Set allan = false in [output] to run without it.")
    page = (out / "report" / "index.html").read_text(encoding="utf-8")
    assert page.index("was not drawn") < page.index("Volumes [")
    there = digests(out)
    assert {"volumes.csv", "certificate.txt", "report/index.html", "pictures/search.png"} <= {
        *there
    }
    assert "pictures/allan_00_F1.png" not in there


def test_a_section_beside_the_model_costs_no_other_result(scenario, tmp_path):
    beside = "sections_m = [[[-900, 0], [-900, 100]], [[0, 100], [4000, 100]]]\nviews = []"
    path = scenario(
        ('views = ["southwest"]', beside), ('search = ["Top", "F1"]', "exploded = false")
    )
    beside = r"'section_00\.png' was not drawn: the line of the section does not meet"
    with pytest.warns(GeosurfWarning, match=beside):
        run_scenario(path, tmp_path)
    assert (tmp_path / "pictures" / "section_01.png").is_file()


def test_an_interrupt_while_drawing_ends_the_run(scenario, tmp_path, monkeypatch):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("geosurf.scene.pictures.render_map", stop)
    with pytest.raises(KeyboardInterrupt):
        run_scenario(scenario(("size_px", "exploded = false\nsize_px")), tmp_path / "out")
    assert not list((tmp_path / "out").iterdir())


def test_a_failure_is_reported_even_if_its_picture_fails_too(scenario, tmp_path, monkeypatch):
    monkeypatch.setattr("geosurf.scenario.failure.render_place", lambda *_, **__: 1 / 0)
    with pytest.raises(OpenUnitError) as caught:
        run_scenario(scenario(("[0, 4000]", "[-500, 4000]")), tmp_path)
    assert "could not be drawn: ZeroDivisionError" in caught.value.__notes__[0]


def test_the_box_may_be_left_out(scenario):
    start, end = BODY.index("[box]"), BODY.index("[output]")
    scene = read_scenario(scenario((BODY[start:end], ""))).scene()
    assert scene.box[:4] == (0.0, 4000.0, 0.0, 3000.0)


def test_what_the_scenario_says_reaches_the_scene(scenario):
    path = scenario(("[output]", "[search]\nvoxel_size_m = 300\n[output]\nexaggeration = 3"))
    read = read_scenario(path)
    assert read.box == BoxRanges(
        easting_m=(0.0, 4000.0), northing_m=(0.0, 3000.0), elevation_m=(-2500.0, -1700.0)
    )
    assert (read.search.voxel_size_m, read.output.exaggeration) == (300.0, 3.0)
    assert (read.title, read.output.search) == ("Tilted planes", ("Top", "F1"))
    coarse, default = read.scene(), read_scenario(scenario()).scene()
    assert np.array_equal(coarse.volumes.values, default.volumes.values)


def test_a_tolerance_reaches_the_scene_the_log_and_the_report(scenario, tmp_path):
    said: list[str] = []
    start = BODY.index("[[horizons]]")
    path = scenario((BODY[start:], "tolerance_m = 5.0\n" + BODY[start:]))
    outcome = run(read_scenario(path), tmp_path / "out", pictures=False, progress=said.append)
    assert outcome.scene.tolerance == 5.0
    assert any(line.startswith("tolerance   5 m") and "m³ of those of all" in line for line in said)
    page = (tmp_path / "out" / "report" / "index.html").read_text(encoding="utf-8")
    assert "Horizons are simplified to 5 m: the volume of any unit" in page
    with pytest.raises(ScenarioError, match=r"tolerance_m is -5.0; it must be a number above 0"):
        read_scenario(scenario((BODY[start:], "tolerance_m = -5.0\n" + BODY[start:])))


def test_direction_and_unit_can_be_said_for_each_file(inputs, scenario):
    (inputs / "deep.irap").write_text(
        "-996 2 2000 2000\n0 2000 0 2000\n2 0 0 0\n0 0 0 0 0 0 0\n5000 5000\n5000 5000\n"
    )
    table = '[[horizons]]\nname = "Deep"\nfile = "deep.irap"\n'
    path = scenario(body=table + 'positive = "down"\nlength_unit = "ft"\n')
    assert read_scenario(path).scene().surface("Deep").bounds[4] == -5000 * 0.3048


# ---- what a wrong scenario is told ---------------------------------------------------

BAD = {
    "unknown table": (("[box]", "[bax]"), r"unknown key 'bax'; known are .*Did you mean 'box'\?"),
    "unknown key": (('file = "Base.nc"', 'flie = "Base.nc"'), r"unknown key 'flie' in horizons\['Base'\]; known are .*Did you mean 'file'"),
    "unknown output": (("size_px", "sise_px"), r"unknown key 'sise_px' in output; .*Did you mean 'size_px'"),
    "missing key": (('name = "F1"\n', ""), r"'name' is missing in faults\[number 1\]; give text between quotes"),
    "missing file": (('"Base.nc"', '"Bsae.nc"'), r"horizons\['Base'\].file is 'Bsae.nc', and .* is not there. Paths are relative to .*Did you mean 'Base.nc'"),
    "duplicate horizon": (('name = "Base"', 'name = "Top"'), r"'Top' is the name of a horizon and of another horizon; rename one"),
    "duplicate fault": (('name = "F1"', 'name = "Top"'), r"'Top' is the name of a horizon and of another fault; rename"),
    "box in the wrong order": (("[-2500, -1700]", "[-1700, -2500]"), r"box.elevation_m is \[-1700, -2500\]; it must be two numbers, the lower one first"),
    "box of one number": (("[0, 4000]", "4000"), r"box.easting_m is 4000; it must be two numbers"),
    "box without a side": (("northing_m = [0, 3000]\n", ""), r"'northing_m' is missing in box; give two numbers"),
    "infinite box": (("[0, 4000]", "[0, inf]"), r"box.easting_m is \[0, inf\]; it must be two numbers"),
    "number as text": (('name = "F1"', "name = 1"), r"faults\[number 1\].name is 1; it must be text between quotes"),
    "table for tables": (("[[faults]]", "[faults]"), r"faults must be tables in double brackets, as in \[\[faults\]\]"),
    "text for a table": (('title = "Tilted planes"', "search = 3"), r"search is 3; it must be a table"),
    "unknown direction": (('file = "Top.nc"', 'file = "Top.nc"\npositive = "dwon"'), r"horizons\['Top'\].positive is 'dwon'; it must be one of 'up', 'down'. Did you mean 'down'"),
    "unknown units": (('file = "Top.nc"', 'file = "Top.nc"\nlength_unit = "furlong"'), r"horizons\['Top'\].length_unit is 'furlong'; it must be one of 'm'"),
    "unknown view": (('["southwest"]', '["southwets"]'), r"output.views has 'southwets'; it may have .*Did you mean 'southwest'"),
    "view twice": (('["southwest"]', '["top", "top"]'), r"output.views is \['top', 'top'\]; it must be a list of any of .* each once"),
    "unknown format": (("size_px", 'formats = ["vtl"]\nsize_px'), r"output.formats has 'vtl'; it may have"),
    "picture size": (("[400, 260]", "[400, true]"), r"output.size_px is \[400, True\]; it must be two whole numbers, \[width, height\], from \[200, 150\]"),
    "small picture": (("[400, 260]", "[64, 64]"), r"output.size_px is \[64, 64\]; it must be .* from \[200, 150\] to \[8000, 8000\]"),
    "large picture": (("[400, 260]", "[8001, 260]"), r"output.size_px is \[8001, 260\]; it must be .* to \[8000, 8000\]"),
    "point twice": (("size_px", "sections_m = [[[0, 0], [0, 0]]]\nsize_px"), r"output.sections_m is .*; it must be lines .* no two in a row the same"),
    "switch": (("size_px", "maps = 1\nsize_px"), r"output.maps is 1; it must be true or false"),
    "exaggeration": (("size_px", "exaggeration = 0\nsize_px"), r"output.exaggeration is 0; it must be a number above 0"),
    "search names": (('["Top", "F1"]', '["Top", "F2"]'), r"output.search names 'F2', which is no surface; there are 'Top', 'Base', 'F1'"),
    "search pair": (('["Top", "F1"]', '["Top", "Top"]'), r"output.search is \['Top', 'Top'\]; it must be the names of two surfaces"),
    "syntax": (('title = "Tilted planes"', "title = Tilted"), r"this is no TOML: .*line 1,.*Mend that line"),
}  # fmt: skip


@pytest.mark.parametrize("change", BAD)
def test_a_wrong_scenario_is_told_where_and_what_next(change, scenario):
    exchange, sentence = BAD[change]
    path = scenario(exchange)
    with pytest.raises(ScenarioError, match=sentence) as caught:
        read_scenario(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_an_empty_scenario_needs_a_horizon(scenario):
    with pytest.raises(ScenarioError, match=r"there are no horizons; give .*\[\[horizons\]\]"):
        read_scenario(scenario(body=""))


def test_a_scenario_that_is_not_there_or_no_text(tmp_path):
    with pytest.raises(ScenarioError, match=r"none.toml: cannot be read .*Check the path"):
        read_scenario(tmp_path / "none.toml")
    (tmp_path / "latin.toml").write_bytes(b'title = "\xe9"')
    with pytest.raises(ScenarioError, match=r"byte 9 is no UTF-8 text. Save"):
        read_scenario(tmp_path / "latin.toml")


@pytest.mark.parametrize("obstacle", ["out", "out/units", "out/pictures", "out/report"])
def test_a_folder_that_cannot_be_written_is_found_before_anything_is_read(
    scenario, tmp_path, monkeypatch, obstacle
):
    monkeypatch.setattr("geosurf.scenario.execute.build_scene", lambda _: pytest.fail("too late"))
    path = tmp_path / obstacle
    path.parent.mkdir(exist_ok=True)
    path.write_text("a file where a folder should be")
    with pytest.raises(OutputError, match=r"out: results cannot be written there .*Choose another"):
        run_scenario(scenario(), tmp_path / "out")
    assert path.read_text().startswith("a file")


def test_netcdf_without_its_library_is_an_error_before_anything_is_read(
    scenario, tmp_path, monkeypatch
):
    monkeypatch.setattr("geosurf.scenario.execute.find_spec", lambda _: None)
    with pytest.raises(DependencyError, match=r"output.formats has 'nc'.*Leave it out.*\[io\]"):
        run_scenario(scenario(), tmp_path / "out")


# ---- the page ------------------------------------------------------------------------


def test_the_page_is_in_step_with_the_code():
    page = (ROOT / "docs" / "scenario.md").read_text(encoding="utf-8")
    assert page == scenario_page(), "run: python -m geosurf.scenario.page > docs/scenario.md"
    for kind in (OutputSettings, BoxRanges):
        assert all(f"`{entry.name}`" in page for entry in fields(kind))


def test_the_page_can_be_made_as_it_says():
    said = subprocess.run(
        [sys.executable, "-m", "geosurf.scenario.page"], capture_output=True, check=True
    )
    assert said.stdout.decode().splitlines() == scenario_page().splitlines()


def test_every_key_has_a_meaning():
    for kind in (Scenario, OutputSettings, BoxRanges):
        keys = [entry for entry in fields(kind) if entry.name != "path"]
        assert all(entry.metadata["meaning"].endswith(".") for entry in keys)


# ---- the examples beside the data ----------------------------------------------------


def test_the_graben_has_the_volumes_of_its_formula():
    scene = read_scenario(ROOT / "data" / "synthetic_horizons" / "graben.toml").scene()
    truth = gs.synthetic.graben(n=33).truth["volumes"]
    assert len(scene.units) == len(truth) == 12
    for (zone, sides), volume in truth.items():
        # blocks outside the graben are named after the one fault that bounds them
        block = " ".join(side for side in sides if side.endswith("-")) or " ".join(sides)
        assert scene.units[zone, block].volume == pytest.approx(volume, rel=1e-9)


def test_the_demo_splits_only_where_a_fault_goes_through():
    scene = read_scenario(ROOT / "data" / "synthetic_horizons" / "faulted_reservoir.toml").scene()
    assert scene.fault_names == ("F1", "F2", "F3")
    assert set(scene.sheets) == {"Top", "Middle", "Base"}
    assert {unit.block for unit in scene.units.values()} == {"F1+", "F1-"}
    split = [name for name, unit in scene.units.items() if unit.contact]
    assert split == [f"Top/Middle F1{s} {w} OWC" for s in "+-" for w in ("above", "below")]
    assert len(scene.units) == 10  # four zones in two blocks, and the reservoir in two parts
    across = scene.juxtaposition("F1").to_dataframe()
    assert across.area[across.kind == "juxtaposed"].sum() > across.area.sum() / 3
