"""Flat parts of faces, such as walls: new points may lie anywhere there, and edges may be flipped.

A wall between two horizons has as many corners as the curves on it, so that its triangles are long
needles. Halving their edges gives hundreds of thousands of smaller needles. Points a stated length
apart, and Delaunay edges between them, give few triangles of good shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ROUNDING = 64.0 * np.finfo(np.float64).eps  # of the largest coordinate: places of vertices
BEND = 1e-6  # neighbours bend no more than this [1 - cosine], before their corners are compared
STRICT = 1e-9  # an edge is flipped if the angles opposite to it exceed 180 degrees by this


@dataclass(frozen=True, eq=False)
class FlatParts:
    """Flat parts of faces.

    Attributes
    ----------
    of_face : ndarray of int64, shape (n_face,)
        Number of the part; -1 where faces are not flat.
    centre : ndarray of float64, shape (n_part, 3)
    axes : ndarray of float64, shape (n_part, 2, 3)
        Orthogonal, in the plane.
    """

    of_face: np.ndarray
    centre: np.ndarray
    axes: np.ndarray

    def in_plane(self, part: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Coordinates (n, 2) of places (n, 3) in the planes of parts (n,)."""
        found: np.ndarray = np.einsum("nij,nj->ni", self.axes[part], x - self.centre[part])
        return found


def flat_parts(x: np.ndarray, faces: np.ndarray, kind: np.ndarray, size: float) -> FlatParts:
    """
    Find parts whose corners lie on one plane, to the rounding of coordinates.

    Parameters
    ----------
    x : ndarray of float64, shape (n, 3)
    faces : ndarray of int64, shape (n_face, 3)
    kind : ndarray of int64, shape (n_face,)
        Faces of different kinds are not joined.
    size : float
        Parts without an edge longer than this are left out [m].

    Returns
    -------
    FlatParts
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    corners = x[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.sqrt(np.square(normal).sum(axis=1))
    normal /= np.where(area > 0.0, area, 1.0)[:, None]
    one, other, _, _ = pairs_of(faces, len(x))
    level = np.einsum("ij,ij->i", normal[one], normal[other]) > 1.0 - BEND
    joined = level & (kind[one] == kind[other])
    links = coo_array(
        (np.ones(int(joined.sum())), (one[joined], other[joined])), shape=(len(faces),) * 2
    )
    label = connected_components(links, directed=False)[1]

    # only parts of several faces with a long edge
    longest = np.square(corners - np.roll(corners, 1, axis=1)).sum(axis=2).max(axis=1)
    count = np.bincount(label)
    asked = np.unique(label[longest > size**2])
    order = np.argsort(label, kind="stable")
    end = np.cumsum(count)
    of_face, centres, axes = np.full(len(faces), -1), [np.zeros(3)], [np.zeros((2, 3))]
    allowed = ROUNDING * np.abs(x).max(initial=0.0)
    for part in asked[count[asked] > 1].tolist():
        rows = order[end[part] - count[part] : end[part]]
        places = x[np.unique(faces[rows])]
        centre = places.mean(axis=0)
        turned = np.linalg.svd(places - centre, full_matrices=False)[2]
        if np.abs((places - centre) @ turned[2]).max() <= allowed:
            of_face[rows] = len(centres)
            centres.append(centre)
            axes.append(turned[:2])
    return FlatParts(of_face, np.array(centres), np.array(axes))


def pairs_of(
    faces: np.ndarray, n_vertex: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return both faces of each edge that exactly two faces share, and its place in each (0..2)."""
    key = _edge_keys(faces, n_vertex)
    order = np.argsort(key, kind="stable")
    new = np.diff(key[order], prepend=-1, append=-1) != 0
    start = np.flatnonzero(new[:-1])
    start = start[np.diff(start, append=len(order)) == 2]
    one, other = order[start], order[start + 1]
    return one // 3, other // 3, one % 3, other % 3


def _held_edges(faces: np.ndarray, parts: FlatParts, n_vertex: int) -> np.ndarray:
    """Edges inside flat parts that belong to other faces, too: a thin unit ends there. They stay.

    Nearly always there are none. Flips make no others, since faces of a model meet at edges only.
    """
    flat = parts.of_face >= 0
    one, other, i, _ = pairs_of(faces[flat], n_vertex)
    of = parts.of_face[flat]
    edges = _edge_keys(faces[flat], n_vertex).reshape(-1, 3)
    inner = edges[one, i][of[one] == of[other]]
    found: np.ndarray = np.intersect1d(inner, _edge_keys(faces[~flat], n_vertex))
    return found


def _edge_keys(faces: np.ndarray, n_vertex: int) -> np.ndarray:
    """Numbers of the three edges of each face, face by face; the same for both directions."""
    return _keys(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), n_vertex)


