"""Rims of grids with holes against edges with one triangle, whole and in ranges of rows."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.triangulate import footprint


@pytest.mark.parametrize("seed", range(12))
def test_law_ranges_of_rows_hold_all_of_a_rim(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(6, 18, size=2).tolist())
    row, col = np.indices(shape)
    absent = (row + col < rng.integers(0, 6)) | (rng.random(shape) < (0.0, 0.05, 0.3)[seed % 3])
    way = 1 - 2 * (seed & 1)  # falling axes turn the triangles
    grid = xr.DataArray(
        np.where(absent, np.nan, 1.0 * col),
        {"northing": 10.0 * np.arange(shape[0]), "easting": 10.0 * np.arange(shape[1])[::way]},
        ("northing", "easting"), attrs={"units": "m", "positive": "up"},
    )  # fmt: skip
    one = gs.triangulate_horizon(grid, name="Top")

    # the oracle: edges that no triangle has the other way round
    t = one.triangles
    edges = {(int(a), int(b)) for k in range(3) for a, b in zip(t[:, k], t[:, k - 2], strict=True)}
    rim = [(*one.vertices[a, :2], *one.vertices[b, :2])
           for a, b in edges if (b, a) not in edges]  # fmt: skip
    for at_once in (1 << 22, 3 * shape[1], 1):
        monkeypatch.setattr(footprint, "_AT_ONCE", at_once)
        found = footprint._rim_of_lattice(one.lattice)
        assert sorted(map(tuple, found.reshape(-1, 4).tolist())) == sorted(rim)
