"""Sealed models of small worlds, and what has to come back of them from a file."""

from __future__ import annotations

import pytest

import geosurf as gs
from tests import laws

LABELS = ("name", "zone", "zone_index", "block", "contact", "beneath", "fault_sides", "bounded_by")


def carve(surfaces):
    return gs.carve_units(gs.rebuild_surfaces(surfaces))


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
