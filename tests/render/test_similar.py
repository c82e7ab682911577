"""Pictures of thinned models look like full ones, and neighbours are told apart by all readers."""

from __future__ import annotations

import runpy
import sys
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

import geosurf as gs
from geosurf.conventions.palette import FAULTS, STRATA, unit_colours
from geosurf.model.protocols import View3D
from geosurf.render import views
from geosurf.render.backend import draw_layers
from geosurf.render.interactive import view_of_units
from geosurf.render.layers import Layer
from tests.render.similar import BLIND, distance, similarity

SIGHTS = (None, *BLIND)


@pytest.fixture(scope="module")
def units():
    """Folded horizons: on planes, thinning would lose nothing."""
    world = gs.synthetic.graben(n=61)
    horizons = {
        name: da + 60.0 * np.sin(da.easting / 300.0) * np.cos(da.northing / 250.0)
        for name, da in world.horizons.items()
    }
    marked = {n: da.assign_attrs(world.horizons[n].attrs) for n, da in horizons.items()}
    return gs.Scene(marked, world.faults, world.box).units


def drawn(view: View3D, direction: str) -> np.ndarray:
    """The content of an interactive view, seen from a direction."""
    layers = []
    for body in view.bodies:
        if body.name.startswith("above Top"):  # it hides the folds
            continue
        # triangles of different surfaces share no points, as the viewer draws them
        points = body.points[body.triangles].reshape(-1, 3)
        rows = np.arange(len(points)).reshape(-1, 3)
        layers.append(Layer(points, rows, colour=body.colour))
        layers.append(Layer(body.points, lines=body.lines, width=1.0))
    camera = views.aim(direction, view.box, (480, 300), view.exaggeration)
    return draw_layers(tuple(layers), camera)


def test_a_thinned_view_looks_like_the_full_one(units):
    """A third of the triangles, as in the report of a field; a tenth is seen to be too few."""
    views_of = {n: view_of_units(units, n) for n in (10**9, 20_000, 7_000)}
    counts = [sum(len(body.triangles) for body in v.bodies) for v in views_of.values()]
    assert counts[0] > 2.5 * counts[1] > 2.5 * counts[2]
    full, thin, coarse = (drawn(view, "southwest") for view in views_of.values())
    assert similarity(full, thin) >= 0.98
    assert similarity(full, coarse) < 0.97


@pytest.mark.parametrize("sight", SIGHTS)
def test_neighbouring_units_are_told_apart(units, sight):
    """Two units that share points differ by twice what is just noticeable, or more."""
    colours = unit_colours((unit.name, unit.zone_index) for unit in units.values())
    corners = {
        unit.name: {tuple(p) for p in np.round(unit.vertices, 3).tolist()}
        for unit in units.values()
    }
    near = [(a, b) for a, b in combinations(units, 2) if len(corners[a] & corners[b]) > 2]
    assert len(near) > 8
    assert min(distance(colours[a], colours[b], sight) for a, b in near) > 8.0


@pytest.mark.parametrize("sight", SIGHTS)
def test_seven_blocks_of_every_zone_are_told_apart(sight):
    """Within a zone, and from the blocks of the zone below."""
    names = [(f"{zone} {block}", zone) for zone in range(len(STRATA)) for block in range(7)]
    of_zone = np.reshape(list(unit_colours(names).values()), (len(STRATA), 7, 3))
    for mine, below in zip(of_zone, np.roll(of_zone, -1, axis=0), strict=True):
        assert min(distance(a, b, sight) for a, b in combinations(mine, 2)) > 8.0
        assert min(distance(a, b, sight) for a in mine for b in below) > 8.0
    assert len(set(unit_colours((str(i), 0) for i in range(30)).values())) == 30


@pytest.mark.parametrize("sight", SIGHTS)
def test_zones_in_the_column_and_faults_are_told_apart(sight):
    ring = zip(STRATA, (*STRATA[1:], STRATA[0]), strict=True)
    assert min(distance(a, b, sight) for a, b in ring) > 15.0
    assert min(distance(a, b, sight) for a, b in combinations(STRATA, 2)) > 9.0
    assert min(distance(a, b, sight) for a, b in combinations(FAULTS, 2)) > 20.0


# ---- Pictures of the documentation, drawn again: they are what geosurf draws today.
ROOT = Path(__file__).resolve().parents[2]
BLOCK, STEP = 4, 30.0  # letters may move by a pixel; 0 to 255 of a colour
PICTURES = {"exploded": "demo", "section": "section", "allan": "allan_F1"}


def changed(one: np.ndarray, other: np.ndarray) -> float:
    """Share of the blocks of pixels whose mean colour differs."""
    assert one.shape == other.shape
    high, wide = (n - n % BLOCK for n in one.shape[:2])
    blocks = [
        image[:high, :wide].reshape(high // BLOCK, BLOCK, wide // BLOCK, BLOCK, 3).mean((1, 3))
        for image in (one.astype(float), other.astype(float))
    ]
    return float((np.abs(blocks[0] - blocks[1]).max(axis=2) > STEP).mean())


@pytest.fixture
def drawn_again(tmp_path, monkeypatch):
    """Run a script of the gallery, and return its picture and the one of the documentation."""
    (tmp_path / "docs" / "pictures").mkdir(parents=True)
    (tmp_path / "data").symlink_to(ROOT / "data")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "gallery"))

    def draw(script, picture):
        runpy.run_path(str(ROOT / "docs" / "gallery" / f"{script}.py"))
        files = (folder / "docs" / "pictures" / f"{picture}.png" for folder in (tmp_path, ROOT))
        return [255.0 * imread(file)[:, :, :3] for file in files]

    yield draw
    sys.modules.pop("field", None)


@pytest.mark.long
def test_the_gallery_shows_what_is_drawn_today(drawn_again):
    """`make gallery` draws them again, after a change that was meant."""
    shares = {name: changed(*drawn_again(name, picture)) for name, picture in PICTURES.items()}
    assert max(shares.values()) < 0.004, shares


def test_a_picture_with_another_shade_or_another_line_is_found():
    white = np.full((600, 960, 3), 255)
    shade, line = white.copy(), white.copy()
    shade[100:150, 100:160] -= 40
    line[300:304, 100:900] = 0
    assert changed(white, white) == 0.0
    assert min(changed(white, shade), changed(white, line)) > 0.004
