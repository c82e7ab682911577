"""Models with zones of no thickness, one unit, slivers and coinciding contacts can be measured."""

from __future__ import annotations

from functools import cache

import pytest

from geosurf.render.compose import plotted
from geosurf.render.section import draw_section
from tests.measure.thin_worlds import WORLDS, foreign, lines_of, measures

# of a world whose fault is left out; its warning has a test of its own
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
PINCHED = [name for name in WORLDS if "pinched" in name or "crossing" in name]


@cache
def scene_of(world):
    return WORLDS[world]()


@pytest.mark.parametrize("world", WORLDS)
def test_every_measure_is_a_result_or_an_error_of_geosurf(world):
    assert foreign(measures(scene_of(world))) == []


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
