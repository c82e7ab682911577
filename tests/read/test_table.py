"""Which columns are coordinates, and what is a number."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import FormatError, InputError
from geosurf.read._common import is_number, line_blocks, number_text, numbers

PLAIN = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
AXES = ("easting", "northing", "elevation")


def points(path, **words):
    """Points of a file as rows."""
    found = gs.read_points(path, positive="up", **words)
    return np.stack([found[axis].values for axis in AXES], axis=1).tolist()


def write(folder, text, name="a.xyz"):
    """A file of that text."""
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


@given(st.text("0123456789+-.eE_xnaif\u0661\u0be7\uff11", min_size=1, max_size=8))
def test_law_a_number_is_what_every_program_takes(word):
    plain = PLAIN.fullmatch(word) is not None
    assert (numbers([word]) is not None) == (plain and np.isfinite(float(word)))
    if plain:
        assert is_number(word)
        assert numbers(["1", word, "2"]).tolist() == [1.0, float(word), 2.0]
    elif is_number(word):
        assert word.strip("+-").lower() in ("nan", "inf", "infinity")


@given(st.text(" 1\n", max_size=60), st.integers(1, 7))
def test_law_pieces_of_a_text_are_the_text(text, size):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("geosurf.read._common.BLOCK", size)
        pieces = list(line_blocks(text))
        words = number_text(text, "a", 1, "value")
    assert "".join(piece for _, piece in pieces) == text
    at = 0
    for first, piece in pieces:
        assert first == 1 + text.count("\n", 0, at)
        at += len(piece)
    assert words.tolist() == list(map(float, text.split()))


@given(
    st.lists(st.sampled_from("nw"), min_size=3, max_size=6),
    st.integers(1, 4),
    st.sampled_from([" ", "\t", ",", ", ", ";", " ; "]),
    st.integers(1, 9),
)
def test_law_only_three_columns_of_numbers_are_coordinates(tmp_path_factory, kinds, n, sign, block):
    """Numbers and words in any columns: taken if three are numbers, otherwise columns= decides."""
    rows = [
        [str(10 * i + k) if kind == "n" else f"w{i}" for k, kind in enumerate(kinds)]
        for i in range(n)
    ]
    text = "".join(sign.join(row) + "\n" for row in rows)
    path = write(tmp_path_factory.mktemp("a"), "# a\n\n" + text)
    places = [k for k, kind in enumerate(kinds) if kind == "n"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("geosurf.read._common.BLOCK", block)
        if len(places) == 3:
            assert points(path) == [[float(row[k]) for k in places] for row in rows]
        else:
            with pytest.raises(FormatError):
                points(path)
        if len(places) >= 3:
            chosen = places[-3:][::-1]
            wanted = [[float(row[k]) for k in chosen] for row in rows]
            assert points(path, columns=[k + 1 for k in chosen]) == wanted


@given(
    st.lists(st.tuples(*[st.decimals(-999, 9e6, places=2)] * 3), min_size=1, max_size=4),
    st.sampled_from([" ", "\t", ";", "; "]),
)
def test_law_decimal_commas_are_refused_or_read(tmp_path_factory, rows, sign):
    folder = tmp_path_factory.mktemp("a")
    text = "".join(sign.join(map(str, row)) + "\n" for row in rows)
    plain = write(folder, text.replace(";", " "))
    comma = write(folder, text.replace(".", ","), "b.txt")
    assert points(comma, decimal=",") == points(plain)
    with pytest.raises(FormatError, match=r"b\.txt, line 1: .*decimal=','"):
        points(comma)
    header = write(folder, "X;Y;Z\n" + comma.read_text().replace(sign, ";"), "c.csv")
    assert points(header, decimal=",") == points(plain)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.dat", "815 1210 777574.2 6736507.8 1000.0\n", r"line 1: found 5 numbers.*columns=\(3"),
        ("a.dat", "1 460000 5930000 1700\n", r"line 1: found 4 numbers and no header"),
        ("a.dat", "A1 1 2 3\n17 1 2 3\n", r"line 2: found 4 numbers"),
        ("a.dat", "A1 1 2 3\n1 2 3 A\n", r"line 2: numbers .* \[1, 2, 3\].*\[2, 3, 4\]"),
        ("a.dat", "460000,25 5930000,5 1700,1\n", r"the comma in '460000,25'.*decimal=','"),
        ("a.dat", "460,000.25 5,930,000.5 1,700.1\n", r"the comma in '460,000.25'"),
        ("a.csv", 'X,Y,Z\n"1,5","2,5","3,5"\n', r"line 2: found '1,5'.*decimal=','"),
        ("a.csv", "1,2,3\n", r"line 1: found numbers, expected the names of columns"),
        ("a.xyz", "1_000 0 5\n", r"line 1: found '1_000', expected a number"),
        ("a.xyz", "\u0661 0 5\n", r"line 1: found '\u0661', expected a number"),
        ("a.xyz", "\ufeff", r"contains only white space"),
        ("a.csv", "\ufeff\n", r"contains only white space"),
    ],
)
def test_what_may_be_no_coordinate_is_refused(tmp_path, name, text, message):
    with pytest.raises(FormatError, match=message):
        points(write(tmp_path, text, name))


def test_columns_by_number_and_their_errors(tmp_path):
    path = write(tmp_path, "815 1210 7.5 6.5 1\n816 1210 8.5 9.5 2\n999 999 999\n", "a.dat")
    assert points(path, columns=(3, 4, 5)) == [[7.5, 6.5, 1], [8.5, 9.5, 2]]
    csv = write(tmp_path, "1,2,3,4\n5,6,7,8\n", "a.csv")
    assert points(csv, columns=(4, 3, 2)) == [[4, 3, 2], [8, 7, 6]]
    headed = write(tmp_path, "id,a,b,c\n5,6,7,8\n", "b.csv")
    assert points(headed, columns=(2, 3, 4)) == [[6, 7, 8]]
    for wrong in ((1, 2), (0, 1, 2), (1, "Y", 3), (True, 2, 3), 3):
        with pytest.raises(InputError, match=r"columns is .*columns=\(3, 4, 5\)"):
            points(path, columns=wrong)
    with pytest.raises(FormatError, match=r"line 1: found 5 values, expected at least 6"):
        points(path, columns=(4, 5, 6))
    with pytest.raises(FormatError, match=r"line 1: the header has 4 columns"):
        points(headed, columns=(3, 4, 5))
    with pytest.raises(FormatError, match=r"line 1: the file has no header.*columns=\(1"):
        points(path, columns=("x", "y", "z"))
    with pytest.raises(InputError, match=r"decimal is ';', expected"):
        points(path, decimal=";")


def test_sticks_and_outlines_have_columns_too(tmp_path):
    text = "1 0 0 5\n1 0 9 6\n999 999 999\n2 3 0 5\n2 3 9 6\n999 999 999 999\n"
    path = write(tmp_path, text, "F1.pol")
    with pytest.raises(FormatError, match=r"line 1: found 4 numbers and no header"):
        gs.read_fault(path, positive="up")
    sticks = gs.read_fault(path, positive="up", columns=(2, 3, 4)).sticks
    assert [stick.tolist() for stick in sticks] == [[[0, 0, 5], [0, 9, 6]], [[3, 0, 5], [3, 9, 6]]]
    lines = gs.read_polygons(path, positive="up", columns=(2, 3, 4))
    assert [line.tolist() for line in lines] == [stick.tolist() for stick in sticks]
    mesh = write(tmp_path, "v 0 0 0\nv 9 0 0\nv 0 9 9\nf 1 2 3\n", "F.obj")
    with pytest.raises(InputError, match=r"columns= and decimal= apply to fault sticks"):
        gs.read_fault(mesh, columns=(1, 2, 3))


def test_999_ends_points_on_the_last_lines_only(tmp_path):
    body = "461000.0 5930000.0 1700.0\n461100.0 5930000.0 1701.0\n"
    end = "999.0 999.0 999.0\n"
    assert len(points(write(tmp_path, body + end, "a.poi"))) == 2
    assert len(points(write(tmp_path, body + end + "\n" + end, "b.poi"))) == 2
    with pytest.raises(FormatError, match=r"line 3: '999 999 999' ends a polyline"):
        points(write(tmp_path, body + end + body, "c.poi"))
    with pytest.raises(FormatError, match=r"the file has end marks only"):
        points(write(tmp_path, end, "d.poi"))
