"""What walls have in common under noise: throw is taken out, and nothing else is shared."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.kernels.sheets.smooth_surface import add_squares
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights import grid_solver, passes
from geosurf.sheets.heights.passes import rebuild, solver_of
from geosurf.sheets.heights.relief import ORDERS, common_relief
from geosurf.sheets.heights.state import Heights, Trims
from geosurf.sheets.lattice.data import picks_or_points
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.solve import BEND, weights_of
from tests.sheets.table import measure

# noise is averaged, which the warning states; it has a test of its own
pytestmark = pytest.mark.filterwarnings("ignore:Horizon .* does not pass through its data")

rows = st.dictionaries(st.integers(0, 6), st.integers(-3, 3), min_size=1, max_size=5)


@given(st.lists(rows, max_size=6), st.permutations(range(7)), st.integers(0, 2**32 - 1))
def test_squares_are_added_where_they_belong(some, place, seed):
    """Whole numbers, so that no order of sums matters."""
    random, place = np.random.default_rng(seed), np.array(place)
    first = np.array([random.integers(0, i + 1) for i in range(7)])
    start = np.append(0, np.cumsum(np.arange(7) - first + 1))
    lower = random.integers(-9, 10, start[-1]).astype(float)
    wanted, dense = np.zeros((7, 7)), np.zeros((len(some), 7))
    for i in range(7):
        wanted[i, first[i] : i + 1] = lower[start[i] : start[i + 1]]
    for k, row in enumerate(some):
        dense[k, place[list(row)]] = list(row.values())
    column = np.array([c for row in some for c in row], dtype=np.int64)
    weight = np.array([w for row in some for w in row.values()], dtype=float)
    of_row = np.append(0, np.cumsum([len(row) for row in some])).astype(np.int64)
    first, lower, start = add_squares(first, lower, start, of_row, column, weight, place)
    found = np.zeros((7, 7))
    for i in range(7):
        found[i, first[i] : i + 1] = lower[start[i] : start[i + 1]]
    assert np.array_equal(found, wanted + np.tril(dense.T @ dense))


def rebuilt(points: np.ndarray, faults, noise: float = 2.0) -> tuple[Picks, Heights]:
    """Both passes over noisy points on a lattice."""
    picks = picks_or_points(points, "Top", "up", None, None)
    assert type(picks) is Picks
    meshes = [
        mesh_in_frame(gs.triangulate_fault(f, name=k), picks.frame) for k, f in faults.items()
    ]
    return picks, rebuild(solver_of(picks, meshes, Trims((0.25,) * len(meshes)), noise)).state


def upright(height, n: int = 31, step: float = 10.0):
    """Points (n * n, 3) of a horizon, height(x, y, side), and an upright fault through it."""
    axis = step * np.arange(n)
    x, y = (c.ravel() for c in np.meshgrid(axis, axis))
    middle = 0.5 * axis[-1]
    away = x - middle - 0.2 * (y - middle) - 3.0
    points = np.stack([x, y, height(x, y, np.where(away > 0, 1.0, -1.0))], axis=1)
    ends = np.array([-60.0, axis[-1] + 60.0])
    east = np.stack([middle + 0.2 * (ends - middle) + 3.0] * 2)
    down = np.array([[400.0, 400.0], [-400.0, -400.0]])
    fault = np.stack([east, np.stack([ends] * 2), down])
    return points, {"F1": gs.synthetic.world.make_fault("F1", *fault, (0.0, 0.0, 0.0))}


def test_a_throw_and_walls_that_tilt_and_bend_apart_cost_nothing():
    """Differences reach across the trace, and vanish on planes with the coefficients' own throw."""
    points, faults = upright(lambda x, y, side: 0.1 * x - 0.2 * y - 15.0 * side)
    picks, state = rebuilt(points, faults)
    frame, (trace,) = picks.frame, state.network.traces
    nodes = np.arange(frame.shape[0] * frame.shape[1])
    weights = weights_of(frame.stretch, BEND)
    common = common_relief(nodes, state.cuts, state.network, state.near, frame.shape, weights)
    number = common.n_coefficient // ORDERS
    matrix = common.matrix
    across = matrix[:, : len(nodes)]
    assert (np.diff(across.indptr) > 0).sum() > 300  # seven differences for each row of nodes
    normal = trace.line[0, 3:5] / np.hypot(*trace.line[0, 3:5])
    places = frame.cells_of_node(nodes)
    away = (places - trace.line[0, :2]) @ normal
    flat = 2.0 * places[:, 0] - places[:, 1]
    for order, power in enumerate((np.ones(len(nodes)), away, 0.5 * away**2)):
        coefficients = np.zeros(common.n_coefficient)
        coefficients[order * number : (order + 1) * number] = 8.0
        heights = flat + 0.5 * np.sign(away) * 8.0 * power
        left = matrix @ np.concatenate([heights, coefficients])
        assert np.abs(left).max() < 2e-3  # what holds coefficients; lines are on whole units
        assert np.abs(matrix @ np.concatenate([heights, 0 * coefficients])).max() > 1.0
    assert (
        common_relief(nodes, state.cuts, state.network, state.near, frame.shape, weights, {0})
        is None
    )


