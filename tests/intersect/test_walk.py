"""Walked curves against plain ones of the same cubics, drawn finely; bounds against all pairs."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Lattice, TriSurface, intersect_surfaces
from geosurf.intersect import dial
from geosurf.intersect.sides import find_candidates, side_of
from geosurf.kernels.smooth.newton_seeds import patch_cone
from geosurf.kernels.smooth.patch_pyramid import BLOCK
from tests.intersect.cubics import points_on
from tests.intersect.smooth_worlds import (
    along,
    distance_from,
    horizon,
    level,
    listric_fault,
    wavy_horizon,
)

SIDE = 1000.0


def sines(rng, scale):
    """Return a sum of three waves as a function of two coordinates."""
    parts = [
        (rng.normal() * scale, *(rng.normal(size=2) * 0.008), rng.uniform(0, 6)) for _ in "abc"
    ]
    return lambda x, y: sum(a * np.sin(p * x + q * y + r) for a, p, q, r in parts)


def rolling_pair(seed):
    """Two lattices of waves, one of them turned, that meet in several curves."""
    rng = np.random.default_rng(seed)
    n, m = rng.integers(30, 60, 2)
    top = horizon(sines(rng, 30.0), int(n), SIDE, "Top")
    x = np.linspace(-SIDE / 2, SIDE / 2, m)
    u, v = np.meshgrid(x, x)
    turn = rng.uniform(0, 6)
    e, k = 500 + np.cos(turn) * u - np.sin(turn) * v, 500 + np.sin(turn) * u + np.cos(turn) * v
    tilted = Lattice(e, k, sines(rng, 9.0)(u, v) + rng.uniform(0, 0.3) * u)
    return top, TriSurface("Tilt", "fault", lattice=tilted)


def drawn_finely(surface, k=6):
    """The same cubics as a lattice with k times as many nodes."""
    lattice = surface.lattice
    x, y, z = (np.ascontiguousarray(q) for q in (*lattice.horizontal(), lattice.elevation))
    rows, cols = (z.shape[0] - 1) * k + 1, (z.shape[1] - 1) * k + 1
    at = np.stack(np.meshgrid(np.arange(cols) / k, np.arange(rows) / k), axis=-1).reshape(-1, 2)
    points = points_on(x, y, z, at).reshape(rows, cols, 3)
    return TriSurface(
        surface.name, surface.role, lattice=Lattice(*(points[..., i].copy() for i in range(3)))
    )


@pytest.fixture
def walks(monkeypatch):
    """Whether each pair was walked, in order."""
    seen, walk = [], dial.walk_curves

    def spy(*arguments):
        lines = walk(*arguments)
        seen.append(lines is not None)
        return lines

    monkeypatch.setattr(dial, "walk_curves", spy)
    return seen


@pytest.mark.parametrize("seed", [3, 8])
def test_every_curve_of_the_cubics_is_walked_once(seed, walks):
    pair = rolling_pair(seed)
    walked = intersect_surfaces(pair, tolerance=0.05)
    plain = intersect_surfaces([drawn_finely(surface) for surface in pair])
    assert walks == [True]
    assert plain.n_curve > 0
    assert sorted(walked.closed.tolist()) == sorted(plain.closed.tolist())
    # six times finer: a thirty-sixth of the plain error of the cells themselves is left
    assert distance_from(plain.points[::9], walked).max() < 0.5
    assert distance_from(walked.points[::5], plain).max() < 0.5


def test_walked_and_lifted_curves_agree_within_their_bounds(walks, monkeypatch):
    pair = [wavy_horizon(141), listric_fault(71, 141)]
    walked = intersect_surfaces(pair, tolerance=0.02)
    assert walks == [True]
    monkeypatch.setattr(dial, "walk_curves", lambda *_: None)
    lifted = intersect_surfaces(pair, tolerance=0.02)
    assert walked.points.tobytes() != lifted.points.tobytes()
    both = walked.error_bound.max() + lifted.error_bound.max()
    assert distance_from(along(walked), lifted).max() <= both
    assert distance_from(along(lifted), walked).max() <= both
    assert len(walked.points) < len(lifted.points)


@pytest.mark.parametrize("spoil", ["hole", "noise"])
def test_what_is_not_whole_and_smooth_is_left_to_the_plain_curve(spoil, walks, rng):
    def height(x, y):
        z = 200 * np.sin(x / 600) * np.sin(y / 700)
        if spoil == "noise":
            return z + rng.normal(size=z.shape)
        z[38:42, 38:42] = np.nan
        return z

    other = horizon(lambda x, y: 0.05 * (x - 2000) + 0 * y, 33, name="Tilt")
    curves = intersect_surfaces([horizon(height, 81), other], tolerance=0.01)
    assert walks == ([False] if spoil == "hole" else [])  # noise is seen before
    assert {place.reason for place in curves.places} & {spoil}


@pytest.mark.parametrize("away", [3, 4])
def test_a_hole_that_only_the_estimate_reaches_is_left_to_the_plain_curve(away, walks):
    """The curve runs between columns 40 and 41; eight nodes around it are looked at."""

    def height(x, y):
        z = 0.05 * (x - 2025) + 1e-5 * (x - 2025) * (y - 2000)
        z[30, 41 + away] = np.nan
        return z

    curves = intersect_surfaces([horizon(height, 81), level(0.0)], tolerance=0.01)
    holes = [place for place in curves.places if place.reason == "hole"]
    assert walks == [away > 3]
    assert bool(holes) == (away == 3)
    assert curves.n_curve == 1


def test_a_bound_beyond_reach_is_told_and_the_curve_still_walked(walks):
    curves = intersect_surfaces([wavy_horizon(71), listric_fault(71, 71)], tolerance=1e-3)
    assert walks == [True]
    (place,) = curves.places
    assert place.reason == "interpolation"
    assert curves.error_bound[0] > place.error_bound > 1e-3


# ---- bounds ------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(8, 9), (17, 26), (25, 12)])
@pytest.mark.parametrize("absent", [0.0, 0.05])
def test_boxes_of_blocks_hold_their_cubics(shape, absent):
    """Whole numbers at random: no slope that is taken off may lose anything."""
    rng = np.random.default_rng(sum(shape))
    z = rng.integers(-3, 4, size=shape).astype(float)
    z[rng.random(shape) < absent] = np.nan
    u, v = np.meshgrid(np.arange(float(shape[1])), np.arange(float(shape[0])))
    side = side_of(TriSurface("A", "horizon", lattice=Lattice(u + 0.3 * v, v, z)), np.zeros(3))
    w = rng.random((4000, 2)) * (shape[1] - 1, shape[0] - 1)
    points = points_on(side.x, side.y, side.z, w)
    there = np.isfinite(points).all(axis=1)
    assert there.sum() > 100
    column, row = (w[there] // BLOCK).astype(int).T
    boxes = side.blocks[row * -(-(shape[1] - 1) // BLOCK) + column]
    assert (boxes[:, :3] <= points[there]).all()
    assert (points[there] <= boxes[:, 3:]).all()


@pytest.mark.parametrize("seed", range(4))
def test_no_pair_of_cells_that_share_a_place_is_left_out(seed):
    """Points of both cubics on a fine raster: where two are equal, their cells are candidates."""
    rng = np.random.default_rng(seed)
    x = np.arange(19.0)
    z = rng.integers(-2, 3, size=(2, 19, 19)).astype(float)
    pair = [TriSurface(name, "horizon", lattice=Lattice(x, x, z[k])) for k, name in enumerate("AB")]
    sides = [side_of(surface, np.zeros(3)) for surface in pair]
    near = find_candidates(*sides)
    found = {(near.cells[0][a], near.cells[1][b]) for a, b in near.pairs.tolist()}
    at = np.stack(np.meshgrid(np.arange(0.125, 18, 0.25), np.arange(0.125, 18, 0.25)), -1)
    heights = [points_on(side.x, side.y, side.z, at.reshape(-1, 2))[:, 2] for side in sides]
    gap = np.subtract(*heights).reshape(at.shape[:2])
    changes = 0
    for i in range(gap.shape[0]):
        for j in range(gap.shape[1] - 1):
            same = int(at[i, j, 0]) == int(at[i, j + 1, 0])
            if same and gap[i, j] * gap[i, j + 1] < 0:  # they meet between, in one cell
                cell = int(at[i, j, 1]) * 18 + int(at[i, j, 0])
                assert (cell, cell) in found
                changes += 1
    assert changes > 20


def crossing_pair(rough, absent, rng):
    """A curvilinear lattice of any heights, and one across it so that most cells meet."""
    u, v = np.meshgrid(np.arange(13.0), np.arange(11.0))
    z = rough * rng.integers(-2, 3, size=u.shape)
    z[rng.random(z.shape) < absent] = np.nan
    x, y = u + 0.1 * rough * rng.random(u.shape), v + 0.2 * u
    one = TriSurface("A", "horizon", lattice=Lattice(x, y, z))
    two = TriSurface("B", "fault", lattice=Lattice(u, 0.3 * u + v, 2.0 * v - 9.0, False))
    return [side_of(surface, np.zeros(3)) for surface in (one, two)]


@pytest.mark.parametrize("rough", [0.0, 0.02, 1.0])
@pytest.mark.parametrize("absent", [0.0, 0.05])
def test_patches_hold_their_cubics_and_cones_their_normals(rough, absent, rng):
    """At 21 x 21 places of each cell; rims, where stencils are shifted, are among them."""
    sides = crossing_pair(rough, absent, rng)
    near = find_candidates(*sides)
    at = np.stack(np.meshgrid(*[np.linspace(0, 1, 21)] * 2), -1).reshape(-1, 2) * (1 - 1e-9)
    cones = 0
    for side, cells, patches, whole in zip(
        sides, near.cells, near.patches, near.whole, strict=True
    ):
        assert len(cells) > 10
        for cell, m in zip(cells[whole == 1], patches[whole == 1], strict=True):
            corner = np.array(divmod(cell, side.z.shape[1] - 1))[::-1]
            points = points_on(side.x, side.y, side.z, at + corner)
            assert (m[:3] <= points).all()
            assert (points <= m[3:6]).all()
            along = points @ m[6:9]
            assert (m[9] <= along).all()
            assert (along <= m[10]).all()
            p, q, r, angle = patch_cone(m)
            if angle < np.pi:
                grid = points.reshape(21, 21, 3)
                du, dv = np.diff(grid, axis=1)[:-1], np.diff(grid, axis=0)[:, :-1]
                normals = np.cross(du, dv)
                normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
                assert (normals @ (p, q, r) >= np.cos(angle) - 1e-6).all()
                cones += 1
    assert cones > (10 if rough < 1.0 else 0)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.2])
def test_flat_patches_have_cones_of_no_width(angle):
    """Around the normal of their plane; cells are sheared and turned."""
    c, s = np.cos(angle), np.sin(angle)
    u, v = np.meshgrid(np.arange(12.0), 2.5 * np.arange(11.0))
    u, v = u - 5.5, v - 12.5  # in the middle they meet
    x, y = c * u - s * v + 0.2 * u, s * u + c * v
    one = TriSurface("A", "horizon", lattice=Lattice(x, y, 0.75 * x - 0.25 * y))
    two = TriSurface("B", "fault", lattice=Lattice(x, y, 0.5 * y + 0.1 * x))
    near = find_candidates(*(side_of(surface, np.zeros(3)) for surface in (one, two)))
    for patches, normal in zip(near.patches, ([-0.75, 0.25, 1.0], [-0.1, -0.5, 1.0]), strict=True):
        assert len(patches) > 4
        for m in patches:
            *axis, width = patch_cone(m)
            assert axis == pytest.approx(normal / np.linalg.norm(normal), abs=1e-12)
            assert width < 1e-12


def test_bends_are_the_largest_second_differences(rng):
    """Of all nodes that stencils of a block reach: one farther than its own, two at a rim."""
    z = rng.integers(-9, 10, size=(21, 30)).astype(float)
    x, y = np.arange(30.0) ** 2, np.arange(21.0)
    side = side_of(TriSurface("A", "horizon", lattice=Lattice(x, y, z)), np.zeros(3))
    along, across = np.abs(np.diff(z, 2, axis=1)), np.abs(np.diff(z, 2, axis=0))
    for block, bend in enumerate(side.bends):
        i, j = block // 4 * BLOCK, block % 4 * BLOCK
        rows = slice(max(i - 1, 0), i + BLOCK + 2)
        columns = slice(max(j - 1, 0), j + BLOCK)
        one = along[rows, columns].max()
        two = across[max(i - 1, 0) : i + BLOCK, j : j + BLOCK + 1].max()
        assert bend.tolist() == [2.0, 0.0, one + two, 0.0]
