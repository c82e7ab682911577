"""What must hold for every input: each law fails for empty, shifted and unsealed results."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from fractions import Fraction

import numpy as np

from geosurf import build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from tests import oracles


def assert_closed(triangles) -> None:
    """Each edge is used as often one way as the other, and there is something at all."""
    count: Counter[tuple[int, int]] = Counter()
    for t in np.asarray(triangles).tolist():
        assert len(set(t)) == 3, f"triangle {t} repeats a corner"
        for k in range(3):
            count[t[k], t[(k + 1) % 3]] += 1
    assert count, "there are no triangles"
    open_edges = [edge for edge, n in count.items() if count[edge[::-1]] != n]
    assert not open_edges, f"{len(open_edges)} open edges, the first {open_edges[0]}"


def assert_on_parents(patches, tolerance=1e-9) -> None:
    """Each triangle lies in the one that it names, faces as it does, and fills its share."""
    assert patches.n_triangle > 0
    for i, source in enumerate(patches.sources):
        mine = patches.surface_of_triangle == i
        child = patches.local[patches.triangles[mine]] + patches.origin
        of = patches.parent_of_triangle[mine]
        parent = source.vertices[source.triangles][of]
        a = parent[:, 0]
        normal = np.cross(parent[:, 1] - a, parent[:, 2] - a)
        size = np.einsum("ij,ij->i", normal, normal)
        for k in range(3):
            p = child[:, k]
            off = np.einsum("ij,ij->i", p - a, normal) / np.sqrt(size)
            assert np.abs(off).max() <= tolerance, (
                f"{source.name}: {np.abs(off).max()} m off the plane"
            )
            for c in range(3):
                q, r = parent[:, c], parent[:, (c + 1) % 3]
                share = np.einsum("ij,ij->i", np.cross(q - p, r - p), normal) / size
                height = share * np.sqrt(size) / np.linalg.norm(r - q, axis=1)
                assert height.min() >= -tolerance, f"{source.name}: {height.min()} m outside"
        turn = np.cross(child[:, 1] - child[:, 0], child[:, 2] - child[:, 0])
        way = np.einsum("ij,ij->i", turn, normal)
        unsure = ~(way > 1e-6 * np.linalg.norm(turn, axis=1) * np.sqrt(size))
        for k in np.flatnonzero(unsure):  # a sliver: floats cannot tell
            p = oracles.rational(patches.local[patches.triangles[mine][k]])
            q = oracles.rational(parent[k])
            one, two = (
                oracles.cross(oracles.minus(t[1], t[0]), oracles.minus(t[2], t[0])) for t in (p, q)
            )
            size_on = [abs(component) for component in two]  # seen along the longest one
            axis = size_on.index(max(size_on))
            assert one[axis] * two[axis] > 0, f"{source.name}: turned over"
        share = np.bincount(of, np.linalg.norm(turn, axis=1), minlength=source.n_triangle)
        whole = np.linalg.norm(
            np.cross(
                *(
                    source.vertices[source.triangles][:, k]
                    - source.vertices[source.triangles][:, 0]
                    for k in (1, 2)
                )
            ),
            axis=1,
        )
        edge = np.ptp(source.vertices[source.triangles], axis=1).max()
        np.testing.assert_allclose(share, whole, rtol=1e-9, atol=tolerance * edge)


def assert_volumes_add_up(units, box, tolerance=1e-12) -> None:
    """Shells are closed and outward, their exact volumes are those stated and fill the box."""
    west, east, south, north, bottom, top = (Fraction(float(value)) for value in box)
    whole = (east - west) * (north - south) * (top - bottom)
    total = Fraction(0)
    assert len(units) > 0
    for unit in units.values():
        assert_closed(unit.triangles)
        exact = oracles.volume(unit.local, unit.triangles)
        assert exact > 0, unit.name
        assert abs(exact - Fraction(unit.volume)) <= tolerance * whole, unit.name
        total += exact
    assert abs(total - whole) <= Fraction(tolerance) * whole, float(total / whole - 1)


def curve_bytes(curves) -> tuple:
    """All that curves are, but for the names of surfaces and what the search cost."""
    contacts = [(c.kind, c.surfaces, c.points.tobytes(), c.area) for c in curves.contacts]
    return (
        curves.local.tobytes(), curves.segments.tobytes(), curves.surfaces_of_segment.tobytes(),
        [c.tobytes() for c in curves.curves], curves.surfaces_of_curve.tobytes(),
        curves.closed.tobytes(), contacts,
    )  # fmt: skip


def assert_same_curves(one, two) -> None:
    """The same curves, byte by byte, whatever the order of the surfaces: matched by name."""
    assert chains_by_name(one) == chains_by_name(two)
    assert contacts_by_name(one) == contacts_by_name(two)


def _pair(curves, row) -> tuple[str, ...]:
    return tuple(sorted(curves.names[i] for i in row))


def chains_by_name(curves) -> Counter:
    """Curves as (names, closed, set of end points of its steps)."""
    keys = []
    for row, chain, closed in zip(
        curves.surfaces_of_curve.tolist(), curves.curves, curves.closed.tolist(), strict=True
    ):
        points = [tuple(p) for p in curves.points[chain].tolist()]
        steps = frozenset(frozenset(step) for step in itertools.pairwise(points))
        assert len(steps) == len(points) - 1, "a curve runs twice along one segment"
        assert closed == (points[0] == points[-1])
        keys.append((_pair(curves, row), closed, steps))
    return Counter(keys)


def contacts_by_name(curves) -> Counter:
    """Touching points and overlap areas as (kind, names, points), areas to ten digits."""
    return Counter(
        (c.kind, _pair(curves, c.surfaces), c.points.tobytes(), float(f"{c.area:.10g}"))
        for c in curves.contacts
    )


def assert_curves_are_whole(curves) -> None:
    """Curves use each segment once, and end only where other than two segments meet."""
    steps = Counter()
    for row, chain in zip(curves.surfaces_of_curve.tolist(), curves.curves, strict=True):
        for a, b in zip(chain[:-1].tolist(), chain[1:].tolist(), strict=True):
            steps[tuple(row), min(a, b), max(a, b)] += 1
    segments = Counter(
        (tuple(row), a, b)
        for row, (a, b) in zip(
            curves.surfaces_of_segment.tolist(), curves.segments.tolist(), strict=True
        )
    )
    assert steps == segments
    degree: Counter = Counter()
    for row, a, b in segments:
        degree[row, a] += 1
        degree[row, b] += 1
    for row, chain, closed in zip(
        curves.surfaces_of_curve.tolist(), curves.curves, curves.closed, strict=True
    ):
        assert all(degree[tuple(row), p] == 2 for p in chain[1:-1].tolist())
        if not closed:
            assert degree[tuple(row), int(chain[0])] != 2
            assert degree[tuple(row), int(chain[-1])] != 2


def pieces_by_name(patches) -> Counter:
    """Triangles as (surface, corners of the parent, corners), without order or numbers."""
    out: Counter = Counter()
    for i, source in enumerate(patches.sources):
        mine = np.flatnonzero(patches.surface_of_triangle == i)
        corners = (patches.local[patches.triangles[mine]] + patches.origin).tolist()
        parent = source.vertices[source.triangles[patches.parent_of_triangle[mine]]].tolist()
        for p, c in zip(parent, corners, strict=True):
            out[source.name, tuple(sorted(map(tuple, p))), tuple(sorted(map(tuple, c)))] += 1
    return out


def assert_same_patches(one, two) -> None:
    """The same triangles and the same patches, up to numbers and order."""
    assert pieces_by_name(one) == pieces_by_name(two)
    assert _partition(one) == _partition(two)


def _partition(patches) -> Counter:
    corners = (patches.local[patches.triangles] + patches.origin).tolist()
    groups: dict[int, list] = {}
    for p, s, c in zip(
        patches.patch_of_triangle.tolist(),
        patches.surface_of_triangle.tolist(),
        corners,
        strict=True,
    ):
        groups.setdefault(p, []).append((patches.names[s], tuple(sorted(map(tuple, c)))))
    return Counter(tuple(sorted(group)) for group in groups.values())


def assert_same_bytes(one, two) -> None:
    """Patches with the same arrays, byte by byte."""
    for name in ("local", "triangles", "surface_of_triangle", "parent_of_triangle",
                 "patch_of_triangle", "curve_edges"):  # fmt: skip
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes(), name


def assert_shares_vertices(patches) -> None:
    """No two vertices have the same place, all are used, and curve edges are edges of triangles."""
    assert len(np.unique(patches.local, axis=0)) == len(patches.local)
    assert len(np.unique(patches.triangles)) == len(patches.local)
    edges = {
        frozenset((t[k], t[(k + 1) % 3])) for t in patches.triangles.tolist() for k in range(3)
    }
    assert {frozenset(e) for e in patches.curve_edges.tolist()} <= edges


def volume_by_zone(units) -> dict[str, float]:
    """Volume of each zone, over all its blocks."""
    found: Counter = Counter()
    for unit in units.values():
        found[unit.zone] += unit.volume
    return dict(found)


def length_of(points, segments) -> float:
    ends = np.asarray(points)[segments]
    return math.fsum(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


def carved(surfaces, ring, box):
    """Units inside an area, all of which are closed, oriented and certified."""
    patches = rebuild_surfaces([*surfaces, *build_walls(box, ring)])
    units = carve_units(patches)
    certificate = certify(patches, units)
    assert certificate.ok, str(certificate)
    for unit in units.values():
        assert_closed(unit.triangles)
        assert oracles.volume(unit.local, unit.triangles) > 0, unit.name  # faces outward
    return units
