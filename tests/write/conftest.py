"""Sealed models, carved once for all tests."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from tests.strategies import BOX, grid, sheet
from tests.write.sealed import carve


@pytest.fixture(scope="session")
def graben():
    """Units of a graben with a contact, in a reference system."""
    world = gs.synthetic.graben(n=7)
    given = (world.horizons, world.faults, world.box)
    return gs.Scene(*given, contacts={"OWC": -2100.0}, crs="EPSG:32631").units


@pytest.fixture(scope="session")
def slit():
    """A fault that ends inside all units, and one that touches nothing but that fault."""
    level = [grid(f"H{k}", np.full((7, 7), -2.0 * k), corner=(-1, -1)) for k in range(2)]
    f1 = sheet("F1", [(2, -1, -5), (2, 2, -5), (2, 2, 9), (2, -1, 9)])
    f2 = sheet("F2", [(1, 1, 1), (3, 1, 1), (3, 1, 2), (1, 1, 2)])
    return carve([*level, f1, f2, *gs.build_walls(BOX)])
