"""The truth of synthetic worlds, found a second time by other means."""

from __future__ import annotations

import importlib.util
import inspect
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

import geosurf
from geosurf import synthetic
from geosurf.errors import InputError
from geosurf.model.column import names_of_zones
from geosurf.synthetic import torn_horizon
from geosurf.synthetic.domes import hashed_noise
from geosurf.triangulate import triangulate_fault, triangulate_horizon
from tests.messages import refused

FILES = Path(__file__).resolve().parents[2] / "data" / "synthetic_horizons"
WORLDS = [
    synthetic.tilted_planes,
    synthetic.graben,
    synthetic.noisy,
    synthetic.dome_and_flat_fault,
    synthetic.egg_box,
    synthetic.listric,
    synthetic.faulted_reservoir,
]
PLANAR = [synthetic.tilted_planes, synthetic.graben]
every_world = pytest.mark.parametrize("make", WORLDS, ids=lambda make: make.__name__)


def centres(low: float, high: float, n: int) -> np.ndarray:
    return low + (high - low) * (np.arange(n) + 0.5) / n


def plane_of(ds) -> tuple[np.ndarray, np.ndarray]:
    """A point and the unit normal into the hanging wall of a planar fault, from its triangles."""
    surface = triangulate_fault(ds)
    a, b, c = surface.vertices[surface.triangles[0]]
    normal = np.cross(b - a, c - a)
    return a, normal / np.linalg.norm(normal)


def bilinear(da, x, y):
    """Value of a plane horizon anywhere, from its corner nodes."""
    z, e, n = da.values, da.easting.values, da.northing.values
    p = (z[0, -1] - z[0, 0]) / (e[-1] - e[0])
    q = (z[-1, 0] - z[0, 0]) / (n[-1] - n[0])
    return z[0, 0] + p * (x - e[0]) + q * (y - n[0])


# ---- what all worlds promise ---------------------------------------------------------


@every_world
def test_grids_are_ready_to_use_and_cover_the_box(make):
    world = make()
    west, east, south, north, bottom, top = world.box
    assert world.name == make.__name__
    for name, da in world.horizons.items():
        surface = triangulate_horizon(da)
        assert surface.name == name
        assert surface.bounds[:4] == (west, east, south, north)
        assert bottom < surface.bounds[4] <= surface.bounds[5] < top
    for name, ds in world.faults.items():
        assert triangulate_fault(ds).name == name
    levels = [da.values for da in world.horizons.values()]
    assert all((upper > lower).all() for upper, lower in pairwise(levels))
    assert "box" in world.formula or "truth" in world.formula


@every_world
def test_an_offset_moves_a_world_and_changes_no_truth(make):
    shift = (456000.25, 6780000.5, -100.0)
    here, there = make(n=17), make(n=17, offset=shift)
    walls = here.truth.pop("wall_at", {}), there.truth.pop("wall_at", {})
    assert here.truth == there.truth
    for key, wall in walls[0].items():
        moved = walls[1][key](2e3 + shift[0], 3e3 + shift[1]) - shift[2]
        assert moved == pytest.approx(wall(2e3, 3e3), abs=1e-9)
    moved_by = np.subtract(there.box, here.box).reshape(3, 2)
    np.testing.assert_array_equal(moved_by.T, [shift] * 2)
    for name, da in here.horizons.items():
        moved = there.horizons[name]
        np.testing.assert_allclose(moved.values, da.values + shift[2], rtol=0, atol=1e-12)
        np.testing.assert_array_equal(moved.easting, da.easting + shift[0])
    for name, ds in here.faults.items():
        for key, by in zip(("easting", "northing", "elevation"), shift, strict=True):
            np.testing.assert_array_equal(there.faults[name][key], ds[key] + by)


@every_world
def test_volumes_add_up_to_zones_and_to_the_box(make):
    world = make(n=9)
    west, east, south, north, bottom, top = world.box
    whole = (east - west) * (north - south) * (top - bottom)
    if "volumes" not in world.truth:
        assert world.truth["box_volume"] == whole
        return
    assert all(value > 0 for value in world.truth["volumes"].values())
    assert math.isclose(math.fsum(world.truth["volumes"].values()), whole, rel_tol=1e-14)
    for zone, value in world.truth.get("zone_volumes", {}).items():
        parts = [v for (z, _), v in world.truth["volumes"].items() if z == zone]
        assert math.isclose(math.fsum(parts), value, rel_tol=1e-13)


@every_world
def test_a_grid_of_one_node_is_refused(make):
    refused(InputError, r"n is 1: a grid needs two nodes per side\. Give n=2", make, n=1)
    assert next(iter(inspect.signature(make).parameters)) == "n"


# ---- planes --------------------------------------------------------------------------


