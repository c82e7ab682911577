"""Inputs of a scene: grids, meshes, sticks and files; units and directions; what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from geosurf import Lattice, Scene, TriSurface, synthetic
from geosurf.errors import InputError
from tests.scene.small import level
from tests.strategies import BOX, sheet


def test_a_gridded_contact_takes_the_options_of_the_scene(scene):
    """As horizons do: depths in feet, where the array itself does not say."""
    x = np.array([-1.0, 5.0])
    owc = xr.DataArray(
        np.full((2, 2), -2.0 / 0.3048), dims=("northing", "easting"),
        coords={"northing": x, "easting": x},
    )  # fmt: skip
    split = scene.replace(contacts={"OWC": {"F1+": owc}}, positive="down", length_unit="ft")
    assert "Top/Base F1+ below OWC" in split.units
    above = split.units["Top/Base F1+ above OWC"].vertices[:, 2]
    assert above.min() == pytest.approx(2.0, abs=1e-12)
    with pytest.raises(InputError, match=r"horizon 'OWC': are the values depth or elevation\?"):
        scene.replace(contacts={"OWC": owc}).units  # noqa: B018


@pytest.mark.parametrize("said", [{"units": "m"}, {"units": "m", "positive": "up"}])
def test_a_gridded_fault_that_declares_its_units_keeps_them(said):
    dims = ("down_dip", "along_strike")
    fault = xr.Dataset({
        "easting": (dims, [[1.0, 1.0], [2.0, 2.0]]),
        "northing": (dims, [[0.0, 9.0], [0.0, 9.0]]),
        "elevation": (dims, [[8.0, 8.0], [-8.0, -8.0]], said),
    })  # fmt: skip
    scene = Scene({}, {"F1": fault}, BOX, positive="down", length_unit="ft")
    assert scene.surface("F1").bounds == (1.0, 2.0, 0.0, 9.0, -8.0, 8.0)
    plain = fault.assign(elevation=fault.elevation.drop_attrs())
    for whole in ({}, {"units": "m"}):  # which once kept the word of the scene away
        feet = (
            Scene({}, {"F1": plain.assign_attrs(whole)}, BOX, length_unit="ft").surface("F1").bounds
        )
        assert feet[4:] == pytest.approx((-2.4384, 2.4384), abs=1e-12)


def test_a_scene_outlives_what_is_done_to_its_inputs():
    """Grids are lent to surfaces, not to scenes: boxes would be stale, and volumes mixed."""
    worlds = [synthetic.tilted_planes() for _ in range(2)]
    scenes = [Scene(world.horizons, world.faults, world.box) for world in worlds]
    for name in (*worlds[0].horizons, *worlds[0].faults):
        scenes[0].surface(name)
    for da in worlds[0].horizons.values():
        da.values[...] += 77.0
    for ds in worlds[0].faults.values():
        ds["easting"].values[...] -= 99.0
    first, second = ({name: unit.volume for name, unit in s.units.items()} for s in scenes)
    assert first == second


def test_a_frame_that_would_round_inputs_is_not_taken():
    """The box lies beyond 2048 m, but 1000.1 - 2048 has more digits than a double."""
    axis = np.arange(900.1, 3200.0, 200.0)
    top = TriSurface("Top", "horizon", lattice=Lattice(axis, axis, np.zeros((12, 12))))
    box = (2100.0, 2900.0, 2100.0, 2900.0, -300.0, 300.0)
    patches = Scene({"Top": top}, box=box).patches
    assert patches.origin.tolist() == [0.0, 0.0, 0.0]
    assert set(map(tuple, top.vertices.tolist())) <= set(map(tuple, patches.vertices.tolist()))
    even = TriSurface("Top", "horizon", lattice=Lattice(*[np.floor(axis)] * 2, np.zeros((12, 12))))
    assert Scene({"Top": even}, box=box).patches.origin.tolist() == [2048.0, 2048.0, 0.0]


def test_a_fault_has_its_front_in_the_hanging_wall_however_it_is_wound():
    dipping = sheet("F1", [(1, -1, 8), (1, 5, 8), (3, 5, -4), (3, -1, -4)])
    turned = TriSurface("F1", "fault", dipping.vertices, dipping.triangles[:, ::-1])
    for fault in (dipping, turned):
        volumes = {u.block: u.volume for u in Scene({}, {"F1": fault}, BOX).units.values()}
        assert volumes == {"F1+": 96.0, "F1-": 96.0}
        units = Scene({"Top": level(5)}, {"F1": fault}, BOX).units
        assert units["above Top F1+"].volume > units["above Top F1-"].volume