def _keys(edges: np.ndarray, n_vertex: int) -> np.ndarray:
    """Number of each edge (n, 2)."""
    low, high = np.sort(edges, axis=1).T
    found: np.ndarray = low * n_vertex + high
    return found


def flipped(x: np.ndarray, faces: np.ndarray, parts: FlatParts) -> np.ndarray:
    """
    Flip edges inside flat parts until they are Delaunay.

    Parameters
    ----------
    x : ndarray of float64, shape (n, 3)
    faces : ndarray of int64, shape (n_face, 3)
    parts : FlatParts

    Returns
    -------
    ndarray of int64, shape (n_face, 3)
        Turned as before. The row of a face stays in its part.
    """
    rows = np.flatnonzero(parts.of_face >= 0)
    out = faces.copy()

    held = _held_edges(faces, parts, len(x))
    while len(rows):
        one, other, i, j = pairs_of(out[rows], len(x))
        one, other = rows[one], rows[other]
        inside = parts.of_face[one] == parts.of_face[other]
        if len(held):
            ends = np.stack([out[one, i], out[one, (i + 1) % 3]], axis=1)
            inside &= ~np.isin(_keys(ends, len(x)), held)
        one, other, i, j = one[inside], other[inside], i[inside], j[inside]
        a, b, c = (out[one, (i + k) % 3] for k in range(3))
        d = out[other, (j + 2) % 3]
        p, q, r, s = (parts.in_plane(parts.of_face[one], x[v]) for v in (a, b, c, d))
        side = np.sign(_cross(q - p, r - p))

        # both new faces are turned as the old ones, and the angles at c and d exceed 180 degrees
        good = (side * _sine(s - p, r - p) > STRICT) & (side * _sine(q - s, r - s) > STRICT)
        sines = side * _sine(p - r, q - r), side * _sine(q - s, p - s)
        cosines = _cosine(p - r, q - r), _cosine(q - s, p - s)
        excess = -(sines[0] * cosines[1] + sines[1] * cosines[0])
        good &= (excess > STRICT) & (out[one, i] == out[other, (j + 1) % 3])
        at = np.flatnonzero(good)
        if not len(at):
            break

        # each face takes part in one flip: that with the largest excess, of equal ones the first
        at = at[np.argsort(-excess[at], kind="stable")]
        rank = np.full(len(out), len(at))
        np.minimum.at(rank, one[at], np.arange(len(at)))
        np.minimum.at(rank, other[at], np.arange(len(at)))
        own = np.arange(len(at))
        at = at[(rank[one[at]] == own) & (rank[other[at]] == own)]
        out[one[at]] = np.stack([a[at], d[at], c[at]], axis=1)
        out[other[at]] = np.stack([d[at], b[at], c[at]], axis=1)
    return out


def spaced(
    middles: np.ndarray, lengths: np.ndarray, others: np.ndarray, least: float
) -> np.ndarray:
    """
    Choose places that are apart from each other and from other places, longest edges first.

    Parameters
    ----------
    middles : ndarray of float64, shape (n, 3)
    lengths : ndarray of float64, shape (n,)
    others : ndarray of float64, shape (m, 3)
    least : float
        Distance [m].

    Returns
    -------
    ndarray of int64
        Rows of `middles`; not all that could be chosen, but at least one if any could.
    """
    from scipy.spatial import cKDTree

    free = cKDTree(others).query(middles, distance_upper_bound=least)[0] >= least
    rows = np.flatnonzero(free)
    rows = rows[np.argsort(-lengths[rows], kind="stable")]
    if not len(rows):
        return rows

    # the first of each cube, then those without a better one nearby
    cube = np.floor(middles[rows] / least).astype(np.int64)
    rows = rows[np.sort(np.unique(cube, axis=0, return_index=True)[1])]
    close = cKDTree(middles[rows]).query_pairs(least, output_type="ndarray")
    worse = np.zeros(len(rows), dtype=bool)
    worse[close.max(axis=1, initial=0)] = len(close) > 0
    return rows[~worse]


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross products of vectors of a plane."""
    found: np.ndarray = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return found


def _sine(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Sines of the angles from a to b; 0 where one has no length."""
    found: np.ndarray = _cross(a, b) / _lengths(a, b)
    return found


def _cosine(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cosines of the angles from a to b; 0 where one has no length."""
    found: np.ndarray = (a * b).sum(axis=1) / _lengths(a, b)
    return found


def _lengths(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of the lengths of vectors; 1 where one has none."""
    found = np.hypot(*a.T) * np.hypot(*b.T)
    ones: np.ndarray = np.where(found > 0.0, found, 1.0)
    return ones


__all__ = ["FlatParts", "flat_parts", "flipped", "pairs_of", "spaced"]
