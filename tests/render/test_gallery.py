"""Pictures of the documentation, drawn again: they are what geosurf draws today."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

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
def drawn(tmp_path, monkeypatch):
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


def test_the_gallery_shows_what_is_drawn_today(drawn):
    """`make gallery` draws them again, after a change that was meant."""
    shares = {name: changed(*drawn(name, picture)) for name, picture in PICTURES.items()}
    assert max(shares.values()) < 0.004, shares


def test_a_picture_with_another_shade_or_another_line_is_found():
    white = np.full((600, 960, 3), 255)
    shade, line = white.copy(), white.copy()
    shade[100:150, 100:160] -= 40
    line[300:304, 100:900] = 0
    assert changed(white, white) == 0.0
    assert min(changed(white, shade), changed(white, line)) > 0.004
