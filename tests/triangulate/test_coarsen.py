"""Fewer triangles within a tolerance: errors measured by another way, rims, holes, volumes."""

from __future__ import annotations

import itertools
from collections import Counter

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from geosurf import triangulate_horizon
from geosurf.errors import HorizonError


def gridded(z, step=10.0, corner=(0.0, 0.0)):
    """A horizon on even steps."""
    n_row, n_col = z.shape
    coords = {
        "northing": corner[1] + step * np.arange(n_row),
        "easting": corner[0] + step * np.arange(n_col),
    }
    return xr.DataArray(
        z, dims=("northing", "easting"), coords=coords, name="Top",
        attrs={"units": "m", "positive": "up"},
    )  # fmt: skip


def rolling(n_row=137, n_col=200):
    x, y = np.meshgrid(10.0 * np.arange(n_col), 10.0 * np.arange(n_row))
    return 50 * np.sin(x / 300) * np.sin(y / 400)


def both(z, tolerance, **place):
    da = gridded(z, **place)
    return triangulate_horizon(da, tolerance=tolerance), triangulate_horizon(da)


def map_areas(surface):
    p = surface.vertices[surface.triangles]
    u, v = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def integral(surface):
    return (map_areas(surface) * surface.vertices[surface.triangles, 2].mean(axis=1)).sum()


