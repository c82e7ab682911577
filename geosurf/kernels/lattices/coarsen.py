"""Fewer triangles on a lattice: right-triangulated irregular networks (Evans et al. 2001).

Squares of 2**t cells are halved along their diagonal, and each right triangle is bisected at the
middle of its longest side, down to half cells. A triangle is accepted if the surface stays within
the tolerance of its plane. It is split if not, if it touches a cell that is not whole, or if one
of its halves is split: the middle of the longest side is shared with the triangle across, so no
vertex ends up inside a side.

The original surface is linear on each quarter of a cell (its corners and its middle, where the
value is the mean of the ends of the diagonal), and triangles consist of whole quarters. So the
largest difference is at nodes and middles. The mean of a quarter's three absolute differences
times its area is an upper bound of its share of the volume between the surfaces (the absolute
value is convex).

Notation
    z      elevation of nodes (n_row, n_col), the anchor of all squares at node (0, 0)
    whole  of each cell: 1 four nodes, 2 three, 0 no triangle
    split  (n, n) nodes at which a triangle is split; larger than z, a whole number of squares
    a, b, c   corners of a triangle as (row, column); c the right angle
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar


@scalar
def _corners(square, i, j, root, path, level):
    """Corners a, b, c of a triangle, as six numbers, from the bisections that lead to it."""
    ai, aj, bi, bj = i, j, i + square, j + square
    # A square has two triangles with a common longest side, the diagonal a-b.
    ci, cj = (i, j + square) if root == 0 else (i + square, j)
    if root == 1:
        ai, aj, bi, bj = bi, bj, ai, aj
    for k in range(level):
        # Each bit of the path chooses one half.
        mi, mj = (ai + bi) // 2, (aj + bj) // 2
        if (path >> k) & 1:
            # The middle of the longest side becomes the right angle of both halves.
            ai, aj, bi, bj, ci, cj = bi, bj, ci, cj, mi, mj
        else:
            ai, aj, bi, bj, ci, cj = ci, cj, ai, aj, mi, mj
    return ai, aj, bi, bj, ci, cj


@scalar
def _plane(z, ai, aj, bi, bj, ci, cj):
    """Height at c, and slopes along rows and columns, of the plane through three nodes."""
    di, dj, ei, ej = ai - ci, aj - cj, bi - ci, bj - cj

    # The legs from the right angle are perpendicular and equal.
    size = di * di + dj * dj
    p, q = (z[ai, aj] - z[ci, cj]) / size, (z[bi, bj] - z[ci, cj]) / size
    return z[ci, cj], p * di + q * ei, p * dj + q * ej


@scalar
def _span(row, low, high, ai, aj, bi, bj, ci, cj):
    """Columns (low, high) of a closed triangle in a row; all numbers in the same units."""
    turn = (bi - ai) * (cj - aj) - (bj - aj) * (ci - ai)
    # Each side bounds the row by a half plane; what is left of the interval lies in all three.
    for side in range(3):
        if side == 0:
            pi, pj, qi, qj = ai, aj, bi, bj
        elif side == 1:
            pi, pj, qi, qj = bi, bj, ci, cj
        else:
            pi, pj, qi, qj = ci, cj, ai, aj
        # (q - p) x (x - p) >= 0, for the turn that the triangle has
        di, dj = qi - pi, qj - pj
        if turn < 0:
            di, dj = -di, -dj
        # di * (col - pj) - dj * (row - pi) >= 0, and |di| = |dj| or one is zero
        bound = dj * (row - pi)
        if di > 0:
            low = max(low, pj + -((-bound) // di))
        elif di < 0:
            high = min(high, pj + (-bound) // (-di))
        elif bound > 0:
            high = low - 1
    return low, high


@scalar
def _middle(z, i, j, rising):
    """Elevation of the original surface in the middle of a cell."""
    if rising:
        return 0.5 * (z[i, j] + z[i + 1, j + 1])
    return 0.5 * (z[i, j + 1] + z[i + 1, j])


@scalar
def _too_far(z, whole, rising, tolerance, ai, aj, bi, bj, ci, cj):
    """Whether a triangle must be split: beyond the tolerance, or not on whole cells."""
    top, bottom = min(ai, min(bi, ci)), max(ai, max(bi, ci))
    left, right = min(aj, min(bj, cj)), max(aj, max(bj, cj))

    # All cells have to be whole, or all outside.
    some, all_of_them = False, True
    # Coordinates are doubled, so that row 2 i + 1 passes through the middles of cells.
    for i in range(top, bottom):
        low, high = _span(
            2 * i + 1, 2 * left, 2 * right, 2 * ai, 2 * aj, 2 * bi, 2 * bj, 2 * ci, 2 * cj
        )
        for j in range(low // 2, (high + 1) // 2):
            kind = 0
            if i < whole.shape[0] and j < whole.shape[1]:
                kind = whole[i, j]
            some |= kind > 0
            all_of_them &= kind == 1
        if some and not all_of_them:
            return True
    if not some:
        return False

    # Differences at nodes, then at the middles of cells.
    height, down, along = _plane(z, ai, aj, bi, bj, ci, cj)
    for i in range(top, bottom + 1):
        low, high = _span(i, left, right, ai, aj, bi, bj, ci, cj)
        base = height + (i - ci) * down
        for j in range(low, high + 1):
            if abs(z[i, j] - base - (j - cj) * along) > tolerance:
                return True
    for i in range(top, bottom):
        low, high = _span(
            2 * i + 1, 2 * left, 2 * right, 2 * ai, 2 * aj, 2 * bi, 2 * bj, 2 * ci, 2 * cj
        )
        base = height + (i + 0.5 - ci) * down
        for j in range(low // 2, (high + 1) // 2):
            if abs(_middle(z, i, j, rising) - base - (j + 0.5 - cj) * along) > tolerance:
                return True
    return False


@entry("d2 l2 b l d b2 -> ")
def mark_splits(z, whole, rising, square, tolerance, split):
    """Fill `split`, from half cells upwards."""
    n_level = 0
    while (1 << n_level) < square:
        n_level += 1
    # Two bisections halve the side of the square; the last level has half cells.
    n_level *= 2

    # Children come before their parents, so that splits propagate upwards.
    for level in range(n_level - 1, -1, -1):
        for i in range(0, split.shape[0] - 1, square):
            for j in range(0, split.shape[1] - 1, square):
                for root in range(2):
                    for path in range(1 << level):
                        ai, aj, bi, bj, ci, cj = _corners(square, i, j, root, path, level)
                        mi, mj = (ai + bi) // 2, (aj + bj) // 2
                        if split[mi, mj]:
                            continue

                        # A split of a half forces the split of the whole.
                        if level + 1 < n_level and (
                            split[(ci + ai) // 2, (cj + aj) // 2]
                            or split[(bi + ci) // 2, (bj + cj) // 2]
                        ):
                            split[mi, mj] = True
                            continue
                        split[mi, mj] = _too_far(
                            z, whole, rising, tolerance, ai, aj, bi, bj, ci, cj
                        )


@entry("d2 b l2 -> d2")
def largest_errors(z, rising, corners):
    """Largest difference from the original surface, and a bound of its integral [m x cells]: (n,
    2).

    corners (n, 6): a, b, c of triangles on whole cells.
    """
    out = np.zeros((corners.shape[0], 2))
    for n in range(corners.shape[0]):
        ai, aj, bi, bj, ci, cj = corners[n]
        height, down, along = _plane(z, ai, aj, bi, bj, ci, cj)
        left, right = min(aj, min(bj, cj)), max(aj, max(bj, cj))
        for i in range(min(ai, min(bi, ci)), max(ai, max(bi, ci))):
            for j in range(left, right):
                base = height + (i - ci) * down + (j - cj) * along

                # Each cell has four quarters: the middle and two neighbouring corners.
                middle = abs(_middle(z, i, j, rising) - base - 0.5 * (down + along))
                # A quarter belongs to the triangle if its centroid does, as triangles consist of
                # quarters.
                for side in range(4):  # above, right, below, left; centroids in sixths
                    si = 6 * i + (1 if side == 0 else (5 if side == 2 else 3))
                    sj = 6 * j + (1 if side == 3 else (5 if side == 1 else 3))
                    low, high = _span(
                        si, 6 * left, 6 * right, 6 * ai, 6 * aj, 6 * bi, 6 * bj, 6 * ci, 6 * cj
                    )
                    if not low <= sj <= high:
                        continue
                    pi, pj = (1 if side == 2 else 0), (1 if side == 1 else 0)
                    qi, qj = (0 if side == 0 else 1), (0 if side == 3 else 1)
                    one = abs(z[i + pi, j + pj] - base - pi * down - pj * along)
                    two = abs(z[i + qi, j + qj] - base - qi * down - qj * along)
                    # A linear function is largest at a corner. The integral of its absolute value
                    # is at most the mean at the corners times the area, here 1/4 of a cell.
                    out[n, 0] = max(out[n, 0], max(middle, max(one, two)))
                    out[n, 1] += (middle + one + two) / 12.0
    return out


@scalar
def _kind(whole, ai, aj, bi, bj, ci, cj):
    """Kind of the cells of an accepted triangle, from the first of them."""
    left, right = min(aj, min(bj, cj)), max(aj, max(bj, cj))
    for i in range(min(ai, min(bi, ci)), max(ai, max(bi, ci))):
        # The first cell tells the kind of all: `_too_far` splits triangles on cells of several
        # kinds.
        low, high = _span(
            2 * i + 1, 2 * left, 2 * right, 2 * ai, 2 * aj, 2 * bi, 2 * bj, 2 * ci, 2 * cj
        )
        for j in range(low // 2, (high + 1) // 2):
            if i < whole.shape[0] and j < whole.shape[1]:
                return whole[i, j]
            return 0
    return 0


@entry("l2 l b2 -> l2")
def collect_triangles(whole, square, split):
    """Accepted triangles, rows (n, 7): a, b, c, and for half cells their cell, else -1.

    There is no triangle outside cells; half cells of cells that are not whole are included.
    """
    n_level = 0
    while (1 << n_level) < square:
        n_level += 1
    n_level *= 2
    out = np.empty((1024, 7), dtype=np.int64)
    # Depth first: at most two triangles of each level wait.
    stack = np.empty((2 * n_level + 4, 7), dtype=np.int64)
    n = 0
    for i in range(0, split.shape[0] - 1, square):
        for j in range(0, split.shape[1] - 1, square):
            for root in range(2):
                stack[0, :6] = _corners(square, i, j, root, 0, 0)
                stack[0, 6] = 0
                size = 1
                while size > 0:
                    size -= 1
                    ai, aj, bi, bj, ci, cj, level = stack[size]
                    mi, mj = (ai + bi) // 2, (aj + bj) // 2

                    # A split triangle is replaced by its two halves.
                    if level < n_level and split[mi, mj]:
                        stack[size, :6] = ci, cj, ai, aj, mi, mj
                        stack[size + 1, :6] = bi, bj, ci, cj, mi, mj
                        stack[size, 6] = level + 1
                        stack[size + 1, 6] = level + 1
                        size += 2
                        continue
                    if _kind(whole, ai, aj, bi, bj, ci, cj) == 0:
                        continue
                    # Full: twice the capacity, so that copying stays linear in the number of
                    # triangles.
                    if n == out.shape[0]:
                        more = np.empty((2 * n, 7), dtype=np.int64)
                        more[:n] = out
                        out = more

                    # Half cells name their cell.
                    out[n, :6] = ai, aj, bi, bj, ci, cj
                    out[n, 6] = -1
                    if level == n_level:
                        row, col = min(ai, min(bi, ci)), min(aj, min(bj, cj))
                        out[n, 6] = row * whole.shape[1] + col
                    n += 1
    return out[:n].copy()
