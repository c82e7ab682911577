"""Wells: paths by minimum curvature, LAS, tops, trajectories of RESQML; what is refused."""

from __future__ import annotations

import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import FormatError, GeosurfError, GeosurfWarning, InputError
from geosurf.measure.places import wells_of
from geosurf.read.wells import SAG, along_arcs
from tests.messages import refused

PETREL = """# WELL TRACE FROM PETREL
# WELL NAME:              W 1
# WELL HEAD X-COORDINATE: 1000.0 (m)
# WELL HEAD Y-COORDINATE: 1500.0 (m)
# WELL DATUM (KB, Kelly bushing, from MSL): 25.0 (m)
# XYZ TRACE IS GIVEN IN COORDINATE SYSTEM ED50-UTM31
# DEPTH (Z, TVD_Z) GIVEN IN m-UNITS
#=====
 MD X Y Z TVD DX DY AZIM_TN INCL DLS AZIM_GN
#=====
 0 1000 1500 25 0 0 0 90 0 0 90
 1725 1000 1500 -1700 1725 0 0 90 0 0 90
 2325 1400 1500 -2200 2225 0 0 90 0 0 90
"""
RMS = """1.0
Undefined
OP 1 1000.0 1500.0 25.0
2
MDepth UNK lin
Zone DISC 1 Top 2 Base
1000 1500 1700 1725 1
1400 1500 2200 2325 -999
"""
RESINSIGHT = """WELLNAME: 'Well A'
# X Y TVDMSL MDMSL
1000 1500 1700 1700
1400 1500 2200 2320
-999
WELLNAME: 'Well B'
900 1500 1750 1750
900 1500 1760 1760
-999
"""
TABLE = "Well,MD,X,Y,TVDSS\nA,0,1,2,3\nB,0,4,5,6\nA,9,1,2,12\nB,9,4,5,15\n"
SURVEY = "Well,MD,Inc,Azi\nA,0,0,0\nA,500,0,0\nA,900,40,90\n"
ROWS = "1725 1000 1500 1700\n2325 1400 1500 2200\n"
NUMBERED = {"md": 1, "x": 2, "y": 3, "z": 4}
COMMAS = "MD;X;Y;Z\n1725,0;1000;1500;-1700\n2325;1400;1500;-2200\n"
HEADS = {"A": (1000.0, 1500.0, 25.0), "s": (0.0, 0.0, 0.0)}


def written(tmp_path: Path, text: str, name: str = "s.csv") -> Path:
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    return file


# ------------------------------------------------------------ minimum curvature
@pytest.mark.parametrize("stations", [2, 3, 8])
def test_an_arc_of_a_circle_is_met_exactly(stations):
    """A well that bends from vertical to level in a plane is a quarter of a circle."""
    radius, azimuth = 800.0, 30.0
    turned = np.linspace(0.0, np.pi / 2, stations)
    places, md = along_arcs(radius * turned, np.degrees(turned), np.full(stations, azimuth))
    angle = md / radius
    away = radius * (1.0 - np.cos(angle))
    east, north = np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth))
    wanted = np.column_stack([away * east, away * north, -radius * np.sin(angle)])
    np.testing.assert_allclose(places, wanted, atol=1e-9)

    # straight lines between the points stay within the promised distance of the arc
    centre = np.array([radius * east, radius * north, 0.0])
    middle = 0.5 * (places[1:] + places[:-1])
    assert radius - np.linalg.norm(middle - centre, axis=1).min() <= SAG * (1 + 1e-9)


