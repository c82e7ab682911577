"""The bound of volumes of models with fewer nodes: no sum of units differs by more."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import xarray

import geosurf as gs
from geosurf.triangulate.decimate import bound_of_change

N = 201  # the smallest grid of which every second node is enough


def grid_of(z, east, north):
    axes = {"northing": north, "easting": east}
    attrs = {"units": "m", "positive": "up"}
    return xarray.DataArray(z, axes, ("northing", "easting"), attrs=attrs)


def horizon(rng, level, uneven=0.0, shift=0.0):
    """A horizon of a few waves; `uneven` moves nodes along both axes."""
    east, north = (np.linspace(shift, 200.0 - shift, N) for _ in range(2))
    for axis in (east, north):
        axis[1:-1] += uneven * rng.uniform(-0.4, 0.4, N - 2) * (axis[1] - axis[0])
    z = np.full((N, N), level)
    for _ in range(3):
        size, *k = rng.uniform(1, 6), *rng.uniform(-1, 1, 2) / 15
        z += size * np.sin(k[0] * east + k[1] * north[:, None] + rng.uniform(0, 6))
    return grid_of(z, east, north)


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
        base = grid_of(base.values, top.easting.values, top.northing.values)
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


@pytest.mark.parametrize("seed", range(6))
def test_the_bound_of_one_horizon_holds_for_any_part_of_the_map(seed):
    """Walls part the map: what is below all nodes, less what is below some, in each part."""
    rng = np.random.default_rng(seed)
    top = gs.triangulate_horizon(horizon(rng, -300.0), name="Top")
    quick = gs.Scene({"Top": top}, tolerance=3.0).surface("Top")
    walls, gains = [], []
    edges = [0.0, *np.sort(rng.uniform(20, 180, 2)), 200.0]
    for k, east in enumerate(edges[1:-1]):
        corners = [(east, -9, -900), (east, 209, -900), (east, 209, 0), (east, -9, 0)]
        walls.append(gs.TriSurface(f"wall {k}", "fault", corners, [(0, 1, 2), (0, 2, 3)]))
    for west, east in pairwise(edges):
        box = (west, east, 0.0, 200.0, -500.0, 0.0)
        below = [gs.Scene({"Top": one}, box=box).units["below Top"].volume for one in (quick, top)]
        gains.append(below[1] - below[0])
    gains = np.array(gains)
    truth = max(gains[gains > 0].sum(), -gains[gains < 0].sum())
    assert truth <= bound_of_change(quick, walls, (0.0, 200.0, 0.0, 200.0)) + 1e-3
