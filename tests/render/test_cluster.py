"""Points that become one: planes keep their volume, meeting lines stay, the budget is kept."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.render.cluster import clustered
from geosurf.render.interactive import view_of_units
from geosurf.render.thin_units import shells_to_draw
from geosurf.render.unit_layers import outline


def volume(shell) -> float:
    a, b, c = ((shell.points - shell.points[0])[shell.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6.0)


@pytest.fixture(scope="module")
def units():
    world = gs.synthetic.tilted_planes(n=31)
    return gs.Scene(world.horizons, world.faults, world.box).units


@pytest.mark.parametrize("share", [0.7, 0.4])
def test_planes_keep_volume_and_outline_with_fewer_triangles(units, share):
    whole = shells_to_draw(units, 10**9)
    n = sum(len(shell.triangles) for shell in whole)
    few = clustered(whole, int(share * n))
    assert sum(len(shell.triangles) for shell in few) <= share * n
    for one, other in zip(whole, few, strict=True):
        # points of a plane stay in it, and its rim stays where it is: so does the volume
        assert volume(other) == pytest.approx(volume(one), rel=1e-9)
        ends = [
            {tuple(p) for p in np.round(s.points[outline(s, creases=False)].reshape(-1, 3), 6)}
            for s in (one, other)
        ]
        assert ends[0] == ends[1]
        assert len(np.unique(other.triangles)) == len(other.points)


def test_few_enough_triangles_are_returned_as_they_are(units):
    whole = shells_to_draw(units, 10**9)
    assert clustered(whole, 10**9) is whole
    assert clustered([], 5) == []


def test_units_that_share_a_surface_go_on_sharing_its_points(units):
    bodies = view_of_units(units, 900).bodies
    points = [{tuple(p) for p in body.points.tolist()} for body in bodies]
    for mine, body in zip(points, bodies, strict=True):
        others = set.union(*(p for p in points if p is not mine))
        inside = body.points[(np.array(units.box[1::2]) > body.points).all(axis=1)]
        inside = inside[(np.array(units.box[::2]) < inside).all(axis=1)]
        assert len(inside) > 5
        assert {tuple(p) for p in inside.tolist()} <= others
