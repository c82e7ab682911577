"""The points that the triangles of a list use: their bounds, and numbers for some of them."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry


@entry("l2 b1 l1* l -> l1 l")
def number_untouched(t, taken, number, first):
    """Number the points of the triangles that are not taken, and count these triangles.

    `number` has the number of each point, or -1: these points get numbers from `first` on, in
    their order, and come back. They are written to `number`, too.
    """
    n = 0
    new = np.zeros(number.shape[0], dtype=np.bool_)
    for i in range(t.shape[0]):
        if not taken[i]:
            n += 1
            for c in range(3):
                new[t[i, c]] = True
    count = 0
    points = np.empty(number.shape[0], dtype=np.int64)
    for p in range(number.shape[0]):
        if new[p] and number[p] < 0:
            number[p] = first + count
            points[count] = p
            count += 1
    return points[:count].copy(), n


@entry("d2 d2 d -> b1")
def near_lines(xy, lines, near):
    """Whether each place (x and y first) is within a distance of one of some lines (a, b, c).

    The distance from a line is a x + b y + c.
    """
    out = np.zeros(xy.shape[0], dtype=np.bool_)
    for i in range(xy.shape[0]):
        for k in range(lines.shape[0]):
            if abs(lines[k, 0] * xy[i, 0] + lines[k, 1] * xy[i, 1] + lines[k, 2]) <= near:
                out[i] = True
                break
    return out
