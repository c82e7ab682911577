"""Faces with edges of at most some length: edges are halved, so that neighbours stay neighbours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geosurf.tetrahedra.boundary import Boundary

# parts of a face by its halved edges, rows of (a, b, c, middle of ab, of bc, of ca); turned
# so that the halved edges come first, and with two of them the shorter diagonal is chosen
ONE = np.array([[3, 1, 2], [3, 2, 0]])
TWO = np.array([[[3, 1, 4], [0, 3, 4], [0, 4, 2]], [[3, 1, 4], [0, 3, 2], [3, 4, 2]]])
THREE = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])


def refined(boundary: Boundary, size: float) -> Boundary:
    """
    Halve all edges longer than a size, until none is left.

    An edge is halved for all faces around it, so that the boundary of each unit stays closed. The
    middle is rounded to float64.

    Parameters
    ----------
    boundary : Boundary
    size : float
        [m].
    """
    x, faces = boundary.x, boundary.faces
    parent = np.arange(len(faces))
    while True:
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        long = np.square(x[edges[:, 0]] - x[edges[:, 1]]).sum(axis=1) > size**2
        if not long.any():
            break

        # one middle for each edge
        key = edges[long, 0] * len(x) + edges[long, 1]
        keys, number = np.unique(key, return_inverse=True)
        middle = np.full(len(edges), -1)
        middle[long] = len(x) + number
        x = np.concatenate([x, 0.5 * (x[keys // len(x)] + x[keys % len(x)])])
        faces, parent = _split(x, faces, middle.reshape(-1, 3), parent)
    return replace(
        boundary,
        x=x,
        faces=faces,
        sides=boundary.sides[parent],
        surface=boundary.surface[parent],
    )


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