def columns(world, n=400):
    """Volumes of all zones on all sides, by integrating over columns."""
    west, east, south, north, bottom, top = world.box
    x, y = np.meshgrid(centres(west, east, n), centres(south, north, n))
    cell = (east - west) * (north - south) / n**2
    levels = [np.full(x.shape, top)]
    levels += [bilinear(da, x, y) for da in world.horizons.values()]
    levels += [np.full(x.shape, bottom)]
    faults = []
    for name, ds in world.faults.items():
        point, normal = plane_of(ds)
        cut = point[2] - ((x - point[0]) * normal[0] + (y - point[1]) * normal[1]) / normal[2]
        faults.append((name, cut))
    found = {}
    zones = names_of_zones(list(world.horizons))
    for zone, upper, lower in zip(zones, levels[:-1], levels[1:], strict=True):
        for signs in np.ndindex(*[2] * len(faults)):
            high, low, sides = upper, lower, []
            for above, (name, cut) in zip(signs, faults, strict=True):
                high, low = (high, np.maximum(low, cut)) if above else (np.minimum(high, cut), low)
                sides.append(name + "-+"[above])
            found[zone, tuple(sides)] = np.clip(high - low, 0, None).sum() * cell
    return found


@pytest.mark.parametrize(
    "world",
    [
        synthetic.tilted_planes(n=5),
        synthetic.tilted_planes(n=5, dip=35.0, dip_direction=290.0, tilt=1.0),
        synthetic.graben(n=5),
        synthetic.graben(n=5, dip=50.0, tilt=0.5),
    ],
    ids=lambda world: world.name,
)
def test_volumes_of_planes_agree_with_columns(world):
    found = columns(world)
    truth = world.truth["volumes"]
    scale = sum(truth.values())
    for key, value in found.items():
        assert abs(value - truth.get(key, 0.0)) < 1e-6 * scale, key


@pytest.mark.parametrize("direction", [0.0, 90.0, 180.0, 270.0, 300.0])
def test_sides_of_a_vertical_fault_are_those_of_the_oriented_surface(direction):
    world = synthetic.tilted_planes(n=5, dip=90.0, dip_direction=direction, tilt=0.0)
    west, east, south, north, _, _ = world.box
    x, y = np.meshgrid(centres(west, east, 801), centres(south, north, 801))
    point, normal = plane_of(world.faults["F1"])
    share = ((x - point[0]) * normal[0] + (y - point[1]) * normal[1] > 0).mean()
    truth = world.truth["volumes"]["Top/Base", ("F1+",)]
    assert math.isclose(truth, share * 4000 * 3000 * 100, rel_tol=2e-3)


@pytest.mark.parametrize("make", PLANAR, ids=lambda make: make.__name__)
def test_lengths_of_curves_agree_with_where_the_rim_of_the_box_is_crossed(make):
    world = make(n=5)
    west, east, south, north, _, _ = world.box
    t = np.linspace(0.0, 1.0, 200001)
    rim = [
        (west + (east - west) * t, np.full_like(t, south)),
        (west + (east - west) * t, np.full_like(t, north)),
        (np.full_like(t, west), south + (north - south) * t),
        (np.full_like(t, east), south + (north - south) * t),
    ]
    assert world.truth["n_curve"] == len(world.horizons) * len(world.faults)
    for (top, fault), length in world.truth["curve_length"].items():
        point, normal = plane_of(world.faults[fault])
        ends = []
        for x, y in rim:
            z = bilinear(world.horizons[top], x, y)
            side = (np.stack([x, y, z], 1) - point) @ normal
            for i in np.flatnonzero(side[1:] * side[:-1] < 0):
                ends.append((x[i], y[i], z[i]))
        assert len(ends) == 2
        assert math.isclose(math.dist(*ends), length, rel_tol=1e-4)


def test_noise_keeps_its_bounds_and_is_the_same_everywhere():
    world, plain = synthetic.noisy(n=33, amplitude=4.0, seed=3), synthetic.tilted_planes(n=33)
    for name, da in world.horizons.items():
        moved = np.abs(da - plain.horizons[name])
        assert 3.9 < float(moved.max()) <= 4.0
        assert da.attrs == plain.horizons[name].attrs
    # the first outputs of splitmix64 from seed 0, as its authors publish them
    published = [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4]
    expected = [2 * (word >> 11) * 2.0**-53 - 1 for word in published]
    assert hashed_noise((2,), 0).tolist() == expected
    values = hashed_noise((400, 400), 5)
    assert abs(values.mean()) < 5e-3
    assert abs(values.var() - 1 / 3) < 5e-3
    for key, (low, high) in world.truth["volume_bounds"].items():
        assert low < world.truth["volumes"][key] < high


