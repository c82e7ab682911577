"""Throw along faults that turn back somewhere: it is read wherever that is not between walls."""

from __future__ import annotations

import re

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError
from geosurf.measure import separation
from geosurf.sheets.faults.fault_profile import overlapping, to_level
from tests.sheets.test_throw_turning import AXIS, RADIUS, cone

BOX = (0.0, 1000.0, 0.0, 1000.0, -2200.0, -1300.0)
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


def turn(a, b, c):
    """Sign of the turn from a over b to c."""
    return int(np.sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])))


def meet(a, b, c, d):
    """Whether two closed segments share a point."""
    if turn(a, b, c) * turn(a, b, d) > 0 or turn(c, d, a) * turn(c, d, b) > 0:
        return False
    return all(
        max(a[k], b[k]) >= min(c[k], d[k]) and max(c[k], d[k]) >= min(a[k], b[k]) for k in (0, 1)
    )


def holds(t, p):
    """Whether a triangle with an area holds a point."""
    turns = {turn(t[k], t[(k + 1) % 3], p) for k in range(3)}
    return turn(*t) != 0 and not {1, -1} <= turns


def test_triangles_overlap_where_edges_meet_or_one_holds_the_other():
    """On a small lattice, with many that touch or have no area."""
    rng, seen = np.random.default_rng(5), []
    for _ in range(40):
        one, others = rng.integers(0, 7, (3, 2)), rng.integers(0, 7, (30, 3, 2))
        found = overlapping(one.astype(float), others.astype(float)).tolist()
        for k, other in enumerate(others.tolist()):
            t = one.tolist()
            edges = [(t[i], t[i - 1], other[j], other[j - 1]) for i in range(3) for j in range(3)]
            truth = any(meet(*e) for e in edges) or holds(t, other[0]) or holds(other, t[0])
            assert (k in found) == truth
            seen.append(truth)
    assert 0.2 < np.mean(seen) < 0.9
