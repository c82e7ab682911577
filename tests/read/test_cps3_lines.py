"""CPS-3 lines: polygons and fault sticks."""

from __future__ import annotations

import pytest

import geosurf as gs
from geosurf.errors import FormatError

HEAD = "FFASCI 0 0 COMPUTED 0 1.0E+30\nFFATTR 0 0\n"
LINES = f"{HEAD}-> 1\n0 0 1500\n0 50 1600\n-> 2\n90 0 1500\n95 50 1600\n->\n"


@pytest.fixture
def file(tmp_path):
    def write(text):
        path = tmp_path / "lines.dat"
        path.write_text(text)
        return path

    return write


def test_lines_are_polygons_or_sticks(file):
    path = file(LINES)
    found = gs.read_polygons(path, positive="down")
    assert [line.tolist() for line in found] == [
        [[0, 0, -1500], [0, 50, -1600]],
        [[90, 0, -1500], [95, 50, -1600]],
    ]
    assert len(gs.read_polygons(path, positive="down", name="2")) == 1
    fault = gs.read_fault(path, positive="down")
    assert (fault.name, [len(stick) for stick in fault.sticks]) == ("lines", [2, 2])
    said = gs.info(path)
    assert (said.format, said.read_with) == ("cps3_lines", "read_polygons or read_fault")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEAD + "0 0 5\n", "line 3: found '0 0 5', expected '-> name' or x y z"),
        (HEAD + "-> 1\n0 0\n", "line 4: found '0 0'"),
        (HEAD + "-> 1\n0 0 x\n", "line 4: found 'x', expected a number"),
        (HEAD + "-> 1\n->\n", "no lines with points"),
    ],
)
def test_damaged_lines_are_refused(file, text, words):
    with pytest.raises(FormatError, match=words):
        gs.read_polygons(file(text), positive="up")
