"""Volume between faces and a level, above it and below it: sums over triangles and runs.

A triangle that reaches across the level is cut by it. With one corner at height p above the level
and the others at q and r below it, the tip above has map area A p^2 / ((p - q) (p - r)) and mean
height p / 3. The rest of the triangle has the rest of its volume.

Letters as in `strips`, sums of two numbers as in `volumes`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW
from geosurf.kernels.meshes.volumes import _add, _first_node, _lowest, next_run, same_run
from geosurf.kernels.search.tree import RISING, TURNED


@scalar
def _tip(flat, p, q, r):
    """Six times the volume between the level and the corner at p, alone on its side of it."""
    return flat * p * (p / (p - q)) * (p / (p - r))


@scalar
def _part(flat, p, q, r):
    """Six times the volume between a triangle and the level: above it, and below it (negative).

    `flat` is twice the map area; p, q and r are the heights of the corners.
    """
    whole = flat * (p + q + r)
    if min(p, min(q, r)) >= 0.0:
        return whole, 0.0
    if max(p, max(q, r)) <= 0.0:
        return 0.0, whole

    # the corner that is alone on its side; one at the level counts to the two others
    above = (1 if p > 0.0 else 0) + (1 if q > 0.0 else 0) + (1 if r > 0.0 else 0)
    sign = 1.0 if above == 1 else -1.0
    if sign * q > 0.0:
        p, q, r = q, r, p
    elif sign * r > 0.0:
        p, q, r = r, p, q
    tip = _tip(flat, p, q, r)
    return (tip, whole - tip) if above == 1 else (whole - tip, tip)


@scalar
def _add_both(out, i, above, below):
    """Add to the sums above and below the level."""
    _add(out, i, 0, above)
    _add(out, i, 2, below)


@entry("d2 l2 l1 b1 d d2* -> .")
def volume_beside_triangles(x, t, face, asked, level, out):
    """Add to the rows (n_face, 4) of their faces six times the volume between triangles and a
    level: above it (two numbers) and below it (two numbers, negative below upper sides).
    """
    for i in range(t.shape[0]):
        if face[i] < 0 or not asked[face[i]]:
            continue
        # A canonical first corner makes the result independent of numbering.
        low = _lowest(x, t, i)
        a, b, c = t[i, low], t[i, (low + 1) % 3], t[i, (low + 2) % 3]
        ax, ay = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1]
        bx, by = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1]
        above, below = _part(ax * by - ay * bx, x[a, 2] - level, x[b, 2] - level, x[c, 2] - level)
        _add_both(out, face[i], above, below)


@entry("d1 d1 d1 l1 l2 l1 d d2* -> .")
def volume_beside_runs(p, q, r, a, runs, face, level, out):
    """Add the same for runs."""
    rising = a[RISING] != 0
    sign = -1.0 if a[TURNED] != 0 else 1.0
    for i in range(runs.shape[0]):
        (x, dx), (u, du) = _first_node(a, 0, runs[i, ROW]), _first_node(a, 0, runs[i, ROW] + 1)
        (y, dy), (v, dv) = _first_node(a, 1, runs[i, ROW]), _first_node(a, 1, runs[i, ROW] + 1)
        (z, dz), (w, dw) = _first_node(a, 2, runs[i, ROW]), _first_node(a, 2, runs[i, ROW] + 1)

        # The first cell may start with its second half.
        first, last = runs[i, FIRST], runs[i, LAST]
        j = first >> 1
        # corners 0, 1, 2, 3 around the cell: 1 and 2 are 0 and 3 of the next
        x1, y1, z1 = p[x + j * dx], q[y + j * dy], r[z + j * dz] - level
        x2, y2, z2 = p[u + j * du], q[v + j * dv], r[w + j * dw] - level
        for col in range(j, (last >> 1) + 1):
            x0, y0, z0, x3, y3, z3 = x1, y1, z1, x2, y2, z2
            x1, y1, z1 = p[x + (col + 1) * dx], q[y + (col + 1) * dy], r[z + (col + 1) * dz] - level
            x2, y2, z2 = p[u + (col + 1) * du], q[v + (col + 1) * dv], r[w + (col + 1) * dw] - level
            if 2 * col >= first:  # else the run starts with the second half
                if rising:  # 0 2 3, then 0 1 2
                    flat = (x2 - x0) * (y3 - y0) - (y2 - y0) * (x3 - x0)
                    above, below = _part(sign * flat, z0, z2, z3)
                else:  # 0 1 3, then 1 2 3
                    flat = (x1 - x0) * (y3 - y0) - (y1 - y0) * (x3 - x0)
                    above, below = _part(sign * flat, z0, z1, z3)
                _add_both(out, face[i], above, below)
            if 2 * col < last:
                if rising:
                    flat = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)
                    above, below = _part(sign * flat, z0, z1, z2)
                else:
                    flat = (x2 - x1) * (y3 - y1) - (y2 - y1) * (x3 - x1)
                    above, below = _part(sign * flat, z1, z2, z3)
                _add_both(out, face[i], above, below)


@entry("d2 l2 l1 b1 d2* -> .")
def heights_of_triangles(x, t, face, asked, out):
    """Widen the rows (n_face, 2) of their faces to the lowest and highest corner of triangles."""
    for i in range(t.shape[0]):
        if face[i] < 0 or not asked[face[i]]:
            continue
        for k in range(3):
            height = x[t[i, k], 2]
            out[face[i], 0] = min(out[face[i], 0], height)
            out[face[i], 1] = max(out[face[i], 1], height)


@entry("d1 l1 l2 l2 d2 -> d2")
def heights_of_runs(r, a, runs, runs0, known):
    """Lowest and highest node of each run (n_run, 2), in order.

    `known` has the rows of some runs (`runs0`, in order) of this lattice.
    """
    out = np.empty((runs.shape[0], 2))
    m = 0
    for i in range(runs.shape[0]):
        m = next_run(runs, i, runs0, m)
        if m < runs0.shape[0] and same_run(runs, i, runs0, m):
            out[i, 0], out[i, 1] = known[m, 0], known[m, 1]
            continue
        low, high = np.inf, -np.inf
        first, last = runs[i, FIRST], runs[i, LAST]
        for k in range(2):
            z, dz = _first_node(a, 2, runs[i, ROW] + k)

            # a half cell has one node of one of the rows: the run may end without the other
            left, right = first >> 1, (last >> 1) + 1
            if first & 1 and k == (0 if a[RISING] == 0 else 1):
                left += 1  # corner 0 (rising: 3) is of the first half only
            if not last & 1 and k == (1 if a[RISING] == 0 else 0):
                right -= 1  # corner 2 (rising: 1) is of the second half only
            for col in range(left, right + 1):
                height = r[z + col * dz]
                low, high = min(low, height), max(high, height)
        out[i, 0], out[i, 1] = low, high
    return out


@entry("d2 l1 d d2* -> .")
def widen_by_runs(ends, face, origin, out):
    """Widen the rows (n_face, 2) of their faces by those of runs, less `origin`."""
    for i in range(ends.shape[0]):
        out[face[i], 0] = min(out[face[i], 0], ends[i, 0] - origin)
        out[face[i], 1] = max(out[face[i], 1], ends[i, 1] - origin)
