"""Throw that dies at a tip, faults too short for it, and what walls share under noise."""

from __future__ import annotations

import re
import warnings
from ast import literal_eval

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeosurfWarning
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights import grid_solver
from geosurf.sheets.heights.passes import rebuild, solver_of
from geosurf.sheets.heights.state import Heights, Trims
from geosurf.sheets.lattice.data import read_data
from geosurf.sheets.lattice.picks import Picks, scale_of
from geosurf.sheets.lattice.solve import lattice_graph, smoothest
from tests.grids import gridded
from tests.sheets import held_out
from tests.sheets.table import assert_met, measure

# noise is averaged, which the warning states; it has a test of its own
pytestmark = pytest.mark.filterwarnings("ignore:Horizon .* does not pass through its data")


def test_noise_is_smoothed_alike_on_cells_of_any_width():
    """A saddle, of which third differences see nothing, on cells half as wide: meant over twice
    as many of them it is flattened as much, and over as many four times as much."""
    found = []
    for n, weight, scale in ((25, 2.0**-6, 2.0), (49, 4.0**-6, 4.0), (49, 4.0**-6, 2.0)):
        x = np.linspace(-12.0, 12.0, n)
        z = (0.1 * (x[:, None] ** 2 - x**2)).ravel()
        every, pull = np.arange(n * n), np.full(n * n, weight)
        graph = lattice_graph(every, (n, n))
        sheet = smoothest(graph, every, z, np.ones(2), pull=pull, target=z, scale=scale)
        found.append(np.abs(sheet - z).max())
    assert scale_of(weight) == pytest.approx(4.0)
    assert found[1] == pytest.approx(found[0], rel=0.3)  # differences are taken within the rim
    assert found[2] > 3.0 * found[1]


# mean and worst error of the throw [%]: without shapes cracks have 10 to 24 at worst
CRACKS = ["crack", "half crack", "push crack"]


@pytest.mark.parametrize("name", [*CRACKS, "bell", "relay"])
def test_held_out_worlds_are_met_as_asked(name):
    faults, n, step, points = held_out.WORLDS[name]
    world = gs.synthetic.torn(faults, n, step=step)
    picked = world.truth["points"] if points else world.horizons["Top"]
    sheet = gs.tear_horizon(picked, world.faults, name="Top", trim=2.25, positive="up")
    assert sheet.report.tips == sheet.report.declared_tips
    for fault in world.faults:
        assert_met(measure(world, sheet, fault, cell=step))


def test_noise_is_smoothed_where_every_node_beside_a_trace_keeps_a_datum():
    """Around a reverse fault none loses all of its data: nothing was smoothed at its far tip."""
    world = gs.synthetic.torn("reverse", n=61, noise=2.0)
    points = world.truth["points"]
    sheet = gs.tear_horizon(points, world.faults, name="Top", trim=0.25, noise=2, positive="up")
    col, row = np.rint(points[:, :2] / 25.0).astype(np.int64).T
    met = sheet.lattice.elevation[row, col] == points[:, 2]
    for k in (0, -1):
        near = np.hypot(*(points[:, :2] - sheet.cuts["F1"].stations[k, :2]).T) < 75.0
        assert near.sum() > 20
        assert not met[near].any()


# ---- The equations of the smoothest surface against differences that are written out one by o
def test_a_cubic_is_carried_on_beyond_the_data():
    """Fourth differences of a cubic are zero: where data end, it goes on as it is."""
    row, col = np.divmod(np.arange(400), 20)
    x, y = 0.1 * col, 0.1 * row
    cubic = 3.0 * x**3 - 2.0 * x**2 * y + x * y**2 + y**3 - x * y + 4.0
    unknown = np.where(col >= 14, np.cumsum(col >= 14) - 1, -1)
    graph = lattice_graph(np.arange(400), (20, 20))
    wall = unknown >= 0
    exact = cubic[wall]
    third, fourth = (
        smoothest(graph, unknown, np.where(wall, 0.0, cubic), np.ones(2), order=k) for k in (3, 4)
    )
    near = col[wall] < 18
    assert np.abs(fourth - exact)[near].max() < 0.3 * np.abs(third - exact)[near].max()


# ---- Faults that were picked too short: the throw that data have beyond their ends.
# noise is averaged, which the warning states; it has a test of its own

CELL = 40.0
X, Y = np.arange(-200.0, 4201.0, CELL), np.arange(-200.0, 3201.0, CELL)
EAST = 2003.0  # of the fault


def torn(end, died, largest=50.0, **options):
    """A sheet of a fault that ends at a northing; in the data throw dies from 1700 to `died`."""
    x, y = np.meshgrid(X, Y)
    throw = largest * np.clip((died - y) / (died - 1700.0), 0, 1)
    throw *= np.maximum(0.0, 1.0 - np.abs(x - EAST) / 800.0)
    grid = gridded(-1600.0 + np.where(x < EAST, 0.5, -0.5) * throw, X, Y)
    corners = [(EAST, y, z) for y, z in ((-900, -2100), (end, -2100), (end, -1300), (-900, -1300))]
    fault = gs.TriSurface("F", "fault", np.array(corners, float), [[0, 1, 2], [0, 2, 3]])
    return gs.tear_horizon(grid, {"F": fault}, name="H", **options)


