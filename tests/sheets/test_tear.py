"""Horizons as picked, torn: against worlds whose cut-offs are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs

CELL = 25.0
N = 61
# kind, points with several values per node, options
WORLDS = [
    ("normal", False, {}),
    ("gentle", False, {}),
    ("vertical", False, {}),
    ("through", False, {}),
    ("listric", False, {}),
    ("reverse", True, {}),
    ("Y", False, {}),
    ("X", False, {}),
    ("parallel", False, {"smear": 0, "trim": 1.0}),
]
IDS = [kind for kind, _, _ in WORLDS]


def ends_of(world, fault: str, points: np.ndarray) -> np.ndarray:
    """Distance [m] of points to both ends of a fault at their own elevation."""
    ds = world.faults[fault]
    x, y, z = (ds[k].values for k in ("easting", "northing", "elevation"))
    far = []
    for col in (0, -1):
        order = np.argsort(z[:, col])
        ex, ey = (np.interp(points[:, 2], z[order, col], c[order, col]) for c in (x, y))
        far.append(np.hypot(points[:, 0] - ex, points[:, 1] - ey))
    return np.minimum(*far)


def inner_truth(world, fault: str, wall: str) -> np.ndarray:
    """Points of a true cut-off beyond two cells from its ends, the data's rim, and other faults."""
    true = world.truth["cutoffs"][fault, wall]
    w, e, s, n = world.box[:4]
    rim = np.min([true[:, 0] - w, e - true[:, 0], true[:, 1] - s, n - true[:, 1]], axis=0)
    keep = (ends_of(world, fault, true) > 2 * CELL) & (rim > 2 * CELL)
    for other in world.faults:
        if other != fault:
            lines = np.concatenate([world.truth["cutoffs"][other, w] for w in "+-"])
            gap = np.hypot(*(true[:, None, :2] - lines[None, ::4, :2]).transpose(2, 0, 1))
            keep &= gap.min(axis=1) > 2 * CELL
    return true[keep]


@pytest.mark.parametrize(("kind", "points", "options"), WORLDS, ids=IDS)
def test_cutoffs_are_within_a_tenth_of_a_cell(torn_world, distances, kind, points, options):
    world, sheet = torn_world(kind, points, n=N, **options)
    for name, cut in sheet.cuts.items():
        for wall in "+-":
            true = inner_truth(world, name, wall)
            assert len(true) > 50
            assert distances(true, cut.cutoffs[wall]).max() < 0.1 * CELL


@pytest.mark.parametrize("kind", ["normal", "gentle", "vertical", "through", "listric", "reverse"])
def test_throw_is_met(torn_world, kind):
    world, sheet = torn_world(kind, kind == "reverse", n=N)
    cut = sheet.cuts["F1"]
    foot, hang = (world.truth["cutoffs"]["F1", wall] for wall in "-+")
    largest = np.abs(foot[: len(hang), 2] - hang[: len(foot), 2]).max()
    inner = ends_of(world, "F1", cut.stations) > 2.5 * CELL
    inner &= np.isfinite(cut.throw)
    # at each station: the true heights where each wall's cut-off is nearest to the found one
    found = cut.throw[inner]
    s = cut.stations[inner]
    near = [
        np.hypot(*(s[:, None, :2] - line[None, :, :2]).transpose(2, 0, 1)) for line in (foot, hang)
    ]
    true = foot[near[0].argmin(axis=1), 2] - hang[near[1].argmin(axis=1), 2]
    error = np.abs(found - true) / largest
    assert error.mean() < 0.015  # stations and truth are not on one dip line: 5 m apart
    assert error.max() < 0.06


@pytest.mark.parametrize("kind", ["normal", "through", "listric", "gentle"])
def test_cutoffs_have_no_saw_teeth(torn_world, kind):
    world, sheet = torn_world(kind, n=N)
    for wall in "+-":
        true = world.truth["cutoffs"]["F1", wall]
        lines = sheet.cuts["F1"].cutoffs[wall]
        variation = sum(np.abs(np.diff(line[:, 2])).sum() for line in lines)
        assert variation / np.abs(np.diff(true[:, 2])).sum() == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(("kind", "points", "options"), WORLDS, ids=IDS)
