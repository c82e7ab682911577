"""Thickness maps are what a vertical line measures in the model, node by node."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from geosurf import Scene, TriSurface, synthetic
from geosurf.kernels.search.columns import cross_columns
from geosurf.measure import thickness as unit_columns
from geosurf.measure import thickness_map
from tests.measure.worlds import faulted, level
from tests.strategies import lattice_points

UTM = (456_000.0, 6_780_000.0, 0.0)


@pytest.fixture(scope="module")
def graben():
    world = synthetic.graben(n=9, offset=UTM)
    return Scene(world.horizons, world.faults, world.box)


def nodes(east, north):
    return xr.Dataset(coords={"northing": np.array(north, float), "easting": np.array(east, float)})


# ---- closed forms --------------------------------------------------------------------


def test_bedding_is_that_of_the_top_or_else_of_the_base():
    """Top and Base dip differently; beneath the fault, lines enter the zone through it."""
    world = synthetic.tilted_planes(n=9)
    scene = Scene(world.horizons, world.faults, world.box)
    p = math.tan(math.radians(2.0)) / math.sqrt(2.0)
    top, base = 1 / math.hypot(1, p, p), 1 / math.hypot(1, p, 1.25 * p)
    both = (scene.thickness("Top/Base", 20.0, kind=kind) for kind in ("isopach", "isochore"))
    ratio = next(both) / next(both)
    hanging, foot = (ratio.sel(block=block).values for block in ("F1+", "F1-"))
    np.testing.assert_allclose(hanging[~np.isnan(hanging)], top, rtol=1e-12)
    beneath = np.abs(foot - base) < 1e-12
    assert 0 < beneath.sum() < 0.05 * foot.size
    np.testing.assert_allclose(foot[~np.isnan(foot) & ~beneath], top, rtol=1e-12)


def test_torn_and_reverse_zones_by_hand():
    # foot: Top -10, Base -20; hanging: 4 lower; the fault is at z = 10 - x
    scene = faulted()
    found = scene.thickness("Top/Base", nodes([15.5, 22.5, 27.0, 31.0, 50.0], [7.3]))
    foot, hanging = found.sel(block="F1-")[0], found.sel(block="F1+")[0]
    np.testing.assert_allclose(foot, [10, 7.5, 3.0, np.nan, np.nan], atol=1e-13)
    np.testing.assert_allclose(hanging, [np.nan, np.nan, 3.0, 7.0, 10.0], atol=1e-13)
    # 4 higher: between x = 20 and 30 the line meets the zone twice over
    scene = faulted((-4.0, -4.0))
    found = scene.thickness("Top/Base", nodes([23.0], [7.3]))[:, 0, 0].to_series()
    assert found["F1-"] == pytest.approx(7.0, abs=1e-13)
    assert found["F1+"] == pytest.approx(7.0, abs=1e-13)


@pytest.mark.parametrize(("throw", "foot", "hanging"), [(4.0, 30, 36), (-4.0, 30, 44)])
def test_the_map_area_is_that_of_all_vertical_lines_with_rock(throw, foot, hanging):
    """Eastings from 0 to 30 and, in the hanging wall, from its cut-off at the top to 60."""
    units = faulted((throw, throw)).units
    assert units["Top/Base", "F1-"].map_area == pytest.approx(30.0 * foot, rel=1e-12)
    assert units["Top/Base", "F1+"].map_area == pytest.approx(30.0 * hanging, rel=1e-12)
    mean = units["Top/Base", "F1-"].volume / units["Top/Base", "F1-"].map_area
    assert mean == pytest.approx((20 * 10 + 10 * 5) / 30, rel=1e-12)
    for unit in units.values():  # a closed shell has as much below as above
        turned = replace(unit, triangles=unit.triangles[:, ::-1])
        assert turned.map_area == pytest.approx(unit.map_area, rel=1e-12)
    assert units.table["map_area"].values.tolist() == [unit.map_area for unit in units.values()]


# ---- laws ----------------------------------------------------------------------------


MUCH = 10**9


def exactly(x, triangles, foot, push):
    """Slow and obvious: the foot is really moved, by a millionth and a billionth."""
    x0 = int(MUCH * foot[0]) + 1000 * int(push[0])
    y0 = int(MUCH * foot[1]) + int(push[1])
    total, count = Fraction(0), 0
    for t in triangles.tolist():
        p = [[MUCH * int(v) for v in x[i]] for i in t]
        turn = [
            (p[(k + 1) % 3][0] - p[k][0]) * (y0 - p[k][1])
            - (p[(k + 1) % 3][1] - p[k][1]) * (x0 - p[k][0])
            for k in range(3)
        ]
        if all(v > 0 for v in turn) or all(v < 0 for v in turn):
            way = 1 if turn[0] > 0 else -1
            weight = [turn[1], turn[2], turn[0]]
            z = sum(w * q[2] for w, q in zip(weight, p, strict=True))
            total, count = total + way * Fraction(z, MUCH * sum(weight)), count + way
    return float(total), count


@given(
    st.lists(lattice_points(4), min_size=4, max_size=4, unique=True).filter(
        lambda p: np.linalg.det(np.diff(p, axis=0)) > 0.5
    ),
    st.integers(0, 8),
    st.integers(0, 8),
)
def test_columns_agree_with_rational_arithmetic(corners, east, north):
    """Feet on corners, edges and upright faces of a tetrahedron; the middle is anywhere."""
    x = np.array(corners, dtype=float)
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    half = np.arange(9) / 2
    feet = np.stack(np.meshgrid(half, half), axis=-1).reshape(-1, 2)
    middle = np.array([east, north]) / 2
    push = np.where(feet <= middle, 1, -1)
    found = cross_columns(x, triangles, feet, middle)
    total = np.bincount(found.foot, found.way * found.elevation, minlength=len(feet))
    for i, foot in enumerate(feet):
        z, count = exactly(x, triangles, foot, push[i])
        assert count == 0
        assert total[i] == pytest.approx(z, abs=1e-4)
        assert total[i] >= 0


# ---- what is refused -----------------------------------------------------------------


@pytest.mark.parametrize("kind", ["isochore", "isopach"])
def test_law_maps_are_the_same_some_lines_at_a_time(graben, kind, monkeypatch):
    zones = {unit.zone: None for unit in graben.units.values()}

    def maps():
        found = [
            thickness_map(graben.units, zone, 151.0, kind=kind, horizons=graben.horizon_names)
            for zone in zones
        ]
        return [one.values.tobytes() for one in found]

    whole = maps()
    monkeypatch.setattr(unit_columns, "AT_ONCE", 50)
    assert maps() == whole


def test_blocks_whose_names_hold_each_other_stay_apart():
    """'A-' is a part of the text 'A+ AA-'; it is no part of that block."""
    box = (0.0, 60.0, 0.0, 30.0, -40.0, 0.0)
    horizons = {name: level(name, z) for name, z in (("Top", -10.0), ("Base", -20.0))}
    faults = {}
    for name, x in (("A", 20.0), ("AA", 40.0)):
        corners = [(x, -2.0, -60.0), (x, 32.0, -60.0), (x, 32.0, 20.0), (x, -2.0, 20.0)]
        faults[name] = TriSurface(name, "fault", corners, [(0, 1, 2), (0, 2, 3)])
    found = Scene(horizons, faults, box).thickness("Top/Base", 10.0)
    assert any("A-" in b.split() for b in found.block.values.tolist())
    for block in found.block.values.tolist():
        there = np.isfinite(found.sel(block=block).values).any(axis=0)
        assert there.sum() == 2, block
    assert (np.isfinite(found.values).sum(axis=0) == 1).all()