# ---- polyhedra -----------------------------------------------------------------------


# ---- domes and circles ---------------------------------------------------------------


def level_columns(world, height, n=1500):
    """Volumes on both sides of a horizon and a flat fault, by columns."""
    west, east, south, north, bottom, top = world.box
    x, y = np.meshgrid(centres(west, east, n), centres(south, north, n))
    z = height(x, y)
    level = float(world.faults["Flat"]["elevation"][0, 0])
    cell = (east - west) * (north - south) / n**2
    cut = {
        ("above Top", ("Flat+",)): top - np.maximum(z, level),
        ("above Top", ("Flat-",)): np.clip(level - z, 0, None),
        ("below Top", ("Flat+",)): np.clip(z - level, 0, None),
        ("below Top", ("Flat-",)): np.minimum(z, level) - bottom,
    }
    return {key: value.sum() * cell for key, value in cut.items()}


@pytest.mark.parametrize(("a", "b"), [(1200.0, 800.0), (700.0, 700.0)])
def test_the_dome(a, b):
    world = synthetic.dome_and_flat_fault(n=9, semi_axes=(a, b), height=15.0)
    found = level_columns(
        world, lambda x, y: -1900 - 15.0 * (((x - 2000) / a) ** 2 + ((y - 2000) / b) ** 2)
    )
    for key, value in found.items():
        assert math.isclose(world.truth["volumes"][key], value, rel_tol=1e-5), key
    phi = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    around = np.hypot(a * np.sin(phi), b * np.cos(phi)).mean() * 2 * np.pi
    assert math.isclose(world.truth["curve_length"]["Top", "Flat"], around, rel_tol=1e-13)
    assert world.truth["closed"] is True


def test_the_egg_box():
    world = synthetic.egg_box(n=97, periods=3, height=25.0, level=0.4)
    k = 2 * np.pi * 3 / 4000
    found = level_columns(world, lambda x, y: -2050 + 25 * np.sin(k * x) * np.sin(k * y))
    for key, value in found.items():
        assert math.isclose(world.truth["volumes"][key], value, rel_tol=1e-5), key
    u = np.linspace(math.asin(0.4), math.pi - math.asin(0.4), 2_000_001)
    v = np.arcsin(np.clip(0.4 / np.sin(u), None, 1.0))
    half = np.hypot(np.diff(u), np.diff(v)).sum()  # below the middle; the loop is twice that
    assert math.isclose(world.truth["curve_length"]["Top", "Flat"], 18 * 2 * half / k, rel_tol=1e-6)
    z = np.pad(world.horizons["Top"].values, 1, constant_values=-9999.0)
    middle = z[1:-1, 1:-1]
    around = [np.roll(z, shift, (0, 1))[1:-1, 1:-1] for shift in ((0, 1), (0, -1), (1, 0), (-1, 0))]
    peaks = (middle > np.max(around, axis=0)) & (middle > -2050 + 10)
    assert world.truth["n_curve"] == peaks.sum() == 18


def test_the_listric_fault():
    world = synthetic.listric(n=33, radius=2500.0, tilt=2.0)
    west, east, south, north, bottom, top = world.box
    slope = math.tan(math.radians(2.0))
    y, z = np.meshgrid(centres(south, north, 1200), centres(bottom, top, 1200))
    x = 3000 - np.sqrt(2500.0**2 - (z + 800) ** 2)
    assert west < x.min() < x.max() < east
    under = z < -1900 + slope * (y - 1500)
    cell = (north - south) * (top - bottom) / y.size
    found = {
        ("above Top", ("F1+",)): ((east - x) * ~under).sum() * cell,
        ("above Top", ("F1-",)): ((x - west) * ~under).sum() * cell,
        ("below Top", ("F1+",)): ((east - x) * under).sum() * cell,
        ("below Top", ("F1-",)): ((x - west) * under).sum() * cell,
    }
    for key, value in found.items():
        assert math.isclose(world.truth["volumes"][key], value, rel_tol=1e-4), key
    y = np.linspace(south, north, 100_001)
    z = -1900 + slope * (y - 1500)
    x = 3000 - np.sqrt(2500.0**2 - (z + 800) ** 2)
    length = np.sqrt(np.diff(x) ** 2 + np.diff(y) ** 2 + np.diff(z) ** 2).sum()
    assert math.isclose(world.truth["curve_length"]["Top", "F1"], length, rel_tol=1e-9)
    fault = triangulate_fault(world.faults["F1"]).vertices
    distance = np.hypot(fault[:, 0] - 3000, fault[:, 2] + 800)
    np.testing.assert_allclose(distance, 2500.0, rtol=1e-12)


# ---- the field -----------------------------------------------------------------------


