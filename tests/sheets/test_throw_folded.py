"""Throw along faults that turn back somewhere: it is read wherever that is not between walls."""

from __future__ import annotations

import re

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeometryError
from geosurf.measure import separation
from geosurf.sheets.faults.fault_profile import overlapping, to_level
from tests.sheets.test_throw_turning import AXIS, RADIUS, cone

BOX = (0.0, 1000.0, 0.0, 1000.0, -2200.0, -1300.0)
THROW = 50.0
COT = 1.0 / np.tan(np.radians(60.0))
S = np.linspace(0.0, 1000.0, 9)  # where dip lines of the fault start, from south to north
FLAT = {"units": "m", "positive": "up"}


def east(z):
    """Where the plane of the fault is."""
    return 500.0 + COT * (-1800.0 - z)


def fault(notch, lower=-2100.0):
    """A plane that dips east, whose dip lines were continued upward, two of them past each other.

    The top of the line in the middle is at the elevation `notch`, all others at -1660 m. That line
    and the next swap their order along strike on their way to -1350 m, and keep clear of each
    other: one passes to the east. So one long triangle of the strip turns back.
    """
    low, top = np.full(9, lower), np.full(9, -1660.0)
    top[4] = notch
    rim, tip = S.copy(), np.full(9, -1350.0)
    tip_s, aside = S.copy(), np.zeros(9)
    tip_s[4], tip_s[5], aside[4], aside[5] = 640.0, 560.0, -40.0, 40.0
    points = np.concatenate(
        [
            np.column_stack([east(low), S, low]),
            np.column_stack([east(top), rim, top]),
            np.column_stack([east(tip) + aside, tip_s, tip]),
        ]
    )
    k = np.arange(8)
    faces = [
        part
        for n in (0, 9)
        for part in (np.c_[k + n, k + n + 1, k + n + 10], np.c_[k + n, k + n + 10, k + n + 9])
    ]
    return gs.TriSurface("F1", "fault", points, np.concatenate(faces))


def beds(middle):
    """Nodes of a bed that hangs down to `middle` half-way along the fault, and is faulted there."""
    axis = np.linspace(0.0, 1000.0, 51)
    y, x = np.meshgrid(axis, axis, indexing="ij")
    foot = -1690.0 + (middle + 1690.0) * np.sin(np.pi * y / 1000.0) ** 2
    z = np.where(x > east(foot - 0.5 * THROW), foot - THROW, foot)
    z[np.abs(x - east(foot - 0.5 * THROW)) < 25.0] = np.nan
    return xr.DataArray(z, {"northing": axis, "easting": axis}, attrs=FLAT)


def turned(surface):
    """Elevations of the corners of triangles that face against the dip (n, 3)."""
    corners = surface.vertices[surface.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    mean = normals.sum(axis=0)
    return corners[normals[:, :2] @ mean[:2] <= 0][:, :, 2]


@pytest.mark.parametrize(
    ("notch", "middle"), [(-1660.0, -1690.0), (-1660.0, -1850.0), (-1800.0, -1850.0)]
)
def test_throw_is_read_where_a_fault_turns_back_beyond_its_cutoffs(notch, middle):
    """Also if that part reaches down, at its place, to where cut-offs are elsewhere."""
    surface = fault(notch)
    sheet = gs.tear_horizon(beds(middle), {"F1": surface}, name="Top")
    scene = gs.Scene({"Top": sheet}, {f.name: f for f in sheet.faults}, BOX)
    found = scene.throw("Top", "F1")
    walls = np.concatenate([found.hanging_wall_elevation, found.footwall_elevation])
    reaches = turned(surface).min() < walls.max()
    assert reaches == (notch == -1800.0)
    assert found.attrs["direction"] == "local"
    assert found.sizes["point"] > 50
    assert np.isfinite(found.throw).all()
    np.testing.assert_allclose(found.throw, THROW, atol=0.5)
    cut = sheet.cuts["F1"].throw
    assert float(found.throw.mean()) == pytest.approx(np.nanmean(cut), abs=0.2)


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
