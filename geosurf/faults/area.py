"""What of the faults lies inside an area of interest, not necessarily convex.

Fence, bottom and top have cut all faults, so that each piece lies on one side of them. Which, is
the exact sign of the turn around an edge of the cut from the wall to the piece, as for the sides
of a main fault: normals of walls point out of the model. A piece that meets no wall is where any
of its vertices is, by counting the sides of the area north of it, in fractions.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.faults.distance import open_edges
from geosurf.faults.sides import adjacency
from geosurf.model import Patches

FRONT, BACK = 0, 1


def inside_area(patches: Patches, walls: np.ndarray) -> np.ndarray:
    """
    Find the triangles that lie inside the walls of a model.

    Parameters
    ----------
    patches : Patches
        Surfaces and the walls that have cut them.
    walls : ndarray of int64
        Rows of the walls' triangles: closed, normals out of the model.

    Returns
    -------
    ndarray of bool, shape (n_triangle,)
        False for the walls, and for triangles that lie in one.

    Raises
    ------
    GeometryError
        If a piece goes through the walls without being cut.

    Examples
    --------
    >>> from geosurf import TriSurface, build_walls, rebuild_surfaces
    >>> corners = [[-1, 1, -3], [9, 1, -3], [9, 1, 3], [-1, 1, 3]]
    >>> fault = TriSurface("F1", "fault", corners, [[0, 1, 2], [0, 2, 3]])
    >>> ring = [(0, 0), (4, 0), (4, 4), (0, 4)]
    >>> patches = rebuild_surfaces([fault, *build_walls((0, 4, 0, 4, -2, 2), ring)])
    >>> walls = np.flatnonzero(patches.surface_of_triangle > 0)
    >>> found = patches.triangles[inside_area(patches, walls)]
    >>> east = patches.vertices[found][:, :, 0]
    >>> float(east.min()), float(east.max())
    (0.0, 4.0)
    """
    # surfaces one at a time: pieces of one do not touch pieces of another
    inside = np.zeros(patches.n_triangle, dtype=bool)
    is_wall = np.zeros(patches.n_triangle, dtype=bool)
    is_wall[walls] = True
    for i in range(len(patches.sources)):
        rows = np.flatnonzero((patches.surface_of_triangle == i) & ~is_wall)
        if len(rows):
            inside[rows] = _of_one(patches, rows, walls)
    return inside


def _of_one(patches: Patches, rows: np.ndarray, walls: np.ndarray) -> np.ndarray:
    """Which triangles of one surface lie inside, bool (n,)."""
    # (n_piece, 2): whether a piece meets the front and the back of a wall; normals of walls point
    # out, so inside is behind
    beside = adjacency(patches, rows, walls, strict=False)
    held = beside.beside[:, BACK] & ~beside.within
    odd = np.flatnonzero(held & beside.beside[:, FRONT])
    if len(odd):
        at = patches.triangles[rows[np.flatnonzero(beside.piece == odd[0])[0]], 0]
        where = patches.vertices[at]
        name = patches.names[int(patches.surface_of_triangle[rows[0]])]
        raise GeometryError(
            f"fault {name!r} lies inside and outside of the area of interest at once, near "
            f"{place(where)}: its walls are not closed there. Give all that build_walls returns.",
            place=tuple(where.tolist()), surfaces=(name,),
        )  # fmt: skip

    # pieces that no wall cuts are inside or outside as a whole: one vertex decides
    alone = ~beside.beside.any(axis=1) & ~beside.within
    for piece in np.flatnonzero(alone).tolist():
        first = rows[np.flatnonzero(beside.piece == piece)[0]]
        held[piece] = _holds(patches, walls, patches.local[patches.triangles[first, 0]])
    return held[beside.piece]


def _holds(patches: Patches, walls: np.ndarray, point: np.ndarray) -> bool:
    """Whether a point that is on no wall lies inside: by the sides of the area north of it."""
    x = patches.local
    used = x[patches.triangles[walls]].reshape(-1, 3)

    # strictly between bottom and top: a piece on no wall cannot lie in them
    if not used[:, 2].min() < point[2] < used[:, 2].max():
        return False

    # triangles of the bottom, whose open edges are the outline of the area in the map
    level = walls[(x[patches.triangles[walls], 2] == used[:, 2].min()).all(axis=1)]
    rim = open_edges(patches.triangles[level], len(x))

    # crossing parity along a ray to the north, in fractions: no rounding near the outline.
    # Half-open in easting, so that a corner counts for one of its two edges
    px, py = Fraction(float(point[0])), Fraction(float(point[1]))
    count = 0
    for a, b in x[rim][:, :, :2].tolist():
        (ax, ay), (bx, by) = sorted(map(tuple, (a, b)))
        if ax <= point[0] < bx:
            ax, ay, bx, by = map(Fraction, (ax, ay, bx, by))
            count += ay + (by - ay) * (px - ax) / (bx - ax) > py
    return count % 2 == 1
