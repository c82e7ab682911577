"""What notebooks show: a card of every object, names escaped, nothing computed; which pictures."""

from __future__ import annotations

import html
import re
from html.parser import HTMLParser

import numpy as np
import pytest

import geosurf as gs
from geosurf.render.interactive import view_of
from tests.messages import refused

NAME = "<b>Top & 'x\"</b>"
VOID = {"meta", "br", "img", "input", "link"}


class Tags(HTMLParser):
    """Collects text, and notes tags that are not closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        assert tag != "b", "a name is not escaped"
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += f"{data} "


def shown(thing):
    return Tags(thing._repr_html_()).text


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.tilted_planes(n=5)
    horizons = {NAME: world.horizons["Top"], "Base": world.horizons["Base"]}
    return gs.Scene(horizons, world.faults, world.box)


def test_a_scene_shows_its_inputs_and_what_is_computed_and_computes_nothing(scene):
    world = gs.synthetic.tilted_planes(n=5)
    fresh = gs.Scene(world.horizons, world.faults)
    assert "nothing yet" in shown(fresh)
    assert fresh.steps == ()
    torn = gs.Scene(world.horizons, {"F1": "nowhere.ts"}, tear=True)
    assert "nothing yet" in shown(torn)  # it neither tears nor reads
    assert (torn.steps, torn.explain()) == ((), fresh.explain())
    assert scene.curves.n_curve
    for word in (NAME, "Base", "F1", "curves"):
        assert word in shown(scene), word


def test_an_interactive_view_is_one_page_in_a_frame_without_rights(scene, tmp_path):
    view = scene.show()
    frame = view._repr_html_()
    assert 'sandbox="allow-scripts allow-downloads"' in frame
    (page,) = re.findall(r'srcdoc="([^"]*)"', frame)
    assert html.unescape(page) == view.page
    assert "http://" not in view.page.replace("http://www.w3.org", "")
    assert view.save(tmp_path / "view.html").read_text(encoding="utf-8") == view.page
    assert view.page == scene.show().page
    assert "Base" in scene.show("surfaces").page
    with pytest.raises(gs.errors.OutputError, match=r"cannot be written"):
        view.save(tmp_path / "missing" / "view.html")
    refused(gs.errors.InputError, r"Use the suffix .html", view.save, tmp_path / "view.png")
    refused(gs.errors.InputError, "show 'units' or 'surfaces'", scene.show, "unit")


def test_everything_with_a_place_shows_itself(scene):
    world = gs.synthetic.graben(n=9)
    sheet = gs.throw_horizon(world.horizons["Top"], world.faults, dict.fromkeys(world.faults, 30.0))
    sticks = gs.FaultSticks("F9", ([[0, 0, 0], [0, 9, -9]], [[9, 0, 0], [9, 9, -9], [9, 9, -19]]))
    unit = next(iter(scene.units.values()))
    for noun in (
        scene.surface(NAME),
        scene.curves,
        scene.patches,
        scene.units,
        unit,
        sheet,
        sticks,
    ):
        assert noun.show().page == gs.show(noun).page
    page = gs.show(scene, scene.surface(NAME), sticks, scene.curves).page
    for name in ("F9", "Base and F1", html.escape(NAME)):
        assert name in page, name
    assert NAME not in page
    for nothing in ((), (gs.TriSurface("F", "fault", [[0, 0, 0]], []),)):
        refused(gs.errors.InputError, "there is nothing to show", gs.show, *nothing)
    refused(gs.errors.InputError, "type DataArray cannot be shown", gs.show, world.horizons["Top"])


def test_law_a_view_has_all_lines_of_curves_and_sticks(scene):
    sticks = gs.FaultSticks("F9", ([[0, 0, 0], [0, 3, 4]], [[9, 0, 0], [9, 3, 4], [9, 3, 5]]))
    bodies = view_of([scene.curves, sticks]).bodies
    lengths = [
        np.linalg.norm(np.diff(body.points[body.lines], axis=1), axis=2).sum() for body in bodies
    ]
    assert sum(lengths[:-1]) == pytest.approx(scene.curves.length)
    assert lengths[-1] == 11.0
    assert len(bodies) == 1 + len(np.unique(scene.curves.surfaces_of_curve, axis=0))


# ---- Which pictures of a scene are drawn, and how: what is refused before anything is compute
NONE = {
    "views": [], "exploded": False, "maps": False, "thickness": False, "allan": False,
    "throw": False, "sections": [],
}  # fmt: skip


def test_a_camera_gives_a_further_view_in_the_style_of_all(planes, tmp_path):
    style = gs.PictureStyle(theme="dark", colours={"Top": "teal", "Tpo": "red"})
    look = {"camera": (225, 30), "zoom": 1.5, "style": style, "size": (300, 200)}
    with pytest.warns(gs.GeosurfWarning, match="'Tpo': its colour is not used.*'Top'"):
        drawn = planes.render_pictures(tmp_path, **NONE, **look)
    ((caption, path),) = drawn.items()
    assert caption.endswith("seen from azimuth 225°, 30° above the horizontal.")
    assert path.name == "view_camera.png"


def test_sections_that_nobody_named_start_and_end_with_the_model(tmp_path):
    """Of an area that is not convex: the line through the middle, as far as it is in the area."""
    world = gs.synthetic.graben(n=11)
    corners = [(1000, 500), (4500, 500), (4500, 2000), (2500, 2000), (2500, 3500), (1000, 3500)]
    scene = gs.Scene(world.horizons, world.faults, aoi=corners)
    drawn = scene.render_pictures(tmp_path, **NONE | {"sections": None})
    assert [re.findall(r"[EN] (\d+)", caption) for caption in drawn] == [
        ["1000", "2000", "4500", "2000"],
        ["2750", "500", "2750", "2000"],
    ]