@pytest.mark.parametrize(("largest", "trim"), [(50.0, 1.0), (-50.0, 2.0)])
@pytest.mark.parametrize(("end", "there"), [(1300.0, 50.0), (1700.0, 50.0), (1900.0, 37.5)])
def test_throw_at_a_fault_that_is_too_short_is_a_warning(end, there, trim, largest):
    """50 m of throw died within a few cells, and the report had no word of it."""
    with pytest.warns(
        GeosurfWarning, match=r"'F' ends inside horizon 'H' at .* a throw of "
    ) as told:
        sheet = torn(end, 2500.0, largest, trim=trim)
    assert [one.filename for one in told] == [__file__]  # the line of the user's own code
    (warning,) = sheet.warnings
    assert (warning.kind, warning.subject) == ("throw at tip", "F")
    np.testing.assert_allclose(warning.place[:2], (EAST, end), atol=0.1 * CELL)
    words = str(warning)
    assert abs(float(words.split("a throw of ")[1].split(" m")[0]) - np.sign(largest) * there) < 3.0
    assert abs(float(words.split("continues for ")[1].split(" m")[0]) + end - 2440.0) < 3 * CELL
    assert words in str(sheet.report)


def test_what_the_remedy_types_ends_the_throw():
    """`lengthen` as it is printed: the longer fault has no throw at its tip."""
    with pytest.warns(GeosurfWarning, match="continues for"):
        sheet = torn(1700.0, 2500.0, trim=2.0)
    remedy = sheet.warnings[0].remedy
    typed = re.search(r"lengthen={'F': ({'\w+': \d+})}; in a scenario, lengthen_m = {", remedy)
    assert typed, remedy
    (fault,) = sheet.faults
    longer = gs.lengthen_fault(fault, literal_eval(typed[1])).surface
    assert longer.bounds[3] > 2440.0 - 3 * CELL
    with warnings.catch_warnings(action="error"):
        torn(longer.bounds[3], 2500.0, trim=2.0)


@pytest.mark.parametrize(("end", "trim"), [(2500.0, 1.0), (2500.0, 3.0), (2900.0, 2.0)])
def test_a_fault_as_long_as_its_throw_has_none(end, trim):
    with warnings.catch_warnings(action="error"):
        assert torn(end, 2500.0, trim=trim).warnings == ()


@pytest.mark.parametrize(
    ("kind", "noise"),
    [
        ("normal", 0.0),
        ("ellipse", 2.0),
        ("listric", 0.0),
        ("Y", 2.0),
        ("X", 0.0),
        ("parallel", 2.0),
    ],
)
def test_throw_that_dies_properly_has_none(kind, noise):
    """Also as a root, around which both walls bend as around a crack."""
    world = gs.synthetic.torn(kind, 61, noise=noise)
    data = world.truth["points"] if noise else world.horizons["Top"]
    trim = 0.25 if noise else 2.25
    sheet = gs.tear_horizon(data, world.faults, name="Top", trim=trim, positive="up")
    assert sheet.warnings == ()


@pytest.mark.parametrize(
    ("smear", "gap", "noise"),
    [(1, 2, 0.3), (1, 6, 0.0), (1, 14, 0.3), (2, 4, 0.0), (2, 9, 0.3), (4, 2, 0.0), (4, 6, 0.3),
     (4, 14, 0.0)],
)  # fmt: skip
def test_law_throw_is_not_lost_in_silence_wherever_the_fault_ends(smear, gap, noise):
    """60 m from rim to rim, smeared; the fault ends some cells inside at both ends."""
    x, y = np.meshgrid(*[np.arange(0.0, 61 * CELL, CELL)] * 2)
    middle, tan, end = 30 * CELL, np.tan(np.radians(60.0)), 60 * CELL - gap * CELL
    share = np.clip((x - middle - 30.0 / tan) / (2 * smear * CELL) + 0.5, 0.0, 1.0)
    z = -1500.0 - 60.0 * share + noise * np.random.default_rng(1).standard_normal(x.shape)
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    corners = [
        (middle + (-1500.0 - z) / tan, y, z)
        for y, z in ((gap * CELL, -1200), (end, -1200), (end, -1900), (gap * CELL, -1900))
    ]
    fault = gs.TriSurface("F", "fault", np.array(corners, float), [[0, 1, 2], [0, 2, 3]])
    with pytest.warns(GeosurfWarning, match="ends inside horizon 'H' at"):
        sheet = gs.tear_horizon(points, {"F": fault}, name="H", positive="up")
    assert [one.kind for one in sheet.warnings].count("throw at tip") == 2


# ---- What walls have in common under noise: throw is taken out, and nothing else is shared.


def rebuilt(points: np.ndarray, faults, noise: float = 2.0) -> tuple[Picks, Heights]:
    """Both passes over noisy points on a lattice."""
    picks = read_data(points, "Top", "up").picks
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
