"""Intersect two triangles, with all degenerate cases."""

from __future__ import annotations

from typing import Any

import numpy as np

from geosurf.arrangement.named import name_contacts
from geosurf.conventions import real_numbers
from geosurf.errors import SurfaceError
from geosurf.kernels.contacts.packed_contact import pack_contacts
from geosurf.kernels.contacts.triangle_contact import (
    CROSSING,
    FIRST_CODE,
    N_COLUMN,
    N_CORNER,
    meet_pairs,
)
from geosurf.kernels.exact.predicates import (
    MAX_COORDINATE,
    MAX_SCALE,
    VALID_SIZES,
    flat_triangles,
    frame_of,
    orient3d_rows,
)
from geosurf.kernels.meshes.mesh import weld
from geosurf.model import TriangleContact, frozen

_FEATURES = ("vertex 0", "vertex 1", "vertex 2", "edge 0", "edge 1", "edge 2", "face")
_KINDS = ("disjoint", "point", "segment")


def intersect_triangles(P: Any, Q: Any) -> TriangleContact:
    """
    Determine how two triangles meet, and where.

    Every case has its answer: apart, touching in a point, along an edge or a part of one, crossing,
    one in the plane of the other, overlapping in it. All decisions are exact signs; only
    the coordinates of constructed points are rounded, correctly.

    Parameters
    ----------
    P, Q : array_like of float, shape (3, 3)
        Corners: easting, northing, elevation [m].

    Returns
    -------
    TriangleContact
        `kind` is ``"disjoint"``, ``"point"``, ``"segment"`` or ``"area"``; `points` has 0, 1, 2 or
        3 to 6 rows; `features` names for each point the lowest-dimensional feature of P and of
        Q that holds it. Edge ``i`` joins corner ``i`` to the next.

    Raises
    ------
    SurfaceError
        If a triangle has another shape, is not finite, or has no area.

    Notes
    -----
    The classical route (heights over the other plane, cut points on the common line, overlap of
    two intervals) assumes that no corner lies in the other plane. Here each
    zero sign is a case: see ``geosurf.kernels.contacts.triangle_contact``.

    Examples
    --------
    >>> flat = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]
    >>> steep = [[1, 1, -1], [1, 1, 1], [9, 9, 1]]
    >>> contact = intersect_triangles(flat, steep)
    >>> contact.kind, contact.points.tolist(), contact.features
    ('segment', [[1.0, 1.0, 0.0], [2.0, 2.0, 0.0]], (('face', 'edge 0'), ('edge 1', 'face')))
    """
    corners = np.concatenate([_checked("P", P), _checked("Q", Q)])
    number, count = weld(corners)
    x = np.empty((count, 3))
    x[number] = corners
    t = number.reshape(2, 3)

    m, w = frame_of(x, 2)
    for row in flat_triangles(x, t, m, w):
        raise SurfaceError(
            f"triangle {'PQ'[row]} has no area: its corners "
            f"{corners[3 * row : 3 * row + 3].tolist()} lie on one line. Give three that do not."
        )

    # The exact contact of the pair (0, 1): its corners come as codes of features of P and Q.
    rows = np.zeros((2, N_COLUMN), dtype=np.int64)
    n, _ = meet_pairs(x, t, np.array([[0, 1]]), m, w, 0.0, rows, np.empty(0, dtype=np.int64))
    coplanar = bool(rows[0, 2]) if n else _coplanar(x, t, m, w)
    if n == 0:
        return TriangleContact(
            "disjoint", frozen(np.empty((0, 3)), np.float64), coplanar, (), False
        )

    # Each code has the feature of P above and the feature of Q in its lower three bits.
    points = _points(x, t, m, w, rows[:1])
    codes = rows[0, FIRST_CODE : FIRST_CODE + rows[0, N_CORNER]] & 63
    order = _around(points) if len(codes) > 2 else np.lexsort(points.T[::-1])
    features = tuple((_FEATURES[code >> 3], _FEATURES[code & 7]) for code in codes[order])
    kind = "area" if len(codes) > 2 else _KINDS[len(codes)]
    crossing = bool(rows[0, CROSSING])
    return TriangleContact(kind, frozen(points[order], np.float64), coplanar, features, crossing)


def _checked(letter: str, triangle: Any) -> np.ndarray:
    """Float64 (3, 3), finite, or a SurfaceError."""
    try:
        corners = real_numbers(triangle)
    except (TypeError, ValueError) as error:
        raise SurfaceError(f"triangle {letter} is not made of numbers: {error}.") from error

    if corners.shape != (3, 3):
        raise SurfaceError(
            f"triangle {letter} has shape {corners.shape}, expected (3, 3): three corners with "
            "easting, northing, elevation."
        )
    if not (np.abs(corners) <= MAX_COORDINATE).all():
        raise SurfaceError(
            f"triangle {letter} has a coordinate that is not finite or beyond "
            f"{MAX_COORDINATE:g} m: {corners.tolist()}. Leave out nodes that are undefined."
        )

    # Coordinates are scaled to whole numbers; -0.0 becomes 0.0 at the end.
    digits = corners * 2.0**MAX_SCALE
    if (digits != np.floor(digits)).any():
        raise SurfaceError(
            f"triangle {letter} has a coordinate too close to 0: {corners.tolist()}; {VALID_SIZES}."
        )
    return corners + 0.0


def _coplanar(x: np.ndarray, t: np.ndarray, m: np.ndarray, w: np.ndarray) -> bool:
    """Whether the corners of the second triangle lie in the plane of the first."""
    # Each corner of Q against the plane of P.
    rows = np.array([[*t[0], corner] for corner in t[1]])
    signs = np.empty(3, dtype=np.int64)
    orient3d_rows(x, rows, m, w, signs)
    return not signs.any()


def _points(
    x: np.ndarray, t: np.ndarray, m: np.ndarray, w: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """Coordinates of the points of one contact."""
    # Room for the six corners and twelve constructed points; the ids name those of the contact.
    space = np.concatenate([x, np.empty((12, 3))])
    e, d = np.zeros((12, 3), dtype=np.int64), np.zeros((12, 4), dtype=np.int64)
    ids = np.empty((1, 6), dtype=np.int64)
    name_contacts(space, t, e, d, m, w, pack_contacts(rows), ids)
    return space[ids[0, : rows[0, N_CORNER]]]


def _around(points: np.ndarray) -> np.ndarray:
    """Order of the corners of a convex polygon around its middle, from the lowest corner."""
    # The two main axes of the points span their plane; angles around the mean give the order.
    middle = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(middle)
    order = np.argsort(np.arctan2(middle @ axes[1], middle @ axes[0]))

    # The lexicographically lowest corner comes first, so that the result does not depend on the
    # SVD.
    start = int(np.lexsort(points[order].T[::-1])[0])
    return np.roll(order, -start)
