"""Where surfaces coincide: overlap areas and their outlines, from the exact arrangement.

An overlap's outline is a curve, the edges inside it are not. Both surfaces of a pair are rebuilt
around their contacts, those of each with itself included: where one crosses itself, both are cut
alike only then. Triangles that both then have are the overlap, edges that both have are
candidates, and those with overlap on both sides are inside. Of a surface that lies on itself, the
candidates are the pieces of its contacts in a line.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geosurf.contact.arrange import Children, cut_contacts
from geosurf.contact.search import Contacts, find_contacts
from geosurf.errors import InvariantError
from geosurf.intersect.collinear import split_overlaps
from geosurf.intersect.link import line_contacts, pairs_of_rows
from geosurf.kernels.mesh import edges, pieces
from geosurf.kernels.packed import in_plane, n_corners
from geosurf.model import Touch


@dataclass
class Overlap:
    """What two surfaces share where they coincide over areas."""

    local: np.ndarray
    segments: np.ndarray
    inside: np.ndarray
    touches: list[Touch]


def arranged_faces(contacts: Contacts, children, surface: int) -> tuple[np.ndarray, np.ndarray]:
    """Faces of one surface after cutting (rows of `children.x`), and the faces they are part of."""
    uncut = np.ones(len(contacts.t), dtype=bool)
    uncut[children.cut] = False
    uncut &= contacts.surface_of_face == surface
    mine = contacts.surface_of_face[children.parent] == surface
    faces = np.concatenate([contacts.t[uncut], children.triangles[mine]])
    return faces, np.concatenate([np.flatnonzero(uncut), children.parent[mine]])


def _edge_keys(t: np.ndarray, n: int) -> np.ndarray:
    """Keys (n_triangle, 3) of the edges of triangles."""
    ends = np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=2), axis=2)
    return ends[:, :, 0] * n + ends[:, :, 1]


def overlap_of(surfaces, i: int, j: int, origin: np.ndarray) -> Overlap:
    """Overlap areas, outline and curves of surfaces i and j, in the frame of `origin`."""
    pair = (surfaces[i], surfaces[j]) if i != j else (surfaces[i],)
    contacts, children, one, two, shared = _arranged(pair)
    if shared is None:
        raise InvariantError(
            f"an overlap of {pair[0].name!r} and {pair[-1].name!r} is not the same triangles in "
            "both; please report this with the surfaces."
        )
    local = children.x + (contacts.origin - origin)
    n = len(local)
    if i != j:
        common = np.intersect1d(_edge_keys(one, n), _edge_keys(two, n))
    else:
        ends = np.sort(_pieces_of_lines(contacts, children, one), axis=1)
        common = ends[:, 0] * n + ends[:, 1]
    inner, times = np.unique(_edge_keys(shared, n), return_counts=True)
    outline = np.union1d(common, inner[times == 1])
    keys = np.setdiff1d(outline, inner[times > 1])
    segments = np.stack([keys // n, keys % n], axis=1)
    return Overlap(local, segments, np.unique(shared), _areas(local, origin, shared, (i, j)))


def _pieces_of_lines(contacts: Contacts, children: Children, faces: np.ndarray) -> np.ndarray:
    """Where a surface meets itself in a line: the edges of its pieces along it, rows (n, 2)."""
    lines, surfaces = line_contacts(contacts, pairs_of_rows(contacts))
    arranged = replace(contacts, x=children.x, d=children.d, m=children.m)
    points = np.unique(faces)
    stops = np.column_stack([np.zeros((len(points), 2), dtype=np.int64), points])
    return split_overlaps(arranged, lines, surfaces, stops)[0]


def _arranged(pair):
    """Both surfaces cut, and the triangles that both have; None for those if a contact over an
    area has none of them.
    """
    contacts = find_contacts(pair, pairs=[(0, 0), (0, 1), (1, 1)] if len(pair) == 2 else [(0, 0)])
    children = cut_contacts(contacts)
    one, of_one = arranged_faces(contacts, children, 0)
    if len(pair) == 1:
        corners, count = np.unique(np.sort(one, axis=1), axis=0, return_counts=True)
        return contacts, children, one, one, corners[count > 1]
    two, of_two = arranged_faces(contacts, children, 1)
    corners, number = np.unique(
        np.sort(np.concatenate([one, two]), axis=1), axis=0, return_inverse=True
    )
    piece_one, piece_two = np.split(number.ravel(), [len(one)])
    both = np.intersect1d(piece_one, piece_two)
    rows = contacts.rows
    area = in_plane(rows) & (n_corners(rows) >= 3)
    area &= contacts.surface_of_face[rows[:, 0]] != contacts.surface_of_face[rows[:, 1]]
    mine, others = _pieces(of_one, piece_one), _pieces(of_two, piece_two)
    complete = all(mine[f] & others[g] for f, g in rows[area, :2].tolist())
    return contacts, children, one, two, corners[both] if complete else None


def _pieces(faces: np.ndarray, pieces: np.ndarray) -> dict[int, set[int]]:
    """Pieces of each face; a surface folded onto itself has one piece in several faces."""
    found: dict[int, set[int]] = {}
    for face, piece in zip(faces.tolist(), pieces.tolist(), strict=True):
        found.setdefault(face, set()).add(piece)
    return found


def _areas(local, origin, shared, pair) -> list[Touch]:
    """One `Touch` for each connected overlap area, largest first."""
    ring, _ = edges(shared, len(local))
    piece, count = pieces(shared, ring)
    a, b, c = (local[shared[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    touches = []
    for p in range(count):
        rows = np.flatnonzero(piece == p)
        keys, times = np.unique(_edge_keys(shared[rows], len(local)), return_counts=True)
        rim = keys[times == 1]
        points = local[np.unique(np.concatenate([rim // len(local), rim % len(local)]))] + origin
        points = points[np.lexsort(points.T[::-1])]
        touches.append(Touch("area", pair, points, float(area[rows].sum())))
    return sorted(touches, key=lambda touch: (-touch.area, touch.points[0].tolist()))