def test_the_field_is_on_its_faults_between_its_walls():
    """Without smear a node is on the hanging wall, on the footwall, or on F1, at its own height."""
    world = synthetic.faulted_reservoir(n=121, smear=0)
    top = world.horizons["Top"]
    x, y = (a.ravel() for a in np.meshgrid(top.easting, top.northing))
    z, near = top.values.ravel(), np.abs(x - 2500.0) < 400.0
    hanging, foot = (world.truth["wall_at"]["Top", f"F1{s}"](x, y) for s in "+-")
    on_wall = np.isclose(z, hanging, atol=1e-9) | np.isclose(z, foot, atol=1e-9)
    assert (near & ~on_wall).sum() > 50  # in the gap
    fault = world.faults["F1"]
    axes = (-fault.elevation.values[:, 0], fault.northing.values[0])
    there = RegularGridInterpolator(axes, fault.easting.values)
    gap = near & ~on_wall
    assert np.abs(there(np.column_stack([-z, y])[gap]) - x[gap]).max() < 3.0
    assert (hanging < foot).all()
    assert ((z <= foot + 1e-9) & (z >= hanging - 1e-9))[near].all()


# ---- the files -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def make_files():
    """The script that writes data/synthetic_horizons, as a module."""
    specification = importlib.util.spec_from_file_location("make_files", FILES / "make.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_the_files_hold_these_worlds(make_files):
    assert {w.name for w in make_files.WORLDS} == {make.__name__ for make in WORLDS}
    for world in make_files.WORLDS:
        names = {path.stem for path in (FILES / world.name).glob("*.nc")}
        assert names == {*world.horizons, *world.faults}
        for name, da in world.horizons.items():
            path = FILES / world.name / f"{name}.nc"
            assert path.stat().st_size < 300_000
            read = geosurf.read_horizon(path)
            assert read.attrs["positive"] == "up"
            np.testing.assert_allclose(read.values, da.values, rtol=0, atol=1e-9)
            np.testing.assert_array_equal(read.easting, da.easting)
            np.testing.assert_array_equal(read.northing, da.northing)
        for name, ds in world.faults.items():
            read = triangulate_fault(geosurf.read_fault(FILES / world.name / f"{name}.nc"))
            assert read.name == name
            np.testing.assert_allclose(
                read.vertices, triangulate_fault(ds).vertices, rtol=0, atol=1e-9
            )


# ---- refusals ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "arguments", "message"),
    [
        ("tilted_planes", {"dip": 0}, r"dip of F1 is 0 degrees, expected 0.1 to 90"),
        ("tilted_planes", {"tilt": 12}, r"Base \(.* m\) is not above the bottom .*x = .*less"),
        ("noisy", {"amplitude": 50}, r"amplitude is 50 m, expected 0 or more and less"),
        ("dome_and_flat_fault", {"semi_axes": (2500, 9)}, r"semi_axes are \(2500, 9\).*Use"),
        ("egg_box", {"level": 0}, r"level is 0, expected between 0 \(saddles\) and 1"),
        ("listric", {"radius": 100}, r"radius is 100 m, expected 2300 to 3000"),
        ("faulted_reservoir", {"throw": 299}, r"throw is 299 m, expected 0 to 200"),
    ],
)
def test_impossible_worlds_are_refused(make, arguments, message):
    refused(InputError, message, lambda: getattr(synthetic, make)(**arguments))


@pytest.mark.parametrize("n_sheet", [1, 5, 64, 200])
def test_maps_are_smeared_where_sheets_meet_however_many_there_are(rng, n_sheet):
    values, width = rng.normal(size=(12, 10)), 1
    there = {k: np.ones(values.shape, dtype=bool) for k in range(n_sheet)}
    there[0][:, 6:] = False  # the first bit, which would run out first
    found = torn_horizon.smeared(values, there, width)
    padded = np.pad(values, width, mode="edge")
    for i, j in np.ndindex(values.shape):
        alone = values[i, j] if j not in (5, 6) else padded[i : i + 3, j : j + 3].mean()
        assert found[i, j] == pytest.approx(alone, rel=1e-12)


def _under(da) -> float:
    corners = triangulate_horizon(da).vertices[triangulate_horizon(da).triangles]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    return float((area * corners[:, :, 2].mean(axis=1)).sum())


def test_the_triangulated_dome_meets_its_zone_volume_with_order_two():
    errors = []
    for n in (17, 33, 65):
        world = synthetic.dome_and_flat_fault(n=n)
        west, east, south, north, bottom, _ = world.box
        below = _under(world.horizons["Top"]) - bottom * (east - west) * (north - south)
        errors.append(abs(below - world.truth["zone_volumes"]["below Top"]))
    assert np.allclose(np.divide(errors[:-1], errors[1:]), 4.0, rtol=0.02)
