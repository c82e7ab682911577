"""Surfaces that coincide with themselves and each other: exact arithmetic, and known shapes."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from geosurf import build_walls, intersect_surfaces, rebuild_surfaces
from tests import laws
from tests.arrangement import self_overlap
from tests.messages import refused
from tests.overlaps import Together, together
from tests.strategies import soup

FIRST = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)]
SECOND = [(2, -1, 0), (6, -1, 0), (6, 5, 0), (2, 5, 0)]
WALL = [(1, 2, -1), (5, 2, -1), (5, 2, 1), (1, 2, 1)]
BENT = [(1, 2, 0), (5, 2, 0), (5, 2, 1), (1, 2, 1)]  # ends on the squares
FLAP = [(1, 2, 0), (5, 2, 0), (5, 3, 1), (1, 3, 1)]  # ends there, leaning
TIP = [(3, 2, 0), (4, 2, 1), (3, 3, 1), (2.5, 2, 1)]  # touches in a point


def quads(name, *of):
    """A surface of quads in two triangles each."""
    return soup(name, [[q[0], q[i], q[i + 1]] for q in of for i in (1, 2)])


def assert_exact(surfaces):
    """Curves, touching points, areas and pieces are those of exact arithmetic."""
    pairs = itertools.combinations_with_replacement(range(len(surfaces)), 2)
    truth = {pair: together(surfaces, *pair) for pair in pairs}
    curves = intersect_surfaces(surfaces, self_intersections=True)
    self_overlap.assert_curves(surfaces, curves, truth)
    for itself in (True, False):
        patches = rebuild_surfaces(surfaces, self_intersections=itself)
        self_overlap.assert_patches(surfaces, patches, truth, itself)
    return curves, truth


def body(name, scale=1.0):
    """The walls of a box as one closed surface."""
    walls = build_walls((0, scale, 0, scale, 0, scale))
    return soup(name, np.concatenate([w.vertices[w.triangles] for w in walls]))


@pytest.mark.parametrize("seed", range(14))
def test_soups_that_overlap(seed):
    self_overlap.check(seed)


@pytest.mark.parametrize("third", [WALL, BENT, FLAP, TIP])
def test_a_third_sheet_at_an_area(third):
    """As a part of one surface, of the other one, of a third one, and all in one surface."""
    for parts in (
        [(FIRST, SECOND, third)],
        [(FIRST, third), (SECOND,)],
        [(FIRST,), (SECOND, third)],
        [(FIRST,), (SECOND,), (third,)],
        [(FIRST, third), (SECOND, third)],
    ):
        assert_exact([quads(n, *part) for n, part in zip("ABC", parts, strict=False)])


@pytest.mark.parametrize("weld", [False, True])
def test_closed_bodies_that_coincide_have_an_area_and_no_curve(weld):
    one, two = body("A"), body("B")
    if weld:
        one, two = (self_overlap.surface(s.name, s.vertices[s.triangles], True) for s in (one, two))
    for surfaces in ([one, two], [one, two, two.renamed("C", "fault")]):
        curves = intersect_surfaces(surfaces)
        assert curves.n_curve == 0
        assert [(c.kind, c.area) for c in curves.contacts] == [("area", 6.0)] * len(curves.contacts)
        pairs = itertools.combinations(range(len(surfaces)), 2)
        assert [c.surfaces for c in curves.contacts] == list(pairs)
        assert all(len(c.points) >= 8 for c in curves.contacts)  # its corners, for want of a rim
    assert_exact([one, two])


def test_a_surface_that_crosses_itself_shares_its_vertices_with_others():
    """Where floor and wall of A cross each other on B, all three meet in one vertex."""
    across = [(3, 0, -1), (3, 4, -1), (3, 4, 1), (3, 0, 1)]
    assert_exact([quads("A", FIRST, WALL), quads("B", across)])
    # where they cross away from B, A is left as it is
    beside = quads("B", [(9, 0, 0), (9, 4, 0), (9, 4, 1), (9, 0, 1)])
    patches = rebuild_surfaces([quads("A", FIRST, WALL), beside])
    assert patches.report["cut_triangles"] == 0


def test_what_is_wrong_is_seen():
    surfaces = [quads("A", FIRST, WALL), quads("B", SECOND)]
    assert_exact(surfaces[::-1])
    curves, truth = assert_exact(surfaces)
    mine = (curves.surfaces_of_segment == (0, 1)).all(axis=1)
    ends, parts = curves.points[curves.segments[mine]], truth[0, 1].curves
    self_overlap.assert_lines("A and B", ends, parts)
    for wrong, words in ((ends[1:], "on 0 curves"), (ends[[0, *range(len(ends))]], "on 2 curves")):
        refused(AssertionError, words, self_overlap.assert_lines, "A and B", wrong, parts)
    with pytest.raises(AssertionError, match="no curve at"):
        self_overlap.assert_lines("A and B", np.concatenate([ends, ends[:1] + 9]), parts)
    fewer = replace(curves, contacts=())
    refused(AssertionError, r"0 m2, not 8\.0", self_overlap.assert_curves, surfaces, fewer, truth)


def test_the_oracle_knows_simple_shapes():
    flat = [((0, 0, 0), (4, 0, 0), (0, 4, 0))]
    assert Together(flat, flat).area == 8.0
    assert len(Together(flat, flat).curves) == 3
    assert Together(flat, flat).points == []
    assert Together(flat + flat).area == 8.0  # with itself: twice there
    spike = [((1, 1, 0), (1, 1, 1), (2, 2, 1))]
    assert Together(flat, spike).points == [(1, 1, 0)]
    assert Together(flat, flat + spike).points == [(1, 1, 0)]
    corner = [((0, 0, 0), (4, 0, 0), (0, 0, 4))]  # one edge in common with the first
    assert len(Together(flat + corner, flat + corner).curves) == 4  # the outline, not the fold
    beyond = [((0, 0, 0), (4, 0, 0), (0, -4, 0))]
    three = flat + corner + beyond
    assert len(Together(three, three).curves) == 7  # three sheets from one edge: areas branch


@pytest.mark.parametrize("at", [(1, 1, 1), (456_000, 6_780_000, -2_000)])
@pytest.mark.parametrize("n", [3, 4, 6])
def test_planes_through_a_point_share_one_vertex_there(n, at, rng):
    """All curves pass through it, and each is the same without the other surfaces."""
    sheets = []
    for name in "ABCDEF"[:n]:
        one, two = rng.integers(-4, 5, (2, 3))
        one[len(sheets) % 3] += 9
        two[(len(sheets) + 1) % 3] += 9
        sheets.append(quads(name, [np.add(at, p) for p in (one, two, -one, -two)]))
    curves, patches = intersect_surfaces(sheets), rebuild_surfaces(sheets)
    (vertex,) = np.flatnonzero((patches.vertices == at).all(axis=1))
    around = (patches.triangles == vertex).any(axis=1)
    assert {*patches.surface_of_triangle[around].tolist()} == set(range(n))
    ends = {tuple(sorted(e)) for e in patches.curve_edges.tolist() if vertex in e}
    assert len(ends) == n * (n - 1)  # two ways along each curve
    for i, j in itertools.combinations(range(n), 2):
        mine = (curves.surfaces_of_segment == (i, j)).all(axis=1)
        lines = curves.points[curves.segments[mine]]
        assert self_overlap.on_segments(np.array([at]), lines).any()
        assert intersect_surfaces([sheets[i], sheets[j]]).length == pytest.approx(
            laws.length_of(curves.points, curves.segments[mine]), rel=1e-9
        )
