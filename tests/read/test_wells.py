"""Paths of wells: minimum curvature, layouts of files, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, GeosurfError
from geosurf.measure.places import wells_of
from geosurf.read.wells.paths import SAG, along_arcs

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
    file.write_text(text)
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
        ("Well,X,Y,MD\nA,0,0,0\n", {"positive": "up"}, "no column is z"),
        ("X,Y,Z,MD\n1,2,3,4\n", {"positive": "up"}, "1 point in one place"),
        ("X,Y,Z,MD\n1,2,3,4\n1,2,x,5\n", {"positive": "up"}, "line 3: found 'x'"),
        ("1,2,3,4\n1,2,4,5\n", {"positive": "up"}, "Give the columns"),
        (TABLE, {}, "depth or elevation"),
        ("Well,MD,X,Y,Z\n", {"positive": "up"}, "has no points of wells"),
        (TABLE, {"positive": "up", "columns": {"depth": "Z"}}, "the key 'depth'"),
        (TABLE, {"positive": "up", "columns": {"md": "MDD"}}, "no column is called 'MDD'"),
        (TABLE, {"positive": "up", "heads": 3}, "heads is a int"),
        (TABLE, {"positive": "up", "heads": {"A": (1, 2)}}, "not three numbers"),
    ],
)  # fmt: skip
def test_what_is_open_or_wrong_is_refused(tmp_path, text, words, match):
    with pytest.raises(GeosurfError, match=match):
        gs.read_wells(written(tmp_path, text), **words)
