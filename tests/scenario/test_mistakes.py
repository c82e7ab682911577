"""All mistakes of a scenario at once, each with its line."""

# ruff: noqa: E501 - the table has one case per line

from __future__ import annotations

import itertools
import json
import re
import runpy
from dataclasses import fields
from pathlib import Path

import pytest

from geosurf.cli import main
from geosurf.errors import ScenarioError
from geosurf.scenario import read_scenario
from geosurf.scenario.keys import BoxRanges
from geosurf.scenario.output_keys import OutputSettings
from geosurf.scenario.validate import find_mistakes
from tests.messages import refused

RIGHT = """title = "A"
[[horizons]]
name = "Top"
file = "scenario.toml"
positive = "down"
[[horizons]]
name = "Base"
file = "scenario.toml"
positive = "down"
[[faults]]
name = "F1"
file = "scenario.toml"
extend = ["strike"]
[box]
easting_m = [0, 6000]
northing_m = [0, 5000]
elevation_m = [-3000, 0]
[[contacts]]
name = "OWC"
elevation_m = -1700
zones = ["Top/Base"]
block = "F1+"
[tear]
horizons = ["Top"]
trim_cells = 2.0
[output]
size_px = [1280, 800]
views = ["top"]
"""
# a line of the file above, what stands there instead, and a part of the message
MISTAKES = [
    (1, 'titel = "A"', "unknown key 'titel'"),
    (3, "name = 3", "horizons[number 1].name is 3"),
    (4, 'file = "none.gri"', "is not there"),
    (5, 'positive = "downward"', "Did you mean 'down'?"),
    (8, 'fille = "scenario.toml"', "unknown key 'fille' in horizons['Base']"),
    (13, 'extend = "yes"', "faults['F1'].extend is 'yes'"),
    (15, "easting_m = [6000, 0]", "the lower one first"),
    (16, "northing = [0, 5000]", "unknown key 'northing' in box"),
    (20, 'elevation_m = "deep"', "contacts['OWC'].elevation_m is 'deep'"),
    (21, 'zones = ["Top/Bsae"]', "unknown zone 'Top/Bsae'"),
    (22, 'block = "F9+"', "unknown block 'F9+'"),
    (24, 'horizons = ["Topp"]', "tear.horizons: unknown horizon 'Topp'"),
    (25, "trim_cells = -1", "tear.trim_cells is -1"),
    (27, "size_px = [10]", "output.size_px is [10]"),
    (28, 'view = ["top"]', "unknown key 'view' in output"),
]


def wrong(tmp_path, mistakes):
    """A scenario with some mistakes."""
    lines = RIGHT.splitlines()
    for row, line, _ in mistakes:
        lines[row - 1] = line
    path = tmp_path / "scenario.toml"
    path.write_text("\n".join(lines) + "\n")
    return path


def found_in(path):
    return [(one.line, one.sentence) for one in find_mistakes(path)]


def test_a_right_scenario_has_none(tmp_path, capsys):
    path = wrong(tmp_path, [])
    assert find_mistakes(path) == []
    assert main(["validate", str(path)]) == 0
    assert "No mistakes: 2 horizons, 1 fault." in capsys.readouterr().out


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake[1])
def test_each_mistake_has_its_line(tmp_path, mistake):
    """It is the one at which reading stops, and nothing that follows from it is listed."""
    row, _, words = mistake
    path = wrong(tmp_path, [mistake])
    ((line, sentence), *rest) = sorted(found_in(path), key=lambda one: one[0] != row)
    assert line == row
    assert words in sentence
    assert not rest or row in (3, 7, 11)  # a surface without its name is unknown elsewhere
    refused(ScenarioError, r"scenario.toml(, line \d+)?: ", read_scenario, path)


def test_a_depth_is_no_elevation_of_a_contact(tmp_path):
    """The model would refuse it after reading all files: outside of the box."""
    deep = (20, "elevation_m = 1700", "")
    ((line, sentence),) = found_in(wrong(tmp_path, [deep]))
    assert (line, "outside of the model ([box] elevation_m = [-3000, 0])" in sentence) == (20, True)

    without_box = [(14, "", ""), (15, "", ""), (16, "", ""), (17, "", "")]
    down = (1, 'positive = "down"', "")
    ((line, sentence),) = found_in(wrong(tmp_path, [deep, down, *without_box]))
    assert (line, "write -1700." in sentence) == (20, True)
    assert found_in(wrong(tmp_path, [deep, *without_box])) == []  # heights, for all that is known
    assert found_in(wrong(tmp_path, [down, *without_box])) == []


def test_all_are_found_at_once(tmp_path, capsys):
    path = wrong(tmp_path, MISTAKES)
    found = found_in(path)
    for row, _, words in MISTAKES:
        if row not in (3, 21):  # names of zones follow from those of horizons
            assert any(line == row and words in sentence for line, sentence in found), row
    assert [line for line, _ in found] == sorted(line for line, _ in found)
    assert main(["validate", str(path), "--json"]) == 2
    listed = json.loads(capsys.readouterr().out)
    assert [(row["line"], row["mistake"]) for row in listed["mistakes"]] == found


