"""What pictures show of surfaces: what is inside the model, with edges where it is cut."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Scene, synthetic, tear_horizon
from geosurf.kernels.lattices.sets import rim_edges
from geosurf.render.clip import Prism, convex_parts
from geosurf.render.surface_layers import as_modelled

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
STAR = np.array([[0, 0], [4, 1], [8, 0], [7, 4], [8, 8], [4, 7], [0, 8], [1, 4]], dtype=float)
HOOK = np.array([[0, 0], [8, 0], [8, 8], [6, 8], [6, 2], [2, 2], [2, 8], [0, 8]], dtype=float)


def map_area(points, triangles):
    a, b, c = (points[triangles[:, k], :2] for k in range(3))
    u, v = b - a, c - a
    return 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()


def ring_area(ring):
    p, q = ring, np.roll(ring, -1, axis=0)
    return 0.5 * (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum()


def tilted(n=7, size=10.0):
    axis = np.linspace(-1.0, size - 1.0, n)
    x, y = np.meshgrid(axis, axis)
    points = np.column_stack([x.ravel(), y.ravel(), 0.1 * x.ravel()])
    cells = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = (
        np.stack([cells, cells + 1, cells + n + 1], 1),
        np.stack([cells, cells + n + 1, cells + n], 1),
    )
    return points, np.concatenate(faces)


@pytest.mark.parametrize("ring", [SQUARE, STAR, HOOK], ids=["square", "star", "hook"])
def test_the_parts_of_a_polygon_add_up_and_know_its_sides(ring):
    parts = convex_parts(ring)
    assert sum(ring_area(part) for part, _ in parts) == ring_area(ring)
    for part, _ in parts:
        corners = [np.roll(part, -k, axis=0) for k in range(3)]
        assert all(ring_area(np.array(three)) >= 0 for three in zip(*corners, strict=True))
    assert sum(int(outer.sum()) for _, outer in parts) == len(ring)
    assert len(parts) == (1 if ring is SQUARE else len(ring) - 2)


@pytest.mark.parametrize("ring", [SQUARE, STAR, HOOK], ids=["square", "star", "hook"])
def test_a_surface_is_cut_to_the_area_and_its_cuts_go_around_it(ring):
    points, triangles = tilted()
    x, t, walls = Prism((0, 8, 0, 8, -5, 5), ring).triangles(points, triangles)
    assert map_area(x, t) == pytest.approx(ring_area(ring), rel=1e-12)
    np.testing.assert_allclose(x[:, 2], 0.1 * x[:, 0], atol=1e-12)
    assert (t != np.roll(t, 1, axis=1)).all()
    length = np.linalg.norm(np.diff(x[walls][:, :, :2], axis=1), axis=2).sum()
    around = np.linalg.norm(np.roll(ring, -1, 0) - ring, axis=1).sum()
    assert length == pytest.approx(around, rel=1e-12)


def test_levels_cut_too_and_neighbours_share_the_cut():
    points, triangles = tilted()
    x, t, walls = Prism((-9, 19, -9, 19, 0.2, 0.5)).triangles(points, triangles)
    assert (x[:, 2].min(), x[:, 2].max()) == (0.2, 0.5)
    assert map_area(x, t) == pytest.approx(3.0 * 10.0, rel=1e-12)
    assert set(np.unique(x[walls][:, :, 2])) == {0.2, 0.5}
    rim = rim_edges(t)  # no seams inside
    on_rim = np.isin(x[rim][:, :, 2], (0.2, 0.5)) | np.isin(x[rim][:, :, 1], (-1.0, 9.0))
    assert on_rim.all()


def test_torn_horizons_are_drawn_as_far_as_their_faults():
    world = synthetic.torn("normal", n=41)
    sheet = tear_horizon(world.horizons["Top"], world.faults, name="Top")
    faults = {fault.name: fault for fault in sheet.faults}
    scene = Scene({"Top": sheet}, faults, (100, 900, 100, 900, -2050, -1550))
    shown = as_modelled(scene, scene.surface("Top"), 10**6)
    assert shown.name == "Top"
    ghost = sheet.surface.vertices[sheet.ghost]
    outer = ghost[sheet.outer]
    assert not (shown.vertices[:, None] == outer[None]).all(axis=2).any()
    fault = scene.surface("F1")
    assert as_modelled(scene, fault, 10) is fault
