"""Volume below, area and bounds of faces: sums over triangles and over runs of a lattice.

The volume between a triangle and a level is its map area times its mean height. Over a closed shell
these add up to the volume inside. A sum is kept as two numbers; the second collects all rounding
errors of the first (Knuth's two-sum; Ogita, Rump & Oishi 2005). The volume kernels compute neither
square roots nor bounds, because volumes are requested most often.

Letters as in `strips`. Each row belongs to the face `face[row]`. Heights are measured from a level,
to preserve digits.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, load
from geosurf.kernels.meshes.checks import two_sum
from geosurf.kernels.search.tree import RISING, TURNED


@scalar
def _lowest(x, t, i):
    """Corner of a triangle that comes first by its coordinates, independent of its numbering."""
    low = 0
    for corner in range(1, 3):
        # Lexicographic comparison of coordinates.
        for k in range(3):
            if x[t[i, corner], k] != x[t[i, low], k]:
                if x[t[i, corner], k] < x[t[i, low], k]:
                    low = corner
                break
    return low


@entry("d2 l2 l1 b1 d d2* -> .")
def volume_below_triangles(x, t, face, asked, level, out):
    """Add six times the volume between triangles and a level (two numbers), and twice their map
    area, to the rows (n_face, 3) of their faces; negative where normals look down.
    """
    for i in range(t.shape[0]):
        if face[i] < 0 or not asked[face[i]]:
            continue
        # A canonical first corner makes the result independent of numbering.
        low = _lowest(x, t, i)
        a, b, c = t[i, low], t[i, (low + 1) % 3], t[i, (low + 2) % 3]
        ax, ay = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1]
        bx, by = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1]
        flat = ax * by - ay * bx
        # Twice the map area times three times the mean height: six times the volume.
        two_sum(out, face[i], 0, flat * ((x[a, 2] - level) + (x[b, 2] - level) + (x[c, 2] - level)))
        out[face[i], 2] += flat


@scalar
def _first_node(a, axis, row):
    """Offset of a coordinate of the first node of a row, and the step to the next."""
    return a[3 * axis] + row * a[3 * axis + 1], a[3 * axis + 2]


@scalar
def _volume_below_run(p, q, r, a, run, level):
    """The same for one run: the sum, its rounding errors, and twice the map area.

    Cell by cell: two corners of each are those of the previous cell.
    """
    rising = a[RISING] != 0
    (x, dx), (u, du) = _first_node(a, 0, run[ROW]), _first_node(a, 0, run[ROW] + 1)
    (y, dy), (v, dv) = _first_node(a, 1, run[ROW]), _first_node(a, 1, run[ROW] + 1)
    (z, dz), (w, dw) = _first_node(a, 2, run[ROW]), _first_node(a, 2, run[ROW] + 1)

    # The first cell may start with its second half.
    first, last = run[FIRST], run[LAST]
    j = first >> 1
    # corners 0, 1, 2, 3 around the cell: 1 and 2 are 0 and 3 of the next
    x1, y1, z1 = p[x + j * dx], q[y + j * dy], r[z + j * dz] - level
    x2, y2, z2 = p[u + j * du], q[v + j * dv], r[w + j * dw] - level
    high = low = flat = 0.0
    for col in range(j, (last >> 1) + 1):
        x0, y0, z0, x3, y3, z3 = x1, y1, z1, x2, y2, z2
        x1, y1, z1 = p[x + (col + 1) * dx], q[y + (col + 1) * dy], r[z + (col + 1) * dz] - level
        x2, y2, z2 = p[u + (col + 1) * du], q[v + (col + 1) * dv], r[w + (col + 1) * dw] - level
        if rising:  # 0 2 3, then 0 1 2
            one = (x2 - x0) * (y3 - y0) - (y2 - y0) * (x3 - x0)
            two = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)
            term, then = one * (z0 + z2 + z3), two * (z0 + z1 + z2)
        else:  # 0 1 3, then 1 2 3
            one = (x1 - x0) * (y3 - y0) - (y1 - y0) * (x3 - x0)
            two = (x2 - x1) * (y3 - y1) - (y2 - y1) * (x3 - x1)
            term, then = one * (z0 + z1 + z3), two * (z1 + z2 + z3)
        if 2 * col < first:  # the run starts with the second half
            one = term = 0.0
        if 2 * col == last:
            two = then = 0.0
        flat += one + two

        # Two-sum of both halves, with local variables.
        total = high + term
        back = total - high
        low += (high - (total - back)) + (term - back)
        high = total + then
        back = high - total
        low += (total - (high - back)) + (then - back)
    return high, low, flat


@entry("d1 d1 d1 l1 l2 d -> d2")
def volume_below_runs(p, q, r, a, runs, level):
    """Rows (n_run, 3) of runs, in order: six times the volume between each and a level (two
    numbers), and twice its map area, before the lattice is turned.
    """
    out = np.empty((runs.shape[0], 3))
    for i in range(runs.shape[0]):
        out[i, 0], out[i, 1], out[i, 2] = _volume_below_run(p, q, r, a, runs[i], level)
    return out


@entry("l1 d2 l1 d2* -> .")
def add_runs(a, sums, face, out):
    """Add the rows of `volume_below_runs` to the rows (n_face, 3) of their faces."""
    sign = -1.0 if a[TURNED] != 0 else 1.0
    for i in range(sums.shape[0]):
        # The sum of a run joins that of its face, with its sign and its rounding errors.
        two_sum(out, face[i], 0, sign * sums[i, 0])
        out[face[i], 1] += sign * sums[i, 1]
        out[face[i], 2] += sign * sums[i, 2]


@scalar
def _extend(out, i, c):
    """Add the triangle with corners c to row i: area, bounds, and its map area."""
    ax, ay, az = c[1, 0] - c[0, 0], c[1, 1] - c[0, 1], c[1, 2] - c[0, 2]
    bx, by, bz = c[2, 0] - c[0, 0], c[2, 1] - c[0, 1], c[2, 2] - c[0, 2]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    two_sum(out, i, 0, 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz))
    # Columns 8 and 10: areas that look up and down.
    two_sum(out, i, 8 if nz > 0.0 else 10, abs(nz))
    for k in range(3):
        out[i, 2 + k] = min(out[i, 2 + k], min(c[0, k], min(c[1, k], c[2, k])))
        out[i, 5 + k] = max(out[i, 5 + k], max(c[0, k], max(c[1, k], c[2, k])))


@entry("d2 l2 l1 b1 d2* -> .")
def extent_triangles(x, t, face, asked, out):
    """Add to the rows (n_face, 12): area (two numbers), lower and upper corner of triangles, twice
    the area in the map of those that look up (two numbers) and of those that look down (two).
    """
    c = np.empty((3, 3))
    for i in range(t.shape[0]):
        if face[i] < 0 or not asked[face[i]]:
            continue
        low = _lowest(x, t, i)
        for corner in range(3):
            for k in range(3):
                c[corner, k] = x[t[i, (low + corner) % 3], k]
        _extend(out, face[i], c)


@scalar
def _sum(high, low, term):
    """A sum of two numbers with one more term, as `two_sum` does it."""
    total = high + term
    back = total - high
    return total, low + ((high - (total - back)) + (term - back))


@scalar
def _area(ax, ay, az, bx, by, bz, cx, cy, cz):
    """Area of a triangle, and twice its area in the map, above 0 where it looks up."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz), nz


