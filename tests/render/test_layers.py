"""What is shown, before anything is drawn."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Scene, synthetic, tear_horizon
from geosurf.conventions import palette
from geosurf.kernels.lattices.sets import rim_edges
from geosurf.model import Lattice, TriSurface
from geosurf.render import render_place, surface_layers, views
from geosurf.render.clip import Prism, convex_parts
from geosurf.render.compose import show_place
from geosurf.render.surface_layers import as_modelled
from tests.grids import ring_area
from tests.strategies import grid, sheet


def big_surface(n_row, n_col, rotated=False):
    x, y = np.arange(n_col) * 25.0, np.arange(n_row) * 25.0
    if rotated:
        x, y = np.meshgrid(x, y)
        x, y = 0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y
    return TriSurface("Top", "horizon", lattice=Lattice(x, y, np.zeros((n_row, n_col))))


@pytest.mark.parametrize("rotated", [False, True])
def test_a_big_grid_is_strided_to_its_border_and_its_own_triangles_are_never_made(rotated):
    surface = big_surface(901, 1203, rotated)
    light = surface_layers.thinned(surface)
    assert 100_000 < light.n_triangle <= surface_layers.MOST
    assert "triangles" not in vars(surface)
    np.testing.assert_array_equal(light.vertices.min(axis=0), surface.vertices.min(axis=0))
    np.testing.assert_array_equal(light.vertices.max(axis=0), surface.vertices.max(axis=0))


def test_blocks_move_sideways_and_zones_up_and_down(units):
    shifts = dict(zip(units, surface_layers.explosion(units, 0.5), strict=True))
    west, east = shifts["Top/Base F1-"], shifts["Top/Base F1+"]
    assert west[0] < 0 < east[0]
    assert west[2] == east[2] == 0.0
    height = units.box[5] - units.box[4]
    assert shifts["above Top F1-"][2] == 0.5 * height
    assert shifts["below Base F1-"][2] == -0.5 * height
    np.testing.assert_array_equal(shifts["above Top F1-"][:2], west[:2])
    assert all((shift == 0.0).all() for shift in surface_layers.explosion(units, 0.0))


# ---- Close-ups: what is cut to the box, and that the mark is in it.
@pytest.fixture
def surfaces():
    flat = grid("Top", np.zeros((11, 11)), spacing=10.0)
    wall = sheet("F1", [(50, 0, -50), (50, 100, -50), (50, 100, 50), (50, 0, 50)])
    return [flat, wall, grid("Far", np.full((2, 2), 500.0), spacing=100.0)]


def test_surfaces_are_cut_to_what_is_near(surfaces):
    content, box = show_place(surfaces, (52.0, 31.0, 1.0), 20.0)
    assert [entry.label for entry in content.legend] == ["Top", "F1", "Location"]
    assert box[:4] == (32.0, 72.0, 11.0, 51.0)
    for layer in content.layers:
        assert (layer.points >= np.array(box[0::2]) - 1e-9).all()
        assert (layer.points <= np.array(box[1::2]) + 1e-9).all()
    top, wall = (layer for layer in content.layers if layer.triangles is not None)
    a, b, c = (top.points[top.triangles[:, k]] for k in range(3))
    assert 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() == pytest.approx(40 * 40)
    assert np.ptp(wall.points, axis=0) == pytest.approx([0, 40, 40])
    mark = content.layers[-1]
    assert mark.colour == palette.ACCENT
    np.testing.assert_allclose(mark.points.mean(axis=0), [52, 31, 1])


def test_a_close_up_is_drawn(surfaces, tmp_path):
    path = render_place(surfaces, (50, 30, 0), tmp_path / "place.png", size=(400, 260))
    assert path.stat().st_size > 2000


def test_triangles_that_are_cut_still_share_their_corners():
    """Where neighbours leave the box their corners are one, or rims are drawn inside a surface."""
    surface = grid("Top", np.random.default_rng(2).normal(size=(12, 12)))
    low, high = np.array([2.3, 3.1, -0.7]), np.array([8.7, 9.9, 0.7])
    box = np.column_stack([low, high]).ravel()
    vertices, triangles, _ = Prism(box).triangles(surface.vertices, surface.triangles)
    rims = vertices[rim_edges(triangles)]
    on_a_side = (np.isclose(rims, low) | np.isclose(rims, high)).any(axis=2).all(axis=1)
    assert len(rims) > 20
    assert on_a_side.all()


# ---- What pictures show of surfaces: what is inside the model, with edges where it is cut.
SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
STAR = np.array([[0, 0], [4, 1], [8, 0], [7, 4], [8, 8], [4, 7], [0, 8], [1, 4]], dtype=float)
HOOK = np.array([[0, 0], [8, 0], [8, 8], [6, 8], [6, 2], [2, 2], [2, 8], [0, 8]], dtype=float)


def map_area(points, triangles):
    a, b, c = (points[triangles[:, k], :2] for k in range(3))
    u, v = b - a, c - a
    return 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()


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


def test_torn_horizons_are_drawn_as_far_as_their_faults():
    world = synthetic.torn("normal", n=41)
    sheet = tear_horizon(world.horizons["Top"], world.faults, name="Top")
    faults = {fault.name: fault for fault in sheet.faults}
    scene = Scene({"Top": sheet}, faults, (100, 900, 100, 900, -2050, -1550))
    shown = as_modelled(scene, scene.surface("Top"), 10**6)
    assert shown.name == "Top"
    outer = sheet.surface.vertices[sheet.ghost][sheet.outer]
    assert not (shown.vertices[:, None] == outer[None]).all(axis=2).any()
    fault = scene.surface("F1")
    assert as_modelled(scene, fault, 10) is fault


# ---- Cameras and projection: right-handed, centred, and blind to where the origin is.
BOUNDS = (456000.0, 460000.0, 6780000.0, 6783000.0, -2500.0, -1700.0)


@pytest.mark.parametrize("view", views.VIEWS)
def test_every_view_is_a_right_handed_frame_with_up_upwards(view):
    frame = np.array(views.view_vectors(view))
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert frame[1] @ (0, 0, 1) >= -1e-12


@pytest.mark.parametrize("view", views.VIEWS)
def test_the_box_fills_the_picture_and_stays_inside(view):
    camera = views.aim(view, BOUNDS, (900, 600), 2.0)
    pixels = camera.to_pixels(views.corners(BOUNDS))
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    assert (low > -1e-6).all()
    assert (high < np.array([900, 600]) + 1e-6).all()
    assert ((high - low) / (900, 600)).max() == pytest.approx(1.0)
