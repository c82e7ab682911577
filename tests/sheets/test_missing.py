"""Horizons without data in a block: refused by name, carried on, or pinched out onto another."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError, InputError, ScenarioError
from geosurf.scenario import build_scene, read_scenario
from tests import laws
from tests.grids import gridded
from tests.messages import refused
from tests.planes import scenario_tables

CELL = 50.0
X, Y = np.arange(-200.0, 4201.0, CELL), np.arange(-200.0, 1801.0, CELL)
BOX = (0, 4000, 0, 1600, -2000, -1400)


def wall(name, east, lean=-0.5):
    """A fault that is at an easting where elevation is -1700 m."""
    corners = [
        (east + (z + 1700.0) * lean, y, z)
        for y, z in ((-900, -2300), (2900, -2300), (2900, -1200), (-900, -1200))
    ]
    return gs.TriSurface(name, "fault", np.array(corners, float), [[0, 1, 2], [0, 2, 3]])


def level_where(there):
    """A level grid with data at some eastings only."""
    return gridded(np.where(there, -1700.0, np.nan) + 0.0 * Y[:, None], X, Y)


@pytest.mark.parametrize(("lean", "west"), [(-0.5, True), (0.0, False), (0.5, True), (0.5, False)])
@pytest.mark.parametrize("short", [50.0, 500.0])
def test_data_that_end_before_a_fault_are_refused_or_carried_on(short, lean, west):
    """Both gave a sheet that ended there, and a model that leaked."""
    fault = wall("F1", 2003.0, lean)
    grid = level_where(2003.0 - short > X if west else 2003.0 + short < X)
    side = r"'F1\+'" if west == (lean <= 0) else "'F1-'"
    if lean == 0.0:
        side = "'F1[+-]'"
    words = rf"'H' has no data in the block {side}: .*fill_empty_blocks=True"
    refused(GeometryError, words, gs.tear_horizon, grid, {"F1": fault}, name="H", trim=1.5)
    sheet = gs.tear_horizon(grid, {"F1": fault}, name="H", trim=1.5, fill_empty_blocks=True)
    assert sheet.report.filled_blocks[0]["over"] == "F1"
    if short < 100.0:
        assert len(gs.Scene({"H": sheet}, {"F1": fault}, BOX).units) == 4


def test_a_block_between_two_faults():
    faults = {"F1": wall("F1", 1203.0), "F2": wall("F2", 2803.0)}
    for there in ((X < 1150) | (X > 2850), X < 1150):
        with pytest.raises(GeometryError, match=r"'H' has no data in the block .*'F1\+'"):
            gs.tear_horizon(level_where(there), faults, name="H", trim=1.5)
        sheet = gs.tear_horizon(
            level_where(there), faults, name="H", trim=1.5, fill_empty_blocks=True
        )
        if there[-1]:
            assert len(gs.Scene({"H": sheet}, faults, BOX).units) == 6


def test_a_fault_beyond_the_lattice_or_far_from_the_data_is_noted_only():
    for grid, east in ((level_where(X < 9e9), 4300.0), (level_where(X < 1000.0), 3003.0)):
        sheet = gs.tear_horizon(grid, {"F1": wall("F1", east, 0.0)}, name="H", trim=1.5)
        assert "Fault 'F1' does not meet the horizon." in str(sheet.report)


# ---- Horizons without data in a block, pinched out onto the horizon above or below.
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
# nothing changes along the faults: a short field will do
Y_PINCH_OUT = np.arange(-200.0, 801.0, CELL)
BOX_PINCH_OUT = (0, 4000, 0, 600, -2000, -1400)
DEEP = (*BOX_PINCH_OUT[:4], -2100, -1400)


def stepped(level, there=None, lean=-0.5, throw=30.0):
    """A horizon that F1 moves down to the east by a throw, and nothing where it is missing."""
    at = 2003.0 + (level + 1700.0) * lean
    z = np.where(at > X, level, level - throw) + 0.01 * Y_PINCH_OUT[:, None]
    return gridded(z if there is None else np.where(there, z, np.nan), X, Y_PINCH_OUT)


def world(there, lean=-0.5):
    throw = 30.0 if lean <= 0 else -30.0
    levels = {"Top": -1600.0, "Mid": -1700.0, "Base": -1800.0}
    return {
        name: stepped(level, there if name == "Mid" else None, lean, throw)
        for name, level in levels.items()
    }


@pytest.mark.parametrize(
    ("onto", "west", "lean"), [("lower", True, -0.5), ("upper", False, 0.5), ("upper", True, 0.0)]
)
def test_the_zone_between_is_absent_and_the_other_takes_its_space(onto, west, lean):
    there = X < 1950 if west else X > 2053
    faults = {"F1": wall("F1", 2003.0, lean)}
    scene = gs.Scene(world(there, lean), faults, DEEP, tear=True, fill_empty_blocks={"Mid": onto})
    assert scene.check().ok
    gone, whole = ("Mid/Base", "Top/Mid") if onto == "lower" else ("Top/Mid", "Mid/Base")
    assert [unit.block for unit in scene.units.values() if unit.zone == gone] == ["whole"]
    assert sum(unit.zone == whole for unit in scene.units.values()) == 2
    assert scene.units.slivers == ()  # the two horizons coincide exactly

    # all other zones, and the sum of both, are those of a model without this horizon
    without = gs.Scene({k: v for k, v in world(there, lean).items() if k != "Mid"}, faults, DEEP,
                       tear=True)  # fmt: skip
    one, two = (laws.volume_by_zone(each.units) for each in (scene, without))
    assert one["above Top"] == pytest.approx(two["above Top"], rel=1e-12)
    assert one["Top/Mid"] + one["Mid/Base"] == pytest.approx(two["Top/Base"], rel=1e-12)

    # triangles of Mid there are those of the other one, and are listed as such
    (warning,) = [one for one in scene.warnings if one.kind == "pinched out"]
    assert warning.subject == "Mid"
    other = "Base" if onto == "lower" else "Top"
    assert f"coincides with {other!r} there" in warning.effect
    mark = scene.sheets["Mid"].extrapolated
    assert 0.45 < mark.mean() < 0.56
    nodes = scene.sheets["Mid"].lattice.elevation[mark]
    np.testing.assert_array_equal(nodes, scene.sheets[other].lattice.elevation[mark])


def test_blocks_between_and_beyond_two_faults():
    faults = {"F1": wall("F1", 1203.0, 0.0), "F2": wall("F2", 2803.0, 0.0)}
    for there in ((X < 1150) | (X > 2850), X < 1150, (X > 1203) & (X < 2803)):
        grids = world(there, 0.0)
        scene = gs.Scene(grids, faults, DEEP, tear=1.5, fill_empty_blocks="lower")
        assert scene.check().ok
        n = 1 + int((there[24] and there[-1]) or 0)
        assert sum(unit.zone == "Mid/Base" for unit in scene.units.values()) == n


def test_a_chain_of_horizons_and_the_default_area():
    """Mid and Base are both missing in the east: both lie on Deep there."""
    grids = {**world(X < 1950), "Deep": stepped(-1900.0)}
    grids["Base"] = grids["Base"].where(X < 1950)
    faults = {"F1": wall("F1", 2003.0)}
    scene = gs.Scene(grids, faults, tear=True, fill_empty_blocks="lower")
    assert scene.box[:2] == (-200.0, 4200.0)  # the blocks without data are in the area
    blocks = {}
    for unit in scene.units.values():
        blocks.setdefault(unit.zone, []).append(unit.block)
    assert blocks["Top/Mid"] == ["F1+", "F1-"]
    assert blocks["Mid/Base"] == blocks["Base/Deep"] == ["whole"]
    assert scene.check().ok
    assert not any(one.kind in ("area", "extrapolated") for one in scene.warnings)


def test_refusal_is_the_default_and_every_refusal_names_a_remedy():
    faults = {"F1": wall("F1", 2003.0)}
    grids = world(X < 1950)
    with pytest.raises(GeometryError, match=r"'Mid' has no data in the block 'F1\+'"):
        gs.Scene(grids, faults, DEEP, tear=True).units  # noqa: B018
    sheet = gs.tear_horizon(grids["Base"].isel(easting=slice(0, 64)), faults, name="Base")
    with pytest.raises(InputError, match=r"'Mid' cannot be pinched out onto 'Base', since the two"):
        gs.tear_horizon(grids["Mid"], faults, name="Mid", fill_empty_blocks=sheet)

    # a fault that ends inside does not close the block off
    short = wall("F1", 2003.0)
    corners = short.vertices.copy()
    corners[corners[:, 1] > 0, 1] = 400.0  # in the middle of the field
    half = {"F1": gs.TriSurface("F1", "fault", corners, short.triangles)}
    base = gs.tear_horizon(grids["Base"], half, name="Base")
    with pytest.raises(GeometryError, match=r"no faults close the part without data off"):
        gs.tear_horizon(grids["Mid"], half, name="Mid", fill_empty_blocks=base)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ({"Mod": "lower"}, r"names 'Mod', which is not a horizon. .* Did you mean 'Mid'"),
        ({"Base": "lower"}, r"no horizon lies below 'Base', .* Give 'upper'"),
        ({"Top": "upper"}, r"no horizon lies above 'Top', .* Give 'lower'"),
        ({"Top": "lower", "Mid": "upper"}, r"would pinch out 'Top' and 'Mid' onto each other"),
    ],
)
def test_wrong_settings_are_refused(value, words, tmp_path):
    faults = {"F1": wall("F1", 2003.0)}
    with pytest.raises(InputError, match=words):
        gs.Scene(world(X < 1950), faults, DEEP, tear=True, fill_empty_blocks=value)
    with pytest.raises(InputError, match=r"applies to horizons that are torn. Give tear=True"):
        gs.Scene(world(X < 1950), faults, DEEP, fill_empty_blocks="lower")


def test_a_scenario_pinches_out(tmp_path):
    text = scenario_tables(tmp_path, world(X < 1950), {"F1": wall("F1", 2003.0)})
    text += "[tear]\nfill_empty_blocks = {}\n"
    path = tmp_path / "scenario.toml"
    path.write_text(text.format('{Mid = "lower"}'))
    scene = build_scene(read_scenario(path))
    assert [unit.block for unit in scene.units.values() if unit.zone == "Mid/Base"] == ["whole"]
    assert scene.box[:2] == (-200.0, 4200.0)
    assert scene.check().ok
    for value, words in (('"down"', "it must be true, false"), ('{Mud = "lower"}', "names 'Mud'")):
        path.write_text(text.format(value))
        refused(ScenarioError, words, read_scenario, path)
