"""On which side of a fault another one leaves their common curve: an exact sign.

Notation
    d        direction of an edge of the curve, from its vertex with the lower number
    way      +1 where a triangle runs along d, -1 where it runs back
    n        normal of the input triangle that a triangle is a part of
    h        way n x d: from the edge into the triangle

Turning around d, counter-clockwise, from triangle a of the main fault one is on its front where a
runs along d. So the question is whether c comes before the main fault's other triangle b in this
turn. The sine of the angle from i to j has the sign of (h_i x h_j) . d, that is of way_i way_j
(n_i x n_j) . d; as n_i x n_j is parallel to d, one component decides. The cosine has the sign of
way_i way_j n_i . n_j. Only input coordinates enter, no constructed point: the method of
`geosurf.kernels.meshes.seams`, for two surfaces. Floats decide where they can, fractions
elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError, SurfaceError
from geosurf.kernels.meshes.mesh import edge_keys, edges, pieces
from geosurf.model import Patches
from geosurf.model.surfaces import exact_normal

_BOUND = 2e-15  # of the sum of magnitudes: the rounding of a determinant of normals
_TINY = 1e-250


@dataclass(frozen=True)
class Adjacency:
    """Position of a fault relative to a main fault.

    Attributes
    ----------
    piece : ndarray of int64, shape (n,)
        For each triangle of the fault: its connected piece once the main fault has cut it.
    beside : ndarray of bool, shape (n_piece, 2)
        Whether each piece meets the front (column 0) and the back of the main fault.
    within : ndarray of bool, shape (n_piece,)
        Pieces that lie in the main fault: they coincide with it.
    edges : ndarray of int64, shape (n_edge, 2)
        Vertices of the edges where the two meet.
    half_edges, edge_of_half : ndarray of int64, shape (n_half,)
        Half-edges of the fault there (3 * triangle + corner), and the edge that each runs along.
    across_walls : ndarray of int64, shape (n, 2)
        Pieces that only a wall of the model box parts.
    """

    piece: np.ndarray
    beside: np.ndarray
    within: np.ndarray
    edges: np.ndarray
    half_edges: np.ndarray
    edge_of_half: np.ndarray
    across_walls: np.ndarray


def _keys(t: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Number of the edge and way of each half-edge of triangles."""
    start, end = t.ravel(), np.roll(t, -1, axis=1).ravel()
    return edge_keys(t, n), np.where(start < end, 1, -1)