def test_no_mistake_hides_another(tmp_path):
    for pair in itertools.combinations(MISTAKES, 2):
        found = found_in(wrong(tmp_path, pair))
        for row, _, words in pair:
            # names of zones follow from those of horizons
            hidden = words.startswith("unknown zone") and pair[0][0] == 3
            there = any(line == row and words in said for line, said in found)
            assert hidden or there, (row, found)


@pytest.mark.parametrize(
    ("row", "line"),
    [
        (1, "title = A field"),
        (4, 'file = "data\\Top.gri"'),
        (5, 'name = "Base"'),
        (20, "elevation_m = -1700,5"),
        (26, "[tear]"),
    ],
)
def test_a_line_that_is_not_toml_is_named(tmp_path, row, line):
    path = wrong(tmp_path, [(row, line, "")])
    ((number, sentence),) = found_in(path)
    assert (number, "is not TOML" in sentence) == (row, True)
    refused(ScenarioError, rf"scenario.toml, line {row}: ", read_scenario, path)


@pytest.mark.parametrize(
    ("zones", "fluids", "unknown"),
    [
        ('["Top/Base"]', "", "above Level"),
        ('["Top/Base"]', 'fluids = {"above Level" = "oil"}', "below Level"),
        ('["Top/Base"]', 'fluids = {"above Level" = "oil", "below Level" = "water"}', ""),
        ('["Top/Base"]', 'fluids = {"F1+" = "oil"}', ""),  # only the model knows its blocks
        ('["below Base"]', "", "Top/Base"),
        ('["below Base"]', 'fluids = "oil"', ""),
    ],
)
def test_a_unit_without_a_fluid_costs_no_run(tmp_path, zones, fluids, unknown):
    values = "net_to_gross = 1\nporosity = 0.2\nwater_saturation = 0.3"
    volumetrics = f"[volumetrics]\n{values}\n{fluids}"
    rows = [(19, 'name = "Level"', ""), (21, f"zones = {zones}", ""), (25, volumetrics, "")]
    found = found_in(wrong(tmp_path, rows))
    assert [f'"{unknown}" = "oil"' in sentence for _, sentence in found] == [True] * bool(unknown)


# ---- Keys of a scenario: what they may say, the errors for wrong ones, and the page that lists them.
ROOT = Path(__file__).resolve().parents[2]


BAD = {
    "missing key": (('name = "F1"\n', ""), r"'name' is missing in faults\[number 1\]; give text between quotes"),
    "duplicate fault": (('name = "F1"', 'name = "Top"'), r"'Top' is the name of a horizon and of a fault; rename"),
    "table for tables": (("[[faults]]", "[faults]"), r"faults must be tables in double brackets, as in \[\[faults\]\]"),
    "unknown view": (('["southwest"]', '["southwets"]'), r"output.views has 'southwets'; it may have .*Did you mean 'southwest'"),
    "switch": (("size_px", "maps = 1\nsize_px"), r"output.maps is 1; it must be true or false"),
    "search names": (('["Top", "F1"]', '["Top", "F2"]'), r"output.search: unknown surface 'F2'; the scenario has 'Top', 'Base', 'F1'"),
    "colour": (("[output]", '[pictures]\ncolours = {Top = "tael"}\n[output]'), r"pictures.colours: the colour of 'Top' is 'tael'.*Did you mean 'teal'"),
    "camera": (("[output]", "[pictures]\ncamera = [0, 91]\n[output]"), r"pictures.camera is \[0, 91\]; it must be azimuth and height"),
    "drawn": (("[output]", '[pictures]\npoints = {W1 = "no.csv"}\n[output]'), r"pictures.points.W1 is 'no.csv', and .* is not there"),
    "syntax": (('title = "Tilted planes"', "title = Tilted"), r", line 1: 'title = Tilted' is not TOML: .*\. Put text and paths between single quotes"),
}  # fmt: skip


def test_the_look_of_pictures_becomes_a_style(scenario):
    look = 'theme = "dark"\ncolours = {Top = "#ff0000"}\ncamera = [45, 30]\nonly = ["Top/Base"]'
    pictures = read_scenario(scenario(("[output]", f"[pictures]\n{look}\n[output]"))).pictures
    assert pictures.style.dark
    assert pictures.style.colours == {"Top": (1.0, 0.0, 0.0)}
    assert (pictures.camera, pictures.only) == ((45.0, 30.0), ("Top/Base",))


@pytest.mark.parametrize("change", BAD)
def test_a_wrong_scenario_gets_an_error_with_place_and_remedy(change, scenario):
    exchange, sentence = BAD[change]
    path = scenario(exchange)
    error = refused(ScenarioError, sentence, read_scenario, path)
    assert re.match(rf"{re.escape(str(path))}(, line \d+)?: ", str(error))


def test_an_empty_scenario_needs_a_horizon(scenario):
    with pytest.raises(ScenarioError, match=r"no horizons are given. Add .*\[\[horizons\]\]"):
        read_scenario(scenario(body=""))


def test_the_page_is_in_step_with_the_code(capsys):
    page = (ROOT / "docs" / "scenario.md").read_text(encoding="utf-8")
    runpy.run_path(str(ROOT / "docs" / "scenario_page.py"), run_name="__main__")
    assert page == capsys.readouterr().out, "run: python docs/scenario_page.py > docs/scenario.md"
    for kind in (OutputSettings, BoxRanges):
        assert all(f"`{entry.name}`" in page for entry in fields(kind))