def edges_of(surface):
    t = surface.triangles
    return Counter(map(tuple, np.sort(t[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).tolist()))


def rim(surface):
    """Steps of the rim, as pairs of places in the map: long edges count for all their steps."""
    steps = set()
    for (a, b), times in edges_of(surface).items():
        if times == 1:
            p, q = surface.vertices[[a, b], :2]
            n = round(np.abs(q - p).max() / 10.0)
            at = p + (q - p) * np.linspace(0, 1, n + 1)[:, None]
            at = [tuple(np.round(x, 6)) for x in at]
            steps |= {frozenset(pair) for pair in itertools.pairwise(at)}
    return steps


def height_at(surface, x, y):
    """Heights at places by searching all triangles: slow and plain. NaN outside."""
    p = surface.vertices[surface.triangles]
    a, u, v = p[:, 0], p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    size = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    out = np.full(len(x), np.nan)
    for k in range(len(x)):
        dx, dy = x[k] - a[:, 0], y[k] - a[:, 1]
        s, t = (dx * v[:, 1] - dy * v[:, 0]) / size, (dy * u[:, 0] - dx * u[:, 1]) / size
        inside = np.flatnonzero((s > -1e-9) & (t > -1e-9) & (s + t < 1 + 1e-9))
        if len(inside):
            i = inside[0]
            out[k] = a[i, 2] + s[i] * u[i, 2] + t[i] * v[i, 2]
    return out


def assert_sound(coarse, plain, tolerance, *, places=60):
    """Conforming, the same rim, errors as told at nodes and between, volumes within the bound."""
    assert max(edges_of(coarse).values()) <= 2
    assert (map_areas(coarse) > 0).all()
    assert rim(coarse) == rim(plain)
    assert coarse.vertex_data["vertical_error"].max() <= tolerance
    known = {tuple(v) for v in plain.vertices.tolist()}
    assert {tuple(v) for v in coarse.vertices.tolist()} <= known
    rng = np.random.default_rng(5)
    p = plain.vertices[plain.triangles[rng.integers(0, plain.n_triangle, places)]]
    weights = rng.dirichlet((0.3, 0.3, 0.3), size=places)
    points = np.concatenate([(p * weights[:, :, None]).sum(axis=1), p[:, 0]])
    away = np.abs(height_at(coarse, points[:, 0], points[:, 1]) - points[:, 2])
    assert away.max() <= coarse.vertex_data["vertical_error"].max() + 1e-7
    bound = coarse.vertex_data["volume_error"].sum()
    assert abs(integral(coarse) - integral(plain)) <= bound + 1e-6
    assert bound <= tolerance * map_areas(plain).sum()


@pytest.mark.parametrize("tolerance", [0.05, 0.5, 5.0])
def test_errors_rims_and_volumes(tolerance):
    coarse, plain = both(rolling(), tolerance)
    assert_sound(coarse, plain, tolerance)
    assert coarse.n_triangle < plain.n_triangle / {0.05: 3, 0.5: 25, 5.0: 100}[tolerance]
    assert coarse.lattice is None


def test_holes_and_islands_are_kept():
    z = rolling()
    z[30:50, 60:90] = np.nan
    z[40, 70] = z[40, 71] = z[41, 70] = 3.0  # an island of one triangle, or none
    z[:3] = np.nan
    z[100, 100] = np.nan
    coarse, plain = both(z, 0.5)
    assert_sound(coarse, plain, 0.5)
    assert coarse.n_triangle < plain.n_triangle / 10


@settings(max_examples=30)
@given(
    arrays(np.int64, st.tuples(st.integers(2, 10), st.integers(2, 10)), elements=st.integers(0, 3)),
    st.sampled_from([0.25, 0.5, 1.0, 2.0]),
    st.integers(0, 99),
)
def test_small_reliefs_with_holes(z, tolerance, seed):
    z = z.astype(float)
    z[np.random.default_rng(seed).random(z.shape) < 0.01 * (seed % 30)] = np.nan
    try:
        coarse, plain = both(z, tolerance)
    except HorizonError as error:
        assert "NaN" in str(error) or "no triangle" in str(error)  # noqa: PT017
        return
    assert_sound(coarse, plain, tolerance, places=20)


def test_the_bound_is_on_the_difference_not_on_its_sum():
    """Up and down leave the volume as it is; the bound says how far parts can be off."""
    coarse, plain = both(rolling(129, 129), 5.0)
    bound = coarse.vertex_data["volume_error"].sum()
    x, y = np.meshgrid(np.arange(2.5, 1280, 5.0), np.arange(2.5, 1280, 5.0))
    points = np.stack([x.ravel(), y.ravel()], axis=1)[::173]
    off = height_at(coarse, *points.T) - height_at(plain, *points.T)
    between = np.abs(off).mean() * 1280**2
    assert 0.85 * between < bound < 1.6 * between


def test_plain_where_nothing_can_be_left_out(rng):
    z = 100.0 * rng.normal(size=(20, 31))
    coarse, plain = both(z, 1e-6)
    faces = [
        {frozenset(map(tuple, p)) for p in s.vertices[s.triangles].tolist()}
        for s in (coarse, plain)
    ]
    assert faces[0] == faces[1]
    assert coarse.vertex_data["volume_error"].sum() == 0


def test_a_plane_is_a_few_triangles():
    x, y = np.meshgrid(np.arange(65.0), np.arange(65.0))
    coarse, _ = both(0.25 * x - 0.5 * y, 1e-9)
    assert coarse.n_triangle == 2
    assert both(0 * rolling(), 0.1)[0].n_triangle < 500


def test_a_symmetric_surface_has_symmetric_triangles():
    n = 129
    u = np.linspace(-1, 1, n)
    z = 40 * np.exp(-4 * (u[:, None] ** 2 + u[None, :] ** 2))
    coarse, _ = both(z, 0.2)
    xy = coarse.vertices[:, :2]
    faces = {frozenset(map(tuple, t)) for t in xy[coarse.triangles].tolist()}
    swapped = {frozenset((b, a) for a, b in t) for t in faces}
    assert swapped == faces
    places = {tuple(p) for p in xy.tolist()}
    assert {(1280 - a, b) for a, b in places} == places


def test_the_direction_of_rows_and_columns_is_not_seen():
    """A grid with 2-D coordinates, read in all eight directions."""
    z = rolling(60, 83)
    easting, northing = np.meshgrid(10.0 * np.arange(83), 10.0 * np.arange(60))
    e, n = easting * 0.8 - northing * 0.6, easting * 0.6 + northing * 0.8
    found = []
    for turn in (False, True):
        for row in (1, -1):
            for col in (1, -1):
                parts = [q[::row, ::col] for q in (z, e, n)]
                parts = [q.T if turn else q for q in parts]
                da = xr.DataArray(
                    parts[0], dims=("i", "j"), name="Top",
                    coords={"easting": (("i", "j"), parts[1]), "northing": (("i", "j"), parts[2])},
                    attrs={"units": "m", "positive": "up"},
                )  # fmt: skip
                s = triangulate_horizon(da, tolerance=0.5)
                assert (map_areas(s) > 0).all()
                found.append({frozenset(map(tuple, t)) for t in s.vertices[s.triangles].tolist()})
    assert all(faces == found[0] for faces in found)


def test_two_runs_and_a_shift_give_the_same_triangles():
    one, _ = both(rolling(), 0.5)
    two, _ = both(rolling(), 0.5, corner=(456_000.0, 6_780_000.0))
    np.testing.assert_array_equal(one.triangles, two.triangles)
    again, _ = both(rolling(), 0.5)
    assert one.vertices.tobytes() == again.vertices.tobytes()
    assert sorted(one.vertex_data) == ["vertical_error", "volume_error"]


@pytest.mark.parametrize("tolerance", [-0.5, np.nan, np.inf])
def test_a_tolerance_is_a_length(tolerance):
    with pytest.raises(HorizonError, match=r"'Top': tolerance is .*Give a length in metres"):
        triangulate_horizon(gridded(rolling()), tolerance=tolerance)


def test_uneven_steps_are_refused():
    da = gridded(rolling(20, 20))
    steps = np.array(da.easting)
    steps[7] += 1.0
    da = da.assign_coords(easting=steps)
    assert triangulate_horizon(da).n_triangle == 722
    with pytest.raises(
        HorizonError, match=r"easting has uneven steps near node \(6,\), by 2 m, but .*Le"
    ):
        triangulate_horizon(da, tolerance=0.5)
