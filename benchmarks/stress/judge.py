"""Compare results of the engine with rational arithmetic and plain geometry.

Nothing here asks the engine what it decided, with one exception: `crossing_pairs` takes the
finished, rounded mesh at face value and tests it exactly, whatever made it. Coordinates are
judged in the local frame of a result, to which the shift is exact. One *ulp* is the spacing of
float64 at the largest local coordinate.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.stress import rational as exact
from benchmarks.stress.judge_curves import judge_curves
from benchmarks.stress.verdict import (
    TINY,
    Meeting,
    Verdict,
    area_vectors,
    judge_distance,
    meetings,
    nearest,
    ulp_of,
)
from geosurf.arrangement.triangles import crossing_pairs
from geosurf.model import Curves, Patches, TriangleContact, TriSurface

__all__ = [
    "Meeting",
    "Verdict",
    "judge_contact",
    "judge_curves",
    "judge_known",
    "judge_order",
    "judge_patches",
    "meetings",
]

KINDS = ("disjoint", "point", "segment")


# ---- two triangles ---------------------------------------------------------------------


def judge_contact(P: np.ndarray, Q: np.ndarray, contact: TriangleContact) -> Verdict:
    """
    Judge the result of `intersect_triangles`: kind, points, features, sides.

    Parameters
    ----------
    P, Q : ndarray of float64, shape (3, 3)
    contact : TriangleContact

    Returns
    -------
    Verdict

    Examples
    --------
    >>> from geosurf.arrangement import intersect_triangles
    >>> P = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0.0]])
    >>> judge_contact(P, P + [1, 1, 0], intersect_triangles(P, P + [1, 1, 0])).wrong
    []
    """
    # The truth comes from fractions alone.
    verdict = Verdict()
    first, second = exact.rational(P), exact.rational(Q)
    corners = exact.meet(first, second)
    kind = KINDS[len(corners)] if len(corners) < 3 else "area"
    verdict.check(contact.kind == kind, f"contact is {contact.kind}, expected {kind}")

    coplanar = not any(exact.sides(first, second))
    verdict.check(contact.coplanar == coplanar, f"coplanar is {contact.coplanar}, which is wrong")
    crossing = kind == "segment" and exact.straddles(first, second)
    crossing = crossing and exact.straddles(second, first)
    verdict.check(contact.crossing == crossing, f"crossing is {contact.crossing}, which is wrong")

    # Each exact corner has a computed one within 1 ulp, with the same features.
    n = len(contact.points)
    verdict.check(n == len(corners), f"contact has {n} points, expected {len(corners)}")
    if verdict.wrong or not corners:
        return verdict
    ulp = ulp_of(P, Q)
    for k, corner in enumerate(corners):
        row = nearest(contact.points, corner)
        verdict.measure(contact.points[row], corner, ulp, f"point {k} of the contact")
        names = exact.feature(first, corner), exact.feature(second, corner)

        # Several features may share a place: any of them may name it.
        found = [
            pair
            for pair, point in zip(contact.features, contact.points, strict=True)
            if (point == contact.points[row]).all()
        ]
        verdict.check(names in found, f"point {k} is {found}, expected {names}")
    return verdict


# ---- meshes ----------------------------------------------------------------------------


def judge_patches(
    given: Sequence[TriSurface], patches: Patches, met: Sequence[Meeting], itself: bool = True
) -> Verdict:
    """
    Judge a rebuilt mesh: nothing lost, moved, turned over or crossing; all contacts in it.

    Parameters
    ----------
    given : sequence of TriSurface
        What was rebuilt.
    patches : Patches
        Inputs that were moved to repair rounding are judged by the move that is reported.
    met : sequence of Meeting
        Of ``patches.sources``, in the frame of ``patches.origin``.
    itself : bool
        Whether surfaces were split at themselves, so that they may not cross themselves.

    Returns
    -------
    Verdict
    """
    verdict = Verdict()
    _judge_moves(given, patches, verdict)
    x = patches.local
    ulp = ulp_of(x)
    # Pieces of each surface against their parent triangles.
    for i, source in enumerate(patches.sources):
        mine = patches.surface_of_triangle == i
        parent = patches.parent_of_triangle[mine]
        corners = (source.vertices - patches.origin)[source.triangles]
        _judge_children(source.name, corners, x[patches.triangles[mine]], parent, ulp, verdict)
    if verdict.wrong:
        return verdict  # the test of crossing pairs needs triangles with an area

    # triangles on which surfaces coincide count once: they do not cross themselves
    rows, number = np.unique(np.sort(patches.triangles, axis=1), axis=0, return_inverse=True)
    pairs = crossing_pairs(x, rows)
    # Without self-intersections, triangles of one surface may cross each other.
    if not itself:
        owners = np.zeros((len(rows), len(given)), dtype=bool)
        owners[number.ravel(), patches.surface_of_triangle] = True
        one, two = owners[pairs[:, 0]], owners[pairs[:, 1]]
        pairs = pairs[(one != two).any(axis=1) | (one.sum(axis=1) > 1)]
    if len(pairs):
        place = x[rows[pairs[0, 0], 0]] + patches.origin
        verdict.check(False, f"{len(pairs)} pairs of triangles cross, the first near {place}")
    _judge_corners(patches, met, ulp, verdict)
    return verdict


def _judge_moves(given: Sequence[TriSurface], patches: Patches, verdict: Verdict) -> None:
    """Sources are the inputs, except for the reported moves."""
    count, far = 0, 0.0
    for old, new in zip(given, patches.sources, strict=True):
        same = old.name == new.name and old.vertices.shape == new.vertices.shape
        verdict.check(same, f"surface {old.name!r} was changed")
        if same:
            steps = np.linalg.norm(new.vertices - old.vertices, axis=1)
            count, far = count + int((steps > 0).sum()), max(far, float(steps.max()))

    reported = patches.report["moved_vertices"], patches.report["largest_move"]
    verdict.check(reported == (count, far), f"moves are {(count, far)}, but reported as {reported}")


def _judge_children(
    name: str,
    parents: np.ndarray,
    children: np.ndarray,
    parent: np.ndarray,
    ulp: float,
    verdict: Verdict,
) -> None:
    """Children (n, 3, 3) cover their parents, face as they do and lie on them."""
    # Signed areas along the axis on which the parent is widest: no square roots.
    vectors = area_vectors(parents)
    axis, way = _facing(parents, vectors)
    axis, way = axis[parent], way[parent]
    mine = area_vectors(children)[np.arange(len(parent)), axis]

    sides = np.abs(children - np.roll(children, 1, axis=1)).max(axis=(1, 2))
    # Floats decide clear cases; the others are decided in fractions.
    for k in np.flatnonzero(~(mine * way > np.maximum(1e-14 * sides**2, TINY))):
        facing = exact.normal_of(exact.rational(children[k]))[axis[k]]
        facing *= int(way[k])
        what = f"{name}: a piece of triangle {parent[k]} "
        verdict.check(facing > 0, what + ("has no area" if facing == 0 else "is turned over"))

    # The area of a triangle is half the length of its vector: compare sums of lengths.
    largest = np.maximum(np.abs(vectors).max(axis=1, keepdims=True), TINY)
    size = np.linalg.norm(vectors / largest, axis=1)  # without squares that underflow
    normal = vectors / largest / np.maximum(size, TINY)[:, None]
    size *= largest[:, 0]
    total = np.bincount(
        parent, (area_vectors(children) * normal[parent]).sum(axis=1), minlength=len(parents)
    )

    count = np.bincount(parent, minlength=len(parents))
    reach = np.abs(parents - np.roll(parents, 1, axis=1)).max(axis=(1, 2))
    slack = 1e-12 * size + 8 * ulp * reach * (count + 2)
    for k in np.flatnonzero(~(np.abs(total - size) <= slack)):
        lack = (size[k] - total[k]) / 2
        verdict.check(False, f"{name}: pieces of triangle {k} are {lack:.3g} m² short")

    points, owners = children.reshape(-1, 3), np.repeat(parent, 3)
    judge_distance(f"{name}: a piece", points, parents[owners], ulp, verdict)


def _facing(parents: np.ndarray, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axis on which each triangle (n, 3, 3) is widest, and which way it faces there."""
    axis = np.abs(vectors).argmax(axis=1)
    largest = vectors[np.arange(len(vectors)), axis]
    sides = np.abs(parents - np.roll(parents, 1, axis=1)).max(axis=(1, 2))

    way = np.sign(largest).astype(np.int64)
    second = np.sort(np.abs(vectors), axis=1)[:, 1]  # where two axes tie, the first is exact
    clear = np.abs(largest) > np.maximum(np.maximum(1e-14 * sides**2, TINY), second * (1 + 1e-12))
    # Where floats leave the axis or the sign open, fractions decide.
    for k in np.flatnonzero(~clear):
        normal = exact.normal_of(exact.rational(parents[k]))
        axis[k] = max(range(3), key=lambda i: abs(normal[i]))
        way[k] = 1 if normal[axis[k]] > 0 else -1
    return axis, way


