"""On which side a fault leaves a bent one: against arithmetic that a child could follow."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geosurf import TriSurface, rebuild_surfaces
from geosurf.errors import GeosurfError
from geosurf.faults.sides import adjacency

place = st.tuples(*[st.integers(-2, 2)] * 2, st.integers(-1, 3))


def height(p, a, b, c):
    """Six times the volume of a, b, c and p: positive in front of a, b, c."""
    u, v, w = ([Fraction(q[k] - a[k]) for k in range(3)] for q in (b, c, p))
    n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    return sum(x * y for x, y in zip(n, w, strict=True))


def in_front(p, u, v, left, right):
    """Whether p lies in front of the flanks (u, v, left) and (v, u, right); 0 where it is in one.

    In front of a fold towards the front is what is in front of both flanks; of a fold towards the
    back, what is in front of one of them.
    """
    one, two = height(p, u, v, left), height(p, v, u, right)
    fold = height(right, u, v, left)
    if fold == 0:  # flat, or folded onto itself
        return 1 if one > 0 else -1 if one < 0 else 0
    if fold > 0:
        return 1 if one > 0 and two > 0 else -1 if one < 0 or two < 0 else 0
    return 1 if one > 0 or two > 0 else -1 if one < 0 and two < 0 else 0


@given(place, place, place, st.booleans(), st.booleans())
def test_law_the_side_of_a_fold_is_that_of_two_planes(left, right, far, turn, back):
    u, v = (0, 0, 0), (0, 0, 2)
    expected = in_front(far, u, v, left, right)
    places = [u, v, left, right, far]
    if len(set(places)) < 5 or any(p[0] == p[1] == 0 for p in (left, right, far)):
        return
    across = left[0] * right[1] - left[1] * right[0]
    if across == 0 and left[0] * right[0] + left[1] * right[1] > 0:
        return  # a main fault folded onto itself
    if expected == 0:
        return  # in the plane of a flank
    main = TriSurface("F1", "fault", [u, v, left, right], [[0, 1, 2], [1, 0, 3]])
    faces = [[1, 0, 2]] if turn else [[0, 1, 2]]
    other = TriSurface("F2", "fault", [u, v, far], faces)
    patches = rebuild_surfaces([other, main] if back else [main, other])
    rows = [
        np.flatnonzero(patches.surface_of_triangle == patches.names.index(n)) for n in ("F2", "F1")
    ]
    beside = adjacency(patches, *rows)
    # the piece at the edge u, v alone: flanks may be met again elsewhere
    at_edge = [
        beside.piece[half // 3]
        for half, edge in zip(beside.half_edges, beside.edge_of_half, strict=True)
        if (patches.vertices[beside.edges[edge]][:, :2] == 0).all()
    ]
    sides = beside.beside[at_edge]
    assert len(sides) > 0
    assert sides[:, 0 if expected > 0 else 1].all()


@given(st.integers(1, 40), st.integers(1, 40), st.integers(-3, 3))
def test_law_nearly_flat_folds_far_from_the_origin_are_told_exactly(a, b, lift):
    """A fold of one part in 10^9 at UTM coordinates, and a fault between its flanks' planes."""
    origin = np.array([460_000.0, 5_930_000.0, -2_000.0])
    tiny = 2.0**-28
    main = np.array([[0, 0, 0], [0, 64, 0], [-64, 0, -a * tiny], [64, 0, -b * tiny]])
    fault = np.array([[0, 0, 0], [0, 64, 0], [-64, 0, lift * tiny - a * tiny]])
    if lift == 0:
        return
    surfaces = [
        TriSurface("F1", "fault", main + origin, [[0, 1, 2], [1, 0, 3]]),
        TriSurface("F2", "fault", fault + origin, [[0, 1, 2]]),
    ]
    try:
        patches = rebuild_surfaces(surfaces)
    except GeosurfError:
        return  # refused by name: too thin for float64
    if patches.report["moved_vertices"]:
        return
    rows = [np.flatnonzero(patches.surface_of_triangle == k) for k in (1, 0)]
    beside = adjacency(patches, *rows)
    assert beside.beside.tolist() == [[lift > 0, lift < 0]]
