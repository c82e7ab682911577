"""Grids with straight axes: what floats settle is what exact signs say, and no pair is missed."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf import TriSurface
from geosurf.arrangement.search import find_contacts
from geosurf.kernels.exact.constructed_points import lpi_in_doubles
from geosurf.model import Lattice
from tests import oracles


@st.composite
def pairs_of_grids(draw):
    """An upright grid and any other one, small whole numbers, some nodes absent."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    n_row, n_col, m, k = rng.integers(2, 12, 4)
    z = rng.integers(-2, 3, (n_row, n_col)) * 1.0
    z[rng.random(z.shape) < draw(st.sampled_from([0.0, 0.2]))] = np.nan
    axes = [np.cumsum(rng.integers(1, 4, n)) * 1.0 for n in (n_col, n_row)]
    top = Lattice(*axes, z, bool(rng.integers(2)))
    u, v = np.meshgrid(np.arange(k) * 1.0, np.arange(m) * 1.0)
    scale = draw(st.sampled_from([1.0, 0.37]))
    x = scale * (u + rng.integers(0, 3, (m, k))) + rng.integers(0, 4)
    y = scale * (rng.integers(0, 6, (m, k)) if draw(st.booleans()) else 2 * v)
    h = scale * rng.integers(-3, 4, (m, k))
    h[rng.random(h.shape) < 0.1] = np.nan
    x, y = 1.0 * x, 1.0 * y
    if draw(st.booleans()):  # whole cells without a place, though with a height
        i, j = rng.integers(0, (m, k))
        draw(st.sampled_from([x, y]))[i : i + 3, j : j + 4] = np.nan
    wall = Lattice(x, y, h * 1.0, bool(rng.integers(2)), bool(rng.integers(2)))
    a = TriSurface("A", "horizon", lattice=top)
    b = TriSurface("B", "fault", lattice=wall)
    a.checked = b.checked = True  # as they are: triangles without area are not asked for here
    return (b, a) if draw(st.booleans()) else (a, b)


def usable(surfaces):
    """Whether all triangles have an area, and there are some."""
    for surface in surfaces:
        x = surface.vertices[surface.triangles]
        normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
        if not len(x) or not normal.any(axis=1).all():
            return False
    return True


def contacts_by_key(found):
    """Triangles of all contacts, and all that is known of each."""
    keys = found.key_of_face[found.rows[:, :2]]
    return {(*key, how) for key, how in zip(keys.tolist(), found.rows[:, 2].tolist(), strict=True)}


def assert_as_by_voxels(surfaces):
    """Contacts by cells and by voxels are the same; how many there are."""
    by_axes = find_contacts(surfaces)
    by_voxels = find_contacts(surfaces, method="voxels")
    assert contacts_by_key(by_axes) == contacts_by_key(by_voxels)
    np.testing.assert_array_equal(by_axes.x[by_axes.n_vertex :], by_voxels.x[by_voxels.n_vertex :])
    return len(by_axes.rows)


@given(pairs_of_grids())
def test_contacts_are_those_of_voxels(surfaces):
    if usable(surfaces):
        assert_as_by_voxels(surfaces)


@pytest.mark.parametrize("cells", [(3, 2), (9, 6), (40, 30)])
@pytest.mark.parametrize("offset", [0.0, 6.5e6])
def test_rough_grids_of_all_sizes_of_cells(rng, cells, offset):
    """Edges inside, through one edge, past corners: what heights tell is what exact signs say."""
    axis = offset + np.linspace(0.0, 30.0, 25)
    top = Lattice(axis, axis + rng.uniform(0, 0.3, 25), rng.normal(0, 0.6, (25, 25)))
    v, u = np.meshgrid(np.linspace(-3, 3, cells[1] + 1), np.linspace(1, 29, cells[0] + 1))
    bent = rng.normal(0, 3.0 / cells[0], (3, *u.shape))
    wall = Lattice(offset + 15 + v + bent[0], offset + u + bent[1], 1.5 * v + bent[2], True, False)
    surfaces = [TriSurface("A", "horizon", lattice=top), TriSurface("B", "fault", lattice=wall)]
    assert assert_as_by_voxels(surfaces) > 25


@settings(max_examples=40)
@given(st.integers(0, 2**32), st.sampled_from([1.0, 1e3, 1e6]))
def test_nodes_within_an_ulp_of_planes_and_edges(seed, offset):
    """Whole numbers moved by the last place or not: floats say nothing that is not so."""
    rng = np.random.default_rng(seed)
    axes = [offset + np.arange(5.0), offset + np.arange(4.0)]
    top = Lattice(*axes, rng.integers(-1, 2, (4, 5)) * 1.0)
    v, u = np.meshgrid(np.arange(-1.0, 2.0), np.arange(4.0))
    places = np.stack([offset + 2 + v, offset + u, rng.integers(-2, 3, u.shape) * 1.0])
    last = 2.0**-52 * (offset + 8.0)
    moved = places + rng.choice([-last, last], places.shape)
    wall = Lattice(*np.where(rng.random(places.shape) < 0.4, moved, places), True, False)
    surfaces = [TriSurface("A", "horizon", lattice=top), TriSurface("B", "fault", lattice=wall)]
    if usable(surfaces):
        assert_as_by_voxels(surfaces)


def test_points_that_doubles_place_are_the_next_doubles(rng):
    sure = 0
    for size in (1.0, 30.0, 1e3):
        for _ in range(60):
            x = rng.uniform(-1, 1, (5, 3)) * size + (4000.0, -3000.0, 1700.0)
            step = rng.uniform(-1, 1, 3) * size / 5
            x[3], x[4] = x[:3].mean(axis=0) + step, x[:3].mean(axis=0) - rng.uniform(0, 1) * step
            t = np.array([[0, 1, 2]])
            known, *place = lpi_in_doubles(x, t, 3, 4, 0)
            if not known:
                continue
            a, b, o, p, q = ([Fraction(v) for v in x[i].tolist()] for i in (3, 4, 0, 1, 2))
            n = oracles.normal_of([o, p, q])
            ha, hb = (oracles.dot(n, oracles.minus(end, o)) for end in (a, b))
            right = [float(u + (v - u) * ha / (ha - hb)) for u, v in zip(a, b, strict=True)]
            assert place == right
            sure += 1
    assert sure > 30
