"""Horizons in their store whose nodes a repair moves: the bytes of grids in memory."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.model.chunked_map import ChunkedMap
from geosurf.model.chunked_moves import with_moved_nodes
from geosurf.model.lattice import Lattice
from geosurf.triangulate import chunked

pytest.importorskip("dask.array")
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

STEP = 10.0 / 3.0  # coordinates of nodes are rounded thirds
ULP = 2.0**-51


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(chunked, "LEAST", 1)


def near_touches(seed: int, rotated: bool) -> tuple[dict, dict]:
    """Two horizons that almost touch here and there: in memory, and in random chunks."""
    rng = np.random.default_rng(seed)
    shape = rng.integers(9, 18, size=2).tolist()
    i, j = np.indices(shape)
    dims = "northing", "easting"
    places = {"northing": STEP * np.arange(shape[0]), "easting": STEP * np.arange(shape[1])}
    if rotated:
        c, s, dims = np.cos(0.3 + seed), np.sin(0.3 + seed), ("row", "column")
        x, y = 1000 + STEP * (c * j - s * i), 2000 + STEP * (s * j + c * i)
        places = {"easting": (dims, x), "northing": (dims, y)}
    top = rng.integers(-2, 3, size=shape) * 0.5
    off = rng.choice([-1, 1], size=shape) * rng.choice([1e-13, 1e-12, 1e-10], size=shape)
    base = np.where(rng.random(shape) < 0.15, top + off, top - 2 + rng.integers(-1, 2, size=shape))
    holes = (i == shape[0] - 1) & (j % 3 == 0) & (seed % 2 == 1)  # beyond the box
    chunks = dict(zip(dims, rng.integers(3, 8, size=2).tolist(), strict=True))
    grids, lazy = {}, {}
    for name, z in (("Top", top), ("Base", base)):
        z = np.where(holes, np.nan, z)
        grids[name] = xr.DataArray(z, places, dims, name, {"units": "m", "positive": "up"})
        lazy[name] = gs.triangulate_horizon(grids[name].chunk(chunks), name=name, lazy=True)
    return grids, lazy


def measured(scene: gs.Scene) -> dict[str, object]:
    """All that is asked of a model here."""
    w, e, s, n, bottom, top = scene.box
    points = np.random.default_rng(1).uniform((w, s, bottom), (e, n, top), size=(100, 3))
    return {
        "report": repr(scene.units.report), "moves": scene.patches.report,
        "words": repr(scene.warnings), "table": scene.units.table.to_dict(),
        "areas": [(u.volume, u.area, u.map_area) for u in scene.units.values()],
        "curves": scene.curves.local.tobytes(), "checks": scene.check().checks,
        "sample": scene.sample(points).to_dict(),
        "section": scene.section([(w, s), (e, n)]).to_dict(),
        "thickness": scene.thickness("Top/Base", STEP / 3.0).to_dict(),
    }  # fmt: skip


@pytest.mark.parametrize(("seed", "rotated"), [(5, False), (6, False), (4, True)])
def test_law_near_touches_are_repaired_as_in_memory(seed, rotated):
    both = near_touches(seed, rotated)
    grid = both[0]["Top"]
    x, y = (float(grid[key].mean()) for key in ("easting", "northing"))
    if rotated:
        box = (x - 3 * STEP, x + 3 * STEP, y - 3 * STEP, y + 2.9 * STEP, -6.0, 6.0)
    else:  # one digit off a column of nodes
        west, east = (float(grid.easting[k]) for k in (1, -2))
        box = (west + ULP, east, STEP / 2, float(grid.northing[-2]), -6.0, 6.0)
    plane = [[x, y - 90, -6], [x, y + 90, -6], [x + 9, y + 90, 6], [x + 2, y - 90, 6]]
    faults = {"F": gs.TriSurface("F", "fault", plane, [[0, 1, 2], [0, 2, 3]])}
    found, stored = [], None
    for of in both:
        stored = gs.Scene(of, faults, box)
        found.append(measured(stored))
    assert found[0]["moves"]["moved_vertices"] > 0
    for key, value in found[0].items():
        assert repr(found[1][key]) == repr(value), key
    assert any(one.lattice is not None and one.lattice.moved is not None
               for one in stored.patches.sources[:2])  # fmt: skip


@pytest.mark.parametrize("rotated", [False, True])
@pytest.mark.parametrize("flat", [False, True])
def test_law_readers_see_moved_nodes_and_boxes_hold_them(rotated, flat):
    # moves that are far larger than those of a repair, and across the borders of chunks
    grids, lazy = near_touches(3, rotated)
    lattice = lazy["Top"].lattice
    whole = gs.triangulate_horizon(grids["Top"], name="Top").lattice
    x, y, z = (np.array(part) for part in (*whole.horizontal(), whole.elevation))
    rng = np.random.default_rng(5)
    nodes = np.flatnonzero((rng.random(z.size) < 0.4) & np.isfinite(z.ravel()))
    far = np.array([0.0, 0.0, 9.0]) if flat else np.array([0.005, 0.005, 9.0])
    places = whole.places_of_nodes(nodes) + rng.uniform(-far, far, size=(len(nodes), 3))
    for values, new in zip((x, y, z), places.T, strict=True):
        values.flat[nodes] = new
    expected = Lattice(x, y, z, whole.rising, whole.turned)

    some = rng.choice(lattice.n_node, 20)
    _ = lattice.places_of_nodes(some)  # held as the store has them
    half = len(nodes) // 2
    first = with_moved_nodes(lattice, nodes[:half], places[:half])
    moved = with_moved_nodes(first, nodes[half:], places[half:])
    assert isinstance(moved, ChunkedMap) == (rotated or not flat)
    assert moved.fingerprint != first.fingerprint
    assert 0.0 < moved.map_height <= lattice.map_height

    every = np.arange(z.size)
    expect = np.stack([part.ravel() for part in (x, y, z)], axis=1)
    np.testing.assert_array_equal(moved.places_of_nodes(every), expect)
    np.testing.assert_array_equal(lattice.places_of_nodes(every), whole.places_of_nodes(every))
    for start, band in moved.bands():
        rows = slice(start * z.shape[1], (start + band.shape[0]) * z.shape[1])
        np.testing.assert_array_equal(band.places_of_nodes(np.arange(band.n_node)), expect[rows])
    rows, cols = np.arange(0, z.shape[0], 2), np.arange(1, z.shape[1], 3)
    np.testing.assert_array_equal(moved.elevations_at(rows, cols), z[np.ix_(rows, cols)])
    if isinstance(moved, ChunkedMap):
        for of, part in zip(moved.map_at(rows, cols), (x, y), strict=True):
            np.testing.assert_array_equal(of, part[np.ix_(rows, cols)])
        assert moved.shares_map(with_moved_nodes(lattice, nodes, places))
        assert moved.shares_map(first) == flat  # elevations alone
        assert first.shares_map(lattice) == flat

    # windows, as tiles are searched, and the boxes that choose them
    for tile in range(int(np.prod(moved.tile_shape))):
        (r, r_end), (c, c_end) = moved.store.tile(*divmod(tile, moved.tile_shape[1]))
        part = moved.window((r, r_end), (c, c_end))
        here = np.stack([of[r:r_end, c:c_end].ravel() for of in (x, y, z)], axis=1)
        np.testing.assert_array_equal(part.places_of_nodes(np.arange(part.n_node)), here)
        here = here[np.isfinite(here).all(axis=1)]
        low, high = here.min(axis=0), here.max(axis=0)
        blocks = moved.bounds.blocks[slice(*moved.bounds.starts[tile : tile + 2])]
        for boxes in (moved.bounds.boxes[tile : tile + 1], blocks):
            if len(boxes):  # tiles without cells have no block
                assert (boxes[:, :3].min(axis=0) <= low).all()
                assert (boxes[:, 3:].max(axis=0) >= high).all()
    assert expected.n_triangle == moved.n_triangle
