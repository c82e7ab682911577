"""The certificate must fail, on the right line, for results that are damaged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geosurf import build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify, crossing_pairs, same_bytes
from geosurf.model import Units
from tests.strategies import BOX, grid, sheet

CLOSED, VOLUMES = "units are closed and oriented", "volumes add up to the box"
CROSSES, PARENTS = "nothing crosses between curves", "triangles lie on their parents"
AREAS, FACING = "areas add up", "triangles face as their parents do"
SHARED = "units share the surfaces' vertices"


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
    lines = str(certificate).splitlines()
    assert [line[:4] for line in lines] == [
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


def with_local(patches, vertex, move):
    local = patches.local.copy()
    local[vertex] += move
    return patches.changed(local=local)


def without(patches, row):
    keep = np.arange(patches.n_triangle) != row
    return patches.changed(
        triangles=patches.triangles[keep],
        surface_of_triangle=patches.surface_of_triangle[keep],
        parent_of_triangle=patches.parent_of_triangle[keep],
        patch_of_triangle=patches.patch_of_triangle[keep],
    )


def test_a_sound_model_passes(patches, units):
    certificate = certify(patches, units)
    assert failed(certificate) == set()
    names = [CLOSED, VOLUMES, SHARED, CROSSES, PARENTS, FACING, AREAS]
    assert [c.name for c in certificate.checks] == names
    assert same_bytes(patches, patches).passed


@pytest.mark.parametrize("move", [1e-9, 1e-3, 0.5])
def test_a_moved_vertex(patches, move):
    _, vertex = inner_row(patches)
    damaged = with_local(patches, vertex, (0.0, 0.0, move))
    assert PARENTS in failed(certify(damaged))
    assert not same_bytes(patches, damaged).passed


def test_a_vertex_moved_in_its_plane(patches):
    """Off its edge, not off its plane: areas and sides tell."""
    row, vertex = inner_row(patches)
    middle = patches.local[patches.triangles[row]].mean(axis=0)
    damaged = with_local(patches, vertex, 0.25 * (middle - patches.local[vertex]))
    assert failed(certify(damaged)) & {PARENTS, AREAS}


def test_a_vertex_moved_through_another_surface(patches):
    _, vertex = inner_row(patches)
    damaged = with_local(patches, vertex, (0.0, 0.0, -20.0))
    assert CROSSES in failed(certify(damaged))


def test_a_dropped_triangle(patches):
    row, _ = inner_row(patches)
    assert AREAS in failed(certify(without(patches, row)))


def test_a_dropped_triangle_opens_a_unit(patches, units):
    name, unit = next(iter(units.items()))
    torn = replace(unit, triangles=unit.triangles[1:])
    damaged = Units([torn, *(u for n, u in units.items() if n != name)], units.box)
    certificate = certify(patches, damaged)
    assert failed(certificate) == {CLOSED, VOLUMES}
    assert f"3 open edges in {name}" in str(certificate)


def test_a_turned_triangle_in_the_mesh(patches):
    row, _ = inner_row(patches)
    triangles = patches.triangles.copy()
    triangles[row] = triangles[row, ::-1]
    assert failed(certify(patches.changed(triangles=triangles))) == {FACING}


def test_a_stretched_shell(patches, units):
    name, unit = next(iter(units.items()))
    stretched = replace(unit, local=unit.local * [1.0, 1.0, 1.5])
    damaged = Units([stretched, *(u for n, u in units.items() if n != name)], units.box)
    assert failed(certify(patches, damaged)) == {VOLUMES, SHARED}


def test_a_turned_triangle_in_a_unit(patches, units):
    name, unit = next(iter(units.items()))
    faces = unit.triangles.copy()
    faces[0] = faces[0, ::-1]
    turned = replace(unit, triangles=faces)
    damaged = Units([turned, *(u for n, u in units.items() if n != name)], units.box)
    assert failed(certify(patches, damaged)) == {CLOSED, VOLUMES}


def test_a_missing_unit(patches, units):
    damaged = Units(list(units.values())[1:], units.box)
    assert failed(certify(patches, damaged)) == {VOLUMES}


def test_a_wrong_volume(patches, units):
    name, unit = next(iter(units.items()))
    wrong = replace(unit, volume=unit.volume * (1 + 1e-10))
    damaged = Units([wrong, *(u for n, u in units.items() if n != name)], units.box)
    assert failed(certify(patches, damaged)) == {VOLUMES}


def test_a_wrong_parent(patches):
    row, _ = inner_row(patches)
    parent = patches.parent_of_triangle.copy()
    parent[row] = (parent[row] + 5) % patches.sources[0].n_triangle
    assert {PARENTS, AREAS} & failed(certify(patches.changed(parent_of_triangle=parent)))


def test_surfaces_that_were_not_rebuilt_cross():
    top = grid("Top", np.zeros((3, 3)), spacing=2.0)
    wall = sheet("F1", [(1, -1, -1), (1, 5, -1), (1, 5, 1), (1, -1, 1)])
    x = np.concatenate([top.vertices, wall.vertices])
    t = np.concatenate([top.triangles, wall.triangles + len(top.vertices)])
    pairs = crossing_pairs(x, t)
    assert len(pairs) > 0
    assert (pairs.max(axis=1) >= top.n_triangle).all()


def test_a_gap_of_one_bit_is_no_crossing_and_an_overlap_of_one_bit_is():
    flat = np.array([[0.0, 0, 1], [4, 0, 1], [0, 4, 1]])
    for z, n in ((np.nextafter(1.0, 2.0), 0), (1.0, 1), (np.nextafter(1.0, 0.0), 1)):
        tip = np.array([[1.0, 1, z], [1, 1, 3], [2, 1, 3]])
        pairs = crossing_pairs(np.concatenate([flat, tip]), np.arange(6).reshape(2, 3))
        assert len(pairs) == n
