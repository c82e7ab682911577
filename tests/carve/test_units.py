"""Closed units: volumes that are known, sealed shells, and leaks that are told."""

from __future__ import annotations

import itertools
import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings

from geosurf import (
    Scene,
    TriSurface,
    build_contacts,
    build_walls,
    carve_units,
    rebuild_surfaces,
    synthetic,
)
from geosurf.carve.certificate import certify
from geosurf.errors import GeometryError, InputError, OpenUnitError
from geosurf.model import Unit
from tests import laws, oracles
from tests.carve.test_certificate import assert_noticed
from tests.strategies import BOX, faulted_worlds, grid, level, soup, upright


def carve(surfaces, box=BOX):
    """Units of surfaces in a box, with all laws that hold for any."""
    patches = rebuild_surfaces([*surfaces, *build_walls(box)])
    units = carve_units(patches)
    laws.assert_volumes_add_up(units, box)
    west, east, south, north, bottom, top = box
    inside = (patches.vertices >= (west, south, bottom)) & (patches.vertices <= (east, north, top))
    triangles = patches.triangles[inside.all(axis=1)[patches.triangles].all(axis=1)]
    assert units.report["cells"] == oracles.n_cell(triangles)
    assert certify(patches, units).ok
    return units


def volumes(units):
    return {name: unit.volume for name, unit in units.items()}


def volume_on(units, zone, sides):
    """Volume of a zone on some sides of faults; a unit names those that bound it only."""
    mine = [u for u in units.values() if u.zone == zone and set(u.block.split()) <= set(sides)]
    assert mine, (zone, sides, list(units))
    return sum(u.volume for u in mine)


# --------------------------------------------------------------- what is known
@pytest.mark.parametrize("n", [2, 9])
@pytest.mark.parametrize(
    "offset", [(0.0, 0.0, 0.0), (456_123.0, 6_780_321.0, 0.0)], ids=["local", "UTM"]
)
@pytest.mark.parametrize("make", [synthetic.tilted_planes, synthetic.graben])
def test_planar_worlds_are_exact(make, n, offset):
    world = make(n=n, offset=offset)
    scene = Scene(world.horizons, world.faults, world.box)
    units = scene.units
    laws.assert_volumes_add_up(units, world.box)
    true = world.truth["volumes"]
    assert len(units) == len(true)
    for (zone, sides), volume in true.items():
        found = volume_on(units, zone, sides)
        # UTM nodes are rounded to 1e-9 m, and so is the truth at that place
        assert found == pytest.approx(volume, rel=1e-12 if not any(offset) else 1e-9), (zone, sides)
    for (horizon, fault), length in world.truth["curve_length"].items():
        assert scene.curves_between(horizon, fault).length >= length * (1 - 1e-12)
    assert certify(scene.patches, units).ok


@pytest.mark.parametrize("make", [synthetic.dome_and_flat_fault, synthetic.listric])
def test_curved_worlds_converge_with_order_two(make):
    errors = []
    for n in (9, 17, 33):
        world = make(n=n)
        units = Scene(world.horizons, world.faults, world.box).units
        laws.assert_volumes_add_up(units, world.box)
        true = world.truth["volumes"]
        errors.append(max(abs(volume_on(units, *key) - volume) for key, volume in true.items()))
    assert errors[0] > 0
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    assert ((ratios > 3.3) & (ratios < 4.8)).all(), (errors, ratios)


@given(faulted_worlds())
def test_zones_of_small_worlds_have_the_volumes_of_prisms(surfaces):
    """Volume above the first horizon: prisms over the pieces of its map, by the trapezium rule."""
    units = carve([s for s in surfaces if s.role != "wall"])
    above = sum(unit.volume for unit in units.values() if unit.zone_index == 0)
    assert above == pytest.approx(float(volume_above(surfaces[0])), rel=1e-12)


def volume_above(horizon) -> Fraction:
    """Volume in `BOX` above a horizon: each triangle's map is clipped to the box, exact."""
    west, east, south, north, _, top = (Fraction(v) for v in BOX)
    total = Fraction(0)
    for corners in horizon.vertices[horizon.triangles]:
        points = oracles.rational(corners)
        for normal, through in (
            ((1, 0, 0), (west, 0, 0)), ((-1, 0, 0), (east, 0, 0)),
            ((0, 1, 0), (0, south, 0)), ((0, -1, 0), (0, north, 0)),
        ):  # fmt: skip
            points = oracles.clip(points, normal, through)
        for b, c in itertools.pairwise(points):
            a = points[0]
            map_area = abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2
            total += map_area * (top - (a[2] + b[2] + c[2]) / 3)
    return total


