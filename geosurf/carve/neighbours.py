"""Units that share faces, and which neighbour a small one becomes a part of.

Units are the nodes of a graph, and the area that two of them share is the weight of the edge. A
sliver goes to the neighbour with the largest shared area among those that are not slivers. One
that touches only slivers waits until some of these have gone, and follows them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.measures import AREA
from geosurf.carve.zones import DIGITS, in_words

Faces = dict[tuple[int, int], list[int]]


def faces_between_units(sides: np.ndarray) -> Faces:
    """Rows of the faces between each pair of units, lower number first.

    Parameters
    ----------
    sides : ndarray of int64, shape (n, 2)
        Unit in front of and behind each face; -1 outside.

    Examples
    --------
    >>> faces_between_units(np.array([[1, 0], [0, 0], [-1, 1], [0, 1]]))
    {(0, 1): [0, 3]}
    """
    found: Faces = {}
    inner = (sides >= 0).all(axis=1) & (sides[:, 0] != sides[:, 1])
    for row in np.flatnonzero(inner).tolist():
        one, two = sorted(sides[row].tolist())
        found.setdefault((one, two), []).append(row)
    return found


def homes_of_slivers(
    faces: Faces, area: np.ndarray, n_unit: int, small: Collection[int], order: Sequence[int]
) -> list[int]:
    """
    Unit that each unit becomes a part of; others stay their own.

    Parameters
    ----------
    faces : dict
        See `faces_between_units`.
    area : ndarray of float64, shape (n_face, k)
        Area of each face, as numbers to be added [m2].
    n_unit : int
    small : collection of int
        The slivers.
    order : sequence of int
        All units by name; of equal areas the first counts. Areas that agree to nine digits are
        equal, so that rounding does not decide.

    Returns
    -------
    list of int
        A sliver that no way leads from to any other unit stays its own.

    Examples
    --------
    Unit 1 touches 0 and 2; unit 2, a sliver as well, touches only 1:

    >>> homes_of_slivers({(0, 1): [0], (1, 2): [1]}, np.array([[4.0], [9.0]]), 3, {1, 2}, range(3))
    [0, 0, 0]
    """
    home = list(range(n_unit))
    rank = {u: k for k, u in enumerate(order)}
    left = set(small)
    while left:
        # faces of each sliver that is left with what is no sliver, or is a part of such a unit
        around: dict[int, dict[int, list[int]]] = {u: {} for u in left}
        for pair, rows in faces.items():
            for u, v in (pair, pair[::-1]):
                if u in left and home[v] not in left:
                    around[u].setdefault(home[v], []).extend(rows)

        # all at once: the order of slivers does not matter
        moves = {}
        for u, beside in around.items():
            if beside:
                shared = {v: rounded_sum(area[rows]) for v, rows in beside.items()}
                moves[u] = min(shared, key=lambda v: (-shared[v], rank[v]))
        if not moves:
            break
        for u, v in moves.items():
            home[u] = v
        left -= set(moves)
    return home


def rounded_sum(area: np.ndarray) -> float:
    """A sum of areas, to nine digits."""
    return float(f"{math.fsum(area.ravel().tolist()):.{DIGITS}g}")


def shared_faces(faces: Faces, home: Sequence[int]) -> dict[int, list[int]]:
    """Rows of the faces between each unit and the other parts of the unit that it is a part of.

    Examples
    --------
    >>> shared_faces({(0, 1): [0, 3], (1, 2): [4]}, [0, 0, 2])
    {0: [0, 3], 1: [0, 3]}
    """
    found: dict[int, list[int]] = {}
    for pair, rows in faces.items():
        if home[pair[0]] == home[pair[1]]:
            for u in pair:
                found.setdefault(u, []).extend(rows)
    return found


def surfaces_of(cells: Cells, faces: Sequence[int]) -> tuple[str, ...]:
    """Names of the surfaces that own some faces, sorted."""
    found = {int(cells.surface_of[row]) for row in faces}
    found |= {other for row in faces for other, _ in cells.also.get(row, ())}
    return tuple(sorted((cells.patches.names[i] for i in found), key=in_words))


def shared_area(cells: Cells, faces: Sequence[int]) -> float:
    """Area of some faces [m2]."""
    return math.fsum(cells.extent[np.array(faces, dtype=np.int64), AREA].ravel().tolist())
