"""Faults that tears take past the faults that they end at: a warning with the area, on paper."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.faults.rules import Rule
from geosurf.scene import tearing as passed_faults
from geosurf.scene.tearing import warnings_of_passed_faults

# F1: the plane x + z = 8; F2: the plane y = 4, where x + z >= 8, above z = 3
MAIN = gs.TriSurface(
    "F1", "fault", [(-1, -1, 9), (9, -1, -1), (9, 9, -1), (-1, 9, 9)], [[0, 1, 2], [0, 2, 3]]
)
CORNERS = [(5, 4, 3), (7.5, 4, 3), (7.5, 4, 6), (2, 4, 6)]


def part(*more, triangles=()):
    """F2 with further corners and triangles."""
    return gs.TriSurface("F2", "fault", [*CORNERS, *more], [[0, 1, 2], [0, 2, 3], *triangles])


def rule(keep):
    return [Rule("F2", "F1", keep)]


def side_above():
    """The side of F1 on which x + z > 8."""
    a, b, c = MAIN.vertices[MAIN.triangles[0]]
    return "+" if np.cross(b - a, c - a)[2] > 0 else "-"


@pytest.mark.parametrize(
    ("fault", "area"),
    [
        # down to z = 2 below x = 5 to 7.5: of that strip, (5, 3), (6, 2), (5, 2) is beyond F1
        (part((5, 4, 2), (7.5, 4, 2), triangles=[[4, 5, 1], [4, 1, 0]]), 0.5),
        # up to z = 7 above x = 2 to 7.5: nowhere beyond F1
        (part((7.5, 4, 7), (2, 4, 7), triangles=[[3, 2, 4], [3, 4, 5]]), 0.0),
    ],
)
def test_the_area_beyond_the_main_fault(fault, area):
    given = {"F1": MAIN, "F2": part()}
    faults = {"F1": MAIN, "F2": fault}
    keep = side_above()
    found = warnings_of_passed_faults(rule(keep), given, faults)
    assert passed_faults._area_beyond(rule(keep)[0], faults) == pytest.approx(area, rel=1e-12)
    assert [one.subject for one in found] == (["F2"] if area else [])
    assert all("lengthen={'F2': " in one.remedy for one in found)
    assert not warnings_of_passed_faults(rule(keep), faults, faults)  # nothing became longer

    # on the other side of F1 it is the rest that counts
    other = "-" if keep == "+" else "+"
    whole = 0.5 * (2.5 + 5.5) * 3.0 + (2.5 if area else 5.5)
    beyond = passed_faults._area_beyond(rule(other)[0], faults)
    assert beyond == pytest.approx(whole - area, rel=1e-12)
