"""Keys of a scenario: what they may say, the errors for wrong ones, and the page that lists them."""

# ruff: noqa: E501 - the table has one case per line

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest

from geosurf.errors import ScenarioError
from geosurf.scenario import read_scenario
from geosurf.scenario.keys import BoxRanges
from geosurf.scenario.output_keys import OutputSettings

ROOT = Path(__file__).resolve().parents[2]


BAD = {
    "unknown key": (('file = "Base.nc"', 'flie = "Base.nc"'), r"unknown key 'flie' in horizons\['Base'\]; known keys are .*Did you mean 'file'"),
    "missing key": (('name = "F1"\n', ""), r"'name' is missing in faults\[number 1\]; give text between quotes"),
    "missing file": (('"Base.nc"', '"Bsae.nc"'), r"horizons\['Base'\].file is 'Bsae.nc', and .* is not there. Paths are relative to .*Did you mean 'Base.nc'"),
    "duplicate fault": (('name = "F1"', 'name = "Top"'), r"'Top' is the name of a horizon and of a fault; rename"),
    "box in the wrong order": (("[-2500, -1700]", "[-1700, -2500]"), r"box.elevation_m is \[-1700, -2500\]; it must be two numbers, the lower one first"),
    "number as text": (('name = "F1"', "name = 1"), r"faults\[number 1\].name is 1; it must be text between quotes"),
    "table for tables": (("[[faults]]", "[faults]"), r"faults must be tables in double brackets, as in \[\[faults\]\]"),
    "unknown view": (('["southwest"]', '["southwets"]'), r"output.views has 'southwets'; it may have .*Did you mean 'southwest'"),
    "picture size": (("[400, 260]", "[400, true]"), r"output.size_px is \[400, True\]; it must be two whole numbers, \[width, height\], from \[200, 150\]"),
    "switch": (("size_px", "maps = 1\nsize_px"), r"output.maps is 1; it must be true or false"),
    "search names": (('["Top", "F1"]', '["Top", "F2"]'), r"output.search: unknown surface 'F2'; the scenario has 'Top', 'Base', 'F1'"),
    "colour": (("[output]", '[pictures]\ncolours = {Top = "tael"}\n[output]'), r"pictures.colours: the colour of 'Top' is 'tael'.*Did you mean 'teal'"),
    "camera": (("[output]", "[pictures]\ncamera = [0, 91]\n[output]"), r"pictures.camera is \[0, 91\]; it must be azimuth and height"),
    "wells": (("[output]", '[pictures]\nwells = {W1 = "no.csv"}\n[output]'), r"pictures.wells.W1 is 'no.csv', and .* is not there"),
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
    with pytest.raises(ScenarioError, match=sentence) as caught:
        read_scenario(path)
    assert re.match(rf"{re.escape(str(path))}(, line \d+)?: ", str(caught.value))


def test_an_empty_scenario_needs_a_horizon(scenario):
    with pytest.raises(ScenarioError, match=r"no horizons are given. Add .*\[\[horizons\]\]"):
        read_scenario(scenario(body=""))


def test_the_page_is_in_step_with_the_code():
    page = (ROOT / "docs" / "scenario.md").read_text(encoding="utf-8")
    made = subprocess.run(
        [sys.executable, ROOT / "docs" / "scenario_page.py"], capture_output=True, check=True
    )
    assert page == made.stdout.decode(), "run: python docs/scenario_page.py > docs/scenario.md"
    for kind in (OutputSettings, BoxRanges):
        assert all(f"`{entry.name}`" in page for entry in fields(kind))
