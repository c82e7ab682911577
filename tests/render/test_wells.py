"""Wells on maps and sections: which tops are drawn, where, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.render.overlay import NEAR, tops_on_map, tops_on_section


@pytest.fixture(scope="module")
def model():
    """A scene and the misfits of its tops: two wells on the middle line, one far off."""
    world = gs.synthetic.graben(n=9)
    scene = gs.Scene(world.horizons, world.faults, world.box)
    rows = [
        (well, horizon, east, north, -2100.0)
        for well, east, north in (("25/4-1", 900.0, 1500.0), ("B", 2000.0, 1530.0), ("C", 900, 9))
        for horizon in ("Top", "Base")
    ]  # fmt: skip
    names = ("well", "horizon", "easting", "northing", "elevation")
    tops = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    return scene.replace(tops=tops)


def test_a_map_has_the_tops_of_its_horizon(model):
    shown = tops_on_map(model.misfit(), "Base")
    assert [(top.well, top.horizon) for top in shown] == [
        ("25/4-1", "Base"), ("B", "Base"), ("C", "Base"),
    ]  # fmt: skip
    assert shown[1].place.tolist() == [2000.0, 1530.0]


def test_a_section_has_the_tops_near_it_by_distance_along_it(model):
    bent = np.array([[0.0, 1500.0], [1500.0, 1500.0], [1500.0, 2500.0], [4000.0, 2500.0]])
    shown, near = tops_on_section(model.misfit(), bent)
    assert near == pytest.approx(NEAR * 5000.0)
    assert [(top.well, top.place.tolist()) for top in shown] == [
        ("25/4-1", [900.0, -2100.0]), ("25/4-1", [900.0, -2100.0]),
    ]  # fmt: skip
    straight = np.array([[100.0, 1500.0], [4000.0, 1500.0]])
    shown, _ = tops_on_section(model.misfit(), straight)
    assert [top.well for top in shown] == ["25/4-1"] * 2 + ["B"] * 2
    assert [top.place[0] for top in shown] == [800.0, 800.0, 1900.0, 1900.0]
