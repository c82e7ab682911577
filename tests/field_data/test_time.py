"""Drogon in time: four velocity models, there and back at every vertex, the same units."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
FRAME = (456000.0, 467600.0, 5926400.0, 5939600.0)


def map_of(low: float) -> xr.DataArray:
    """A map of velocities that changes by 300 m/s over the field."""
    x, y = np.linspace(*FRAME[:2], 30), np.linspace(*FRAME[2:], 40)
    values = low + 300.0 * np.sin(x / 1500.0) * np.cos(y[:, None] / 2100.0)
    return xr.DataArray(values, {"northing": y, "easting": x}, ("northing", "easting"))


LAYERS = {
    "above topvolantis": 2100.0,
    "topvolantis/toptherys": 2900.0,
    "toptherys/topvolon": 2700.0,
    "elsewhere": 3200.0,
}
MODELS = {
    "constant": 2600.0,
    "layers": LAYERS,
    "v0 + k z": LAYERS | {"above topvolantis": {"v0": 1800.0, "k": 0.6}},
    "maps": LAYERS | {"above topvolantis": map_of(2100.0), "toptherys/topvolon": map_of(2900.0)},
}


@pytest.fixture(scope="module")
def depth(drogon_horizons, drogon_faults) -> gs.Scene:
    """The field in depth, of every second node."""
    horizons = {}
    for one in drogon_horizons:
        axes = (one.lattice.easting, one.lattice.northing)
        thin = (slice(None, None, 2),) * 2
        grid = gs.Lattice(*(a[thin[: a.ndim]] for a in axes), one.lattice.elevation[thin], True)
        horizons[one.name] = gs.TriSurface(one.name, "horizon", lattice=grid)
    return gs.Scene(horizons, {one.name: one for one in drogon_faults}, tear=True)


@pytest.mark.parametrize(
    "model", [pytest.param(one, marks=() if one == "maps" else pytest.mark.long) for one in MODELS]
)
def test_depth_to_time_to_depth_is_the_same_model(depth, model):
    velocity = MODELS[model]
    time = depth.replace(velocity=velocity).in_time("two-way")
    back = time.replace(velocity=velocity, box=depth.box, aoi=depth.aoi)

    def names(scene: gs.Scene) -> set[tuple[str, str]]:
        zones = scene.reservoir
        return {(u.zone, u.block) for u in scene.units.without_slivers if u.zone in zones}

    assert names(depth) == names(back) == names(back.in_time())
    assert [one for one in back.warnings if one.kind == "depth"] == []
    assert all(line.startswith("pass") for line in str(back.check()).splitlines())

    # every vertex, on both walls of each fault
    vertices = back.patches.vertices
    np.testing.assert_allclose(back.to_depth(back.to_time(vertices)), vertices, rtol=0.0, atol=1e-6)
    # nodes as they were given, away from faults
    for name in depth.horizon_names:
        off = back.sheets[name].lattice.elevation - depth.sheets[name].lattice.elevation
        assert np.nanmedian(np.abs(off)) < 1e-6
