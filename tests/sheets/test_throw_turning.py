"""By throw on faults that turn in the map or turn back: throw is met down their own dip."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError
from geosurf.sheets.faults.fault_profile import dip_lines, section_of
from geosurf.synthetic.world import make_fault
from tests.grids import gridded
from tests.sheets.test_throw import BOX, along, horizon, wall

AXIS = np.array([-400.0, 500.0])  # of the cones
COT = 1.0 / np.tan(np.radians(60.0))
RADIUS = 900.0  # of the cone at -1800 m


def cone(turn=1.0, n=9, m=61, half=700.0):
    """A fault that dips at 60 degrees away from a vertical axis, or (`turn` -1) towards it."""
    z = np.linspace(-1450.0, -2150.0, n)[:, None]
    phi = np.linspace(-half, half, m)[None, :] / RADIUS
    r = RADIUS + turn * COT * (-1800.0 - z)
    x, y = AXIS[0] + r * np.cos(phi), AXIS[1] + r * np.sin(phi)
    return make_fault("F1", x, y, z + 0.0 * phi, (0.0, 0.0, 0.0))


def slope(x, y):
    """A plane that dips steeply along the strike of the cone."""
    return -1800.0 + 0.04 * (x - 500.0) - 0.2 * (y - 500.0)


def down_true_dip(cut, n=101):
    """Throw in vertical planes through the axis, in which the cone dips: by other means."""
    at, z = np.linspace(-0.45, 0.45, n), {}
    for side, lines in cut.cutoffs.items():
        points = np.concatenate(lines)
        east, north = (points[:, :2] - AXIS).T
        phi = np.arctan2(north, east)
        order = np.argsort(phi)
        z[side] = np.interp(at, phi[order], points[order, 2])
    return z["-"] - z["+"]


@pytest.mark.parametrize(
    ("turn", "throw", "share"), [(1.0, 60.0, 1.0), (-1.0, 45.0, 0.4), (1.0, -40.0, 1.0)]
)
def test_throw_down_the_true_dip_of_a_cone_is_met_to_order_two(turn, throw, share):
    worst = []
    for n in (21, 41):
        fault = cone(turn, m=2 * n + 1)
        sheet = gs.throw_horizon(
            horizon(n, slope), {"F1": fault}, {"F1": throw}, hanging_wall=share
        )
        cut = sheet.cuts["F1"]
        worst.append(np.abs(down_true_dip(cut) - throw).max())
        assert np.nanmax(np.abs(cut.throw - throw)) < 3e-4 * abs(throw)
        assert np.nanmax(np.abs(cut.heave - throw * COT)) < 3e-3 * abs(throw)
        assert sheet.report.tips == sheet.report.declared_tips == 0
    assert worst[1] < 2e-4 * abs(throw)
    assert worst[0] > 1.8 * worst[1]
    across = gs.throw_horizon(
        horizon(41, slope), {"F1": fault}, {"F1": throw}, hanging_wall=share, direction="mean"
    )
    assert np.abs(down_true_dip(across.cuts["F1"]) - throw).max() > 0.03 * abs(throw)
    assert np.nanmax(np.abs(across.cuts["F1"].throw - throw)) < 3e-4 * abs(throw)


@pytest.mark.parametrize(("dip", "azimuth"), [(60.0, 100.0), (35.0, 250.0), (90.0, 33.0)])
def test_on_a_plane_both_directions_are_one(dip, azimuth):
    """Also on one that a grid of many facets makes, with the rounding of its corners."""
    fault = wall(dip, azimuth, n=7, m=11)
    one, two = (
        gs.throw_horizon(horizon(31, slope), {"F1": fault}, {"F1": 40.0}, direction=d)
        for d in ("local", "mean")
    )
    assert np.abs(one.lattice.elevation - two.lattice.elevation).max() < 1e-9
    for side in "+-":
        for a, b in zip(one.cuts["F1"].cutoffs[side], two.cuts["F1"].cutoffs[side], strict=True):
            np.testing.assert_allclose(a, b, rtol=0, atol=1e-9)
    np.testing.assert_allclose(one.cuts["F1"].throw, two.cuts["F1"].throw, rtol=0, atol=1e-9)
    # cut-offs have pieces of 1e-8 m, on which throw is read to fewer places
    assert np.nanmax(np.abs(one.cuts["F1"].throw - 40.0)) < 1e-5


def test_at_a_crease_rock_is_not_torn_along_strike():
    """Two planes that meet at an angle: strike is a mean over as far as beds need to bend."""
    z = np.array([-1450.0, -2150.0])[:, None]
    s = np.array([-900.0, 0.0, 900.0])[None, :]
    down = COT * (-1800.0 - z)
    for bend in (0.5, -0.5):
        fault = make_fault(
            "F1", 500.0 + down + bend * np.abs(s), 500.0 + s + 0 * z, z + 0 * s, (0.0, 0.0, 0.0)
        )
        section = section_of(gs.triangulate_fault(fault, name="F1"), np.zeros(2), 12.5)
        lines = dip_lines(section, 60.0, 25.0)
        spacing = section.length / (len(lines.table) - 1)
        assert 60.0 * np.abs(np.diff(lines.table, axis=0)).max() / spacing <= 0.5
        sheet = gs.throw_horizon(horizon(41, slope), {"F1": fault}, {"F1": 60.0})
        assert np.nanmax(np.abs(sheet.cuts["F1"].throw - 60.0)) < 0.3
        assert sheet.report.tips == 0


def test_units_between_sheets_on_a_cone_are_closed_and_fill_the_box():
    n = 31
    beds = {
        "Top": horizon(n, slope),
        "Base": horizon(n, lambda x, y: slope(x, y) - 80.0, name="Base"),
    }
    faults = {"F1": cone(half=800.0)}
    sheets = {k: gs.throw_horizon(h, faults, {"F1": 50.0}, name=k) for k, h in beds.items()}
    box = (*BOX[:4], -2140.0, -1460.0)
    scene = gs.Scene(sheets, {f.name: f for f in sheets["Top"].faults}, box)
    assert scene.check().ok
    assert set(scene.units) == {
        f"{zone} F1{side}" for zone in ("above Top", "Top/Base", "below Base") for side in "+-"
    }
    assert scene.units.volume == pytest.approx(scene.units.box_volume, rel=1e-12)
    for name in sheets:
        assert np.nanmax(np.abs(sheets[name].cuts["F1"].throw - 50.0)) < 0.02
        # the model says the same, by the same lines; across the mean strike it is something else
        model = scene.throw(name, "F1")
        assert model.sizes["point"] > n
        assert np.abs(model.throw - 50.0).max() < 0.02
        assert np.abs(model.heave - 50.0 * COT).max() < 0.2
        mean = scene.throw(name, "F1", direction="mean")
        assert np.abs(mean.throw - 50.0).max() > 1.0
        assert (model.attrs["direction"], mean.attrs["direction"]) == ("local", "mean")


def test_a_fault_that_turns_back_has_throw_unless_that_is_between_its_cutoffs():
    """A wall that is folded up at its foot, where a horizon meets it or not."""
    corners = [[500, 0, -1400], [500, 1000, -1400], [500, 1000, -2100], [500, 0, -2100]]
    wing = [480, 500, -2050]
    folded = gs.TriSurface(
        "F1", "fault", np.array([*corners, wing], float), [[0, 1, 2], [0, 2, 3], [3, 2, 4]]
    )
    deep = horizon(11, lambda x, y: -2070.0 + 0.0 * x, name="Deep")
    box = (*BOX[:4], -2140.0, -1460.0)
    scene = gs.Scene({"Top": horizon(11, slope), "Deep": deep}, {"F1": folded}, box)
    for direction in ("local", "mean"):
        found = scene.throw("Top", "F1", direction=direction)
        assert found.throw.values == pytest.approx(0.0, abs=1e-9)
        assert found.sizes["point"] > 1
    with pytest.raises(GeometryError, match=r"'F1' turns back .* between its cut-offs") as caught:
        scene.throw("Deep", "F1")
    east, _, level = caught.value.place
    assert (east, level) == pytest.approx((494.0, -2070.0), abs=10.0)
    (note,) = caught.value.__notes__
    assert note == "With direction='mean' throw is read across the mean strike."


# ------------------------------------------------------------------------- at tips
def test_throw_that_cells_are_too_coarse_for_is_told_with_its_place():
    tips, asked = wall(half=400.0), gs.EllipticThrow(50.0)
    lost = gs.throw_horizon(horizon(21), {"F1": tips}, {"F1": asked}).report.lost
    assert len(lost) == 2
    for one in lost:
        s = along(np.array([one.place]), half=400.0)[0]
        assert min(s, 800.0 - s) < 101.0  # two cells of 50 m
        truth = gs.EllipticThrow(50.0, 400.0, centre=(400.0, None)).at(np.array([s]), np.zeros(1))
        assert one.requested == pytest.approx(truth[0], abs=1e-6)
        assert one.requested - one.measured > 0.02 * 50.0
        assert 20.0 < one.suggested_cell < one.cell == pytest.approx(50.0)
    finer = gs.throw_horizon(horizon(41), {"F1": tips}, {"F1": asked}).report
    assert finer.lost == ()
    assert not [note for note in finer.notes if "too coarse" in note]


def test_a_fault_without_length_at_the_horizon_has_no_throw_there():
    """Its mesh ends in a corner, at the level of which it has no length to share out throw over."""
    field = gs.EllipticThrow(30.0)
    corner = gs.TriSurface(
        "F1", "fault", [[500, 200, -2000], [400, 500, -1600], [500, 800, -2000]], [[0, 1, 2]]
    )
    section = section_of(corner, np.zeros(2), 10.0)
    s = np.array([100.0, 300.0, 500.0])
    assert field.at(s, np.full(3, section.z[1]), section).tolist() == [0.0, 0.0, 0.0]
    assert field.at(np.array([300.0]), np.array([-1990.0]), section) == pytest.approx(30.0)


@pytest.mark.parametrize("beyond", ["level", "backward"])
def test_parts_of_a_fault_that_no_wall_reaches_may_lie_flat_or_turn_back(beyond):
    """Level triangles turn neither way; those far from the horizon are not looked at."""
    x, z = np.array([1500.0, 2000.0, 2200.0, 4200.0]), np.array([-900.0, -1450.0, -1900.0, -1900.0])
    if beyond == "backward":
        x[3], z[3] = 2000.0, -2300.0
    y = np.linspace(-400.0, 1400.0, 4)
    fault = make_fault("L", x[:, None], y, z[:, None], (0.0, 0.0, 0.0))
    east, north = np.arange(200.0, 3801.0, 40.0), np.arange(0.0, 1001.0, 40.0)
    flat = gridded(np.full((len(north), len(east)), -1500.0), east, north)
    sheet = gs.throw_horizon(flat, {"L": fault}, {"L": 50.0}, name="H")
    np.testing.assert_allclose(sheet.cuts["L"].throw, 50.0, atol=1e-6)
