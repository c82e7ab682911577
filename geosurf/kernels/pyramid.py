"""Where can two surfaces meet? Bounds of local cubics over blocks of cells, then cell by cell.

A cubic between nodes leaves their range by a known part of it: 4-point weights add up to 1, and
their absolute values to 1.25 at most in the middle and 1.632 at the rim, so that a tensor product
stays within ``range * (1.25**2 - 1) / 2``, and at the rim ``range * (1.632**2 - 1) / 2``, of
the lowest and the highest node of its stencil. Over blocks this is what the pyramid keeps; over
single cells, Bernstein coefficients bound the cubic and hold its corners, so that triangles of
the plain surface are inside as well. What is excluded here holds neither a contact of the
cubics nor one of the triangles.

Letters as in `patch`; boxes (n, 6) lower, upper; nets (n, 4, 4, 3) Bernstein coefficients.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar

BLOCK = 8
_INSIDE = (1.25**2 - 1) / 2
_AT_RIM = (1.632**2 - 1) / 2
SLACK = 1e-9  # [m], above the rounding of coefficients


@scalar
def _range(q, r0, r1, c0, c1):
    """Least and largest value of nodes that exist."""
    low, high = np.inf, -np.inf
    if q.shape[0] == 1:
        r0, r1 = 0, 1
    if q.shape[1] == 1:
        c0, c1 = 0, 1
    for i in range(r0, r1):
        for j in range(c0, c1):
            value = q[i, j]
            if value < low:
                low = value
            if value > high:
                high = value
    return low, high


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
            r0, r1 = i * BLOCK - 1, min(i * BLOCK + BLOCK, n_row) + 2
            c0, c1 = j * BLOCK - 1, min(j * BLOCK + BLOCK, n_col) + 2
            rim = r0 < 0 or c0 < 0 or r1 > n_row + 1 or c1 > n_col + 1
            part = _AT_RIM if rim else _INSIDE
            # a shifted stencil reaches one node farther in
            r0, r1 = max(min(r0, n_row - 3), 0), min(max(r1, 4), n_row + 1)
            c0, c1 = max(min(c0, n_col - 3), 0), min(max(c1, 4), n_col + 1)
            row = i * shape[0, 2] + j
            for axis in range(3):
                low, high = _range(x if axis == 0 else (y if axis == 1 else z), r0, r1, c0, c1)
                more = part * (high - low) + SLACK if high >= low else 0.0
                boxes[row, axis], boxes[row, 3 + axis] = low - more, high + more
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
def _apart(p, q, plane):
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
            if _apart(boxes[row], items[item], planes[item]):
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
def _cast_shadow(net, p, q, r):
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
        low, high = _cast_shadow(one, p, q, r)
        floor, ceiling = _cast_shadow(two, p, q, r)
        if low > ceiling + SLACK or floor > high + SLACK:
            return True
    return False


@entry("d4 -> d2")
def net_boxes(nets):
    """Boxes of control nets; coefficients that are NaN count for nothing."""
    boxes = np.empty((nets.shape[0], 6))
    for n in range(nets.shape[0]):
        for axis in range(3):
            low, high = np.inf, -np.inf
            for k in range(4):
                for col in range(4):
                    value = nets[n, k, col, axis]
                    if value < low:
                        low = value
                    if value > high:
                        high = value
            boxes[n, axis], boxes[n, 3 + axis] = low - SLACK, high + SLACK
    return boxes


@entry("l2 d2 l1 d4 d2 l1 d4 d2 -> l2")
def near_pairs(pairs, blocks, start_a, nets_a, boxes_a, start_b, nets_b, boxes_b):
    """Pairs of patches that are not apart, from pairs of groups of patches.

    `start_a`, `start_b`: first patch of each group, and the end; `blocks`: boxes of groups b.
    """
    out = np.empty((256, 2), dtype=np.int64)
    n = 0
    none = np.zeros(4)
    for k in range(pairs.shape[0]):
        g, h = pairs[k]
        for a in range(start_a[g], start_a[g + 1]):
            if _apart(boxes_a[a], blocks[h], none):
                continue
            for b in range(start_b[h], start_b[h + 1]):
                if _apart(boxes_a[a], boxes_b[b], none) or separated(nets_a[a], nets_b[b]):
                    continue
                if n == out.shape[0]:
                    more = np.empty((2 * n, 2), dtype=np.int64)
                    more[:n] = out
                    out = more
                out[n] = a, b
                n += 1
    return out[:n].copy()
