"""Which pieces of faces are thinner than the displacement that rounding can cause?

A piece is thin if its height, times the sine of the flattest contact of its face, is below a limit.
Contacts of faces that are adjacent in the map, with only edges and corners in common, do not
count: the vertical plane between them meets both at an angle, and search methods differ in which
of them they list. Letters as in `exact_signs`, contacts as in `packed_contact`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.packed_contact import (
    HOW,
    TRIANGLE_A,
    TRIANGLE_B,
    lies_in_plane,
    lies_on_boundaries,
)
from geosurf.kernels.exact.predicates import orient2d

_LEAST = 1e-300  # avoids division by 0
_UPRIGHT = 2.0**-9  # faces with a smaller vertical part of the normal are nearly vertical


@scalar
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@scalar
def _cross_of_sides(x, i, j, k):
    """Cross product of sides i-j and i-k, its square, and the square of the longest side."""
    ax, ay, az = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
    bx, by, bz = x[k, 0] - x[i, 0], x[k, 1] - x[i, 1], x[k, 2] - x[i, 2]
    cx, cy, cz = bx - ax, by - ay, bz - az

    # The height of a triangle is its doubled area over the longest side.
    longest = max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz)
    longest = max(longest, cx * cx + cy * cy + cz * cz)
    nx, ny, nz = _cross(ax, ay, az, bx, by, bz)
    return nx, ny, nz, nx * nx + ny * ny + nz * nz, longest


@scalar
def _write_normals(x, t, normal):
    """Unit normals of faces."""
    for i in range(t.shape[0]):
        nx, ny, nz, square, _ = _cross_of_sides(x, t[i, 0], t[i, 1], t[i, 2])
        size = max(np.sqrt(square), _LEAST)
        normal[i, 0], normal[i, 1], normal[i, 2] = nx / size, ny / size, nz / size


@scalar
def _beyond_an_edge(x, t, m, w, i, j):
    """Whether in the map all of face j lies beyond an edge of face i, or on its line."""
    # Orientation of the face in the map.
    turn = orient2d(x, m, w, t[i, 0], t[i, 1], t[i, 2], 0, 1)
    for k in range(3):
        a, b = t[i, k], t[i, 0 if k == 2 else k + 1]

        # Corners on the line of the edge count as beyond.
        inside = False
        for c in range(3):
            p = t[j, c]
            if p != a and p != b:
                side = orient2d(x, m, w, a, b, p, 0, 1)
                inside = inside or side * turn > 0
        if not inside:
            return True
    return False


@scalar
def _counts(x, t, m, w, rows, k, normal):
    """Whether a contact can bring pieces of its faces close to each other."""
    i, j = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
    if lies_in_plane(rows[k, HOW]):
        return False

    # Nearly vertical faces and contacts inside faces always count.
    if min(abs(normal[i, 2]), abs(normal[j, 2])) < _UPRIGHT or not lies_on_boundaries(rows[k, HOW]):
        return True
    return not (_beyond_an_edge(x, t, m, w, i, j) or _beyond_an_edge(x, t, m, w, j, i))


@entry("d2 l2 l1* l1* l2 d2 l2 l1 d -> l1")
def thin_children(x, t, m, w, rows, y, children, parent, limit):
    """Rows of the thin children of faces.

    Corners of faces are in `x`, those of children in `y`; `rows` are all contacts of these faces;
    the limit is a height [m].
    """
    normal = np.empty((t.shape[0], 3))
    _write_normals(x, t, normal)

    # The flattest contact of each face, as a squared sine.
    flattest = np.ones(t.shape[0])  # squares of sines
    for k in range(rows.shape[0]):
        if _counts(x, t, m, w, rows, k, normal):
            i, j = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
            nx, ny, nz = _cross(
                normal[i, 0], normal[i, 1], normal[i, 2], normal[j, 0], normal[j, 1], normal[j, 2]
            )
            square = nx * nx + ny * ny + nz * nz
            flattest[i], flattest[j] = min(flattest[i], square), min(flattest[j], square)

    reach = limit**2

    # Squared height = squared cross product / squared longest side.
    thin = np.empty(children.shape[0], dtype=np.int64)
    n = 0
    for c in range(children.shape[0]):
        _, _, _, square, longest = _cross_of_sides(
            y, children[c, 0], children[c, 1], children[c, 2]
        )
        # Written so that NaN counts as thin.
        if not square * flattest[parent[c]] > reach * longest:  # heights are square / longest
            thin[n] = c
            n += 1
    return thin[:n].copy()
