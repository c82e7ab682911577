"""Scenes with a tolerance: fewer nodes, within proven bounds of places and volumes."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
import xarray

import geosurf as gs
from geosurf import Scene, synthetic
from geosurf.errors import InputError
from geosurf.model import Lattice
from geosurf.report.tables import accuracy
from geosurf.triangulate.decimate import Frame, kept_nodes, measure_differences
from tests.grids import gridded
from tests.messages import refused
from tests.scene.conftest import FAULT, waves


def test_a_torn_horizon_has_no_tolerance():
    world = synthetic.tilted_planes()
    fault = Scene(world.horizons, world.faults, world.box).surface("F1")
    sheet = gs.throw_horizon(world.horizons["Top"], [fault], {"F1": 20.0}, name="Top")
    horizons = {**world.horizons, "Top": sheet}
    words = r"'Top' is a sheet torn at faults, .* Leave tolerance out"
    refused(InputError, words, Scene, horizons, world.faults, world.box, tolerance=5.0)


# ---- Scenes with a tolerance: models of every k-th node, within proven bounds, in the same or
N = 201  # nodes along a side of 200 m: the smallest grid of which every second node is enough


def grid_of(z):
    return gridded(z, np.linspace(0.0, 200.0, len(z)))


def scene_of(horizons, tolerance, **more):
    return gs.Scene(
        {k: grid_of(z) for k, z in horizons.items()}, {"F1": FAULT}, tolerance=tolerance, **more
    )


# ---- the bound -------------------------------------------------------------------------


def heights(x, y, z, east, north):
    """Elevation of a lattice with rising diagonals at some places: the plane of each triangle."""
    j = np.clip(np.searchsorted(x, east, "right") - 1, 0, len(x) - 2)
    i = np.clip(np.searchsorted(y, north, "right") - 1, 0, len(y) - 2)
    s, t = (east - x[j]) / (x[j + 1] - x[j]), (north - y[i]) / (y[i + 1] - y[i])
    a, b, c, d = z[i, j], z[i, j + 1], z[i + 1, j + 1], z[i + 1, j]
    return np.where(s >= t, a + s * (b - a) + t * (c - b), a + t * (d - a) + s * (c - d))


def places_in(x, y, x0, x1, y0, y1):
    """Nodes, points of a raster, and points along the diagonal, of a coarse cell."""
    e, n = np.meshgrid(x[(x >= x0) & (x <= x1)], y[(y >= y0) & (y <= y1)])
    t = np.linspace(0.0, 1.0, 1201)
    u, v = np.meshgrid((np.arange(60) + 0.5) / 60, (np.arange(60) + 0.5) / 60)
    raster = x0 + u * (x1 - x0), y0 + v * (y1 - y0)
    line = x0 + t * (x1 - x0), y0 + t * (y1 - y0)
    both = zip((e, n), line, raster, strict=True)
    return [np.concatenate([p.ravel() for p in part]) for part in both]


def exact_change(x, y, z, rows, cols):
    """Integral of a lattice with rising diagonals less that of its corners, in exact fractions."""

    def below(rows, cols):
        total = Fraction(0)
        for i, k in pairwise(rows):
            for j, m in pairwise(cols):
                corners = 2 * z[i, j], z[i, m], 2 * z[k, m], z[k, j]
                area = (Fraction(x[m]) - Fraction(x[j])) * (Fraction(y[k]) - Fraction(y[i]))
                total += sum(map(Fraction, corners)) * area / 6
        return total

    all_nodes = (range(int(ends[0]), int(ends[1]) + 1) for ends in (rows, cols))
    return float(below(*map(list, all_nodes)) - below(rows.tolist(), cols.tolist()))


@pytest.mark.parametrize("uneven", [0.0, 0.2])
@pytest.mark.parametrize("seed", range(12))
def test_the_bound_is_that_of_a_search_by_brute_force(seed, uneven):
    rng = np.random.default_rng(seed)
    shape = rng.integers(7, 30, 2)
    x, y = (np.arange(n) * 2.0 + 1e5 + uneven * rng.uniform(-1, 1, n) for n in shape[::-1])
    z = rng.normal(0, 1, shape) if seed % 2 else np.add.outer(np.cos(y / 4), (x - x[0]) ** 2 / 90)
    rows, cols = kept_nodes(shape[0], int(rng.integers(2, 7))), kept_nodes(shape[1], 4)
    whole = Lattice(x, y, z)
    found = measure_differences(whole, Frame.of_nodes(whole, rows, cols), np.inf)
    few = z[np.ix_(rows, cols)]
    for i, j in np.ndindex(found.largest.shape):
        x0, x1, y0, y1 = x[cols[j]], x[cols[j + 1]], y[rows[i]], y[rows[i + 1]]
        e, n = places_in(x, y, x0, x1, y0, y1)
        off = np.abs(heights(x, y, z, e, n) - heights(x[cols], y[rows], few, e, n))
        change = exact_change(x, y, z, rows[i : i + 2], cols[j : j + 2])
        assert abs(found.change[i, j] - change) <= found.doubt[i, j]
        assert found.doubt[i, j] <= (found.volume[i, j] if uneven else 1e-7)
        volume = off[-3600:].mean() * (x1 - x0) * (y1 - y0)
        assert off.max() <= found.largest[i, j] + 1e-12
        assert volume <= found.volume[i, j] * 1.02 + 1e-12
        if not uneven:  # no larger than it has to be
            assert found.largest[i, j] <= 1.02 * off.max() + 1e-9
            assert found.volume[i, j] <= 8 * volume + 1e-6


@pytest.mark.parametrize("stride", [2, 3, 4, 5])
def test_the_volume_is_exact_where_one_surface_is_above_the_other(stride):
    x = np.arange(stride * 4 + 1.0)
    z = np.add.outer(x**2, 0.5 * x**2) - 0.1 * np.multiply.outer(x, x)
    kept = kept_nodes(len(x), stride)
    found = measure_differences(Lattice(x, x, z), Frame.of(Lattice(x, x, z), stride), np.inf)
    e, n = np.meshgrid(x, x)
    d = heights(x[kept], x[kept], z[np.ix_(kept, kept)], e, n) - z
    assert d.min() >= -1e-9
    a, b, c, corner = d[:-1, :-1], d[:-1, 1:], d[1:, 1:], d[1:, :-1]
    volume = ((a + b + c) + (a + c + corner)) / 6  # of both triangles of each fine cell
    parts = volume.reshape(4, stride, 4, stride).sum(axis=(1, 3))
    np.testing.assert_allclose(found.volume, parts, rtol=1e-9)


# ---- models ----------------------------------------------------------------------------


def test_a_model_of_fewer_nodes_is_within_its_bound_and_certified():
    horizons = {"Top": waves(-300.0), "Base": waves(-400.0, phase=1.0)}
    exact, quick = scene_of(horizons, None), scene_of(horizons, 0.5)
    assert quick.box == exact.box
    assert quick.surface("Top").n_vertex == 101**2
    assert quick.whole_surface("Top").n_vertex == N**2
    off = float(abs(quick.volumes - exact.volumes).max())
    assert 0.0 < off <= quick.volume_error_bound < 2 * 0.5 * 200.0**2
    assert quick.check().ok
    assert "decimate" in quick.explain()
    assert (exact.volume_error_bound, accuracy(exact)) == (0.0, [])

    # the same nodes as those of horizons that were made with this tolerance
    few = {
        name: gs.triangulate_horizon(grid_of(z), name=name, tolerance=0.5)
        for name, z in horizons.items()
    }
    other = exact.replace(horizons=few)
    assert other.surface("Top").vertices.tobytes() == quick.surface("Top").vertices.tobytes()
    assert other.volume_error_bound == pytest.approx(quick.volume_error_bound, rel=1e-9)
    (line,) = accuracy(other)
    assert line.startswith("Horizons have fewer nodes than their grids, and are at most ")

    # curves are those of the model
    alone = gs.intersect_surfaces([quick.surface("Top"), quick.surface("F1")])
    both = quick.curves_between("Top", "F1")
    assert both.points.shape == alone.points.shape
    np.testing.assert_allclose(both.points, alone.points, atol=1e-9)
    (first,) = accuracy(quick)
    error = max(quick.surface(name).vertex_data["vertical_error"].max() for name in horizons)
    assert f"at most {error:.2g} m off" in first


# ---- The bound of volumes of models with fewer nodes: no sum of units differs by more.


def horizon(rng, level, uneven=0.0, shift=0.0):
    """A horizon of a few waves; `uneven` moves nodes along both axes."""
    east, north = (np.linspace(shift, 200.0 - shift, N) for _ in range(2))
    for axis in (east, north):
        axis[1:-1] += uneven * rng.uniform(-0.4, 0.4, N - 2) * (axis[1] - axis[0])
    z = np.full((N, N), level)
    for _ in range(3):
        size, *k = rng.uniform(1, 6), *rng.uniform(-1, 1, 2) / 15
        z += size * np.sin(k[0] * east + k[1] * north[:, None] + rng.uniform(0, 6))
    return gridded(z, east, north)


def fault(rng, name, lattice=False):
    """A fault across the map, as two triangles or as a grid."""
    a, b, dip = *rng.uniform(40, 160, 2), rng.uniform(-60, 60)
    if not lattice:
        corners = [(a, -50, -900), (b, 250, -900), (b + dip, 250, 100), (a + dip, -50, 100)]
        return gs.TriSurface(name, "fault", corners, [(0, 1, 2), (0, 2, 3)])
    s, t = np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, 1, 33))
    east = a + s * (b - a) + dip * t + 4 * np.sin(6 * s)
    dims = ("down_dip", "along_strike")
    parts = {"easting": east, "northing": -50 + 300 * s, "elevation": -900 + 1000 * t}
    return xarray.Dataset(
        {key: (dims, value, {"units": "m", "positive": "up"}) for key, value in parts.items()}
    )


def worst_sum(quick, exact):
    """The largest difference of any sum of units, and of one unit [m3]."""
    units = {*quick.units, *exact.units}
    volumes = [[of.units[one].volume if one in of.units else 0.0 for one in sorted(units)]
               for of in (quick, exact)]  # fmt: skip
    off = np.subtract(*volumes)
    return max(off[off > 0].sum(), -off[off < 0].sum()), np.abs(off).max()


@pytest.mark.parametrize("seed", range(10))
def test_no_sum_of_units_differs_by_more_than_the_bound(seed):
    rng = np.random.default_rng(seed)
    uneven = [0.0, 0.0, 0.2][seed % 3]
    frame = np.random.default_rng(100 + seed)  # the same axes for two horizons
    top, base = (horizon(frame, level, uneven) for level in (-300.0, -310.0 - 20 * (seed % 2)))
    if uneven:
        base = gridded(base.values, top.easting.values, top.northing.values)
    horizons = {"Top": top, "Base": base}
    if seed % 4 == 1:  # a frame of its own
        horizons["Deep"] = horizon(rng, -360.0, shift=-3.0)
    faults = {"F1": fault(rng, "F1", lattice=seed % 2 == 1)}
    more = {"contacts": {"OWC": -305.0}} if seed % 3 == 0 else {}
    box = (2.0, 197.0, 1.5, 198.5, -420.0, -200.0)
    exact = gs.Scene(horizons, faults, box, column={"Base": "erosional"}, **more)
    quick = exact.replace(tolerance=3.0)
    assert quick.surface("Top").n_vertex < N**2
    together, alone = worst_sum(quick, exact)
    assert 0.0 < alone <= together <= quick.volume_error_bound + 1e-9 * exact.units.box_volume
    everything = sum(quick.surface(k).vertex_data["volume_error"].sum() for k in horizons)
    assert quick.volume_error_bound <= everything * (1 + 1e-12)
