"""Scenes of simplified horizons: volumes within their bound."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf import Scene, synthetic
from geosurf.errors import InputError
from geosurf.report.tables import accuracy
from geosurf.triangulate.coarsen import volume_error

WORLDS = {
    "tilted planes": (synthetic.tilted_planes, {}),
    "graben": (synthetic.graben, {"n": 17}),
    "hills": (synthetic.hills, {"n": 41, "horizons": 2}),
    "waves": (synthetic.waves, {"n": 41}),
    "dome": (synthetic.dome_and_flat_fault, {"n": 41}),
    "egg box": (synthetic.egg_box, {"n": 41}),
    "listric": (synthetic.listric, {"n": 33}),
    "noisy": (synthetic.noisy, {"n": 33}),
    "faulted": (synthetic.faulted, {"n": 33}),
    "torn": (synthetic.torn, {"n": 41}),
    "faulted reservoir": (synthetic.faulted_reservoir, {"n": 41}),
}


def pair_of(name, tolerance):
    make, options = WORLDS[name]
    world = make(**options)
    exact = Scene(world.horizons, world.faults, world.box)
    few = {
        name: gs.triangulate_horizon(horizon, name=name, tolerance=tolerance)
        for name, horizon in world.horizons.items()
    }
    return exact.replace(horizons=few), exact


@pytest.mark.parametrize("tolerance", [0.5, 8.0])
@pytest.mark.parametrize("name", WORLDS)
def test_volumes_are_within_the_bound(name, tolerance):
    quick, exact = pair_of(name, tolerance)
    bound, rounding = quick.volume_error_bound, 1e-9 * exact.units.box_volume
    assert set(quick.units) == set(exact.units)
    off = {unit: abs(quick.units[unit].volume - exact.units[unit].volume) for unit in exact.units}
    assert max(off.values()) <= bound + rounding
    zones = {}
    for unit in exact.units:
        zone = exact.units[unit].zone
        zones[zone] = zones.get(zone, 0.0) + quick.units[unit].volume - exact.units[unit].volume
    assert max(map(abs, zones.values())) <= bound + rounding
    w, e, s, n, _, _ = quick.box
    assert bound <= len(quick.horizon_names) * tolerance * 1.5 * (e - w) * (n - s)
    assert quick.check().ok


def test_the_bound_is_no_empty_one():
    quick, exact = pair_of("waves", 8.0)
    assert quick.surface("Top").n_triangle < exact.surface("Top").n_triangle / 4
    off = float(abs(quick.volumes - exact.volumes).max())
    assert 0.0 < off <= quick.volume_error_bound < 0.1 * exact.units.box_volume
    assert exact.volume_error_bound == 0.0


def test_no_tolerance_changes_no_byte():
    world = synthetic.graben(n=17)
    one = Scene(world.horizons, world.faults, world.box)
    two = Scene(world.horizons, world.faults, world.box, tolerance=2.0).replace(tolerance=None)
    assert two.tolerance is None
    for key in ("vertices", "triangles", "surface_of_triangle", "parent_of_triangle"):
        assert getattr(one.patches, key).tobytes() == getattr(two.patches, key).tobytes()
    assert one.curves.points.tobytes() == two.curves.points.tobytes()


def test_the_default_box_is_that_of_all_nodes():
    world = synthetic.waves(n=41)
    boxes = [Scene(world.horizons, world.faults, tolerance=t).box for t in (None, 8.0)]
    assert boxes[0] == boxes[1]


def test_reports_state_the_effect():
    few, exact = pair_of("waves", 8.0)
    (line,) = accuracy(few)
    assert line.startswith("Horizons have fewer nodes than their grids, and are at most ")
    assert accuracy(exact) == []


@pytest.mark.parametrize("sides", [(0.0, 10_000.0, 0.0, 10_000.0), (1300.0, 4100.0, 700.0, 5900.0)])
def test_the_bound_holds_for_what_lies_between_both_surfaces(sides):
    """Summed over a raster, finer than the nodes, of one part of the map."""
    x = np.linspace(0.0, 10_000.0, 41)
    z = 200 * np.sin(x[None, :] / 700) * np.sin(x[:, None] / 900)
    import xarray

    grid = xarray.DataArray(
        z, {"northing": x, "easting": x}, ("northing", "easting"),
        attrs={"units": "m", "positive": "up"},
    )  # fmt: skip
    plain, quick = (gs.triangulate_horizon(grid, name="Top", tolerance=t) for t in (0.0, 15.0))
    west, east, south, north = sides
    e, n = np.meshgrid(np.linspace(west, east, 300), np.linspace(south, north, 300))
    gap = np.abs(height_of(plain, e.ravel(), n.ravel()) - height_of(quick, e.ravel(), n.ravel()))
    assert gap.max() <= 15.0
    between = gap.mean() * (east - west) * (north - south)
    assert 0.0 < between <= volume_error(quick, sides)
    assert volume_error(plain, sides) == 0.0


def height_of(surface, e, n):
    from matplotlib.tri import LinearTriInterpolator, Triangulation

    x, y, z = surface.vertices.T
    found = LinearTriInterpolator(Triangulation(x, y, surface.triangles), z)(e, n)
    return np.asarray(found.filled(np.nan))


@pytest.mark.parametrize("tolerance", [-1.0, 0.0, np.nan, np.inf, "5 m", True])
def test_a_tolerance_is_a_length(tolerance):
    world = synthetic.tilted_planes()
    with pytest.raises(InputError, match=r"tolerance is .*; give a length above 0 m, or None for"):
        Scene(world.horizons, world.faults, world.box, tolerance=tolerance)


def test_a_torn_horizon_has_no_tolerance():
    world = synthetic.tilted_planes()
    fault = Scene(world.horizons, world.faults, world.box).surface("F1")
    sheet = gs.throw_horizon(world.horizons["Top"], [fault], {"F1": 20.0}, name="Top")
    horizons = {**world.horizons, "Top": sheet}
    with pytest.raises(
        InputError, match=r"'Top' is a sheet torn at faults, .* Leave tolerance out"
    ):
        Scene(horizons, world.faults, world.box, tolerance=5.0)
