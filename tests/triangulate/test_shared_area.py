"""The default area: inside all horizons, and nearly all of what they share."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from scipy.ndimage import label

import geosurf as gs
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model import Lattice
from geosurf.rebuild import repair
from geosurf.triangulate import outline
from geosurf.triangulate.footprint import footprint_of
from geosurf.triangulate.outline import moved_inward, off_the_rims, signed_area
from geosurf.triangulate.shared_area import shared_area
from tests.grids import gridded, ring_area
from tests.grids import turned as places_of
from tests.messages import refused


def grid(degrees, there, cell=50.0, corner=(460000.0, 5930000.0), flip=False):
    """A grid turned about its corner, with nodes where `there` is set."""
    east, north, i, j = places_of(degrees, there.shape, cell, corner)
    values = np.where(there, -1700 + 0.02 * i + 0.01 * j, np.nan)
    if flip:
        east, north, values = east[::-1], north[::-1], values[::-1]
    return gridded(values, east, north)


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


@pytest.mark.parametrize("seed", [0, 3, 5])
def test_the_area_is_inside_and_nearly_all_that_horizons_cover(seed):
    degrees, there = np.random.default_rng(seed).uniform(0, 360), blob(seed)
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
    array = gridded(np.where(there, -1700.0, np.nan), x, y).drop_attrs()
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


def test_what_other_horizons_cut_off_is_listed_beside_separate_pieces():
    whole, short = np.ones((21, 31), dtype=bool), np.ones((21, 31), dtype=bool)
    short[:, 15:] = False
    short[:3, 28:] = True  # a second piece
    scene = gs.Scene({"T": grid(30, whole), "B": lower(grid(30, short), 90.0)})
    with pytest.warns(GeosurfWarning) as issued:
        assert len(scene.units) == 3
    told = sorted({str(w.message) for w in issued})
    assert "All horizons cover 2 separate pieces" in told[0]
    assert "covers 47 % of horizon 'T'" in told[1]
    assert len(told) == 2


def test_holes_are_listed_largest_first_with_the_horizon():
    whole, holed = np.ones((31, 31), dtype=bool), np.ones((31, 31), dtype=bool)
    holed[5, 5] = holed[10:14, 10:14] = False
    scene = gs.Scene({"T": grid(30, whole), "B": lower(grid(30, holed), 90.0)})
    words = r"2 holes: in 'B' at \(E 460 2.*\(60 0\d\d m²\), 'B' at \(E 460 0"
    refused(InputError, words, lambda: scene.units)


def test_horizons_apart_have_no_area():
    full = np.ones((5, 5), dtype=bool)
    for corner in ((460000.0, 5990000.0), (460210.0, 5930000.0)):
        with pytest.raises(InputError, match="no area in common"):
            _ = gs.Scene({"T": grid(3, full), "B": grid(3, full, corner=corner)}).box


# ---- Areas whose sides run along the rim of a horizon: closed, and what that leaves out is st
def turned(degrees, shape=(9, 7), step=50.0, origin=(460000.0, 5930000.0)):
    """A grid turned about its corner, and its four corner nodes."""
    east, north, i, j = places_of(degrees, shape, step, origin)
    grid = gridded(-1700 + 0.02 * i + 0.01 * j, east, north)
    corners = np.array([[east[a], north[a]] for a in ((0, 0), (0, -1), (-1, -1), (-1, 0))])
    return grid, corners


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
@pytest.mark.parametrize(
    ("degrees", "decimals"),
    [(1e-3, None), (7.0, 3), (30.0, None), (45.0, 2), (89.9, 3), (133.0, None), (271.0, 2)],
)
def test_the_corners_of_a_grid_are_an_area_that_is_closed(degrees, decimals):
    grid, corners = turned(degrees, (40, 30))
    given = corners if decimals is None else corners.round(decimals)
    scene = gs.Scene({"T": grid}, {}, aoi=given)
    assert len(scene.units) == 2
    assert scene.check().ok


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
@pytest.mark.parametrize("off", [0.0, 1e-10])  # m, inside its corners
def test_rims_that_a_repair_may_move_are_closed(off):
    grid, corners = turned(30.0, (9, 9), 1.0, (0.0, 0.0))
    base, aoi = grid.copy(data=grid - 4.0), moved_inward(corners, np.full(4, off))
    scene = gs.Scene({"T": grid, "B": base}, aoi=aoi)
    assert scene.check().ok


def test_the_warning_states_what_is_left_out():
    grid, corners = turned(30.0)
    given = corners.round(3)
    scene = gs.Scene({"T": grid}, {}, aoi=given)
    with pytest.warns(GeosurfWarning, match="runs along the rim of horizon 'T'"):
        area = scene.aoi
    (note,) = scene.warnings
    assert (note.kind, note.subject) == ("rim", "T")
    assert 0 < 300.0 * 400.0 - ring_area(area) < 30.0
    assert note.effect.endswith(f"which leaves out {ring_area(given) - ring_area(area):.3g} m².")


def test_an_area_exactly_on_the_rim_stays_as_it_is():
    x, y = np.arange(0, 301, 50.0) + 460000.1, np.arange(0, 201, 50.0) + 5930000.3
    grid = gridded(np.full((5, 7), -1700.0), x, y)
    box = (x[0], x[-1], y[0], y[-1], -1800.0, -1600.0)
    scene = gs.Scene({"T": grid}, {}, box)
    assert scene.box == box
    assert len(scene.units) == 2
    assert scene.warnings == ()


def test_a_box_beside_the_rim_by_rounding_is_closed_and_an_area_inside_stays():
    grid, corners = turned(0.0)
    west, south = corners.min(axis=0)
    east, north = corners.max(axis=0)
    scene = gs.Scene({"T": grid}, {}, (west - 1e-9, east, south, north, -1800.0, -1500.0))
    with pytest.warns(GeosurfWarning, match="The model box runs along the rim"):
        assert len(scene.units) == 2
    top = gs.triangulate_horizon(grid, name="T")
    inside = corners.mean(axis=0) + 0.5 * (corners - corners.mean(axis=0))
    assert off_the_rims(inside, [top], "area of interest") is inside


def test_rims_around_holes_and_of_meshes_count():
    grid, corners = turned(30.0)
    padded, _ = turned(30.0, (11, 9))
    padded = padded.where((np.arange(11)[:, None] < 9) & (np.arange(9) < 7))
    mesh = gs.triangulate_horizon(grid, name="T")
    mesh = gs.TriSurface("T", "horizon", mesh.vertices, mesh.triangles)
    for horizon in (padded, mesh):
        scene = gs.Scene({"T": horizon}, {}, aoi=corners)
        with pytest.warns(GeosurfWarning, match="rim of horizon 'T'"):
            assert len(scene.units) == 2


def test_a_horizon_that_ends_farther_inside_still_leaks():
    grid, corners = turned(30.0)
    middle = corners.mean(axis=0)
    with pytest.raises(gs.errors.OpenUnitError, match="Shrink"):
        _ = gs.Scene({"T": grid}, {}, aoi=middle + 1.001 * (corners - middle)).units


# ---- Horizons of one survey: 2-D coordinates are read and held once, and results do not show
def coordinates(rng, kind):
    """Eastings and northings: rotated or bent, turned either way."""
    n_row, n_col = rng.integers(2, 90, 2)
    i, j = np.meshgrid(np.arange(n_row), np.arange(n_col), indexing="ij")
    angle, (step, other) = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(5.0, 60.0, 2)
    u, v = step * j, other * i * rng.choice([-1.0, 1.0])
    if kind == "bent":
        u, v = u + 0.1 * step * np.sin(i / 3.0), v + 0.1 * other * np.cos(j / 5.0)
    x = 461_000.0 + u * np.cos(angle) - v * np.sin(angle)
    y = 5_931_000.0 + u * np.sin(angle) + v * np.cos(angle)
    return x, y


def test_a_map_that_differs_in_one_bit_is_another():
    x, y = coordinates(np.random.default_rng(3), "rotated")
    first = Lattice(x, y, np.zeros(x.shape))
    moved = x.copy()
    moved[len(x) // 2, 0] = np.nextafter(moved[len(x) // 2, 0], np.inf)
    assert first.has_map(x, y)
    assert not first.has_map(moved, y)
    assert not Lattice(0.0 * x, y, x).has_map(-0.0 * x, y)


def survey_of(kind, n=3):
    """Horizons over one map, as `Scene` takes them."""
    rng = np.random.default_rng(len(kind))
    x, y = coordinates(rng, kind)
    found = {}
    for k in range(n):
        heights = rng.normal(-1000.0 - 300.0 * k, 5.0, x.shape)
        found[f"H{k}"] = gridded(heights, x.copy(), y.copy())
    return found


@pytest.mark.parametrize("kind", ["rotated", "bent"])
def test_a_scene_holds_the_map_once_and_has_the_same_bytes(kind):
    horizons = survey_of(kind)
    scene = gs.Scene(horizons)
    alone = {name: gs.triangulate_horizon(one, name=name) for name, one in horizons.items()}
    other = gs.Scene(alone)
    lattices = [scene.surface(name).lattice for name in horizons]
    assert all(one.easting is lattices[0].easting for one in lattices)
    assert scene.aoi.tobytes() == other.aoi.tobytes()
    assert scene.patches.vertices.tobytes() == other.patches.vertices.tobytes()
    assert scene.patches.triangles.tobytes() == other.patches.triangles.tobytes()

    # another horizon of the survey refers to the map as well; one off it has its own
    before, deeper = scene.volumes.copy(deep=True), horizons["H1"] - 20.0
    deeper.attrs = horizons["H1"].attrs
    beside = deeper.assign_coords(easting=deeper.easting + 0.25)
    moved = scene.replace(horizons={"H1": deeper, "H2": beside})
    assert moved.surface("H1").lattice.easting is lattices[0].easting
    assert moved.surface("H2").lattice.easting[0, 0] == lattices[0].easting[0, 0] + 0.25

    # what the user does to the arrays afterwards changes nothing
    for one in horizons.values():
        one.values[:] = 0.0
        one.coords["easting"].values[:] = 0.0
    assert scene.volumes.equals(before)
    assert np.abs(lattices[0].easting).min() > 1.0


def test_areas_move_off_rims_by_more_than_a_repair_of_rounding_moves_vertices():
    assert repair.STEPS[0] == outline.ROUNDED  # rooms that may not import each other
    assert outline.FURTHER > 1.0
