"""Well tops from files as programs export them; what cannot be used is refused or listed."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import FormatError, GeosurfWarning, InputError

PETREL = """# Petrel well tops
# Unit in X and Y direction: m
# Unit in depth: ft
VERSION 2
BEGIN HEADER
X
Y
Z
TWT picked
MD
Type
Surface
Well
END HEADER
459123.1 5932000.2 -5400.0 -999 1700.2 Horizon "Top Volantis" "55/33-1 A"
459200.0 5932000.2 -5500.0 -999 1800.2 HORIZON "Base" "55/33-1 A"
459200.0 5932000.2 -5500.0 -999 1900.2 FAULT "F1" "55/33-1 A"
459200.0 5932000.2 -999 -999 1900.2 HORIZON "Base" "55/33-2"
"""
RMS = """String Horizon
String Well
Float MD
! a comment
459123.1 5932000.2 1600.0 TopVolantis OP_1 1700
459124.1 5932000.2 UNDEF TopVolantis OP_2 1700
"""


def write(folder, text, name="tops.csv"):
    """A file of that text."""
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def rows(tops):
    """Tops as rows of well, horizon, easting, northing and elevation."""
    names = ("well", "horizon", "easting", "northing", "elevation")
    return list(zip(*(tops[name].values.tolist() for name in names), strict=True))


def test_petrel_files_hold_elevations_and_declare_their_unit(tmp_path):
    with pytest.warns(GeosurfWarning, match="2 of 4 rows of 'tops.txt' are not used") as found:
        tops = gs.read_tops(write(tmp_path, PETREL, "tops.txt"))
    assert [row[:2] for row in rows(tops)] == [
        ("55/33-1 A", "Top Volantis"), ("55/33-1 A", "Base"),
    ]  # fmt: skip
    assert tops.elevation.values.tolist() == pytest.approx([-5400 * 0.3048, -5500 * 0.3048])
    assert found[0].message.kind == "tops"
    first, second = tops.attrs["unused"]
    assert "type 'FAULT'" in first
    assert second == "'Base' in well '55/33-2' (line 18) has undefined z"


def test_rms_points_with_attributes(tmp_path):
    with pytest.warns(GeosurfWarning, match="undefined z"):
        tops = gs.read_tops(write(tmp_path, RMS, "tops.rmsattr"), positive="down")
    assert rows(tops) == [("OP_1", "TopVolantis", 459123.1, 5932000.2, -1600.0)]


@given(
    st.permutations(["Well", "X", "Y", "TVDSS", "Surface", "MD"]),
    st.sampled_from([",", ";", "\t", " "]),
    st.booleans(),
)
def test_law_columns_may_come_in_any_order_and_with_any_separator(order, sign, comma):
    import pathlib
    import tempfile

    comma = comma and sign != ","
    values = {"Well": '"W 1"', "X": "10.25", "Y": "20.5", "TVDSS": "1500.5", "Surface": "Top"}
    values["MD"] = "1700.0"
    line = sign.join(values[name] for name in order)
    with tempfile.TemporaryDirectory() as folder:
        text = f"{sign.join(order)}\n{line.replace('.', ',') if comma else line}\n"
        file = write(pathlib.Path(folder), text, "tops.txt")
        found = gs.read_tops(file, positive="down", decimal="," if comma else ".")
    assert rows(found) == [("W 1", "Top", 10.25, 20.5, -1500.5)]


@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        ("Well,X,Y,MD,Surface\nW1,1,5,2,Top\n", {}, "below the rig .MD or TVD.*Export .* TVDSS"),
        ("Well,X,Y,Z,TVDSS,Surface\nW1,1,5,2,3,Top\n", {}, "found 2 columns for z.*Set columns="),
        ("Wel,X,Y,Z,Top\nW1,1,5,2,Top\n", {}, "found 0 columns for well.*Set columns="),
        ("W1,1,5,2,Top\n", {}, r"no header.*columns=\(1, 2, 3, 4, 5\)"),
        ("Well;X;Y;Z;Top\nW1;1,5;2;3;Top\n", {}, r"line 2: found '1,5'.*pass decimal=','"),
        ("Well,X,Y,Z,Top\nW1,1,5,2,3,Top\n", {}, "line 2: found 6 values, expected 5.*decimal=','"),
        ("Well,X,Y,Z,Top\n,1,5,2,Top\n", {}, "line 2: the name of the well is missing"),
        ("Well,X,Y,Z,Top\nW1,1,5,-999,Top\n", {}, "has no well tops: 'Top' in well 'W1'"),
        ("BEGIN HEADER\nX\n1 2 3\n", {}, "BEGIN HEADER has no END HEADER"),
        ("W1 1 5 2 Top\n", {"columns": (1, 2, 3, 4, 9)}, "a line has 5 values"),
        ("W1 1 5 2 Top\n", {"columns": ("Well", "X")}, "columns is .*5 names"),
        ("Well,X,Y,Z [ft],Top\nW1,1,5,2,Top\n", {"length_unit": "m"}, "length unit 'ft'"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_in_words(tmp_path, text, words, message):
    with pytest.raises(InputError, match=f"(?s){message}"):
        gs.read_tops(write(tmp_path, text), positive="up", **words)


def test_repeated_rows_are_listed_and_a_second_place_is_a_top_of_its_own(tmp_path):
    text = "Well,X,Y,Z,Top\nW1,1,5,-2,Top\nW1,1,5,-2,Top\nW1,1,5,-3,Top\n"
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        tops = gs.read_tops(write(tmp_path, text), positive="up")
    assert tops.elevation.values.tolist() == [-2.0, -3.0]
    assert len(found) == 1
    assert "line 3) is there twice" in str(found[0].message)


def test_columns_by_name_and_by_number(tmp_path):
    file = write(tmp_path, "Hole,E,N,Sub,Pick\nW1,1,5,2,Top\n")
    by_name = gs.read_tops(file, positive="up", columns=("Hole", "E", "N", "Sub", "Pick"))
    by_number = gs.read_tops(file, positive="up", columns=(1, 2, 3, 4, 5))
    assert rows(by_name) == rows(by_number) == [("W1", "Top", 1.0, 5.0, 2.0)]
    assert np.issubdtype(by_name.easting.dtype, np.float64)


WELLS = (
    "Well,MD,X,Y,Z\nW-1,0,0,0,20\nW-1,1000,0,0,-980\nW-1,2000,600,0,-1780\nB,0,9,9,0\nB,5,9,9,-5\n"
)


@pytest.fixture
def paths(tmp_path):
    (tmp_path / "wells.csv").write_text(WELLS)
    return gs.read_wells(tmp_path / "wells.csv", positive="up")


def test_tops_with_measured_depths_lie_on_the_paths_of_their_wells(tmp_path, paths):
    path = tmp_path / "tops.csv"
    path.write_text("Well,Surface,MD\nW-1,Top,1000\nW-1,Base,1500\nW-1,Deep,2001\nB,Top,-999.25\n")
    with pytest.warns(gs.GeosurfWarning, match="2 of 4 rows"):
        tops = gs.read_tops(path, wells=paths)
    assert tops.easting.values.tolist() == [0.0, 300.0]
    assert tops.elevation.values.tolist() == [-980.0, -1380.0]
    assert "'Deep' in well 'W-1' (line 4) is beyond the path of its well" in tops.attrs["unused"]

    # other names of columns, and feet
    path.write_text("Id,Pick,DEPT\nW-1,Top,1000\n")
    found = gs.read_tops(path, wells=paths, columns=("Id", "DEPT", "Pick"), length_unit="ft")
    assert found.elevation.values.tolist() == [pytest.approx(20 - 304.8)]


def test_measured_tops_without_their_path_are_refused(tmp_path, paths):
    path = tmp_path / "tops.csv"
    path.write_text("Well,Surface,MD\nW-2,Top,1000\n")
    with pytest.raises(FormatError, match=r"pass wells=gs\.read_wells"):
        gs.read_tops(path, positive="up")
    with pytest.raises(
        FormatError, match=r"line 2: well 'W-2' has no path in wells=\. Did you mean"
    ):
        gs.read_tops(path, wells=paths)
    with pytest.raises(InputError, match=r"wells= has no md\. Pass what gs\.read_wells"):
        gs.read_tops(path, wells=paths.drop_vars("md"))
    with pytest.raises(
        InputError, match="Give 3 names of the header, those of well, measured depth"
    ):
        gs.read_tops(path, wells=paths, columns=(1, 2, 3, 4, 5))


def test_a_well_of_gocad_is_refused_with_what_to_do(tmp_path):
    path = tmp_path / "a.wl"
    path.write_text("GOCAD Well 1\nHEADER {\nname: W-1\n}\nWREF 0 0 25\nPATH 0 25 0 0\nEND\n")
    for read in (gs.read_wells, gs.read_tops):
        with pytest.raises(FormatError, match=r"of the kind GOCAD Well.*with Well, MD, X, Y and Z"):
            read(path, positive="up")
    with pytest.raises(FormatError, match="file of the kind GOCAD Well"):
        gs.read_points(path, positive="up")
    assert "geosurf does not read" in str(gs.info(path))
