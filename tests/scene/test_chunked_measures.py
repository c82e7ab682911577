"""Maps, samples and sections of horizons that stay in their store: as of grids in memory."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.measure import locate, parts
from geosurf.model import Unit
from geosurf.triangulate import chunked

pytest.importorskip("dask.array")
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

STEP = 25.0


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(chunked, "LEAST", 1)


def scenes(seed: int, holes: bool, **options) -> tuple[gs.Scene, gs.Scene, xr.DataArray]:
    """A model in memory and the same in chunks: whole numbers, so that places lie on nodes."""
    rng = np.random.default_rng(seed)
    shape = 17, 21
    axes = {"northing": STEP * np.arange(shape[0]), "easting": STEP * np.arange(shape[1])}
    row, col = np.indices(shape)
    rim = (row + col < 5) | (row - col > 13) | ((row == 16) & (col > 8))
    grids, lazy = {}, {}
    for name, shift in (("Top", 0.0), ("Base", 5.0 + 20.0 * (seed % 2))):
        z = rng.integers(-2, 3, size=shape) * 4.0 - shift
        grid = xr.DataArray(
            np.where(rim & holes, np.nan, z), axes, ("northing", "easting"), name,
            {"units": "m", "positive": "up"},
        )  # fmt: skip
        grids[name] = grid
        chunks = {"northing": int(rng.integers(3, 9)), "easting": int(rng.integers(3, 9))}
        lazy[name] = gs.triangulate_horizon(grid.chunk(chunks), name=name, lazy=True)
    plane = [[180, -50, -90], [240, 500, -90], [270, 500, 90], [210, -50, 90]]
    # a grid in memory among those in chunks, as faults and contacts may be
    u, w = np.meshgrid(np.linspace(-20, 520, 7), np.linspace(-80, 80, 5))
    bent = gs.Lattice(u, 300 + 0.2 * u + 0.3 * w, w, reverse=False)
    faults = {
        "F1": gs.TriSurface("F1", "fault", plane, [[0, 1, 2], [0, 2, 3]]),
        "F2": gs.TriSurface("F2", "fault", lattice=bent),
    }
    return gs.Scene(grids, faults, **options), gs.Scene(lazy, faults, **options), grids["Top"]


@pytest.mark.parametrize(
    ("seed", "holes", "options"),
    [(1, False, {}), (2, True, {}), (3, True, {"contacts": {"OWC": -9.0}})],
)
def test_law_measures_are_those_of_grids_in_memory(seed, holes, options):
    one, two, grid = scenes(seed, holes, **options)
    w, e, s, n, bottom, top = one.box
    rng = np.random.default_rng(seed)
    places = rng.uniform((w - 30, s - 30, bottom), (e + 30, n + 30, top), size=(400, 3))
    places[::2, :2] = np.rint(places[::2, :2] / STEP) * STEP  # on lines of nodes, and on nodes
    places[::3, 2] = np.rint(places[::3, 2])
    upright = [[200.0, 200.0, top - 1], [200.0, 200.0, bottom + 1], [300.0, 225.0, top - 2]]
    picks = zip(("easting", "northing", "elevation"), places[:40].T, strict=True)
    names = {"well": ["W"] * 40, "horizon": ["Top", "Base"] * 20}
    tops = names | {key: of.tolist() for key, of in picks}
    asks = [
        lambda m: m.thickness("Top/Base"),
        lambda m: m.thickness("Top/Base", grid),  # in nodes
        lambda m: m.thickness("above Top", 11.0),
        lambda m: m.thickness("Top/Base", 30.0, kind="isopach"),
        lambda m: m.sample(places),
        lambda m: m.sample(places, distance=True),
        lambda m: m.sample(places - [0.0, 0.0, 500.0], distance=True),  # far below
        lambda m: m.sample(cell=(17.0, 23.0, 5.0), codes=True),
        lambda m: m.section([(w, 100.0), (e, 100.0)]),  # along nodes
        lambda m: m.section([(150.0, n), (150.0, s)]),
        lambda m: m.section([(w + 1, s), (e, n - 7), (w, n - 20)]),
        lambda m: m.well_intervals({"A": places[:5], "B": upright}),
        lambda m: m.well_intervals(upright[:2]),
        lambda m: m.misfit(tops),
    ]
    if options:
        asks.append(lambda m: m.thickness("Top/Base", 20.0, contact="above OWC"))
    for ask in asks:
        assert ask(one).identical(ask(two))
    for unit, same in zip(one.units.values(), two.units.values(), strict=True):
        assert unit.n_triangle == len(unit.triangles)
        assert repr(unit) == repr(same)
        assert unit.zone_map_area == same.zone_map_area
        listed = Unit.zone_map_area.func(unit)  # one by one
        assert unit.zone_map_area == pytest.approx(listed, rel=1e-9, abs=1e-6)
    for line in ([(0.0, -90.0), (9.0, -90.0)], [(0.0, 9e5), (1.0, 9e5)]):
        with pytest.raises(gs.errors.InputError, match="outside the model"):
            two.section(line)


def test_samples_and_sections_read_the_chunks_at_their_places(monkeypatch):
    _, lazy, _ = scenes(1, holes=False)
    _ = lazy.units
    lattice = lazy.surface("Top").lattice
    kind, seen = type(lattice), set()
    chunk = kind._chunk
    monkeypatch.setattr(
        kind, "_chunk",
        lambda self, i, j: seen.add((self.store.name, i, j)) or chunk(self, i, j),
    )  # fmt: skip
    for one in (lazy.surface(name).lattice for name in ("Top", "Base")):
        one._held.nodes = np.empty(0, dtype=np.int64), np.empty(0)
    lazy.sample([[30.0, 30.0, -10.0]])
    assert seen
    assert len(seen) <= 4
    n = sum(int(np.prod(lazy.surface(name).lattice.tile_shape)) for name in ("Top", "Base"))
    lazy.section([(40.0, 30.0), (41.0, 399.0)])
    assert len(seen) < n / 2


def test_law_pieces_that_touch_nothing_are_placed_as_in_memory():
    # an island beyond the area, in a corner of its bounds
    row, col = np.indices((19, 19))
    z = np.where(np.abs(row - 9) + np.abs(col - 9) < 8, 0.0, np.nan)
    z[[13, 14, 14], [4, 4, 5]] = 3.0  # one triangle
    axes = {"northing": STEP * np.arange(19), "easting": STEP * np.arange(19)}
    attrs = {"units": "m", "positive": "up"}
    grids = {
        name: xr.DataArray(z + 0.01 * row * col - k, axes, ("northing", "easting"), attrs=attrs)
        for name, k in (("Top", 0.0), ("Base", 20.0))
    }
    lazy = {
        name: gs.triangulate_horizon(grid.chunk(5), name=name, lazy=True)
        for name, grid in grids.items()
    }
    middle = STEP * np.array([[9, 3.2], [14.8, 9], [9, 14.8], [3.2, 9]])
    one, two = (gs.Scene(of, {}, aoi=middle) for of in (grids, lazy))
    assert one.units.table.identical(two.units.table)
    assert repr(one.units.report) == repr(two.units.report)


def test_law_pictures_draw_the_nodes_of_grids_in_memory():
    from geosurf.render.surface_layers import thinned

    one, two, _ = scenes(2, holes=True)
    for most in (100, 10**6):
        for name in ("Top", "Base"):
            drawn, read = (thinned(scene.surface(name), most) for scene in (one, two))
            assert drawn.vertices.tobytes() == read.vertices.tobytes()
            assert drawn.triangles.tobytes() == read.triangles.tobytes()
    two.plot_map("Top")
    two.plot_section([(150.0, 20.0), (150.0, 380.0)])


def test_a_model_takes_candidates_from_its_curves(monkeypatch):
    from geosurf.arrangement import candidates

    _, lazy, _ = scenes(1, holes=False, box=(10, 490, 10, 390, -70, 40))
    searched = []
    tiles = candidates.pairs_by_tiles
    monkeypatch.setattr(
        candidates, "pairs_by_tiles",
        lambda of, *rest: searched.append({one.name for one in of}) or tiles(of, *rest),
    )  # fmt: skip
    curves, table = lazy.curves, lazy.units.table
    assert not [pair for pair in searched if searched.count(pair) > 1]
    monkeypatch.undo()
    other = lazy.replace(faults={"F2": None}).replace(faults={"F2": lazy.surface("F2")})
    assert other.units.table.identical(table)
    assert other.curves.local.tobytes() == curves.local.tobytes()


def test_few_places_above_many_chunks_list_what_is_near_them_once(monkeypatch):
    """As each listing passes over all that curves touch."""
    _, scene, _ = scenes(1, False)
    w, e, s, n, bottom, top = scene.box
    places = np.random.default_rng(0).uniform((w, s, bottom), (e, n, top), size=(60, 3))
    listed, near = [], locate.list_near
    monkeypatch.setattr(locate, "list_near", lambda *given: listed.append(given) or near(*given))
    units = scene.sample(places).unit.values.tolist()
    assert len(set(units)) > 3
    assert len(listed) == 1

    # groups of a few places read the same
    monkeypatch.setattr(parts, "AT_ONCE", 7)
    assert scene.sample(places).unit.values.tolist() == units
    assert len(listed) == 1 + -(-60 // 7)


def test_horizons_in_their_store_leave_the_memory_to_themselves():
    """The arrangement that other scenes could take from is stored for grids in memory only."""
    kept = [
        scene._graph.memory.arrangement_of(scene.patches) is not None
        for scene in scenes(1, False)[:2]
    ]
    assert kept == [True, False]