def _judge_corners(patches: Patches, met: Any, ulp: float, verdict: Verdict) -> None:
    """Whatever two triangles have in common begins and ends in vertices that both have."""
    # Vertices of the pieces of each triangle, by (surface, row).
    vertices: dict[tuple[int, int], set[int]] = {}
    owners = zip(
        patches.surface_of_triangle.tolist(), patches.parent_of_triangle.tolist(), strict=True
    )
    for owner, triangle in zip(owners, patches.triangles.tolist(), strict=True):
        vertices.setdefault(owner, set()).update(triangle)
    for m in met:
        both = sorted(vertices[m.i, m.f] & vertices[m.j, m.g])
        what = _pair_name(patches.names, m)
        verdict.check(len(both) >= 1, f"{what}: they share no vertex")
        for corner in m.corners if both else ():
            place = patches.local[both]
            verdict.measure(place[nearest(place, corner)], corner, ulp, what)


def _pair_name(names: Sequence[str], m: Meeting) -> str:
    return f"triangle {m.f} of {names[m.i]!r} and {m.g} of {names[m.j]!r}"


# ---- known in advance, and the same in any order ---------------------------------------


def judge_known(known: dict[str, Any], contact: TriangleContact | None, curves: Curves) -> Verdict:
    """Judge by what was known when a case was made: kind and count, apart, area [m2]."""
    verdict = Verdict()
    if contact is not None and "kind" in known:
        given, true = (contact.kind, len(contact.points)), (known["kind"], known["count"])
        verdict.check(given == true, f"contact is {given}, the catalogue has {true}")
    if known.get("apart"):
        verdict.check(curves.n_curve + len(curves.contacts) == 0, "surfaces with a gap meet")
    if "area" in known:
        found = sum(t.area for t in curves.contacts if t.surfaces == (0, 1))
        true = known["area"]
        verdict.check(
            abs(found - true) <= 1e-12 * (1 + true), f"overlap {found} m², expected {true}"
        )
    return verdict


def judge_order(one: Patches, two: Patches) -> Verdict:
    """Judge whether the same surfaces in another order became the same triangles."""
    verdict = Verdict()
    for name in one.names:
        first, second = (_pieces(patches, name) for patches in (one, two))
        same = first.shape == second.shape and bool((first == second).all())
        verdict.check(same, f"pieces of {name!r} depend on the order of the input")
    return verdict


def _pieces(patches: Patches, name: str) -> np.ndarray:
    """Triangles of one surface (n, 9), corners and rows in lexicographic order."""
    rows = patches.triangles[patches.surface_of_triangle == patches.names.index(name)]

    # Number points by coordinates, so that the order of rows does not matter.
    number = np.empty(len(patches.local), dtype=np.int64)
    number[np.lexsort(patches.local.T[::-1])] = np.arange(len(number))
    rows = np.take_along_axis(rows, np.argsort(number[rows], axis=1), axis=1)
    out = patches.local[rows].reshape(-1, 9)
    return out[np.lexsort(out.T[::-1])]