def test_places_are_the_integral_of_the_direction():
    """Beside a slow oracle: directions turn evenly between stations, and are summed up."""
    rng = np.random.default_rng(7)
    md = np.cumsum(rng.uniform(10.0, 60.0, 6)) - 10.0
    inc, azi = rng.uniform(0.0, 60.0, 6), rng.uniform(0.0, 360.0, 6)
    inc[2:4], azi[2:4] = 20.0, 50.0  # one straight piece
    places, depths = along_arcs(md, inc, azi)

    ways = np.column_stack(
        [np.sin(np.radians(inc)) * np.sin(np.radians(azi)),
         np.sin(np.radians(inc)) * np.cos(np.radians(azi)), -np.cos(np.radians(inc))]
    )  # fmt: skip
    at, n = np.zeros(3), 4000
    for k in range(5):
        angle = np.arccos(min(ways[k] @ ways[k + 1], 1.0))
        share = (np.arange(n) + 0.5)[:, None] / n
        turned = (1.0 - share) * ways[k] + share * ways[k + 1]
        if angle > 1e-6:
            turned = np.sin((1 - share) * angle) * ways[k] + np.sin(share * angle) * ways[k + 1]
            turned /= np.sin(angle)
        at = at + turned.mean(axis=0) * (md[k + 1] - md[k])
        np.testing.assert_allclose(places[depths == md[k + 1]][0], at, atol=1e-5)


# -------------------------------------------------------------------- layouts
def test_layouts_give_the_same_path(tmp_path):
    found = [
        gs.read_wells(written(tmp_path, PETREL, "W1.dev")).isel(point=[1, 2]),
        gs.read_wells(written(tmp_path, RMS, "W1.rmswell"), positive="down"),
        gs.read_wells(written(tmp_path, COMMAS), positive="up", decimal=","),
        gs.read_wells(written(tmp_path, "# MD X Y TVDSS\n" + ROWS, "s.txt"), positive="down"),
        gs.read_wells(written(tmp_path, ROWS, "n.txt"), positive="down", columns=NUMBERED),
    ]  # fmt: skip
    for wells in found:
        assert wells.md.values.tolist() == [1725.0, 2325.0]
        assert wells.easting.values.tolist() == [1000.0, 1400.0]
        assert wells.elevation.values.tolist() == [-1700.0, -2200.0]
    assert [wells.well.values[0] for wells in found] == ["W 1", "OP 1", "s", "s", "n"]
    assert found[0].attrs["crs"] == "ED50-UTM31"
    assert [gs.info(tmp_path / name).read_with for name in ("W1.dev", "W1.rmswell", "s.csv")] == [
        "read_wells"
    ] * 3


def test_depths_of_petrel_are_known_by_their_vertical_depth(tmp_path):
    lines = PETREL.replace(" 25 0 ", " -25 0 ").replace("-1700", "1700").replace("-2200", "2200")
    wells = gs.read_wells(written(tmp_path, lines, "W1.dev"))
    assert wells.elevation.values.tolist() == [25.0, -1700.0, -2200.0]
    with pytest.raises(FormatError, match="drift by"):
        gs.read_wells(written(tmp_path, PETREL.replace("-2200", "-2100"), "W2.dev"))


def test_a_trace_without_places_begins_at_its_head(tmp_path):
    head = PETREL[: PETREL.index(" MD X")]
    text = head + "MD INCL AZIM_GN\n0 0 0\n100 0 0\n"
    wells = gs.read_wells(written(tmp_path, text, "W1.dev"))
    assert wells.to_array("key").sel(key=["easting", "elevation"]).values.tolist() == [
        [1000.0, 1000.0], [25.0, -75.0]
    ]  # fmt: skip


def test_wells_of_one_file_stay_apart(tmp_path):
    scene_of = {"A": 2, "B": 2}
    wells = gs.read_wells(written(tmp_path, TABLE), positive="down")
    assert dict(zip(*np.unique(wells.well.values, return_counts=True), strict=True)) == scene_of
    assert wells.well.values.tolist() == ["A", "A", "B", "B"]
    # read_points keeps what parts them, in the order of the file
    points = gs.read_points(written(tmp_path, TABLE), positive="down")
    assert points.well.values.tolist() == ["A", "B", "A", "B"]
    assert points.md.values.tolist() == [0.0, 0.0, 9.0, 9.0]
    found = gs.read_wells(written(tmp_path, RESINSIGHT, "two.dev"))
    assert found.well.values.tolist() == ["Well A", "Well A", "Well B", "Well B"]
    assert found.elevation.values[-1] == -1760.0

    # what is written comes back
    gs.write(wells, tmp_path / "out.csv")
    again = gs.read_wells(tmp_path / "out.csv", positive="up")
    assert all((again[key] == wells[key]).all() for key in wells)


