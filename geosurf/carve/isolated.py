"""Locate pieces of surfaces that touch nothing else: a ray finds the cell around each piece.

A ray that meets nothing more has left the model: its piece lies beyond the walls, as a fault in
a corner of the bounds that the area of interest does not reach. It is put into the space outside.
"""

from __future__ import annotations

import numpy as np

from geosurf.carve.rays import NO_HIT, Rays


def place_floating(
    x: np.ndarray, t: np.ndarray, piece: np.ndarray, fixed: np.ndarray, shell: np.ndarray
) -> np.ndarray:
    """Unite the outer shell of each floating piece with the cell, or the outside, that holds it.

    Parameters
    ----------
    x, t : ndarray
        Points and triangles.
    piece : ndarray of int64, shape (n_triangle,)
        Connected piece of each triangle.
    fixed : ndarray of int64
        Pieces that do not float: those of the walls, one at least.
    shell : ndarray of int64, shape (2 * n_triangle,)
        Shell of each side of each triangle.

    Returns
    -------
    ndarray of int64, shape (2 * n_triangle,)

    Raises
    ------
    InvariantError
        If no ray passes through a piece, which has no area then.

    Notes
    -----
    One ray for each piece, and one more for each group of pieces that see each other only: all
    others are placed by what holds those that they see.

    Examples
    --------
    A tetrahedron as the wall, a triangle in it and one next to it, below nothing:

    >>> x = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9], [1, 1, 1], [2, 1, 1], [1, 2, 1],
    ...               [8, 8, 1], [9, 8, 1], [8, 9, 1]], dtype=float)
    >>> t = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [4, 5, 6], [7, 8, 9]])
    >>> outer, inner = 0, 1  # shells of the wall: normals point out
    >>> shell = np.array([outer, inner] * 4 + [8, 8, 10, 10])
    >>> piece = np.array([0, 0, 0, 0, 4, 5])
    >>> place_floating(x, t, piece, np.array([0]), shell)[8:].tolist()
    [1, 1, 0, 0]
    """
    floating, first = np.unique(piece, return_index=True)
    in_walls = np.isin(floating, fixed)
    wall, floating, first = first[in_walls][:1], floating[~in_walls], first[~in_walls]
    if len(floating) == 0:
        return shell.copy()

    # one ray from each piece: the side where it leaves the piece, and the side that it meets next
    rays = Rays(x, t)
    outer, holding = rays.shoot(first, piece).T
    label = shell[outer]
    # the label of each label once they are united, and whether others than outer sides have it
    parent = np.arange(int(shell.max()) + 1)
    of_others = np.zeros(len(parent), dtype=bool)
    of_others[shell[_others(piece, shell, floating, label)]] = True
    start, outside = label, -1
    while True:
        beyond = holding == NO_HIT
        if beyond.any() and outside < 0:
            # the topmost side of the walls sees the outside as well
            outside = int(shell[rays.shoot(wall, np.where(np.isin(piece, fixed), -1, piece))[0, 0]])
        held = np.where(beyond, outside, shell[holding])
        for one, holder in zip(start.tolist(), held.tolist(), strict=True):
            one, holder = _root(parent, one), _root(parent, holder)
            if one != holder:
                parent[one] = holder
                of_others[holder] |= of_others[one]
        root = _roots(parent)
        # pieces that float side by side may see each other only: ask beyond all of them
        # pieces whose shells only see each other are one group; the next rays start from its
        # members and pass through all of it
        alone, member = np.unique(root[label], return_index=True)
        member = member[~of_others[alone]]
        if len(member) == 0:
            return root[shell]
        group = piece.copy()
        at = np.minimum(np.searchsorted(floating, piece), len(floating) - 1)
        floats = floating[at] == piece
        group[floats] = 1 + piece.max() + root[label[at[floats]]]
        start, holding = label[member], rays.shoot(first[member], group)[:, 1]


def _others(
    piece: np.ndarray, shell: np.ndarray, floating: np.ndarray, label: np.ndarray
) -> np.ndarray:
    """Sides that are not outer sides of floating pieces."""
    at = np.minimum(np.searchsorted(floating, piece), len(floating) - 1)
    floats = floating[at] == piece
    outer = np.repeat(floats, 2) & (shell == np.repeat(label[at], 2))
    others: np.ndarray = np.flatnonzero(~outer)
    return others


def _root(parent: np.ndarray, one: int) -> int:
    """Where a label leads, halving the way."""
    while parent[one] != one:
        # path halving: later walks are short
        parent[one] = parent[parent[one]]
        one = int(parent[one])
    return one


def _roots(parent: np.ndarray) -> np.ndarray:
    """Where each label leads."""
    while True:
        # pointer jumping, all rows at once, until each points to its root
        onward = parent[parent]
        if np.array_equal(onward, parent):
            return onward
        parent = onward
