"""Faults from grids, sticks and meshes: what is promised, and what is refused."""

from __future__ import annotations

import re
import warnings
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import GeosurfWarning, InputError, SurfaceError
from geosurf.model import FaultSticks, TriSurface
from geosurf.triangulate import orient_fault, triangulate_fault, triangulate_sticks
from geosurf.triangulate.mesh import find_zero_area
from geosurf.triangulate.sticks import sorted_along
from tests.messages import refused
from tests.triangulate.test_triangulate import in_the_world, normals

DIMS = ("down_dip", "along_strike")


# ---- faults --------------------------------------------------------------------------


def fault_grid(dip=60.0, direction=75.0, n_row=4, n_col=5, roughness=0.0, height="elevation"):
    """A planar fault Dataset, normal by definition up along (direction, dip)."""
    d, a = np.radians(dip), np.radians(direction)
    t, s = np.mgrid[:n_row, :n_col] * 100.0
    rough = roughness * np.sin(7.0 * t + 3.0 * s)
    x = s * np.cos(a) + t * np.cos(d) * np.sin(a) + rough
    y = -s * np.sin(a) + t * np.cos(d) * np.cos(a)
    z = -1500.0 - t * np.sin(d)
    values = z if height == "elevation" else -z
    return xr.Dataset(
        {"easting": (DIMS, x), "northing": (DIMS, y), height: (DIMS, values, {"units": "m"})},
        attrs={"name": "F1"},
    )


def fault_directions(ds):
    back = slice(None, None, -1)
    turned = [ds, ds.isel(down_dip=back), ds.isel(along_strike=back)]
    turned.append(turned[1].isel(along_strike=back))
    return turned + [t.transpose() for t in turned]


@pytest.mark.parametrize("direction", [0, 75, 90, 180, 200, 270, 359])
@pytest.mark.parametrize("dip", [0, 20, 60, 90])
def test_a_fault_grid_is_the_same_read_from_any_corner(dip, direction):
    ds = fault_grid(dip, direction, roughness=0.3 if 0 < dip < 90 else 0.0)
    ds["elevation"][0, 1] = np.nan
    surfaces = [triangulate_fault(d) for d in fault_directions(ds)]
    assert all(in_the_world(s) == in_the_world(surfaces[0]) for s in surfaces)
    for surface in surfaces:
        assert surface.role == "fault"
        assert surface.lattice is not None
        normal = normals(surface).sum(axis=0)
        normal /= np.linalg.norm(normal)
        if dip < 90:
            assert normal[2] > 0
        elif abs(normal[0]) > 1e-6:
            assert normal[0] > 0
        else:
            assert normal[1] > 0


def test_depth_is_turned_and_names_decide():
    up, down = triangulate_fault(fault_grid()), triangulate_fault(fault_grid(height="depth"))
    assert in_the_world(up) == in_the_world(down)
    feet = fault_grid()
    feet["elevation"].attrs["units"] = "ft"
    assert np.isclose(triangulate_fault(feet).bounds[5], -1500 * 0.3048)
    assert triangulate_fault(fault_grid(), name="F9").name == "F9"


def test_a_fault_from_sticks_a_mesh_or_a_surface():
    lines = ([[0, 0, 1500], [300, 0, 2000]], [[0, 400, 1500], [300, 400, 2000]])
    picked = triangulate_fault(FaultSticks("F7", lines), positive="down")
    assert picked.name == "F7"
    assert picked.bounds[4:] == (-2000.0, -1500.0)
    mesh = triangulate_fault((picked.vertices, picked.triangles[:, [0, 2, 1]]), name="F7")
    assert in_the_world(mesh) == in_the_world(picked)
    assert (normals(mesh)[:, 2] > 0).all()
    passed = triangulate_fault(TriSurface("F7", "surface", mesh.vertices, mesh.triangles))
    assert passed.role == "fault"
    depth = triangulate_fault(
        (picked.vertices * [1, 1, -1], picked.triangles), name="F7", positive="down"
    )
    assert in_the_world(depth) == in_the_world(picked)


def _fault_with(**changes):
    ds = fault_grid()
    for key, value in changes.items():
        ds[key] = value
    return ds


def _flat_spot():
    ds = fault_grid()
    for key in ("easting", "northing", "elevation"):
        ds[key][0, 1] = ds[key][0, 0]
    return ds


def _with_units(key, units):
    ds = fault_grid()
    ds[key].attrs["units"] = units
    return ds


SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 2, 0]]
WRONG_FAULTS = {
    "no name": (lambda: ((SQUARE, [[0, 1, 2]]), {}), r"no name\. Pass it"),
    "contradiction": (
        lambda: (fault_grid(), {"positive": "down"}),
        r"elevation has positive='down', expected 'up'.*Name the variable",
    ),
    "no units": (
        lambda: (_with_units("elevation", None), {}),
        r"'F1': the length unit is missing.*length_unit=",
    ),
    "infinite": (
        lambda: (
            _fault_with(elevation=fault_grid().elevation.where(lambda z: z > -1700, -np.inf)),
            {},
        ),
        r"5 nodes are infinite, the first is node \(3, 0\) at \(E.*elevation -inf.*NaN",
    ),
    "far": (
        lambda: (_fault_with(elevation=fault_grid().elevation * 1e300), {"length_unit": "m"}),
        r"'F1' has a coordinate of .*e\+30\d m, but .* limited to 1\.15292e\+18 .*to NaN",
    ),
    "zero area, grid": (
        lambda: (_flat_spot(), {}),
        r"1 of 24 triangles have exactly zero area, the first is triangle \d+ .*at \(E.*NaN",
    ),
    "zero area, mesh": (
        lambda: ((SQUARE, [[0, 1, 2], [0, 2, 3]]), {"name": "F1"}),
        r"1 of 2 triangles have exactly zero area, .* triangle 1 .*vertices \[0, 2, 3\].*Remove",
    ),
    "surface in depth": (
        lambda: (TriSurface("F1", "fault", SQUARE, [[0, 1, 2]]), {"positive": "down"}),
        r"a TriSurface is in metres.*Pass \(vertices, triangles\)",
    ),
}


@pytest.mark.parametrize("case", WRONG_FAULTS)
def test_a_fault_is_refused_with_what_where_and_what_next(case):
    make, message = WRONG_FAULTS[case]
    obj, arguments = make()
    refused(InputError, re.compile(message, re.DOTALL), triangulate_fault, obj, **arguments)


# ---- orientation ---------------------------------------------------------------------


@given(st.integers(0, 2**32 - 1), st.sampled_from([0, 30, 60, 90]), st.integers(0, 359))
def test_orientation_forgets_how_triangles_were_turned(seed, dip, direction):
    whole = triangulate_fault(fault_grid(dip, direction))
    turned = np.random.default_rng(seed).random(whole.n_triangle) < 0.5
    mixed = np.where(turned[:, None], whole.triangles[:, [0, 2, 1]], whole.triangles)
    soup = TriSurface(
        "F1", "fault", whole.vertices[mixed].reshape(-1, 3), np.arange(mixed.size).reshape(-1, 3)
    )
    for given_surface in (TriSurface("F1", "fault", whole.vertices, mixed), soup):
        oriented = orient_fault(given_surface)
        np.testing.assert_array_equal(
            np.sign((normals(oriented) * normals(whole)).sum(axis=1)), 1.0
        )
        assert orient_fault(oriented) is oriented


def test_a_grid_with_holes_becomes_a_fault_without_a_list_of_triangles():
    ds = fault_grid(n_row=20, n_col=20)
    ds["elevation"][7, 3] = np.nan
    fault = triangulate_fault(ds, name="F1")
    assert not {"vertices", "triangles"} & set(fault.__dict__)
    assert fault.n_triangle == 2 * 19 * 19 - 6


def test_sheets_that_share_an_edge_of_three_triangles_are_turned_one_by_one():
    vertices = [[0, 0, 0], [0, 9, 0], [9, 0, 1], [-9, 0, 1], [1, 0, 9]]
    fins = TriSurface("F1", "fault", vertices, [[0, 1, 2], [0, 1, 3], [1, 0, 4]])
    assert (normals(orient_fault(fins))[:, 2] > 0).all()


def test_a_closed_surface_has_no_hanging_wall_and_stays_as_it_is():
    corners = 0.1 + np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
    closed = TriSurface("F1", "fault", corners, faces)
    assert orient_fault(closed) is closed


def test_a_moebius_strip_is_refused_with_a_place():
    t = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    rim = [
        np.stack(
            [
                (9 + w * np.cos(t / 2)) * np.cos(t),
                (9 + w * np.cos(t / 2)) * np.sin(t),
                w * np.sin(t / 2),
            ],
            1,
        )
        for w in (-2.0, 2.0)
    ]
    a, b = np.arange(12), np.arange(12) + 12
    next_a, next_b = np.r_[a[1:], b[0]], np.r_[b[1:], a[0]]
    faces = np.r_[np.stack([a, next_a, next_b], 1), np.stack([a, next_b, b], 1)]
    with pytest.raises(SurfaceError, match=r"'F1' has only one side.*edge at \(E .*Cut it"):
        orient_fault(TriSurface("F1", "fault", np.concatenate(rim), faces))


# ---- sticks --------------------------------------------------------------------------


