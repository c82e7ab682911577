"""Which pieces of faces are thinner than what rounding can do.

Letters as in `exact`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar

_LEAST = 1e-300  # so that nothing is divided by 0


@scalar
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@scalar
def _length(x, y, z):
    return np.sqrt(x * x + y * y + z * z)


@scalar
def _cross_of_sides(x, i, j, k):
    """Cross product of sides i-j and i-k, and the length of the longest side."""
    ax, ay, az = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
    bx, by, bz = x[k, 0] - x[i, 0], x[k, 1] - x[i, 1], x[k, 2] - x[i, 2]
    longest = max(_length(ax, ay, az), _length(bx, by, bz))
    longest = max(longest, _length(bx - ax, by - ay, bz - az))
    nx, ny, nz = _cross(ax, ay, az, bx, by, bz)
    return nx, ny, nz, longest


@entry("d2 l2 l2 d2 l2 l1 d -> b1")
def thin_children(x, t, pairs, y, children, parent, reach):
    """Children lower than `reach` over the sine of the flattest contact of their face.

    `pairs` are faces (rows of `t`, corners in `x`) in contact, none of them in one plane; corners
    of `children` are in `y`.
    """
    normal = np.empty((t.shape[0], 3))
    for i in range(t.shape[0]):
        nx, ny, nz, _ = _cross_of_sides(x, t[i, 0], t[i, 1], t[i, 2])
        size = max(_length(nx, ny, nz), _LEAST)
        normal[i, 0], normal[i, 1], normal[i, 2] = nx / size, ny / size, nz / size
    flattest = np.ones(t.shape[0])
    for row in range(pairs.shape[0]):
        i, j = pairs[row, 0], pairs[row, 1]
        nx, ny, nz = _cross(
            normal[i, 0], normal[i, 1], normal[i, 2], normal[j, 0], normal[j, 1], normal[j, 2]
        )
        sine = _length(nx, ny, nz)
        flattest[i], flattest[j] = min(flattest[i], sine), min(flattest[j], sine)
    thin = np.empty(children.shape[0], dtype=np.bool_)
    for c in range(children.shape[0]):
        nx, ny, nz, longest = _cross_of_sides(y, children[c, 0], children[c, 1], children[c, 2])
        height = _length(nx, ny, nz) / max(longest, _LEAST)
        thin[c] = not (height * flattest[parent[c]] > reach)
    return thin
