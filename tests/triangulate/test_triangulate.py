"""Grids, sticks and boxes become surfaces: what is promised, and what is refused."""

from __future__ import annotations

import re
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from geosurf.errors import HorizonError
from geosurf.model import TriSurface
from geosurf.triangulate import triangulate_horizon
from geosurf.triangulate.mesh import find_zero_area, map_turns
from tests.grids import gridded, turned


def horizon(values, **attrs) -> xr.DataArray:
    values = np.asarray(values, dtype=float)
    n_row, n_col = values.shape
    return curvilinear(values, 25.0 * np.arange(n_col), 50.0 * np.arange(n_row), **attrs)


def curvilinear(values, easting, northing, **attrs) -> xr.DataArray:
    return gridded(values, easting, northing, **attrs).rename("Top")


def rotated(degrees: float, n_row: int = 5, n_col: int = 4, origin=(456000.0, 6780000.0)):
    """Easting, northing (n_row, n_col) of a square grid, turned counter-clockwise."""
    return turned(degrees, (n_row, n_col), 50.0, origin)[:2]


def in_the_world(surface: TriSurface) -> set:
    """Triangles as sets of places: what is left when numbering is forgotten."""
    return {frozenset(map(tuple, corners)) for corners in surface.vertices[surface.triangles]}


def normals(surface: TriSurface) -> np.ndarray:
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    return 0.5 * np.cross(b - a, c - a)


def directions(da: xr.DataArray) -> list[xr.DataArray]:
    """The same grid read along all eight directions."""
    r, c = da.dims
    turned = [da, da.isel({r: slice(None, None, -1)}), da.isel({c: slice(None, None, -1)})]
    turned.append(turned[1].isel({c: slice(None, None, -1)}))
    return turned + [t.transpose() for t in turned]


# ---- horizons ------------------------------------------------------------------------


@given(st.floats(0, 360), st.floats(0.2, 5), st.floats(-0.8, 0.8), st.integers(0, 2**32 - 1))
def test_law_the_diagonal_does_not_see_the_direction_of_travel(degrees, stretch, shear, seed):
    i, j = np.mgrid[:4, :5].astype(float)
    a = np.radians(degrees)
    u, v = j + shear * i, stretch * i
    u = u + np.random.default_rng(seed).uniform(-0.05, 0.05, u.shape)
    x, y = u * np.cos(a) - v * np.sin(a), u * np.sin(a) + v * np.cos(a)
    values = np.arange(20.0).reshape(4, 5)
    values[2, 1] = np.nan
    surfaces = [triangulate_horizon(d) for d in directions(curvilinear(values, x, y))]
    assert all(in_the_world(one) == in_the_world(surfaces[0]) for one in surfaces)
    assert all((normals(one)[:, 2] > 0).all() for one in surfaces)


@given(st.integers(2, 6), st.integers(2, 6), st.integers(0, 2**32 - 1))
def test_triangles_exist_where_their_three_nodes_do(n_row, n_col, seed):
    r = np.random.default_rng(seed)
    values = np.where(r.random((n_row, n_col)) < 0.3, np.nan, r.integers(-9, 9, (n_row, n_col)))
    values[:2, :2] = -1.0
    surface = triangulate_horizon(horizon(values))
    count = 0
    for i, j in product(range(n_row - 1), range(n_col - 1)):
        for third in ((i, j + 1), (i + 1, j)):  # north-east diagonal, by definition
            count += not np.isnan([values[i, j], values[i + 1, j + 1], values[third]]).any()
    assert surface.n_triangle == count
    number = surface.lattice.vertex_of_node
    for i, j in product(range(n_row), range(n_col)):
        if np.isnan(values[i, j]):
            assert number[i, j] == -1
        else:
            assert surface.vertices[number[i, j]].tolist() == [25.0 * j, 50.0 * i, values[i, j]]


FLAT = np.zeros((3, 3))


