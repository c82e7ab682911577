"""Stored pictures: another look draws those again that it changes, with the bytes of all others."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf.scene import stored_pictures
from geosurf.scene.result_cache import ResultCache

pytest.importorskip("pyvista")

LINE, OTHER = ([(0.0, 500.0), (4000.0, 500.0)], [(0.0, 900.0), (4000.0, 500.0)])
BASE = {"views": ["top"], "sections": [LINE], "size": (200, 150)}
OVERLAY = gs.PictureOverlay(points={"Top": np.array([[900.0, 600.0, -1000.0]])})
VIEWS, FLAT = {"view_top", "units_exploded"}, {"map", "isochore", "allan", "throw", "section"}
LOOKS = {
    "the same": ({}, set()),
    "colour of a fault": ({"style": {"colours": {"F1": "teal"}}}, {"view_top", "map", "section"}),
    "colour of a zone": (
        {"style": {"colours": {"Top/Base": "teal"}}},
        {"units_exploded", "section", "allan"},
    ),
    "colour of nothing": ({"style": {"colours": {"F9": "teal"}}}, set()),
    "block, camera": (
        {"colour_by": "block", "camera": (200.0, 40.0), "zoom": 1.5},
        {"units_exploded", "view_camera"},
    ),
    "some units, exaggeration": ({"only": ["Top/Base"], "exaggeration": 3.0}, VIEWS),
    "no clip": ({"clip": False}, {"view_top", "map"}),
    "other line": ({"sections": [OTHER]}, {"section"}),
    "points on top": ({"overlay": OVERLAY}, {"view_top", "map", "section"}),
    "theme": ({"style": {"theme": "dark"}}, VIEWS | FLAT),
}


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.tilted_planes(n=5)
    return gs.Scene(world.horizons, world.faults, world.box)


def pictures(folder: Path) -> dict[str, bytes]:
    return {path.stem: path.read_bytes() for path in (folder / "pictures").iterdir()}


@pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")
def test_a_look_draws_what_it_changes(scene, tmp_path, monkeypatch):
    drawn: set[str] = set()
    inner = stored_pictures.pictures_of

    def noted(*args, **choice):
        """The pictures; each notes that it is drawn."""

        def draw(path, one):
            drawn.add(path.stem)
            return one.draw(path)

        return [
            dataclasses.replace(one, draw=lambda path, one=one: draw(path, one))
            for one in inner(*args, **choice)
        ]

    monkeypatch.setattr(stored_pictures, "pictures_of", noted)
    cache = ResultCache(tmp_path / "cache")

    def stored(choice: dict, name: str) -> dict[str, bytes]:
        """Pictures with the cache."""
        drawn.clear()
        stored_pictures.draw_with_cache(scene, tmp_path / name, lambda _: None, choice, cache)
        return pictures(tmp_path / name)

    base = stored(BASE, "base")
    assert {name.split("_0")[0] for name in drawn} == VIEWS | FLAT
    for look, (change, expected) in LOOKS.items():
        choice = {**BASE, **change}
        if "style" in change:
            choice["style"] = gs.PictureStyle(**change["style"])
        found = stored(choice, look)
        assert {name.split("_0")[0] for name in drawn} == expected, look
        plain = base  # compared by the other looks
        if expected:
            scene.render_pictures(tmp_path / f"{look}, plain", **choice)
            plain = pictures(tmp_path / f"{look}, plain")
        assert found == plain, look
