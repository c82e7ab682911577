"""Points on the wrong side of a fault: found, named and left out; clean points all stay."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeosurfWarning

pytestmark = pytest.mark.filterwarnings("ignore:Horizon .* does not pass through its data")
MIDDLE = 1000.0


def points_beside_a_fault(seed):
    """Points of two walls, their fault, which places are wrong, and the throw [m]."""
    rng = np.random.default_rng(seed)
    dip, strike = np.radians(rng.uniform(35.0, 75.0)), rng.uniform(0.0, np.pi)
    throw, n = rng.uniform(30.0, 120.0), int(rng.choice([1600, 3600]))
    noise = rng.choice([0.0, 0.01]) * throw
    along = np.array([np.cos(strike), np.sin(strike)])
    across = np.array([-along[1], along[0]])
    xy = rng.uniform(0.0, 2.0 * MIDDLE, (n, 2))
    if rng.random() < 0.5:
        axis = np.linspace(0.0, 2.0 * MIDDLE, int(np.sqrt(n)))
        xy = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    foot = -1500.0 + (xy - MIDDLE) @ rng.uniform(-0.1, 0.1, 2)
    off = (xy - MIDDLE) @ across
    # the fault is met where off = (-1500 - z) / tan(dip)
    in_foot, in_hanging = (
        sign * ((-1500.0 - z) / np.tan(dip) - off) for sign, z in ((1, foot), (-1, foot - throw))
    )
    there = (in_foot > 0) | (in_hanging > 0)
    xy, foot, off, mine = (a[there] for a in (xy, foot, off, in_foot > 0))
    true, other = np.where(mine, foot, foot - throw), np.where(mine, foot - throw, foot)
    cell = 2.0 * MIDDLE / np.sqrt(n)
    away = np.abs(off - (-1500.0 - other) / np.tan(dip))
    middle = (np.abs(xy - MIDDLE) < 800.0).all(axis=1)
    wrong = rng.choice(np.flatnonzero(middle & (away > 2.0 * cell) & (away < 6.0 * cell)), 3)
    corners = [
        [*(MIDDLE + s * 1800.0 * along + (-1500.0 - z) / np.tan(dip) * across), z]
        for s, z in ((-1, -1000.0), (1, -1000.0), (1, -2200.0), (-1, -2200.0))
    ]
    fault = gs.TriSurface("F", "fault", np.array(corners), [[0, 1, 2], [0, 2, 3]])
    scatter = noise * rng.standard_normal(len(xy))
    clean = np.column_stack([xy, true + scatter])
    spoilt = clean.copy()
    spoilt[wrong, 2] = other[wrong] + scatter[wrong]
    return clean, spoilt, fault, {tuple(spoilt[k].tolist()) for k in wrong}, throw


@pytest.mark.parametrize("seed", range(12))
def test_law_wrong_points_are_left_out_and_named(seed):
    clean, spoilt, fault, wrong, throw = points_beside_a_fault(seed)
    sheet = gs.tear_horizon(clean, [fault], name="Top", positive="up")
    assert sheet.report.left_out == []
    true = sheet.cuts["F"].throw
    with pytest.warns(GeosurfWarning, match=r"3 picks of horizon 'Top' fit the other wall") as told:
        sheet = gs.tear_horizon(spoilt, [fault], name="Top", positive="up")
    left = {tuple(np.round(one["place"], 6)) for one in sheet.report.left_out}
    assert left == {tuple(np.round(one, 6)) for one in wrong}
    for one in sheet.report.left_out:
        assert one["fault"] == "F"
        assert abs(one["off"]) == pytest.approx(throw, rel=0.15)
    assert [w.message.kind for w in told if w.message.kind == "wrong side"] == ["wrong side"]
    assert np.nanmax(np.abs(sheet.cuts["F"].throw - true)) < 0.1 * throw


@pytest.mark.filterwarnings("ignore:Fault 'F' has a throw")  # that such peaks change
@pytest.mark.parametrize("seed", [0, 1, 2])  # where they stay on their side of the fault
def test_points_that_fit_neither_wall_are_no_mistakes_of_side(seed):
    """As far off as wrong ones, on the other side of their own wall: a peak, for all we know."""
    clean, spoilt, fault, _, _ = points_beside_a_fault(seed)
    clean[:, 2] = 2.0 * clean[:, 2] - spoilt[:, 2]
    assert (clean != spoilt).any()
    sheet = gs.tear_horizon(clean, [fault], name="Top", positive="up")
    assert sheet.report.left_out == []


def test_outliers_are_kept_when_asked():
    _, spoilt, fault, _, throw = points_beside_a_fault(3)
    kept = gs.tear_horizon(spoilt, [fault], name="Top", positive="up", keep_outliers=True)
    assert kept.report.left_out == []
    assert kept.report.n_data == len(spoilt)
    assert np.nanmax(np.abs(kept.cuts["F"].throw - throw)) > 0.2 * throw


def test_law_data_that_are_not_met_are_told():
    """Mean, 95th percentile and the worst place, where noise is averaged; nothing on exact data."""
    world = gs.synthetic.torn("normal", n=61)
    for noise in (0.0, 0.2, 3.0):
        points = world.truth["scattered"](4000, noise)
        sheet = gs.tear_horizon(points, world.faults, name="Top", positive="up", spacing=25.0)
        told = [one for one in sheet.warnings if one.kind == "moved data"]
        assert len(told) == (sheet.report.misfit["p95"] > 1.0) == (noise == 3.0)
    words, place = told[0].effect, np.array(told[0].place)
    assert f"off by {sheet.report.misfit['mean']:.3g} m on average" in words
    assert f"noise of {sheet.report.noise:.3g} m" in words
    assert np.abs(points - place).sum(axis=1).min() < 1e-6
