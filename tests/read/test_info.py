"""`geosurf info` and `gs.info`: every real file is recognised, and doubts are named."""

from __future__ import annotations

import json
import os
import re
import socket
import sys

import pytest

import geosurf as gs
from geosurf import cli
from geosurf.errors import FormatError, InputError, ScenarioError
from geosurf.read import FAULT_FORMATS, HORIZON_FORMATS, POINT_FORMATS, POLYGON_FORMATS, _guard
from geosurf.scenario import read_scenario
from tests.messages import refused

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


# ---- What is no regular file is refused and never waited for; memory has a limit.
READERS = [
    (read, formats[kind][2][0])
    for read, formats in (
        (gs.read_horizon, HORIZON_FORMATS),
        (gs.read_fault, FAULT_FORMATS),
        (gs.read_points, POINT_FORMATS),
        (gs.read_polygons, POLYGON_FORMATS),
        (lambda path, **_: gs.read.read_tsurf(path), {"tsurf": FAULT_FORMATS["tsurf"]}),
    )
    for kind in formats
]


@pytest.mark.skipif(sys.platform == "win32", reason="there are no named pipes among files")
@pytest.mark.parametrize(("read", "suffix"), READERS)
def test_only_regular_files_are_read(tmp_path, read, suffix):
    pipe, folder, device, gone, server, loop = (
        tmp_path / f"{word}{suffix}" for word in ("p", "f", "d", "gone", "s", "loop")
    )
    os.mkfifo(pipe)
    folder.mkdir()
    device.symlink_to("/dev/zero")
    gone.symlink_to(tmp_path / "nowhere")
    loop.symlink_to(loop)
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(os.path.relpath(server))  # names of sockets are short
        kinds = (
            (pipe, "named pipe"),
            (folder, "folder"),
            (device, "device"),
            (server, "cannot be"),
        )
        for path, kind in (*kinds, (gone, "cannot be"), (loop, "cannot be")):
            refused(InputError, rf"{path.name}: .*{kind}", read, path, positive="up")


def test_a_file_that_grows_is_not_read(tmp_path, monkeypatch):
    path = tmp_path / "a.xyz"
    path.write_text("0 0 1\n")
    kept = os.fstat

    def smaller(handle):
        """A size from before the last line was written."""
        found = list(kept(handle))
        found[6] -= 2
        return os.stat_result(found)

    monkeypatch.setattr(_guard.os, "fstat", smaller)
    with pytest.raises(InputError, match=r"a\.xyz: the file grew from 4 to 5 bytes"):
        gs.read_points(path, positive="up")


def test_the_limit_grows_with_the_file_and_is_set_by_a_word(monkeypatch, tmp_path):
    monkeypatch.delenv(_guard.BUDGET, raising=False)
    assert _guard.limit_of(0) == _guard.ALLOWANCE
    assert _guard.limit_of(10**9) == _guard.MULTIPLE * 10**9
    for text, bytes_ in (("1", 1), ("3 kB", 3 << 10), ("4GiB", 4 << 30), ("2t", 2 << 40)):
        monkeypatch.setenv(_guard.BUDGET, text)
        assert _guard.limit_of(10**9) == bytes_
    for text in ("much", "-1GB", "1.5GB", "\u0661"):
        monkeypatch.setenv(_guard.BUDGET, text)
        refused(InputError, r"GEOSURF_READ_MEMORY is .*=4GB", _guard.limit_of, 1)
    monkeypatch.setenv(_guard.BUDGET, "1MB")
    _guard.refuse_large(tmp_path, 1 << 20, 1, "array 'z'")
    with pytest.raises(FormatError, match=r"array 'z' needs 2 MB.*GEOSURF_READ_MEMORY=1GB"):
        _guard.refuse_large(tmp_path, 2 << 20, 1, "array 'z'")
    monkeypatch.setenv(_guard.BUDGET, "99TB")
    monkeypatch.setattr(_guard, "free_memory", lambda: 1 << 30)
    with pytest.raises(FormatError, match=r"needs 2 048 MB of memory, but only 1 024 MB are free"):
        _guard.refuse_large(tmp_path, 2 << 30, 1, "array 'z'")


@pytest.mark.skipif(sys.platform == "win32", reason="there are no named pipes among files")
def test_a_scenario_is_a_regular_file(tmp_path):
    os.mkfifo(tmp_path / "a.toml")
    refused(ScenarioError, r"a\.toml: this is a named pipe", read_scenario, tmp_path / "a.toml")
