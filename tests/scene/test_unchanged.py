"""A scene never changes: what is set is refused by name, and copies and pickles still work."""

from __future__ import annotations

import copy
import gc
import pickle
import weakref

import pytest

import geosurf as gs
from geosurf.errors import InputError
from geosurf.scene.inputs import INPUTS


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.graben(n=9)
    return gs.Scene(world.horizons, world.faults, world.box)


@pytest.mark.parametrize("name", INPUTS)
def test_inputs_cannot_be_set(scene, name):
    with pytest.raises(InputError, match=rf"scene\.{name} cannot be set.*scene\.replace\({name}="):
        setattr(scene, name, None)
    with pytest.raises(InputError, match="cannot be changed"):
        delattr(scene, name)


def test_what_is_shown_cannot_be_changed_in_place(scene):
    with pytest.raises(TypeError):
        scene.extend["F1"] = ("up",)
    with pytest.raises(TypeError):
        scene.truncations["F1"] = ("F2", "+")
    scene.column["Top"] = "erosional"
    assert scene.column["Top"] == "conformable"


def test_replace_is_the_way(scene):
    other = scene.replace(box=(0, 5000, 0, 2000, -2600, -1800))
    assert other.box != scene.box
    assert float(other.volumes.sum()) == pytest.approx(8e9)
    assert float(scene.volumes.sum()) == pytest.approx(1.6e10)


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))]
)
def test_copies_are_scenes_of_their_own(scene, again):
    ruled = scene.replace(extend={"F1": "up"})
    other = again(ruled)
    assert dict(other.extend) == {"F1": ("up",)}
    assert other.surface("F1").n_triangle == ruled.surface("F1").n_triangle
    del ruled
    gc.collect()
    assert len(other.units) == 12
    with pytest.raises(InputError, match="cannot be set"):
        other.box = None


def test_a_scene_ends_with_its_last_name():
    """Without waiting for the garbage collector: what it holds may be large."""
    world = gs.synthetic.graben(n=9)
    scene = gs.Scene(world.horizons, world.faults, world.box, extend=["F1"])
    _ = (
        scene.units,
        scene.curves,
        scene.warnings,
        scene.fault_actions,
        scene.thickness("Top/Middle"),
    )
    _ = scene.throw("Top", "F1"), scene.propose_fault_network()
    gone = weakref.ref(scene)
    gc.disable()
    try:
        del scene
        assert gone() is None
    finally:
        gc.enable()
