"""A small scene for the tests of this folder."""

from __future__ import annotations

import pytest

from geosurf import Scene
from tests.scene.small import level, upright
from tests.strategies import BOX, sheet


@pytest.fixture
def scene():
    """Two horizons, two faults; F2 ends above Base and stays off Top."""
    low = sheet("F2", [(-1, 2, -5), (5, 2, -5), (5, 2, 2), (-1, 2, 2)])
    return Scene({"Top": level(3), "Base": level(1)}, {"F1": upright(1), "F2": low}, BOX)
