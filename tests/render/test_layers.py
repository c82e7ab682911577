"""What is shown, before anything is drawn."""

import numpy as np
import pytest

from geosurf.model import Lattice, TriSurface
from geosurf.render import surface_layers
from geosurf.render.surface_layers import Shell


def big_surface(n_row, n_col, rotated=False):
    x, y = np.arange(n_col) * 25.0, np.arange(n_row) * 25.0
    if rotated:
        x, y = np.meshgrid(x, y)
        x, y = 0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y
    return TriSurface("Top", "horizon", lattice=Lattice(x, y, np.zeros((n_row, n_col))))


@pytest.mark.parametrize("rotated", [False, True])
def test_a_big_grid_is_strided_to_its_border_and_its_own_triangles_are_never_made(rotated):
    surface = big_surface(1501, 2003, rotated)
    light = surface_layers.thinned(surface)
    assert 100_000 < light.n_triangle <= surface_layers.MOST
    assert "triangles" not in vars(surface)
    np.testing.assert_array_equal(light.vertices.min(axis=0), surface.vertices.min(axis=0))
    np.testing.assert_array_equal(light.vertices.max(axis=0), surface.vertices.max(axis=0))


@pytest.mark.parametrize("n", [226, 240, 300, 500])
def test_a_grid_that_is_hardly_too_large_loses_hardly_any_triangles(n):
    """Every second row of 240 would leave a quarter, and cells five pixels wide."""
    light = surface_layers.thinned(big_surface(n, n), 100_000)
    assert 0.95 * 100_000 < light.n_triangle <= 100_000
    x = light.lattice.easting
    assert np.diff(x).max() <= 2.0 * np.diff(x).min() + 25.0


def test_a_larger_picture_shows_more_triangles():
    every = [big_surface(900, 900)]
    count = [
        len(surface_layers.show_surfaces(every, size=size, zoom=zoom).layers[0].triangles)
        for size, zoom in [((1280, 800), 1.0), ((1280, 800), 1.5), ((2560, 1600), 1.0)]
    ]
    assert count[0] < 110_000 < 200_000 < count[1] < 300_000 < count[2]


def test_surfaces_of_a_picture_share_its_triangles():
    x = np.arange(401.0)
    flat = Lattice(x, x, np.zeros((401, 401)))
    every = [TriSurface(f"H{k}", "horizon", lattice=flat) for k in range(12)]
    content = surface_layers.show_surfaces(every)
    count = [len(layer.triangles) for layer in content.layers if layer.triangles is not None]
    assert len(count) == 12
    assert min(count) > 50_000
    assert sum(count) <= surface_layers.MAX_TRIANGLE


def test_blocks_move_sideways_and_zones_up_and_down(units):
    shifts = dict(zip(units, surface_layers.explosion(units, 0.5), strict=True))
    west, east = shifts["Top/Base, F1-"], shifts["Top/Base, F1+"]
    assert west[0] < 0 < east[0]
    assert west[2] == east[2] == 0.0
    height = units.box[5] - units.box[4]
    assert shifts["above Top, F1-"][2] == 0.5 * height
    assert shifts["below Base, F1-"][2] == -0.5 * height
    np.testing.assert_array_equal(shifts["above Top, F1-"][:2], west[:2])
    assert all((shift == 0.0).all() for shift in surface_layers.explosion(units, 0.0))


def test_the_outline_of_a_block_closes_and_skips_flat_sides(units):
    unit = units["Top/Base, F1-"]
    shell = Shell(unit.vertices, unit.triangles, unit.surface_of_triangle)
    edges = surface_layers.outline(shell)
    assert (np.bincount(edges.ravel())[np.unique(edges)] >= 2).all()
    n_rim = 2 * 4 * 11 + 4  # two rims of 4 x 11 edges, and four corners
    assert len(edges) == n_rim
