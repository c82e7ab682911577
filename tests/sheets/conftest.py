"""Truth worlds, torn once for all tests, and how to compare cut-offs with the truth."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import geosurf as gs


@pytest.fixture(scope="session")
def torn_world():
    """Function of a kind of world: (world, sheet); grids, or points where sheets overlap."""

    @cache
    def make(kind: str, points: bool = False, **options):
        chosen = dict(options)
        trim = chosen.pop("trim", 2.25)
        world = gs.synthetic.torn(kind, **chosen)
        data = world.truth["points"] if points else world.horizons["Top"]
        return world, gs.tear_horizon(data, world.faults, name="Top", trim=trim)

    return make


@pytest.fixture(scope="session")
def distances():
    """Function of points (n, 3) and lines: distance of each point to the lines in the map [m]."""

    def measure(points: np.ndarray, lines) -> np.ndarray:
        best = np.full(len(points), np.inf)
        for line in lines:
            for a, b in zip(line[:-1, :2], line[1:, :2], strict=True):
                t = b - a
                length = max(float(t @ t), 1e-30)
                f = np.clip((points[:, :2] - a) @ t / length, 0.0, 1.0)
                best = np.minimum(best, np.hypot(*(points[:, :2] - a - f[:, None] * t).T))
        return best

    return measure
