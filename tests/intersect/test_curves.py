"""Curves of surfaces: against all pairs in rational arithmetic, and against known shapes."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf import TriSurface, intersect_surfaces, rebuild_surfaces
from geosurf.errors import InputError, SurfaceError
from geosurf.intersect.link import shared_curves
from tests import laws, oracles
from tests.messages import refused
from tests.strategies import grid, relief, sheet, shuffled, soup, soups

LEVEL = [(-1, -1, 1), (9, -1, 1), (9, 9, 1), (-1, 9, 1)]


def mesh(surface):
    return surface.vertices, surface.triangles


def assert_true(one, two, **options):
    """Segments, touching points and overlap area are those of the oracle, rounded once."""
    curves = intersect_surfaces([one, two], **options)
    segments, single, overlap = oracles.curves(mesh(one), mesh(two))
    found = Counter(frozenset(map(tuple, ends)) for ends in curves.points[curves.segments].tolist())
    if not overlap:
        assert found == Counter(frozenset(map(oracles.rounded, s)) for s in segments)
    points = {tuple(c.points[0]) for c in curves.contacts if c.kind == "point"}
    if not overlap:
        assert points == {oracles.rounded(p) for p in single}
    assert math.isclose(sum(c.area for c in curves.contacts), overlap, rel_tol=1e-12)
    assert curves.surfaces_of_segment.tolist() == [[0, 1]] * len(curves.segments)
    laws.assert_curves_are_whole(curves)
    return curves


@settings(max_examples=10)
@given(relief(), relief("Base", holes=False))
def test_two_reliefs_on_one_lattice(one, two):
    assert_true(one, two)


@given(
    relief(),
    st.integers(0, 3),
    st.sampled_from([(0, 0), (1, 0), (0, 1), (1, 1), (-1, 1)]),
    st.integers(1, 3),
)
def test_relief_and_a_fault_along_lattice_lines(one, at, lean, n):
    dx, dy = lean
    fault = sheet(
        "F1",
        [(at, -1, -1), (at + 4 * dx, 3 + dy, -1), (at + 4 * dx, 3 + dy, 3), (at, -1, 3)],
        (n, 2),
    )
    assert_true(one, fault)


@given(relief(), relief("Base"), st.randoms(use_true_random=False))
def test_order_and_voxels_change_nothing(one, two, random):
    rng = np.random.default_rng(random.randrange(2**32))
    straight = intersect_surfaces([one, two])
    for size in (0.4, 1.0, 50.0):
        other = intersect_surfaces([one, two], method="voxels", voxel_size=size)
        assert laws.curve_bytes(other) == laws.curve_bytes(straight)
    turned = [shuffled(two, rng), shuffled(one, rng)]
    laws.assert_same_curves(intersect_surfaces(turned), straight)
    same_order = intersect_surfaces([shuffled(one, rng), shuffled(two, rng)])
    assert same_order.local.tobytes() == straight.local.tobytes()
    assert same_order.segments.tobytes() == straight.segments.tobytes()
    assert [c.tobytes() for c in same_order.curves] == [c.tobytes() for c in straight.curves]


def test_closed_curves_one_for_each_crest():
    z = np.zeros((9, 9))
    z[2::4, 2::4] = 2.0
    curves = assert_true(grid("Top", z), sheet("Flat", LEVEL))
    assert curves.n_curve == 4
    assert curves.closed.all()
    for curve in curves.curves:
        assert curve[0] == curve[-1]
        assert len(curve) == 7
        # half way up the six faces around a node: a hexagon
        assert {curves.points[i, 2] for i in curve.tolist()} == {1.0}
    each = 2 * 0.5 + 2 * 0.5 + 2 * math.sqrt(0.5)
    np.testing.assert_allclose(curves.length_of_curve, each, rtol=1e-15)


def test_curves_that_branch():
    """A saddle and its tangent plane: two lines that cross in a node."""
    n = np.arange(7) - 3.0
    saddle = grid("Top", n[None, :] ** 2 - n[:, None] ** 2 + 1.0)
    curves = assert_true(saddle, sheet("Flat", LEVEL))
    degree = np.bincount(curves.segments.ravel())
    node = np.flatnonzero(degree == 4)
    assert curves.points[node].tolist() == [[3.0, 3.0, 1.0]]
    assert curves.n_curve == 4
    assert all(node[0] in (curve[0], curve[-1]) for curve in curves.curves)


@pytest.mark.parametrize("self_intersections", [False, True])
def test_an_overlap_beside_a_surface_that_crosses_itself(self_intersections):
    """Two walls of B cross each other on A, and a third triangle of B lies on A: walls were cut
    unalike where they cross, and their curves on A forgotten.
    """
    flat = soup("A", [[(0, 0, 0), (10, 0, 0), (0, 10, 0)]])
    wall = np.array([(2, -1, -3), (2, 9, -3), (2, 4, 9)])
    part = [(5, 3, 0), (6, 3, 0), (5, 4, 0)]
    crossed = soup("B", [wall, wall[:, [1, 0, 2]], part])
    curves = intersect_surfaces([flat, crossed], self_intersections=self_intersections)
    between = (curves.surfaces_of_segment == (0, 1)).all(axis=1)
    length = laws.length_of(curves.points, curves.segments[between])
    assert length == pytest.approx(7.5 + 7.5 + 2 + math.sqrt(2), rel=1e-12)


@pytest.mark.parametrize("along", [(7, 3), (3, 7), (5, -2), (-1, 6), (2, 9)])
@pytest.mark.parametrize("offset", [0.0, 1000.0])
def test_upright_triangles_that_overlap_above_a_slope(along, offset):
    """Their segments begin inside each other, at points that rounding takes off the line."""
    slope = [(-99, -98, -31), (99, -97, 5), (1, 130, 17)]
    step = np.array([*along, 0.0])
    low, high = np.array([0, 0, -60.0]), np.array([0, 0, 70.0])
    walls = [[k * step + low, (k + 2) * step + low, (k + 1) * step + high] for k in range(3)]
    walls = np.add(walls, (offset, offset, 0.0))
    slope = soup("A", [np.add(slope, (offset, offset, 0.0))])
    curves = intersect_surfaces([slope, soup("B", walls)])
    assert curves.n_curve == 1
    (curve,) = curves.curves
    ends = curves.points[curve[[0, -1]]]
    assert len(curve) == 6  # three segments begin, three end
    assert curves.length == pytest.approx(np.linalg.norm(ends[1] - ends[0]), rel=1e-12)
    assert curves.length > 2.0 * np.hypot(*along)


def test_refusals():
    top = grid("Top", np.zeros((3, 3)))
    refused(InputError, r"1 surfaces were passed; at least 2 are needed", intersect_surfaces, [top])
    message = r"surface 1 is a list, not a TriSurface. Convert it with triangulate_horizon"
    refused(InputError, message, intersect_surfaces, [top, [[0, 0, 0]]])
    empty = TriSurface("Empty", "fault", [[0, 0, 0]], np.empty((0, 3), dtype=int))
    with pytest.raises(SurfaceError, match=r"surface 'Empty' has no triangles; leave it out"):
        intersect_surfaces([top, empty])
    line = soup("F1", [[[0, 0, 0], [1, 1, 1], [0, 1, 0]], [[5, 5, 5], [6, 6, 6], [7, 7, 7]]])
    words = r"'F1': 1 of 2 triangles have no area.*triangle 1 at \(E 5,.*Remove them"
    refused(SurfaceError, words, intersect_surfaces, [top, line])
    far = soup("F2", [[[0, 0, 0], [1e30, 1, 1], [0, 1, 0]]])
    with pytest.raises(SurfaceError, match=r"'F2' has a coordinate of 1e\+30 m; the limit"):
        intersect_surfaces([top, far])


# ----------------------------------------------------------- an independent check


def length_covered(segments) -> float:
    """Length of the union of exact segments: intervals on each line, merged."""
    lines = {}
    for p, q in segments:
        p, q = sorted((tuple(p), tuple(q)))
        along = oracles.minus(q, p)
        axis = next(i for i in range(3) if along[i] != 0)
        step = tuple(value / along[axis] for value in along)
        base = tuple(u - p[axis] * v for u, v in zip(p, step, strict=True))
        lines.setdefault((axis, step, base), []).append((p[axis], q[axis]))
    total = 0.0
    for (_, step, _), intervals in lines.items():
        end = None
        for low, high in sorted(intervals):
            start = low if end is None else max(low, end)
            end = high if end is None else max(high, end)
            total += float(max(high - start, 0)) * math.hypot(*map(float, step))
    return total


@given(soups(most=5))
def test_curves_of_soups_cover_each_line_once(pair):
    """Separate triangles that overlap their neighbours' curves in part: counted once."""
    one, two = pair
    segments, _, overlap = oracles.curves(mesh(one), mesh(two))
    if overlap:
        return
    curves = intersect_surfaces([one, two])
    ends = [tuple(map(oracles.rounded, s)) for s in segments]
    assert curves.length == pytest.approx(length_covered(segments), abs=1e-12)
    points = {tuple(p) for p in curves.points.tolist()}
    assert {p for segment in ends for p in segment} <= points
    rebuilt = rebuild_surfaces([one, two], self_intersections=True)
    if rebuilt.report["moved_vertices"] == 0:
        shared = shared_curves(rebuilt, one.name, two.name)
        assert shared.length == pytest.approx(curves.length, abs=1e-12)
