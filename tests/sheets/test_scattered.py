"""Points on no lattice: met like grids; those on the wrong side; walls that overlap widely."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import GeometryError, GeosurfWarning, HorizonError, InputError
from geosurf.sheets.faults.cut_edges import FALLING
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.passes import PointSolver, rebuild
from geosurf.sheets.heights.state import Trims, inputs_of
from geosurf.sheets.lattice.data import proposed_spacing, scattered
from geosurf.sheets.mesh.finish import fault_surfaces
from tests.grids import gridded
from tests.sheets import held_out
from tests.sheets.table import assert_met, measure

# noise is averaged, which the warning states; it has a test of its own
pytestmark = pytest.mark.filterwarnings("ignore:Horizon .* does not pass through its data")

N = 61


@pytest.fixture(scope="module")
def normal():
    return gs.synthetic.torn("normal", n=N)


# a thrust overlaps by 7 cells: it was refused, when nothing held a wall past its trace
@pytest.mark.parametrize(("kind", "n"), [("reverse", N), ("Y", N), ("thrust", 81)])
def test_clean_points_are_met_like_a_grid(kind, n):
    world = gs.synthetic.torn(kind, n=n)
    points = world.truth["scattered"](n * n)
    sheet = gs.tear_horizon(points, world.faults, name="Top", trim=1.0, positive="up")
    assert sheet.report.noise is None
    assert sheet.report.tips == sheet.report.declared_tips
    for name in world.faults:
        assert_met(measure(world, sheet, name))


def test_throw_that_dies_as_a_root_is_met_at_its_tips():
    """Without shapes 22 % of it were missed there."""
    faults, n, step, _ = held_out.WORLDS["half crack"]
    world = gs.synthetic.torn(faults, n, step=step)
    sheet = gs.tear_horizon(
        world.truth["scattered"](n * n), world.faults, name="Top", trim=1.0, positive="up"
    )
    assert_met(measure(world, sheet, "F1", cell=step))


def test_noisy_points_are_met_as_well_as_asked(normal):
    points = normal.truth["scattered"](8000, 2.0)
    words = {"trim": 1.0, "spacing": 25.0, "positive": "up"}
    sheet = gs.tear_horizon(points, normal.faults, name="Top", **words)
    assert sheet.report.noise == pytest.approx(2.0, rel=0.1)
    found = measure(normal, sheet, "F1")
    assert found.position.max() < 0.25
    assert found.throw.mean() < 2.0


def test_the_lattice_that_is_proposed_has_one_cell_per_point():
    rng = np.random.default_rng(3)
    for number in (500, 5000):
        points = rng.uniform(0.0, 1000.0, (number, 3))
        assert proposed_spacing(points) == pytest.approx(1000.0 / np.sqrt(number), rel=0.1)


def test_no_point_speaks_across_a_cut(normal):
    """Against a slow look at all six links of each cell."""
    picks = scattered("Top", normal.truth["scattered"](3000), 25.0)
    meshes = [mesh_in_frame(f, picks.frame) for f in fault_surfaces(normal.faults)]
    solver = PointSolver.over(inputs_of(picks, meshes, Trims((1.0,) * len(meshes))))
    cuts = rebuild(solver).state.cuts
    links = set(zip(*(end.tolist() for end in cuts.ends(picks.frame.shape[1])), strict=True))
    links |= {(b, a) for a, b in links}
    nodes, share = picks.corners()
    assert np.allclose(share.sum(axis=1), 1.0)
    assert (cuts.kind == FALLING).any()
    whole = [not any((a, b) in links for a in cell for b in cell) for cell in nodes.tolist()]
    assert solver.whole(cuts).tolist() == whole
    assert 10 < len(whole) - sum(whole) < 400


def test_what_is_no_surface_is_refused(normal):
    rng = np.random.default_rng(1)
    few = rng.uniform(0.0, 900.0, (20, 3))
    with pytest.raises(HorizonError, match=r"'Top': 20 scattered points are too few .* Give more"):
        gs.tear_horizon(few, normal.faults, name="Top", spacing=25.0, positive="up")
    s = rng.uniform(0.0, 900.0, 200)
    line = np.column_stack([s, 2.0 * s, s])
    with pytest.raises(HorizonError, match=r"all 200 points are on one line, through \(.*both"):
        gs.tear_horizon(line, normal.faults, name="Top", spacing=25.0, positive="up")
    points = normal.truth["scattered"](300)
    with pytest.raises(HorizonError, match=r"0.01 m would have \d+ x \d+ nodes.*Give a larger"):
        gs.tear_horizon(points, normal.faults, name="Top", spacing=0.01, positive="up")
    with pytest.raises(InputError, match="spacing is -1, expected metres above 0"):
        gs.tear_horizon(points, normal.faults, spacing=-1, positive="up")
    with pytest.raises(InputError, match=r"25 m, but the data are a grid, .* own\. Leave"):
        gs.tear_horizon(normal.horizons["Top"], normal.faults, spacing=25.0)
    with pytest.raises(HorizonError, match=r"points sit on no lattice of right angles\. Give a g"):
        gs.throw_horizon(points, normal.faults, {"F1": 10.0}, name="Top", positive="up")


def test_a_thrust_is_met_by_points_of_both_walls_past_its_trace():
    """An overlap of 7 cells: refused, when nothing held a wall past its trace."""
    world = gs.synthetic.torn("thrust", n=61)
    sheet = gs.tear_horizon(
        world.truth["scattered"](6561), world.faults, name="Top", trim=1.0, positive="up"
    )
    assert sheet.report.tips == sheet.report.declared_tips
    assert_met(measure(world, sheet, "F1"))


@given(
    st.integers(0, 2**32 - 1), st.floats(1.0, 30.0), st.floats(0.0, 2.0 * np.pi),
    st.sampled_from([0.0, 0.2, 0.5]),
)  # fmt: skip
def test_law_points_of_any_lattice_are_met_exactly(seed, ratio, turn, gaps):
    """Steps in any ratio, rotated, with gaps, rounded to a centimetre: every point is a node."""
    rng = np.random.default_rng(seed)
    step = rng.permutation([12.5, 12.5 * ratio])
    grid = np.stack(np.meshgrid(*map(np.arange, rng.integers(9, 30, 2))), -1).reshape(-1, 2)
    grid = grid[rng.random(len(grid)) >= gaps]
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    xy = np.round((grid * step) @ axes + [456000.0, 5930000.0], 2)
    points = np.column_stack([xy, rng.normal(-2000.0, 30.0, len(xy))])
    lattice = gs.tear_horizon(points, {}, name="Top", positive="up").lattice
    nodes = np.column_stack(
        [a.ravel() for a in (lattice.easting, lattice.northing, lattice.elevation)]
    )
    assert set(map(tuple, points)) <= set(map(tuple, nodes))


# ---- Points on the wrong side of a fault: found, named and left out; clean points all stay.
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


@pytest.mark.parametrize("seed", range(4))
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
    assert gs.tear_horizon(clean, [fault], name="Top", positive="up").report.left_out == []


def test_outliers_are_kept_when_asked():
    _, spoilt, fault, _, throw = points_beside_a_fault(3)
    kept = gs.tear_horizon(spoilt, [fault], name="Top", positive="up", keep_outliers=True)
    assert kept.report.left_out == []
    assert kept.report.n_data == len(spoilt)
    assert np.nanmax(np.abs(kept.cuts["F"].throw - throw)) > 0.2 * throw


def test_law_data_that_are_not_met_are_told():
    """Mean, 95th percentile and the worst place, where noise is averaged; nothing on exact data."""
    world = gs.synthetic.torn("normal", n=41)
    for noise in (0.0, 0.2, 3.0):
        points = world.truth["scattered"](4000, noise)
        sheet = gs.tear_horizon(points, world.faults, name="Top", positive="up", spacing=25.0)
        told = [one for one in sheet.warnings if one.kind == "moved data"]
        assert len(told) == (sheet.report.misfit["p95"] > 1.0) == (noise == 3.0)
    words, place = told[0].effect, np.array(told[0].place)
    assert f"off by {sheet.report.misfit['mean']:.3g} m on average" in words
    assert f"noise of {sheet.report.noise:.3g} m" in words
    assert np.abs(points - place).sum(axis=1).min() < 1e-6


# ---- Horizons that overlap by many cells, on a plane that dips by 30 degrees: throw is known.
CELL, MIDDLE_OVERLAP, LEVEL = 40.0, 2003.0, -1500.0
RUN = float(1.0 / np.tan(np.radians(30.0)))
X, Y = np.arange(-200.0, 4201.0, CELL), np.arange(0.0, 801.0, CELL)


def thrust():
    """A plane that rises eastward: its hanging wall is in the west."""
    corners = [
        (MIDDLE_OVERLAP + (z - LEVEL) * RUN, y, z)
        for y, z in ((-900, -3000), (1700, -3000), (1700, 0), (-900, 0))
    ]
    return {"T": gs.TriSurface("T", "fault", np.array(corners, float), [[0, 1, 2], [0, 2, 3]])}


def overlapping(throw):
    """Points of two level walls, each up to its own cut-off."""
    x, y = (a.ravel() for a in np.meshgrid(X, Y))
    upper, lower = LEVEL + 0.5 * throw, LEVEL - 0.5 * throw
    hanging = x < MIDDLE_OVERLAP + (upper - LEVEL) * RUN
    foot = x > MIDDLE_OVERLAP + (lower - LEVEL) * RUN
    wall = [(x[hanging], y[hanging], upper), (x[foot], y[foot], lower)]
    return np.concatenate([np.column_stack([a, b, np.full(len(a), z)]) for a, b, z in wall])


@pytest.mark.parametrize("trim", [1.0, 3.0])
@pytest.mark.parametrize("cells", [6.0, 9.0, 15.0, 21.0])
def test_throw_does_not_depend_on_the_width_of_an_overlap(cells, trim):
    """At nine cells and more a mean of both walls was taken for the horizon, without throw."""
    throw = cells * CELL / RUN
    data = overlapping(throw)
    sheet = gs.tear_horizon(data, thrust(), name="H", trim=trim, positive="up")
    np.testing.assert_allclose(sheet.cuts["T"].throw, -throw, rtol=1e-6)


def test_an_overlap_that_is_too_wide_is_refused_by_name():
    data = overlapping(26.0 * CELL / RUN)
    with pytest.raises(GeometryError, match=r"by 26 cells at fault 'T', near \(.* of 47.* m or mo"):
        gs.tear_horizon(data, thrust(), name="H", trim=1.0, positive="up")


@pytest.mark.parametrize("cells", [9.0, 26.0])
def test_throw_that_is_given_may_overlap_by_any_width(cells):
    """Wider than 24 cells, no wall had a cut-off, and throw was not a number anywhere."""
    flat = gridded(np.full((len(Y), len(X)), LEVEL), X, Y)
    throw = cells * CELL / RUN
    sheet = gs.throw_horizon(flat, thrust(), {"T": -throw}, name="H")
    np.testing.assert_allclose(sheet.cuts["T"].throw, -throw, rtol=1e-6)


def test_a_tear_that_ends_where_it_starts_parts_nothing():
    """Its only triangle was there twice, so that no unit could be found."""
    world = gs.synthetic.torn("thrust", n=41)
    scene = gs.Scene(world.horizons, world.faults, tear=6)
    with pytest.warns(gs.GeosurfWarning, match="throw dies there"):
        certificate = scene.check()
    assert certificate.ok
    assert len(scene.units) == 2
