"""The certificate must fail, on the right line, for results that are damaged."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from geosurf import Scene, build_walls, carve_units, rebuild_surfaces
from geosurf.arrangement import threads
from geosurf.carve.certificate import certify, same_bytes
from geosurf.carve.certificate_facts import Facts
from geosurf.carve.certificate_lines import partition
from geosurf.carve.certificate_names import named
from geosurf.carve.certificate_shells import matched_lists, weld_lists
from geosurf.carve.shells import unit_name
from geosurf.errors import InputError
from geosurf.model import Units
from geosurf.model.column import names_of_zones
from tests.rebuild.worlds import boxed_world
from tests.strategies import BOX, faulted_worlds, grid, level, sheet

CLOSED, VOLUMES = "units are closed and oriented", "volumes add up to the box"
CROSSES, PARENTS = "surfaces meet only along shared edges", "triangles lie on their input triangles"
AREAS, FACING = "areas add up", "triangles keep the orientation of their input"
SHARED = "units share the surfaces' vertices"
DIVIDE, NAMED = "units fill the box without overlap", "unit names match their bounding surfaces"


@pytest.fixture(scope="module")
def patches():
    rng = np.random.default_rng(2)
    top = grid("Top", rng.integers(0, 3, (4, 4)), spacing=2.0, corner=(-1.0, -1.0))
    return rebuild_surfaces(
        [top, sheet("F1", [(1, -1, -5), (1, 5, -5), (3, 5, 9), (3, -1, 9)]), *build_walls(BOX)]
    )


@pytest.fixture(scope="module")
def units(patches):
    return carve_units(patches)


def failed(certificate):
    assert certificate.ok == all(check.passed for check in certificate.checks)
    assert [line[:4] for line in str(certificate).splitlines()] == [
        "pass" if c.passed else "FAIL" for c in certificate.checks
    ]
    return {check.name for check in certificate.checks if not check.passed}


def inner_row(patches):
    """A triangle of Top, and one of its corners inside the box that is only on Top."""
    others = np.unique(patches.triangles[patches.surface_of_triangle != 0])
    for row in np.flatnonzero(patches.surface_of_triangle == 0):
        for vertex in patches.triangles[row]:
            inside = (np.abs(patches.local[vertex, :2] - 2.0) < 2.0).all()
            if inside and vertex not in others:
                return row, vertex
    raise AssertionError("Top has no vertex of its own in the box")


def test_a_sound_model_passes(patches, units):
    certificate = certify(patches, units)
    assert failed(certificate) == set()
    names = [CLOSED, VOLUMES, SHARED, DIVIDE, NAMED, CROSSES, PARENTS, FACING, AREAS]
    assert [c.name for c in certificate.checks] == names
    assert same_bytes(patches, patches).passed


def moved_by(up):
    def damaged(patches, row, vertex):
        local = patches.local.copy()
        local[vertex, 2] += up
        return patches.changed(local=local)

    return damaged


def turned(patches, row, vertex):
    triangles = patches.triangles.copy()
    triangles[row] = triangles[row, ::-1]
    return patches.changed(triangles=triangles)


def of_another_parent(patches, row, vertex):
    parent = patches.parent_of_triangle.copy()
    parent[row] = (parent[row] + 5) % patches.sources[0].n_triangle
    return patches.changed(parent_of_triangle=parent)


DAMAGES = [(moved_by(up), {PARENTS}) for up in (1e-9, 1e-3, 0.5)]
DAMAGES += [(moved_by(-20.0), {CROSSES}), (turned, {FACING}), (of_another_parent, {PARENTS, AREAS})]


@pytest.mark.parametrize(("damage", "lines"), DAMAGES)
def test_a_damaged_mesh_fails_on_a_line_that_says_so(patches, damage, lines):
    damaged = damage(patches, *inner_row(patches))
    assert lines & failed(certify(damaged))
    assert not same_bytes(patches, damaged).passed


def test_a_dropped_triangle_opens_a_unit(patches, units):
    name, unit = next(iter(units.items()))
    torn = replace(unit, triangles=unit.triangles[1:])
    damaged = Units([torn, *(u for n, u in units.items() if n != name)], units.box)
    certificate = certify(patches, damaged)
    assert failed(certificate) == {CLOSED, VOLUMES, DIVIDE}
    assert f"3 open edges in {name}" in str(certificate)


def exchanged(units, **of_unit):
    """Units, some of them with other attributes: name of the unit -> attributes."""
    return Units([replace(u, **of_unit.get(n, {})) for n, u in units.items()], units.box)


def labels(unit):
    names = ("name", "zone", "zone_index", "block", "contact", "fault_sides")
    return {name: getattr(unit, name) for name in names}


def test_a_wrong_volume(patches, units):
    name, unit = next(iter(units.items()))
    for wrong in (1 - 1e-10, 1 + 1e-10, 2.0):
        damaged = exchanged(units, **{name: {"volume": unit.volume * wrong}})
        assert failed(certify(patches, damaged)) == {VOLUMES}


def test_a_wrong_volume_of_a_unit_that_is_tiny_beside_the_box():
    """Of the box it is a part in 1e14: whether it is right is a matter of its own size."""
    levels = level("Top", 0.0), level("Base", -(2.0**-43))
    patches = rebuild_surfaces([*levels, *build_walls(BOX)])
    units = carve_units(patches)
    assert failed(certify(patches, units)) == set()
    thin = units["Top/Base"]
    assert thin.volume == pytest.approx(16 * 2.0**-43, rel=0.01)
    damaged = exchanged(units, **{thin.name: {"volume": 2 * thin.volume}})
    assert failed(certify(patches, damaged)) == {VOLUMES}


def test_a_wrong_area_of_a_shell_and_another_box(patches, units):
    name, unit = next(iter(units.items()))
    damaged = exchanged(units, **{name: {"area": unit.area * (1 + 1e-9)}})
    certificate = certify(patches, damaged)
    assert failed(certificate) == {VOLUMES}
    assert f"the stated volume or area of {name} differs from its shell" in str(certificate)
    west, east, *rest = units.box
    certificate = certify(patches, Units(units.values(), (west + 1, east + 1, *rest)))
    assert failed(certificate) == {VOLUMES}
    assert "the stated box differs from the walls" in str(certificate)


@pytest.mark.parametrize("pair", [(0, 1), (0, 2), (1, 2), (0, 3)])
def test_units_that_have_each_others_names(patches, units, pair):
    one, two = (list(units.values())[i] for i in pair)
    damaged = exchanged(units, **{one.name: labels(two), two.name: labels(one)})
    certificate = certify(patches, damaged)
    assert failed(certificate) == {NAMED}
    assert one.name in str(certificate)
    only = exchanged(units, **{one.name: {"name": two.name}, two.name: {"name": one.name}})
    assert failed(certify(patches, only)) == {NAMED}


def fits(patches, units):
    """Whether names of units are found to be right; shells are whole."""
    facts = Facts.of(patches.changed())
    found = matched_lists(patches, units, weld_lists(patches, units)[1])
    divided = partition(facts, units, found).passed
    assert divided
    return named(facts, units, found, divided).passed


@settings(max_examples=12)
@given(faulted_worlds())
def test_every_wrong_side_of_a_fault_and_every_wrong_zone_is_noticed(surfaces):
    assert_noticed(surfaces)


# faults that hang in a unit, in two, in none, and bound others; also on walls and on each other
@pytest.mark.parametrize("seed", [258, 322, 340, 352, 368, 333])
def test_every_wrong_side_of_a_fault_that_hangs_in_a_unit_is_noticed(seed):
    assert_noticed([*boxed_world(seed), *build_walls(BOX)])


def assert_noticed(surfaces):
    """A side more or less for each unit, and each other zone in its name."""
    patches = rebuild_surfaces(surfaces, self_intersections=True)
    units = carve_units(patches)
    zones = names_of_zones([s.name for s in patches.sources if s.role == "horizon"])
    sides = [s.name + sign for s in patches.sources if s.role == "fault" for sign in "+-"]
    assert fits(patches, units)
    for name, unit in units.items():
        damages = [
            {
                "fault_sides": tuple(
                    side for side in sides if (side in unit.fault_sides) != (side == other)
                )
            }
            for other in sides
        ]
        for k, zone in enumerate(zones):
            words = {"zone": zone, "zone_index": k, "name": unit_name(zone, unit.block, "")}
            if words["name"] not in units:
                damages.append(words)
        for damage in damages:
            assert not fits(patches, exchanged(units, **{name: damage})), (name, damage)


def wedge(way):
    """Two faults that meet between two horizons, and close a wedge up (1) or down (-1); a lid on
    its tip.
    """
    surfaces = [level("Top", 5.0), level("Base", -1.0)]
    for name, x in (("F1", -0.25), ("F2", 4.25)):
        end = 2 + 9 * way
        surfaces.append(sheet(name, [(2, -1, 2), (2, 5, 2), (x, 5, end), (x, -1, end)]))
    lid = [(x, y, 2 + 2 * way) for x, y in ((1.5, -1), (2.5, -1), (2.5, 5), (1.5, 5))]
    return [*surfaces, sheet("Lid", lid), *build_walls(BOX)]


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("lidded", [False, True])
def test_a_zone_that_no_horizon_around_a_unit_tells_is_told_by_its_neighbours(way, lidded):
    """A unit that touches no Base, or no Top, named as if it lay beyond it, and blocks to match."""
    patches = rebuild_surfaces([s for s in wedge(way) if lidded or s.name != "Lid"])
    units = carve_units(patches)
    assert fits(patches, units)
    inner = [u for u in units.values() if u.zone == "Top/Base"]
    zone, index, far = ("below Base", 2, "Base") if way > 0 else ("above Top", 0, "Top")
    moved = [u for u in inner if patches.names.index(far) not in u.surface_of_triangle]
    assert len(moved) == 1 + lidded
    for unit in moved:
        words = {"zone": zone, "zone_index": index, "block": "whole #2", "fault_sides": ()}
        damage = {unit.name: {**words, "name": unit_name(zone, "whole #2")}}
        others = [u for u in inner if u is not unit]
        left = {side for u in others for side in u.fault_sides}
        for other in others:
            opposite = {side: side[:-1] + "-+"[side[-1] == "-"] for side in other.fault_sides}
            sides = tuple(side for side in other.fault_sides if opposite[side] in left)
            block = " ".join(sides) or "whole"
            named_anew = {
                "block": block,
                "fault_sides": sides,
                "name": unit_name(other.zone, block),
            }
            damage[other.name] = named_anew
        assert not fits(patches, exchanged(units, **damage)), damage


def test_fluids_that_have_each_others_names():
    scene = Scene({"Top": level("Top", 3)}, box=BOX, contacts={"GOC": 1.0, "OWC": -1.0})
    assert failed(certify(scene.patches, scene.units)) == set()
    parts = ["below Top above GOC", "below Top GOC/OWC", "below Top below OWC"]
    for one, two in itertools.combinations((scene.units[name] for name in parts), 2):
        damaged = exchanged(scene.units, **{one.name: labels(two), two.name: labels(one)})
        assert failed(certify(scene.patches, damaged)) == {NAMED}


def test_a_shell_with_a_triangle_of_another_surface(patches, units):
    name, unit = next(iter(units.items()))
    other = unit.surface_of_triangle.copy()
    other[0] = (other[0] + 1) % len(unit.surface_names)
    certificate = certify(patches, exchanged(units, **{name: {"surface_of_triangle": other}}))
    assert failed(certificate) == {DIVIDE}
    assert f"1 triangles: the first, of {name} at (" in str(certificate)
    assert "is not a triangle of its surface" in str(certificate)


def test_a_gap_as_large_as_an_overlap():
    """Closed shells whose volumes add up, and yet one place is in two units and one in none."""
    floors = [level(f"H{k}", z) for k, z in enumerate((6, 4, 2, 0))]
    patches = rebuild_surfaces([*floors, *build_walls(BOX)])
    units = carve_units(patches)
    one, two = units["H0/H1"], units["H2/H3"]
    assert one.volume == two.volume
    shell = {name: getattr(two, name) for name in ("local", "triangles", "surface_of_triangle")}
    certificate = certify(patches, exchanged(units, **{one.name: shell}))
    assert failed(certificate) == {DIVIDE, NAMED}
    assert "has two units on one side" in str(certificate)


def test_a_certificate_beyond_what_is_free_is_an_error_with_numbers(patches, units, monkeypatch):
    monkeypatch.setattr(threads, "_SMALL", 0)
    monkeypatch.setattr(threads, "free_memory", lambda: 20_000)
    with pytest.raises(InputError, match=r"triangles needs .* GB are free\. Check"):
        certify(patches, units)
    monkeypatch.setattr(threads, "free_memory", lambda: 10**9)
    assert certify(patches, units).ok
