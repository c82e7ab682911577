"""Coordinates from the least to the largest numbers: a right answer, or a refusal with a range."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import TriSurface, intersect_surfaces, intersect_triangles, rebuild_surfaces
from geosurf.errors import InputError, SurfaceError
from geosurf.kernels.exact.predicates import MAX_COORDINATE, MIN_COORDINATE
from tests.arrangement import extremes
from tests.strategies import soup


@pytest.mark.parametrize("kind", range(len(extremes.KINDS)))
def test_any_size(kind):
    for seed in range(4):
        extremes.check(kind + seed * len(extremes.KINDS))


@pytest.mark.parametrize("size", [1e-300, 1e-317, 5e-324])
def test_the_surface_whose_numbers_are_too_small_is_named(size):
    """Rounding errors below the least normal number once counted as none: memory was overrun."""
    flat = soup("A", [[(0, 0, 0), (4 * size, 0, 0), (0, 4 * size, 0)]])
    wall = soup("B", [[(size, size, -size), (size, size, size), (9 * size, 0, size)]])
    for function in (intersect_surfaces, rebuild_surfaces):
        with pytest.raises(InputError, match=r"surface 'A' has a coordinate of .*0 and sizes from"):
            function([flat, wall])
    with pytest.raises(SurfaceError, match="triangle P has a coordinate too close to 0"):
        intersect_triangles(flat.vertices, wall.vertices)


def test_what_does_not_meet_may_be_as_small_as_it_likes():
    tiny = soup("A", [[(0, 0, 1), (1e-250, 0, 1), (0, 1, 1)]])
    below = soup("B", [[(0, 0, 0), (4, 0, 0), (0, 4, 0)]])
    assert intersect_surfaces([tiny, below]).n_curve == 0
    assert rebuild_surfaces([tiny, below]).n_triangle == 2


@pytest.mark.parametrize("size", [MIN_COORDINATE, 2.0**-240, 1.0, MAX_COORDINATE / 4])
def test_the_sizes_that_are_promised_are_taken(size):
    """Coordinates with all of their digits, at both ends of the range."""
    rng = np.random.default_rng(5)
    corners = size * (1 + rng.random((4, 3, 3)))
    surfaces = [soup("A", corners[:2]), soup("B", corners[2:])]
    small, plain = (
        rebuild_surfaces(
            [TriSurface(s.name, s.role, s.vertices * k, s.triangles) for s in surfaces]
        )
        for k in (1.0, 1.0 / size)
    )
    assert small.report["cut_triangles"] == plain.report["cut_triangles"]
    assert intersect_surfaces(surfaces).n_curve == intersect_surfaces(surfaces[::-1]).n_curve
