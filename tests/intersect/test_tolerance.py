"""Curves with a tolerance, against formulas: errors, bounds, lost loops, and what is confessed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from geosurf import Lattice, TriSurface, intersect_surfaces
from geosurf.arrangement import find_contacts
from geosurf.errors import InputError, SurfaceError
from geosurf.intersect import curves_of, exact_route
from geosurf.intersect import sides as two_sides
from geosurf.intersect.sides import find_candidates, piece_of, sides_of
from tests import laws
from tests.intersect.smooth_worlds import (
    along,
    distance_from,
    horizon,
    level,
    listric_fault,
    onto_the_curve,
    two_triangles,
    waves,
    wavy_horizon,
)
from tests.strategies import UTM, soup

DOME = 10_000.0  # twice the radius at the crest


def dome(n=41, x0=2050.0, y0=1950.0):
    return horizon(lambda x, y: -((x - x0) ** 2 + (y - y0) ** 2) / DOME, n)


def saddle(n=41):
    return horizon(lambda x, y: ((x - 2033) ** 2 - (y - 1977) ** 2) / 2e4, n)


def rolling(x, y):
    return 200 * np.sin(x / 600) * np.sin(y / 700)


def radii(curves, x0=2050.0, y0=1950.0):
    return np.hypot(curves.points[:, 0] - x0, curves.points[:, 1] - y0)


def true_error(points):
    return np.linalg.norm(onto_the_curve(points) - points, axis=1)


def reasons(curves):
    return {place.reason for place in curves.places}


# ---- error and bound -------------------------------------------------------------------


def test_points_gain_more_than_three_and_a_half_orders(monkeypatch):
    monkeypatch.setattr(exact_route, "DENSE", 10**9)  # cubics, although triangles are near enough
    errors = []
    for n in (71, 141, 281):
        curves = intersect_surfaces([wavy_horizon(n), listric_fault(n, n)], tolerance=1.0)
        errors.append(true_error(curves.points).max())
    orders = [np.log2(a / b) for a, b in pairwise(errors)]
    assert min(orders) > 3.5, errors


@pytest.mark.parametrize("tolerance", [1.0, 0.1, 1e-2, 1e-3])
def test_the_bound_holds_in_both_directions(tolerance):
    curves = intersect_surfaces([wavy_horizon(283), listric_fault(141, 283)], tolerance=tolerance)
    laws.assert_curves_are_whole(curves)
    (bound,) = curves.error_bound
    assert not curves.places
    assert 0.2 * tolerance < bound <= tolerance
    there = along(curves)
    assert true_error(there).max() <= bound
    back = onto_the_curve(there[:: max(1, len(there) // 1500)])
    assert distance_from(back, curves).max() <= 1.01 * bound


def test_a_lattice_too_coarse_for_the_tolerance_says_what_it_can():
    surfaces = [wavy_horizon(71), listric_fault(71, 71)]
    plain = intersect_surfaces(surfaces)
    curves = intersect_surfaces(surfaces, tolerance=1e-3)
    (bound,), (place,) = curves.error_bound, curves.places
    error = true_error(along(curves)).max()
    assert 1e-3 < error <= bound < 2 * error
    assert (place.reason, place.curve, place.surfaces) == ("interpolation", 0, (0, 1))
    assert place.error_bound > 1e-3
    assert "interpolation at (E" in str(place)
    assert true_error(plain.points).max() > 50 * error


def test_fewer_points_for_more_tolerance():
    surfaces = [wavy_horizon(141), listric_fault(71, 141)]
    counts = [len(intersect_surfaces(surfaces, tolerance=t).points) for t in (1.0, 0.1, 0.01)]
    assert counts[0] < len(intersect_surfaces(surfaces).points) / 4
    assert counts[0] < counts[1] < counts[2]


def test_neither_the_order_of_surfaces_nor_a_second_run_changes_a_byte():
    surfaces = [wavy_horizon(71), listric_fault(36, 71), two_triangles(20.0, side=10_000.0)]
    one = intersect_surfaces(surfaces, tolerance=0.1)
    two = intersect_surfaces(surfaces[::-1], tolerance=0.1)
    assert laws.chains_by_name(one) == laws.chains_by_name(two)
    again = intersect_surfaces(surfaces, tolerance=0.1)
    assert one.local.tobytes() == again.local.tobytes()
    np.testing.assert_array_equal(one.error_bound, again.error_bound)


def test_utm_coordinates_change_nothing_but_the_place():
    def moved(surface):
        lattice = surface.lattice
        parts = (lattice.easting, lattice.northing, lattice.elevation)
        parts = (part + shift for part, shift in zip(parts, UTM, strict=True))
        lattice = Lattice(*parts, lattice.rising, lattice.reverse)
        return TriSurface(surface.name, surface.role, lattice=lattice)

    surfaces = [wavy_horizon(71), listric_fault(36, 71)]
    here = intersect_surfaces(surfaces, tolerance=0.1)
    there = intersect_surfaces([moved(surface) for surface in surfaces], tolerance=0.1)
    (one,), (two,) = here.curves, there.curves
    one, two = here.points[one], there.points[two] - UTM
    one, two = (line if line[0, 0] < line[-1, 0] else line[::-1] for line in (one, two))
    assert distance_from(two, here).max() < 0.2
    assert np.abs(one[[0, -1]] - two[[0, -1]]).max() < 1e-6


def test_a_rotated_grid_is_as_good():
    x = np.linspace(-3000.0, 3000.0, 121)
    u, v = np.meshgrid(x, x)
    turn = np.radians(30.0)
    e, n = u * np.cos(turn) - v * np.sin(turn), u * np.sin(turn) + v * np.cos(turn)
    top = TriSurface("Top", "horizon", lattice=Lattice(e, n, -(e**2 + n**2) / DOME))
    flat = two_triangles(-100.0, side=4000.0)
    flat = TriSurface("Flat", "fault", flat.vertices - [2000, 2000, 0], flat.triangles)
    curves = intersect_surfaces([top, flat], tolerance=0.01)
    assert curves.closed.tolist() == [True]
    assert np.abs(np.hypot(*curves.points[:, :2].T) - 1000).max() <= 0.2 * curves.error_bound[0]


# ---- what triangles do not show ----------------------------------------------------------


@pytest.mark.parametrize("flat", [two_triangles, level])
@pytest.mark.parametrize("radius", [60.0, 10.0, 1.0])
def test_a_loop_inside_a_cell_is_found(flat, radius):
    surfaces = [dome(), flat(-(radius**2) / DOME)]
    assert intersect_surfaces(surfaces).n_curve == 0
    curves = intersect_surfaces(surfaces, tolerance=0.01)
    laws.assert_curves_are_whole(curves)
    assert curves.closed.tolist() == [True]
    assert not curves.places
    assert np.abs(radii(curves) - radius).max() < 1e-9
    assert np.abs(np.hypot(*(along(curves)[:, :2] - [2050, 1950]).T) - radius).max() <= 0.01
    assert curves.error_bound[0] <= 0.01


def test_a_loop_across_two_triangles_is_one():
    surfaces = [dome(x0=2050.0, y0=2050.0), two_triangles(-0.09)]
    curves = intersect_surfaces(surfaces, tolerance=0.01)
    assert curves.closed.tolist() == [True]
    assert np.abs(radii(curves, 2050, 2050) - 30).max() < 1e-9


def test_a_loop_beside_a_long_curve_is_found():
    """A bump in a cell that the triangles show nothing of, and a slope that they cut elsewhere."""

    def height(x, y):
        tilt = 0.02 * (x - 3000)
        return np.where(x < 2600, -((x - 2050) ** 2 + (y - 1950) ** 2) / DOME, tilt)

    curves = intersect_surfaces([horizon(height), two_triangles(-0.01)], tolerance=0.01)
    loops = [line for line, closed in zip(curves.curves, curves.closed, strict=True) if closed]
    assert any(
        np.abs(np.hypot(*(curves.points[line, :2] - [2050, 1950]).T) - 10).max() < 1e-6
        for line in loops
    )


def test_touching_is_told_and_nearness_is_not():
    touching = intersect_surfaces([dome(), level(0.0)], tolerance=0.01)
    assert touching.n_curve == 0
    assert reasons(touching) == {"touching"}
    (place,) = touching.places
    assert np.abs(place.points[:, :2] - [2050, 1950]).max() <= place.error_bound < 12
    near = intersect_surfaces([dome(), level(0.01)], tolerance=0.01)
    assert (near.n_curve, near.places) == (0, ())


def test_touching_is_told_where_a_hole_lies_elsewhere():
    """The size of cells, with which nearness is compared, is that of cells with all corners."""

    def height(x, y):
        z = np.where(x < 2600, -((x - 2050) ** 2 + (y - 1950) ** 2) / DOME, 0.02 * (x - 3000))
        z[20, 30] = np.nan
        return z

    curves = intersect_surfaces([horizon(height), level(0.0)], tolerance=0.01)
    (place,) = [place for place in curves.places if place.reason == "touching"]
    assert np.hypot(*(place.points[:, :2] - [2050, 1950]).T).min() < 12
    assert "hole" in reasons(curves)


def test_surfaces_far_apart_cost_nothing():
    curves = intersect_surfaces([dome(), level(500.0)], tolerance=0.01)
    assert (curves.n_curve, curves.places, curves.cost) == (0, (), {})
    assert curves.error_bound.shape == (0,)


@pytest.mark.parametrize("height", [1.0, -1.0])
def test_both_branches_of_a_saddle(height):
    curves = intersect_surfaces([saddle(), two_triangles(height)], tolerance=0.01)
    assert (curves.n_curve, curves.places) == (2, ())
    x, y, _ = along(curves).T
    slope = np.hypot(x - 2033, y - 1977) / 1e4
    off = np.abs(((x - 2033) ** 2 - (y - 1977) ** 2) / 2e4 - height) / slope
    assert off.max() <= 1.01 * curves.error_bound.max() <= 0.0102


def test_the_crossing_of_a_saddle_is_a_place_of_tangency():
    curves = intersect_surfaces([saddle(), two_triangles(0.0)], tolerance=0.01)
    assert "tangency" in reasons(curves)
    at = np.concatenate([place.points for place in curves.places])
    assert np.hypot(*(at[:, :2] - [2033, 1977]).T).max() < 150
    assert np.isinf(curves.error_bound).any()


# ---- where data are not smooth -----------------------------------------------------------


def test_noise_is_told_and_the_plain_curve_stays(rng):
    rough = rng.normal(size=(81, 81))
    surfaces = [horizon(lambda x, y: rolling(x, y) + rough, 81), two_triangles(-30.0, 0.05, 0.02)]
    plain = intersect_surfaces(surfaces)
    curves = intersect_surfaces(surfaces, tolerance=0.01)
    assert "noise" in reasons(curves)
    assert {tuple(p) for p in curves.points.tolist()} <= {tuple(p) for p in plain.points.tolist()}
    assert curves.n_curve == plain.n_curve
    assert curves.error_bound.min() > 1.0


@pytest.mark.parametrize("sigma", [0.003, 0.03, 0.3])
def test_noise_below_the_relief_is_in_the_bound(rng, sigma):
    """The bound follows the noise, though the relief is a thousand times larger."""
    rough = sigma * rng.normal(size=(81, 81))
    tilt = two_triangles(-30.0, 0.05, 0.02)
    clean = intersect_surfaces([horizon(rolling, 81), tilt], tolerance=1e-3)
    curves = intersect_surfaces(
        [horizon(lambda x, y: rolling(x, y) + rough, 81), tilt], tolerance=1e-3
    )
    points = curves.points[np.unique(np.concatenate(curves.curves))]
    assert distance_from(points, clean).max() <= 3 * curves.error_bound.max()
    assert curves.error_bound.max() > sigma


def test_a_hole_keeps_the_plain_curve_around_it():
    def holed(x, y):
        z = rolling(x, y) + 0 * x
        z[30:40, 20:60] = np.nan
        return z

    surfaces = [horizon(holed, 81), two_triangles(-30.0, 0.05, 0.02)]
    plain, curves = intersect_surfaces(surfaces), intersect_surfaces(surfaces, tolerance=0.01)
    assert curves.n_curve == plain.n_curve == 3
    assert reasons(curves) == {"hole"}
    for place in curves.places:
        assert np.isinf(place.error_bound)
        assert np.isinf(curves.error_bound[place.curve])
        assert {tuple(p) for p in place.points.tolist()} <= {
            tuple(p) for p in plain.points.tolist()
        }
    whole = np.flatnonzero(np.isfinite(curves.error_bound))
    assert curves.closed[whole].all()
    assert len(whole) == 1


def test_a_curve_ends_on_the_rims():
    curves = intersect_surfaces([wavy_horizon(71), listric_fault(36, 71)], tolerance=0.1)
    ends = curves.points[curves.curves[0][[0, -1]]]
    assert np.abs(ends[:, 1] * (ends[:, 1] - 10_000)).max() < 1e-2
    assert curves.error_bound[0] <= 0.1


def test_coincidence_is_no_smooth_curve():
    curves = intersect_surfaces([level(0.0, 9, "A"), level(0.0, 11, "B")], tolerance=0.01)
    assert "overlap" in reasons(curves)
    assert np.isinf(curves.error_bound).all()
    assert [contact.kind for contact in curves.contacts] == ["area"]


# ---- surfaces without a lattice ------------------------------------------------------------


def test_a_mesh_is_taken_as_its_triangles():
    """Points lie on the triangles of the mesh, and on the horizon as it is between nodes."""
    fault = listric_fault(12, 30)
    mesh = TriSurface("F1", "fault", fault.vertices, fault.triangles)
    curves = intersect_surfaces([wavy_horizon(141), mesh], tolerance=0.05)
    assert curves.n_curve == 1
    x, y, z = curves.points.T
    assert np.abs(z - waves(x, y)).max() < 0.01
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    for p in curves.points:
        heights = np.abs(((p - a) * normals).sum(axis=1))
        size = np.linalg.norm(b - a, axis=1)
        near = np.linalg.norm(p - (a + b + c) / 3, axis=1) < 2 * size
        assert heights[near].min() < 1e-6
    if not curves.places:
        assert curves.error_bound[0] <= 0.05


def test_meshes_alone_keep_their_plain_curves():
    one, two = (
        soup("A", [[(0, 0, 0), (9, 0, 0), (0, 9, 0)]]),
        soup("B", [[(3, -1, -5), (3, 9, -5), (3, 4, 9)]]),
    )
    plain, curves = intersect_surfaces([one, two]), intersect_surfaces([one, two], tolerance=0.01)
    assert laws.chains_by_name(plain) == laws.chains_by_name(curves)
    assert curves.error_bound.tolist() == [0.0]
    assert plain.error_bound is None


def test_a_bent_lattice_of_few_nodes_is_named():
    curves = intersect_surfaces([wavy_horizon(71), listric_fault(5, 40)], tolerance=0.1)
    assert "coarse lattice" in reasons(curves)
    assert np.isinf(curves.error_bound).all()


# ---- the search ----------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_candidate_cells_hold_all_plain_contacts(seed, monkeypatch):
    """The plain curve of the cells that bounds leave over is the plain curve."""
    monkeypatch.setattr(two_sides, "_MANY", 5 * (seed % 2))
    rng = np.random.default_rng(seed)
    n = 9 + 4 * seed
    z = rng.integers(-2, 3, size=(2, n, n)).astype(float)
    z[0][rng.random((n, n)) < 0.05 * (seed % 3)] = np.nan
    x = np.arange(float(n))
    u, v = np.meshgrid(x, x)
    one = TriSurface("A", "horizon", lattice=Lattice(x, x, z[0]))
    two = TriSurface("B", "fault", lattice=Lattice(u + 0.25 * v, v, z[1] + 0.5 * (seed % 2), False))
    origin = np.zeros(3)
    sides = sides_of(one, two, origin)
    near = find_candidates(*sides)
    pieces = [piece_of(*pair) for pair in zip(sides, near.cells, strict=True)]
    found = curves_of(find_contacts([piece.surface for piece in pieces], origin=origin))
    laws.assert_same_curves(found, curves_of(find_contacts([one, two], origin=origin)))
    assert found.n_curve > 0


def holed_and_rough(n):
    rng = np.random.default_rng(n)
    rough = rng.normal(size=(n, n)) * (rng.random((n, n)) < 0.02)
    rough[rng.random((n, n)) < 0.002] = np.nan
    return horizon(lambda x, y: rolling(x, y) + rough, n)


def moved(surface, by):
    grid = surface.lattice
    lattice = Lattice(grid.easting + by[0], grid.northing + by[1], grid.elevation, False, False)
    return TriSurface(surface.name, surface.role, lattice=lattice)


LARGE = {
    "waves": (wavy_horizon(101), listric_fault(60, 101)),
    "dome": (dome(90), level(-40.0, 77)),
    "saddle": (saddle(90), level(0.3, 77)),
    "touching": (dome(81), level(0.0, 77)),
    "triangles": (horizon(rolling, 120), two_triangles(-30.0, 0.05, 0.02)),
    "rough, with holes": (holed_and_rough(97), level(3.0, 77)),
    "moved": (
        moved(wavy_horizon(101), UTM),
        moved(listric_fault(60, 101), UTM),
    ),
}


@pytest.mark.parametrize("world", LARGE)
def test_blocks_that_are_left_out_change_no_byte(world, monkeypatch):
    found = []
    for many in (0, 10**9):
        monkeypatch.setattr(two_sides, "_MANY", many)
        found.append(intersect_surfaces(LARGE[world], tolerance=0.05))
    one, two = found
    assert laws.curve_bytes(one) == laws.curve_bytes(two)
    assert one.error_bound.tobytes() == two.error_bound.tobytes()
    assert repr(one.places) == repr(two.places)
    assert one.n_curve + len(one.places) > 0


def test_most_blocks_of_large_lattices_are_left_out(monkeypatch):
    monkeypatch.setattr(two_sides, "_MANY", 0)
    sides = sides_of(wavy_horizon(601), listric_fault(400, 601), np.zeros(3))
    assert all(np.isinf(side.blocks[:, 0]).mean() > 0.5 for side in sides)


# ---- errors --------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [-1.0, np.nan, np.inf])
def test_a_tolerance_is_a_length(tolerance):
    with pytest.raises(InputError, match=r"tolerance is .*; give a length in metres, or 0 for the"):
        intersect_surfaces([dome(), level(-1.0)], tolerance=tolerance)


def test_no_tolerance_for_a_surface_with_itself():
    with pytest.raises(InputError, match=r"tolerance and self_inter.* cannot be combined.* Call"):
        intersect_surfaces([dome()], tolerance=0.1, self_intersections=True)


def test_surfaces_are_checked_as_without():
    with pytest.raises(InputError, match="1 surfaces were passed; at least 2 are needed"):
        intersect_surfaces([dome()], tolerance=0.1)
    with pytest.raises(InputError, match="surface 1 is a str, not a TriSurface"):
        intersect_surfaces([dome(), "F1"], tolerance=0.1)
    x = np.arange(9.0)
    nothing = TriSurface("Top", "horizon", lattice=Lattice(x, x, np.full((9, 9), np.nan)))
    with pytest.raises(SurfaceError, match="surface 'Top' has no triangles; leave it out"):
        intersect_surfaces([nothing, dome()], tolerance=0.1)
