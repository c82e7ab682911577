"""Sheets by throw: what is recovered is what was put in, wherever a fault lies on the grid."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeometryError, HorizonError
from geosurf.synthetic.torn_horizon import relief
from geosurf.synthetic.world import make_fault, make_horizon
from tests.grids import gridded
from tests.messages import refused

BOX = (0.0, 1000.0, 0.0, 1000.0, -2200.0, -1400.0)
KINDS = ["normal", "reverse", "vertical", "graben", "X", "Y"]


def plane(x, y):
    """A plane horizon."""
    return -1800.0 + 0.04 * (x - 500.0) - 0.06 * (y - 500.0)


def horizon(n=41, height=plane, box=BOX, name="Top"):
    return make_horizon(name, box, n, height, (0.0, 0.0, 0.0))


def wall(dip=60.0, azimuth=100.0, half=900.0, at=(500.0, 500.0), bend=0.0, name="F1", n=2, m=2):
    """A fault that cuts right through, plane or (`bend`) an arc of parabola down dip."""
    a = np.radians(azimuth)
    z = np.linspace(-1500.0, -2150.0, n)[:, None]
    s = np.linspace(-half, half, m)[None, :]
    down = -1800.0 - z
    r = down / np.tan(np.radians(dip)) + bend * down**2 if dip < 90 else 0.0 * down
    x = at[0] - s * np.cos(a) + r * np.sin(a)
    y = at[1] + s * np.sin(a) + r * np.cos(a)
    return make_fault(name, x, y, z + 0.0 * s, (0.0, 0.0, 0.0))


def along(points, azimuth=100.0, half=900.0, at=(500.0, 500.0)):
    """Distance along the strike of `wall` from its first end by the right-hand rule."""
    a = np.radians(azimuth)
    return (points[:, 0] - at[0]) * -np.cos(a) + (points[:, 1] - at[1]) * np.sin(a) + half


def model(kind, n=13):
    """World, sheets by throw, and the scene of a planar world."""
    world = gs.synthetic.faulted(kind, n)
    faults = world.faults
    if world.truth["truncations"]:
        cut = gs.Scene({}, faults, world.box, truncations=world.truth["truncations"])
        faults = {name: cut.surface(name) for name in faults}
    throw = world.truth["throw"]
    sheets = {k: gs.throw_horizon(h, faults, throw, name=k) for k, h in world.horizons.items()}
    used = {fault.name: fault for fault in sheets["Top"].faults}
    return world, sheets, gs.Scene(sheets, used, world.box)


@pytest.fixture(scope="module", params=KINDS)
def planar(request):
    return model(request.param)


# ------------------------------------------------------------- planes: to rounding
def test_volumes_of_planes_are_those_of_half_spaces(planar):
    world, _, scene = planar
    true = world.truth["volumes"]
    assert len(scene.units) == len(true)
    for (zone, sides), volume in true.items():
        mine = [u for u in scene.units.values() if u.zone == zone]
        found = sum(u.volume for u in mine if set(u.block.split()) <= set(sides))
        assert found == pytest.approx(volume, rel=1e-9), (zone, sides)
    assert scene.check().ok


def test_juxtaposed_areas_of_planes_are_known(planar):
    world, _, scene = planar
    for fault in world.faults:
        table = scene.juxtaposition(fault, "all").to_dataframe()
        found = table.groupby(["zone_plus", "zone_minus"]).area.sum().to_dict()
        true = {(a, b): v for (f, a, b), v in world.truth["juxtaposition"].items() if f == fault}
        assert set(found) == set(true)
        assert found == pytest.approx(true, rel=1e-9)


def test_recovered_throw_is_the_throw_put_in(planar):
    """Where no other fault adds to it: in a Y beyond the contact, in an X right at the crossing."""
    world, sheets, scene = planar
    for fault, throw in world.truth["throw"].items():
        whole = world.name not in ("faulted_X", "faulted_Y") or fault == "F2"
        for name, sheet in sheets.items():
            for found in (sheet.cuts[fault].throw, scene.throw(name, fault).throw.values):
                assert len(found) > 5
                assert np.isnan(found).sum() < 3  # at the rim and right at a crossing
                found = found[np.isfinite(found)]
                error = np.abs(found - throw)
                assert np.median(error) < 1e-7
                if whole:
                    assert error.max() < 1e-7


def test_throws_add_up_beyond_a_branch():
    _, sheets, _ = model("Y")
    cut = sheets["Top"].cuts["F1"]
    # the horizon is tilted, so that a throw along another fault is not quite its own on this one
    assert cut.throw.min() == pytest.approx(70.0, abs=1e-6)
    assert cut.throw.max() == pytest.approx(70.0 + 30.0, abs=1.0)
    assert sheets["Top"].report.branches == {"F2": ("F1",)}


@pytest.mark.parametrize("share", [1.0, 0.4, 0.0])
@pytest.mark.parametrize(("dip", "throw"), [(60.0, 45.0), (40.0, -30.0), (90.0, 20.0)])
def test_cutoffs_lie_on_the_fault_and_walls_share_the_throw(dip, throw, share):
    fault = wall(dip)
    sheet = gs.throw_horizon(horizon(), {"F1": fault}, {"F1": throw}, hanging_wall=share)
    cut = sheet.cuts["F1"]
    inner = slice(1, -1)  # at the rim of the data one wall may be outside
    assert cut.throw[inner] == pytest.approx(throw, abs=1e-7)
    a = np.radians(100.0)
    cot = 0.0 if dip == 90 else 1.0 / np.tan(np.radians(dip))
    assert cut.heave[inner] == pytest.approx(throw * cot, abs=1e-7)
    lift = {"+": -share * throw, "-": (1.0 - share) * throw}
    for side, lines in cut.cutoffs.items():
        for x, y, z in np.concatenate(lines):
            r = (x - 500.0) * np.sin(a) + (y - 500.0) * np.cos(a)
            assert r == pytest.approx((-1800.0 - z) * cot, abs=1e-6)
            back = -lift[side] * cot  # where the particle was
            before = plane(x - back * np.sin(a), y - back * np.cos(a))
            assert z == pytest.approx(before + lift[side], abs=1e-6)


def test_the_footwall_is_the_horizon_itself_bit_for_bit():
    top = horizon()
    sheet = gs.throw_horizon(top, {"F1": wall()}, {"F1": 40.0})
    x, y = np.meshgrid(top.easting.values, top.northing.values)
    far = (x - 500.0) * np.sin(np.radians(100)) + (y - 500.0) * np.cos(np.radians(100))
    foot = far < -120.0
    assert foot.sum() > 100
    assert (sheet.lattice.elevation[foot] == top.values[foot]).all()
    assert (sheet.lattice.elevation[far > 120.0] != top.values[far > 120.0]).all()


@pytest.mark.parametrize("dip", [60.0, 40.0, 90.0])
def test_scissors_by_throw_are_sealed(dip):
    """One sheet has a gap, an overlap, and a place between where its walls meet."""
    throw = {"F1": [[0.0, -40.0], [1800.0, 40.0]]}
    sheet = gs.throw_horizon(horizon(height=relief), {"F1": wall(dip)}, throw, name="Top")
    found = sheet.cuts["F1"].throw
    assert np.nanmin(found) < -20.0
    assert np.nanmax(found) > 20.0
    faults = {fault.name: fault for fault in sheet.faults}
    scene = gs.Scene({"Top": sheet}, faults, (100.0, 900.0, 100.0, 900.0, -2070.0, -1530.0))
    assert len(scene.units) == 4
    assert scene.check().ok


# ------------------------------------------------------------- forms of throw
def forms():
    s = np.array([0.0, 1800.0])
    profile = xr.DataArray([10.0, 55.0], {"along_strike": s}, "along_strike")
    cm = xr.DataArray([1000.0, 5500.0], {"along_strike": s}, "along_strike", attrs={"units": "m"})
    cm = cm / 100.0
    return {
        "array": np.column_stack([s, profile]),
        "list": [[0.0, 10.0], [1800.0, 55.0]],
        "function": lambda at: 10.0 + at / 40.0,
        "profile": profile,
        "profile of points": xr.DataArray([10.0, 55.0], {"along_strike": ("point", s)}, "point"),
    }


@pytest.mark.parametrize("form", forms())
def test_a_profile_in_any_form_is_met_along_the_strike(form):
    cut = gs.throw_horizon(horizon(), {"F1": wall()}, {"F1": forms()[form]}).cuts["F1"]
    asked = 10.0 + along(cut.stations) / 40.0
    assert cut.throw == pytest.approx(asked, abs=1e-6)
    assert np.ptp(cut.throw) > 15.0


def test_a_map_of_throw_is_read_where_the_rock_was():
    grid = gridded([[20.0, 40.0], [20.0, 40.0]], [-500.0, 1500.0]).drop_attrs()
    cut = gs.throw_horizon(horizon(), {"F1": wall(90.0)}, {"F1": grid}).cuts["F1"]
    assert cut.throw == pytest.approx(25.0 + cut.stations[:, 0] / 100.0, abs=1e-6)


def test_what_was_measured_can_be_put_in_again():
    world, sheets, scene = model("normal")
    measured = scene.throw("Top", "F1").throw
    fault = sheets["Top"].faults[0]
    again = gs.throw_horizon(world.horizons["Top"], [fault], {"F1": measured}, name="Top")
    assert again.lattice.elevation == pytest.approx(sheets["Top"].lattice.elevation, abs=1e-6)


def test_the_elliptic_field_dies_at_its_tip_line():
    field = gs.EllipticThrow(80.0, 400.0, 200.0, (400.0, -1800.0))
    turn = np.linspace(0.0, 2 * np.pi, 9)
    rim = 400.0 + 400.0 * np.cos(turn), -1800.0 + 200.0 * np.sin(turn)
    assert field.at(*rim) == pytest.approx(0.0, abs=1e-9)
    half = 400.0 + 200.0 * np.cos(turn), -1800.0 + 100.0 * np.sin(turn)
    assert np.ptp(field.at(*half)) < 1e-9  # contours are ellipses
    assert field.at(np.array([400.0]), np.array([-1800.0])) == pytest.approx(80.0)


# ------------------------------------------------------------- curved: order two
@pytest.mark.parametrize("kind", ["finite", "listric", "reverse"])
def test_throw_on_curved_surfaces_is_met_to_order_two(kind):
    """Linear interpolation of beds and profile on the lattice is all that is missing."""
    bend, dip = {"finite": (0.0, 60.0), "listric": (6e-4, 60.0), "reverse": (0.0, 45.0)}[kind]
    sign = -1.0 if kind == "reverse" else 1.0
    half = 900.0 if kind == "listric" else 400.0
    # of the beds: as they were, and on both walls; and of the throw
    beds = 15.0 * (2 * np.pi / 1200.0) ** 2 + 60.0 * (2 * np.pi / 4000.0) ** 2
    curvature = 3 * beds + 8e-4
    for n in (31, 61):
        arc = {"n": 2 * n, "m": 61} if kind == "listric" else {}
        fault = wall(dip, half=half, bend=bend, **arc)
        given = 50.0 if kind == "listric" else gs.EllipticThrow(sign * 50.0)
        sheet = gs.throw_horizon(horizon(n, relief), {"F1": fault}, {"F1": given})
        cut = sheet.cuts["F1"]
        s = along(cut.stations, half=half)
        inner = np.isfinite(cut.throw) & (np.abs(s - half) < 0.7 * half)
        asked = np.full(len(s), 50.0)
        if kind != "listric":
            ellipse = gs.EllipticThrow(sign * 50.0, half, centre=(half, None))
            asked = ellipse.at(s, np.zeros(len(s)))
        error = np.abs(cut.throw - asked)[inner]
        assert error.max() < curvature * (1000.0 / (n - 1)) ** 2 / 8
        assert sheet.report.tips == sheet.report.declared_tips
        assert not sheet.report.shortened


@pytest.mark.parametrize("share", [1.0, 0.4, 0.0])
def test_movement_dies_away_within_reach_on_both_walls(share):
    top, faults = horizon(61), {"F1": wall(90.0)}
    sheet = gs.throw_horizon(top, faults, {"F1": 40.0}, reach=200.0, hanging_wall=share)
    x, y = np.meshgrid(top.easting.values, top.northing.values)
    away = (x - 500.0) * np.sin(np.radians(100)) + (y - 500.0) * np.cos(np.radians(100))
    down = top.values - sheet.lattice.elevation
    left = np.clip(1.0 - abs(away) / 200.0, 0.0, None) ** 2
    expected = 40.0 * np.where(away > 0, share, share - 1.0) * left
    off = abs(away) > 1e-9  # one node is on the fault
    assert down[off] == pytest.approx(expected[off], abs=1e-9)
    assert sheet.cuts["F1"].throw == pytest.approx(40.0, abs=0.5)  # linear between nodes


def test_rock_above_and_below_a_fault_moves_as_beside_it():
    """A steep plane that leaves the heights of its fault is a plane still, moved as one."""
    top = horizon(height=lambda x, y: -1800.0 + 0.8 * (x - 500.0))
    sheet = gs.throw_horizon(top, {"F1": wall(60.0, 90.0)}, {"F1": 30.0})
    heave = 30.0 / np.tan(np.radians(60.0))
    east = top.easting.values > 600.0
    assert top.values.max() > -1410.0  # the fault ends at -1500 m
    expected = top.values - 30.0 - 0.8 * heave
    assert sheet.lattice.elevation[:, east] == pytest.approx(expected[:, east], abs=1e-6)


@pytest.mark.parametrize("turned", [False, True])
def test_beds_are_read_on_their_triangles(turned):
    """Rock comes from half a cell away each way: from the middle of the diagonal of its cell.

    Diagonals run north-east, also where rows of the grid do not run east.
    """
    axis, throw = np.linspace(0.0, 1000.0, 21), 25.0 * 2**0.5
    z = np.random.default_rng(7).uniform(-1800.0, -1797.0, (21, 21))
    x, y = np.meshgrid(axis, axis)
    if turned:
        x, y, z = (np.ascontiguousarray(part.T[::-1]) for part in (x, y, z))
    top = gs.TriSurface("Top", "horizon", lattice=gs.Lattice(x, y, z, not turned))
    moved = gs.throw_horizon(top, {"F1": wall(45.0, 45.0)}, {"F1": throw}).lattice.elevation
    if turned:
        z, moved = z[::-1].T, moved[::-1].T
    far = np.add.outer(axis[1:], axis[1:]) > 1200.0
    expected = 0.5 * (z[:-1, :-1] + z[1:, 1:]) - throw
    assert moved[1:, 1:][far] == pytest.approx(expected[far], abs=1e-9)


def test_a_hole_moves_with_its_block():
    top = horizon()
    top[10:13, 30:33] = np.nan
    sheet = gs.throw_horizon(top, {"F1": wall(90.0)}, {"F1": 40.0})
    assert (np.isnan(sheet.lattice.elevation) == np.isnan(top.values)).all()
    moved = gs.throw_horizon(top, {"F1": wall(45.0)}, {"F1": 50.0}).lattice.elevation
    assert np.isnan(moved).sum() > 4
    assert np.isfinite(moved[11, 30])  # the hole has gone east by two columns
    assert np.isnan(moved[11, 33])


# ------------------------------------------------------------- what is refused
def short(**more):
    return wall(half=250.0, **more)


def test_throw_that_ends_inside_or_changes_too_quickly_is_refused():
    for fault, throw, options, words in (
        (short(), 30.0, {}, r"'F1' ends inside horizon 'Top' at \(E .* still 30 m. Let throw die"),
        (wall(), 60.0, {"reach": 50.0}, r"throw changes so quickly at \(E .* fold"),
    ):
        with pytest.raises(GeometryError, match=words):
            gs.throw_horizon(horizon(), {"F1": fault}, {"F1": throw}, **options)


def test_faults_that_cannot_guide_a_wall():
    flat = gs.TriSurface(
        "F1", "fault", [[0, 0, -1800], [1000, 0, -1800], [0, 1000, -1800]], [[0, 1, 2]]
    )
    with pytest.raises(GeometryError, match="'F1' is horizontal on average, so it has no strike"):
        gs.throw_horizon(horizon(), [flat], {"F1": 10.0})
    x = np.array([[300.0, 500.0, 500.0, 300.0]]) + np.array([[0.0], [100.0]])
    y = np.array([[0.0, 300.0, 600.0, 1200.0]]) + np.zeros((2, 1))
    y[:, 2] = 250.0
    back = make_fault("F1", x, y, np.array([[-1600.0], [-2000.0]]), (0.0, 0.0, 0.0))
    words = r"'F1' turns back against its mean dip direction at \("
    refused(GeometryError, words, lambda: gs.throw_horizon(horizon(), {"F1": back}, {"F1": 10.0}))


def test_a_fault_that_misses_the_horizon_does_nothing():
    top = horizon(height=lambda x, y: plane(x, y) + 500.0)
    sheet = gs.throw_horizon(top, {"F1": wall()}, {"F1": 30.0})
    assert (sheet.lattice.elevation == top.values).all()
    assert sheet.report.notes == ["Fault 'F1' does not meet the horizon."]


def test_a_horizon_that_is_torn_already_is_refused():
    world = gs.synthetic.torn("reverse", 41)
    with pytest.raises(
        HorizonError, match="several values at one node, so that it is torn already"
    ):
        gs.throw_horizon(
            world.truth["points"], world.faults, {"F1": -30.0}, name="Top", positive="up"
        )


# ---- Throw does not depend on where a fault lies on the grid: on nodes of it, beside them, as
CELL, LEVEL = 32.0, -1152.0
MIDDLE = np.array([20 * CELL, 20 * CELL])
HALF = 12 * CELL
PEAK = 40.0


def flat(n=41):
    axis = CELL * np.arange(n)
    return gridded(np.full((n, n), LEVEL), axis)


def wall_throw_on_nodes(at, azimuth=90.0, dip=60.0, half=HALF, name="F1"):
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


@pytest.mark.parametrize(
    ("azimuth", "share"), [(0.0, 1.0), (90.0, 0.5), (180.0, 0.5), (270.0, 1.0)]
)
def test_beside_and_on_lines_of_nodes(azimuth, share):
    for off in OFF:
        at = MIDDLE + off
        fault, strike = wall_throw_on_nodes(at, azimuth)
        throw = dying()
        sheet = gs.throw_horizon(flat(), {"F1": fault}, {"F1": throw}, hanging_wall=share)
        assert_found(sheet.cuts["F1"], strike, at, throw)
        assert sum(sheet.report.shortened.values()) == 0


@pytest.mark.parametrize(("dip", "peak"), [(60.0, -PEAK), (90.0, PEAK), (30.0, PEAK)])
def test_reverse_vertical_and_gentle_faults(dip, peak):
    # both azimuths on and next to nodes
    for off, azimuth in zip(OFF[::2], (90.0, 180.0) * 2, strict=True):
        at = MIDDLE + off
        fault, strike = wall_throw_on_nodes(at, azimuth, dip)
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
        fault, strike = wall_throw_on_nodes(at, azimuth, half=half)
        throw = dying(half=half)
        sheet = gs.throw_horizon(flat(), {"F1": fault}, {"F1": throw})
        assert_found(sheet.cuts["F1"], strike, at, throw, half)


@pytest.mark.parametrize("n", [3, 5])
def test_faults_of_a_few_cells_tear_what_they_can(n):
    for off in OFF:
        fault, _ = wall_throw_on_nodes(MIDDLE + off, half=n * CELL)
        for throw in (dying(half=n * CELL), gs.EllipticThrow(PEAK)):
            sheet = gs.throw_horizon(flat(), {"F1": fault}, {"F1": throw})
            assert 0.4 * PEAK < np.nanmax(sheet.cuts["F1"].throw) < 1.001 * PEAK