# --------------------------------------------------------------------- names
@pytest.mark.parametrize("world", [synthetic.tilted_planes(n=9), synthetic.waves(21)])
def test_surfaces_that_bound_a_unit_are_those_of_its_triangles(world):
    """Found from faces, and no triangle is listed: a page asks for those of every unit."""
    units = Scene(world.horizons, world.faults, world.box).units
    found = {name: unit.bounded_by for name, unit in units.items()}
    shells, _ = next(iter(units.values()))._shell
    assert "in_full" not in shells.cells.__dict__
    for name, unit in units.items():
        rows = np.unique(unit.surface_of_triangle).tolist()
        assert found[name] == tuple(unit.surface_names[i] for i in rows)


def test_zones_and_blocks_have_names():
    units = carve([level("Top", 3), level("Base", 1), upright("F1", 1)])
    assert volumes(units) == {
        "above Top F1+": 60.0, "above Top F1-": 20.0, "Top/Base F1+": 24.0, "Top/Base F1-": 8.0,
        "below Base F1+": 60.0, "below Base F1-": 20.0,
    }  # fmt: skip
    unit = units["Top/Base", "F1+"]
    assert unit.zone_index == 1
    assert set(unit.bounded_by) == {"Top", "Base", "F1", "east", "north", "south"}
    assert unit.area == 2 * 12.0 + 2 * 8.0 + 2 * 6.0
    assert units.report["slits"] == {}
    with pytest.raises(KeyError, match=r"no unit 'Top'. The units are \['above Top F1\+'"):
        units["Top"]


# ------------------------------------------------------- faults that end, float


def test_floating_pieces_that_see_only_each_other():
    """Rays through them run along different axes, each through the other first."""
    corners = [
        [(0, 3, 1), (0, 2, 2), (1, 3, 0)],
        [(1, 1, 0), (2, 3, 2), (0, 1, 0)],
        [(1, 3, 0), (0, 3, 2), (1, 0, 2)],
    ]
    faults = [TriSurface(f"F{i}", "fault", of, [[0, 1, 2]]) for i, of in enumerate(corners)]
    box = (-1, 4, -1, 4, -1, 4)
    for order in itertools.permutations(faults):
        assert volumes(carve(order, box)) == {"box": 125.0}


# --------------------------------------------------------------------- horizons
def test_a_horizon_with_a_hole_leaks():
    top = level("Top", 3, n=7)
    faces = top.triangles[
        ~(np.abs(top.vertices[top.triangles].mean(axis=1)[:, :2] - 2.5) < 0.5).all(axis=1)
    ]
    torn = TriSurface("Top", "horizon", top.vertices, faces)
    assert len(faces) == top.n_triangle - 2
    with pytest.raises(OpenUnitError) as caught:
        carve([torn])
    words = str(caught.value)
    assert re.search(r"leak around horizon 'Top': 4 m of its rim are open", words), words
    place = re.search(r"E ([\d.]+), N ([\d.]+), elevation ([\d.]+)", words)
    x, y, z = map(float, place.groups())
    assert max(abs(x - 2.5), abs(y - 2.5)) == 0.5
    assert z == 3.0
    assert "Shrink the box" in words


def test_the_remedy_of_a_leak_fits_the_surface_that_the_horizon_ends_before():
    world = synthetic.graben(n=41)
    top, faults = world.horizons["Top"], world.faults
    near = (abs(top.easting - 1350) < 300) & (abs(top.northing - 2000) < 400)
    holed = Scene(world.horizons | {"Top": top.where(~near)}, faults, world.box)
    with pytest.raises(OpenUnitError, match=r"before fault 'F1' there\. Tear it there \(tear=True"):
        _ = holed.units
    assert holed.replace(tear=True).check().ok
    short = world.horizons | {"Top": top.sel(easting=slice(None, 4000.0))}
    ring = [(1000, 500), (4500, 500), (4500, 3500), (1000, 3500)]
    with pytest.raises(OpenUnitError, match="Shrink the area of interest to the horizon, or"):
        _ = Scene(short, faults, aoi=ring).units


def test_two_zones_of_one_name_are_refused():
    """One of them would be lost, since units go by name."""
    names = ("A", "B/C", "x", "A/B", "C")
    with pytest.raises(
        InputError, match=r"two zones would have the name 'A/B/C' because .* Rename one"
    ):
        carve([level(name, 4 - 0.5 * k) for k, name in enumerate(names)])


def test_refusals():
    with pytest.raises(GeometryError, match=r"surfaces include no walls.*build_walls\(box\)"):
        carve_units(rebuild_surfaces([level("Top", 3)]))


# ------------------------------------------------------------------ same answer


@settings(max_examples=10)
@given(faulted_worlds())
def test_map_areas_of_faces_are_those_of_all_triangles(surfaces):
    for unit in carve_units(rebuild_surfaces(surfaces)).values():
        assert unit.map_area == pytest.approx(Unit.map_area.func(unit), rel=1e-14)