def test_surveys_begin_at_heads(tmp_path):
    file = written(tmp_path, SURVEY)
    heads = written(tmp_path, "Well,X,Y,KB [ft]\nA,1000,1500,100\n", "heads.csv")
    wells = gs.read_wells(file, heads=heads)
    assert wells.elevation.values[0] == pytest.approx(30.48)
    assert gs.info(heads).format == "well_heads"
    feet = gs.read_wells(file, heads=HEADS, length_unit="ft")
    metres = gs.read_wells(file, heads=HEADS)
    depth = (metres.elevation.values[-1] - 25.0) * 0.3048
    assert feet.elevation.values[-1] - 25.0 == pytest.approx(depth)


def test_paths_go_straight_into_intervals_and_pictures(tmp_path):
    wells = gs.read_wells(written(tmp_path, TABLE), positive="down")
    assert [dict(path.sizes) for path in wells_of(wells).values()] == [{"point": 2}] * 2
    for table in (wells, wells.to_dataframe()):
        overlay = gs.PictureOverlay(wells=table)
        assert [path.tolist() for (path,) in overlay.wells.values()] == [
            [[1.0, 2.0, -3.0], [1.0, 2.0, -12.0]], [[4.0, 5.0, -6.0], [4.0, 5.0, -15.0]]
        ]  # fmt: skip


# -------------------------------------------------------------------- refused
@pytest.mark.parametrize(
    ("text", "words", "match"),
    [
        (SURVEY, {}, "no place to begin at"),
        (SURVEY.replace("40", "190"), {"heads": HEADS}, "line 4: .*inclination 190"),
        (SURVEY.replace("900", "400"), {"heads": HEADS}, "line 4: .*falls from 500 m to 400 m"),
        (SURVEY.replace("A,0,0,0\nA,500,0", "A,500,9"), {"heads": HEADS}, "Add a station"),
        (SURVEY.replace("A,900,40", "A,500,40"), {"heads": HEADS}, "two directions"),
        (SURVEY.replace("40", "180"), {"heads": HEADS}, "turns by 180 degrees"),
        ("Well,MD,Inc,AZIM_TN\nA,0,0,0\n", {"heads": HEADS}, "true north"),
        ("X,Y,Z,MD\n1,2,3,4\n", {"positive": "up"}, "1 point in one place"),
        ("X,Y,Z,MD\n1,2,3,4\n1,2,x,5\n", {"positive": "up"}, "line 3: found 'x'"),
        ("1,2,3,4\n1,2,4,5\n", {"positive": "up"}, "Give the columns"),
        (TABLE, {}, "depth or elevation"),
        (TABLE, {"positive": "up", "columns": {"md": "MDD"}}, "no column is called 'MDD'"),
    ],
)  # fmt: skip
def test_what_is_open_or_wrong_is_refused(tmp_path, text, words, match):
    refused(GeosurfError, match, lambda: gs.read_wells(written(tmp_path, text), **words))


