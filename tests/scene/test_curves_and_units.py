"""Curves, units and certificate of a scene."""

from __future__ import annotations

import pytest

from geosurf import intersect_surfaces
from tests import laws
from tests.strategies import BOX


def test_curves_are_those_of_all_surfaces_at_once(scene):
    together = intersect_surfaces(scene.surfaces)
    laws.assert_same_curves(scene.curves, together)
    assert scene.curves.local.tobytes() == together.local.tobytes()
    assert scene.curves.names == ("Top", "Base", "F1", "F2")


def test_units_and_certificate(scene):
    laws.assert_volumes_add_up(scene.units, BOX)
    assert scene.table("all").volume.sum().item() == pytest.approx(192.0, rel=1e-12)
    certificate = scene.check()
    assert certificate.ok, str(certificate)
    assert certificate.checks[-1].name == "two runs give the same bytes"
    # F2 splits what lies below Base, and dies in the zone above
    assert len(scene.units) == 2 + 2 + 4
