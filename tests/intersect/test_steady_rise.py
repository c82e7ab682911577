"""Triangles show all curves of a gentle lattice and a steep mesh, and only then is that said."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Lattice, TriSurface, intersect_surfaces
from geosurf.intersect import dial
from geosurf.kernels.smooth.steady_rise import rises_steadily
from tests.intersect.cubics import points_on

SIDE = 1000.0


def lattice_of(height, n=12):
    axis = np.linspace(0.0, SIDE, n)
    return axis, np.asarray(height(*np.meshgrid(axis, axis)), dtype=float)


def mesh_over(height, n, low, high):
    """A mesh over a square of the map, as corners and triangles."""
    x, y = (values.ravel() for values in np.meshgrid(*[np.linspace(low, high, n)] * 2))
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = [np.stack([a, a + 1, a + n + 1], 1), np.stack([a, a + n + 1, a + n], 1)]
    return np.stack([x, y, height(x, y)], 1), np.concatenate(faces)


def is_steady(axis, z, v, t):
    return rises_steadily(axis[None, :], axis[:, None], z, v, np.asarray(t)) == 1


def n_curves(axis, z, v, t, refined=1):
    """Number of curves of the cubics, drawn with many triangles for each cell, with the mesh."""
    fine = np.linspace(0.0, len(axis) - 1.0, (len(axis) - 1) * refined + 1)
    w = np.stack(np.meshgrid(fine, fine), -1).reshape(-1, 2)
    cubic = points_on(axis[None, :], axis[:, None], z, w)[:, 2].reshape(len(fine), -1)
    x = np.interp(fine, np.arange(len(axis)), axis)
    top = TriSurface("Top", "horizon", lattice=Lattice(x, x, cubic))
    return intersect_surfaces([top, TriSurface("F", "fault", v, t)]).n_curve


def random_world(rng):
    """A wavy lattice, and a mesh that is bent a little; some are nearly tangent somewhere."""
    wave = rng.uniform(250, 900, 2)
    relief, phase = rng.uniform(2, 40), rng.uniform(0, 6, 2)
    axis, z = lattice_of(
        lambda x, y: relief * np.sin(x / wave[0] + phase[0]) * np.cos(y / wave[1] + phase[1])
    )
    dip, bend = rng.uniform(-0.3, 0.3, 2), rng.uniform(0, 20)
    low, high = rng.choice([(-100.0, 1100.0), (130.0, 870.0)])
    level = rng.uniform(-1, 1) * relief
    n = int(rng.integers(2, 6))
    v, t = mesh_over(lambda x, y: level + dip[0] * (x - 500) + dip[1] * (y - 500), n, low, high)
    v[:, 2] += bend * rng.normal(size=len(v))
    return axis, z, v, t


def test_where_it_is_steady_cubics_have_the_curves_that_triangles_show():
    rng, said = np.random.default_rng(5), []
    for _ in range(50):
        world = random_world(rng)
        said.append(is_steady(*world))
        if said[-1]:
            assert n_curves(*world) == n_curves(*world, refined=8)
    assert 10 < sum(said) < 45


def dome(x, y):
    return 40 - ((x - 500) ** 2 + (y - 500) ** 2) / 20_000  # its top is inside a cell


ROOF = [(100, 500, 40.05), (900, 500, 40.05), (500, 100, -90.0), (500, 900, -90.0)]
HIDDEN = {  # curves that cubics have, and triangles do not show
    "top of a dome": (dome, [(0, 0, 39.93), (1000, 0, 39.93), (500, 1000, 39.93)], [(0, 1, 2)]),
    "ridge": (lambda x, y: 80 - dome(x, y), ROOF, [(0, 1, 2), (0, 3, 1)]),
    "peak": (lambda x, y: 40 + ((x - 500) ** 2 + (y - 500) ** 2) / 20_000,
             [(500, 500, 40.05), (100, 100, -400), (900, 100, -400), (500, 900, -400)],
             [(0, 1, 2), (0, 2, 3), (0, 3, 1)]),
    "tip": (lambda x, y: 40 + ((x - 500) ** 2 + (y - 500) ** 2) / 20_000,
            [(500, 500, 40.05), (100, 540, -400), (900, 540, -400)], [(0, 1, 2)]),
    "rim": (lambda x, y: dome(x, 500) + y / 2,
            [(0, -100, 39.93), (1000, -100, 39.93), (500, 900, 39.93)], [(0, 1, 2)]),
}  # fmt: skip


@pytest.mark.parametrize("name", HIDDEN)
def test_what_triangles_do_not_show_is_never_steady(name):
    height, v, t = HIDDEN[name]
    world = *lattice_of(height), np.array(v, dtype=float), np.array(t)
    assert not is_steady(*world)
    assert n_curves(*world, refined=16) > n_curves(*world)


def test_steady_pairs_are_not_searched_cell_by_cell(monkeypatch):
    """A coarse lattice and a fault get smooth curves, and no cubic is made but along them."""
    monkeypatch.setattr(dial, "sides_of", lambda *_: pytest.fail("cells were searched"))
    axis, z = lattice_of(lambda x, y: 30 * np.sin(x / 300) * np.cos(y / 250), 24)
    top = TriSurface("Top", "horizon", lattice=Lattice(axis, axis, z))
    corners = [(400, -50, -500), (400, 1050, -500), (700, 1050, 500), (700, -50, 500)]
    fault = TriSurface("F", "fault", corners, [(0, 1, 2), (0, 2, 3)])
    curves = intersect_surfaces([top, fault], tolerance=0.05)
    assert curves.n_curve == 1
    assert curves.error_bound[0] <= 0.05


def test_uneven_axes_are_never_steady():
    axis, z = lattice_of(lambda x, y: 0 * x)
    v = np.array([(400, 100, -500), (400, 900, -500), (700, 500, 500)], dtype=float)
    assert is_steady(axis, z, v, [(0, 1, 2)])
    assert not is_steady(axis**1.1, z, v, [(0, 1, 2)])
