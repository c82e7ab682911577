"""Models with zones of no thickness, one unit, slivers and coinciding contacts can be measured."""

from __future__ import annotations

from functools import cache

import pytest

from geosurf import Scene
from geosurf.render.compose import plotted
from geosurf.render.section import draw_section
from tests.measure.thin_worlds import BOX, WORLDS, fault, foreign, level, lines_of, measures, wedge

# of a world whose fault is left out; its warning has a test of its own
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
PINCHED = [name for name in WORLDS if "pinched" in name or "crossing" in name]


@cache
def scene_of(world):
    return WORLDS[world]()


@pytest.mark.parametrize("world", WORLDS)
def test_every_measure_is_a_result_or_an_error_of_geosurf(world):
    assert foreign(measures(scene_of(world))) == []


@pytest.mark.parametrize("world", WORLDS)
def test_the_rings_of_a_section_add_up_to_the_box(world):
    scene = scene_of(world)
    west, east, south, north, bottom, top = scene.box
    middle = 0.5 * (south + north)
    section = scene.section([(west, middle), (east, middle)])
    box = (east - west) * (top - bottom)
    if scene.aoi is None:
        assert float(section.area.sum()) == pytest.approx(box, rel=1e-9)


@pytest.mark.parametrize("world", PINCHED)
def test_sections_along_a_zone_of_no_thickness_are_drawn_without_it(world, tmp_path):
    scene, path = scene_of(world), tmp_path / "s.png"
    calls = (
        (
            str(line),
            lambda at=line: plotted(draw_section, scene.section(at), path=path, size=(400, 300)),
        )
        for line in lines_of(scene)[:4]
    )
    assert foreign(calls) == []


def test_the_legend_leaves_out_a_zone_of_no_thickness(tmp_path, monkeypatch):
    listed = []
    monkeypatch.setattr(
        "geosurf.render.section.draw_legend", lambda sheet, legend, room: listed.append(legend)
    )
    scene = Scene({"A": level("A", -150.0), "B": wedge("B", -150.0, 200.0)}, {"F1": fault()}, BOX)
    for east, zones in ((100.0, {"above A", "below B"}), (300.0, {"above A", "A/B", "below B"})):
        plotted(draw_section, scene.section([(east, 0.0), (east, 300.0)]), path=tmp_path / "s.png")
        assert {entry.label for entry in listed.pop()} == zones
