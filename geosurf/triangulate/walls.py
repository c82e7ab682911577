"""The walls of the model: the six sides of a box, or a fence around an area of interest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from geosurf.conventions import place
from geosurf.errors import InputError
from geosurf.model import TriSurface
from geosurf.model.expected import SIDES, box_of_sides
from geosurf.triangulate.outline import check_outline, triangulate_ring

# corner i of the box is east, north, top where bit 0, 1, 2 of i is set; each row is
# one side, seen from outside counter-clockwise
_CORNERS = {
    "west": (0, 4, 6, 2),
    "east": (1, 3, 7, 5),
    "south": (0, 1, 5, 4),
    "north": (2, 6, 7, 3),
    "bottom": (0, 2, 3, 1),
    "top": (4, 5, 7, 6),
}


def build_walls(box: Sequence[float], aoi: Any = None) -> list[TriSurface]:
    """Return the walls of the model as surfaces: the six sides of a box, or a fence.

    Parameters
    ----------
    box : (west, east, south, north, bottom, top)
        World coordinates [m], elevation positive up.
    aoi : array_like of float, shape (n, 2), optional
        Area of interest: easting and northing around a polygon inside the box, which
        need not be convex. The model is then what lies inside it, from bottom to top of the box.

    Returns
    -------
    list of TriSurface
        Role "wall", normals out of the model: ``west``, ``east``, ``south``, ``north``,
        ``bottom`` and ``top``, in this order, two triangles each; or ``aoi`` (two vertical
        triangles for each side of the polygon), ``bottom`` and ``top``.

    Raises
    ------
    InputError
        If the box does not have six finite numbers, or is not in order; if the polygon crosses
        itself, has holes, or leaves the box.

    Examples
    --------
    >>> walls = build_walls((0, 4000, 0, 3000, -2500, -1500))
    >>> [wall.name for wall in walls]
    ['west', 'east', 'south', 'north', 'bottom', 'top']
    >>> walls[0].bounds
    (0.0, 0.0, 0.0, 3000.0, -2500.0, -1500.0)
    >>> corner = [(0, 0), (4000, 0), (4000, 1000), (1000, 1000), (1000, 3000), (0, 3000)]
    >>> [wall.n_triangle for wall in build_walls((0, 4000, 0, 3000, -2500, -1500), corner)]
    [12, 4, 4]
    """
    limits = box_of_sides(box).reshape(3, 2)
    if aoi is not None:
        return _fence(check_outline(aoi), limits)

    # corner i: bit 0 of i is east, bit 1 north, bit 2 top
    corners = np.array([[limits[axis, (i >> axis) & 1] for axis in range(3)] for i in range(8)])
    halves = [[0, 1, 2], [0, 2, 3]]
    return [
        TriSurface(side, "wall", corners[list(_CORNERS[side])], np.array(halves)) for side in SIDES
    ]


def _fence(ring: np.ndarray, limits: np.ndarray) -> list[TriSurface]:
    """Upright walls along a ring, and the caps between them."""
    # Each corner has to lie inside the box; `out` is the outward direction on the axis.
    for axis, sides in enumerate((("west", "east"), ("south", "north"))):
        for corner in ring:
            for side, limit, out in zip(sides, limits[axis], (-1.0, 1.0), strict=True):
                if out * (corner[axis] - limit) > 0:
                    raise InputError(
                        f"aoi: corner {place(corner)} lies beyond the {side} of the box "
                        f"({limit:.1f} m). Enlarge the box, or leave it out."
                    )

    # The ring is counter-clockwise, so these quads face outwards.
    n = len(ring)
    low, high = (np.column_stack([ring, np.full(n, z)]) for z in limits[2])
    here, there = np.arange(n), (np.arange(n) + 1) % n
    strips = [np.stack([here, there, there + n], 1), np.stack([here, there + n, here + n], 1)]

    faces = triangulate_ring(ring)
    return [
        TriSurface("aoi", "wall", np.concatenate([low, high]), np.concatenate(strips)),
        TriSurface("bottom", "wall", low, faces[:, ::-1]),
        TriSurface("top", "wall", high, faces),
    ]
