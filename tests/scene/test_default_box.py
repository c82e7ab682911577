"""The default box, and boxes that do not fit."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import (
    Lattice,
    Scene,
    TriSurface,
    synthetic,
)
from geosurf.errors import GeometryError, GeosurfWarning, InputError
from tests import laws
from tests.scene.small import level


def test_the_default_box_is_where_all_horizons_are():
    world = synthetic.tilted_planes(n=5)
    top, base = world.horizons["Top"], world.horizons["Base"].isel(easting=slice(1, None))
    scene = Scene({"Top": top, "Base": base}, world.faults)
    west, east, south, north, bottom, high = scene.box
    assert (west, east, south, north) == (1000.0, 4000.0, 0.0, 3000.0)
    assert bottom < float(base.min()) < float(top.max()) < high
    assert "default: where all horizons are" in scene.explain()
    laws.assert_volumes_add_up(scene.units, scene.box)
    assert {u.zone for u in scene.units.values()} == {"above Top", "Top/Base", "below Base"}


def test_a_hole_that_shrinks_the_default_box_is_reported():
    holed = np.full((21, 21), 3.0)
    holed[5:8, 9:12] = np.nan
    axis = np.arange(21.0)
    scene = Scene({"Top": TriSurface("Top", "horizon", lattice=Lattice(axis, axis, holed))})
    with pytest.warns(GeosurfWarning, match="default box covers 60 % of the area of all"):
        west, east, south, north, _, _ = scene.box
    share = (east - west) * (north - south) / 400
    (step,) = [s for s in scene.steps if s.stage == "box"]
    assert f"the largest rectangle that all horizons cover, {100 * share:.0f} %" in step.detail
    assert len(scene.units) == 2


@pytest.mark.parametrize(("box", "words"), [
    ((0, 4, 0, 4, -8, -2), r"Top' \(easting -1 to 5, .* elevation 3 to 3\) does not .* are depths"),
    ((0, 4, 0, 4, 5, 8), r"elevation 3 to 3\) does not reach .*0 to 4, 5 to 8\)\. Enlarge the box"),
    ((9, 12, 0, 4, 0, 8), r"model box \(9 to 12, 0 to 4, 0 to 8\)\. Enlarge the box"),
])  # fmt: skip
def test_a_box_apart_from_a_horizon_names_both_extents(box, words):
    with pytest.raises(GeometryError, match=words):
        Scene({"Top": level(3)}, box=box).units  # noqa: B018


def test_a_mesh_has_no_default_box():
    with pytest.raises(InputError, match=r"horizon 'Top' is a mesh.*Give box="):
        _ = Scene({"Top": level(3)}).box
