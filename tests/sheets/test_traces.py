"""Traces of faults on a drape: one line on both, however wide triangles are."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf import TriSurface
from geosurf.kernels.sheets import link_lines
from geosurf.sheets.faults.traces import mesh_in_frame, trace_lines
from geosurf.sheets.lattice.picks import Frame


def frame_of(n_row: int, n_col: int) -> Frame:
    axes = np.arange(n_col, dtype=float), np.arange(n_row, dtype=float)
    return Frame((n_row, n_col), np.zeros(2), np.eye(2), *axes)


def plane_fault(s: np.ndarray) -> TriSurface:
    """A plane through (20, 20), dipping 60 degrees, with columns at some places along strike."""
    z = np.array([30.0, -30.0])[:, None]
    x = 20.0 + 0.8 * s[None, :] - z / 3.0
    y = 20.0 + 0.6 * s[None, :] + 0 * z
    points = np.stack([x, y, z + 0 * x], axis=-1).reshape(-1, 3)
    a = np.arange(len(s) - 1)
    b, c, d = a + 1, a + len(s) + 1, a + len(s)
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return TriSurface("F1", "fault", points, faces)


COLUMNS = {
    "two columns": np.array([-15.0, 15.0]),
    "even": np.linspace(-15.0, 15.0, 61),
    "one wide": np.concatenate([np.linspace(-15.0, -5.0, 41), [15.0]]),
    "steps": np.array([-15.0, -14.9, -14.0, -7.0, 0.0, 0.01, 15.0]),
}


@pytest.mark.parametrize("s", COLUMNS.values(), ids=COLUMNS)
def test_a_trace_is_one_line_on_fault_and_drape_however_wide_triangles_are(s):
    frame = frame_of(41, 41)
    x, y = np.meshgrid(np.arange(41.0), np.arange(41.0))
    drape = 3.0 * np.sin(x / 5.0) * np.cos(y / 7.0)
    (line,) = trace_lines(mesh_in_frame(plane_fault(s), frame), drape, np.ones(2))
    along = 0.8 * (line[:, 0] - 20.0 + line[:, 2] / 3.0) + 0.6 * (line[:, 1] - 20.0)
    assert np.abs(along[[0, -1]]) == pytest.approx([15.0, 15.0])
    across = 0.6 * (line[:, 0] - 20.0 + line[:, 2] / 3.0) - 0.8 * (line[:, 1] - 20.0)
    assert across == pytest.approx(np.zeros(len(line)), abs=1e-9)
    height = 3.0 * np.sin(line[:, 0] / 5.0) * np.cos(line[:, 1] / 7.0)
    assert np.abs(line[:, 2] - height).max() < 0.05  # the drape is linear between its nodes
    assert np.hypot(*np.diff(line[:, :2], axis=0).T).max() < 0.75
    ahead, normal = np.diff(line[:, :2], axis=0), line[1:, 3:5]
    assert (ahead[:, 0] * normal[:, 1] - ahead[:, 1] * normal[:, 0] > 0).all()


small = st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=2, max_size=80)


@given(small, small)
def test_crossings_of_lines_are_those_of_whole_numbers(one, two):
    def pieces(line):
        points = np.array(line, dtype=float)
        return np.hstack([points[:-1], points[1:]])

    def exactly(p, q, r, s):
        d, e = (q[0] - p[0], q[1] - p[1]), (s[0] - r[0], s[1] - r[1])
        det = d[0] * e[1] - d[1] * e[0]
        if det == 0:
            return None
        x, y = r[0] - p[0], r[1] - p[1]
        return Fraction(x * e[1] - y * e[0], det), Fraction(x * d[1] - y * d[0], det)

    wanted = []
    for i in range(len(one) - 1):
        for j in range(len(two) - 1):
            met = exactly(one[i], one[i + 1], two[j], two[j + 1])
            if met and 0 <= met[0] < 1 and 0 <= met[1] < 1:
                wanted.append((float(i + met[0]), float(j + met[1])))
    found = link_lines.line_crossings(pieces(one), pieces(two))
    assert found == pytest.approx(np.array(wanted).reshape(-1, 2), abs=1e-12)
