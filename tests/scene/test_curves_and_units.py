"""Curves, units and certificate of a scene."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import (
    Scene,
    TriSurface,
    intersect_surfaces,
)
from tests import laws
from tests.scene.small import level
from tests.strategies import BOX


def test_curves_of_a_surface_with_itself():
    """A roll of four faces that passes through its own first one; `curves` has it if asked to."""
    corners = [(0, -1, 2), (0, 5, 2), (3, -1, 2), (3, 5, 2), (3, -1, 6), (3, 5, 6), (1, -1, 6),
               (1, 5, 6), (1, -1, 0), (1, 5, 0)]  # fmt: skip
    faces = [f for i in range(0, 8, 2) for f in ((i, i + 2, i + 3), (i, i + 3, i + 1))]
    roll = TriSurface("F1", "fault", corners, faces)
    plain = Scene({"Top": level(3)}, {"F1": roll}, BOX)
    mine = plain.curves_between("F1", "F1")
    assert mine.names == ("F1",)
    assert mine.length == 6.0
    assert set(map(tuple, mine.points[:, [0, 2]].tolist())) == {(1.0, 2.0)}
    assert plain.curves_between("F1", "F1") is mine
    assert plain.curves_between("Top", "Top").n_curve == 0
    assert (plain.curves.surfaces_of_curve[:, 0] != plain.curves.surfaces_of_curve[:, 1]).all()
    whole = Scene({"Top": level(3)}, {"F1": roll}, BOX, self_intersections=True)
    once = intersect_surfaces(whole.surfaces, self_intersections=True)
    assert whole.curves.points.tobytes() == once.points.tobytes()
    assert whole.curves.surfaces_of_curve.tolist() == once.surfaces_of_curve.tolist()
    assert [1, 1] in whole.curves.surfaces_of_curve.tolist()


def test_curves_are_those_of_all_surfaces_at_once(scene):
    together = intersect_surfaces(scene.surfaces)
    laws.assert_same_curves(scene.curves, together)
    assert scene.curves.local.tobytes() == together.local.tobytes()
    assert scene.curves.names == ("Top", "Base", "F1", "F2")


def test_units_and_certificate(scene):
    laws.assert_volumes_add_up(scene.units, BOX)
    assert scene.volumes.sum().item() == pytest.approx(192.0, rel=1e-12)
    certificate = scene.check()
    assert certificate.ok, str(certificate)
    assert certificate.checks[-1].name == "two runs give the same bytes"
    # F2 splits what lies below Base, and dies in the zone above
    assert len(scene.units) == 2 + 2 + 4


def test_order_of_faults_and_voxel_size_change_no_volume(scene):
    faults = {name: scene.surface(name) for name in ("F2", "F1")}
    other = Scene({"Top": level(3), "Base": level(1)}, faults, BOX, voxel_size=0.7)
    volumes = sorted(unit.volume for unit in scene.units.values())
    np.testing.assert_allclose(sorted(u.volume for u in other.units.values()), volumes, rtol=1e-14)
