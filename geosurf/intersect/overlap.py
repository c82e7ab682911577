"""Where surfaces coincide: overlap areas and their outlines, from the exact arrangement.

An overlap's outline is a curve, the edges inside it are not. Both surfaces of a pair are
rebuilt around their contacts; triangles that both then have are the overlap, edges that both have
are candidates, and those with overlap on both sides are inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.contact.arrange import cut_contacts
from geosurf.contact.search import Contacts, find_contacts
from geosurf.kernels.mesh import edges, pieces
from geosurf.model import Touch


@dataclass
class Overlap:
    """What two surfaces share where they coincide over areas."""

    local: np.ndarray
    segments: np.ndarray
    inside: np.ndarray
    touches: list[Touch]


def arranged_faces(contacts: Contacts, children, surface: int) -> np.ndarray:
    """Candidate faces of one surface after cutting: rows of `children.x`."""
    uncut = np.ones(len(contacts.t), dtype=bool)
    uncut[children.cut] = False
    uncut &= contacts.surface_of_face == surface
    mine = contacts.surface_of_face[children.parent] == surface
    return np.concatenate([contacts.t[uncut], children.triangles[mine]])


def _edge_keys(t: np.ndarray, n: int) -> np.ndarray:
    """Keys (n_triangle, 3) of the edges of triangles."""
    ends = np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=2), axis=2)
    return ends[:, :, 0] * n + ends[:, :, 1]


def overlap_of(surfaces, i: int, j: int, origin: np.ndarray, **options) -> Overlap:
    """Overlap areas, outline and curves of surfaces i and j, in the frame of `origin`."""
    pair = (surfaces[i], surfaces[j]) if i != j else (surfaces[i],)
    contacts = find_contacts(pair, pairs=[(0, len(pair) - 1)], **options)
    children = cut_contacts(contacts)
    local = children.x + (contacts.origin - origin)
    one = arranged_faces(contacts, children, 0)
    two = arranged_faces(contacts, children, len(pair) - 1)
    n = len(local)
    corners_one, corners_two = np.sort(one, axis=1), np.sort(two, axis=1)
    both = np.concatenate([np.unique(corners_one, axis=0), np.unique(corners_two, axis=0)])
    if i == j:
        both = corners_one
    shared, count = np.unique(both, axis=0, return_counts=True)
    shared = shared[count > 1]
    common = np.intersect1d(_edge_keys(one, n), _edge_keys(two, n)) if i != j else np.empty(0, int)
    inner, times = np.unique(_edge_keys(shared, n), return_counts=True)
    inside = inner[times > 1]
    outline = np.union1d(common, inner[times == 1])
    keys = np.setdiff1d(outline, inside)
    segments = np.stack([keys // n, keys % n], axis=1)
    return Overlap(local, segments, np.unique(shared), _areas(local, origin, shared, (i, j)))


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
