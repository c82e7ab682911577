"""Horizons in their store with a tolerance: grids in memory, as if all nodes had been there."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.model import Lattice
from geosurf.triangulate import chunked, decimate
from geosurf.triangulate.decimate import Differences, Frame, kept_nodes, measure_differences

pytest.importorskip("dask")

FAULT = gs.TriSurface(
    "F1", "fault", [[90, -50, -900], [110, 250, -900], [110, 250, 0], [90, -50, 0]],
    [[0, 1, 2], [0, 2, 3]],
)  # fmt: skip
BOX = (10, 190, 10, 190, -300, 0)


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(chunked, "LEAST", 1)
    monkeypatch.setattr(decimate, "ENOUGH", 100)


def grid_of(z, chunks=None):
    axes = {"northing": np.linspace(0.0, 200.0, len(z)), "easting": np.linspace(0, 200, len(z[0]))}
    attrs = {"units": "m", "positive": "up"}
    made = xr.DataArray(z, axes, ("northing", "easting"), attrs=attrs)
    return made if chunks is None else made.chunk(dict(zip(made.dims, chunks, strict=True)))


def chunks_of(n, rng):
    """Random sizes of chunks, one row among them."""
    cuts = rng.choice(np.arange(1, n), size=min(5, n - 1), replace=False)
    return tuple(np.diff([0, *np.sort(cuts), n]).tolist())


def waves(level, n=101, shift=0.0):
    x = np.linspace(0.0, 200.0, n)
    return level + 8.0 * np.sin(x / 30 + shift)[:, None] * np.cos(x / 40)


@pytest.mark.parametrize("seed", range(12))
def test_law_differences_are_those_of_a_grid_in_memory(seed):
    rng = np.random.default_rng(seed)
    shape = rng.integers(13, 60, 2).tolist()
    z = np.cumsum(rng.normal(size=shape), axis=0)
    stored = gs.triangulate_horizon(
        grid_of(z, [chunks_of(n, rng) for n in shape]), name="Top", lazy=True
    ).lattice
    whole = Lattice(stored.easting, stored.northing, z)
    rows, cols = (kept_nodes(n, int(rng.integers(2, 11))) for n in shape)
    nodes = Frame.of_nodes(whole, rows, cols)
    one, two = (measure_differences(of, nodes, np.inf) for of in (whole, stored))
    for key in ("elevation", "largest", "volume", "change", "doubt"):
        np.testing.assert_array_equal(getattr(one, key), getattr(two, key))

    # the limit ends both, and the place is one that exceeds it
    limit = float(np.median(one.largest.max(axis=1)))
    failed = measure_differences(stored, nodes, limit)
    assert one.largest[int(failed * (len(rows) - 1))].max() > limit
    found = measure_differences(stored, nodes, one.largest.max())
    assert isinstance(found, Differences)


@pytest.mark.parametrize("tolerance", [0.05, 0.2, 1.5])
def test_law_models_are_those_of_grids_in_memory(tolerance):
    rng = np.random.default_rng(1)
    grids = {"Top": waves(-100.0), "Base": waves(-130.0, shift=0.3)}
    lazy = {
        name: gs.triangulate_horizon(
            grid_of(z, [chunks_of(n, rng) for n in z.shape]), name=name, lazy=True
        )
        for name, z in grids.items()
    }
    given = {name: grid_of(z) for name, z in grids.items()}
    one, two = (gs.Scene(of, {"F1": FAULT}, BOX, tolerance=tolerance) for of in (given, lazy))
    shape = one.surface("Top").lattice.shape
    assert two.surface("Top").lattice.shape == shape
    assert shape[0] < 101
    assert one.units.table.identical(two.units.table)
    for name in one.units:
        np.testing.assert_array_equal(one.units[name].vertices, two.units[name].vertices)
    assert two.volume_error_bound == one.volume_error_bound > 0.0
    table = gs.build_grid(two, cell=20.0, layers=2).table
    assert float(table.volume.sum()) == pytest.approx(float(table.exact.sum()), rel=1e-3)
    np.testing.assert_array_equal(one.curves.points, two.curves.points)


def test_one_horizon_that_needs_all_nodes_keeps_those_of_its_frame():
    grids = {"Top": waves(-100.0), "Base": waves(-130.0)}
    grids["Base"][77, 31] += 5.0
    lazy = {
        name: gs.triangulate_horizon(grid_of(z, (30, 40)), name=name, lazy=True)
        for name, z in grids.items()
    }
    scene = gs.Scene(lazy, {"F1": FAULT}, BOX, tolerance=1.5)
    assert scene.surface("Top").lattice.shape == (101, 101)
    with pytest.raises(gs.errors.HorizonError, match="one in 2 rows and columns is farther off"):
        gs.triangulate_horizon(grid_of(grids["Base"], (30, 40)), lazy=True, tolerance=1.5)
    top = gs.triangulate_horizon(grid_of(grids["Top"], (30, 40)), lazy=True, tolerance=1.5)
    assert top.lattice.shape[0] < 51


def test_a_horizon_with_fewer_nodes_is_torn_as_any_grid():
    z = waves(-100.0) + 12 / (1 + np.exp(100.0 - np.linspace(0.0, 200.0, 101)))
    top = gs.triangulate_horizon(grid_of(z, (30, 40)), name="Top", lazy=True, tolerance=3.0)
    scene = gs.Scene({"Top": top}, {"F1": FAULT}, BOX, tear=True)
    assert len(scene.units) == 4
    assert scene.check().ok

    # near faults nobody knows what the nodes that are left out would change
    assert np.isinf(scene.volume_error_bound)
    assert np.isinf(gs.Scene(scene.sheets, {"F1": FAULT}, BOX).volume_error_bound)

    # its bound is that of all nodes: no more nodes are left out of it
    again = gs.Scene({"Top": top}, {"F1": FAULT}, BOX, tolerance=50.0)
    assert again.surface("Top").lattice.shape == top.lattice.shape
