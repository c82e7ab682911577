"""Tables in text: what is a number, which columns are coordinates, blocks, marks of no data."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.conventions.checks import NO_DATA
from geosurf.errors import FormatError, GeosurfError, InputError
from geosurf.read import _common
from geosurf.read._common import TextBlocks, is_number, numbers
from tests.messages import refused

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


PLACE = (*[st.decimals(-999, 9e6, places=2)] * 2, st.decimals(-999, 9e5, places=2))


@given(st.lists(st.tuples(*PLACE), min_size=1, max_size=4), st.sampled_from([" ", "\t", ";", "; "]))
def test_law_decimal_commas_are_refused_or_read(tmp_path_factory, rows, sign):
    folder = tmp_path_factory.mktemp("a")
    text = "".join(sign.join(map(str, row)) + "\n" for row in rows)
    plain = write(folder, text.replace(";", " "))
    comma = write(folder, text.replace(".", ","), "b.txt")
    assert points(comma, decimal=",") == points(plain)
    refused(FormatError, r"b\.txt, line 1: .*decimal=','", points, comma)
    header = write(folder, "X;Y;Z\n" + comma.read_text().replace(sign, ";"), "c.csv")
    assert points(header, decimal=",") == points(plain)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.dat", "815 1210 777574.2 6736507.8 1000.0\n", r"line 1: found 5 numbers.*columns=\(3"),
        ("a.dat", "1 460000 5930000 1700\n", r"line 1: found 4 numbers and no header"),
        ("a.dat", "A1 1 2 3\n1 2 3 A\n", r"line 2: numbers .* \[1, 2, 3\].*\[2, 3, 4\]"),
        ("a.dat", "460000,25 5930000,5 1700,1\n", r"the comma in '460000,25'.*decimal=','"),
        ("a.csv", 'X,Y,Z\n"1,5","2,5","3,5"\n', r"line 2: found '1,5'.*decimal=','"),
        ("a.csv", "1,2,3\n", r"line 1: found 0 columns for x in '1'.*These are numbers: write"),
        ("a.xyz", "1_000 0 5\n", r"line 1: found '1_000', expected a number"),
        ("a.xyz", "\ufeff", r"contains only white space"),
        ("a.poi", "1 2 3\0\n", r"byte 5 is zero, so this is not a text file.*format="),
        ("a.xyz", "X Y Z\n1 2 3\n1 2 3 4\n", r"line 3: found 4 values, expected 3 as in the h"),
        ("a.csv", "X,Y,W\n1,2,3\n", r"line 1: found 0 columns for z.*Rename"),
        ("a.csv", "X,Y,Z\n", r"the file has no points below the header"),
    ],
)
def test_what_may_be_no_coordinate_is_refused(tmp_path, name, text, message):
    refused(FormatError, message, points, write(tmp_path, text, name))


def test_columns_by_number_and_their_errors(tmp_path):
    path = write(tmp_path, "815 1210 7.5 6.5 1\n816 1210 8.5 9.5 2\n999 999 999\n", "a.dat")
    assert points(path, columns=(3, 4, 5)) == [[7.5, 6.5, 1], [8.5, 9.5, 2]]
    csv = write(tmp_path, "1,2,3,4\n5,6,7,8\n", "a.csv")
    assert points(csv, columns=(4, 3, 2)) == [[4, 3, 2], [8, 7, 6]]
    headed = write(tmp_path, "id,a,b,c\n5,6,7,8\n", "b.csv")
    assert points(headed, columns=(2, 3, 4)) == [[6, 7, 8]]
    for wrong in ((1, 2), (0, 1, 2), (1, "Y", 3), (True, 2, 3), 3):
        refused(InputError, r"columns is .*columns=\(3, 4, 5\)", points, path, columns=wrong)
    with pytest.raises(FormatError, match=r"line 1: found 5 values, expected at least 6"):
        points(path, columns=(4, 5, 6))
    refused(FormatError, r"line 1: the header has 4 columns", points, headed, columns=(3, 4, 5))
    with pytest.raises(FormatError, match=r"line 1: the file has no header.*columns=\(1"):
        points(path, columns=("x", "y", "z"))
    refused(InputError, r"decimal is ';', expected", points, path, decimal=";")


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
    with pytest.raises(InputError, match=r"columns= and decimal= apply to tables of text"):
        gs.read_fault(mesh, columns=(1, 2, 3))


def test_999_ends_points_on_the_last_lines_only(tmp_path):
    body = "461000.0 5930000.0 1700.0\n461100.0 5930000.0 1701.0\n"
    end = "999.0 999.0 999.0\n"
    assert len(points(write(tmp_path, body + end, "a.poi"))) == 2
    assert len(points(write(tmp_path, body + end + "\n" + end, "b.poi"))) == 2
    with pytest.raises(FormatError, match=r"line 3: '999 999 999' ends a polyline"):
        points(write(tmp_path, body + end + body, "c.poi"))
    refused(FormatError, r"the file has end marks only", points, write(tmp_path, end, "d.poi"))


# ---- A text in blocks is the whole text, whatever its line ends and the size of blocks.
words = st.text("01.e-+ \tné\n\r", max_size=60)


@given(words, st.integers(4, 9))
def test_law_blocks_join_to_the_text(text, size):
    text += "1\n"
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(_common, "BLOCK", size)
        path = Path(folder) / "a.txt"
        path.write_bytes(b"\xef\xbb\xbf" + text.encode())
        plain = text.replace("\r\n", "\n").replace("\r", "\n")
        found = list(TextBlocks(path))
        assert "".join(piece for _, piece in found) == plain
        starts = np.cumsum([1] + [piece.count("\n") for _, piece in found])[:-1]
        assert [line for line, _ in found] == starts.tolist()
        assert all(piece.endswith("\n") for _, piece in found)


def map_of_numbers(n, word="-1600.25", end="\n"):
    """A ZMAP+ map of n x n nodes; its last value is `word`."""
    body = [" -1600.25"] * (n * n - 1) + [f" {word}"]
    lines = ["".join(body[k : k + 5]) for k in range(0, len(body), 5)]
    head = ["@top, GRID, 5", "15, -99, , 2, 1"]
    return end.join([*head, f"{n}, {n}, 0, 10, 0, 10", "0, 0, 0", "@", *lines, ""])


def test_cut_files_are_refused(tmp_path):
    path = tmp_path / "top.zmap"
    text = map_of_numbers(300)
    path.write_text(text[: text.rindex("\n", 0, -1) + 1])
    refused(FormatError, "incomplete", gs.read_horizon, path, positive="up")
    path.write_text(text[:-1])
    with pytest.warns(gs.errors.GeosurfWarning, match="no line end follows .* may be cut off"):
        gs.read_horizon(path, positive="up")
    path.write_text(text + "1\n")
    refused(FormatError, "found 90001 values, expected 90000", gs.read_horizon, path, positive="up")


# ---- Marks of no data in wells, sticks and polygons: refused with their place, in every unit.
STRONG = [*(mark for mark in NO_DATA if mark != 999.0), 1e20, 1e30, 1.70141e38]


@pytest.mark.parametrize("unit", ["m", "ft"])
@pytest.mark.parametrize("mark", [sign * mark for mark in STRONG for sign in (1, -1)])
def test_law_no_mark_becomes_a_place(tmp_path, mark, unit):
    (tmp_path / "lines.csv").write_text(f"X,Y,Z,POLY_ID\n0,0,-100,1\n10,0,{mark!r},1\n9,9,-100,1\n")
    with pytest.raises(GeosurfError, match=r"point 2 of line 1 has .* mark of no data"):
        gs.read_polygons(tmp_path / "lines.csv", positive="up", length_unit=unit)
    (tmp_path / "wells.csv").write_text(
        f"Well,X,Y,TVDSS\nA,1000,1000,-25\nA,1000,1000,500\nA,1000,1000,{mark!r}\nA,1000,1000,900\n"
    )
    with pytest.raises(GeosurfError, match=r"line 4: well 'A' has .* mark of no data"):
        gs.read_wells(tmp_path / "wells.csv", positive="down", length_unit=unit)
    scale = {"m": 1.0, "ft": 0.3048}[unit]
    stick = [[0.0, 500, -1000], [0, 520, mark * scale], [0, 560, -1600]]
    with pytest.raises(GeosurfError, match=r"point 2 of stick 1 has .* mark of no data"):
        gs.FaultSticks("F", [np.add(stick[0], [[9, 0, 0], [9, 9, -9]]), np.array(stick)])


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("mark", [-999.0, -999.25, -9999.0, 99999.0, 1e30])
def test_law_no_mark_becomes_an_easting_or_a_northing(tmp_path, axis, mark):
    corner = np.array([460_000.0, 5_930_000, -100])
    clean = corner + np.array([[0, 0, 0], [10, 50, -10], [90, 60, -20]])
    places = clean.copy()
    places[1, axis] = mark
    rows = [" ".join(map(repr, map(float, one))) for one in places]
    (tmp_path / "a.pol").write_text("\n".join([*rows, "999.0 999.0 999.0", ""]))
    with pytest.raises(GeosurfError, match=r"point 2 of line 1 has .* mark of no data"):
        gs.read_polygons(tmp_path / "a.pol", positive="up")
    with pytest.raises(GeosurfError, match=r"point 2 of stick 1 has .* mark of no data"):
        gs.FaultSticks("F", [clean - np.array([0, 0, 9]), places])
    columns = dict(zip(("easting", "northing", "elevation"), places.T, strict=True))
    tops = {"well": ["A", "B", "C"], "horizon": ["Top"] * 3, **columns}
    box = (460_000, 460_100, 5_930_000, 5_930_100, -200, -50)
    plane = gs.TriSurface("Top", "horizon", clean, [[0, 1, 2]])
    with pytest.raises(GeosurfError, match=r"'Top' in well 'B' has .* mark of no data"):
        gs.Scene({"Top": plane}, {}, box, tops=tops).misfit()


def test_law_measured_places_are_no_marks():
    """Whole numbers, 999 m and 9999 ft among them, are depths; only 999 999 999 is none."""
    z = np.concatenate([-np.arange(0.0, 9000.0), -0.3048 * np.arange(9000.0, 10100.0)])
    z = z[z != -999.25]
    gs.FaultSticks(
        "F", [np.column_stack([0 * z, 0 * z, z]), np.column_stack([0 * z + 9, 0 * z, z])]
    )
    refused(GeosurfError, r"has 999", gs.FaultSticks, "F", [[[0, 0, -9], [-999, -999, -999]]])


def test_a_path_longer_than_its_measured_depth_is_refused(tmp_path):
    (tmp_path / "w.csv").write_text(
        "Well,X,Y,TVDSS,MD\nA,0,0,-25,0\nA,0,0,500,525\nA,0,0,-1000,800\nA,0,0,1200,1225\n"
    )
    with pytest.raises(GeosurfError, match=r"line 4: well 'A' goes 1500 m while .* by 275 m"):
        gs.read_wells(tmp_path / "w.csv", positive="down")


def test_a_table_of_several_horizons_is_named(tmp_path):
    lines = [f"{k},{k},-9,{k % 2}" for k in range(6)]
    path = write(tmp_path, "\n".join(["X,Y,Z,val", *lines, ""]), "both.csv")
    with pytest.warns(gs.GeosurfWarning, match="its column 'val' has 2 values") as issued:
        assert len(points(path)) == 6
    assert len(issued) == 1
    assert gs.info(path).notes["objects"].startswith("its column 'val' has 2 values")
    assert len(points(path, columns=("X", "Y", "Z"))) == 6  # who names columns knows the others
    measured = [f"{k},{k},-9,{k}.5" for k in range(6)]  # a value for each point is no name
    assert len(points(write(tmp_path, "\n".join(["X,Y,Z,val", *measured, ""]), "one.csv"))) == 6


def test_columns_in_another_order_are_refused(tmp_path):
    path = write(tmp_path, "1600 460000 5930000\n1700 460050 5930000\n")
    refused(FormatError, r"z is around 5930000.*columns=\[2, 3, 1\]", points, path)
    assert points(path, columns=(2, 3, 1))[0] == [460000.0, 5930000.0, 1600.0]