@scalar
def _widen(out, i, x, y, z):
    """Make the bounds of row i hold a point."""
    out[i, 2], out[i, 3] = min(out[i, 2], x), min(out[i, 3], y)
    out[i, 4], out[i, 5] = min(out[i, 4], z), max(out[i, 5], x)
    out[i, 6], out[i, 7] = max(out[i, 6], y), max(out[i, 7], z)


@scalar
def _extend_by_run(p, q, r, a, row, first, last, origin, out, f, up):
    """Add a run to row f; sums are kept in local variables, and each node is loaded once."""
    rising, down = a[RISING] != 0, 18 - up
    high, low = out[f, 0], out[f, 1]
    up_high, up_low, down_high, down_low = (
        out[f, up],
        out[f, up + 1],
        out[f, down],
        out[f, down + 1],
    )
    begin, end = first >> 1, last >> 1

    # nodes 0, 1, 2, 3 around a cell
    dx, dy, dz = origin[0], origin[1], origin[2]
    x1, x2 = load(p, a, 0, row, begin) - dx, load(p, a, 0, row + 1, begin) - dx
    y1, y2 = load(q, a, 1, row, begin) - dy, load(q, a, 1, row + 1, begin) - dy
    z1, z2 = load(r, a, 2, row, begin) - dz, load(r, a, 2, row + 1, begin) - dz
    west, south, bottom = np.inf, np.inf, np.inf
    east, north, top = -np.inf, -np.inf, -np.inf
    for col in range(begin, end + 1):
        x0, y0, z0, x3, y3, z3 = x1, y1, z1, x2, y2, z2
        x1, x2 = load(p, a, 0, row, col + 1) - dx, load(p, a, 0, row + 1, col + 1) - dx
        y1, y2 = load(q, a, 1, row, col + 1) - dy, load(q, a, 1, row + 1, col + 1) - dy
        z1, z2 = load(r, a, 2, row, col + 1) - dz, load(r, a, 2, row + 1, col + 1) - dz

        # triangles 0 1 2 and 0 2 3, or 0 1 3 and 1 2 3; places come in the other order where
        # diagonals rise
        if rising:
            area, flat = _area(x0, y0, z0, x2, y2, z2, x3, y3, z3)
            then, level = _area(x0, y0, z0, x1, y1, z1, x2, y2, z2)
        else:
            area, flat = _area(x0, y0, z0, x1, y1, z1, x3, y3, z3)
            then, level = _area(x1, y1, z1, x2, y2, z2, x3, y3, z3)
        if 2 * col >= first:
            high, low = _sum(high, low, area)
            if flat > 0.0:
                up_high, up_low = _sum(up_high, up_low, abs(flat))
            else:
                down_high, down_low = _sum(down_high, down_low, abs(flat))
        if 2 * col < last:
            high, low = _sum(high, low, then)
            if level > 0.0:
                up_high, up_low = _sum(up_high, up_low, abs(level))
            else:
                down_high, down_low = _sum(down_high, down_low, abs(level))

        # inside the run both nodes of a column are corners of a triangle
        if col > begin:
            west, east = min(west, min(x0, x3)), max(east, max(x0, x3))
            south, north = min(south, min(y0, y3)), max(north, max(y0, y3))
            bottom, top = min(bottom, min(z0, z3)), max(top, max(z0, z3))
        if col == begin and 2 * col == first:
            _widen(out, f, x0, y0, z0)
            _widen(out, f, x3, y3, z3)
        elif col == begin and rising:
            _widen(out, f, x0, y0, z0)
        elif col == begin:
            _widen(out, f, x3, y3, z3)
        if col == end and 2 * col < last:
            _widen(out, f, x1, y1, z1)
            _widen(out, f, x2, y2, z2)
        elif col == end and rising:
            _widen(out, f, x2, y2, z2)
        elif col == end:
            _widen(out, f, x1, y1, z1)
    if end > begin:
        _widen(out, f, west, south, bottom)
        _widen(out, f, east, north, top)
    out[f, 0], out[f, 1] = high, low
    out[f, up], out[f, up + 1] = up_high, up_low
    out[f, down], out[f, down + 1] = down_high, down_low


@entry("d1 d1 d1 l1 l2 l1 d1 d2* -> .")
def extent_runs(p, q, r, a, runs, face, origin, out):
    """Add the same for runs; `origin` is subtracted from their nodes."""
    up = 10 if a[TURNED] != 0 else 8
    for i in range(runs.shape[0]):
        row, first, last = runs[i, ROW], runs[i, FIRST], runs[i, LAST]
        _extend_by_run(p, q, r, a, row, first, last, origin, out, face[i], up)


# ---- level volumes ----------------------------------------
# Volume between faces and a level, above it and below it: sums over triangles and runs.
#
# A triangle that reaches across the level is cut by it. With one corner at height p above the level
# and the others at q and r below it, the tip above has map area A p^2 / ((p - q) (p - r)) and mean
# height p / 3. The rest of the triangle has the rest of its volume.
#
# Letters as in `strips`, sums of two numbers as in `volumes`.


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
    two_sum(out, i, 0, above)
    two_sum(out, i, 2, below)


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
