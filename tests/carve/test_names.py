"""Names of blocks: from the sides of faults that a unit sees, by size and place where none do."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from geosurf import TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.model import FluidContact, Units
from tests.carve.test_units import volumes
from tests.strategies import BOX, grid, level, sheet, upright


def carve(*surfaces):
    return carve_units(rebuild_surfaces([*surfaces, *build_walls(BOX)]))


def turned_over(surface):
    return TriSurface(surface.name, surface.role, surface.vertices, surface.triangles[:, [0, 2, 1]])


def scissors(y, shift, x=2.0, z=2.0):
    """A horizon that is torn at x, and moved there by shift: up on its east, down on its west."""
    n = len(y)
    rows = np.concatenate(
        [
            [(-1.0, at, z) for at in y],
            [(x, at, z - by) for at, by in zip(y, shift, strict=True)],
            [(x, at, z + by) for at, by in zip(y, shift, strict=True)],
            [(5.0, at, z) for at in y],
        ]
    )
    lower = np.arange(n - 1)
    strips = [
        np.stack([lower + a, lower + a + n, lower + a + n + 1, lower + a + 1], axis=1)
        for a in (0, 2 * n)
    ]
    quads = np.concatenate(strips)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    vertices, number = np.unique(rows, axis=0, return_inverse=True)
    return TriSurface("Top", "horizon", vertices, number[triangles])


def test_a_unit_that_sees_both_sides_of_a_fault_is_on_neither():
    """It goes around the end of F1, and throw of either sign puts other units across from it."""
    top = scissors([-1.0, 2.0, 2.5, 3.0, 5.0], [1.5, 0.0, -0.25, 0.0, 0.0])
    across = sheet("F2", [(-1, 1, -5), (5, 1, -5), (5, 1, 9), (-1, 1, 9)])
    units = carve(top, upright("F1", 2, y=(-1, 3)), across)
    assert set(units) == {
        f"{zone} {block}"
        for zone in ("above Top", "below Top")
        for block in ("F1+ F2+", "F1- F2+", "F2-")
    }
    assert sum(unit.volume for unit in units.values()) == pytest.approx(units.box_volume)


# ------------------------------------------------------------- faults that coincide
def wall(name, south, north, turned=False):
    """Part of the plane x = 1: its front looks east."""
    found = sheet(name, [(1, south, -5), (1, north, -5), (1, north, 9), (1, south, 9)])
    return turned_over(found) if turned else found


def sound(surfaces):
    """Volume and sides of faults of each unit, certified."""
    patches = rebuild_surfaces([*surfaces, *build_walls(BOX)])
    units = carve_units(patches)
    assert certify(patches, units).ok
    return {name: (round(unit.volume, 9), unit.fault_sides) for name, unit in units.items()}


ALL, SOUTH, NORTH = (-1, 5), (-1, 3), (2, 5)
COINCIDING = [(ALL, ALL), (SOUTH, NORTH), (ALL, NORTH), (SOUTH, ALL)]


@pytest.mark.parametrize(("one", "two"), COINCIDING)
@pytest.mark.parametrize("turned", [(False, False), (True, False), (False, True), (True, True)])
def test_faults_that_coincide_have_a_side_each(one, two, turned):
    a, b = ("-" if way else "+" for way in turned)
    c, d = ("+" if way else "-" for way in turned)
    faults = [wall("F1", *one, turned[0]), wall("F2", *two, turned[1])]
    east, west = (f"F1{a}", f"F2{b}"), (f"F1{c}", f"F2{d}")
    expected = {f"box {' '.join(east)}": (144.0, east), f"box {' '.join(west)}": (48.0, west)}
    assert sound(faults) == expected
    assert sound(faults[::-1]) == expected


@pytest.mark.parametrize("turned", [False, True])
def test_a_side_that_a_name_leaves_out_or_exchanges_is_seen(turned):
    """Of all units at once, and in their names and sides of faults alike."""
    patches = rebuild_surfaces([wall("F1", *SOUTH), wall("F2", *NORTH, turned), *build_walls(BOX)])
    units = carve_units(patches)
    for signs in ({"F2+": "", "F2-": ""}, {"F2+": "F2-", "F2-": "F2+"}):
        wrong = []
        for unit in units.values():
            sides = tuple(filter(None, (signs.get(side, side) for side in unit.fault_sides)))
            block = " ".join(sides)
            wrong.append(replace(unit, name=f"box {block}", block=block, fault_sides=sides))
        found = certify(patches, Units(wrong, units.box))
        assert [check.name for check in found.checks if not check.passed] == [
            "unit names match their bounding surfaces"
        ]


def test_levels_that_coincide_may_be_wound_either_way():
    """Base meets Top in the west; a fluid contact meets Base all over the east."""
    top = grid("Top", np.tile([2.0, 2.0, 2.0, 2.0], (4, 1)), spacing=2.0, corner=(-1.0, -1.0))
    base = grid("Base", np.tile([2.0, 2.0, 0.0, 0.0], (4, 1)), spacing=2.0, corner=(-1.0, -1.0))
    water = level("OWC", 0, role="contact")
    entry = FluidContact(0.0, name="OWC")
    expected = None
    for ways in itertools.product((False, True), repeat=3):
        levels = [
            turned_over(s) if way else s for s, way in zip((top, base, water), ways, strict=True)
        ]
        patches = rebuild_surfaces([*levels, *build_walls(BOX)])
        units = carve_units(patches, contacts=[entry])
        assert certify(patches, units).ok
        found = volumes(units)
        expected = expected or found
        assert found == pytest.approx(expected)
    assert sum(expected.values()) == pytest.approx(192.0)
    assert {name for name in expected if name.startswith("Top/Base")} == {"Top/Base above OWC"}
