"""One model, asked for in every way that must not change it, on a field that is irregular."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from tests import oracles
from tests.same_model import worlds

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

OFFSET = (2.0**19, 2.0**22)  # as UTM has them, exact in binary


def plain_model() -> dict[str, Any]:
    return {"horizons": worlds.uneven_horizons(), "faults": worlds.faults(), "box": worlds.BOX}


def torn_model() -> dict[str, Any]:
    horizons = {name: one[::2, ::2] for name, one in worlds.picked_horizons().items()}
    del horizons["Base"]
    faults = {name: fault for name, fault in worlds.faults().items() if name != "V"}
    return {"horizons": horizons, "faults": faults, "box": worlds.BOX, "tear": {"W": 2, "E": 2}}


MODELS = {"plain": plain_model, "torn": torn_model}


@pytest.fixture(scope="module", params=MODELS)
def model(request):
    """How to make a model, and what it says."""
    make = MODELS[request.param]
    found = worlds.bytes_of(gs.Scene(**make()))
    assert "error" not in found
    return make, found


def of_horizons(inputs: dict[str, Any], change) -> dict[str, Any]:
    return inputs | {"horizons": {n: change(one) for n, one in inputs["horizons"].items()}}


def from_files(inputs, folder):
    paths = {}
    for name, data in inputs["horizons"].items():
        paths[name] = folder / f"{name}.nc"
        data.to_dataset(name="elevation").to_netcdf(paths[name], engine="h5netcdf")
    return inputs | {"horizons": paths}


SAME_BYTES = {
    "depths, one thread": lambda inputs, _: of_horizons(
        inputs, lambda one: (-one).assign_attrs(units="m", positive="down")
    ),
    "search voxels, three threads": lambda inputs, _: inputs | {"voxel_size": 170.0},
    "rows from north to south": lambda inputs, _: of_horizons(
        inputs, lambda one: one.isel(northing=slice(None, None, -1))
    ),
    "columns from east to west, in Fortran order": lambda inputs, _: of_horizons(
        inputs, lambda one: one.copy(data=np.asfortranarray(one.values))[:, ::-1]
    ),
    "files": from_files,
}


@pytest.mark.parametrize("variant", SAME_BYTES)
def test_law_same_bytes(model, variant, tmp_path, monkeypatch):
    make, wanted = model
    if variant.endswith(("thread", "threads")):
        monkeypatch.setenv("GEOSURF_THREADS", "1" if variant.endswith("one thread") else "3")
    scene = gs.Scene(**SAME_BYTES[variant](make(), tmp_path))
    assert worlds.difference(worlds.bytes_of(scene), wanted) == ""


def test_law_a_shift_of_the_map_changes_no_byte(model):
    make, wanted = model
    inputs = make()
    x, y = OFFSET

    def moved(one: xr.DataArray) -> xr.DataArray:
        return one.assign_coords(easting=one.easting + x, northing=one.northing + y)

    faults = {
        name: gs.TriSurface(name, "fault", f.vertices + np.array([x, y, 0.0]), f.triangles)
        for name, f in inputs["faults"].items()
    }
    west, east, south, north, *levels = inputs["box"]
    box = (west + x, east + x, south + y, north + y, *levels)
    found = worlds.bytes_of(gs.Scene(**of_horizons(inputs, moved) | {"faults": faults, "box": box}))
    units = [name for name in wanted if name.startswith("unit ")]
    assert len(units) >= 6
    if inputs.get("tear"):  # cut-off lines are solved for in world coordinates
        for name in units:
            assert found[name][0] == pytest.approx(wanted[name][0], rel=1e-12)
        return
    assert {name: found[name] for name in units} == {name: wanted[name] for name in units}


def test_law_the_order_of_faults_changes_no_triangle(model):
    make, _ = model
    inputs = make()
    names = list(inputs["faults"])
    one, two = (
        gs.Scene(**inputs | {"faults": {name: inputs["faults"][name] for name in order}})
        for order in (names, names[::-1])
    )
    assert names != names[::-1]

    def shells(scene):
        """Corners of each triangle, begun at the least one, in the order of places."""
        found = {}
        for name, unit in scene.units.items():
            places, rank = np.unique(unit.local + 0.0, axis=0, return_inverse=True)
            corners = rank.reshape(-1)[unit.triangles]
            first = corners.argmin(axis=1)[:, None]
            turned = np.take_along_axis(corners, (first + np.arange(3)) % 3, axis=1)
            order = np.lexsort(turned.T[::-1])
            found[frozenset(name.split())] = places.tobytes(), turned[order].tobytes()
        return found

    assert len(shells(one)) >= 6
    assert shells(one) == shells(two)


def test_law_a_transposed_model_is_the_transposed_model(model):
    """East and north exchanged in every input: the same units, as a mirror has them."""
    make, wanted = model
    inputs = make()

    def mirrored(one: xr.DataArray) -> xr.DataArray:
        coords = {"northing": one.easting.values, "easting": one.northing.values}
        turned = one.transpose("easting", "northing").values
        return xr.DataArray(turned, coords, ("northing", "easting"), attrs=one.attrs)

    faults = {
        name: gs.TriSurface(name, "fault", f.vertices[:, [1, 0, 2]], f.triangles[:, ::-1])
        for name, f in inputs["faults"].items()
    }
    west, east, south, north, *levels = inputs["box"]
    scene = gs.Scene(
        **of_horizons(inputs, mirrored)
        | {"faults": faults, "box": (south, north, west, east, *levels)}
    )
    volumes = {name: unit.volume for name, unit in scene.units.items()}
    plain = gs.Scene(**inputs).units
    assert volumes.keys() == plain.keys()
    for name, unit in plain.items():
        # a tear solves equations in another order: the last digits differ
        assert volumes[name] == pytest.approx(
            unit.volume, rel=1e-6 if inputs.get("tear") else 1e-12
        )
    assert len(wanted["warnings"]) == len(scene.warnings)


def test_meshes_of_the_same_triangles_are_the_same_model():
    inputs = plain_model()
    meshes = {}
    for name, data in inputs["horizons"].items():
        surface = gs.triangulate_horizon(data, name=name)
        meshes[name] = (surface.vertices, surface.triangles)
    grids, found = gs.Scene(**inputs).units, gs.Scene(**inputs | {"horizons": meshes}).units
    assert found.keys() == grids.keys()
    for name, unit in grids.items():
        assert found[name].volume == pytest.approx(unit.volume, rel=1e-12)
        assert found[name].area == pytest.approx(unit.area, rel=1e-12)


# ---- measures beside a slow oracle ----------------------------------------------------------


def heights(data: xr.DataArray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Elevation of the triangles of a grid, cell by cell; the diagonal runs from south-west."""
    east, north, z = data.easting.values, data.northing.values, data.values
    j = np.clip(np.searchsorted(east, x, side="right") - 1, 0, len(east) - 2)
    i = np.clip(np.searchsorted(north, y, side="right") - 1, 0, len(north) - 2)
    u = (x - east[j]) / (east[j + 1] - east[j])
    v = (y - north[i]) / (north[i + 1] - north[i])
    z00, z01, z10, z11 = z[i, j], z[i, j + 1], z[i + 1, j], z[i + 1, j + 1]
    below = z00 + u * (z01 - z00) + v * (z11 - z01)
    above = z00 + v * (z10 - z00) + u * (z11 - z10)
    return np.where(u >= v, below, above)