def curved_sticks(n_stick=14, sweep=1.4 * np.pi, seed=0):
    """Sticks of a fault that bends through most of a circle, of two to five points each."""
    r = np.random.default_rng(seed)
    out = []
    for phi in np.linspace(0.0, sweep, n_stick):
        t = np.sort(np.r_[0.0, r.random(r.integers(0, 4)), 1.0])
        size = r.uniform(0.7, 1.0)
        radius = 2000.0 - 150.0 * t * size
        out.append(
            np.stack(
                [radius * np.cos(phi), radius * np.sin(phi), -1500.0 - 300.0 * t * size], axis=1
            )
        )
    return out


def shuffled(sticks, seed):
    r = np.random.default_rng(seed)
    return [sticks[i][:: r.choice([1, -1])] for i in r.permutation(len(sticks))]


@given(st.integers(0, 2**32 - 1), st.integers(2, 14))
def test_order_and_direction_of_sticks_do_not_matter(seed, n_stick):
    sticks = curved_sticks(n_stick, seed=seed)
    one = triangulate_sticks(sticks, name="F1")
    two = triangulate_sticks(shuffled(sticks, seed), name="F1")
    assert in_the_world(one) == in_the_world(two)
    np.testing.assert_array_equal(one.triangles, two.triangles)


def rows_of_sticks(surface, sticks):
    rows = {tuple(v): i for i, v in enumerate(surface.vertices.tolist())}
    return [rows[tuple((np.asarray(stick) + 0.0)[0].tolist())] for stick in sticks]


