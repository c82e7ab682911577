"""A fault given twice is warned of, whatever the order of its triangles; others are not."""

import numpy as np
import pytest

import geosurf as gs
from tests.scene.small import level, upright
from tests.strategies import BOX


def scene_with(second):
    one = upright(2.0, "F1")
    return gs.Scene({"Top": level(0.5)}, {"F1": one, "F2": second(one)}, BOX)


def again(fault, shift=0.0):
    order = np.random.default_rng(1).permutation(fault.n_triangle)
    x = fault.vertices[::-1] + np.array([shift, 0, 0])
    faces = (len(x) - 1 - fault.triangles)[order][:, [1, 2, 0]]
    return gs.TriSurface("F2", "fault", x, faces)


def test_the_same_triangles_in_another_order_are_warned_of():
    scene = scene_with(again)
    with pytest.warns(gs.GeosurfWarning, match="'F1' and 'F2' have the same triangles"):
        len(scene.units)
    assert [one.kind for one in scene.warnings] == ["same fault"]


def test_a_fault_a_little_beside_is_another():
    scene = scene_with(lambda one: again(one, np.spacing(2.0)))
    assert not [one for one in scene.warnings if one.kind == "same fault"]
