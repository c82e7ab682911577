"""`geosurf info` and `gs.info`: every real file is recognised, and doubts are named."""

from __future__ import annotations

import json
import re
import zipfile

import pytest

import geosurf as gs
from geosurf import cli
from geosurf.errors import GeosurfError, InputError

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


def test_only_files_are_looked_at(tmp_path):
    with pytest.raises(InputError, match="this is a folder"):
        gs.info(tmp_path)


def test_an_empty_file_and_a_workbook_are_named(tmp_path):
    (tmp_path / "empty.csv").write_text("")
    assert "The file is empty" in str(gs.info(tmp_path / "empty.csv"))
    (tmp_path / "wide.xyz").write_text("1 2 3\n", encoding="utf-16")
    assert "Save the file as UTF-8" in str(gs.info(tmp_path / "wide.xyz"))
    with zipfile.ZipFile(tmp_path / "tops.xlsx", "w") as book:
        book.writestr("[Content_Types].xml", "<Types/>")
        book.writestr("xl/workbook.xml", "<workbook/>")
    assert "RESQML" not in str(gs.info(tmp_path / "tops.xlsx"))
    with pytest.raises(GeosurfError, match="Excel workbook"):
        gs.read_horizon(tmp_path / "tops.xlsx")


def test_polygons_may_be_called_xyz_and_headers_of_gxf_may_be_quoted(tmp_path):
    (tmp_path / "f.xyz").write_text("0 0 9\n9 0 9\n9 9 9\n999 999 999\n")
    assert "read_polygons" in str(gs.info(tmp_path / "f.xyz"))
    assert len(gs.read_polygons(tmp_path / "f.xyz", positive="down")) == 1
    plain = "#POINTS\n2\n#ROWS\n2\n#PTSEPARATION\n10\n#RWSEPARATION\n20\n#GRID\n1 2\n3 4\n"
    quoted = re.sub(r"(?m)^(\d+)$", r'"\1"', plain)
    for name, text in (("a", plain), ("b", quoted)):
        (tmp_path / f"{name}.gxf").write_text(text)
    one, other = (gs.read_horizon(tmp_path / f"{name}.gxf", positive="up") for name in "ab")
    assert one.equals(other)
