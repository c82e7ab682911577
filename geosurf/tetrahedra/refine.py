"""Faces with edges of at most some length: they are halved, so that neighbours stay neighbours."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from geosurf.tetrahedra.boundary import Boundary
from geosurf.tetrahedra.flat import FlatParts, flat_parts, flipped, pairs_of, spaced

# parts of a face by its halved edges, rows of (a, b, c, middle of ab, of bc, of ca); turned
# so that the halved edges come first, and with two of them the shorter diagonal is chosen
ONE = np.array([[3, 1, 2], [3, 2, 0]])
TWO = np.array([[[3, 1, 4], [0, 3, 4], [0, 4, 2]], [[3, 1, 4], [0, 3, 2], [3, 4, 2]]])
THREE = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])


def refined(boundary: Boundary, size: float = math.inf) -> Boundary:
    """
    Flip edges of flat parts, and halve all edges longer than a size, until none is left.

    An edge is halved for all faces around it, so that the boundary of each unit stays closed. The
    middle is rounded to float64. Inside flat parts only edges are halved whose middles are half a
    size apart from other points; then edges are flipped until they are Delaunay. A few there stay
    longer, by less than half. Shapes change by rounding only.

    Parameters
    ----------
    boundary : Boundary
    size : float
        [m]; by default no edge is halved, and edges of flat parts are flipped only.
    """
    x, faces = boundary.x, boundary.faces
    parent = np.arange(len(faces))
    key = np.column_stack([boundary.surface, boundary.sides])
    kind = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    parts = flat_parts(x, faces, kind, size if math.isfinite(size) else 0.0)
    faces = flipped(x, faces, parts)
    while True:
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        square = np.square(x[edges[:, 0]] - x[edges[:, 1]]).sum(axis=1)
        long = square > size**2
        key = edges[:, 0] * len(x) + edges[:, 1]
        long[long] = np.isin(key[long], _chosen(x, faces, parts, key, square, size))
        if not long.any():
            break

        # one middle for each edge
        keys, number = np.unique(key[long], return_inverse=True)
        middle = np.full(len(edges), -1)
        middle[long] = len(x) + number
        x = np.concatenate([x, 0.5 * (x[keys // len(x)] + x[keys % len(x)])])
        faces, source = _split(x, faces, middle.reshape(-1, 3), np.arange(len(faces)))
        parent, parts = parent[source], replace(parts, of_face=parts.of_face[source])
        faces = flipped(x, faces, parts)
    return replace(
        boundary,
        x=x,
        faces=faces,
        sides=boundary.sides[parent],
        surface=boundary.surface[parent],
    )


def _chosen(
    x: np.ndarray, faces: np.ndarray, parts: FlatParts, key: np.ndarray, square: np.ndarray,
    size: float,
) -> np.ndarray:  # fmt: skip
    """Keys of the long edges to halve: all, but inside flat parts only those that are apart."""
    one, other, i, _ = pairs_of(faces, len(x))
    inside = (parts.of_face[one] >= 0) & (parts.of_face[one] == parts.of_face[other])
    edge = 3 * one[inside] + i[inside]
    within = key[edge]
    rest = np.setdiff1d(key[square > size**2], within)

    edge = edge[square[edge] > size**2]
    if len(rest) or not len(edge):
        return rest  # the borders of flat parts first
    a, b = key[edge] // len(x), key[edge] % len(x)
    middles = 0.5 * (x[a] + x[b])
    used = np.unique(faces[parts.of_face >= 0])
    chosen: np.ndarray = key[edge[spaced(middles, square[edge], x[used], 0.5 * size)]]
    return chosen


def _split(
    x: np.ndarray, faces: np.ndarray, middle: np.ndarray, parent: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Split faces at the middles of their edges; -1 where an edge stays."""
    count = (middle >= 0).sum(axis=1)
    # turned: the first edge is the halved one, or the edge before the whole one
    whole = (middle < 0).argmax(axis=1)
    turn = np.where(count == 1, (middle >= 0).argmax(axis=1), np.where(count == 2, whole + 1, 0))
    columns = (turn[:, None] + np.arange(3)) % 3
    rows = np.concatenate(
        [np.take_along_axis(faces, columns, 1), np.take_along_axis(middle, columns, 1)], axis=1
    )

    # of two diagonals the shorter one: from the first corner, or to the last
    two = np.flatnonzero(count == 2)
    length = [np.square(x[rows[two, i]] - x[rows[two, j]]).sum(axis=1) for i, j in ((0, 4), (3, 2))]
    other = length[0] > length[1]
    parts = [
        (np.flatnonzero(count == 0), np.array([[0, 1, 2]])),
        (np.flatnonzero(count == 1), ONE),
        (two[~other], TWO[0]),
        (two[other], TWO[1]),
        (np.flatnonzero(count == 3), THREE),
    ]
    made = np.concatenate([rows[of][:, part].reshape(-1, 3) for of, part in parts])
    source = np.concatenate([np.repeat(of, len(part)) for of, part in parts])
    order = np.argsort(source, kind="stable")
    return made[order], parent[source[order]]