@pytest.mark.parametrize("turns", [(1, 1), (1, -1), (1, 1, -1, 1)])
def test_a_fault_folded_onto_itself_has_the_same_units_beside_all_its_sheets(turns):
    """Slits, and faults that part the box: whichever way each sheet looks, also twice the same."""
    box = (0.0, 9.0, 0.0, 9.0, 0.0, 9.0)
    for corners, n_unit in (
        ([[2.0, 4, 2], [6, 4, 2], [3, 4, 7]], 1),
        ([[-9.0, 4, -9], [-9, 4, 60], [60, 4, -9]], 2),
    ):
        fault = soup("F1", [corners[::turn] for turn in turns])
        patches = rebuild_surfaces([fault, *build_walls(box)], self_intersections=True)
        units = carve_units(patches)
        assert len(units) == n_unit
        inside = (patches.vertices >= 0).all(axis=1) & (patches.vertices <= 9).all(axis=1)
        mine = (patches.surface_of_triangle == 0) & inside[patches.triangles].all(axis=1)
        assert mine.sum() % len(turns) == 0 < mine.sum()
        a, b, c = (patches.local[patches.triangles[mine, k]] for k in range(3))
        north = np.cross(b - a, c - a)[:, 1] > 0  # the front
        middle = {unit: units[unit].vertices[:, 1].mean() for unit in units}
        order = sorted(range(n_unit), key=lambda u: list(middle.values())[u])
        wanted = np.where(north[:, None], [[order[-1], order[0]]], [[order[0], order[-1]]])
        assert (units.sides[mine] == wanted).all()


def test_a_layer_is_as_thick_as_it_is_whatever_its_blocks_cover():
    """Mean thickness is that where a unit is, not over the whole model."""
    units = carve([level("Top", 2.0), level("Base", 0.5), upright("F1", 1.0)])
    layer = [name for name, unit in units.items() if unit.zone == "Top/Base"]
    assert len(layer) == 2
    thickness = units.table["thickness_mean"].sel(unit=layer)
    assert thickness.values == pytest.approx([1.5, 1.5], rel=1e-12)


# ---- Shells of a few units are those of all units, byte by byte, and list nothing else.


def test_shells_of_some_units_are_those_of_all():
    world = synthetic.graben(n=9)
    contacts = {"OWC": -2100.0}
    units = Scene(world.horizons, world.faults, world.box, contacts=contacts).units
    shells = next(iter(units.values()))._shell[0]
    some = np.arange(len(shells.volumes))[::3]
    found = [*shells.triangles_of(some)]
    assert "in_full" not in shells.cells.__dict__  # nothing else was listed
    for u, (x, triangles) in zip(some.tolist(), found, strict=True):
        whole = shells.triangles(u)
        assert x.tobytes() == whole[0].tobytes()
        assert triangles.tobytes() == whole[1].tobytes()


# ---- Horizons that the column took away where another surface goes on: names stay right there
BOX_CLIPPED_AWAY = (0.0, 3, 0, 3, -1, 3)
FLAT = np.full((5, 5), 1.0)


def horizon(name, z):
    return grid(name, z, corner=(-1.0, -1.0))


def bump(level):
    """A horizon at 0 that rises to a level, flat over two cells, above a flat one at 1."""
    z = np.zeros((5, 5))
    z[1:4, 1:3] = level
    return z


def carved(surfaces, contacts=None, column=None):
    levels, given = build_contacts(contacts or {}, BOX_CLIPPED_AWAY)
    patches = rebuild_surfaces([*surfaces, *levels, *build_walls(BOX_CLIPPED_AWAY)])
    return patches, carve_units(patches, column, given)


@pytest.mark.parametrize("level", [2.0, 3.0])
@pytest.mark.parametrize("beside", ["nothing", "contact", "fault"])
def test_an_older_horizon_is_taken_away_beside_a_wall_contact_or_fault(level, beside):
    """At 3 it lies on the lid of the box, at 2 on the contact or fault."""
    surfaces = [horizon("Top", FLAT), horizon("Base", bump(level))]
    if beside == "fault":
        plane = [[-1, -1, 2], [4, -1, 2], [4, 4, 2], [-1, 4, 2]]
        surfaces.append(TriSurface("F1", "fault", plane, [[0, 1, 2], [0, 2, 3]]))
    patches, units = carved(surfaces, {"OWC": 2.0} if beside == "contact" else None)
    assert certify(patches, units).ok, str(certify(patches, units))
    above = sum(unit.volume for unit in units.values() if unit.zone == "above Top")
    assert above == pytest.approx(3 * 3 * 2)


def test_wrong_zones_are_still_noticed_there():
    surfaces = [horizon("Top", FLAT), horizon("Base", bump(3.0))]
    assert_noticed([*surfaces, *build_walls(BOX_CLIPPED_AWAY)])