@pytest.mark.parametrize("n_stick", [5, 9, 14, 40])
def test_sticks_of_a_strongly_curved_fault_keep_their_order(n_stick):
    sticks = curved_sticks(n_stick)
    surface = triangulate_sticks(shuffled(sticks, 5), name="F1")
    steps = np.diff(rows_of_sticks(surface, sticks))
    assert (steps > 0).all() or (steps < 0).all()
    assert surface.n_vertex == sum(map(len, sticks))
    assert surface.n_triangle == sum(len(a) + len(b) - 2 for a, b in pairwise(sticks))
    assert len(find_zero_area(surface.vertices[surface.triangles])) == 0
    edges = np.sort(surface.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, times = np.unique(edges, axis=0, return_counts=True)
    rim = len(sticks[0]) + len(sticks[-1]) - 2 + 2 * (n_stick - 1)
    assert times.max() == 2
    assert (times == 1).sum() == rim


def test_level_sticks_run_along_with_their_neighbours():
    sticks = [
        [[0, 0, -z], [900, 3 * (-1) ** i, -z]] for i, z in enumerate((1500, 1700, 1900, 2100))
    ]
    trace = triangulate_sticks(shuffled([np.array(s, float) for s in sticks], 3), name="F1")
    assert trace.n_triangle == 6
    area = np.linalg.norm(normals(trace), axis=1).sum()
    assert np.isclose(area, 900 * 600, rtol=0.02)


@pytest.mark.parametrize("fault", ["F1", "F2", "F3", "F4", "F5", "F6"])
def test_sticks_of_a_real_field_come_out_in_the_order_of_the_file(shared, fault):
    file = shared / "data" / "drogon" / "fault_sticks_pol" / f"{fault}.pol"
    sticks = [
        np.array([line.split() for line in block.splitlines() if line.strip()], dtype=float)
        * [1, 1, -1]
        for block in re.split(r"999\.0+ +999\.0+ +999\.0+", file.read_text())
        if block.strip()
    ]
    surface = triangulate_sticks(shuffled(sticks, 1), name=fault)
    tops = [stick[np.argmax(stick[:, 2]) :] for stick in sticks]
    steps = np.diff(rows_of_sticks(surface, tops))
    assert (steps > 0).all() or (steps < 0).all()
    assert (normals(surface)[:, 2].sum()) > 0


A = [[0, 0, -1500], [300, 0, -2000]]
WRONG_STICKS = {
    "one": ([A], r"'F1' has 1 stick, but .*two or more.*strike=30, length=2000"),
    "loop": (
        [A, [[0, 400, 0], [9, 400, -9], [0, 400, -9], [9, 400, -9], [0, 400, -20]]],
        r"stick 1 passes \(E 9,.*twice. Split",
    ),
    "in line": (
        [[[0, 0, 0], [0, 0, -1]], [[0, 0, -3], [0, 0, -4]]],
        r"triangles have exactly zero area.*Remove the collinear point",
    ),
    "crossing": (
        [[[0, 0, 0], [900, 0, -90]], [[450, 0, 500], [450, 1, -900], [450, 5, -901]]],
        r"neighbouring sticks cross, so the surface folds over at \(E.*Remove or correct",
    ),
}


@pytest.mark.parametrize("case", WRONG_STICKS)
def test_sticks_are_refused_with_what_where_and_what_next(case):
    sticks, message = WRONG_STICKS[case]
    refused(SurfaceError, re.compile(message, re.DOTALL), triangulate_sticks, sticks, name="F1")


def test_minus_zero_is_zero():
    """Results are compared by their bytes; -0.0 and 0.0 differ in theirs."""
    i, j = np.mgrid[:3, :4] * 10.0
    ds = xr.Dataset({"easting": (DIMS, j), "northing": (DIMS, i), "elevation": (DIMS, -i)})
    ds["elevation"].attrs["units"] = "m"
    lattice = triangulate_fault(ds, name="F1").lattice
    assert np.signbit(ds["elevation"].values[0]).all()
    assert not np.signbit(lattice.elevation[0]).any()


# ---- Sticks as files have them: points in any order, sticks twice, and a single one.
def listric(northing, n=9):
    """A stick that flattens with depth, and leans a little along strike."""
    t = np.linspace(0.0, 1.0, n)
    return np.column_stack([1000 * t**2, northing + 20 * t, -1500 - 800 * t])


def overturned(northing, n=15):
    """A stick that goes around a bend: no direction in which its points are in order."""
    a = np.linspace(0.0, 1.3 * np.pi, n)
    return np.column_stack([500 * np.sin(a), np.full(n, float(northing)), 400 * np.cos(a)])


def bytes_of(sticks):
    surface = gs.triangulate_sticks(sticks, name="F1")
    return surface.vertices.tobytes(), surface.triangles.tobytes()


@pytest.mark.parametrize("shape", [listric, overturned])
def test_sticks_and_their_points_may_come_in_any_order(shape, rng):
    sticks = [shape(300.0 * k) for k in range(5)]
    with warnings.catch_warnings(action="error"):  # in order there is nothing to warn of
        expected = bytes_of(sticks)
    for _ in range(3):
        mixed = [sticks[i][rng.permutation(len(sticks[i]))] for i in rng.permutation(5)]
        with pytest.warns(GeosurfWarning, match=r"'F1': the points of 5 sticks run back and forth"):
            assert bytes_of(mixed) == expected


def test_picks_that_slip_back_a_little_stay_as_they_are():
    level = np.array([[0, 0, 0], [100, 0, 1], [90, 0, -1], [200, 0, 0.0]])
    assert sorted_along(level) is level
    mixed = level[[0, 3, 1, 2]]
    assert np.ptp(np.diff(sorted_along(mixed)[:, 0])) < np.ptp(np.diff(mixed[:, 0]))


def test_a_stick_that_comes_twice_is_used_once():
    sticks = [listric(0.0), listric(300.0), listric(600.0)]
    words = r"2 sticks of 5 came twice and are used once; sticks 0 and 3 are the same, from \(E 0,"
    with pytest.warns(GeosurfWarning, match=words) as found:
        again = bytes_of([*sticks, sticks[0][::-1], sticks[2]])
    assert again == bytes_of(sticks)
    assert (found[0].message.kind, found[0].message.subject) == ("sticks", "F1")


@pytest.mark.parametrize("strike", [0.0, 30.0, 250.0])
def test_a_single_stick_with_a_strike_is_a_fault_of_that_strike(strike):
    stick = listric(0.0)
    surface = gs.triangulate_sticks([stick], name="F1", strike=strike, length=2000)
    along = np.array([np.sin(np.radians(strike)), np.cos(np.radians(strike)), 0.0])
    a, b, c = surface.vertices[surface.triangles].swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    assert np.abs(normal @ along).max() < 1e-9 * np.linalg.norm(normal, axis=1).max()
    reach = surface.vertices @ along
    own = stick @ along
    assert np.ptp(reach) == pytest.approx(2000 + np.ptp(own), rel=1e-12)
    places = {tuple(x) for x in surface.vertices.tolist()}
    assert all(tuple(x) in places for x in stick.tolist())


def test_a_strike_that_cannot_be_used_is_refused():
    for words, match in (
        ({"strike": 30}, r"length is None. A single stick needs strike, .*strike=30, length=2000"),
        ({"length": 500.0}, r"strike is None"),
        ({"strike": "N", "length": 500.0}, r"strike is 'N'"),
        ({"strike": 30, "length": -5}, r"length is -5"),
    ):
        with pytest.raises(SurfaceError, match=match):
            gs.triangulate_sticks([listric(0.0)], name="F1", **words)
    with pytest.raises(SurfaceError, match=r"has 2 sticks, which define its strike. Leave strike"):
        gs.triangulate_sticks([listric(0.0), listric(9.0)], name="F1", strike=3, length=9)
