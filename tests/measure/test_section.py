"""Vertical sections: what is known by hand, and laws that hold for any line."""

from __future__ import annotations

import contextlib
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import InputError
from geosurf.measure import vertical_section
from tests.grids import lines_of
from tests.measure.worlds import BOX, faulted

WEST, EAST, SOUTH, NORTH, BOTTOM, TOP = BOX


@pytest.fixture(scope="module")
def scene():
    return faulted((4.0, 4.0), contacts={"OWC": gs.FluidContact(-13.0, zones="Top/Base")})


def lines(section, kind):
    """Label and points (n, 2) of the lines of a kind."""
    points = lines_of(section, "along_section", "elevation")
    return [(section.label.values[i], points[i]) for i in np.flatnonzero(section.kind == kind)]


def areas(section):
    mine = section.area.values[section.kind.values == "unit"]
    names = section.label.values[section.kind.values == "unit"]
    return {name: float(mine[names == name].sum()) for name in names.tolist()}


def test_areas_across_a_fault_are_those_of_trapezia(scene):
    """x + z = 10: Top is cut at -10 and -14, Base at -20 and -24, in the east 4 m lower."""
    found = areas(scene.section([(WEST, 15.0), (EAST, 15.0)]))
    assert found["above Top F1-"] == pytest.approx(0.5 * 10 * (10 + 20), rel=1e-12)
    assert found["above Top F1+"] == pytest.approx(0.5 * 14 * (50 + 36), rel=1e-12)
    foot = {part: found[f"Top/Base F1- {part} OWC"] for part in ("above", "below")}
    assert foot["above"] == pytest.approx(3 * (20 + 23) / 2, rel=1e-12)
    assert foot["below"] == pytest.approx(7 * (23 + 30) / 2, rel=1e-12)
    assert found["Top/Base F1+ below OWC"] == pytest.approx(10 * (36 + 26) / 2, rel=1e-12)
    assert sum(found.values()) == pytest.approx((EAST - WEST) * (TOP - BOTTOM), rel=1e-12)


def test_lines_lie_on_their_surfaces_where_these_bound_units(scene):
    section = scene.section([(WEST, 15.0), (EAST, 15.0)])
    ((name, fault),) = lines(section, "fault")
    assert name == "F1"
    assert np.abs(fault.sum(axis=1) - 10.0).max() < 1e-12
    assert fault[:, 1].min() == BOTTOM
    assert fault[:, 1].max() == TOP
    ends = {}
    for name, line in lines(section, "horizon"):
        ends.setdefault(name, []).append((line[0].tolist(), line[-1].tolist()))
    assert ends["Top"] == [([0.0, -10.0], [20.0, -10.0]), ([24.0, -14.0], [60.0, -14.0])]
    ((name, contact),) = lines(section, "contact")  # only where it parts the zone
    assert name == "OWC"
    assert contact[[0, -1]].tolist() == [[0.0, -13.0], [23.0, -13.0]]
    assert section.attrs["zones"] == ["above Top", "Top/Base", "below Base"]


whole = st.integers(-2, 12)


@given(st.lists(st.tuples(whole, whole), min_size=2, max_size=4))
def test_areas_of_units_add_up_to_what_is_inside_the_box(points):
    """Whole numbers: lines run through corners, along edges and walls, and out of the model."""
    corners = np.array(points, dtype=float) * 5.0
    if (np.diff(corners, axis=0) == 0).all(axis=1).any():
        return
    model = MODELS[0]
    inside = 0.0
    with contextlib.suppress(InputError):  # lines that pass the model by
        section = vertical_section(model.patches, model.units, corners)
        inside = section.area.values.sum() / (TOP - BOTTOM)
    expected, in_wall = 0.0, 0.0
    for a, b in itertools.pairwise(corners):
        length = float(np.hypot(*(b - a)))
        span = length * max(_share_inside(a, b), 0.0)
        along_wall = any(a[k] == b[k] and a[k] in (BOX[2 * k], BOX[2 * k + 1]) for k in (0, 1))
        expected += 0.0 if along_wall else span
        in_wall += span if along_wall else 0.0  # may count, or not
    assert expected - 1e-9 <= inside <= expected + in_wall + 1e-9


def _share_inside(a, b):
    """Part of the way from a to b that lies in the box (Liang & Barsky)."""
    first, last = 0.0, 1.0
    for k, (low, high) in enumerate(((WEST, EAST), (SOUTH, NORTH))):
        step = b[k] - a[k]
        if step == 0:
            if not low <= a[k] <= high:
                return 0.0
            continue
        ends = sorted(((low - a[k]) / step, (high - a[k]) / step))
        first, last = max(first, ends[0]), min(last, ends[1])
    return last - first


MODELS = [faulted((4.0, 4.0))]


@settings(max_examples=10)
@given(
    st.lists(st.tuples(st.integers(-2, 14), st.integers(-2, 8)), min_size=2, max_size=6),
    st.lists(st.floats(0, 1), max_size=40),
    st.sampled_from([0.0, 0.004]),
)
def test_stations_between_the_corners_change_nothing(scene, corners, shares, noise):
    """Stations of a well on straight parts, some of them twice, rounded to a centimetre."""
    corners = [(5.0 * x + 2.3, 5.0 * y + 1.7) for x, y in corners]
    inside = any(0 <= x <= 60 and 0 <= y <= 30 for x, y in corners)
    path = [corners[0]]
    for k, (a, b) in enumerate(itertools.pairwise(corners)):
        steps = sorted(shares[k::5])
        path += [tuple(np.add(a, np.multiply(s, np.subtract(b, a)))) for s in steps] + [b, b]
    shift = noise * np.sin(np.arange(2 * len(path)).reshape(-1, 2))
    if not inside or len(set(corners)) < 2:
        return
    with contextlib.suppress(InputError):  # beside the model
        one, two = scene.section(corners), scene.section(np.array(path) + shift)
        assert len(two.attrs["line"]) <= len(one.attrs["line"]) or noise
        assert len(two.attrs["line"]) <= 2 * len(corners)
        for name, area in areas(one).items():
            assert areas(two).get(name, 0.0) == pytest.approx(area, abs=1e-9 + 200 * noise)
