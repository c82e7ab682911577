"""A small world at UTM coordinates: two bumpy horizons, a dipping fault, and the units between."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Scene
from geosurf.arrangement import search_voxels
from geosurf.model import Lattice, TriSurface
from tests.strategies import sheet

BOX = (456000.0, 460000.0, 6780000.0, 6783000.0, -2500.0, -1700.0)


def horizon(name, base, n=20):
    x, y = np.linspace(456000, 460000, n), np.linspace(6780000, 6783000, n)
    u, v = (x - 456000) / 700, (y[:, None] - 6780000) / 600
    z = base + 55 * np.sin(u) * np.cos(v) - 20 * ((y[:, None] - 6781500) / 1500) ** 2
    return TriSurface(name, "horizon", lattice=Lattice(x, y, z))


@pytest.fixture(scope="session")
def top():
    return horizon("Top", -2000.0)


@pytest.fixture(scope="session")
def fault():
    """It dips to the east."""
    (east, west), ends = (457760.0, 457440.0), (6779900, 6783100)
    corners = [(west, y, -1700) for y in ends] + [(east, y, -2500) for y in ends[::-1]]
    return sheet("F1", corners)


@pytest.fixture(scope="session")
def scene(top, fault):
    horizons = {"Top": top, "Base": horizon("Base", -2220.0)}
    every = ["above Top", "Top/Base", "below Base"]
    return Scene(horizons, {"F1": fault}, BOX, reservoir=every)


@pytest.fixture(scope="session")
def curves(scene):
    return scene.curves


@pytest.fixture(scope="session")
def units(scene):
    return scene.units


@pytest.fixture(scope="session")
def search(top, fault):
    return search_voxels(top, fault)
