"""Which pictures of a scene are drawn, and how: what is refused before anything is computed."""

from __future__ import annotations

import pytest

import geosurf as gs
from geosurf.errors import InputError

NONE = {
    "views": [], "exploded": False, "maps": False, "thickness": False, "allan": False,
    "throw": False, "sections": [],
}  # fmt: skip


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.tilted_planes(n=3)
    return gs.Scene(world.horizons, world.faults, world.box)


def test_a_camera_gives_a_further_view_in_the_style_of_all(scene, tmp_path):
    style = gs.PictureStyle(theme="dark", colours={"Top": "teal", "Tpo": "red"})
    look = {"camera": (225, 30), "zoom": 1.5, "style": style, "size": (300, 200)}
    with pytest.warns(gs.GeosurfWarning, match="'Tpo': its colour is not used.*'Top'"):
        drawn = scene.render_pictures(tmp_path, **NONE, **look)
    ((caption, path),) = drawn.items()
    assert caption.endswith("seen from azimuth 225°, 30° above the horizontal.")
    assert path.name == "view_camera.png"


@pytest.mark.parametrize(
    "wrong",
    [{"camera": (1, 2, 3)}, {"zoom": -1}, {"colour_by": "zoen"}, {"only": 5}, {"style": "dark"}],
)
def test_wrong_looks_are_refused(scene, wrong, tmp_path):
    with pytest.raises(InputError):
        scene.render_pictures(tmp_path, **NONE, **wrong)
