"""Close-ups: what is cut to the box, and that the mark is in it."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.conventions import palette
from geosurf.kernels.lattices.sets import rim_edges
from geosurf.render import render_place
from geosurf.render.clip import Prism
from geosurf.render.compose import show_place
from tests.strategies import grid, sheet


@pytest.fixture
def surfaces():
    flat = grid("Top", np.zeros((11, 11)), spacing=10.0)
    wall = sheet("F1", [(50, 0, -50), (50, 100, -50), (50, 100, 50), (50, 0, 50)])
    far = grid("Far", np.full((2, 2), 500.0), spacing=100.0)
    return [flat, wall, far]


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
