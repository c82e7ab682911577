"""Where can two surfaces meet? Bounds of local cubics over blocks of cells, then cell by cell.

A cubic between nodes leaves their range by a known part of it: 4-point weights add up to 1, and
their absolute values to 1.25 at most in the middle and 1.632 at the rim, so that a tensor product
stays within ``range * (1.25**2 - 1) / 2``, and at the rim ``range * (1.632**2 - 1) / 2``, of
the lowest and the highest node of its stencil. Taken are the nodes less their mean slope over the
block, which cubics reproduce: what is left is small where a surface is smooth. The same holds for
coordinates along any direction, since a sum of cubics is a cubic. Over blocks this is what the
pyramid keeps; over single cells, Bernstein coefficients bound the cubic and hold its corners, so
that triangles of the plain surface are inside as well. What is excluded here holds neither a
contact of the cubics nor one of the triangles.

Letters as in `patch`; boxes (n, 6) lower, upper; nets (n, 4, 4, 3) Bernstein coefficients.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels._jit import entry, scalar

BLOCK = 8
_INSIDE = (1.25**2 - 1) / 2
_AT_RIM = (1.632**2 - 1) / 2
SLACK = 1e-9  # [m], above the rounding of coefficients


@scalar
def _stencils(n, first, last):
    """Nodes that stencils of some cells in a row of n nodes reach, and whether one is shifted.

    A shifted stencil reaches one node farther in.
    """
    shifted = first == 0 or last == n - 1
    return max(min(first - 1, n - 4), 0), min(max(last + 2, 4), n), shifted


@scalar
def _bounds(low, high, shifted, du, dv, across, along):
    """Bounds of cubics from those of nodes less a slope; the wrong way round if there is none."""
    if high < low:
        return low, high
    more = (_AT_RIM if shifted else _INSIDE) * (high - low) + SLACK
    du, dv = du * across, dv * along
    return (
        low + min(du, 0.0) + min(dv, 0.0) - more,
        high + max(du, 0.0) + max(dv, 0.0) + more,
    )


@scalar
def _slopes(a, b, c, d, across, along):
    """What the first of four corners is, and mean slopes; zeros if a corner is absent."""
    du, dv = 0.5 * (b - a + d - c) / across, 0.5 * (c - a + d - b) / along
    if not math.isfinite(du + dv):
        return 0.0, 0.0
    return du, dv


@scalar
def span_of(q, n_row, n_col, r0, r1, c0, c1):
    """Bounds of one coordinate over the cubics of cells, rows r0 to r1 and columns c0 to c1."""
    k, m = (0 if q.shape[0] == 1 else 1), (0 if q.shape[1] == 1 else 1)
    i0, i1, down = _stencils(n_row, r0, r1)
    j0, j1, beside = _stencils(n_col, c0, c1)
    du, dv = _slopes(q[k * r0, m * c0], q[k * r0, m * c1], q[k * r1, m * c0], q[k * r1, m * c1],
                     c1 - c0, r1 - r0)  # fmt: skip
    if k == 0:  # all rows are alike
        i0, i1 = r0, r0 + 1
    if m == 0:
        j0, j1 = c0, c0 + 1
    low, high = np.inf, -np.inf
    for i in range(i0, i1):
        for j in range(j0, j1):
            value = q[k * i, m * j] - dv * (i - r0) - du * (j - c0)
            # written so that a node that is absent changes nothing
            if value < low:
                low = value
            if value > high:
                high = value
    return _bounds(low, high, down or beside, du, dv, c1 - c0, r1 - r0)


@scalar
def span_along(x, y, z, r0, r1, c0, c1, p, q, r):
    """Bounds of p x + q y + r z over the cubics of cells, rows r0 to r1 and columns c0 to c1."""
    k, m = (0 if x.shape[0] == 1 else 1), (0 if y.shape[1] == 1 else 1)
    i0, i1, down = _stencils(z.shape[0], r0, r1)
    j0, j1, beside = _stencils(z.shape[1], c0, c1)
    du, dv = _slopes(
        p * x[k * r0, c0] + q * y[r0, m * c0] + r * z[r0, c0],
        p * x[k * r0, c1] + q * y[r0, m * c1] + r * z[r0, c1],
        p * x[k * r1, c0] + q * y[r1, m * c0] + r * z[r1, c0],
        p * x[k * r1, c1] + q * y[r1, m * c1] + r * z[r1, c1],
        c1 - c0, r1 - r0,
    )  # fmt: skip
    low, high = np.inf, -np.inf
    for i in range(i0, i1):
        for j in range(j0, j1):
            value = p * x[k * i, j] + q * y[i, m * j] + r * z[i, j]
            value = value - dv * (i - r0) - du * (j - c0)
            if value < low:
                low = value
            if value > high:
                high = value
    return _bounds(low, high, down or beside, du, dv, c1 - c0, r1 - r0)


@scalar
def box_of(x, y, z, r0, r1, c0, c1, box):
    """Box around the cubics of cells into the first six of `box`."""
    n_row, n_col = z.shape
    box[0], box[3] = span_of(x, n_row, n_col, r0, r1, c0, c1)
    box[1], box[4] = span_of(y, n_row, n_col, r0, r1, c0, c1)
    box[2], box[5] = span_of(z, n_row, n_col, r0, r1, c0, c1)


@entry("d2 d2 d2 -> d2 l2")
def lattice_pyramid(x, y, z):
    """Boxes of all levels, the finest first, and (offset, n_row, n_col) of each level."""
    n_row, n_col = z.shape[0] - 1, z.shape[1] - 1
    shape = np.empty((40, 3), dtype=np.int64)
    r, c, total, n_level = (n_row + BLOCK - 1) // BLOCK, (n_col + BLOCK - 1) // BLOCK, 0, 0
    while True:
        shape[n_level] = total, r, c
        n_level += 1
        total += r * c
        if r * c == 1:
            break
        r, c = (r + 1) // 2, (c + 1) // 2
    boxes = np.empty((total, 6))
    for i in range(shape[0, 1]):
        for j in range(shape[0, 2]):
            r0, r1 = i * BLOCK, min(i * BLOCK + BLOCK, n_row)
            c0, c1 = j * BLOCK, min(j * BLOCK + BLOCK, n_col)
            box_of(x, y, z, r0, r1, c0, c1, boxes[i * shape[0, 2] + j])
    for level in range(1, n_level):
        before, _, below = shape[level - 1]
        for i in range(shape[level, 1]):
            for j in range(shape[level, 2]):
                box = boxes[shape[level, 0] + i * shape[level, 2] + j]
                box[:3], box[3:] = np.inf, -np.inf
                for k in range(2 * i, min(2 * i + 2, shape[level - 1, 1])):
                    for col in range(2 * j, min(2 * j + 2, below)):
                        for axis in range(3):
                            child = boxes[before + k * below + col]
                            box[axis] = min(box[axis], child[axis])
                            box[3 + axis] = max(box[3 + axis], child[3 + axis])
    return boxes, shape[:n_level].copy()


@scalar
def apart(p, q, plane):
    """Whether two boxes are apart, or the first from the plane (a, b, c, d) of the second."""
    for axis in range(3):
        # written so that an empty or undefined box is apart from all
        if not (p[axis] <= q[3 + axis] and q[axis] <= p[3 + axis]):
            return True
    middle, reach = -plane[3], SLACK
    for axis in range(3):
        middle += plane[axis] * 0.5 * (p[axis] + p[3 + axis])
        reach += abs(plane[axis]) * 0.5 * (p[3 + axis] - p[axis])
    return abs(middle) > reach


@entry("d2 l2 d2 d2 -> l2")
def block_pairs(boxes, shape, items, planes):
    """Pairs (finest block, item) whose boxes meet, item by item.

    `planes` (n_item, 4): unit normal and distance of items that are flat, zeros elsewhere.
    """
    out = np.empty((256, 2), dtype=np.int64)
    n = 0
    stack = np.empty((256, 3), dtype=np.int64)
    for item in range(items.shape[0]):
        stack[0] = shape.shape[0] - 1, 0, 0
        top = 1
        while top > 0:
            top -= 1
            level, i, j = stack[top]
            row = shape[level, 0] + i * shape[level, 2] + j
            if apart(boxes[row], items[item], planes[item]):
                continue
            if level == 0:
                if n == out.shape[0]:
                    more = np.empty((2 * n, 2), dtype=np.int64)
                    more[:n] = out
                    out = more
                out[n] = row, item
                n += 1
                continue
            for k in range(2 * i, min(2 * i + 2, shape[level - 1, 1])):
                for col in range(2 * j, min(2 * j + 2, shape[level - 1, 2])):
                    stack[top] = level - 1, k, col
                    top += 1
    return out[:n].copy()


@scalar
def shadow(net, p, q, r):
    """Bounds of p x + q y + r z over a net."""
    low, high = np.inf, -np.inf
    for k in range(4):
        for col in range(4):
            value = p * net[k, col, 0] + q * net[k, col, 1] + r * net[k, col, 2]
            if value < low:
                low = value
            if value > high:
                high = value
    return low, high


@scalar
def net_normal(net):
    """Unit vector across a net, from its diagonals; NaN if they are parallel or absent."""
    ax, ay, az = (
        net[3, 3, 0] - net[0, 0, 0],
        net[3, 3, 1] - net[0, 0, 1],
        net[3, 3, 2] - net[0, 0, 2],
    )
    bx, by, bz = (
        net[3, 0, 0] - net[0, 3, 0],
        net[3, 0, 1] - net[0, 3, 1],
        net[3, 0, 2] - net[0, 3, 2],
    )
    p, q, r = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    size = np.sqrt(p * p + q * q + r * r)
    return p / size, q / size, r / size


@scalar
def separated(one, two):
    """Whether two nets are apart along an axis or along one of their own normals."""
    for axis in range(5):
        if axis < 3:
            p, q, r = 1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2)
        else:
            p, q, r = net_normal(one) if axis == 3 else net_normal(two)
            if not np.isfinite(p + q + r):
                continue
        low, high = shadow(one, p, q, r)
        floor, ceiling = shadow(two, p, q, r)
        if low > ceiling + SLACK or floor > high + SLACK:
            return True
    return False
