"""`geosurf info` and `gs.info`: every real file is recognised, and doubts are named."""

from __future__ import annotations

import json
import re

import pytest

import geosurf as gs
from geosurf import cli

# suffix of a file, or its folder -> format by content; None: texts that are no data
EXPECTED = {
    ".gri": "irap",
    ".zmap": "zmap",
    ".ts": "tsurf",
    ".ml": "model3d",
    ".poi": "xyz",
    ".vs": "vset",
}
STATED = ("The file does not state", "Easting and northing are below 360")


def test_every_shared_file_is_read_as_what_it_is(shared):
    seen = 0
    for path in sorted((shared / "data").rglob("*.*")):
        key = EXPECTED.get(path.suffix)
        if key is None or path.name == "F2.poi":
            continue
        if path.suffix == ".poi" and path.name != "TopVolon.poi":
            continue  # one of four files of one kind
        found = gs.info(path)
        assert found.format == key, path
        assert found.count > 0, found.doubts
        assert all(doubt.startswith(STATED) for doubt in found.doubts), (path, found.doubts)
        seen += 1
    assert seen > 25


def test_the_command_prints_text_and_json(tmp_path, capsys):
    top = tmp_path / "top.xyz"
    top.write_text("-996 2 10 10\n500 510 0 10\n2 30 500 0\n0 0 0 0 0 0 0\n1 2\n3 -999.25\n")
    assert cli.main(["info", str(top)]) == 0
    said = capsys.readouterr().out
    for words in (r"IRAP classic", r"rotation +30 degrees", r"sign +open", r"z +-999.25 to 3.00 m"):
        assert re.search(words, said)
    assert "1 values are -999.25, which many programs write for undefined" in said

    assert cli.main(["info", "--json", str(top)]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert (found["format"], found["count"], found["extent"]["z"]) == ("irap", 4, [-999.25, 3.0])
    assert cli.main(["info", str(tmp_path / "gone")]) == 2


@pytest.mark.parametrize(
    ("name", "text", "format_", "doubt"),
    [
        ("a.dat", "815 1210 777574.2 6736507.8 1000.0\n", "xyz", r"columns=\(3, 4, 5\)"),
        ("a.dat", "460000,25 5930000,5 1700,1\n", "xyz", r"decimal=','"),
        ("a.pol", "0 0 5\n1 1 5\n", "polygons", "no line 999 999 999 after the last line"),
        ("a.grd", "DSAA\n3 2\n", "surfer", "lines 2 to 5: expected two values"),
        ("a.md", "Some words, 3 of 4.\n", "unknown", "knows no format with this content"),
        ("a.tif", "II*\0", "geotiff", "rasterio"),
        ("a.json", '{"type": "Feature"', "geojson", "JSON parser cannot read it"),
        ("a.xyz", "1 2 -9999\n3 4 5\n", "xyz", "may be degrees"),
        ("a.csv", "X,Y,Z,Well\n1,2,3,A\n", "wells", "in one place"),
    ],
)
def test_doubts_say_which_word_is_missing(tmp_path, name, text, format_, doubt):
    (tmp_path / name).write_text(text)
    found = gs.info(tmp_path / name)
    assert found.format == format_
    assert re.search(doubt, " ".join(found.doubts))
