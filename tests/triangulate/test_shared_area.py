"""The default area: inside all horizons, and nearly all of what they share."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import xarray as xr
from scipy.ndimage import label

import geosurf as gs
from geosurf.errors import GeosurfWarning, InputError
from geosurf.triangulate.footprint import footprint_of
from geosurf.triangulate.outline import signed_area, with_fewer_corners
from geosurf.triangulate.shared_area import shared_area


def grid(degrees, there, cell=50.0, corner=(460000.0, 5930000.0), flip=False):
    """A grid turned about its corner, with nodes where `there` is set."""
    i, j = np.meshgrid(np.arange(there.shape[1]) * cell, np.arange(there.shape[0]) * cell)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    east, north = corner[0] + i * c - j * s, corner[1] + i * s + j * c
    values = np.where(there, -1700 + 0.02 * i + 0.01 * j, np.nan)
    if flip:
        east, north, values = east[::-1], north[::-1], values[::-1]
    coords = {"easting": (("row", "column"), east), "northing": (("row", "column"), north)}
    return xr.DataArray(values, coords, ("row", "column"), attrs={"units": "m", "positive": "up"})


def blob(seed, n=14):
    """A random region of nodes without holes: some disks, and what they surround."""
    from scipy.ndimage import binary_fill_holes, binary_opening

    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:n, :n]
    there = np.zeros((n, n), dtype=bool)
    for _ in range(4):
        cx, cy, r = rng.uniform(3, n - 4), rng.uniform(3, n - 4), rng.uniform(2, 5)
        there |= (x - cx) ** 2 + (y - cy) ** 2 <= r * r
    there = binary_opening(there, np.ones((2, 2)))
    number, _ = label(there)
    return binary_fill_holes(number == np.bincount(number.ravel())[1:].argmax() + 1)


def turn(p, q, r):
    """Exact side of r beside the line from p to q."""
    (px, py), (qx, qy), (rx, ry) = ([Fraction(float(v)) for v in one] for one in (p, q, r))
    value = (qx - px) * (ry - py) - (qy - py) * (rx - px)
    return (value > 0) - (value < 0)


def slow_is_inside(outline, horizon):
    """Whether all corners are in triangles, and no side crosses a rim; in fractions."""
    corners = horizon.vertices[horizon.triangles][:, :, :2]
    for p in outline:
        near = (corners.min(axis=1) <= p).all(axis=1) & (corners.max(axis=1) >= p).all(axis=1)
        turns = [[turn(t[k], t[(k + 1) % 3], p) for k in range(3)] for t in corners[near]]
        if not any(min(of) >= 0 or max(of) <= 0 for of in turns):
            return False
    edges = np.sort(horizon.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    pairs, count = np.unique(edges, axis=0, return_counts=True)
    for a, b in horizon.vertices[pairs[count == 1]][:, :, :2]:
        for p, q in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            if turn(a, b, p) * turn(a, b, q) < 0 and turn(p, q, a) * turn(p, q, b) < 0:
                return False
    return True


@pytest.mark.parametrize("seed", range(6))
def test_the_area_is_inside_and_nearly_all_that_horizons_cover(seed):
    rng = np.random.default_rng(seed)
    degrees, there = rng.uniform(0, 360), blob(seed)
    arrays = [grid(degrees, there), grid(degrees, there, flip=True)]
    horizons = [gs.triangulate_horizon(array, name=f"H{k}") for k, array in enumerate(arrays)]
    found = shared_area([footprint_of(horizon) for horizon in horizons])
    assert all(slow_is_inside(found.outline, horizon) for horizon in horizons)
    covered = footprint_of(horizons[0]).area
    a, b, c = np.moveaxis(horizons[0].vertices[horizons[0].triangles][:, :, :2], 1, 0)
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert covered == pytest.approx(0.5 * twice.sum())
    assert 0.985 < signed_area(found.outline) / covered < 1.0
    assert found.share == pytest.approx(found.area / covered, abs=0.005)


@pytest.mark.parametrize("seed", [0, 3])
def test_a_scene_takes_it_and_is_closed(seed):
    scene = gs.Scene({"T": grid(29.0 * seed + 7, blob(seed))})
    assert scene.check().ok
    assert scene.warnings == ()
    assert scene.units.footprint == pytest.approx(signed_area(scene.aoi), rel=1e-9)
    again = gs.Scene({"T": grid(29.0 * seed + 7, blob(seed))})
    assert scene.aoi.tobytes() == again.aoi.tobytes()
    assert "of what all horizons cover" in scene.explain()
    assert scene.coverage["T"] == pytest.approx(1.0, abs=0.02)


def clipped(ring, by):
    """A convex ring clipped by another one (Sutherland & Hodgman)."""
    for p, q in zip(by, np.roll(by, -1, axis=0), strict=True):
        side = [(q - p)[0] * (r - p)[1] - (q - p)[1] * (r - p)[0] for r in ring]
        out = []
        for k, (a, s) in enumerate(zip(ring, side, strict=True)):
            b, t = ring[k - 1], side[k - 1]
            if (s > 0) != (t > 0):
                out.append(b + (a - b) * t / (t - s))
            if s > 0:
                out.append(a)
        ring = out
    return np.array(ring)


def lower(array, by):
    """A grid some metres lower; xarray of 2024 drops attributes in sums."""
    return (array - by).assign_attrs(array.attrs)


@pytest.mark.parametrize(("degrees", "cell"), [((20, 47), (50, 50)), ((0, 65), (50, 80))])
def test_grids_in_different_frames_share_what_two_rectangles_share(degrees, cell):
    full = np.ones((41, 31), dtype=bool)
    corners = ((460000.0, 5930000.0), (460400.0, 5929700.0))
    made = [grid(d, full, c, at) for d, c, at in zip(degrees, cell, corners, strict=True)]
    rings = []
    for array in made:
        e, n = array.easting.values, array.northing.values
        rings.append(np.array([[e[k], n[k]] for k in ((0, 0), (0, -1), (-1, -1), (-1, 0))]))
    exact = signed_area(clipped(list(rings[0]), rings[1]))
    scene = gs.Scene({"H0": made[0], "H1": lower(made[1], 50.0)})
    with pytest.warns(GeosurfWarning, match="% of horizon 'H"):
        _ = scene.units
    assert 0.99 < scene.units.footprint / exact < 1.0
    assert scene.check().ok
    assert len(scene.aoi) < 20


def test_an_upright_grid_with_an_empty_rim_keeps_all_its_cells():
    there = np.zeros((13, 17), dtype=bool)
    there[2:11, 3:15] = True
    x, y = 460000.1 + np.arange(17) * 50.0, 5930000.3 + np.arange(13) * 50.0
    values = np.where(there, -1700.0, np.nan)
    array = xr.DataArray(values, {"northing": y, "easting": x}, ("northing", "easting"))
    scene = gs.Scene({"T": array}, positive="up", length_unit="m")
    assert scene.aoi is None
    assert scene.box[:4] == (x[3], x[14], y[2], y[10])
    assert scene.check().ok
    assert scene.warnings == ()


def test_the_largest_piece_is_taken_and_the_others_are_listed():
    there = np.ones((21, 31), dtype=bool)
    there[:, 18:20] = False
    there[9:11, 18:] = False
    scene = gs.Scene({"T": grid(30, there)})
    with pytest.warns(GeosurfWarning, match="cover 3 separate pieces") as issued:
        assert len(scene.units) == 2
    (warning,) = {w.message for w in issued}
    assert "is the largest (0.85 km²)" in str(warning)
    assert "leaves out 0.225 km² around (E 4" in str(warning)
    assert "and a smaller one of 0.2 km²" in str(warning)
    assert scene.units.footprint == pytest.approx(17 * 20 * 2500.0, rel=1e-3)


def test_holes_are_listed_largest_first_with_the_horizon():
    whole, holed = np.ones((31, 31), dtype=bool), np.ones((31, 31), dtype=bool)
    holed[5, 5] = holed[10:14, 10:14] = False
    scene = gs.Scene({"T": grid(30, whole), "B": lower(grid(30, holed), 90.0)})
    with pytest.raises(
        InputError, match=r"2 holes: in 'B' at \(E 460 2.*\(60 0\d\d m²\), 'B' at \(E 460 0"
    ):
        _ = scene.units


def test_horizons_apart_have_no_area():
    full = np.ones((5, 5), dtype=bool)
    for corner in ((460000.0, 5990000.0), (460210.0, 5930000.0)):
        with pytest.raises(InputError, match="no area in common"):
            _ = gs.Scene({"T": grid(3, full), "B": grid(3, full, corner=corner)}).box


@pytest.mark.parametrize("seed", range(4))
def test_a_polygon_only_shrinks_and_stays_simple(seed):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 60))
    radius = rng.integers(300, 1000, 60)
    ring = np.rint(np.c_[radius * np.cos(angle), radius * np.sin(angle)]).astype(np.int64)
    ring = ring[(ring != np.roll(ring, 1, axis=0)).any(axis=1)]
    area = signed_area(ring.astype(float))
    found = with_fewer_corners(ring, each=0.01 * area, total=0.05 * area)
    assert 0.95 * area <= signed_area(found.astype(float)) <= area
    assert len(found) < len(ring)
    gs.build_walls((-2000, 2000, -2000, 2000, -1, 1), found)  # raises if it meets itself
