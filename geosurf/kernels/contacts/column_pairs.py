"""Pairs of triangles of one cell and of the patch below or above it of a grid with axes.

For rows of the patch at the height of the cell, the heights of all nodes over the planes of both
triangles of the cell are computed. A cell of the patch with all nodes certainly above or below a
plane is skipped, and so is one beyond an edge of the triangle. The few others are compared by
`cell_contacts`.

Notation, in addition to that of `cell_contacts` and `axis_grids`
    box      of the cell, float64 (6,), in the world
    heights  of nodes, float64 (4, n): two rows, this one and the last, over both planes
    marks    of nodes, int64 (2, n): bits for above and below each plane, and the box
    rows     lowest and highest node of each row of the patch, float64 (2, n)
    present  which triangles of the cell have three nodes, as bits
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.contacts.cell_contacts import (
    BOUND,
    CORNER,
    NORMAL,
    contact_by_heights,
    decide_contact,
    edge_distances,
    set_edge_query,
    set_plane_query,
)
from geosurf.kernels.contacts.contact_table import UNDECIDED
from geosurf.kernels.search.tree import N_COL

_FIRST, _SECOND, _BOX = 3, 12, 48  # bits of marks: above and below
_ALL = _FIRST | _SECOND | _BOX  # of a missing node: it leaves the decision to the others of a cell


class AxisGrid(NamedTuple):
    """Side A: a grid with straight rising axes."""

    x: np.ndarray  # coordinates and their layout, as in `tree`
    y: np.ndarray
    z: np.ndarray
    a: np.ndarray
    nodes: np.ndarray  # its pyramid of boxes
    levels: np.ndarray
    pace_x: float  # cells per metre
    pace_y: float


class CellQuery(NamedTuple):
    """What one cell of side B asks."""

    box: np.ndarray
    reach: np.ndarray
    origin: np.ndarray
    slip: float
    swapped: bool


class Work(NamedTuple):
    """Scratch arrays: see the notation here and in `cell_contacts`."""

    c: np.ndarray
    f: np.ndarray
    v: np.ndarray
    h: np.ndarray
    w: np.ndarray
    codes_table: np.ndarray
    heights: np.ndarray
    marks: np.ndarray
    rows: np.ndarray


@scalar
def _extremes_of_rows(z, a, at, rows):
    """Lowest and highest node of each row of the patch; NaN nodes are skipped.

    Column by column: the rows are far apart in memory, and are then loaded side by side.
    """
    n = at[1] - at[0] + 1
    for i in range(n):
        rows[0, i], rows[1, i] = np.inf, -np.inf
    # Columns outside, rows inside: see above.
    for j in range(at[2], at[3] + 1):
        start = a[6] + at[0] * a[7] + j * a[8]
        for i in range(n):
            value = z[start + i * a[7]]
            rows[0, i] = value if value < rows[0, i] else rows[0, i]
            rows[1, i] = value if value > rows[1, i] else rows[1, i]


@scalar
def _evaluate_row(grid, i, first, last, query, work):
    """Heights of the nodes of row i, columns first to last, over both planes; and their marks."""
    x, y, z, a = grid.x, grid.y, grid.z, grid.a
    origin, box = query.origin, query.box
    h, heights, marks = work.h, work.heights, work.marks
    # Two rows of scratch in turns: a row of cells needs its lower and its upper nodes.
    row = i & 1

    # Local names keep the loop free of index arithmetic, so that it is vectorised.
    x0, z0, nx, nz = h[0, CORNER], h[0, CORNER + 2], h[0, NORMAL], h[0, NORMAL + 2]
    x1, z1, mx, mz = h[1, CORNER], h[1, CORNER + 2], h[1, NORMAL], h[1, NORMAL + 2]
    far, off = h[0, BOUND], h[1, BOUND]
    ox, oz, roof, floor = origin[0], origin[2], box[5], box[2]
    level = y[i] - origin[1]
    # Northing is constant along a row: its term is computed once per plane.
    ny = (level - h[0, CORNER + 1]) * h[0, NORMAL + 1]
    my = (level - h[1, CORNER + 1]) * h[1, NORMAL + 1]
    # The loop has no branch on the data; marks are sums of selections.
    start, step = a[6] + i * a[7] + first * a[8], a[8]
    for k in range(last - first + 1):
        value = z[start + k * step]
        u, w = x[first + k] - ox, value - oz
        p = (u - x0) * nx + ny + (w - z0) * nz
        q = (u - x1) * mx + my + (w - z1) * mz
        heights[2 * row, k], heights[2 * row + 1, k] = p, q

        # Two bits per plane and for the box: above and below.
        mark = (1 if p > far else 0) + (2 if p < -far else 0)
        mark += (4 if q > off else 0) + (8 if q < -off else 0)
        mark += (16 if value > roof else 0) + (32 if value < floor else 0)
        marks[row, k] = mark if value == value else _ALL


@scalar
def _load_patch_cell(x, y, z, a, i, j, origin, c):
    """Load the corners of a cell of the patch into the first four rows of c."""
    at = a[6] + i * a[7] + j * a[8]
    c[0, 0] = c[3, 0] = x[j] - origin[0]
    c[1, 0] = c[2, 0] = x[j + 1] - origin[0]
    c[0, 1] = c[1, 1] = y[i] - origin[1]
    c[2, 1] = c[3, 1] = y[i + 1] - origin[1]
    c[0, 2], c[1, 2] = z[at] - origin[2], z[at + a[8]] - origin[2]
    c[2, 2], c[3, 2] = z[at + a[7] + a[8]] - origin[2], z[at + a[7]] - origin[2]


@scalar
def _add_pair(pairs, n, key_a, key_b, codes, swapped):
    # Beyond the capacity pairs are only counted; the caller repeats with larger arrays.
    if n < pairs.shape[0]:
        pairs[n, 0] = key_b if swapped else key_a
        pairs[n, 1] = key_a if swapped else key_b
        pairs[n, 2] = codes
    return n + 1


@scalar
def _pairs_of_cell(work, row, k, other, key_a, key_b, query, pairs, n):
    """Pairs of both triangles of a loaded cell of the patch and one of the cell, 2 + `other`."""
    slip, swapped = query.slip, query.swapped
    c, f, v, h, w, codes_table, heights = (
        work.c,
        work.f,
        work.v,
        work.h,
        work.w,
        work.codes_table,
        work.heights,
    )

    # Heights of the four corners, counter-clockwise.
    # The lower row of nodes is the one of parity row & 1.
    low, high = 2 * (row & 1) + other, 2 - 2 * (row & 1) + other
    w[0, 0], w[0, 1] = heights[low, k], heights[low, k + 1]
    w[0, 2], w[0, 3] = heights[high, k + 1], heights[high, k]
    # All four corners beyond one edge: neither triangle of the patch can meet this one.
    if not edge_distances(c, h[other], w):
        return n
    for half in range(2):
        codes = contact_by_heights(w, v, half, h[other], codes_table)
        if codes == UNDECIDED:
            codes = decide_contact(c, f, v, half, 2 + other, slip, swapped)
        if codes != 0:
            n = _add_pair(pairs, n, key_a + half, key_b + other, codes, swapped)
    return n


@scalar
def _set_plane_queries(c, f, v, reach, slip, h):
    """Set the queries of both triangles of the cell; which of them exist, as bits."""
    present = 0
    for other in range(2):
        if set_plane_query(c, f, v, 2 + other, reach, slip, h[other]):
            present |= 1 << other
        else:
            # A missing triangle: with a zero normal and bound, no node is marked above or below.
            h[other, : BOUND + 1] = 0.0
    return present


@scalar
def _pairs_of_row(grid, i, first, last, present, key_b, query, work, asked, pairs, n):
    """Pairs of the cells of row i of the patch; and the triangles whose edge queries are set."""
    x, y, z, a = grid.x, grid.y, grid.z, grid.a
    reach, origin, slip = query.reach, query.origin, query.slip
    c, f, v, h, marks = work.c, work.f, work.v, work.h, work.marks
    # Bits that both nodes of a column share; the right column of a cell is the left one of the
    # next.
    right = marks[0, 0] & marks[1, 0]
    for k in range(last - first):
        # A bit that all four corners share excludes the cell.
        left, right = right, marks[0, k + 1] & marks[1, k + 1]
        both = left & right
        near = (1 if both & _FIRST == 0 else 0) + (2 if both & _SECOND == 0 else 0)
        near &= present
        if near == 0 or both & _BOX != 0:
            continue

        # Compare with both triangles of the cell; edge queries are set on first use.
        _load_patch_cell(x, y, z, a, i, first + k, origin, c)
        key_a = 2 * (i * (a[N_COL] - 1) + first + k)
        for other in range(2):
            bit = 1 << other
            if near & bit == 0:
                continue
            if asked & bit == 0:
                set_edge_query(c, f, v, 2 + other, reach, slip, h[other])
                asked |= bit
            n = _pairs_of_cell(work, i, k, other, key_a, key_b, query, pairs, n)
    return n, asked


@scalar
def pairs_in_columns(grid, at, key_b, query, work, pairs, n):
    """Pairs of triangles of a loaded cell of B and the cells of A below or above it, `at`."""
    z, a = grid.z, grid.a
    box, reach, slip = query.box, query.reach, query.slip
    c, f, v, h, rows = work.c, work.f, work.v, work.h, work.rows

    # Triangles that exist (-1: unknown), those with edge queries, last evaluated row.
    present, asked, last_row = (
        -1,
        0,
        -1,
    )
    first, last = at[2], at[3]
    _extremes_of_rows(z, a, at, rows)
    for i in range(at[0], at[1]):
        # Skip rows of cells above or below the box.
        k = i - at[0]
        low, high = min(rows[0, k], rows[0, k + 1]), max(rows[1, k], rows[1, k + 1])
        if not (low <= box[5] and box[2] <= high):
            continue
        # Planes are set up for the first row that is near, which most cells never reach.
        if present < 0:
            present = _set_plane_queries(c, f, v, reach, slip, h)
        if present == 0:
            return n

        # Neighbouring rows of cells share a row of nodes.
        if last_row != i:
            _evaluate_row(grid, i, first, last, query, work)
        _evaluate_row(grid, i + 1, first, last, query, work)
        last_row = i + 1
        n, asked = _pairs_of_row(grid, i, first, last, present, key_b, query, work, asked, pairs,
        n)  # fmt: skip
    return n
