"""Cells of grids with 2-D coordinates near places: the same as from every cell."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.model.excerpt import Boxes, Line, model_near
from geosurf.model.lattice import Lattice


def curvilinear(seed, n_row, n_col):
    """A rotated and bent grid on a coarse lattice of places, with absent nodes."""
    rng = np.random.default_rng(seed)
    i, j = np.mgrid[:n_row, :n_col]
    x = 3.0 * j - 2.0 * i + rng.integers(-1, 2, i.shape)
    y = 2.0 * j + 3.0 * i + rng.integers(-1, 2, i.shape)
    x[rng.random(i.shape) < 0.1] = np.nan
    return Lattice(x, y, np.zeros(i.shape))


def boxes_of_cells(lattice):
    """Lower and upper corners (n, 2) of all cells, over the nodes that exist."""
    corners = [
        np.stack([lattice.easting[a, b], lattice.northing[a, b]], -1).reshape(-1, 2)
        for a in (slice(-1), slice(1, None))
        for b in (slice(-1), slice(1, None))
    ]
    return np.fmin.reduce(corners), np.fmax.reduce(corners)


@given(st.integers(0, 2**32), st.integers(2, 40), st.integers(2, 40), st.integers(0, 60))
def test_all_cells_near_a_place_are_found_and_no_others(seed, n_row, n_col, at):
    lattice = curvilinear(seed, n_row, n_col)
    low, high = boxes_of_cells(lattice)
    line = Line(np.array([at, 0.0]), np.array([0.0, 31.0]))
    box = Boxes(np.array([[at, 3.0]]), np.array([[at + 2.0, 9.0]]))
    for region in (line, box):
        met = region.meets(low, high)
        assert region.cells(lattice).tolist() == np.flatnonzero(met).tolist()


@pytest.mark.parametrize("shape", [(1, 5), (5, 1), (1, 1)])
def test_grids_without_cells_have_none(shape):
    lattice = curvilinear(1, *shape)
    assert not len(Line(np.zeros(2), np.ones(2)).cells(lattice))


def test_a_section_of_rotated_grids_lists_a_small_part_of_them():
    east, north = np.meshgrid(np.arange(81) * 25.0, np.arange(81) * 25.0)
    grids = {}
    for name, level in (("Top", -1000.0), ("Base", -1100.0)):
        at = {"easting": (("j", "i"), east - north), "northing": (("j", "i"), east + north)}
        z = level + 20.0 * np.sin(east / 300.0)
        about = {"units": "m", "positive": "up"}
        grids[name] = xr.DataArray(z, dims=("j", "i"), coords=at, attrs=about)
    units = gs.Scene(grids).units
    part = model_near(units, Line(np.array([-500.0, 1000.0]), np.array([700.0, 1500.0])))[1]
    n, n_part = (sum(len(unit.triangles) for unit in of.values()) for of in (units, part))
    assert 0 < n_part < 0.1 * n
