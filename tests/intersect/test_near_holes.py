"""Two lattices that meet at a hole take the exact curve first; elsewhere walks stay."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Lattice, TriSurface, intersect_surfaces
from geosurf.intersect import dial
from geosurf.intersect.near_holes import meet_at_holes
from geosurf.kernels.smooth.near_blocks import blocks_at_holes


def grids(east, north, radius=200.0, n=161):
    """Waves with a hole, and a gentle second grid."""
    x, y = np.linspace(0.0, 4000.0, n), np.linspace(0.0, 3000.0, n)
    e, m = np.meshgrid(x, y)
    z = 60 * np.sin(e / 600) * np.cos(m / 500)
    z[np.hypot(e - east, m - north) < radius] = np.nan
    gentle = 0.03 * (e - 2000) + 0.01 * (m - 1500) + 5 * np.sin(e / 900)
    return [
        TriSurface(name, "horizon", lattice=Lattice(x, y, values))
        for name, values in (("Top", z), ("Base", gentle))
    ]


@pytest.mark.parametrize("flip", [False, True])
def test_a_hole_on_the_curve_takes_no_walk(flip, monkeypatch):
    pair = grids(2000.0, 1500.0, n=221)[:: -1 if flip else 1]
    assert meet_at_holes(*pair)
    monkeypatch.setattr(dial, "sides_of", lambda *_: pytest.fail("a walk was tried"))
    curves = intersect_surfaces(pair, tolerance=0.03)
    assert {place.reason for place in curves.places} == {"hole"}


def test_a_hole_off_the_curve_is_walked_past(monkeypatch):
    pair = grids(942.0, 400.0, 60.0, n=401)
    assert not meet_at_holes(*pair)
    monkeypatch.setattr(dial, "exact_curves", lambda *_: pytest.fail("triangles were intersected"))
    curves = intersect_surfaces(pair, tolerance=0.03)
    assert curves.error_bound.max() <= 0.03


def test_every_block_whose_stencils_read_a_hole_is_marked():
    rng = np.random.default_rng(2)
    for _ in range(20):
        z = rng.normal(size=rng.integers(20, 60, 2))
        i, j = (int(rng.integers(0, n)) for n in z.shape)
        z[i, j] = np.nan
        x, y = np.zeros((1, z.shape[1])), np.zeros((z.shape[0], 1))
        blocks = tuple(-(-(n - 1) // 8) for n in z.shape)
        marked = blocks_at_holes(x, y, z, *blocks, 8).reshape(blocks)
        for cell in np.ndindex(z.shape[0] - 1, z.shape[1] - 1):
            reads = all(-4 <= at - c <= 5 for at, c in zip((i, j), cell, strict=True))
            assert marked[cell[0] // 8, cell[1] // 8] or not reads
        assert marked.sum() <= 16
