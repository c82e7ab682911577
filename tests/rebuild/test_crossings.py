"""Pieces that no rounding turned over may cross each other all the same: found, and repaired.

What is moved for it is never the model box, nor off it.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from benchmarks.stress.families import make_case
from geosurf import build_walls, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.errors import RoundingError
from geosurf.rebuild import repair
from tests import laws, oracles
from tests.carve.plane_worlds import plane_world
from tests.rebuild.crossings import FAMILIES, check
from tests.strategies import soup

# of thousands of cases of `make stress`, those in which nothing but a crossing was wrong
FOUND = [("near-degenerate", number) for number in (29, 65, 251, 435, 997)]
FOUND += [("triple lines", 188)]


def assert_conforming(patches):
    """Any two triangles meet in the corners and edges that they share, in rational numbers."""
    corners = np.unique(np.sort(patches.triangles, axis=1), axis=0)
    x = patches.local[corners]
    exact = [oracles.rational(triangle) for triangle in x]
    low, high = x.min(axis=1), x.max(axis=1)
    asked = 0
    for i, j in itertools.combinations(range(len(x)), 2):
        if (low[i] > high[j]).any() or (low[j] > high[i]).any():
            continue
        shared = set(exact[i]) & set(exact[j])
        assert set(oracles.meet_triangles(exact[i], exact[j])) <= shared, (i, j)
        asked += 1
    assert asked > 10


@pytest.mark.parametrize(("family", "number"), FOUND)
def test_crossings_after_rounding_are_repaired(family, number, monkeypatch):
    found = []

    def watched(*arguments):
        found.append(len(crossing(*arguments)))
        return crossing(*arguments)

    crossing = repair.crossing_faces
    monkeypatch.setattr(repair, "crossing_faces", watched)
    case = make_case(family, number, 7)
    patches = rebuild_surfaces(case.surfaces, self_intersections=case.self_intersections)
    assert found[0] > 0
    assert found[-1] == 0
    assert patches.report["moved_vertices"] > 0
    assert 0 < patches.report["largest_move"] < 1e-4
    assert_conforming(patches)
    assert certify(patches).ok
    laws.assert_shares_vertices(patches)


def test_children_at_moved_vertices_are_compared_however_thick_they_are():
    """A corner is off a plane by the step of the grid: a child that is 1e-7 m thick feels it."""
    assert check("degenerate", 2336) == ["turned"]


@pytest.mark.parametrize("number", [0, 3, 4, 17])
def test_what_lies_on_the_box_stays_on_it_when_inputs_are_moved(number):
    """The walls pass through the outermost vertices, which rounding to a step would take off."""
    case = make_case("near-degenerate", number, 7)
    places = np.concatenate([surface.vertices for surface in case.surfaces])
    low, high = places.min(axis=0), places.max(axis=0)
    box = (low[0], high[0], low[1], high[1], low[2] - 1.0, high[2] + 1.0)
    walls = build_walls(box)
    patches = rebuild_surfaces([*case.surfaces, *walls], self_intersections=case.self_intersections)
    assert patches.report["moved_vertices"] > 0
    stay = 0
    for given, used in zip([*case.surfaces, *walls], patches.sources, strict=True):
        x, y = given.vertices, used.vertices
        on_box = np.isin(x[:, :2], box[:4])
        assert (x[:, :2] == y[:, :2])[on_box].all()
        stay += on_box.any(axis=1).sum() if given.role != "wall" else 0
        assert (x == y).all() or given.role != "wall"
    assert stay >= 2
    assert certify(patches).ok


def test_distinct_points_that_round_to_one_place_are_one_vertex():
    """Two pairs of triangles on either side of a slab 5e-19 m wide: each pair ends in it, the one
    at a third of (1, 1, 1), the other 3e-19 m from there, and no triangle has both points.
    """
    d = 2.0**-60
    pairs = [
        ("F", [(1, 0, 0), (0, 0.5, 0.5), (0, 0, 0)]),
        ("H", [(0, 1, 0), (0.5, 0, 0.5), (-1, 0, -1)]),
        ("G", [(1, d, 0), (d, 0.5, 0.5), (2, 1, 1)]),
        ("I", [(0, 1, d), (0.5, d, 0.5), (1, 2, 1)]),
    ]
    surfaces = [soup(name, [corners]) for name, corners in pairs]
    for order in (surfaces, surfaces[::-1], [surfaces[k] for k in (2, 0, 3, 1)]):
        patches = rebuild_surfaces(order)
        assert patches.report["rounding_collisions"] == 1
        assert patches.report["moved_vertices"] == 0
        laws.assert_shares_vertices(patches)
        (third,) = np.flatnonzero((patches.local == 1 / 3).all(axis=1))
        of = patches.surface_of_triangle[(patches.triangles == third).any(axis=1)]
        assert set(of.tolist()) == {0, 1, 2, 3}
        assert_conforming(patches)
        assert certify(patches).ok


# ---- No crossing that rounding makes is missed by the shortlist, and none is left after the r
@pytest.mark.parametrize("family", list(FAMILIES))
def test_nothing_is_missed_and_nothing_is_left(family):
    for seed in range(10):
        assert not {"missed", "left", "refused"} & set(check(family, seed)), seed


def test_a_line_that_moves_along_itself_is_moved_again(monkeypatch):
    """The diagonal of a fault passes by an edge of the box, and still does after the first draw."""
    world = plane_world(3396)
    given = [*world.surfaces, *build_walls(world.box)]
    assert rebuild_surfaces(given).report["largest_move"] < 1e-4
    monkeypatch.setattr(repair, "DRAWS", 1)
    with pytest.raises(RoundingError, match="float64 cannot represent"):
        rebuild_surfaces(given)
