"""Which of many trees can overlap, decided from their upper levels: one call for all pairs.

The boxes of faults that run side by side overlap, while few of their parts do. The upper levels of
a tree, its top, exclude most of such pairs at once. Without them a call with all arrays would be
needed for each pair.

Notation, in addition to that of `tree`
    nodes    nodes of all tops, one after the other
    levels   int64 (n, 5): first row of `nodes`, rows and columns of nodes of each level, and the
             rows and columns of nodes that each node of the level above holds
    first    int64 (n_tree + 1,): lowest level of each top, and the end of the last
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.tree import boxes_apart, extent, push_pair

_FAN_ROW, _FAN_COL = 3, 4


@scalar
def _push_children(levels, level, node, other, level_other, swapped, stack, top):
    """Push each node below a node, paired with a node of the other tree."""
    # Row and column of the node in its level.
    at, width = node - levels[level, 0], levels[level, 2]
    row, col = at // width, at % width
    below = level - 1
    fan_row, fan_col = levels[below, _FAN_ROW], levels[below, _FAN_COL]
    for i in range(row * fan_row, min(row * fan_row + fan_row, levels[below, 1])):
        for j in range(col * fan_col, min(col * fan_col + fan_col, levels[below, 2])):
            kid = levels[below, 0] + i * levels[below, 2] + j

            # The order of the two trees is preserved on the stack.
            if swapped:
                top = push_pair(stack, top, other, level_other, kid, below)
            else:
                top = push_pair(stack, top, kid, below, other, level_other)
    return top


@scalar
def _pair_overlaps(nodes, levels, first, one, two, stack):
    """Whether two nodes of the lowest levels of two tops overlap."""
    # Both roots: the last level of each top.
    top = push_pair(
        stack, 0, levels[first[one + 1] - 1, 0], first[one + 1] - 1,
        levels[first[two + 1] - 1, 0], first[two + 1] - 1,
    )  # fmt: skip
    while top > 0:
        top -= 1
        i, level_i, j, level_j = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        if boxes_apart(nodes, i, nodes, j):
            continue

        # Descend on the larger box until both are at the lowest level.
        # `first` is the lowest level that a top has.
        low_i, low_j = level_i == first[one], level_j == first[two]
        if low_i and low_j:
            return True
        if low_j or (not low_i and extent(nodes, i) >= extent(nodes, j)):
            top = _push_children(levels, level_i, i, j, level_j, False, stack, top)
        else:
            top = _push_children(levels, level_j, j, i, level_i, True, stack, top)
    return False


@entry("d2 l2 l1 l2 -> b1")
def tops_overlap(nodes, levels, first, pairs):
    """Whether the lowest levels of two tops overlap, for each pair of trees (rows of `first`).

    A level above another one has at least one node for each `fan` of it, see `tree`.
    """
    # The stack holds at most all children of one node per level and side.
    most = 1
    for level in range(levels.shape[0]):
        most = max(most, levels[level, _FAN_ROW] * levels[level, _FAN_COL])
    stack = np.empty((2 * most * levels.shape[0] + 2, 4), dtype=np.int64)
    found = np.empty(pairs.shape[0], dtype=np.bool_)
    for k in range(pairs.shape[0]):
        found[k] = _pair_overlaps(nodes, levels, first, pairs[k, 0], pairs[k, 1], stack)
    return found
