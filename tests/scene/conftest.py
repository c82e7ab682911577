"""Small surfaces, a scene of them, and a look at its steps."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Scene
from tests.strategies import BOX, grid, sheet


def upright(x, name="F1", **options):
    return sheet(name, [(x, -1, -5), (x, 5, -5), (x, 5, 9), (x, -1, 9)], **options)


def level(z, name="Top"):
    return grid(name, np.full((4, 4), float(z)), spacing=2.0, corner=(-1.0, -1.0))


# a fault across 200 m, and horizons over as many
FAULT = sheet("F1", [(90, -50, -900), (110, 250, -900), (110, 250, 0), (90, -50, 0)])


def waves(level, n=201, phase=0.0):
    x = np.linspace(0.0, 200.0, n)
    return level + 8.0 * np.sin(x / 30 + phase)[:, None] * np.cos(x / 40)


def ran(scene, stage=None, outcome="ran"):
    return [s.subject for s in scene.steps if s.outcome == outcome and stage in (None, s.stage)]


@pytest.fixture
def scene():
    """Two horizons, two faults; F2 ends above Base and stays off Top."""
    low = sheet("F2", [(-1, 2, -5), (5, 2, -5), (5, 2, 2), (-1, 2, 2)])
    return Scene({"Top": level(3), "Base": level(1)}, {"F1": upright(1), "F2": low}, BOX)
