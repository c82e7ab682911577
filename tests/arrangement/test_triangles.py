"""Two triangles: every kind of contact, against clipping in rational arithmetic."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np
import pytest
from hypothesis import given

from benchmarks.stress.catalogue import BASE, CATALOGUE
from geosurf import intersect_triangles
from geosurf.errors import SurfaceError
from tests import oracles
from tests.strategies import UTM, triangles

FLAT = BASE.astype(float)
KINDS = {0: "disjoint", 1: "point", 2: "segment"}


def assert_true(P, Q):
    """Kind, points, features, coplanarity and crossing of a contact are those of the oracle."""
    P, Q = np.asarray(P, dtype=float), np.asarray(Q, dtype=float)
    contact = intersect_triangles(P, Q)
    corners = oracles.meet_triangles(P, Q)
    assert contact.kind == KINDS.get(len(corners), "area")
    assert len(contact.points) == len(corners) == len(contact.features)
    # distinct corners may have equal doubles, so points and features are compared together
    p, q = oracles.rational(P), oracles.rational(Q)
    true = Counter(
        (oracles.rounded(c), oracles.feature(p, c), oracles.feature(q, c)) for c in corners
    )
    named = zip(map(tuple, contact.points.tolist()), contact.features, strict=True)
    assert Counter((point, *features) for point, features in named) == true
    assert contact.coplanar == oracles.coplanar(P, Q)
    crossing = len(corners) == 2 and oracles.straddles(p, q) and oracles.straddles(q, p)
    assert contact.crossing == crossing
    return contact


@given(triangles(), triangles())
def test_lattice_pairs(P, Q):
    assert_true(P, Q)


@given(triangles(), triangles())
def test_coplanar_lattice_pairs(P, Q):
    P[:, 2] = Q[:, 2] = 1.0
    if not (oracles.flat(P) or oracles.flat(Q)):
        assert_true(P, Q)


@given(triangles(2), triangles(2))
def test_points_of_skew_coplanar_pairs_are_rounded_once(P, Q):
    P[:, 2] = 3.0 * P[:, 0] - 7.0 * P[:, 1]
    Q[:, 2] = 3.0 * Q[:, 0] - 7.0 * Q[:, 1]
    if not (oracles.flat(P) or oracles.flat(Q)):
        assert_true(P, Q)


@given(triangles(), triangles())
def test_nudged_pairs(P, Q):
    rng = np.random.default_rng(5)
    for _ in range(3):
        bent = np.where(rng.random((3, 3)) < 0.3, np.nextafter(Q, 9.0), Q)
        bent[np.abs(bent) < 1e-300] = 2.0**-50
        assert_true(P + 0.1, bent + 0.1)
    assert_true(P * 12.5 + UTM, bent * 12.5 + UTM)


@pytest.mark.parametrize("kind", ["disjoint", "point", "segment", "area"])
def test_catalogue(kind):
    for pair in (one for one in CATALOGUE if one.kind == kind):
        for k in range(3):
            contact = assert_true(np.roll(pair.corners, k, axis=0), FLAT)
            assert (contact.kind, len(contact.points)) == (kind, pair.count), pair.name


@given(triangles(), triangles())
def test_law_the_textbook_says_the_same_where_its_numbers_are_clear(P, Q):
    contact = intersect_triangles(P, Q, steps=True)
    steps = contact.steps
    np.testing.assert_array_equal(np.sign(steps.heights), steps.sides)  # whole numbers
    assert (steps.rejected is not None) == (3 in np.abs(steps.sides.sum(axis=1)))
    if steps.intervals is None:
        assert contact.coplanar or (steps.rejected and contact.kind == "disjoint")
        return
    # both planes hold the line, and each cut point lies on it
    assert np.abs(steps.normals @ steps.direction).max() < 1e-9 * np.abs(steps.normals).max()
    origin = steps.cut_points[0][0]
    for points in steps.cut_points:
        assert np.abs(np.cross(points - origin, steps.direction)).max() < 1e-9
    low, high = steps.intervals[:, 0].max(), steps.intervals[:, 1].min()
    if high < low - 1e-9:
        assert (contact.kind, steps.overlap) == ("disjoint", None)
    if high > low + 1e-9:
        assert (contact.kind, steps.overlap) == ("segment", (low, high))
        ends = origin + np.outer([low, high], steps.direction)
        found = contact.points[np.argsort(contact.points @ steps.direction)]
        np.testing.assert_allclose(found, ends, atol=1e-9)


def test_corners_of_an_area_run_around_it():
    contact = intersect_triangles([(16, 16, 0), (-8, 16, 0), (16, -8, 0)], FLAT)
    ring = contact.points[:, :2]
    turns = [oracles.orient2d(ring[k - 2], ring[k - 1], ring[k]) for k in range(len(ring))]
    assert abs(sum(turns)) == 6


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], r"triangle Q has no area.*on one line\. Give three"),
        ([[0, 0, 0], [1, 1, 1], [0, 0, 0]], r"triangle Q has no area"),
        ([[0.1, 0.1, 0.1]] * 3, r"triangle Q has no area.*0\.1"),
        ([[0, 0, 1e30], [1, 0, 0], [0, 1, 0]], r"triangle Q .*beyond 1\.15292e\+18 m"),
    ],
)
def test_what_is_no_triangle_is_refused_by_name(corners, words):
    with pytest.raises(SurfaceError, match=words):
        intersect_triangles(FLAT, corners)
    with pytest.raises(SurfaceError, match=re.sub("triangle Q", "triangle P", words)):
        intersect_triangles(corners, FLAT)


def test_nearly_flat_triangles_are_not_refused():
    sliver = [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, np.nextafter(1.0, 2.0), 0.0]]
    contact = assert_true(sliver, FLAT)
    assert contact.kind == "segment"
    assert contact.points[0, 1] != contact.points[1, 1]