def adjacency(
    patches: Patches,
    fault: np.ndarray,
    main: np.ndarray,
    walls: np.ndarray | None = None,
    *,
    strict: bool = True,
) -> Adjacency:
    """Find the pieces of a fault and the sides of a main fault on which they lie.

    Parameters
    ----------
    patches : Patches
        Of both faults, and perhaps others.
    fault, main : ndarray of int64
        Rows of their triangles.
    walls : ndarray of int64, optional
        Rows of the walls of the model box, which cut the fault into pieces, too.
    strict : bool
        False leaves edges out where the main fault has no two sides; True raises.

    Returns
    -------
    Adjacency

    Raises
    ------
    SurfaceError
        If the triangles of the main fault do not agree about their front.
    GeometryError
        If more than two sheets of the main fault meet on the curve.
    """
    # for each half-edge of the fault the triangles of the main fault along the same edge
    n = len(patches.local)
    tf, tm = patches.triangles[fault], patches.triangles[main]
    key_f, way_f = _keys(tf, n)
    key_m, way_m = _keys(tm, n)
    order = np.argsort(key_m, kind="stable")

    # the run of half-edges of the main fault with this key: `first` and the number of `sheets`
    first = np.searchsorted(key_m[order], key_f, side="left")
    sheets = np.searchsorted(key_m[order], key_f, side="right") - first
    half = np.flatnonzero(sheets > 0)
    twin = _coincident(tf, tm)

    # pieces: neighbours across a half-edge, unless the main fault or a wall is in between
    ring, _ = edges(tf, n)
    at_wall = np.zeros(0, dtype=np.int64)
    if walls is not None and len(walls):
        at_wall = np.flatnonzero(np.isin(key_f, _keys(patches.triangles[walls], n)[0]))
    beyond = np.setdiff1d(at_wall, half)
    neighbours = np.stack([beyond // 3, ring[beyond] // 3], axis=1)
    ring[half] = half
    ring[beyond] = beyond
    piece, n_piece = pieces(tf, ring)
    within = np.zeros(n_piece, dtype=bool)
    within[piece[twin]] = True

    # where the main fault has one triangle only, it ends: that edge has no sides
    pairs = half[(sheets[half] >= 2) & ~twin[half // 3]]
    a, b = order[first[pairs]], order[first[pairs] + 1]

    # no two sides: more than two sheets, or two that run the same way along the edge
    odd = (sheets[pairs] > 2) | (way_m[a] == way_m[b])
    if strict:
        _refuse_sheets(patches, main, tf, pairs[odd], sheets[pairs[odd]])
    pairs, a, b = pairs[~odd], a[~odd], b[~odd]

    # which side each of these triangles leaves on, exactly; a piece has the sides of all of them
    c_before_b = _between(
        patches, fault[pairs // 3], way_f[pairs], main[a // 3], way_m[a], main[b // 3], way_m[b],
        key_f[pairs],
    )  # fmt: skip

    # the turn starts at a; it runs through the front where a runs along d
    front = c_before_b == (way_m[a] > 0)
    beside = np.zeros((n_piece, 2), dtype=bool)
    beside[piece[pairs // 3], np.where(front, 0, 1)] = True

    found, edge_of_half = np.unique(key_f[half], return_inverse=True)
    ends = np.stack(np.divmod(found, n), axis=1)
    return Adjacency(piece, beside, within, ends, half, edge_of_half, piece[neighbours])


def _refuse_sheets(
    patches: Patches, main: np.ndarray, tf: np.ndarray, half: np.ndarray, sheets: np.ndarray
) -> None:
    """Refuse a main fault that has no two sides along the curve."""
    if len(half) == 0:
        return
    name = patches.names[int(patches.surface_of_triangle[main[0]])]
    where = patches.vertices[tf[half[0] // 3, half[0] % 3]]
    if sheets[0] > 2:
        raise GeometryError(
            f"fault {name!r} has {sheets[0]} sheets at {place(where)}, so that it has no two sides "
            "there. Cut it into faults of their own.",
            place=where,
            surfaces=(name,),
        )
    raise SurfaceError(
        f"fault {name!r}: its triangles do not agree about their front at {place(where)}. Pass it "
        "through triangulate_fault, which turns them.",
        place=where,
        surfaces=(name,),
    )


def _coincident(tf: np.ndarray, tm: np.ndarray) -> np.ndarray:
    """Which triangles of a fault have the corners of one of the main fault."""
    both = np.sort(np.concatenate([tf, tm]), axis=1)
    _, number = np.unique(both, axis=0, return_inverse=True)
    return np.isin(number[: len(tf)], number[len(tf) :])


def _between(
    patches: Patches,
    c: np.ndarray,
    way_c: np.ndarray,
    a: np.ndarray,
    way_a: np.ndarray,
    b: np.ndarray,
    way_b: np.ndarray,
    key: np.ndarray,
) -> np.ndarray:
    """Whether triangles c come before b, turning from a around the edges `key`."""
    # the key is lower vertex * n + higher vertex
    u, v = np.divmod(key, len(patches.local))
    d = patches.local[v] - patches.local[u]

    # the component of the cross product that is farthest from 0 gives its sign safely
    axis = np.abs(d).argmax(axis=1)
    heading = np.sign(d[np.arange(len(d)), axis]).astype(np.int64)
    normals = _Normals(patches)

    def sine(i: np.ndarray, way_i: np.ndarray, j: np.ndarray, way_j: np.ndarray) -> np.ndarray:
        """Sign of the sine of the angle from sheet i to sheet j around the edge."""
        return way_i * way_j * heading * normals.cross_sign(i, j, axis)

    def half(j: np.ndarray, way_j: np.ndarray) -> np.ndarray:
        """Whether sheet j lies half a turn or more after sheet a."""
        s = sine(a, way_a, j, way_j)
        ahead = way_a * way_j * normals.dot_sign(a, j) > 0
        return np.where(s != 0, s < 0, ~ahead)

    # first by half turns, then by the sine within the same half: no angle is ever computed
    half_c, half_b = half(c, way_c), half(b, way_b)
    return np.where(half_c != half_b, ~half_c, sine(c, way_c, b, way_b) > 0)


class _Normals:
    """Exact signs of products of the normals of input triangles."""

    def __init__(self, patches: Patches) -> None:
        self.patches = patches
        self.offset = np.cumsum([0] + [s.n_triangle for s in patches.sources])

    def corners(self, rows: np.ndarray) -> np.ndarray:
        """Corners (n, 3, 3) of the input triangles of some triangles."""
        surface = self.patches.surface_of_triangle[rows]
        out = np.empty((len(rows), 3, 3))
        for i in np.unique(surface):
            source, mine = self.patches.sources[i], surface == i
            faces = source.triangles[self.patches.parent_of_triangle[rows[mine]]]
            out[mine] = source.vertices[faces] - self.patches.origin
        return out

    def _floats(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normals (n, 3), the magnitudes of their terms (n, 3), corners."""
        corners = self.corners(rows)

        # each component is the difference of two products; their sizes bound its rounding
        p, q = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        one, two = p[:, [1, 2, 0]] * q[:, [2, 0, 1]], p[:, [2, 0, 1]] * q[:, [1, 2, 0]]
        return one - two, np.abs(one) + np.abs(two), corners

    def cross_sign(self, i: np.ndarray, j: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """Sign of one component of n_i x n_j, each on its own axis."""
        (p, size_p, at_p), (q, size_q, at_q) = self._floats(i), self._floats(j)
        rows = np.arange(len(i))
        k, o = (axis + 1) % 3, (axis + 2) % 3
        value = p[rows, k] * q[rows, o] - p[rows, o] * q[rows, k]
        size = size_p[rows, k] * size_q[rows, o] + size_p[rows, o] * size_q[rows, k]

        def exact(r: int) -> Fraction:
            """The same number of one row in fractions."""
            m, n = exact_normal(at_p[r]), exact_normal(at_q[r])
            return m[k[r]] * n[o[r]] - m[o[r]] * n[k[r]]

        return _signs(value, size, exact, self._same(i, j), 0)

    def dot_sign(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Sign of n_i . n_j."""
        (p, size_p, at_p), (q, size_q, at_q) = self._floats(i), self._floats(j)

        def exact(r: int) -> Fraction:
            """The same number of one row in fractions."""
            m, n = exact_normal(at_p[r]), exact_normal(at_q[r])
            return sum((f * g for f, g in zip(m, n, strict=True)), Fraction(0))

        return _signs(
            (p * q).sum(axis=1), (size_p * size_q).sum(axis=1), exact, self._same(i, j), 1
        )

    def _same(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether triangles are parts of one input triangle: their normals are equal."""
        surface, parent = self.patches.surface_of_triangle, self.patches.parent_of_triangle
        return (surface[i] == surface[j]) & (parent[i] == parent[j])


def _signs(
    value: np.ndarray,
    size: np.ndarray,
    exact: Callable[[int], Fraction],
    same: np.ndarray,
    sign_of_same: int,
) -> np.ndarray:
    """Signs of values that are known to a part of `size`; those in doubt from `exact(row)`.

    Rows that are `same` have a sign that is known: a curve mostly runs through triangles, with
    parts of one on both sides.
    """
    signs = np.where(same, sign_of_same, np.sign(value)).astype(np.int64)

    # other rows in doubt, one by one in fractions: they are rare
    sure = same | ((np.abs(value) > _BOUND * size) & (size > _TINY))
    for row in np.flatnonzero(~sure):
        number = exact(int(row))
        signs[row] = (number > 0) - (number < 0)
    return signs
