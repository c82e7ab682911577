"""A scene computes what is asked for, once; `replace`; words of the field."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf import Scene
from geosurf.errors import InputError
from tests.messages import refused
from tests.scene.conftest import level, ran, upright
from tests.strategies import BOX


def test_one_cutoff_runs_one_pair_and_reads_two_surfaces(scene):
    (line,) = scene.cutoffs("Top", "F1")
    assert line.shape[1] == 3
    assert set(line[:, 0]) == {1.0}
    assert ran(scene, "triangulate") == ["Top", "F1"]
    assert ran(scene, "curves") == ["Top x F1"]
    assert len(scene.steps) == 3


def test_files_that_are_not_asked_for_are_not_read(tmp_path):
    missing = tmp_path / "missing.ts"
    scene = Scene({"Top": level(3), "Base": missing}, {"F1": upright(1)}, BOX)
    assert len(scene.cutoffs("Top", "F1")) == 1
    refused(InputError, r"missing\.ts", scene.surface, "Base")


def test_the_second_time_comes_from_memory(scene):
    assert scene.curves_between("Top", "F1") is scene.curves_between("Top", "F1")
    assert [s.outcome for s in scene.steps if s.stage == "curves"] == ["ran", "from memory"]
    assert scene.curves is scene.curves
    assert scene.units is scene.units
    assert ran(scene, "rebuild") == ["4 surfaces and the box"]
    assert ran(scene, "carve") == ["the box"]


def test_all_curves_are_one_search(scene):
    """Of all pairs; those of two surfaces by themselves are a search of their own."""
    curves = scene.curves
    assert ran(scene, "curves") == ["4 surfaces"]
    other = scene.replace(faults={"F1": upright(2)})
    assert other.steps == ()
    after = other.curves
    assert ran(other, "triangulate") == ["F1"]
    assert {*after.between("Top", "F1")[0][:, 0]} == {2.0}
    np.testing.assert_array_equal(after.between("Base", "F2")[0], curves.between("Base", "F2")[0])
    # the first scene is what it was, and is found again
    assert scene.curves is curves
    again = other.replace(faults={"F1": upright(1)})
    assert again.curves.local.tobytes() == curves.local.tobytes()
    assert ran(again, "curves", "from memory") == ["4 surfaces"]


# ---- Scene.replace: what it adds, removes and refuses.
def test_a_removed_fault_takes_its_rules_along(scene):
    """Of its own; that another fault is to end at it cannot be forgotten in silence."""
    ruled = scene.replace(extend={"F1": "up"}, truncations={"F2": ("F1", "+")})
    assert ruled.replace(faults={"F2": None}).extend == {"F1": ("up",)}
    assert ruled.replace(faults={"F2": None}).truncations == {}
    with pytest.raises(InputError, match="truncations name 'F1', which is not a fault"):
        ruled.replace(faults={"F1": None})


def test_replace_adds_and_removes(scene):
    assert scene.replace(faults={"F2": None}).fault_names == ("F1",)
    assert scene.replace(horizons={"Deep": level(-1)}).horizon_names == ("Top", "Base", "Deep")
    assert scene.replace(box=(0, 2, 0, 4, -4, 8)).units.box_volume == 96.0
    assert scene.units.box_volume == 192.0
    with pytest.raises(InputError, match=r"a scene has no input 'fault'.*Did you mean 'faults'\?"):
        scene.replace(fault={})


# ---- Curves, units and certificate of a scene.
# ---- Words of the field, and depths in place of elevations, lead to what was meant.
@pytest.mark.parametrize(
    ("word", "rule"),
    [("unconformity", "erosional"), ("Erosion", "erosional"), ("onlap", "base"), ("bse", "base")],
)
def test_field_words_lead_to_the_rule(planes, word, rule):
    refused(InputError, f"Did you mean '{rule}'", planes.replace, column={"Base": word})


@pytest.mark.parametrize(("door", "depth"), [("sample", 2100), ("well_intervals", 2400)])
def test_depths_in_place_of_elevations_are_warned_of(planes, door, depth):
    says = f"All points lie above the model.* write a depth of {depth} m as -{depth}"
    before = planes.warnings
    with pytest.warns(gs.GeosurfWarning, match=says) as caught:
        getattr(planes.replace(), door)([[1000.0, 1500.0, 0.0], [1000.0, 1500.0, depth]])
    assert caught[0].filename == __file__
    assert planes.warnings == before  # a scene that other tests draw, too
