"""The default box, and boxes that do not fit."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Lattice, Scene, TriSurface, synthetic, tear_horizon
from geosurf.errors import GeometryError, GeosurfWarning, InputError
from tests import laws
from tests.scene.small import level


def test_the_default_box_is_where_all_horizons_are():
    world = synthetic.tilted_planes(n=5)
    top, base = world.horizons["Top"], world.horizons["Base"].isel(easting=slice(1, None))
    scene = Scene({"Top": top, "Base": base}, world.faults)
    with pytest.warns(GeosurfWarning, match="covers 75 % of horizon 'Top'"):
        west, east, south, north, bottom, high = scene.box
    assert (west, east, south, north) == (1000.0, 4000.0, 0.0, 3000.0)
    assert bottom < float(base.min()) < float(top.max()) < high
    assert "default: where all horizons are" in scene.explain()
    laws.assert_volumes_add_up(scene.units, scene.box)
    assert {u.zone for u in scene.units.values()} == {"above Top", "Top/Base", "below Base"}


def test_a_hole_is_refused_by_name_and_the_remedies_work():
    holed = np.full((21, 21), 3.0)
    holed[5:8, 9:12] = np.nan
    axis = np.arange(21.0)
    horizons = {"Top": TriSurface("Top", "horizon", lattice=Lattice(axis, axis, holed))}
    words = r"has 1 hole: in 'Top' at \(E 9.9\d+, N 5.9\d+\) \(15 m²\)\. Fill them"
    with pytest.raises(InputError, match=words):
        _ = Scene(horizons).box
    scene = Scene(horizons, aoi="rectangle")
    west, east, south, north, _, _ = scene.box
    share = (east - west) * (north - south) / (400 - 15)
    (step,) = [s for s in scene.steps if s.stage == "box"]
    assert (
        f"largest axis-parallel rectangle that all horizons cover, {100 * share:.0f} %"
        in step.detail
    )
    assert len(scene.units) == 2


@pytest.mark.parametrize(("box", "words"), [
    ((0, 4, 0, 4, -8, -2), r"Top' \(easting -1 to 5, .* elevation 3 to 3\) does not .* are depths"),
    ((0, 4, 0, 4, 5, 8), r"elevation 3 to 3\) does not reach .*0 to 4, 5 to 8\)\. Enlarge the box"),
    ((9, 12, 0, 4, 0, 8), r"model box \(9 to 12, 0 to 4, 0 to 8\)\. Enlarge the box"),
])  # fmt: skip
def test_a_box_apart_from_a_horizon_names_both_extents(box, words):
    with pytest.raises(GeometryError, match=words):
        Scene({"Top": level(3)}, box=box).units  # noqa: B018


def test_the_default_area_of_a_mesh_is_inside_its_rim():
    corners = [(0, 0, 3), (9, 1, 3), (8, 7, 3), (4, 2, 3), (1, 8, 3)]  # not convex
    mesh = TriSurface("Top", "horizon", corners, [[0, 1, 3], [1, 2, 3], [0, 3, 4]])
    scene = Scene({"Top": mesh})
    assert len(scene.units) == 2
    assert scene.check().ok
    assert 5 <= len(scene.aoi) <= 20
    assert scene.units.footprint == pytest.approx(36.5, rel=0.01)
    with pytest.raises(InputError, match="'Top' is a mesh, and aoi='rectangle' is for grids only"):
        _ = Scene({"Top": mesh}, aoi="rectangle").box
    with pytest.raises(InputError, match="proposes a box, and box= is given as well"):
        Scene({"Top": mesh}, box=(0, 1, 0, 1, 0, 4), aoi="rectangle")


@pytest.fixture(scope="module")
def torn():
    """A horizon torn by a fault that cuts right through, and this fault."""
    world = synthetic.torn("through", 41)
    sheet = tear_horizon(world.truth["points"], world.faults, name="Top", positive="up")
    return {"Top": sheet}, {fault.name: fault for fault in sheet.faults}


@pytest.mark.parametrize("words", [{"extend": ["F1"]}, {"truncations": {"F1": ("X", "+")}}])
def test_the_default_area_of_torn_horizons_does_not_ask_for_the_faults_that_leave_it(torn, words):
    """Each would ask for the other: the fault ends at the box, the horizon at the fault."""
    sheets, faults = torn
    wall = [[0, 400, -2100], [1000, 400, -2100], [1000, 400, -1500], [0, 400, -1500]]
    scene = Scene(sheets, {**faults, "X": (wall, [[0, 1, 2], [0, 2, 3]])}, **words)
    assert scene.box[:4] == pytest.approx((0, 1000, 0, 1000))
    assert scene.aoi is None
    assert scene.surface("F1").n_triangle
    if "truncations" in words:
        with pytest.raises(InputError, match=r"another surface here.* tear .* scene.surface"):
            _ = scene.units
    else:  # it leaves the box already
        assert scene.check().ok


def test_the_default_area_of_torn_horizons_is_closed(torn):
    scene = Scene(*torn)
    assert scene.check().ok
    assert scene.units.footprint == 1e6
