"""GOCAD VSet and PLine: points and lines, also those that geosurf wrote."""

from __future__ import annotations

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
    """Two curves of one pair: ids go on from one to the next."""
    steep = np.array([[1.0, 1, -1], [3, 1, 2], [1, 4, 2]])
    one = gs.TriSurface("A", "fault", [[0.0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    both = np.concatenate([steep, steep + np.array([3.0, 0, 0])])
    two = gs.TriSurface("B", "fault", both, [[0, 1, 2], [3, 4, 5]])
    curves = gs.intersect_surfaces([one, two])
    gs.write(curves, tmp_path / "c.pl")
    back = gs.read_polygons(tmp_path / "c.pl")
    assert len(back) == curves.n_curve == 2
    found = {tuple(point) for line in back for point in line.tolist()}
    assert found == {tuple(point) for point in curves.points.tolist()}


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
