"""Pictures, judged by counts of pixels: drivers differ, colours hardly."""

import numpy as np
import pytest

from geosurf.conventions import palette
from geosurf.render import backend, compose, surface_layers, views
from geosurf.render.backend import draw_layers
from geosurf.render.compose import plotted
from geosurf.render.layers import Layer
from geosurf.render.map import draw_map
from geosurf.scene.plots import ScenePlots

SMALL = (640, 400)


def pixels(path):
    from matplotlib.image import imread

    return imread(path)[:, :, :3]


def share(image, colour, near=0.12):
    """Part of the picture whose hue is that of a colour, whatever its light."""
    light = image.max(axis=2, keepdims=True)
    hue = image / np.maximum(light, 1e-6)
    wanted = np.array(colour) / max(colour)
    close = (np.abs(hue - wanted) < near).all(axis=2) & (light[:, :, 0] > 0.2)
    return close[:, : int(image.shape[1] * 0.76)].mean()


def dark(image):
    """Part of the drawn rectangle that is nearly black."""
    height, width = image.shape[:2]
    inner = image[height // 8 : -height // 6, width // 8 : int(width * 0.76)]
    return (inner.max(axis=2) < 0.25).mean()


class Lazy:
    """A scene that notes what it is asked for."""

    def __init__(self, scene):
        self._scene, self.asked = scene, set()

    def __getattr__(self, name):
        self.asked.add(name)
        return getattr(self._scene, name)


def test_scene_shows_horizons_faults_and_curves(scene, tmp_path):
    path = ScenePlots(scene).view(path=tmp_path / "new" / "scene.png", size=SMALL)
    image = pixels(path)
    assert image.shape == (400, 640, 3)
    assert share(image, palette.stratum(0)) > 0.08
    assert share(image, palette.stratum(1)) > 0.02
    assert (image == 1.0).all(axis=2).mean() > 0.35
    without = ScenePlots(scene).view(path=tmp_path / "no.png", size=SMALL, show=["horizons"])
    assert dark(pixels(without)) < dark(image)


def test_utm_offsets_do_not_change_a_pixel(top, fault):
    """float32 steps are half a metre at these northings; none of it may show."""

    def draw(shift):
        shown = surface_layers.show_surfaces([top, fault]).moved(shift)
        bounds = views.bounds_of([layer.points for layer in shown.layers])
        return draw_layers(shown.layers, views.aim("southwest", bounds, (300, 200), 2.0))

    far = draw(np.array([2.0**24, 2.0**26, 0.0]))
    np.testing.assert_array_equal(draw(np.zeros(3)), far)


@pytest.mark.parametrize("largest", [540_000, 9_000])  # four parts, and 25 of uneven sizes
def test_parts_of_a_picture_fit_together_without_a_seam(monkeypatch, largest):
    """The middle of a picture is where parts meet that are drawn one after the other."""
    monkeypatch.setattr(backend, "LARGEST_PART", largest)
    size, width = (301, 200), 5.0  # an odd number: the middle is between two pixels

    def dark(x0):
        ends = np.array([[x0, -500.0, 0.0], [x0, 500.0, 0.0], [-500.0, x0, 0.0], [500.0, x0, 0.0]])
        lines = Layer(ends, lines=np.array([[0, 1], [2, 3]]), colour=(0.0, 0.0, 0.0), width=width)
        camera = views.Camera(*np.eye(3), np.zeros(3), 1.0, size, 1.0)
        return 255.0 - draw_layers((lines,), camera, (1.0, 1.0, 1.0)).mean(axis=2)

    middle, beside = dark(1.0), dark(40.0)  # a part of each line is beyond the middle
    for found in (middle, beside):
        assert found.sum(axis=1).min() == pytest.approx(255.0 * width, rel=0.02)
        assert found.sum(axis=0).min() == pytest.approx(255.0 * width, rel=0.02)
    assert middle.sum() == pytest.approx(beside.sum(), rel=0.002)


@pytest.mark.parametrize(
    ("show", "asked"),
    [
        (("horizons",), {"surfaces", "box"}),
        (("curves",), {"curves", "box"}),
        (("units",), {"units", "box"}),
        (("patches",), {"patches", "box"}),
    ],
)
def test_a_scene_is_asked_only_for_what_is_shown(scene, tmp_path, show, asked):
    lazy = Lazy(scene)
    ScenePlots(lazy).view(path=tmp_path / "lazy.png", size=(300, 200), show=show)
    assert lazy.asked - {"aoi", "time", "_inputs"} == asked


def test_units_are_drawn_apart_in_their_colours(scene, units, tmp_path):
    look = {"show": ["units"], "size": SMALL}
    path = scene.plot.view(path=tmp_path / "units.png", exploded=0.3, **look)
    image = pixels(path)
    for entry in surface_layers.show_units(units).legend:
        assert share(image, entry.colour, 0.06) > 0.004, entry.label
    whole = pixels(scene.plot.view(path=tmp_path / "whole.png", **look))
    assert (whole != 1.0).any(axis=2).sum() != (image != 1.0).any(axis=2).sum()


def test_the_search_is_explained_in_colour(top, fault, search, curves, tmp_path):
    shown = compose.show_search(top, fault, search, curves)
    path = tmp_path / "search.png"
    compose.draw_picture(shown, path, title="", view="southwest", size=SMALL, exaggeration=None)
    image = pixels(path)
    assert share(image, palette.ACCENT, 0.2) > 0.001
    assert share(image, palette.VOXEL, 0.25) > 0.001


def test_map_has_contours_curves_and_elevation_colours(top, curves, tmp_path):
    plain = pixels(plotted(draw_map, top, path=tmp_path / "plain.png", size=SMALL))
    image = pixels(plotted(draw_map, top, curves, path=tmp_path / "map.png", size=SMALL))
    assert share(image, palette.fault(0), 0.1) > share(plain, palette.fault(0), 0.1) + 3e-4
    assert len(np.unique(plain[80:300, 100:450].reshape(-1, 3), axis=0)) > 40


def test_map_is_the_same_twice_and_leaves_pyplot_alone(top, curves, tmp_path):
    import sys

    def figures() -> list[int]:
        """Those that pyplot knows; other tests of this process may have left some."""
        pyplot = sys.modules.get("matplotlib.pyplot")
        return pyplot.get_fignums() if pyplot else []

    before = figures()
    one = plotted(draw_map, top, curves, path=tmp_path / "1.png", size=SMALL).read_bytes()
    two = plotted(draw_map, top, curves, path=tmp_path / "2.png", size=SMALL).read_bytes()
    assert one == two
    assert figures() == before
