"""Whether the curves of a smooth lattice and of its triangles with a mesh are the same in number.

Let F be the height of points of the mesh above the lattice. Its zeros are the curves: those of the
triangles for a linear lattice, smooth ones for local cubics. Both are ends of a family of functions
with slopes in one range. If none of the family has a critical point where it may be zero, all have
the same number of curves: none appears that the triangles do not show. Critical points are

- in a triangle: where it may be parallel to the lattice;
- on an edge: where F may be level along it, and does not rise on one side and fall on the other;
- at a corner: where F does not change its sign twice around it, or once at the border of the mesh;
- on a rim of the lattice: the same along the line in which the mesh crosses it.

The test is for steep meshes and gentle lattices: one range of slopes is taken for all cells under
the mesh. The range holds cubics: they differ from slopes and heights of chords by known parts of
second differences. No critical point is missed; what cannot be excluded counts as one.

Notation
    p, q      slopes of the lattice along x and y
    range_    lowest and highest p and q (4,)
    box       of the lattice (6,): lower corner, upper corner
    v, t      corners (n, 3) and triangles (n, 3) of the mesh
    edges     ends, number of triangles, and opposite corners of two of these (n, 5)
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.slope_ranges import extremes, per_metre, window

_SURE = 1e-9  # of a length: more than rounding of differences


@scalar
def _sign(range_, dx, dy, dz):
    """Whether F rises (1) or falls (-1) in a direction for all slopes; 0: may be level."""
    low = dz - max(range_[0] * dx, range_[1] * dx) - max(range_[2] * dy, range_[3] * dy)
    high = dz - min(range_[0] * dx, range_[1] * dx) - min(range_[2] * dy, range_[3] * dy)
    sure = _SURE * (abs(dx) + abs(dy) + abs(dz))
    return 1 if low > sure else -1 if high < -sure else 0


@scalar
def _sign_between(range_, v, a, b):
    """`_sign` from corner a to corner b."""
    return _sign(range_, v[b, 0] - v[a, 0], v[b, 1] - v[a, 1], v[b, 2] - v[a, 2])


@scalar
def _is_near(box, v, a, b, c):
    """Whether the box of three corners and that of the lattice have a point in common."""
    for k in (2, 0, 1):  # most triangles of a fault are above or below
        if min(v[a, k], min(v[b, k], v[c, k])) > box[3 + k]:
            return False
        if max(v[a, k], max(v[b, k], v[c, k])) < box[k]:
            return False
    return True


@scalar
def _normal(v, a, b, c):
    """Normal of a triangle."""
    ux, uy, uz = v[b, 0] - v[a, 0], v[b, 1] - v[a, 1], v[b, 2] - v[a, 2]
    wx, wy, wz = v[c, 0] - v[a, 0], v[c, 1] - v[a, 1], v[c, 2] - v[a, 2]
    return uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx


@scalar
def _meets_rim(box, v, a, b, c, k):
    """Whether three corners meet a rim of the lattice across axis k (0, 1), near its heights."""
    corners = (a, b, c)
    for side in (0, 3):
        n, level = 0, box[side + k]
        low, high, left, right = np.inf, -np.inf, np.inf, -np.inf
        for i in range(3):
            one, two = corners[i], corners[(i + 1) % 3]
            before, after = v[one, k] - level, v[two, k] - level
            if before != 0.0 and not (before < 0.0) != (after < 0.0):
                continue
            part = before / (before - after) if before != after else 0.0
            z = v[one, 2] + part * (v[two, 2] - v[one, 2])
            along = v[one, 1 - k] + part * (v[two, 1 - k] - v[one, 1 - k])
            low, high, left, right = min(low, z), max(high, z), min(left, along), max(right, along)
            n += 1
        wide = _SURE * (abs(high) + abs(right))
        if n > 0 and low - wide <= box[5] and high + wide >= box[2]:
            if left - wide <= box[4 - k] and right + wide >= box[1 - k]:
                return True
    return False


@scalar
def _is_steady(range_, box, v, a, b, c):
    """Whether F has no critical point in a triangle, nor on a rim inside it."""
    nx, ny, nz = _normal(v, a, b, c)
    # the part of the vertical in the triangle has to rise for all slopes
    one, two = nz * nx, nz * ny
    least = nx * nx + ny * ny
    least += min(one * range_[0], one * range_[1]) + min(two * range_[2], two * range_[3])
    if not least > _SURE * (nx * nx + ny * ny + nz * nz):
        return False
    if _meets_rim(box, v, a, b, c, 0) and _sign(range_, 0.0, nz, -ny) == 0:
        return False
    return not (_meets_rim(box, v, a, b, c, 1) and _sign(range_, -nz, 0.0, nx) == 0)


@scalar
def _edges_of(t, near, n):
    """Edges of some triangles."""
    size = 16
    while size < 6 * n:
        size *= 2
    slots, edges, found = np.full(size, -1, dtype=np.int64), np.empty((3 * n, 5), np.int64), 0
    for k in range(n):
        for side in range(3):
            one, two = t[near[k], side], t[near[k], (side + 1) % 3]
            a, b = min(one, two), max(one, two)
            at = (a * 73856093 + b * 19349663) & (size - 1)
            while slots[at] >= 0:
                if edges[slots[at], 0] == a and edges[slots[at], 1] == b:
                    break
                at = (at + 1) & (size - 1)
            row = slots[at]
            if row < 0:
                row = slots[at] = found
                edges[row, 0], edges[row, 1], edges[row, 2], found = a, b, 0, found + 1
            if edges[row, 2] < 2:
                edges[row, 3 + edges[row, 2]] = t[near[k], (side + 2) % 3]
            edges[row, 2] += 1
    return edges[:found]


@scalar
def _sign_into(range_, v, a, b, c, k):
    """`_sign` from edge a-b into the triangle with corner c: across the edge, or along the rim
    across axis k (0, 1); 0 also where that runs along the edge.
    """
    ex, ey, ez = v[b, 0] - v[a, 0], v[b, 1] - v[a, 1], v[b, 2] - v[a, 2]
    dx, dy, dz = v[c, 0] - v[a, 0], v[c, 1] - v[a, 1], v[c, 2] - v[a, 2]
    part = (dx * ex + dy * ey + dz * ez) / (ex * ex + ey * ey + ez * ez)
    mx, my, mz = dx - part * ex, dy - part * ey, dz - part * ez
    if k < 0:
        return _sign(range_, mx, my, mz)
    nx, ny, nz = _normal(v, a, b, c)
    rx, ry, rz = (0.0, nz, -ny) if k == 0 else (-nz, 0.0, nx)
    into = rx * mx + ry * my + rz * mz
    if not into * into > _SURE * (rx * rx + ry * ry + rz * rz) * (mx * mx + my * my + mz * mz):
        return 0
    return _sign(range_, rx, ry, rz) * (1 if into > 0.0 else -1)


@scalar
def _edge_is_steady(range_, box, v, edge, changes, at_border):
    """Whether F has no critical point on an edge; counts changes of its sign at the ends."""
    a, b, n, one, two = edge[0], edge[1], edge[2], edge[3], edge[4]
    level = _sign_between(range_, v, a, b) == 0
    if n == 1:
        at_border[a] += 1
        at_border[b] += 1
        on_rim = _meets_rim(box, v, a, b, b, 0) or _meets_rim(box, v, a, b, b, 1)
        return not (_is_near(box, v, a, b, b) and (level or on_rim))
    if not _is_near(box, v, a, b, b):
        return True
    if n > 2:
        return False
    for k in range(2):
        if _meets_rim(box, v, a, b, b, k):
            up, down = _sign_into(range_, v, a, b, one, k), _sign_into(range_, v, a, b, two, k)
            if up * down != -1:
                return False
    if not level:
        return True
    up, down = _sign_into(range_, v, a, b, one, -1), _sign_into(range_, v, a, b, two, -1)
    if up * down != -1:
        return False
    for k in range(2):
        end = edge[k]
        if not _is_near(box, v, end, end, end):
            continue
        if _sign_between(range_, v, end, one) != up or _sign_between(range_, v, end, two) != down:
            return False
        changes[end] += 1
    return True


@entry("d2 d2 d2 d2 l2 -> l")
def rises_steadily(x, y, z, v, t):
    """1 if cubics of a lattice with straight axes have no curve with a mesh that its triangles do
    not show; 0 if they may have.

    Nothing is said about cells next to absent nodes, nor about what touches.
    """
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(v.shape[0]):
        for k in range(3):
            low[k], high[k] = min(low[k], v[i, k]), max(high[k], v[i, k])
    m, n, dx = window(x[0], low[0], high[0])
    i, j, dy = window(y[:, 0], low[1], high[1])
    if dx == 0.0 or dy == 0.0:
        return 0
    if n < m or j < i:
        return 1
    range_, box, heights = np.empty(4), np.empty(6), np.empty(2)
    extremes(z, i, j, m, n, range_, heights)
    box[2], box[5] = heights
    if not math.isfinite(range_.sum() + box[2] + box[5]):
        return 0
    per_metre(range_, 0, dx)
    per_metre(range_, 2, dy)
    last, top = x[0, x.shape[1] - 1], y[y.shape[0] - 1, 0]
    box[0], box[3] = min(x[0, 0], last), max(x[0, 0], last)
    box[1], box[4] = min(y[0, 0], top), max(y[0, 0], top)

    near, n_near = np.empty(t.shape[0], dtype=np.int64), 0
    for k in range(t.shape[0]):
        if _is_near(box, v, t[k, 0], t[k, 1], t[k, 2]):
            if not _is_steady(range_, box, v, t[k, 0], t[k, 1], t[k, 2]):
                return 0
            near[n_near] = k
            n_near += 1
    changes, at_border = np.zeros((2, v.shape[0]), dtype=np.int64)
    edges = _edges_of(t, near, n_near)
    for k in range(edges.shape[0]):
        if not _edge_is_steady(range_, box, v, edges[k], changes, at_border):
            return 0
    for k in range(n_near):
        for side in range(3):
            a, b, c = t[near[k], side], t[near[k], (side + 1) % 3], t[near[k], (side + 2) % 3]
            if _is_near(box, v, a, a, a):
                one, two = _sign_between(range_, v, a, b), _sign_between(range_, v, a, c)
                if one == 0 and two == 0:
                    return 0
                changes[a] += 1 if one * two == -1 else 0
    for k in range(n_near):
        for side in range(3):
            a = t[near[k], side]
            if _is_near(box, v, a, a, a):
                border = at_border[a]
                if not ((border == 0 and changes[a] == 2) or (border == 2 and changes[a] == 1)):
                    return 0
    return 1
