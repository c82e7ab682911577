"""Which triangles of a lattice are near triangles of another surface?

A certificate lists some triangles of each lattice, and looks for others that it has to list. The
tree has boxes around the unlisted ones, and no other triangle is read. Answers are marks instead of
pairs, since nearly no unlisted triangle is near another surface.

Notation as in `geosurf.kernels.search.tree`, in addition
    free    whether each triangle of a lattice is unlisted, by key
    hit     the marks, by key
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.tree import (
    BLOCK,
    FAN,
    IS_LATTICE,
    N_COL,
    N_ROW,
    Loaded,
    Tree,
    _box_corners,
    _box_misses_plane,
    _children,
    _is_excluded,
    _load_half,
    _load_list_leaf,
    boxes_apart,
    build_above,
    clear_boxes,
    extent,
    levels_of,
    push_pair,
)

_ROOM = 2 * BLOCK * BLOCK


@entry("d1 d1 d1 l1 b1 -> d2 l2")
def unlisted_boxes(p, q, r, a, free):
    """Boxes and levels of a tree over the unlisted triangles of a lattice, empty without them."""
    n_cell_row, n_cell_col = max(a[N_ROW] - 1, 0), max(a[N_COL] - 1, 0)
    n_row, n_col = (
        max((n_cell_row + BLOCK - 1) // BLOCK, 1),
        max((n_cell_col + BLOCK - 1) // BLOCK, 1),
    )
    levels, n_node = levels_of(n_row, n_col, 2, 2)
    nodes = np.empty((n_node, 6))
    clear_boxes(nodes, 0, n_node)
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    tree = Tree(p, q, r, a, none[0], none[1], nodes, levels)
    c, box = np.empty((1, 9)), np.empty((1, 6))
    for row in range(n_cell_row):
        for col in range(n_cell_col):
            leaf = (row // BLOCK) * n_col + col // BLOCK
            for half in range(2):
                if free[2 * (row * n_cell_col + col) + half]:
                    _load_half(tree, row, col, half, c, 0)
                    _box_corners(c, 0, box)
                    for k in range(3):
                        nodes[leaf, k] = min(nodes[leaf, k], box[0, k])
                        nodes[leaf, 3 + k] = max(nodes[leaf, 3 + k], box[0, 3 + k])
    build_above(nodes, levels, 2, 2)
    return nodes, levels


@scalar
def _load_free(tree, free, leaf, near, j, loaded):
    """Load the unlisted triangles of a leaf whose boxes meet box j of `near`; their number."""
    a, levels = tree.a, tree.levels
    n = 0
    n_col = a[N_COL] - 1
    first_row, first_col = BLOCK * (leaf // levels[0, 2]), BLOCK * (leaf % levels[0, 2])
    for row in range(first_row, min(first_row + BLOCK, a[N_ROW] - 1)):
        for col in range(first_col, min(first_col + BLOCK, n_col)):
            for half in range(2):
                key = 2 * (row * n_col + col) + half
                if not free[key]:
                    continue
                _load_half(tree, row, col, half, loaded.c, n)
                _box_corners(loaded.c, n, loaded.boxes)
                loaded.keys[n] = key
                # the row is used again unless the triangle is near
                if not boxes_apart(loaded.boxes, n, near, j):
                    n += 1
    return n


@scalar
def _mark_near(one, count, two, count_two, hit, hit_two):
    """Mark loaded triangles whose boxes meet, and whose planes pass the other's box."""
    for i in range(count):
        for j in range(count_two):
            if boxes_apart(one.boxes, i, two.boxes, j):
                continue
            if _box_misses_plane(one.c, i, two.boxes, j):
                continue
            if _box_misses_plane(two.c, j, one.boxes, i):
                continue
            hit[one.keys[i]] = True
            if hit_two.shape[0] > 0:
                hit_two[two.keys[j]] = True


@entry("d1 d1 d1 l1 d2 l2 b1 b1* d1 d1 d1 l1 l2 l1 d2 l2 b1 b1* -> .")
def mark_near(pa, qa, ra, aa, na, la, free, hit, pb, qb, rb, ab, tb, ob, nb, lb, free_b, hit_b):
    """Mark the unlisted triangles of a lattice that are near triangles of another surface.

    That is a lattice, of which the unlisted triangles are marked, too, or a list (no `free_b`).
    """
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    a, b = Tree(pa, qa, ra, aa, none[0], none[1], na, la), Tree(pb, qb, rb, ab, tb, ob, nb, lb)
    ca, ba, ka = np.empty((_ROOM, 9)), np.empty((_ROOM, 6)), np.empty(_ROOM, dtype=np.int64)
    cb, bb, kb = np.empty((_ROOM, 9)), np.empty((_ROOM, 6)), np.empty(_ROOM, dtype=np.int64)
    one, two = Loaded(ca, ba, ka), Loaded(cb, bb, kb)
    stack = np.empty((4096, 4), dtype=np.int64)
    kids = np.empty(FAN, dtype=np.int64)
    top = push_pair(stack, 0, na.shape[0] - 1, la.shape[0] - 1, nb.shape[0] - 1, lb.shape[0] - 1)
    while top > 0:
        top -= 1
        i, level_i, j, level_j = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        if boxes_apart(na, i, nb, j):
            continue
        if ab[IS_LATTICE] == 0 and _is_excluded(a, i, level_i, one, b, j, level_j, two):
            continue
        if level_i == 0 and level_j == 0:
            count = _load_free(a, free, i, nb, j, one)
            if count > 0:
                if ab[IS_LATTICE] == 0:
                    count_b = _load_list_leaf(b, j, na, i, two)
                else:
                    count_b = _load_free(b, free_b, j, na, i, two)
                _mark_near(one, count, two, count_b, hit, hit_b)
            continue

        # room for all pairs of children of two nodes
        if top + FAN * FAN > stack.shape[0]:
            larger = np.empty((2 * stack.shape[0], 4), dtype=np.int64)
            larger[: stack.shape[0]] = stack
            stack = larger

        # descend on the side whose box is larger
        if level_j == 0 or (level_i > 0 and extent(na, i) >= extent(nb, j)):
            count = _children(aa, la, i, level_i, kids)
            for k in range(count):
                top = push_pair(stack, top, kids[k], level_i - 1, j, level_j)
        else:
            count = _children(ab, lb, j, level_j, kids)
            for k in range(count):
                top = push_pair(stack, top, i, level_i, kids[k], level_j - 1)