def test_tips_of_the_mesh_are_the_free_ends_of_the_faults(torn_world, kind, points, options):
    _, sheet = torn_world(kind, points, n=N, **options)
    assert sheet.report.tips == sheet.report.declared_tips
    assert sum(sheet.report.sign_changes.values()) == 0


@pytest.mark.parametrize(("kind", "points", "options"), WORLDS, ids=IDS)
def test_every_sheet_ends_on_its_faults_and_nowhere_else(torn_world, kind, points, options):
    """Rims of the exactly cut sheet: the data's own outline, and edges that faults share."""
    world, sheet = torn_world(kind, points, n=N, **options)
    patches = gs.drop_ghosts(gs.rebuild_surfaces([sheet.surface, *sheet.faults]))
    of = patches.surface_of_triangle
    edges = [
        np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        for t in (patches.triangles[of == 0], patches.triangles[of > 0])
    ]
    own, times = np.unique(edges[0], axis=0, return_counts=True)
    assert times.max() == 2
    rim = own[times == 1]
    shared = {tuple(e) for e in edges[1].tolist()}
    free = np.array([e for e in rim.tolist() if tuple(e) not in shared])
    x, y = patches.vertices[free][..., 0], patches.vertices[free][..., 1]
    w, e, s, n = world.box[:4]
    border = ((x == w) | (x == e)).all(axis=1) | ((y == s) | (y == n)).all(axis=1)
    assert border.all()


def test_noise_is_noticed_and_smoothed(torn_world, distances):
    world, sheet = torn_world("normal", n=81, noise=2.0)
    assert sheet.report.noise == pytest.approx(2.0, rel=0.2)
    for wall in "+-":
        true = inner_truth(world, "F1", wall)
        assert distances(true, sheet.cuts["F1"].cutoffs[wall]).max() < 0.25 * CELL


def test_clean_data_are_met_exactly(torn_world):
    _, sheet = torn_world("normal", n=N)
    assert sheet.report.noise is None
    assert sheet.report.kept["max"] == 0.0
    assert sheet.report.n_distrusted < 0.2 * sheet.report.n_data


def test_a_rotated_grid_gives_the_same_sheet(torn_world):
    world, sheet = torn_world("normal", n=N)
    turn, shift = np.radians(30.0), np.array([456000.0, 5930000.0])
    matrix = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    grid = world.horizons["Top"]
    x, y = np.meshgrid(grid["easting"].values, grid["northing"].values)
    points = np.column_stack([x.ravel(), y.ravel()]) @ matrix + shift
    faults = {}
    for name, ds in world.faults.items():
        xy = np.stack([ds["easting"].values, ds["northing"].values], axis=-1) @ matrix + shift
        faults[name] = ds.assign(
            easting=(ds.easting.dims, xy[..., 0]), northing=(ds.easting.dims, xy[..., 1])
        )
    cloud = np.column_stack([points, grid.values.ravel()])
    turned = gs.tear_horizon(cloud, faults, name="Top", trim=2.25)
    assert np.nanmax(np.abs(turned.cuts["F1"].throw)) == pytest.approx(
        np.nanmax(np.abs(sheet.cuts["F1"].throw)), abs=0.05
    )
    assert np.sort(turned.lattice.elevation.ravel()) == pytest.approx(
        np.sort(sheet.lattice.elevation.ravel()), abs=0.02
    )


def test_a_gap_in_the_data_along_the_fault_is_filled(distances):
    world = gs.synthetic.torn("through", n=N)
    grid = world.horizons["Top"].copy()
    true = np.concatenate([world.truth["cutoffs"]["F1", wall] for wall in "+-"])
    x, y = np.meshgrid(grid["easting"].values, grid["northing"].values)
    near = np.hypot(x[..., None] - true[::5, 0], y[..., None] - true[::5, 1]).min(axis=-1)
    sheet = gs.tear_horizon(grid.where(near > 1.6 * CELL), world.faults, trim=2.0)
    assert np.isfinite(sheet.lattice.elevation).all()
    for wall in "+-":
        inner = inner_truth(world, "F1", wall)
        assert distances(inner, sheet.cuts["F1"].cutoffs[wall]).max() < 0.1 * CELL
