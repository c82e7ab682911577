"""Two faults that cross: the younger one is whole, the older one becomes two faults at it."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError, InputError, ScenarioError
from geosurf.scenario import build_scene, read_scenario
from tests.faults.worlds import BOX, across, antithetic, dipping, upright, volumes
from tests.grids import gridded
from tests.planes import INPUTS, write_grids

X = {"F1": dipping(), "F2": across(4, "F2")}


def scene(truncations, faults=X, **more):
    return gs.Scene({}, faults, BOX, truncations=truncations, **more)


@pytest.mark.parametrize("older", [across(4, "F2"), across(3, "F2"), antithetic()])
def test_halves_cut_the_same_blocks_as_two_faults_that_cross(older):
    faults = {"F1": dipping(), "F2": older}
    crossed, split = scene({}, faults), scene({"F2": ("F1", "both")}, faults)
    assert split.fault_names == ("F1", "F2 (1)", "F2 (2)")
    assert (volumes(split.units) == volumes(crossed.units)).all()
    assert split.check().ok

    # the halves add up to the fault, one on each side; the younger fault is whole
    assert sum(cut.kept_area for cut in split.fault_actions) == pytest.approx(
        split.fault_actions[0].kept_area + split.fault_actions[0].dropped_area, rel=1e-15
    )
    for name, sign in (("F2 (1)", 1), ("F2 (2)", -1)):
        x = split.surface(name).vertices
        assert (sign * (x[:, 0] + x[:, 2] - 8)).min() == 0
    assert split.surface("F1").bounds == dipping().bounds

    # blocks on one side of F1 lie on one half only
    for unit in split.units.values():
        half = "F2 (1)" if "F1+" in unit.block else "F2 (2)"
        other = "F2 (2)" if half == "F2 (1)" else "F2 (1)"
        assert half in unit.block
        assert other not in unit.block


def test_what_is_stated_for_the_fault_holds_for_its_halves():
    short = gs.TriSurface("F2", "fault", X["F2"].vertices * (1, 1, 0.8), X["F2"].triangles)
    faults = {"F1": dipping(), "F2": short}
    made = scene({"F2": ("F1", "both")}, faults, extend={"F2": "up"}, tear={"F2": 2})
    assert made.extend == {"F2 (1)": ("up",), "F2 (2)": ("up",)}
    assert made.check().ok
    again = made.replace(faults={"F2": across(3, "F2")})
    assert again.surface("F2 (2)").bounds[2:4] == (3, 3)
    assert made.replace(faults={"F2": None}).fault_names == ("F1",)
    crossed = made.replace(truncations=None)
    assert crossed.fault_names == ("F1", "F2")
    assert crossed.extend == {"F2": ("up",)}
    one = scene({"F2": ("F1", "both")}, faults, extend={"F2": "up", "F2 (2)": "down"})
    assert one.extend == {"F2 (1)": ("up",), "F2 (2)": ("down",)}


def test_a_half_has_rules_of_its_own():
    faults = {**X, "F3": upright(6, "F3")}
    rules = {"F2": ("F1", "both"), "F2 (1)": ("F3", "right"), "F3": ("F1", "hanging wall")}
    made = scene(rules, faults)
    assert made.check().ok
    assert made.surface("F2 (1)").bounds[0] == 6
    twice = scene({"F2": (("F1", "both"), ("F3", "both"))}, {**X, "F3": across(4, "F3")})
    assert len(twice.fault_names) == 6
    with pytest.raises(GeometryError):
        _ = twice.units  # F3 lies in F2


@pytest.mark.parametrize(
    ("rules", "more", "words"),
    [
        ({"F2": ("F1", "both"), "F3": ("F2", "+")}, {"F3": upright(6, "F3")},
         r"F3 ends at 'F2', which is split into 'F2 \(1\)' and 'F2 \(2\)'. Name the half"),
        ({"F2": ("F1", "both")}, {"F2 (1)": upright(6)},
         r"half would be called 'F2 \(1\)'.*Rename"),
        ({"F2": ("F9", "both")}, {}, r"'F9', which is not a fault"),
        ({"F2": ("F1", "both")}, {"F2": gs.TriSurface(
            "F2", "fault", upright(6).vertices * (1, 1, 0.5) + (0, 0, 4), upright(6).triangles)},
         r"'F2 \(1\)' ends .* short of 'F1'"),
    ],
)  # fmt: skip
def test_what_cannot_be_split_is_one_plain_sentence(rules, more, words):
    with pytest.raises((InputError, GeometryError), match=words):
        _ = scene(rules, {**X, **more}).patches


def test_a_scenario_splits_a_fault(tmp_path):
    write_grids(tmp_path)
    gs.write(gs.TriSurface("F2", "fault", np.array(
        [(-99, 1500, -2600), (4099, 1500, -2600), (4099, 1500, -1600), (-99, 1500, -1600)]
    ), [[0, 1, 2], [0, 2, 3]]), tmp_path / "F2.ts")  # fmt: skip
    rule = '[[truncations]]\nfault = "F2"\nmain = "F1"\nkeep = "both"\n'
    older = '[[faults]]\nname = "F2"\nfile = "F2.ts"\n'
    path = tmp_path / "scenario.toml"
    path.write_text(INPUTS + older + rule)
    made = build_scene(read_scenario(path))
    assert made.fault_names == ("F1", "F2 (1)", "F2 (2)")
    assert made.check().ok
    throw = '[[throws]]\nfault = "F2"\nthrow_m = 20\nhorizons = ["Base"]\n'
    tear = '[tear]\nhorizons = ["Top"]\ntrim_cells = { F2 = 2 }\n'
    path.write_text(INPUTS + older + rule + throw + tear)
    read = read_scenario(path)
    assert [entry.fault for entry in read.throws] == ["F2 (1)", "F2 (2)"]
    assert read.tear is not None
    assert read.tear.trim_cells == {"F2 (1)": 2, "F2 (2)": 2}
    path.write_text(INPUTS + older + older.replace('"F2"', '"F2 (1)"') + rule)
    with pytest.raises(ScenarioError, match=r"half would be called 'F2 \(1\)'"):
        read_scenario(path)


@pytest.mark.parametrize("picked_apart", [False, True])
@pytest.mark.parametrize("turn", [0.0, -35.0, 35.0])
def test_halves_offset_each_its_own_side(turn: float, picked_apart: bool) -> None:
    """The older throw, then the younger one: four level blocks, whatever angle and names."""

    def plane(name: str, strike: float, dip: float) -> gs.TriSurface:
        along = np.array([np.sin(np.radians(strike)), np.cos(np.radians(strike))])
        down = np.array([along[1], -along[0]]) * 1000.0 / np.tan(np.radians(dip))
        ends = np.array([[1000.0, 1000.0] - 1800 * along, [1000.0, 1000.0] + 1800 * along])
        x = [[*ends[0], -500], [*ends[1], -500], [*(ends[1] + down), -1500]]
        return gs.TriSurface(
            name, "fault", [*x, [*(ends[0] + down), -1500]], [[0, 1, 2], [0, 2, 3]]
        )

    x = np.arange(0.0, 2001.0, 50.0)
    grid = gridded(np.full((41, 41), -1000.0), x)
    given = {"F1": plane("F1", 0.0, 70.0), "F2": plane("F2", 90.0 + turn, 75.0)}
    box = (0.0, 2000.0, 0.0, 2000.0, -1400.0, -600.0)
    rules = {"F2": ("F1", "both")}
    if picked_apart:
        rules = {"east": ("F1", "hanging wall"), "west": ("F1", "footwall")}
        given |= {name: given["F2"].renamed(name, "fault") for name in rules}
        del given["F2"]
    scene = gs.Scene({}, given, box, truncations=rules)
    faults = [scene.whole_surface(name) for name in scene.fault_names]
    throws = {name: 40.0 if name == "F1" else 25.0 for name in scene.fault_names}
    sheet = gs.throw_horizon(grid, faults, throws, name="Top")
    levels = np.unique(sheet.surface.vertices[:, 2].round(6))
    np.testing.assert_allclose(levels, [-1065.0, -1040.0, -1025.0, -1000.0])