def test_planes_are_met_whatever_noise_is_thought_to_be():
    points, faults = upright(lambda x, y, side: 0.1 * x - 0.2 * y - 15.0 * side)
    _, state = rebuilt(points, faults)
    there = np.isfinite(state.values)
    assert state.values[there] == pytest.approx(points[there, 2], abs=0.01)  # first differences


def test_walls_share_relief_unless_data_speak_against_it(monkeypatch):
    """One wall is moved along the fault: then both are what they are without the other."""

    def relief(slide):
        noise = np.random.default_rng(4).standard_normal(81 * 81)
        return lambda x, y, side: (
            12.0 * np.sin((x + 0.3 * y + slide * side) / 90.0) - 15.0 * side + noise
        )

    points, faults = upright(relief(0.0), 81)
    _, state = rebuilt(points, faults, 1.0)
    assert state.apart == set()
    slid, _ = upright(lambda x, y, side: relief(0.0)(x, y + 400.0 * side, side), 81)
    _, moved = rebuilt(slid, faults, 1.0)
    assert moved.apart == {0}
    monkeypatch.setattr(grid_solver, "common_relief", lambda *_: None)
    alone = [rebuilt(data, faults, 1.0)[1].values for data in (points, slid)]
    assert np.array_equal(moved.values, alone[1], equal_nan=True)
    assert not np.array_equal(state.values, alone[0], equal_nan=True)


def test_throw_may_jump_where_a_fault_meets_another():
    """The main fault of a Y has two throws: coefficients of one are in no row with the other's."""
    world = gs.synthetic.torn("Y", 61, noise=2.0)
    picks, state = rebuilt(world.truth["points"], world.faults)
    nodes = np.flatnonzero(np.isfinite(state.values))
    weights = weights_of(picks.frame.stretch, BEND)
    common = common_relief(
        nodes, state.cuts, state.network, state.near, picks.frame.shape, weights, {1}
    )
    throws = common.matrix[:, len(nodes) :]
    meet = (throws.T @ throws).toarray() != 0.0
    reached = np.linalg.matrix_power(meet.astype(float), 40)[0] > 0
    assert 0 < reached.sum() < common.n_coefficient


def test_noisy_cut_offs_gain_by_it(monkeypatch):
    """Squared errors of throw are a fifth less on the branch of a Y; its depth varies as true."""
    found = []
    for share in (True, False):
        if not share:
            monkeypatch.setattr(grid_solver, "common_relief", lambda *_: None)
        errors = []
        for seed in (1, 2, 3):
            world = gs.synthetic.torn("Y", 81, noise=2.0, seed=seed)
            sheet = gs.tear_horizon(
                world.truth["points"], world.faults, name="Top", trim=0.25, positive="up"
            )
            errors.append(measure(world, sheet, "F2"))
        found.append(np.mean([np.mean(m.throw**2) for m in errors]))
        if share:
            assert max(abs(v - 1.0) for m in errors for v in m.variation) < 0.05
    assert found[0] < 0.8 * found[1]


def test_scattered_points_gain_by_it(monkeypatch):
    found = []
    for share in (True, False):
        if not share:
            monkeypatch.setattr(passes, "common_relief", lambda *_: None)
        errors = []
        for seed in (1, 2):
            world = gs.synthetic.torn("through", 61)
            points = world.truth["scattered"](61 * 61, 2.0, seed)
            sheet = gs.tear_horizon(points, world.faults, name="Top", trim=1.0, positive="up")
            errors.append(np.mean(measure(world, sheet, "F1").throw ** 2))
        found.append(np.mean(errors))
    assert found[0] < 0.9 * found[1]