# ---- LAS: the path of a well by its curves, and tops along it.
HEAD = (
    "# made by hand\n~Version\nVERS.   2.0 : CWLS\nWRAP.    NO : one line per depth\n~Well\n"
    "NULL. -999.25 : null\nWELL.   W-1 : name of the well\n~Curve\nDEPT.M  : measured depth\n"
    "GR  .GAPI : gamma\nX   .M  : easting\nY   .M : northing\nTVDSS.FT : depth\n~A\n"
)
ROWS_LAS = (
    "0 50 461000 5932000 -100\n500 51 461100 5932200 900\n700 -999.25 -999.25 5932300 1100\n"
    "1000 52 461300 5932200 1900\n"
)
TOPS = (
    "~Tops_Definition\nTOPN. : name\nTOPT.M : depth\n~Tops_Data | Tops_Definition\n"
    "Top 250\nBase 750\nDeep 5000\n"
)


def test_the_path_is_taken_from_its_curves(tmp_path):
    path = written(tmp_path, HEAD + ROWS_LAS, "w.las")
    well = gs.read_points(path, positive="down")
    assert well.attrs["well"] == "W-1"
    assert well.md.values.tolist() == [0, 500, 1000]  # one station has no easting
    assert well.easting.values.tolist() == [461000, 461100, 461300]
    np.testing.assert_allclose(well.elevation, np.array([100, -900, -1900]) * 0.3048)
    found = gs.info(path)
    assert (found.format, found.read_with, found.count) == ("las", "read_points", 3)
    assert found.notes["columns"].startswith("x is X, y is Y, z is TVDSS, md is DEPT")
    assert found.notes["left out"] == "1 stations with -999.25"
    refused(InputError, "positive='down'", gs.read_points, path)
    same = gs.read_points(path, positive="down", columns=("X", "Y", "TVDSS"))
    assert same.equals(well)


@pytest.mark.filterwarnings("ignore:1 of 3 rows")
def test_tops_lie_on_the_path(tmp_path):
    path = written(tmp_path, HEAD + ROWS_LAS + TOPS, "w.las")
    with pytest.warns(GeosurfWarning, match="'Deep' in well 'W-1'.*is outside of the path"):
        tops = gs.read_tops(path, positive="down")
    assert tops.horizon.values.tolist() == ["Top", "Base"]
    assert tops.well.values.tolist() == ["W-1", "W-1"]
    assert tops.easting.values.tolist() == [461050, 461200]
    assert tops.northing.values.tolist() == [5932100, 5932200]
    np.testing.assert_allclose(tops.elevation, np.array([-400, -1400]) * 0.3048)
    assert gs.info(path).read_with == "read_tops"


DAMAGES = {
    "no path": (
        HEAD.replace("TVDSS", "TVDKB") + ROWS_LAS,
        "no curve of the LAS file is z; curves are",
    ),
    "wrapped": (HEAD.replace("WRAP.    NO", "WRAP. YES") + ROWS_LAS, "the LAS file is wrapped"),
    "word": (HEAD + ROWS_LAS.replace("461100", "46l100"), "line 16: found '46l100"),
    "back": (HEAD + ROWS_LAS + "900 5 1 2 3\n", "depths do not increase after 1000 m"),
    "unit": (HEAD.replace("TVDSS.FT", "TVDSS.US") + ROWS_LAS, "us"),
}


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_wells_get_one_sentence(tmp_path, case):
    text, message = DAMAGES[case]
    error = InputError if case == "unit" else FormatError
    refused(
        error, message, lambda: gs.read_points(written(tmp_path, text, "w.las"), positive="down")
    )


def test_tops_without_a_section_or_a_path_are_refused(tmp_path):
    with pytest.raises(FormatError, match="no section ~Tops with data"):
        gs.read_tops(written(tmp_path, HEAD + ROWS_LAS, "w.las"), positive="down")
    text = HEAD.replace("X   .M", "DX  .M").replace("Y   .M", "DY  .M")
    with pytest.raises(FormatError, match="no curve of the LAS file is x or y"):
        gs.read_tops(written(tmp_path, text + ROWS_LAS + TOPS, "w.las"), positive="down")


