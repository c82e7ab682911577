"""The independent checker on every synthetic world: curves, split, closure, partition."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs

WORLDS = ("tilted_planes", "graben", "listric", "dome_and_flat_fault", "egg_box", "noisy")
UTM = (456000.0, 6.78e6, 0.0)


def scene_of(name, offset=(0.0, 0.0, 0.0), turned=False):
    world = getattr(gs.synthetic, name)(n=17, offset=offset)
    faults = dict(reversed(list(world.faults.items()))) if turned else world.faults
    return gs.Scene(world.horizons, faults, world.box)


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
