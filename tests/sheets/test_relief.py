"""What walls have in common under noise: throw is taken out, and nothing else is shared."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights import grid_solver, passes
from geosurf.sheets.heights.passes import rebuild, solver_of
from geosurf.sheets.heights.state import Heights, Trims
from geosurf.sheets.lattice.data import picks_or_points
from geosurf.sheets.lattice.picks import Picks
from tests.sheets.table import measure

# noise is averaged, which the warning states; it has a test of its own
pytestmark = pytest.mark.filterwarnings("ignore:Horizon .* does not pass through its data")


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
