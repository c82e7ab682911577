"""Sealed models of small worlds, and what has to come back of them from a file."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from tests import laws
from tests.strategies import BOX, grid, sheet

LABELS = ("name", "zone", "zone_index", "block", "contact", "beneath", "fault_sides", "bounded_by")


def carve(surfaces):
    return gs.carve_units(gs.rebuild_surfaces(surfaces))


def slit():
    """A fault that ends inside all units, and one that touches nothing but that fault."""
    level = [grid(f"H{k}", np.full((7, 7), -2.0 * k), corner=(-1, -1)) for k in range(2)]
    f1 = sheet("F1", [(2, -1, -5), (2, 2, -5), (2, 2, 9), (2, -1, 9)])
    f2 = sheet("F2", [(1, 1, 1), (3, 1, 1), (3, 1, 2), (1, 1, 2)])
    return carve([*level, f1, f2, *gs.build_walls(BOX)])


def assert_equal(back, units):
    assert list(back) == list(units)
    assert back.box == units.box
    for new, old in zip(back.values(), units.values(), strict=True):
        assert [getattr(new, key) for key in LABELS] == [getattr(old, key) for key in LABELS]
        assert new.volume == pytest.approx(old.volume, rel=1e-13)
        assert new.area == pytest.approx(old.area, rel=1e-13)
        laws.assert_closed(new.triangles)
        assert set(map(tuple, new.vertices.tolist())) == set(map(tuple, old.vertices.tolist()))
    assert back.volume == pytest.approx(back.box_volume, rel=1e-13)
