"""What is shown, before anything is drawn."""

import numpy as np
import pytest

from geosurf.model import Lattice, TriSurface
from geosurf.render import surface_layers


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


def test_blocks_move_sideways_and_zones_up_and_down(units):
    shifts = dict(zip(units, surface_layers.explosion(units, 0.5), strict=True))
    west, east = shifts["Top/Base F1-"], shifts["Top/Base F1+"]
    assert west[0] < 0 < east[0]
    assert west[2] == east[2] == 0.0
    height = units.box[5] - units.box[4]
    assert shifts["above Top F1-"][2] == 0.5 * height
    assert shifts["below Base F1-"][2] == -0.5 * height
    np.testing.assert_array_equal(shifts["above Top F1-"][:2], west[:2])
    assert all((shift == 0.0).all() for shift in surface_layers.explosion(units, 0.0))
