"""Rotated grids that stay in their store: the bytes of grids in memory."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.model.chunked_map import ChunkedMap
from geosurf.model.regions import Boxes, Line
from geosurf.triangulate import chunked

SHAPE = (23, 31)


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(chunked, "LEAST", 1)


def grids(
    seed: int, angle: float, step: tuple[float, float], *, holes: bool = False
) -> dict[str, xr.DataArray]:
    """Two rough horizons over a rotated grid, with noise on its nodes in the last digits."""
    rng = np.random.default_rng(seed)
    i, j = np.indices(SHAPE)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    x = 460000 + j * step[0] * c - i * step[1] * s
    y = 5930000 + j * step[0] * s + i * step[1] * c
    places = {"easting": (("row", "column"), x), "northing": (("row", "column"), y)}
    absent = (i + j < 6) | ((i == 3) & (j > 20)) if holes else np.zeros(SHAPE, dtype=bool)
    found = {}
    for name, shift in (("Top", 0.0), ("Base", 40.0)):
        z = np.where(absent, np.nan, np.round(rng.normal(size=SHAPE) * 6) - 1000 - shift)
        attrs = {"units": "m", "positive": "up"}
        found[name] = xr.DataArray(z, places, ("row", "column"), name, attrs)
    return found


def stored(grid: xr.DataArray, chunks: tuple[int, int], name: str) -> gs.TriSurface:
    parts = dict(zip(grid.dims, chunks, strict=True))
    return gs.triangulate_horizon(grid.chunk(parts), name=name, lazy=True)


def fault_in(grid: xr.DataArray) -> dict[str, gs.TriSurface]:
    x, y = float(grid.easting.mean()), float(grid.northing.mean())
    low = [[x - 60, y - 2000, -2000], [x - 20, y + 2000, -2000]]
    plane = [*low, [x + 60, y + 2000, 0], [x + 20, y - 2000, 0]]
    return {"F": gs.TriSurface("F", "fault", plane, [[0, 1, 2], [0, 2, 3]])}


def results(
    scene: gs.Scene, points: np.ndarray, line: list[tuple[float, float]], grid: xr.DataArray
) -> list[object]:
    """What has to be the same, as values that can be compared."""
    samples = scene.sample(points), scene.sample(points, distance=True)
    tables = scene.units.table, scene.volumes, *samples, scene.cutoffs("Top", "F")
    return [
        scene.box, *(repr(one) for one in tables), scene.curves.local.tobytes(),
        scene.volumes.to_dict(), scene.check().checks, scene.coverage,
        [(name, u.volume, u.area, u.map_area) for name, u in scene.units.items()],
        repr(scene.section(line)), scene.thickness("Top/Base", 9.0).to_dict(),
        scene.thickness("Top/Base", grid, kind="isopach").to_dict(),  # in nodes
        scene.throw("Top", "F").to_dict(), scene.well_intervals(points[:6]).to_dict(),
    ]  # fmt: skip


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
@pytest.mark.parametrize(
    ("angle", "step", "chunks", "holes", "option"),
    [
        (30.0, (25.0, 20.0), (7, 11), False, "area"),
        (45.0, (25.0, 25.0), (23, 5), False, "box"),  # both diagonals run as far to the north-east
        (-77.0, (20.0, 25.0), (5, 4), False, "box"),
        (130.0, (25.0, -20.0), (9, 31), True, "rectangle"),  # left-handed
    ],
)
def test_law_rotated_grids_give_the_bytes_of_grids_in_memory(angle, step, chunks, holes, option):
    made = grids(int(abs(angle)), angle, step, holes=holes)
    lazy = {name: stored(grid, chunks, name) for name, grid in made.items()}
    assert all(isinstance(one.lattice, ChunkedMap) for one in lazy.values())
    x, y = float(made["Top"].easting.mean()), float(made["Top"].northing.mean())
    how = {
        "area": {}, "rectangle": {"aoi": "rectangle"},
        "box": {"box": (x - 110, x + 120, y - 90, y + 100, -1300, -800)},
    }[option]  # fmt: skip
    one, two = (gs.Scene(of, fault_in(made["Top"]), **how) for of in (made, lazy))
    west, east, south, north, bottom, top = one.box
    low, high = (west, south, bottom), (east, north, top)
    points = np.random.default_rng(0).uniform(low, high, size=(60, 3))
    line = [(west, south), (east, north)]
    found = [results(of, points, line, made["Top"]) for of in (one, two)]
    assert repr(found[0]) == repr(found[1])


def test_law_equal_coordinates_of_other_arrays_are_one_map():
    made = grids(3, 30.0, (25.0, 20.0))
    top = stored(made["Top"], (7, 11), "Top")
    base = made["Base"].copy(deep=True)
    others = [stored(base, (5, 9), "Base"), gs.triangulate_horizon(base, name="Base")]
    area = gs.Scene({"Top": top}, {}).aoi
    expected = gs.Scene(made, fault_in(made["Top"]), aoi=area).units.table
    for other in others:
        assert top.lattice.shares_map(other.lattice)
        assert other.lattice.shares_map(top.lattice)
        scene = gs.Scene({"Top": top, "Base": other}, fault_in(made["Top"]), aoi=area)
        assert scene.units.table.identical(expected)
    moved = base.assign_coords(easting=base.easting + 1e-9 * (base.northing > 5930500))
    assert not top.lattice.shares_map(stored(moved, (5, 9), "Base").lattice)
    assert not top.lattice.shares_map(gs.triangulate_horizon(moved, name="Base").lattice)


@pytest.mark.parametrize("value", [40.0, np.nan])
def test_grids_without_even_steps_are_refused_with_the_place_and_the_remedy(value):
    grid = grids(0, 30.0, (25.0, 20.0))["Top"]
    x = grid.easting.values.copy()
    x[15, 20] += value
    uneven = grid.assign_coords(easting=(grid.dims, x))
    with pytest.raises(gs.errors.HorizonError, match=r"node \(1[45], (19|20)\).*da\.load\(\)"):
        stored(uneven, (7, 11), "Top")


def test_what_needs_all_nodes_says_so():
    made = grids(0, 30.0, (25.0, 20.0))
    lazy = {name: stored(grid, (7, 11), name) for name, grid in made.items()}
    scene = gs.Scene(lazy, fault_in(made["Top"]))
    with pytest.raises(gs.errors.HorizonError, match=r"'Top' stays in its store.*da\.load"):
        _ = scene.surface("Top").vertices


def test_the_default_area_of_square_cells_needs_no_node_to_move():
    """Its corners would lie beside diagonals, off by rounding alone."""
    made = grids(5, 30.0, (12.5, 12.5))
    lazy = {name: stored(grid, (7, 11), name) for name, grid in made.items()}
    one, two = (gs.Scene(of, fault_in(made["Top"])) for of in (made, lazy))
    assert one.aoi.tobytes() == two.aoi.tobytes()
    assert one.units.table.identical(two.units.table)
    assert one.patches.report["moved_vertices"] == two.patches.report["moved_vertices"] == 0
    assert two.check().ok


@pytest.mark.parametrize("seed", range(6))
def test_law_regions_name_all_cells_that_they_meet_and_few_others(seed):
    rng = np.random.default_rng(seed)
    grid = grids(seed, rng.uniform(-180, 180), (25.0, 40.0))["Top"]
    lattices = [gs.triangulate_horizon(grid).lattice, stored(grid, (7, 9), "Top").lattice]
    x, y = grid.easting.values, grid.northing.values
    a, b = np.stack([rng.choice(x.ravel(), 2), rng.choice(y.ravel(), 2)], axis=1)
    line, (low, high) = Line(a, b), np.sort([a, b], axis=0)

    # cells whose corners are on both sides of the line; cells with a node in the box
    side = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
    corners = [np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1], np.s_[1:, 1:]]
    signs = np.sign([side[c] for c in corners])
    inside = (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1])
    asked = [(line, signs.min(axis=0) < signs.max(axis=0)), (Boxes(low[None], high[None]),
             np.any([inside[c] for c in corners], axis=0))]  # fmt: skip
    for region, met in asked:
        for lattice in lattices:
            found = region.cells(lattice)
            assert set(np.flatnonzero(met)) <= set(found.tolist())
        assert len(found) <= 4 * met.sum() + 40  # of 660, in the store
