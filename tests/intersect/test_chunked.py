"""Horizons that stay in their store: the same bytes as in memory, for any chunks."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.triangulate import chunked

da = pytest.importorskip("dask.array")


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(chunked, "LEAST", 1)


def grid(z: np.ndarray, *, origin: float = 0.0, flip: tuple[int, int] = (1, 1)) -> xr.DataArray:
    """A grid of 25 m; rows or columns may run backwards."""
    y, x = (origin + 25.0 * np.arange(n)[::way] for n, way in zip(z.shape, flip, strict=True))
    coords = {"northing": y, "easting": x}
    return xr.DataArray(z, dims=("northing", "easting"), coords=coords, attrs={"units": "m"})


def parts(rng: np.random.Generator, n: int) -> tuple[int, ...]:
    """A random division of n nodes into chunks, of one node, too."""
    cuts = np.unique(rng.integers(1, n, size=rng.integers(0, 5)))
    return tuple(np.diff([0, *cuts.tolist(), n]).tolist())


def both_ways(rng: np.random.Generator, of: xr.DataArray, name: str, positive: str = "up"):
    """A horizon in memory, and the same in random chunks."""
    lazy = of.copy(data=da.from_array(of.values, chunks=tuple(parts(rng, n) for n in of.shape)))
    how = {"name": name, "positive": positive}
    return gs.triangulate_horizon(of, **how), gs.triangulate_horizon(lazy, **how, lazy=True)


def assert_same(one: gs.Curves, two: gs.Curves) -> None:
    for key in ("local", "origin", "segments", "surfaces_of_segment", "surfaces_of_curve"):
        assert getattr(one, key).tobytes() == getattr(two, key).tobytes(), key
    assert len(one.curves) == len(two.curves)
    assert all(np.array_equal(a, b) for a, b in zip(one.curves, two.curves, strict=True))
    assert repr(one.contacts) == repr(two.contacts)


def faults() -> list[gs.TriSurface]:
    """A plane of two triangles along nodes, a bent grid, and a level plane."""
    plane = [[100, -50, -40], [200, 700, -40], [200, 700, 40], [100, -50, 40]]
    u, w = np.meshgrid(np.linspace(-100, 700, 17), np.linspace(-40, 40, 9))
    bent = gs.Lattice(u, 200 + 40 * np.sin(u / 100) + 0.5 * w, w, reverse=False)
    level = [[-50, -50, 0], [700, -50, 0], [700, 700, 0], [-50, 700, 0]]
    two = [[0, 1, 2], [0, 2, 3]]
    return [
        gs.TriSurface("Plane", "fault", plane, two),
        gs.TriSurface("Bent", "fault", lattice=bent),
        gs.TriSurface("Level", "fault", level, two),
    ]


@pytest.mark.parametrize("seed", range(4))
def test_law_any_chunks_give_the_curves_of_a_grid_in_memory(seed):
    # small whole numbers: contacts in nodes, along edges and over areas
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(6, 18, size=2))
    holes = np.where(rng.random(shape) < 0.05, np.nan, 0.0) if seed % 3 == 0 else 0.0
    if seed == 0:
        holes[: shape[0] // 2, : shape[1] // 2] = np.nan  # chunks without a node
    flip = (1 - 2 * (seed & 1), 1 - (seed & 2))
    top, lazy_top = both_ways(
        rng, grid(rng.integers(-2, 3, size=shape) * 4.0 + holes, flip=flip), "Top"
    )
    mid, lazy_mid = both_ways(rng, grid(rng.integers(-2, 3, size=shape) * 4.0), "Mid", "down")
    off, lazy_off = both_ways(
        rng, grid(rng.integers(-3, 3, size=(9, 11)) * 5.0, origin=37.0), "Off"
    )

    expected = gs.intersect_surfaces([top, mid, off, *faults()])
    assert expected.n_curve > 5
    assert_same(gs.intersect_surfaces([lazy_top, lazy_mid, lazy_off, *faults()]), expected)
    assert_same(gs.intersect_surfaces([lazy_top, mid]), gs.intersect_surfaces([top, mid]))
    assert_same(gs.intersect_surfaces([off, lazy_mid]), gs.intersect_surfaces([off, mid]))


def test_law_windows_of_large_tiles_miss_nothing():
    # tiles of several blocks of 64 x 64 cells; faults of two long triangles, askew and along blocks
    rng = np.random.default_rng(3)
    z = rng.integers(-2, 3, size=(150, 200)) * 2.0
    top, lazy_top = both_ways(rng, grid(z), "Top")
    base, lazy_base = both_ways(rng, grid(z[::-1] - 7.0), "Base")
    askew = [[-90, 300, -30], [5100, 3300, -30], [5130, 3300, 30], [-60, 300, 30]]
    along = [[1600, -50, -30], [1600, 4000, -30], [1600, 4000, 30], [1600, -50, 30]]
    two = [[0, 1, 2], [0, 2, 3]]
    cut = [gs.TriSurface(k, "fault", v, two) for k, v in (("Askew", askew), ("Along", along))]
    expected = gs.intersect_surfaces([top, base, *cut])
    assert_same(gs.intersect_surfaces([lazy_top, lazy_base, *cut]), expected)


def test_only_chunks_near_the_other_surface_are_read(monkeypatch):
    z = np.add.outer(np.zeros(60), 0.1 * np.arange(60.0))
    lazy = grid(z).copy(data=da.from_array(z, chunks=(10, 10)))
    top = gs.triangulate_horizon(lazy, positive="up", lazy=True)
    read = []
    kind = type(top.lattice.store)
    values = kind._values
    monkeypatch.setattr(kind, "_values", lambda *of: read.append(of[1:]) or values(*of))

    # a fault along northing in the third column of chunks, and one far below
    at = [[600, -50, -40], [600, 1600, -40], [610, 1600, 40], [610, -50, 40]]
    deep = [[600, -50, -400], [600, 1600, -400], [610, 1600, -300], [610, -50, -300]]
    two = [[0, 1, 2], [0, 2, 3]]
    gs.intersect_surfaces([top, gs.TriSurface("Deep", "fault", deep, two)])
    assert read == []
    gs.intersect_surfaces([top, gs.TriSurface("F", "fault", at, two)])
    assert sorted(read) == [((10 * i, 10 * i + 10), (20, 30)) for i in range(6)]


def test_chunks_that_cannot_be_read_are_an_error_of_geosurf():
    def broken(block):
        raise OSError("checksum mismatch")

    z = da.zeros((20, 20), chunks=(7, 7)).map_blocks(broken, dtype=float, meta=np.empty((0, 0)))
    with pytest.raises(gs.errors.HorizonError, match=r"'Top'.*cannot be read.*checksum mismatch"):
        gs.triangulate_horizon(
            grid(np.zeros((20, 20))).copy(data=z), name="Top", positive="up", lazy=True
        )


@pytest.mark.parametrize(
    ("change", "how", "words"),
    [
        (lambda g: g.compute(), {}, "values are in memory"),
        (lambda g: g, {"tolerance": 1.0}, "the grid is small"),
        (lambda g: g.where(g != 3.0), {"tolerance": 1.0}, "absent nodes"),
        (lambda g: g, {"lazy": "yes"}, "lazy"),
        (lambda g: g.where(g != 3.0, np.inf), {}, "infinite|inf m"),
        (lambda g: g.where(g < -5.0), {}, "no triangle"),
        (lambda g: g.isel(easting=[0, 2, 1, 3]), {}, "easting"),
    ],
)
def test_grids_that_cannot_stay_in_their_store_are_refused(change, how, words):
    z = np.arange(400.0).reshape(20, 20)
    lazy = change(grid(z).copy(data=da.from_array(z, chunks=7)))
    with pytest.raises(gs.errors.InputError, match=words):
        gs.triangulate_horizon(lazy, positive="up", **{"lazy": True, **how})


def test_chunks_that_are_too_long_are_refused(monkeypatch):
    monkeypatch.setattr(chunked, "MOST", 100)
    lazy = grid(np.zeros((20, 20))).chunk({"northing": 7, "easting": 7})
    with pytest.raises(gs.errors.HorizonError, match="shorter chunks"):
        gs.triangulate_horizon(lazy, positive="up", lazy=True)
