"""Triangles above points: bins on the map, with the triangles whose shadows meet each bin.

Cut triangles, faults, contacts and walls are listed by bin, from the highest down, so that the
search at a point stops at the first triangle that lies below it. Where the shadow of a triangle
covers a whole bin (a contact, a wall, a large fault), no point of the bin has to be tested on the
map.

Notation
    c         corners of the triangles, local, float64 (n, 9), highest triangle first
    facing    +1 where a triangle goes round counter-clockwise on the map, -1 where clockwise
    ends      lowest and highest elevation of each triangle, float64 (n, 2)
    step      unit below a triangle minus unit above it
    grid      west, south, bins per metre to the east and to the north, float64 (4,); the bins reach
              a little farther east and north than all triangles
    shape     rows and columns of bins, int64 (2,)
    start     first item of each bin, int64 (n_bin + 1,)
    items     triangles bin by bin: the row, or ``-1 - row`` where the shadow covers the bin
    p, levels, each, unit, rule   as in `lattice_units`
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.location.lattice_units import N_SCRATCH, Lines, aim, n_below, side_of_edge

_MARGIN = 1e-6  # of a bin: far more than rounding moves the corner of a bin, or a crossing


@scalar
def _bin(value, low, per_metre, n):
    """Bin of a coordinate: it never falls where the coordinate rises, whatever rounding does."""
    return int(min(max((value - low) * per_metre, 0.0), n - 1.0))


@scalar
def _ends_in_row(c, t, south, north, ends):
    """Least and greatest easting of a triangle between two northings."""
    ends[0], ends[1] = np.inf, -np.inf
    for k in range(3):
        ax, ay = c[t, 3 * k], c[t, 3 * k + 1]
        bx, by = c[t, (3 * k + 3) % 9], c[t, (3 * k + 4) % 9]
        if south <= ay <= north:
            ends[0], ends[1] = min(ends[0], ax), max(ends[1], ax)

        # where the edge passes the southern and the northern side of the row
        for level in (south, north):
            if (ay < level < by) or (by < level < ay):
                at = ax + (bx - ax) * ((level - ay) / (by - ay))
                ends[0], ends[1] = min(ends[0], at), max(ends[1], at)


@scalar
def _covers(c, facing, t, west, east, south, north):
    """Whether the shadow of a triangle covers a rectangle, for certain."""
    for k in range(3):
        ax, ay = c[t, 3 * k], c[t, 3 * k + 1]
        dx, dy = c[t, (3 * k + 3) % 9] - ax, c[t, (3 * k + 4) % 9] - ay
        dx, dy = facing[t] * dx, facing[t] * dy

        # the corner of the rectangle that is farthest to the right of the edge
        px = east if dy > 0.0 else west
        py = south if dx > 0.0 else north
        left, right = dx * (py - ay), dy * (px - ax)
        if left - right <= 1e-12 * (abs(left) + abs(right)):
            return False
    return True


@scalar
def _row_of_bins(c, t, grid, shape, row, ends):
    """First and last bin of a row that the shadow of a triangle may meet; none if first > last."""
    # a little wider than the row: points are sorted into bins with rounding
    south = grid[1] + (row - _MARGIN) / grid[3]
    north = grid[1] + (row + 1.0 + _MARGIN) / grid[3]
    _ends_in_row(c, t, south, north, ends)
    if ends[0] > ends[1]:
        return 1, 0
    slip = _MARGIN / grid[2]
    west = _bin(ends[0] - slip, grid[0], grid[2], shape[1])
    return west, _bin(ends[1] + slip, grid[0], grid[2], shape[1])


@entry("d2 d1 l1 l1* -> l")
def count_bins(c, grid, shape, count):
    """Count the triangles of each bin, and return the sum."""
    total = 0
    ends = np.empty(2)
    for t in range(c.shape[0]):
        low = _bin(min(c[t, 1], min(c[t, 4], c[t, 7])), grid[1], grid[3], shape[0])
        high = _bin(max(c[t, 1], max(c[t, 4], c[t, 7])), grid[1], grid[3], shape[0])
        for row in range(low, high + 1):
            west, east = _row_of_bins(c, t, grid, shape, row, ends)
            for col in range(west, east + 1):
                count[row * shape[1] + col] += 1
            total += max(0, east - west + 1)
    return total


@entry("d2 l1 d1 l1 l1* l1* -> .")
def fill_bins(c, facing, grid, shape, at, items):
    """Write the triangles of each bin in their order, the highest first.

    `at` is where each bin begins; it moves on, and ends where the next bin begins.
    """
    ends = np.empty(2)
    for t in range(c.shape[0]):
        low = _bin(min(c[t, 1], min(c[t, 4], c[t, 7])), grid[1], grid[3], shape[0])
        high = _bin(max(c[t, 1], max(c[t, 4], c[t, 7])), grid[1], grid[3], shape[0])
        for row in range(low, high + 1):
            west, east = _row_of_bins(c, t, grid, shape, row, ends)
            south = grid[1] + (row - _MARGIN) / grid[3]
            north = grid[1] + (row + 1.0 + _MARGIN) / grid[3]
            for col in range(west, east + 1):
                left = grid[0] + (col - _MARGIN) / grid[2]
                right = grid[0] + (col + 1.0 + _MARGIN) / grid[2]
                of = row * shape[1] + col
                covered = _covers(c, facing, t, left, right, south, north)
                items[at[of]] = -1 - t if covered else t
                at[of] += 1


@scalar
def _is_in_shadow(c, facing, t, lines):
    """Whether the moved line lies inside all three edges of a triangle on the map."""
    for k in range(3):
        ax, ay = c[t, 3 * k], c[t, 3 * k + 1]
        bx, by = c[t, (3 * k + 3) % 9], c[t, (3 * k + 4) % 9]
        if side_of_edge(ax, ay, bx, by, lines) != facing[t]:
            return False
    return True


@entry("d2 d1 d1 l1 d2* d1* -> l1")
def order_by_tile(p, levels, box, shape, ordered, z):
    """Order of points by tiles of the map, row by row, with their coordinates: a counting sort.

    Points far from each other would load the memory of the model once each: random points take a
    third of the time in this order. `box` is west, south, tiles per metre east and north.
    """
    n_tile = shape[0] * shape[1]
    tile = np.empty(p.shape[0], dtype=np.int64)
    at = np.zeros(n_tile + 1, dtype=np.int64)
    for q in range(p.shape[0]):
        row = _bin(p[q, 1], box[1], box[3], shape[0])
        tile[q] = row * shape[1] + _bin(p[q, 0], box[0], box[2], shape[1])
        at[tile[q] + 1] += 1
    for k in range(n_tile):
        at[k + 1] += at[k]
    order = np.empty(p.shape[0], dtype=np.int64)
    for q in range(p.shape[0]):
        k = at[tile[q]]
        order[k] = q
        ordered[k, 0], ordered[k, 1], z[k] = p[q, 0], p[q, 1], levels[q]
        at[tile[q]] += 1
    return order


@entry("d2 l1 d2 l1 d1 l1 l1 l1 d2 d1 l d1 l1* l1* l1* -> .")
def add_triangle_units(
    c, facing, ends, step, grid, shape, start, items, p, levels, each, rule, m, w, unit
):
    """Add the steps of all triangles to the highest level below each."""
    s = np.zeros((N_SCRATCH, 3))
    n = unit.shape[0] // max(p.shape[0], 1)
    lines = Lines(levels, n, rule, s, m, w)
    for q in range(p.shape[0]):
        row, col = (p[q, 1] - grid[1]) * grid[3], (p[q, 0] - grid[0]) * grid[2]
        if not (0.0 <= row < shape[0] and 0.0 <= col < shape[1]):
            continue  # beside all triangles
        of = int(row) * shape[1] + int(col)
        aim(s, rule, p[q, 0], p[q, 1])
        for k in range(start[of], start[of + 1]):
            covered = items[k] < 0
            t = -1 - items[k] if covered else items[k]
            if ends[t, 1] < levels[q * each]:
                break  # this triangle and all after it lie below the lowest level
            if not covered and not _is_in_shadow(c, facing, t, lines):
                continue
            for corner in range(9):
                s[corner // 3, corner % 3] = c[t, corner]
            below = n_below(lines, q * each, facing[t])
            if below > 0:
                unit[q * n + below - 1] += step[t]
