"""Names of blocks: from the sides of faults that a unit sees, by size and place where none do."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.blocks import name_blocks
from tests.carve.test_units import level, upright, volumes
from tests.strategies import BOX, sheet


def carve(*surfaces):
    return carve_units(rebuild_surfaces([*surfaces, *build_walls(BOX)]))


def turned_over(surface):
    return TriSurface(surface.name, surface.role, surface.vertices, surface.triangles[:, [0, 2, 1]])


def both(name, one, two):
    """Two sheets as one surface."""
    vertices = np.concatenate([one.vertices, two.vertices])
    triangles = np.concatenate([one.triangles, two.triangles + one.n_vertex])
    return TriSurface(name, one.role, vertices, triangles)


def test_a_horizon_may_be_wound_either_way():
    top, base = level("Top", 3, n=4), level("Base", 1)
    expected = volumes(carve(top, base))
    assert expected == {"above Top": 80.0, "Top/Base": 32.0, "below Base": 80.0}
    assert volumes(carve(turned_over(top), base)) == expected
    assert volumes(carve(turned_over(top), turned_over(base))) == expected


def test_a_fault_that_is_turned_over_exchanges_its_sides():
    fault = upright("F1", 1)
    assert volumes(carve(fault)) == {"box F1-": 48.0, "box F1+": 144.0}
    assert volumes(carve(turned_over(fault))) == {"box F1+": 48.0, "box F1-": 144.0}


def test_a_unit_around_the_end_of_a_fault_is_on_neither_side():
    """F1 goes on through F2 and ends beyond: there it parts nothing, and names nothing."""
    across = sheet("F2", [(-1, 2, -5), (5, 2, -5), (5, 2, 9), (-1, 2, 9)])
    found = volumes(carve(upright("F1", 1, y=(-1, 3)), across))
    assert found == {"box F1- F2+": 24.0, "box F1+ F2+": 72.0, "box F2-": 96.0}


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


@pytest.mark.parametrize("x", [0.5, 3])
def test_a_slit_of_a_fault_takes_no_side_from_the_unit_that_holds_it(x):
    """A piece of F1 floats in a block that another piece of it bounds."""
    piece = upright("F1", x, y=(1, 2), z=(0, 1))
    units = carve(both("F1", upright("F1", 1), piece))
    assert volumes(units) == {"box F1-": 48.0, "box F1+": 144.0}
    assert units.report["slits"] == {"F1": pytest.approx(1.0)}


@pytest.mark.parametrize("larger", [0, 1])
def test_rounding_of_volumes_ranks_nothing(larger):
    """Two remnants are equal but for their last bit: the western one comes first."""
    volume = [1 / 3, 1 / 3]
    volume[larger] = np.nextafter(volume[larger], 1.0)
    corners = [(2.0, 0.0, 0.0), (1.0, 0.0, 0.0)]
    zone = np.zeros(2, dtype=np.int64)
    found = name_blocks([("F1+",)] * 2, zone, volume, lambda u: corners[u])
    assert found == ["F1+ #2", "F1+"]
    clear = [volume[0], volume[1] * (1.001 if larger else 0.999)]
    found = name_blocks([("F1+",)] * 2, zone, clear, lambda u: corners[u])
    assert found == (["F1+ #2", "F1+"] if larger else ["F1+", "F1+ #2"])
