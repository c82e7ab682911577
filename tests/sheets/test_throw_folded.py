"""Throw along faults that turn back somewhere: it is read wherever that is not between walls."""

from __future__ import annotations

import re

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError
from geosurf.measure import separation
from geosurf.sheets.faults.fault_profile import to_level
from tests.sheets.test_throw_turning import AXIS, RADIUS, cone

THROW = 50.0
COT = 1.0 / np.tan(np.radians(60.0))


def turned(surface):
    """Elevations of the corners of triangles that face against the dip (n, 3)."""
    corners = surface.vertices[surface.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    mean = normals.sum(axis=0)
    return corners[normals[:, :2] @ mean[:2] <= 0][:, :, 2]


# ------------------------------------------------------------- on a cone, with exact cut-offs
PHI = np.linspace(-0.6, 0.6, 241)


def on_cone(phi, z, aside=0.0):
    """Points (n, 3) of the cone, or of a larger or smaller one."""
    r = RADIUS + COT * (-1800.0 - z) + aside
    return np.column_stack([AXIS[0] + r * np.cos(phi), AXIS[1] + r * np.sin(phi), z])


def cutoffs():
    """Where a plane meets the cone, and the same moved down its dip: (hanging wall, footwall)."""
    step = -0.2 * np.sin(PHI)  # z is -1800 + step * r
    z = -1800.0 + step * RADIUS / (1.0 + step * COT)
    return [on_cone(PHI, z - THROW)], [on_cone(PHI, z)]


def with_turned(low, phi=0.3):
    """The cone, and a long triangle beside it that turns back: from its point at `low` upward."""
    whole = gs.triangulate_fault(cone(), name="F1")
    more = on_cone(np.array([phi, phi - 0.05, phi + 0.05]), np.array([low, -1460.0, -1460.0]), 30.0)
    n = whole.n_vertex
    faces = np.vstack([whole.triangles, [[n, n + 1, n + 2]]])
    found = gs.TriSurface("F1", "fault", np.vstack([whole.vertices, more]), faces)
    if len(turned(found)) == 0:
        found = gs.TriSurface("F1", "fault", found.vertices, [*faces[:-1], [n, n + 2, n + 1]])
    assert len(turned(found)) == 1
    return found


def read(surface):
    """Throw between the exact cut-offs, by lines down the dip."""
    hanging, foot = cutoffs()
    level = to_level(surface, THROW, 25.0, -1820.0, hanging, foot)
    return separation(hanging, foot, 90.0, level=level)


@pytest.mark.parametrize("low", [-1600.0, -1840.0])
def test_a_part_that_turns_back_beyond_the_cutoffs_at_its_place_changes_no_throw(low):
    """Cut-offs are at -1855 m and -1905 m there, up to -1705 m elsewhere."""
    found = read(with_turned(low))
    assert found.sizes["point"] > 400
    assert (float(found.footwall_elevation.max()) > low) == (low < -1710.0)
    assert np.abs(found.throw - THROW).max() < 0.02


@pytest.mark.parametrize("low", [-1870.0, -2100.0])
def test_a_part_that_turns_back_between_the_cutoffs_is_refused_with_its_place(low):
    with pytest.raises(GeometryError, match=r"'F1' turns back .* between its cut-offs") as caught:
        read(with_turned(low))
    here = on_cone(np.array([0.3]), np.array([-1870.0]))[0]
    assert np.linalg.norm(np.array(caught.value.place) - here) < 60.0
    share = float(re.search(r"on ([\d.]+) % of their length", str(caught.value))[1])
    assert 0.0 < share < 8.5  # the triangle is 0.1 of 1.2 wide
