"""Scene.replace: what it adds, removes and refuses."""

from __future__ import annotations

import pytest

from geosurf.errors import InputError
from tests.scene.small import level


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
    smaller = scene.replace(box=(0, 2, 0, 4, -4, 8))
    assert smaller.units.box_volume == 96.0
    assert scene.units.box_volume == 192.0
    with pytest.raises(InputError, match=r"a scene has no input 'fault'.*Did you mean 'faults'\?"):
        scene.replace(fault={})
