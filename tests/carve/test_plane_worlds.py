"""Planes that meet in one point or line but for the last digit: every unit is there, above 0."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geosurf import Scene, TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.carve.measures import exact_volume
from geosurf.errors import GeosurfWarning
from geosurf.model import Units
from tests import oracles
from tests.carve.half_spaces import Pieces
from tests.carve.plane_worlds import KINDS, check, corners_of, plane_world

THREE = [((0, 1, -1), 0), ((1, -1, 1), -2), ((2, 1, -2), 0)]
SHIFT = np.array([0.1, 0.2, 0.3])
BOX = tuple(np.array([-4, 4, -4, 4, -4, 4]) + np.repeat(SHIFT, 2))


def three_planes(shift=SHIFT):
    """Three planes that meet in a point of one wall, but for rounding."""
    return [
        TriSurface(f"P{k}", "fault", corners_of(*plane, True) + shift, [[0, 1, 2], [0, 2, 3]])
        for k, plane in enumerate(THREE)
    ]


# three of each kind; one world in six has a unit that is as thin as rounding
@pytest.mark.parametrize("seed", range(3 * len(KINDS)))
def test_units_are_those_of_rational_arithmetic(seed):
    assert check(seed) != "refused"


def test_three_planes_that_nearly_meet_on_a_wall_bound_a_unit_that_a_scene_warns_of():
    """The sum of its prisms is 0 in doubles; that of whole numbers is not."""
    scene = Scene({}, {s.name: s for s in three_planes()}, BOX)
    with pytest.warns(
        GeosurfWarning, match="thinner than the rounding error of coordinates .*'P0', 'P1'"
    ):
        units = scene.units
    (thin,), (warning,) = units.report["thin"], scene.warnings
    assert (warning.kind, warning.subject, warning.place) == ("thin unit", thin.name, thin.place)
    assert 0 < thin.volume == units[thin.name].volume < 1e-40
    np.testing.assert_allclose(thin.place, np.array([0, -4, -4]) + SHIFT, atol=5)
    assert min(unit.volume for unit in units.values()) > 0
    assert units.volume == pytest.approx(512, abs=1e-9)
    assert certify(scene.patches, units).ok


def test_a_scene_warns_of_inputs_that_a_repair_moved():
    world = plane_world(3396)  # one fault goes by an edge of the box, until it is moved by 70 µm
    scene = Scene({}, {s.name: s for s in world.surfaces}, world.box)
    with pytest.warns(GeosurfWarning, match="moved by up to .* float64 cannot represent"):
        report = scene.patches.report
    (warning,) = scene.warnings
    assert warning.kind == "moved"
    assert f"{report['largest_move']:.1e} m" in warning.effect
    given = {tuple(v) for s in world.surfaces for v in s.vertices.tolist()}
    assert warning.place in given
    assert warning.subject in [s.name for s in world.surfaces]


@pytest.mark.parametrize("seed", range(12))
def test_exact_volumes_are_determinants(seed):
    """Of any triangles, closed or not: coordinates of many sizes, whole numbers, far away."""
    rng = np.random.default_rng(seed)
    x = rng.integers(-3, 4, (6, 3)) * 10.0 ** rng.integers(-9, 10, (6, 1))
    x += rng.choice([0.0, 1e6], 3)
    x *= 10.0 ** rng.integers(-90, 90)
    t = rng.integers(0, 6, (9, 3))
    true = sum(oracles.determinant([oracles.rational(x)[k] for k in row]) for row in t.tolist()) / 6
    found = exact_volume(x, t)
    assert found == pytest.approx(float(true), rel=1e-15, abs=0)
    assert oracles.sign(found) == oracles.sign(true)


def test_a_unit_turned_inside_out_fails_the_certificate():
    patches = rebuild_surfaces([*three_planes(), *build_walls(BOX)])
    units = carve_units(patches)
    thin = units[units.report["thin"][0].name]
    turned = replace(thin, triangles=thin.triangles[:, ::-1])
    damaged = Units([turned if u is thin else u for u in units.values()], units.box)
    failed = [c for c in certify(patches, damaged).checks if not c.passed]
    assert "units are closed and oriented" in [c.name for c in failed]
    assert f"turned inside out: {thin.name}" in failed[0].detail


# ------------------------------------------------------------------ the oracle
def test_pieces_of_a_box():
    """A corner cut off, planes that only touch, and what is left add up."""
    box = (0.0, 2, 0, 2, 0, 2)
    corner = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    lid = [[0, 0, 2], [1, 0, 2], [0, 1, 2]]
    of = Pieces(box, [*corner, *lid])
    front, behind = of.split(of.box, of.plane(corner))
    assert of.volume(behind) == pytest.approx(1 / 6)
    assert of.volume(front) + of.volume(behind) == pytest.approx(8)
    assert of.split(front, of.plane(corner)) == (front, [])
    assert of.split(of.box, of.plane(lid)) == ([], of.box)
