"""A scene computes what is asked for, once; results come from memory by what went into them."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Scene, intersect_surfaces
from geosurf.errors import InputError
from geosurf.synthetic.world import make_fault
from tests.scene.small import level, ran, upright
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
    with pytest.raises(InputError, match=r"missing\.ts"):
        scene.surface("Base")


def test_the_second_time_comes_from_memory(scene):
    first = scene.curves_between("Top", "F1")
    assert scene.curves_between("Top", "F1") is first
    assert [s.outcome for s in scene.steps if s.stage == "curves"] == ["ran", "from memory"]
    assert scene.curves is scene.curves
    assert scene.units is scene.units
    assert ran(scene, "rebuild") == ["4 surfaces and the box"]
    assert ran(scene, "carve") == ["the box"]


def test_faults_that_lean_side_by_side_are_not_searched_pair_by_pair():
    """All pairs are asked at once which are near; the curves are those of all pairs searched."""
    y, z = np.meshgrid(np.linspace(-1.0, 11.0, 21), np.linspace(-1.0, 6.0, 21))
    faults = {
        f"F{k}": make_fault(f"F{k}", 0.5 * (k + z) - 1.0, y, z, (0.0, 0.0, 0.0)) for k in range(6)
    }
    along, _ = np.meshgrid(np.linspace(-1.0, 6.0, 21), np.ones(21))
    faults["X"] = make_fault("X", along, 0.0 * z + 2.05, z, (0.0, 0.0, 0.0))  # across all others
    scene = Scene({"Top": level(3)}, faults, BOX)
    curves = scene.curves
    across = [f"F{k} x X" for k in range(6)]
    assert ran(scene, "curves") == [*(f"Top x {name}" for name in faults), *across]
    apart = [s for s in scene.steps if s.detail == "boxes of their parts do not meet"]
    assert len(apart) == len(ran(scene, "curves", "skipped")) == 15

    whole = intersect_surfaces([scene.surface(name) for name in ("Top", *faults)])
    assert (curves.points == whole.points).all()
    assert (curves.segments == whole.segments).all()
    assert (curves.surfaces_of_curve == whole.surfaces_of_curve).all()


def test_replace_recomputes_the_pairs_of_what_changed(scene):
    before = scene.curves
    other = scene.replace(faults={"F1": upright(2)})
    assert other.steps == ()
    after = other.curves
    assert ran(other, "triangulate") == ["F1"]
    assert sorted(ran(other, "curves")) == ["Base x F1", "F1 x F2", "Top x F1"]
    assert ran(other, "curves", "from memory") == ["Base x F2"]
    assert {*after.between("Top", "F1")[0][:, 0]} == {2.0}
    np.testing.assert_array_equal(after.between("Base", "F2")[0], before.between("Base", "F2")[0])
    # the first scene is what it was
    assert scene.curves is before
    assert {*scene.cutoffs("Top", "F1")[0][:, 0]} == {1.0}
