"""Rotated grids with even steps as grids with straight axes, whose cells are found directly.

A linear map takes the mean steps of a grid to straight ones. It turns nothing over and keeps
elevations, so two triangles meet in the same edges and faces before and after. Nodes come to lie
near whole steps, off by a proven bound: how far they are from even steps, and what rounding adds.
What is decided of the mapped triangles holds under any such move (`axis_grids`); what a move could
change is decided by the coordinates themselves.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.arrangement.tree import Tree
from geosurf.model import Lattice
from geosurf.model.map_frame import MapFrame
from geosurf.model.survey import Survey

_ROUNDING = 2.0**-48  # of sizes: sixteen units in the last place, for a few sums and products
_STRAIGHT, _MAPPED = "_straight", "_mapped"  # remembered on lattices


class StraightMap:
    """
    The linear map of a grid to straight axes.

    Parameters
    ----------
    frame : MapFrame
        Of a right-handed grid.
    first : (float, float)
        Easting and northing of its first node.

    Attributes
    ----------
    steps : (float, float)
        Of the straight axes [m]: powers of two, so that their multiples are exact.
    matrix : ndarray, shape (2, 2)
        Of differences (east, north) to differences (along columns, along rows).
    norm : float
        No difference becomes longer by more than this factor.
    """

    def __init__(self, frame: MapFrame, first: tuple[float, float]) -> None:
        self.key = frame, first
        self.frame, self.first = frame, np.array(first)
        steps = [2.0 ** round(math.log2(math.hypot(*of))) for of in (frame.column, frame.row)]
        self.steps = steps[0], steps[1]
        turned = np.array([frame.column, frame.row]).T
        self.matrix = np.diag(steps) @ np.linalg.inv(turned)
        self.norm = float(np.hypot.reduce(self.matrix, axis=None))
        self._off = np.abs(self.matrix @ turned - np.diag(steps)).sum(axis=0)

    def slip(self, shape: tuple[int, int], far: float, local: float) -> float:
        """No mapped coordinate of a node is farther off [m].

        Parameters
        ----------
        shape : (int, int)
            Of the grid with even steps.
        far : float
            The largest difference of a node from the first one [m].
        local : float
            What rounding in the local frame moves.
        """
        n_row, n_col = shape
        uneven = self.norm * (self.frame.off + 2.0 * local)
        steps = n_col * float(self._off[0]) + n_row * float(self._off[1])
        size = self.norm * far + n_col * self.steps[0] + n_row * self.steps[1]
        return 2.0 * (uneven + steps) + _ROUNDING * size

    def apply(self, lattice: Lattice) -> Lattice:
        """Return another lattice with mapped nodes, remembered on it until another map is asked."""
        kept = lattice.__dict__.get(_MAPPED)
        if kept is None or kept[0] != self.key:
            x, y = (of - at for of, at in zip(lattice.horizontal(), self.first, strict=True))
            m = self.matrix
            made = Lattice(
                m[0, 0] * x + m[0, 1] * y, m[1, 0] * x + m[1, 1] * y, lattice.elevation,
                lattice.rising, lattice.turned,
            )  # fmt: skip
            made.__dict__["survey"] = Survey.of(made.coordinates, made.places, quads=False)
            kept = lattice.__dict__[_MAPPED] = self.key, made
        found: Lattice = kept[1]
        return found


def straightened(
    lattices: tuple[Lattice, Lattice], trees: tuple[Tree, Tree], origin: np.ndarray, local: float
) -> tuple[tuple[Lattice, Lattice], np.ndarray, float] | None:
    """
    Return two grids as the first one with even steps, or else the second, has straight axes.

    Parameters
    ----------
    lattices : (Lattice, Lattice)
    trees : (Tree, Tree)
    origin : ndarray, shape (3,)
        Of the local frame [m].
    local : float
        What rounding in the local frame moves [m].

    Returns
    -------
    tuple or None
        Both grids, the origin of their frame, and how far nodes may be off [m]. None without even
        steps, or where the map would make lengths far larger.
    """
    for mine, other in ((0, 1), (1, 0)):
        one, two = lattices[mine], lattices[other]
        kept = one.__dict__.get(_STRAIGHT, False)
        if kept is False:
            kept = one.__dict__[_STRAIGHT] = _straight(one)
        if kept is None or not _is_plain(two):
            continue
        turn, straight = kept
        start = [*turn.first.tolist()] * 2
        ends = (tree.bounds[[0, 1, 3, 4]].tolist() for tree in trees)
        far = max(abs(x - o) for of in ends for x, o in zip(of, start, strict=True))
        slip = turn.slip(one.shape, 2.0 * far, local)
        if not slip < 1e-4 * min(turn.steps):
            continue
        both = straight, turn.apply(two)
        frame = np.array([0.0, 0.0, origin[2]])
        return (both if mine == 0 else both[::-1]), frame, slip
    return None


def _straight(lattice: Lattice) -> tuple[StraightMap, Lattice] | None:
    """A right-handed horizon with even steps with straight axes; None of others."""
    if not _is_plain(lattice) or lattice.easting.ndim != 2 or lattice.reverse is not None:
        return None
    frame = lattice.map_frame
    if not (frame.height > 0.0 and frame.determinant > 0.0):
        return None
    if not frame.off < 1e-5 * min(math.hypot(*frame.column), math.hypot(*frame.row)):
        return None
    turn = StraightMap(frame, (lattice.easting.item(0), lattice.northing.item(0)))
    if not turn.norm < 8.0:  # rows and columns nearly along one line
        return None
    n_row, n_col = lattice.shape
    axes = turn.steps[0] * np.arange(n_col), turn.steps[1] * np.arange(n_row)
    return turn, Lattice(*axes, lattice.elevation, lattice.rising)


def _is_plain(lattice: Lattice) -> bool:
    """Whether a lattice is in memory, and not torn."""
    return type(lattice) is Lattice