# ---- Well tops from files as programs export them; what cannot be used is refused or listed.
PETREL_TOPS = """# Petrel well tops
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
RMS_TOPS = """String Horizon
String Well
Float MD
! a comment
459123.1 5932000.2 1600.0 TopVolantis OP_1 1700
459124.1 5932000.2 UNDEF TopVolantis OP_2 1700
"""


def rows(tops):
    """Tops as rows of well, horizon, easting, northing and elevation."""
    names = ("well", "horizon", "easting", "northing", "elevation")
    return list(zip(*(tops[name].values.tolist() for name in names), strict=True))


def test_petrel_files_hold_elevations_and_declare_their_unit(tmp_path):
    with pytest.warns(GeosurfWarning, match="2 of 4 rows of 'tops.txt' are not used") as found:
        tops = gs.read_tops(written(tmp_path, PETREL_TOPS, "tops.txt"))
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
        tops = gs.read_tops(written(tmp_path, RMS_TOPS, "tops.rmsattr"), positive="down")
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
        file = written(pathlib.Path(folder), text, "tops.txt")
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
        ("Well,X,Y,Z,Top\n,1,5,2,Top\n", {}, "line 2: the name of the well is missing"),
        ("Well,X,Y,Z,Top\nW1,1,5,-999,Top\n", {}, "has no well tops: 'Top' in well 'W1'"),
        ("W1 1 5 2 Top\n", {"columns": ("Well", "X")}, "columns is .*5 names"),
        ("Well,X,Y,Z [ft],Top\nW1,1,5,2,Top\n", {"length_unit": "m"}, "length unit 'ft'"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_in_words(tmp_path, text, words, message):
    with pytest.raises(InputError, match=f"(?s){message}"):
        gs.read_tops(written(tmp_path, text), positive="up", **words)


def test_repeated_rows_are_listed_and_a_second_place_is_a_top_of_its_own(tmp_path):
    text = "Well,X,Y,Z,Top\nW1,1,5,-2,Top\nW1,1,5,-2,Top\nW1,1,5,-3,Top\n"
    with warnings.catch_warnings(record=True, action="always") as found:
        tops = gs.read_tops(written(tmp_path, text), positive="up")
    assert tops.elevation.values.tolist() == [-2.0, -3.0]
    assert len(found) == 1
    assert "line 3) is there twice" in str(found[0].message)


def test_columns_by_name_and_by_number(tmp_path):
    file = written(tmp_path, "Hole,E,N,Sub,Pick\nW1,1,5,2,Top\n")
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
    refused(FormatError, r"pass wells=gs\.read_wells", gs.read_tops, path, positive="up")
    words = r"line 2: well 'W-2' has no path in wells=\. Did you mean"
    refused(FormatError, words, gs.read_tops, path, wells=paths)
    with pytest.raises(InputError, match=r"wells= has no md\. Pass what gs\.read_wells"):
        gs.read_tops(path, wells=paths.drop_vars("md"))
    words = "Give 3 names of the header, those of well, measured depth"
    refused(InputError, words, gs.read_tops, path, wells=paths, columns=(1, 2, 3, 4, 5))


def test_a_well_of_gocad_is_refused_with_what_to_do(tmp_path):
    path = tmp_path / "a.wl"
    path.write_text("GOCAD Well 1\nHEADER {\nname: W-1\n}\nWREF 0 0 25\nPATH 0 25 0 0\nEND\n")
    for read in (gs.read_wells, gs.read_tops):
        with pytest.raises(FormatError, match=r"of the kind GOCAD Well.*with Well, MD, X, Y and Z"):
            read(path, positive="up")
    refused(FormatError, "file of the kind GOCAD Well", gs.read_points, path, positive="up")
    assert "geosurf does not read" in str(gs.info(path))


# ---- Trajectories of RESQML packages, made by hand: places, units, names, and what is refused
h5py = pytest.importorskip("h5py", reason="h5py is not installed")
SPACES = (
    'xmlns:resqml2="http://www.energistics.org/energyml/data/resqmlv2" '
    'xmlns:eml="http://www.energistics.org/energyml/data/commonv2" '
    'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
)
FT = 0.3048
MD = np.array([0.0, 1000.0, 2000.0, 3000.0])
LOCAL = np.array([[0, 0, -25], [0, 0, 975], [300, 0, 1900], [900, 100, 2600.0]])


def tagged(name, text):
    return f"<resqml2:{name}>{text}</resqml2:{name}>"


def titled(name, uuid, title, body):
    citation = f"<eml:Citation><eml:Title>{title}</eml:Title></eml:Citation>"
    return f'<resqml2:{name} {SPACES} uuid="{uuid}">{citation}{body}</resqml2:{name}>'


def reference(name, uuid):
    return tagged(name, f"<eml:UUID>{uuid}</eml:UUID>")


def array(word, kind, inner, path):
    proxy = "<eml:HdfProxy><eml:UUID>h5</eml:UUID></eml:HdfProxy>"
    values = f"<eml:PathInHdfFile>{path}</eml:PathInHdfFile>{proxy}"
    return f'<resqml2:{word} xsi:type="resqml2:{kind}">{tagged(inner, values)}</resqml2:{word}>'


def system(unit="m", crs="<resqml2:EpsgCode>32631</resqml2:EpsgCode>", uuid="crs"):
    body = (
        "<resqml2:XOffset>100</resqml2:XOffset><resqml2:YOffset>50</resqml2:YOffset>"
        '<resqml2:ZOffset>0</resqml2:ZOffset><resqml2:ArealRotation uom="rad">0'
        "</resqml2:ArealRotation>"
        + tagged("ProjectedAxisOrder", "easting northing")
        + tagged("ProjectedUom", "m")
        + tagged("VerticalUom", unit)
        + tagged("ZIncreasingDownward", "true")
        + tagged("ProjectedCrs", crs)
    )
    return titled("LocalDepth3dCrs", uuid, "local", body)


def trajectory(uuid, title, *, n=4, unit="m", geometry=True, listed=True, crs="crs", of=""):
    line = (
        tagged("KnotCount", n)
        + tagged("LineKindIndex", 5)
        + (array("ControlPointParameters", "DoubleHdf5Array", "Values", f"{uuid}/md") * listed)
        + array("ControlPoints", "Point3dHdf5Array", "Coordinates", f"{uuid}/xyz")
        + reference("LocalCrs", crs)
    )
    line = f'<resqml2:Geometry xsi:type="resqml2:ParametricLineGeometry">{line}</resqml2:Geometry>'
    body = (reference("RepresentedInterpretation", of) if of else "") + tagged("MdUom", unit)
    return titled("WellboreTrajectoryRepresentation", uuid, title, body + line * geometry)


def package(folder, objects, arrays):
    path = folder / "w.epc"
    with zipfile.ZipFile(path, "w") as held:
        held.writestr("[Content_Types].xml", "<Types/>")
        for k, text in enumerate(objects):
            held.writestr(f"obj_{k}.xml", text)
    with h5py.File(path.with_suffix(".h5"), "w") as file:
        for uuid, (md, xyz) in arrays.items():
            file[f"{uuid}/md"], file[f"{uuid}/xyz"] = md, xyz
    return path


def single(folder, md=MD, xyz=LOCAL, unit="m", **words):
    held = [system(words.pop("z_unit", "m")), trajectory("t1", "W-1", unit=unit, **words)]
    return package(folder, held, {"t1": (md, xyz)})


def test_control_points_become_the_path(tmp_path):
    path = single(tmp_path)
    wells = gs.read_wells(path)
    assert set(wells.well.values) == {"W-1"}
    np.testing.assert_array_equal(wells.md, MD)
    np.testing.assert_array_equal(wells.easting, LOCAL[:, 0] + 100)
    np.testing.assert_array_equal(wells.northing, LOCAL[:, 1] + 50)
    np.testing.assert_array_equal(wells.elevation, -LOCAL[:, 2])
    assert wells.attrs["crs"] == "EPSG:32631"
    text = str(gs.info(path))
    assert "read_wells" in text
    assert "1, by control points with straight lines of up to 1000 m" in text
    assert "doubt" not in text


@pytest.mark.parametrize("md_unit", ["m", "ft"])
@pytest.mark.parametrize("z_unit", ["m", "ft"])
def test_law_measured_depths_and_z_have_units_of_their_own(tmp_path, md_unit, z_unit):
    wells = gs.read_wells(single(tmp_path, unit=md_unit, z_unit=z_unit))
    scale = {"m": 1.0, "ft": FT}
    np.testing.assert_allclose(wells.md, scale[md_unit] * MD, rtol=1e-15)
    np.testing.assert_allclose(wells.elevation, -scale[z_unit] * LOCAL[:, 2], rtol=1e-15)


def test_without_measured_depths_there_are_places_only(tmp_path):
    wells = gs.read_wells(single(tmp_path, listed=False))
    assert "md" not in wells
    assert wells.sizes["point"] == 4


def test_names_are_those_of_wells_where_each_has_one_trajectory(tmp_path):
    def well(k, name):
        feature = titled("WellboreFeature", f"f{k}", name, "")
        body = reference("InterpretedFeature", f"f{k}")
        return [feature, titled("WellboreInterpretation", f"i{k}", "any", body)]

    objects = [system(), *well(1, "A-1"), *well(2, "A-2")]
    lines = [("t1", "survey", "i1"), ("t2", "main", "i2"), ("t3", "side track", "i2"),
             ("t4", "survey", ""), ("t5", "survey", "gone")]  # fmt: skip
    objects += [trajectory(uuid, title, of=of) for uuid, title, of in lines]
    path = package(tmp_path, objects, {uuid: (MD, LOCAL) for uuid, *_ in lines})
    names = [*dict.fromkeys(gs.read_wells(path).well.values)]
    assert names == ["A-1", "main", "side track", "survey", "survey t5"]


def test_what_cannot_be_a_path_is_refused(tmp_path):
    for words, sentence in [
        ({"geometry": False}, "trajectory of well 'W-1' has no geometry"),
        ({"xyz": LOCAL * np.nan}, "control point that is not finite"),
        ({"xyz": LOCAL * 0}, "control points in one place"),
        ({"md": MD[::-1]}, "does not have 4 measured depths that rise"),
        ({"md": MD[:3]}, "does not have 4 measured depths that rise"),
        ({"n": 5}, "expected 5 x 3"),
    ]:
        refused(FormatError, sentence, gs.read_wells, single(tmp_path, **words))
    with pytest.raises(InputError, match="the file has positive="):
        gs.read_wells(single(tmp_path), positive="up")
    refused(InputError, "columns", lambda: gs.read_wells(single(tmp_path), columns={"md": "MD"}))


def test_two_reference_systems_are_refused(tmp_path):
    other = system(crs="<resqml2:EpsgCode>23031</resqml2:EpsgCode>", uuid="other")
    objects = [system(), other, trajectory("t1", "A"), trajectory("t2", "B", crs="other")]
    path = package(tmp_path, objects, {"t1": (MD, LOCAL), "t2": (MD, LOCAL)})
    refused(FormatError, "2 coordinate reference systems", gs.read_wells, path)


def test_packages_without_wells_name_what_they_have(tmp_path):
    path = gs.write(gs.synthetic.graben(n=5).horizons["Top"], tmp_path / "t.epc")[0]
    refused(FormatError, r"no trajectory of a well; .* Grid2dRepresentation", gs.read_wells, path)
    with pytest.raises(FormatError, match=r"no horizons.*WellboreTrajectoryRepresentation"):
        gs.read_horizon(single(tmp_path))
