"""Keys of a scenario: what they may say, the errors for wrong ones, and the page that lists them."""

# ruff: noqa: E501 - the wrong scenarios are a table, one case per line

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest

from geosurf.errors import (
    ScenarioError,
)
from geosurf.scenario import read_scenario
from geosurf.scenario.keys import BoxRanges, Scenario
from geosurf.scenario.output_keys import OutputSettings

ROOT = Path(__file__).resolve().parents[2]


BAD = {
    "unknown table": (("[box]", "[bax]"), r"unknown key 'bax'; known keys are .*Did you mean 'box'\?"),
    "unknown key": (('file = "Base.nc"', 'flie = "Base.nc"'), r"unknown key 'flie' in horizons\['Base'\]; known keys are .*Did you mean 'file'"),
    "unknown output": (("size_px", "sise_px"), r"unknown key 'sise_px' in output; .*Did you mean 'size_px'"),
    "missing key": (('name = "F1"\n', ""), r"'name' is missing in faults\[number 1\]; give text between quotes"),
    "missing file": (('"Base.nc"', '"Bsae.nc"'), r"horizons\['Base'\].file is 'Bsae.nc', and .* is not there. Paths are relative to .*Did you mean 'Base.nc'"),
    "duplicate horizon": (('name = "Base"', 'name = "Top"'), r"'Top' is the name of a horizon and of another horizon; rename one"),
    "duplicate fault": (('name = "F1"', 'name = "Top"'), r"'Top' is the name of a horizon and of a fault; rename"),
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
    "search names": (('["Top", "F1"]', '["Top", "F2"]'), r"output.search: unknown surface 'F2'. Surfaces are 'Top', 'Base', 'F1'"),
    "search pair": (('["Top", "F1"]', '["Top", "Top"]'), r"output.search is \['Top', 'Top'\]; it must be the names of two surfaces"),
    "theme": (("[output]", '[pictures]\ntheme = "drak"\n[output]'), r"pictures.theme is 'drak'; .*Did you mean 'dark'"),
    "colour": (("[output]", '[pictures]\ncolours = {Top = "tael"}\n[output]'), r"pictures.colours: the colour of 'Top' is 'tael'.*Did you mean 'teal'"),
    "font": (("[output]", '[pictures]\nfont = "Nope"\n[output]'), r"pictures.font: font 'Nope' is not installed"),
    "colour map": (("[output]", "[pictures]\ncolour_map = 5\n[output]"), r"pictures.colour_map is 5; it must be"),
    "camera": (("[output]", "[pictures]\ncamera = [0, 91]\n[output]"), r"pictures.camera is \[0, 91\]; it must be azimuth and height"),
    "wells": (("[output]", '[pictures]\nwells = {W1 = "no.csv"}\n[output]'), r"pictures.wells.W1 is 'no.csv', and .* is not there"),
    "points": (("[output]", "[pictures]\npoints = 3\n[output]"), r"pictures.points is 3; it must be a table of names and files"),
    "zoom": (("[output]", "[pictures]\nzoom = 0\n[output]"), r"pictures.zoom is 0; it must be a number from 0.1 to 100"),
    "syntax": (('title = "Tilted planes"', "title = Tilted"), r", line 1: 'title = Tilted' is not TOML\. Put text between quotes: title = \"Tilted\""),
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
    with pytest.raises(ScenarioError, match=sentence) as caught:
        read_scenario(path)
    assert re.match(rf"{re.escape(str(path))}(, line \d+)?: ", str(caught.value))


def test_an_empty_scenario_needs_a_horizon(scenario):
    with pytest.raises(ScenarioError, match=r"no horizons are given. Add .*\[\[horizons\]\]"):
        read_scenario(scenario(body=""))


def test_a_scenario_that_is_not_there_or_no_text(tmp_path):
    with pytest.raises(ScenarioError, match=r"none.toml: cannot be read .*Check the path"):
        read_scenario(tmp_path / "none.toml")
    (tmp_path / "latin.toml").write_bytes(b'title = "\xe9"')
    with pytest.raises(
        ScenarioError, match=r"byte 9 is not UTF-8 text. Give a scenario \(TOML\), saved as UTF-8"
    ):
        read_scenario(tmp_path / "latin.toml")


def test_the_page_is_in_step_with_the_code():
    page = (ROOT / "docs" / "scenario.md").read_text(encoding="utf-8")
    made = subprocess.run(
        [sys.executable, ROOT / "docs" / "scenario_page.py"], capture_output=True, check=True
    )
    assert page == made.stdout.decode(), "run: python docs/scenario_page.py > docs/scenario.md"
    for kind in (OutputSettings, BoxRanges):
        assert all(f"`{entry.name}`" in page for entry in fields(kind))


def test_every_key_has_a_meaning():
    for kind in (Scenario, OutputSettings, BoxRanges):
        keys = [entry for entry in fields(kind) if entry.name not in ("path", "settings")]
        assert all(entry.metadata["meaning"].endswith(".") for entry in keys)
