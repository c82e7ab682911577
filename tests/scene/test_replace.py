"""Scene.replace: what it adds, removes and refuses."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from geosurf import Scene
from geosurf.errors import InputError
from tests.scene.small import level
from tests.strategies import BOX


def test_a_removed_fault_takes_its_rules_along(scene):
    """Of its own; that another fault is to end at it cannot be forgotten in silence."""
    ruled = scene.replace(extend={"F1": "up"}, truncations={"F2": ("F1", "+")})
    assert ruled.replace(faults={"F2": None}).extend == {"F1": ("up",)}
    assert ruled.replace(faults={"F2": None}).truncations == {}
    with pytest.raises(InputError, match="truncations name 'F1', which is not a fault"):
        ruled.replace(faults={"F1": None})


def test_replace_refuses_what_it_cannot_do(scene):
    with pytest.raises(InputError, match=r"faults has no 'F11' to remove; .* mean 'F1'\?"):
        scene.replace(faults={"F11": None})
    with pytest.raises(InputError, match=r"`horizons` must be a mapping such as .*, not list"):
        scene.replace(horizons=[level(3)])


def test_replace_adds_and_removes(scene):
    assert scene.replace(faults={"F2": None}).fault_names == ("F1",)
    assert scene.replace(horizons={"Deep": level(-1)}).horizon_names == ("Top", "Base", "Deep")
    smaller = scene.replace(box=(0, 2, 0, 4, -4, 8))
    assert smaller.units.box_volume == 96.0
    assert scene.units.box_volume == 192.0
    with pytest.raises(InputError, match=r"a scene has no input 'fault'.*Did you mean 'faults'\?"):
        scene.replace(fault={})


def test_an_array_changed_in_place_counts_where_it_is_given_again():
    """What a change does not name is taken as the first scene read it; files are read again."""
    x = np.array([-1.0, 5.0])
    top, base = (
        xr.DataArray(np.full((2, 2), z), {"northing": x, "easting": x}, ("northing", "easting"))
        for z in (2.0, 0.0)
    )
    scene = Scene({"Top": top, "Base": base}, {}, BOX, positive="up", length_unit="m")
    before = scene.volumes
    top += 1.0
    assert scene.replace(contacts={"OWC": 1.0}).surface("Top").bounds[4:] == (2.0, 2.0)
    after = scene.replace(horizons={"Top": top})
    assert after.surface("Top").bounds[4:] == (3.0, 3.0)
    np.testing.assert_allclose(after.volumes - before, [-16.0, 16.0, 0.0], atol=1e-12)
