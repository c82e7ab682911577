"""GOCAD VSet and PLine: points and lines, also those that geosurf wrote."""

from __future__ import annotations

import shlex

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, InputError

HEAD = (
    "GOCAD {}\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\nZPOSITIVE Depth\nEND_ORIGINAL_COORDINATE_SYSTEM\n"
)
VERTICES = "VRTX 7 0 0 10\nPVRTX 8 5 0 20\nVRTX 3 5 5 30\n"


def written(tmp_path, text, name="a.txt"):
    (tmp_path / name).write_text(text)
    return tmp_path / name


def test_points_of_several_vsets_are_elevations(tmp_path):
    one = HEAD.format("VSet 1") + VERTICES + "END\n"
    points = gs.read_points(written(tmp_path, one + "GOCAD PLine 1\nEND\n" + one))
    assert points.elevation.values.tolist() == [-10, -20, -30] * 2
    assert points.easting.values.tolist() == [0, 5, 5] * 2
    with pytest.raises(InputError, match="positive='up'"):
        gs.read_points(tmp_path / "a.txt", positive="up")


def test_lines_are_parts_and_chains_of_segments(tmp_path):
    body = f"ILINE\n{VERTICES}SEG 7 8\nSEG 8 3\nILINE\nATOM 9 3\nVRTX 4 9 9 0\nSEG 9 4\nSEG 4 9\n"
    path = written(tmp_path, HEAD.format("PLine 1") + body + "END\n")
    lines = gs.read_polygons(path)
    assert [line.tolist() for line in lines] == [
        [[0, 0, -10], [5, 0, -20], [5, 5, -30]],
        [[5, 5, -30], [9, 9, 0], [5, 5, -30]],
    ]
    sticks = gs.read_fault(path)
    assert isinstance(sticks, gs.FaultSticks)
    assert [len(stick) for stick in sticks.sticks] == [3, 3]


def test_law_curves_come_back_from_a_pline(tmp_path):
    flat = [[0, 0, 0], [9, 0, 0], [0, 9, 0]]
    steep = [[1, 1, -1], [3, 1, 2], [1, 4, 2]]
    one, two = (
        gs.TriSurface(name, "fault", np.array(points, float), [[0, 1, 2]])
        for name, points in (("A", flat), ("B", steep))
    )
    curves = gs.intersect_surfaces([one, two])
    gs.write(curves, tmp_path / "c.pl")
    back = gs.read_polygons(tmp_path / "c.pl")
    assert len(back) == curves.n_curve == 1
    assert {tuple(p) for p in back[0]} == {tuple(p) for p in curves.points.tolist()}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("GOCAD PLine 1\nILINE\nVRTX 1 0 0 0\nSEG 1 2\nEND\n", "line 4: vertex 2 is used but"),
        ("GOCAD PLine 1\nILINE\nVRTX 1 0 0 0\nSEG 1\nEND\n", "line 4: SEG has 1 values"),
        ("GOCAD PLine 1\nILINE\nVRTX 1 0 0 0\nEND\n", "no segments"),
        ("GOCAD PLine 1\nILINE\nEND\n", "has no vertices"),
        ("GOCAD PLine 1\nILINE\nVRTX 1 0 0 x\nEND\n", "line 3: found 'x'"),
        ("GOCAD PLine 1\nILINE\nVRTX 1 0 0 0\n", "has no END"),
    ],
)
def test_damaged_lines_get_one_sentence_each(tmp_path, text, message):
    with pytest.raises(FormatError, match=message):
        gs.read_polygons(written(tmp_path, text))


@pytest.mark.parametrize("step", [1, 3])
@pytest.mark.parametrize(
    "change",
    [("", ""), ("VRTX 4 ", "VRTX 4  "), ("END\n", "BSTONE 1\nEND\n"), ("0 0 5\n", "0 0 5 CNXYZ\n")],
)
def test_law_a_tsurf_in_bulk_is_that_of_its_lines(tmp_path, monkeypatch, step, change):
    rows = np.random.default_rng(2).integers(0, 50, (40, 3))
    rows = rows[(rows[:, [0]] != rows[:, [1]]).ravel() & (np.ptp(rows, axis=1) > 1)]
    ids = step * np.random.default_rng(1).permutation(50) + 4 if step > 1 else np.arange(50) + 4
    text = HEAD.format("TSurf 1") + "TFACE\n"
    text += "".join(f"VRTX {i} {k / 7!r} {k * k} 5\n" for k, i in enumerate(ids))
    text += "".join("TRGL {} {} {}\n".format(*ids[row]) for row in rows if len(set(row)) == 3)
    path = written(tmp_path, (text + "END\n").replace(*change))
    slow = gs.read_fault(path)
    _in_bulk(monkeypatch)
    monkeypatch.setattr("geosurf.read._gocad_draft.quoted_words", _no_vertices)
    fast = gs.read_fault(path)
    assert fast.vertices.tobytes() == slow.vertices.tobytes()
    assert fast.triangles.tobytes() == slow.triangles.tobytes()


def _in_bulk(monkeypatch):
    """Read small files as large ones are read."""
    monkeypatch.setattr("geosurf.read._gocad_bulk.FEWEST", 10)
    monkeypatch.setattr("geosurf.read._gocad_bulk.BYTES_IN_A_RUN", 0)


def test_law_a_model_of_many_parts_in_bulk_is_that_of_its_lines(tmp_path, monkeypatch):
    world = gs.synthetic.tilted_planes(n=5)
    units = gs.Scene(world.horizons, world.faults, world.box).units
    (path,) = gs.write(units, tmp_path / "m.ml")
    slow = gs.read_units(path)
    _in_bulk(monkeypatch)
    monkeypatch.setattr("geosurf.read._gocad_draft.quoted_words", _no_vertices)
    fast = gs.read_units(path)
    for name, unit in slow.items():
        assert fast[name].vertices.tobytes() == unit.vertices.tobytes()
        assert fast[name].triangles.tobytes() == unit.triangles.tobytes()


def _no_vertices(line):
    assert not line.startswith(("VRTX", "TRGL")), "read line by line"
    return shlex.split(line)


@pytest.mark.parametrize(
    "change",
    [("VRTX 2 ", "VRTX 1 "), ("TRGL 1 2 3", "TRGL 1 2 9"), ("TRGL 1 2 3", "TRGL 1 2 3.0"),
     ("VRTX 2 ", "VRTX 2.0 "),
     ("TRGL 1 2 3\n", "TRGL 1 2 4\nVRTX 4 5 5 5\n"),
     ("9 9 0", "9 9 nan"), ("9 9 0", "9-9 0"), ("END\n", ""), ("TRGL 1 2 3\n", "")],
)  # fmt: skip
def test_damaged_files_in_bulk_get_the_sentence_of_their_line(tmp_path, monkeypatch, change):
    text = "GOCAD TSurf 1\nTFACE\nVRTX 1 0 0 0\nVRTX 2 9 0 0\nVRTX 3 9 9 0\nTRGL 1 2 3\nEND\n"
    path = written(tmp_path, text.replace(*change))
    with pytest.raises(FormatError) as slow:
        gs.read_fault(path)
    _in_bulk(monkeypatch)
    with pytest.raises(FormatError) as fast:
        gs.read_fault(path)
    assert str(fast.value) == str(slow.value)