def column_at(x, y):
    """Top, Middle and Base, the older ones cut by the younger ones."""
    horizons = worlds.uneven_horizons()
    found = [heights(horizons["Top"], x, y)]
    for name in ("Middle", "Base"):
        found.append(np.minimum(heights(horizons[name], x, y), found[-1]))
    return found


def zones_at(x, y, z):
    names = ("above Top", "Top/Middle", "Middle/Base", "below Base")
    return np.array(names)[sum((z < one).astype(int) for one in column_at(x, y))]


@pytest.fixture(scope="module")
def plain():
    return gs.Scene(**plain_model())


def random_places(n):
    rng = np.random.default_rng(41)
    west, east, south, north, bottom, top = worlds.BOX
    places = rng.uniform((west, south, bottom), (east, north, top), (n, 3))
    places[::2, 2] = rng.uniform(-2100.0, -1850.0, (n + 1) // 2)  # near the horizons
    return places


@pytest.mark.parametrize("form", ["points", "table", "cells"])
def test_samples_are_in_the_zone_of_the_oracle(plain, form):
    if form == "cells":
        found = plain.sample(cell=(83.0, 97.0, 41.0))
        z, y, x = np.meshgrid(found.elevation, found.northing, found.easting, indexing="ij")
    else:
        x, y, z = random_places(3000).T
        table = {"easting": x, "northing": y, "elevation": z}
        found = plain.sample(table if form == "table" else np.stack([x, y, z], axis=1))
    wanted = zones_at(x.ravel(), y.ravel(), z.ravel())
    assert len(np.unique(wanted)) == 4
    assert (found.zone.values.ravel() == wanted).all()


def test_thickness_is_that_of_the_oracle(plain):
    found = plain.thickness("Top/Middle", 110.0).sum("block")
    x, y = np.meshgrid(found.easting, found.northing)
    top, middle, _ = column_at(x.ravel(), y.ravel())
    assert (top - middle).min() == 0.0
    np.testing.assert_allclose(found.values.ravel(), top - middle, atol=1e-6)


def test_wells_pass_the_zones_of_the_oracle(plain):
    for x, y in ((1777.0, 2999.0), (3210.0, 4321.0), (2190.5, 5555.5)):
        path = np.array([(x, y, -1650.0), (x, y, -2450.0)])
        found = plain.well_intervals(path, md=[0.0, 800.0])
        top, middle, base = (one[0] for one in column_at(np.array([x]), np.array([y])))
        wanted = {"above Top": -1650.0 - top, "Top/Middle": top - middle,
                  "Middle/Base": middle - base, "below Base": base + 2450.0}  # fmt: skip
        lengths: dict[str, float] = {}
        for zone, length in zip(found.zone.values, np.ptp(found.md.values, axis=1), strict=True):
            lengths[str(zone)] = lengths.get(str(zone), 0.0) + float(length)
        for zone, length in wanted.items():
            assert lengths.get(zone, 0.0) == pytest.approx(length, abs=1e-6), (x, y, zone)


def test_volumes_are_those_of_the_oracle(plain):
    """Zone by zone, by the sum over columns of fine cells: a check of size, not of digits."""
    n = 500
    west, east, south, north = worlds.BOX[:4]
    x = west + (np.arange(n) + 0.5) * (east - west) / n
    y = south + (np.arange(n) + 0.5) * (north - south) / n
    top, middle, base = column_at(*(one.ravel() for one in np.meshgrid(x, y)))
    cell = (east - west) * (north - south) / n**2
    zones: dict[str, float] = {}
    for unit in plain.units.values():
        zones[unit.zone] = zones.get(unit.zone, 0.0) + unit.volume
    assert zones["Top/Middle"] == pytest.approx((top - middle).sum() * cell, rel=1e-4)
    assert zones["Middle/Base"] == pytest.approx((middle - base).sum() * cell, rel=1e-4)
    for unit in sorted(plain.units.values(), key=lambda one: len(one.triangles))[:3]:
        exact = float(oracles.volume(unit.local, unit.triangles))
        assert exact == pytest.approx(unit.volume, rel=1e-12)


def test_faults_two_cells_apart_keep_the_strip_between_them(plain):
    """Volumes between W and V, from their planes and the oracle of the horizons."""
    strip = {u.zone: u.volume for u in plain.units.values() if {"W+", "V-"} <= set(u.block.split())}
    south, north = worlds.BOX[2:4]
    z = np.linspace(worlds.BOX[4], worlds.BOX[5], 1801)
    middle = 0.5 * (z[1:] + z[:-1])
    y = south + (np.arange(75) + 0.5) * (north - south) / 75
    first = worlds.EAST[60] + 5.0 - 350.0 * (middle + 2100.0) / 800.0
    totals: dict[str, float] = {}
    for share in (np.arange(8) + 0.5) / 8:
        x, yy = np.meshgrid(first + 40.0 * share, y)
        zone = zones_at(x.ravel(), yy.ravel(), np.broadcast_to(middle, x.shape).ravel())
        for name in np.unique(zone):
            size = (zone == name).sum() * (z[1] - z[0]) * (y[1] - y[0]) * 5.0
            totals[str(name)] = totals.get(str(name), 0.0) + size
    assert strip.keys() == totals.keys()
    for name, volume in totals.items():
        assert strip[name] == pytest.approx(volume, rel=2e-3), name


# ---- torn at W: what the data say of it is known ---------------------------------------------


@pytest.fixture(scope="module")
def noisy():
    top = worlds.picked_horizons()["Top"]
    return top + np.random.default_rng(1).normal(0.0, 3.0, top.shape)


def test_one_outlier_among_thousands_moves_no_estimate(noisy):
    spiked = noisy.copy()
    spiked[100, 180] += 400.0
    faults = {"W": worlds.faults()["W"]}
    one, two = (gs.tear_horizon(data, faults, name="Top") for data in (noisy, spiked))
    assert one.report.noise == pytest.approx(3.0, rel=0.05)
    assert two.report.noise == pytest.approx(one.report.noise, rel=0.01)
    inside = slice(10, -10)
    assert np.median(one.cuts["W"].throw[inside]) == pytest.approx(55.0, abs=6.0)
    np.testing.assert_allclose(two.cuts["W"].throw[inside], one.cuts["W"].throw[inside], atol=0.05)


def test_a_well_with_a_repeated_station_is_followed_to_its_end(plain):
    once = np.array([(1777, 2999, -1650.0), (1900, 3100, -1900.0), (2900, 3700, -2450.0)])
    path = once[[0, 1, 1, 2]]
    length = np.linalg.norm(np.diff(once, axis=0), axis=1).sum()
    rig = (1777.0, 2999.0, 20.0)
    found = plain.well_intervals([rig, *path])
    assert np.ptp(found.md.values, axis=1).sum() == pytest.approx(1670.0 + length, rel=1e-12)
    assert worlds.plain(found) == worlds.plain(plain.well_intervals([rig, *once]))
