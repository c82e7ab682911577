"""Lines parallel to pillars: how long each is inside each unit.

In the coordinates of the lattice pillars are vertical, so that the exact signs of
`geosurf.measure.columns` decide what a line meets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.measure.columns import cross_columns


@dataclass(frozen=True, eq=False)
class Shell:
    """The closed boundary of a unit, in coordinates of the lattice.

    Attributes
    ----------
    zone, region : int
    x : ndarray of float64, shape (n_vertex, 3)
        Along I and J in cells, elevation [m].
    triangles : ndarray of int64, shape (n_triangle, 3)
    """

    zone: int
    region: int
    x: np.ndarray
    triangles: np.ndarray


@dataclass(frozen=True, eq=False)
class Pieces:
    """The length of each line in each unit that it meets, sorted by line, then from the top down.

    Attributes
    ----------
    line, zone, region : ndarray of int64, shape (n,)
    length, top : ndarray of float64, shape (n,)
        Length, and elevation of the highest point [m].
    """

    line: np.ndarray
    zone: np.ndarray
    region: np.ndarray
    length: np.ndarray
    top: np.ndarray


def pieces_along(shells: Sequence[Shell], feet: np.ndarray, middle: np.ndarray) -> Pieces:
    """
    Find how long lines are inside units.

    Parameters
    ----------
    shells : sequence of Shell
    feet : ndarray of float64, shape (n, 2)
        In coordinates of the lattice.
    middle : ndarray of float64, shape (2,)
        Feet on a rim count as if they were a little nearer to this.

    Returns
    -------
    Pieces
    """
    nothing = np.empty(0)
    parts: list[tuple[np.ndarray, int, int, np.ndarray, np.ndarray]] = [
        (np.empty(0, np.int64), 0, 0, nothing, nothing)
    ]
    for shell in shells:
        found = cross_columns(shell.x, shell.triangles, feet, middle)
        if not len(found.foot):
            continue

        # a line leaves through the top (+) and enters through the base (-); heights count from the
        # level of the unit, so that little is lost in the sum
        level = float(np.round(shell.x[:, 2].mean()))
        n = len(feet)
        length = np.bincount(found.foot, found.way * (found.elevation - level), minlength=n)
        top = np.full(n, -np.inf)
        np.maximum.at(top, found.foot, found.elevation)
        rows = np.flatnonzero(length > 0.0)
        parts.append((rows, shell.zone, shell.region, length[rows], top[rows]))
    line, length, top = (np.concatenate([part[k] for part in parts]) for k in (0, 3, 4))
    zone, region = (np.repeat([p[k] for p in parts], [len(p[0]) for p in parts]) for k in (1, 2))
    order = np.lexsort((-top, zone, line))
    return Pieces(line[order], zone[order], region[order], length[order], top[order])
