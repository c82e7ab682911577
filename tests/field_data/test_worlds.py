"""The independent checker on every synthetic world: curves, split, closure, partition."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import geosurf as gs
from geosurf.carve.certificate import certify
from tests.field_data.conftest import near, pieces

WORLDS = ("tilted_planes", "graben", "listric", "dome_and_flat_fault", "egg_box", "noisy")
UTM = (456000.0, 6.78e6, 0.0)


def scene_of(name, offset):
    world = getattr(gs.synthetic, name)(n=17, offset=offset)
    return gs.Scene(world.horizons, world.faults, world.box)


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), UTM], ids=["local", "utm"])
@pytest.mark.parametrize("name", WORLDS)
def test_the_exact_checker_accepts(verify, name, offset):
    scene = scene_of(name, offset)
    surfaces = scene.surfaces
    n_curve = 0
    for i, a in enumerate(surfaces):
        for b in surfaces[i + 1 :]:
            curves = scene.curves_between(a.name, b.name)
            if curves is not None:
                n_curve += curves.n_curve
                meshes = (a.vertices, a.triangles), (b.vertices, b.triangles)
                verify.check_curve(*meshes, curves.points, curves.segments, 1e-7)
    assert n_curve == scene.curves.n_curve > 0
    patches = scene.patches
    for i, source in enumerate(patches.sources):
        mine = patches.surface_of_triangle == i
        verify.check_split(
            source.vertices - patches.origin, source.triangles, patches.local,
            patches.triangles[mine], patches.parent_of_triangle[mine], 1e-7, weld=False,
        )  # fmt: skip
    for unit in scene.units.values():
        report = verify.check_closed(unit.local, unit.triangles)
        assert report.volume == pytest.approx(unit.volume, rel=1e-12)
    low, high = (np.array(scene.box[k::2]) - patches.origin for k in (0, 1))
    verify.check_partition(
        [(unit.local, unit.triangles) for unit in scene.units.values()], (low, high),
        rtol=1e-12, samples=100, require_matching=True,
    )  # fmt: skip


# ---- Eleven measured faults that cross, branch and touch (SCEC Community Fault Model).
@pytest.fixture(scope="module")
def faults(data):
    return [gs.read_fault(path) for path in sorted((data / "scec_cfm7").glob("*.ts"))]


@pytest.fixture(scope="module")
def curves(faults):
    return gs.intersect_surfaces(faults)


def test_curves_of_all_pairs_are_the_exact_ones(faults, curves, verify):
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
    assert certify(patches).ok
    distinct = np.unique(np.sort(patches.triangles, axis=1), axis=0)
    assert len(verify.nonconforming_pairs((patches.local, distinct))) == 0


def test_one_fault_crosses_itself_and_only_a_search_inside_it_mends_that(faults):
    alone = [s for s in faults if gs.intersect_surfaces([s], self_intersections=True).n_curve]
    assert [s.name.split("-")[3] for s in alone] == ["North_Channel_fault_east"]
    line = certify(gs.rebuild_surfaces(alone)).checks[0]
    assert not line.passed
    assert "North_Channel" in line.detail
    assert certify(gs.rebuild_surfaces(alone, self_intersections=True)).ok
