"""Closed bodies from grids, for packages that know solids only."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geosurf.model import Lattice


def body_below(lattice: Lattice, box: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """
    Return vertices and triangles of what lies below a grid, down to the bottom of a box.

    Parameters
    ----------
    lattice : Lattice
        Without holes; it ends where the box does.
    box : (west, east, south, north, bottom, top)
        [m]

    Returns
    -------
    vertices : ndarray of float64, shape (n_vertex, 3)
        [m]
    triangles : ndarray of int64, shape (n_triangle, 3)
        Closed, normals outward; the grid's own triangles are the first ones.

    Examples
    --------
    >>> lattice = Lattice(np.array([0.0, 2.0]), np.array([0.0, 3.0]), np.zeros((2, 2)))
    >>> vertices, triangles = body_below(lattice, (0, 2, 0, 3, -4, 1))
    >>> shell_volume(vertices, triangles)
    24.0
    """

    def down(rim: np.ndarray) -> np.ndarray:
        """Points of a rim, moved down to the floor of the box."""
        return np.column_stack([rim[:, :2], np.full(len(rim), float(box[4]))])

    return _close(lattice, down)


def body_beside(lattice: Lattice, box: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """
    Return vertices and triangles of what lies east of a fault grid, to well beyond a box.

    Parameters
    ----------
    lattice : Lattice
        Without holes; it reaches beyond the box.
    box : (west, east, south, north, bottom, top)
        [m]

    Returns
    -------
    vertices, triangles
        As for `body_below`.

    Examples
    --------
    >>> x, y, z = np.zeros((2, 2)), np.array([[0.0, 3.0]] * 2), np.array([[0.0] * 2, [-1.0] * 2])
    >>> vertices, triangles = body_beside(Lattice(x, y, z, True, False), (0, 2, 0, 3, -4, 1))
    >>> shell_volume(vertices, triangles)
    12.0
    """
    far = float(box[1] + (box[1] - box[0]))

    def east(rim: np.ndarray) -> np.ndarray:
        """Points of a rim, moved far to the east."""
        return np.column_stack([np.full(len(rim), far), rim[:, 1:]])

    return _close(lattice, east)


def _close(
    lattice: Lattice, moved: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """A grid, walls from its rim to a moved copy of the rim, and a fan over that."""
    n_row, n_col = lattice.shape
    vertices, triangles = lattice.build_vertices(), lattice.build_triangles()
    number = np.arange(n_row * n_col).reshape(n_row, n_col)
    rim = np.concatenate([number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[:0:-1, 0]])
    other = moved(vertices[rim])
    a, b = rim, np.roll(rim, -1)
    c = len(vertices) + np.arange(len(rim))
    d, middle = np.roll(c, -1), np.full(len(rim), len(vertices) + len(rim))
    # along the grid's own edges the other way round
    if not _runs_with(triangles, a[0], b[0]):
        a, b, c, d = b, a, d, c
    walls = [np.stack(t, axis=1) for t in ((b, a, c), (b, c, d), (d, c, middle))]
    vertices = np.concatenate([vertices, other, other.mean(axis=0)[None]])
    triangles = np.concatenate([triangles, *walls])
    if shell_volume(vertices, triangles) < 0:
        triangles = triangles[:, [0, 2, 1]]
    return np.ascontiguousarray(vertices), np.ascontiguousarray(triangles)


def _runs_with(triangles: np.ndarray, a: int, b: int) -> bool:
    """Whether a triangle has the edge from a to b."""
    return bool(((triangles == a) & (np.roll(triangles, -1, axis=1) == b)).any())


def shell_volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume that a closed shell holds, positive for outward normals [m3].

    Examples
    --------
    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    >>> round(6 * shell_volume(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])), 9)
    1.0
    """
    corners = (vertices - vertices[0])[triangles]
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0)
