"""Small surfaces and a look at the steps of a scene."""

from __future__ import annotations

import numpy as np

from tests.strategies import grid, sheet


def upright(x, name="F1", **options):
    return sheet(name, [(x, -1, -5), (x, 5, -5), (x, 5, 9), (x, -1, 9)], **options)


def level(z, name="Top"):
    return grid(name, np.full((4, 4), float(z)), spacing=2.0, corner=(-1.0, -1.0))


def ran(scene, stage=None, outcome="ran"):
    return [s.subject for s in scene.steps if s.outcome == outcome and stage in (None, s.stage)]
