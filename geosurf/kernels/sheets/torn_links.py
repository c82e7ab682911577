"""Links of a lattice that faults cut: the triangles they divide, and the steps that none parts.

Links are named as in `Cuts`: node and kind, 0 east, 1 north, 2 rising and 3 falling diagonal. A
link as one number is ``4 * node + kind``. Triangle ``2 * node + half`` lies in the cell whose lower
left node that is.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

EAST, NORTH, RISING, FALLING = range(4)


@entry("d2 l1 l1 l l -> l2 l2")
def uncut_steps(walls, node, kind, n_row, n_col):
    """Neighbours (n, 2) to the east, then to the north, in different walls that no link parts.

    `walls` (n_slip, n_node) are compared exactly; `node` and `kind` are the links that are cut.
    """
    cut = np.zeros((2, n_row * n_col), dtype=np.bool_)
    for k in range(node.shape[0]):
        if kind[k] <= NORTH:
            cut[kind[k], node[k]] = True
    size = 256
    east, north = np.empty((size, 2), dtype=np.int64), np.empty((size, 2), dtype=np.int64)
    n_east = n_north = 0
    for i in range(n_row):
        for j in range(n_col):
            a = i * n_col + j
            for side in range(2):
                if (j if side == EAST else i) + 1 == (n_col if side == EAST else n_row):
                    continue
                b = a + (1 if side == EAST else n_col)
                differ = False
                for k in range(walls.shape[0]):
                    differ = differ or walls[k, a] != walls[k, b]
                if not differ or cut[side, a]:
                    continue
                if max(n_east, n_north) + 1 > size:
                    east = np.concatenate((east, np.empty_like(east)))
                    north = np.concatenate((north, np.empty_like(north)))
                    size *= 2
                if side == EAST:
                    east[n_east, 0], east[n_east, 1] = a, b
                    n_east += 1
                else:
                    north[n_north, 0], north[n_north, 1] = a, b
                    n_north += 1
    return east[:n_east].copy(), north[:n_north].copy()


@scalar
def _corner(t, k, rising, n_col):
    """Corner k of a triangle: anticlockwise, from the lower left of its cell where that is one."""
    a = t // 2
    if k == 0:
        return a + 1 if t % 2 == 1 and not rising else a
    if t % 2 == 0:
        return a + 1 if k == 1 else (a + n_col + 1 if rising else a + n_col)
    return a + n_col + 1 if k == 1 else a + n_col


@scalar
def _link(one, two, n_col):
    """Number of the link between two corners of a triangle."""
    low, step = min(one, two), abs(one - two)
    if step == 1:
        return 4 * low + EAST
    if step == n_col:
        return 4 * low + NORTH
    if step == n_col + 1:
        return 4 * low + RISING
    return 4 * (low - 1) + FALLING


@scalar
def _beside(link, turn, rising, n_col):
    """One of the two triangles of a link (turn 0 or 1), -1 if it would be outside."""
    node, kind = link // 4, link % 4
    if kind == EAST:
        if turn == 0:
            return 2 * node
        return 2 * (node - n_col) + 1 if node >= n_col else -1
    if kind == NORTH:
        left = 1 if rising else 0
        if turn == 0:
            return 2 * node + left
        return 2 * (node - 1) + 1 - left if node % n_col > 0 else -1
    return 2 * node + turn


@scalar
def _exists(t, rising, present, n_row, n_col):
    """Whether a triangle is in the lattice and has its three nodes."""
    a = t // 2
    if t < 0 or a // n_col >= n_row - 1 or a % n_col >= n_col - 1:
        return False
    for k in range(3):
        if not present[_corner(t, k, rising, n_col)]:
            return False
    return True


@entry("l1 b b1 l l -> l1")
def triangles_beside(links, rising, present, n_row, n_col):
    """Triangles beside some links that exist, in any order and more than once."""
    found, n = np.empty(2 * links.shape[0], dtype=np.int64), 0
    for k in range(links.shape[0]):
        for turn in range(2):
            t = _beside(links[k], turn, rising, n_col)
            if _exists(t, rising, present, n_row, n_col):
                found[n] = t
                n += 1
    return found[:n].copy()


@entry("l1 l1 b b1 l l -> l1 l2 b2 l2 b2")
def divided_triangles(near, cut, rising, present, n_row, n_col):
    """Copies of the triangles that two cut links or more divide: one for each fragment.

    Parameters
    ----------
    near : int64 (n,)
        Triangles that exist, rising.
    cut : int64 (n_cut,)
        Links, rising.

    Returns
    -------
    triangle : int64 (n_copy,)
        Rising.
    corners : int64 (n_copy, 3)
        Nodes.
    real : bool (n_copy, 3)
        Corners of the fragment; the copies of one triangle by these, what is false first.
    across : int64 (n_copy, 3)
        The triangle beyond each edge, from a corner to the next.
    exists : bool (n_copy, 3)
        Whether there is one.
    """
    most = 3 * near.shape[0]
    triangle, real = np.empty(most, dtype=np.int64), np.empty((most, 3), dtype=np.bool_)
    corners, across = np.empty((most, 3), dtype=np.int64), np.empty((most, 3), dtype=np.int64)
    exists, is_cut = np.empty((most, 3), dtype=np.bool_), np.empty(3, dtype=np.bool_)
    link = np.empty(3, dtype=np.int64)
    n = 0
    for i in range(near.shape[0]):
        t, times = near[i], 0
        for k in range(3):
            one = _corner(t, k, rising, n_col)
            two = _corner(t, 0 if k == 2 else k + 1, rising, n_col)
            link[k] = _link(one, two, n_col)
            at = np.searchsorted(cut, link[k])
            is_cut[k] = at < cut.shape[0] and cut[at] == link[k]
            times += 1 if is_cut[k] else 0
        if times < 2:
            continue  # one cut edge alone ends inside the triangle: the tip goes through it

        # the corner that is alone lies between two cut edges; with three cut edges all are alone
        for turn in range(times):
            for k in range(3):
                if times == 3:
                    real[n, k] = k == 2 - turn
                    continue
                # the fragment without corner 0 comes first
                other = (turn == 1) != (is_cut[0] and is_cut[2])
                real[n, k] = (is_cut[k] and is_cut[2 if k == 0 else k - 1]) != other
            triangle[n] = t
            for k in range(3):
                corners[n, k] = _corner(t, k, rising, n_col)
                over = _beside(link[k], 0, rising, n_col)
                if over == t:
                    over = _beside(link[k], 1, rising, n_col)
                across[n, k] = over
                exists[n, k] = _exists(over, rising, present, n_row, n_col)
            n += 1
    return (
        triangle[:n].copy(), corners[:n].copy(), real[:n].copy(), across[:n].copy(),
        exists[:n].copy(),
    )  # fmt: skip
