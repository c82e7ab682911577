"""Throw does not depend on where a fault lies on the grid: on nodes of it, beside them, aslant."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs

CELL, LEVEL = 32.0, -1152.0
MIDDLE = np.array([20 * CELL, 20 * CELL])
HALF = 12 * CELL
PEAK = 40.0


def flat(n=41):
    axis = CELL * np.arange(n)
    return xr.DataArray(
        np.full((n, n), LEVEL),
        dims=("northing", "easting"),
        coords={"northing": axis, "easting": axis},
        attrs={"units": "m", "positive": "up"},
    )


def wall(at, azimuth=90.0, dip=60.0, half=HALF, name="F1"):
    """A plane fault, and the direction of its strike by the right-hand rule."""
    a, d = np.radians([azimuth, dip])
    across = np.array([np.sin(a), np.cos(a), 0.0])
    strike = np.array([-np.cos(a), np.sin(a), 0.0])
    down = np.cos(d) * across + [0.0, 0.0, -np.sin(d)]
    corners = [
        np.append(at, LEVEL) + s * half * strike + t * 300.0 * down
        for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    fault = gs.TriSurface(name, "fault", np.array(corners), [[0, 1, 2], [0, 2, 3]])
    return fault, strike[:2]


def dying(peak=PEAK, half=HALF):
    """Throw of a fault that dies at both of its tips, by distance along it."""
    return lambda s: peak * np.maximum(0.0, 1.0 - ((np.asarray(s) - half) / half) ** 2)


def assert_found(cut, strike, at, asked, half=HALF, cells=1.5):
    """Throw is what was asked for, up to some cells from the tips; there it is less."""
    s = (cut.stations[:, :2] - at) @ strike + half
    near = cells * CELL * np.abs(strike).sum()
    inner = (s > near) & (s < 2.0 * half - near) & np.isfinite(cut.throw)
    assert inner.sum() >= 2.0 * half / CELL - 6
    assert cut.throw[inner] == pytest.approx(asked(s[inner]), abs=0.005 * PEAK)
    rest = ~inner & np.isfinite(cut.throw)
    most = np.abs(asked(np.array([near + CELL]))[0])
    assert (np.abs(cut.throw[rest]) <= most).all()


OFF = [(0.0, 0.0), (1e-9, 0.0), (1.0, 0.0), (11.0, 0.0), (0.0, 7.0), (11.0, 7.0), (-16.0, 16.0)]


@pytest.mark.parametrize("azimuth", [0.0, 90.0, 180.0, 270.0])
@pytest.mark.parametrize("share", [1.0, 0.5])
def test_beside_and_on_lines_of_nodes(azimuth, share):
    for off in OFF:
        at = MIDDLE + off
        fault, strike = wall(at, azimuth)
        throw = dying()
        sheet = gs.throw_horizon(flat(), {"F1": fault}, {"F1": throw}, hanging_wall=share)
        assert_found(sheet.cuts["F1"], strike, at, throw)
        assert sum(sheet.report.shortened.values()) == 0


@pytest.mark.parametrize(("dip", "peak"), [(60.0, -PEAK), (90.0, PEAK), (30.0, PEAK)])
def test_reverse_vertical_and_gentle_faults(dip, peak):
    for off, azimuth in zip(
        OFF, (90.0, 180.0) * 4, strict=False
    ):  # both azimuths on and next to nodes
        at = MIDDLE + off
        fault, strike = wall(at, azimuth, dip)
        throw = dying(peak)
        sheet = gs.throw_horizon(flat(), {"F1": fault}, {"F1": throw})
        # where walls overlap, tears may end up to two links early
        cells = 2.5 if peak < 0 else 1.5
        assert_found(sheet.cuts["F1"], strike, at, throw, cells=cells)
        assert sum(sheet.report.shortened.values()) <= 2


@pytest.mark.parametrize("azimuth", [45.0, 135.0, np.degrees(np.arctan2(3, 1)), 100.0])
def test_aslant_through_nodes_with_tips_on_nodes(azimuth):
    half = {45.0: 9 * CELL * 2**0.5, 135.0: 9 * CELL * 2**0.5}.get(azimuth, 4 * CELL * 10**0.5)
    for off in OFF[:5]:
        at = MIDDLE + off
        fault, strike = wall(at, azimuth, half=half)
        throw = dying(half=half)
        sheet = gs.throw_horizon(flat(), {"F1": fault}, {"F1": throw})
        assert_found(sheet.cuts["F1"], strike, at, throw, half)


@pytest.mark.parametrize("n", [3, 5])
def test_faults_of_a_few_cells_tear_what_they_can(n):
    for off in OFF:
        fault, _ = wall(MIDDLE + off, half=n * CELL)
        for throw in (dying(half=n * CELL), gs.EllipticThrow(PEAK)):
            sheet = gs.throw_horizon(flat(), {"F1": fault}, {"F1": throw})
            assert 0.4 * PEAK < np.nanmax(sheet.cuts["F1"].throw) < 1.001 * PEAK


def test_constant_throw_that_leaves_the_area_on_a_line_of_nodes():
    for azimuth in (0.0, 90.0, 180.0, 270.0, 45.0):
        for dip in (60.0, 90.0):
            for share in (1.0, 0.5):
                fault, _ = wall(MIDDLE, azimuth, dip, half=1500.0)
                sheet = gs.throw_horizon(flat(), {"F1": fault}, {"F1": PEAK}, hanging_wall=share)
                found = sheet.cuts["F1"].throw
                assert np.isfinite(found).sum() >= 35
                assert found[np.isfinite(found)] == pytest.approx(PEAK, abs=1e-6)
