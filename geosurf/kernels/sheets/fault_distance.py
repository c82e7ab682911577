"""Distance of a datum from a fault at its own elevation, and lattice edges that a trace cuts.

Notation
    x, y, z     a point; x and y in cells of the lattice, z in metres
    a, b        ends of the segment in which a triangle meets the level of the point
    p, q        ends of a piece of a trace, in units of 2**-22 cells: x is 2 mod 4, y is odd,
                so that no end lies on a line of the lattice or on a diagonal
    m, n        nodes at the ends of a link; kinds of links: 0 east, 1 north, 2 north-east (from
                the lower left node), 3 north-west (from the lower right node, named by its left)

Candidates come from blocks of the map: `starts` and `items` list what can be near each block. A
trace cuts a link if it crosses the link an odd number of times. Signs are those of integers; a
node on the trace counts as left of it. So a triangle has an odd number of cut edges exactly if an
end of the trace lies in it.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

UNIT = 4194304  # 2**22


@scalar
def distance_to_segment(x, y, ax, ay, bx, by):
    """Squared distance to a segment, parameter of the nearest point, and squared length."""
    tx, ty = bx - ax, by - ay
    length2 = tx * tx + ty * ty
    t = 0.0
    # A segment without length is its first end.
    if length2 > 0.0:
        t = ((x - ax) * tx + (y - ay) * ty) / length2

    # Clamp to the segment.
    t = min(1.0, max(0.0, t))
    dx, dy = x - ax - t * tx, y - ay - t * ty
    return dx * dx + dy * dy, t, length2


@scalar
def signed_offset(x, y, ax, ay, bx, by, length2):
    """Signed distance from the line of a segment, positive on its left; 0 if it is a point."""
    if length2 > 0.0:
        return ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / np.sqrt(length2)
    return 0.0


@scalar
def distance_to_box(x, y, box):
    """Squared distance to a box, 0 inside."""
    dx = max(box[0] - x, x - box[2], 0.0)
    dy = max(box[1] - y, y - box[3], 0.0)
    return dx * dx + dy * dy


@scalar
def _level_segment(corners, z):
    """Where a triangle meets a level: found, ax, ay, bx, by; half-open, so that edges agree."""
    n = 0
    ax = ay = bx = by = 0.0
    for i in range(3):
        j = (i + 1) % 3
        zi, zj = corners[3 * i + 2], corners[3 * j + 2]
        if (zi <= z) != (zj <= z):
            # Interpolate from the lower end, so that neighbours agree.
            lo, hi = (i, j) if zi < zj else (j, i)
            f = (z - corners[3 * lo + 2]) / (corners[3 * hi + 2] - corners[3 * lo + 2])
            px = corners[3 * lo] + f * (corners[3 * hi] - corners[3 * lo])
            py = corners[3 * lo + 1] + f * (corners[3 * hi + 1] - corners[3 * lo + 1])
            if n == 0:
                ax, ay = px, py
            else:
                bx, by = px, py
            n += 1
    return n == 2, ax, ay, bx, by


@entry("d2 l1 d2 d2 d2 l1 l1 d -> d1 d1")
def distance_at_elevation(points, block, corners, boxes, normals, starts, items, reach):
    """Distance (n,) of points to a fault at their own elevation, and side (n,): +1, -1, 0 if far.

    `corners` (m, 9), `boxes` in the map and horizontal `normals` (m, 2) of the fault's triangles.
    """
    n = points.shape[0]
    far = np.full(n, reach)
    side = np.zeros(n)

    # Elevation range of each triangle.
    low, high = np.empty(corners.shape[0]), np.empty(corners.shape[0])
    for f in range(corners.shape[0]):
        low[f] = min(corners[f, 2], corners[f, 5], corners[f, 8])
        high[f] = max(corners[f, 2], corners[f, 5], corners[f, 8])
    for k in range(n):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        best, lead = reach * reach, -1.0
        for at in range(starts[block[k]], starts[block[k] + 1]):
            f = items[at]
            if z < low[f] or z >= high[f]:  # half-open, as `_level_segment` is
                continue
            # A box is never farther than its triangle; the margin covers rounding.
            if distance_to_box(x, y, boxes[f]) > best * (1.0 + 1e-8):
                continue

            # The segment at this level, and its distance in the map.
            found, ax, ay, bx, by = _level_segment(corners[f], z)
            if not found:
                continue
            d2, _, length2 = distance_to_segment(x, y, ax, ay, bx, by)
            if d2 > best * (1.0 + 1e-9):
                continue
            left = signed_offset(x, y, ax, ay, bx, by, length2)
            # at a corner of the slice both segments are equally near: the larger offset decides
            if d2 > best * (1.0 - 1e-9) and abs(left) <= lead:
                continue

            # Orient the segment by the normal of the fault.
            turn = (bx - ax) * normals[f, 1] - (by - ay) * normals[f, 0]
            best, lead = min(best, d2), abs(left)
            side[k] = 1.0 if (left >= 0.0) == (turn >= 0.0) else -1.0
        far[k] = np.sqrt(best)
    return far, side


@scalar
def _left(px, py, qx, qy, nx, ny):
    """Whether n is left of the line pq, or on it."""
    return (qx - px) * (ny - py) - (qy - py) * (nx - px) >= 0


@entry("l2 l l -> l2 d1")
def cut_links(ends, n_row, n_col):
    """Links that pieces of a trace cross: rows (node, kind, piece, +1 if the node's end is left).

    `ends` (n, 4) are p and q of each piece; also the parameter on the piece, 0 to 1, of each
    crossing.
    """
    size = 64
    rows = np.empty((size, 4), dtype=np.int64)
    place = np.empty(size)
    count = 0
    for s in range(ends.shape[0]):
        px, py, qx, qy = ends[s, 0], ends[s, 1], ends[s, 2], ends[s, 3]
        # most pieces lie inside one cell, where only diagonals can cross them
        south, west = min(py, qy) // UNIT, min(px, qx) // UNIT
        for row in range(south, max(py, qy) // UNIT + 1):
            for col in range(west, max(px, qx) // UNIT + 1):
                for kind in range(4):
                    if (kind == 0 and row == south) or (kind == 1 and col == west):
                        continue  # links on the near sides of the nearest cells

                    # Nodes at the ends of the link, inside the lattice.
                    m = col + (1 if kind == 3 else 0)
                    n = col + (1 if kind == 0 or kind == 2 else 0)
                    up = 0 if kind == 0 else 1
                    # Traces may leave the lattice.
                    if col < 0 or row < 0 or row + up >= n_row or max(m, n) >= n_col:
                        continue

                    # A crossing needs opposite sides for both segments.
                    mx, my, nx, ny = m * UNIT - px, row * UNIT - py, n * UNIT - px, 0
                    ny = (row + up) * UNIT - py
                    one = _left(0, 0, qx - px, qy - py, mx, my)
                    if one == _left(0, 0, qx - px, qy - py, nx, ny):
                        continue
                    if _left(mx, my, nx, ny, 0, 0) == _left(mx, my, nx, ny, qx - px, qy - py):
                        continue
                    if count == size:
                        rows = np.concatenate((rows, np.empty_like(rows)))
                        place = np.concatenate((place, np.empty_like(place)))
                        size *= 2
                    rows[count, 0] = row * n_col + col
                    rows[count, 1] = kind
                    rows[count, 2] = s
                    rows[count, 3] = 1 if one else -1
                    # in floats: only the order along the trace is read from it
                    over = float((nx - mx) * (0 - my) - (ny - my) * (0 - mx))
                    under = float((nx - mx) * (qy - py - my) - (ny - my) * (qx - px - mx))
                    place[count] = over / (over - under)
                    count += 1
    return rows[:count].copy(), place[:count].copy()
