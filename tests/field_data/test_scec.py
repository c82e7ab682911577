"""Eleven measured faults that cross, branch and touch (SCEC Community Fault Model)."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import geosurf as gs
from geosurf.carve.certificate import certify


@pytest.fixture(scope="module")
def faults(data):
    return [gs.read_fault(path) for path in sorted((data / "scec_cfm7").glob("*.ts"))]


@pytest.fixture(scope="module")
def curves(faults):
    return gs.intersect_surfaces(faults)


def test_curves_of_all_pairs_are_the_exact_ones(faults, curves, verify, near, pieces):
    in_contact = 0
    for i, j in itertools.combinations(range(len(faults)), 2):
        meshes = near(faults[i], faults[j]), near(faults[j], faults[i])
        exact = verify.exact_curve_segments(*meshes)
        mine = (curves.surfaces_of_curve == (i, j)).all(axis=1)
        lines = [curves.points[curve] for curve, m in zip(curves.curves, mine, strict=True) if m]
        touching = [c for c in curves.contacts if c.surfaces == (i, j) and c.kind == "point"]
        assert len(touching) == len(exact.isolated)
        assert bool(lines) == (len(exact.edges) > 0)
        if not lines:
            continue
        in_contact += 1
        points, segments = verify.polylines_to_graph(lines)
        report = verify.check_curve(*meshes, points, segments, 1e-8, exact=exact)
        assert abs(report.reported_length / report.exact_length - 1) < 1e-9
        _, number = np.unique(points, axis=0, return_inverse=True)
        assert pieces(number.ravel()[segments]) == pieces(exact.edges)
    assert in_contact == 25


def test_rebuilt_faults_share_all_their_curves(faults, verify):
    patches = gs.rebuild_surfaces(faults, self_intersections=True)
    certificate = certify(patches)
    assert certificate.ok, str(certificate)
    distinct = np.unique(np.sort(patches.triangles, axis=1), axis=0)
    assert len(verify.nonconforming_pairs((patches.local, distinct))) == 0


def test_one_fault_crosses_itself_and_only_a_search_inside_it_mends_that(faults):
    alone = [s for s in faults if gs.intersect_surfaces([s], self_intersections=True).n_curve]
    assert [s.name.split("-")[3] for s in alone] == ["North_Channel_fault_east"]
    line = certify(gs.rebuild_surfaces(alone)).checks[0]
    assert not line.passed
    assert "North_Channel" in line.detail
    assert certify(gs.rebuild_surfaces(alone, self_intersections=True)).ok
