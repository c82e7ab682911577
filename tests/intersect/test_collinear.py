"""Segments that overlap in a line are split alike: as slow and obvious arithmetic does it."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from benchmarks.growth import chords, planes_through_a_line, seam
from geosurf.arrangement.search import find_contacts
from geosurf.intersect.link import (
    line_contacts,
    of_pairs,
    pairs_of_rows,
    pairs_with_areas,
    split_overlaps,
    touching_points,
)
from tests import oracles
from tests.rebuild.worlds import world
from tests.strategies import soup


def face_corners(contacts, points, face):
    """Three points of the plane of a face, or of one through an edge along an axis."""
    if face < len(contacts.t):
        return [points[i] for i in contacts.t[face]]
    a, b, axis = contacts.e[face - len(contacts.t)].tolist()
    up = list(points[a])
    up[axis] += 1
    return [points[a], points[b], tuple(up)]


def exact_points(contacts):
    """All points as fractions: vertices, then where an edge passes the plane of a face."""
    points = [tuple(map(Fraction, p)) for p in contacts.x[: contacts.n_vertex].tolist()]
    for _, a, b, face in contacts.d.tolist():
        p, q = points[a], points[b]
        corners = face_corners(contacts, points, face)
        normal, way = oracles.normal_of(corners), oracles.minus(q, p)
        part = oracles.dot(normal, oracles.minus(corners[0], p)) / oracles.dot(normal, way)
        points.append(tuple(c + part * w for c, w in zip(p, way, strict=True)))
    return points


def split_slowly(contacts, segments, surfaces, touching):
    """Every point of a pair of surfaces against every segment of it."""
    points, out = exact_points(contacts), set()
    for pair in {tuple(of) for of in surfaces.tolist()}:
        mine = segments[(surfaces == pair).all(axis=1)].tolist()
        stops = {i for ends in mine for i in ends}
        stops |= set(touching[(touching[:, :2] == pair).all(axis=1), 2].tolist())
        for a, b in mine:
            p, q = points[a], points[b]
            way = oracles.minus(q, p)
            on = [
                i for i in stops
                if not any(oracles.cross(way, oracles.minus(points[i], p)))
                and 0 <= oracles.dot(way, oracles.minus(points[i], p)) <= oracles.dot(way, way)
            ]  # fmt: skip
            on.sort(key=points.__getitem__)
            out |= {(pair, ends) for ends in pairwise(on)}
    return rounded(contacts, out)


def rounded(contacts, pieces):
    """Pieces between rounded points, which is where curves run."""
    place = [tuple(p) for p in contacts.x.tolist()]
    found = {(pair, frozenset(place[i] for i in ends)) for pair, ends in pieces}
    return {piece for piece in found if len(piece[1]) == 2}


def loose(rng, name):
    """Separate triangles on a lattice, many of them with corners in one plane."""
    while True:
        corners = rng.integers(0, rng.integers(3, 6), (rng.integers(3, 14), 3, 3)).astype(float)
        if rng.random() < 0.5:
            corners[rng.random(corners.shape[:2]) < 0.6, 1] = 1.0
        corners = [c / rng.choice([1, 3]) for c in corners if not oracles.flat(c)]
        if corners:
            return soup(name, corners)


def surfaces_of_collinear(seed):
    """Two or three surfaces, or one that may cross itself."""
    if seed % 3 == 0:
        return world(seed)
    rng = np.random.default_rng(seed)
    return [loose(rng, name) for name in "ABC"[: rng.integers(1, 4)]]


def both_ways(surfaces, itself):
    """Pieces by split_overlaps and by slow arithmetic, and how many segments there were."""
    contacts = find_contacts(surfaces, self_intersections=itself)
    pairs = pairs_of_rows(contacts)
    segments, of = line_contacts(contacts, pairs)
    touching = touching_points(contacts, pairs)
    areas = pairs_with_areas(contacts, pairs)
    plain, single = ~of_pairs(of, areas), ~of_pairs(touching[:, :2], areas)
    given = contacts, segments[plain], of[plain], touching[single]
    pieces, owners = split_overlaps(*given)
    fast = rounded(contacts, zip(map(tuple, owners.tolist()), pieces.tolist(), strict=True))
    return fast, split_slowly(*given), int(plain.sum())


def test_pieces_are_those_of_every_point_against_every_segment():
    n_split = 0
    for seed in range(30):
        surfaces = surfaces_of_collinear(seed)
        fast, slow, n = both_ways(surfaces, len(surfaces) == 1 or seed % 2 == 0)
        assert fast == slow, seed
        n_split += len(slow) > n
    assert n_split > 3  # the law is asked where it matters


@pytest.mark.parametrize("n", [7, 24])
@pytest.mark.parametrize("make", [planes_through_a_line, seam, chords])
def test_surfaces_along_one_line(make, n):
    fast, slow, _ = both_ways(make(n if make is not seam else 7), True)
    assert fast == slow


def test_a_point_reaches_segments_through_faces_that_it_does_not_end_in():
    """Sheets A and B cross along a line that C has as its edge, and D passes C and ends there.

    No contact of A or B has a corner where D does: it is known in C, by its edge in A, then in B.
    """
    corners = [
        [(-9, -9, -9), (9, -9, -9), (0, 9, 9)],  # A: y = z
        [(-9, -9, 9), (9, -9, 9), (0, 9, -9)],  # B: y = -z
        [(-1, 0, 0), (1, 0, 0), (0, -1, 0)],  # C: its first edge in the line y = z = 0
        [(0, -9, -9), (0, 9, -9), (0, 0, 9)],  # D: x = 0
    ]
    fast, slow, _ = both_ways([soup("A", corners)], True)
    assert fast == slow
    middle = [p for _, ends in fast for p in ends]
    assert len(middle) > 8
