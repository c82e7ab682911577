"""Plain curves of two surfaces, with parameters of each point on both sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from geosurf.arrangement.search import Contacts
from geosurf.intersect.sides import Piece, Side
from geosurf.kernels.contacts.packed_contact import n_corners
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.smooth.lift import (
    HOLD_SUM,
    HOLD_UA,
    HOLD_UB,
    HOLD_VA,
    HOLD_VB,
)
from geosurf.model import Curves, TriSurface

_ON_RIM = 1e-9


@dataclass(eq=False)
class Line:
    """One curve of a pair of sides, local frame; `bound` inf where a part is not known."""

    points: np.ndarray
    closed: bool
    bound: float
    places: list[tuple[str, np.ndarray, float]] = field(default_factory=list)


@dataclass(eq=False)
class Strand:
    """Plain curves, one after the other, with parameters of each point on both sides.

    Attributes
    ----------
    start : ndarray, shape (n, 3)
        Plain points, local.
    offsets : ndarray of int64, shape (n_curve + 1,)
    w : ndarray, shape (n, 4)
        Parameters as in `geosurf.kernels.smooth.lift`.
    tri : ndarray of int64, shape (n,)
        Triangle of the second side that holds the segment from each point on.
    hold : ndarray of int64, shape (n,)
        What is held there; -1 where no pair of faces is known.
    must : ndarray of int64, shape (n,)
        1 for points that cannot be left out: ends, and sides of triangles.
    """

    start: np.ndarray
    offsets: np.ndarray
    w: np.ndarray
    tri: np.ndarray
    hold: np.ndarray
    must: np.ndarray


def strand_of(
    plain: Curves, contacts: Contacts, pieces: tuple[Piece, Piece], sides: Sequence[Side]
) -> Strand:
    """Plain curves with the parameters of their points."""
    rows = np.concatenate(plain.curves)
    offsets = np.append(0, np.cumsum([len(curve) for curve in plain.curves]))
    start = plain.local[rows]

    faces = _faces_of_segments(plain, contacts, rows, offsets)
    known = faces[:, 0] >= 0
    w = np.zeros((len(rows), 4))
    hold = np.where(known, 0, -1)
    must = np.zeros(len(rows), dtype=np.int64)

    # The ends of each curve stay in the result; ends of open curves may lie on a rim of a side.
    first, last = offsets[:-1], offsets[1:] - 1
    ends = np.concatenate([first, last])
    must[ends] = 1
    ends = ends[~np.tile(plain.closed, 2)]
    tri = np.zeros(len(rows), dtype=np.int64)
    # The second side first: where both have a rim at a point, that of the first side is held.
    for k in (1, 0):
        side, piece = sides[k], pieces[k]
        face = np.where(known, faces[:, k], 0)
        weights = _weights(piece.surface, side.origin, face, start)
        # Parameters of a lattice count columns and rows, so a corner has whole numbers.
        if side.smooth:
            corners = piece.node_of_vertex[piece.surface.triangles[face]]
            n_row, n_col = side.z.shape
            w[:, 2 * k] = (weights * (corners % n_col)).sum(axis=1)
            w[:, 2 * k + 1] = (weights * (corners // n_col)).sum(axis=1)
            # On the rim, the parameter across it is fixed and only the one along it is solved for.
            for axis, top in ((0, n_col - 1), (1, n_row - 1)):
                u = w[ends, 2 * k + axis]
                rim = ends[(np.minimum(u, top - u) < _ON_RIM) & known[ends]]
                w[rim, 2 * k + axis] = np.round(w[rim, 2 * k + axis])
                hold[rim] = (HOLD_UA, HOLD_VA)[axis] if k == 0 else (HOLD_UB, HOLD_VB)[axis]
        # Parameters of a triangle are its second and third weight. A point on an edge (a weight of
        # 0) stays there, as the next triangle begins with it.
        else:
            tri = piece.cell_of_triangle[face]
            w[:, 2:] = weights[:, 1:]
            for corner, what in ((0, HOLD_SUM), (1, HOLD_UB), (2, HOLD_VB)):
                side_points = (np.abs(weights[:, corner]) < _ON_RIM) & known
                hold[side_points] = what
                must[side_points] = 1
    return Strand(start, offsets, w, tri, hold, must)


def _faces_of_segments(
    plain: Curves, contacts: Contacts, rows: np.ndarray, offsets: np.ndarray
) -> np.ndarray:
    """Faces (n, 2) of both pieces that make the segment from each point on; -1: none (overlaps).

    The last point of a curve takes the faces of the segment before it.
    """
    two = n_corners(contacts.rows) == 2
    lines, ids = contacts.rows[two], contacts.ids[two, :2]

    # Points of the curves and of the contacts are compared by place, not by row.
    number, count = weld(np.concatenate([plain.local, contacts.x]))
    of_point, of_id = number[: len(plain.local)], number[len(plain.local) :]
    ends = np.sort(of_id[ids], axis=1)
    keys = ends[:, 0] * count + ends[:, 1]

    # Segments as one sorted key each, for look-ups.
    order = np.argsort(keys, kind="stable")
    keys = keys[order]

    # The segment that leaves each point, as a key of the same kind.
    here = of_point[rows]
    onward = np.arange(len(rows))
    onward[offsets[1:] - 1] -= 1  # the last point of a curve
    ends = np.sort(np.stack([here[onward], here[onward + 1]], axis=1), axis=1)
    wanted = ends[:, 0] * count + ends[:, 1]

    at = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
    faces = np.full((len(rows), 2), -1, dtype=np.int64)
    if len(keys):
        found = keys[at] == wanted
        # The first column is to be the first surface.
        pair = lines[order[at[found]], :2]
        swap = contacts.surface_of_face[pair[:, 0]] > 0
        pair[swap] = pair[swap][:, ::-1]
        faces[found] = contacts.key_of_face[pair]  # of lists: keys are rows
    return faces


def _weights(
    surface: TriSurface, origin: np.ndarray, face: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """Barycentric coordinates (n, 3) of points in the planes of triangles."""
    a, b, c = ((surface.vertices - origin)[surface.triangles[face, k]] for k in range(3))

    # Normal equations of x = a + s u + t v, with Cramer's rule on the Gram matrix.
    u, v, d = b - a, c - a, x - a
    uu, uv, vv = ((p * q).sum(axis=1) for p, q in ((u, u), (u, v), (v, v)))
    du, dv = (d * u).sum(axis=1), (d * v).sum(axis=1)

    size = uu * vv - uv * uv
    s, t = (du * vv - dv * uv) / size, (dv * uu - du * uv) / size
    return np.stack([1 - s - t, s, t], axis=1)
