"""What the model leaves out: most of a rotated field, faults beside it, bodies that are none."""

from __future__ import annotations

import re

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeosurfWarning, SurfaceError
from geosurf.triangulate.stored import check_horizon_mesh

BOX = (0.0, 5000.0, 0.0, 4000.0, -2600.0, -1800.0)


def turned(degrees, n=(31, 61), cell=50.0, hole=None):
    """A grid turned by an angle, with a hole."""
    i, j = np.meshgrid(np.arange(n[0]) * cell, np.arange(n[1]) * cell)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    coords = {
        "easting": (("row", "column"), i * c - j * s),
        "northing": (("row", "column"), i * s + j * c),
    }
    heights = -1700 + 0.02 * i
    if hole is not None:
        heights[hole] = np.nan
    attrs = {"units": "m", "positive": "up"}
    return xr.DataArray(heights, coords, ("row", "column"), attrs=attrs)


@pytest.mark.parametrize("degrees", [3, 20, 45, 77, 140, 250])
def test_the_default_area_of_a_turned_grid_is_all_of_it(degrees):
    scene = gs.Scene({"T": turned(degrees)})
    assert len(scene.units) == 2
    assert scene.check().ok
    assert scene.warnings == ()
    assert len(scene.aoi) == 4
    assert 0.9995 < scene.units.footprint / (1500.0 * 3000.0) < 1.0
    height = scene.box[5] - scene.box[4]
    assert float(scene.volumes.sum()) == pytest.approx(scene.units.footprint * height)


def test_an_upright_grid_that_loses_much_is_named_with_the_share():
    world = gs.synthetic.tilted_planes(n=5)
    base = world.horizons["Base"].isel(easting=slice(1, None))
    scene = gs.Scene({**world.horizons, "Base": base})
    with pytest.warns(GeosurfWarning, match=r"covers 75 % of horizon 'Top' \(9 km² of 12 km²\)"):
        assert len(scene.units) == 3
    assert [warning.subject for warning in scene.warnings] == ["Top"]
    assert gs.Scene({**world.horizons, "Base": base}, box=scene.box).warnings == ()


# ---- faults beside the model -----------------------------------------------------------------


def wall(name, x, low=-3000.0, high=-1000.0):
    corners = [(x, -500, low), (x, 4500, low), (x, 4500, high), (x, -500, high)]
    return gs.TriSurface(name, "fault", np.array(corners, dtype=float), [[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize(
    ("fault", "where"),
    [
        (wall("Out", 5500), r"500 m east of the model box"),
        (wall("Out", -20), r"20 m west of"),
        (wall("Out", 2500, -1500, -1000), r"300 m above the model box"),
        (wall("Out", 2500, -4000, -2700), r"100 m below the model box"),
    ],
)
def test_a_fault_beside_the_box_is_named(fault, where):
    top = gs.synthetic.graben(n=21).horizons["Top"]
    scene = gs.Scene({"Top": top}, {"In": wall("In", 2500), "Out": fault}, BOX)
    with pytest.warns(GeosurfWarning, match=rf"Fault 'Out' lies {where}") as issued:
        (found,) = scene.warnings
    assert len(issued) == 1
    assert (found.kind, found.subject) == ("outside", "Out")
    assert len(scene.units) == 4
    assert scene.warnings == (found,)
    late = gs.Scene({"Top": top}, {"In": wall("In", 2500), "Out": fault}, BOX)
    with pytest.warns(GeosurfWarning):
        assert len(late.units) == 4
    assert late.warnings == (found,)
    box = eval(re.search(r"box=(\([^)]*\))", found.remedy)[1])
    wide = gs.Scene({}, {"Out": fault}, box)
    assert wide.warnings == ()


# ---- bodies and folds ---------------------------------------------------------------------------


def ball(n=8, radius=100.0, centre=(0.0, 0.0, -500.0)):
    """A closed body, wound outward."""
    polar, turn = np.linspace(0, np.pi, n)[1:-1], np.linspace(0, 2 * np.pi, 2 * n, endpoint=False)
    ring = [[np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)] for t in polar for p in turn]
    m, last, faces = 2 * n, 1 + len(ring), []
    pairs = [(j, (j + 1) % m) for j in range(m)]
    faces += [[0, 1 + j, 1 + k] for j, k in pairs]
    for i in range(n - 3):
        for a, b in ((1 + i * m + j, 1 + i * m + k) for j, k in pairs):
            faces += [[a, a + m, b], [b, a + m, b + m]]
    faces += [[last, last - m + k, last - m + j] for j, k in pairs]
    return radius * np.array([[0, 0, 1], *ring, [0, 0, -1]]) + centre, np.array(faces)


def variants():
    """A ball as programs hand it out."""
    vertices, faces = ball()
    rng = np.random.default_rng(0)
    yield "as it is", vertices, faces
    yield "shuffled", vertices, faces[rng.permutation(len(faces))]
    wound = rng.random(len(faces)) < 0.5
    yield "wound at random", vertices, np.where(wound[:, None], faces[:, ::-1], faces)
    yield "not welded", vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)
    sheet = np.array([(-400.0, -400, -100), (400, -400, -100), (400, 400, -100)])
    n = len(vertices)
    yield "beside a sheet", np.vstack([vertices, sheet]), np.vstack([faces, [n, n + 1, n + 2]])


@pytest.mark.parametrize("variant", list(variants()), ids=lambda variant: variant[0])
def test_a_closed_body_is_refused_as_a_horizon(variant):
    _, vertices, faces = variant
    salt = gs.TriSurface("Salt", "horizon", vertices, faces)
    box = (-400, 400, -400, 400, -1000, 0)
    with pytest.raises(SurfaceError, match=r"'Salt' \w+ a closed body of 3\.\d+ million m³ around"):
        _ = gs.Scene({"Salt": salt}, {}, box).units
    if variant[0] == "as it is":  # what the message proposes
        made = gs.Scene({}, {"Salt": salt}, box)
        assert made.check().ok
        assert sorted(made.units) == ["Salt+", "Salt-"] or len(made.units) == 2


@pytest.mark.parametrize("flip", [False, True])
def test_a_sheet_that_does_not_fold_is_silent_however_it_is_wound(flip):
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(5.0), np.arange(5.0)))
    cells = np.array([[k, k + 1, k + 6, k + 5] for k in range(19) if k % 5 < 4])
    faces = np.vstack([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    if flip:
        faces[::3] = faces[::3, ::-1]
    check_horizon_mesh(gs.TriSurface("T", "horizon", np.column_stack([x, y, x * y]), faces))


def test_the_share_of_a_fault_inside_counts_heights(scene):
    _, _, south, north, bottom, top = scene.box
    _, _, y_low, y_high, z_low, z_high = scene.surface("F1").bounds
    share = (north - south) * (top - bottom) / ((y_high - y_low) * (z_high - z_low))
    assert share < (north - south) / (y_high - y_low)
    assert scene.coverage["F1"] == pytest.approx(share, abs=0.02)