def _holes():
    values = np.full((3, 3), np.nan)
    values[0, 0] = values[2, 2] = values[0, 2] = 1.0
    return horizon(values)


def _with(i, j, value):
    values = FLAT.copy()
    values[i, j] = value
    return horizon(values)


def _folded():
    easting, northing = rotated(30, 4, 4)
    easting[2, 2] += 80.0
    return curvilinear(np.zeros((4, 4)), easting, northing)


def _pinched():
    easting, northing = rotated(0, 3, 3, (0.0, 0.0))
    easting[0, 1], northing[0, 1] = easting[0, 0], northing[0, 0]
    return curvilinear(np.zeros((3, 3)), easting, northing)


def _placeless():
    easting, northing = rotated(0, 3, 3)
    easting[1, 2] = np.nan
    return curvilinear(FLAT, easting, northing)


@pytest.mark.parametrize("way", ["northing", "easting"])
def test_axes_that_decrease_change_nothing(way):
    """A raster has its northernmost row first."""
    rng = np.random.default_rng(3)
    values = np.where(rng.random((4, 5)) < 0.2, np.nan, rng.integers(-9, 9, (4, 5)))
    given = horizon(values)
    turned = given.isel({way: slice(None, None, -1)})
    one, two = triangulate_horizon(given), triangulate_horizon(turned)
    for key in ("easting", "northing", "elevation"):
        assert getattr(one.lattice, key).tobytes() == getattr(two.lattice, key).tobytes()
    assert one.vertices.tobytes() == two.vertices.tobytes()
    assert one.triangles.tobytes() == two.triangles.tobytes()
    assert not np.array_equal(turned.values, given.values)


WRONG_HORIZONS = {
    "decreasing": (
        lambda: horizon(FLAT).isel(northing=[1, 0, 2]),
        r"northing decreases at index 1: 50 is followed by 0, expected .*sortby\('northing'\)",
    ),
    "infinite": (
        lambda: _with(1, 2, np.inf),
        r"1 nodes are infinite, the first is node \(1, 2\) at \(E 50,.*elevation inf.*NaN",
    ),
    "no triangle": (_holes, r"has its three nodes: only 3 of 9 nodes are present.*NaN mask"),
    "folded": (
        _folded,
        r"folded: \d+ of 18 triangles are turned over, the first at \(E .*2-D coordinates",
    ),
    "pinched": (_pinched, r"folded: 1 of 8 triangles are without area in the map.*NaN"),
    "no place": (_placeless, r"1 nodes have a value but no position, .*\(1, 2\), easting nan.*NaN"),
}


@pytest.mark.parametrize("case", WRONG_HORIZONS)
def test_a_horizon_is_refused_with_what_where_and_what_next(case):
    make, message = WRONG_HORIZONS[case]
    with pytest.raises(HorizonError, match=re.compile(message, re.DOTALL)):
        triangulate_horizon(make())


def test_a_node_without_value_needs_no_place():
    da = _placeless()
    da[1, 2] = np.nan
    assert triangulate_horizon(da).n_triangle == 5


# ---- walls ---------------------------------------------------------------------------


# ---- exact signs ---------------------------------------------------------------------


@given(
    st.lists(st.integers(-3, 3), min_size=9, max_size=9),
    st.sampled_from([1.0, 0.1, 1e-155, 1e-170]),
)
def test_zero_area_is_told_exactly(numbers, scale):
    corners = np.array(numbers, dtype=float).reshape(1, 3, 3) * scale
    a, b, c = ([Fraction(v) for v in p] for p in corners[0].tolist())
    u, v = [q - p for p, q in zip(a, b, strict=True)], [q - p for p, q in zip(a, c, strict=True)]
    pairs = [(0, 1), (1, 2), (2, 0)]
    cross = [u[i] * v[j] - u[j] * v[i] for i, j in pairs]
    assert (len(find_zero_area(corners)) == 1) == (not any(cross))
    assert map_turns(corners)[0] == (cross[0] > 0) - (cross[0] < 0)
