"""Distances to the boundaries of units, where horizons stay in their store."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from geosurf.measure.boundaries import Boundaries, tree_over
from geosurf.measure.parts import groups_by_tile
from geosurf.model import Lattice, Units
from geosurf.model.excerpt import Region, in_runs
from geosurf.model.pieces import Pieces
from geosurf.model.regions import Boxes, Feet

MOST_CELLS = 1 << 21  # cells that are listed at once


@dataclass(frozen=True, eq=False)
class StoredBoundaries(Boundaries):
    """
    The boundaries of all units: listed triangles in a tree, and runs of grids.

    Attributes
    ----------
    pieces : Pieces
    sides : ndarray of int64, shape (n_element, 2)
        Units in front of and behind each element of the pieces.
    """

    pieces: Pieces
    sides: np.ndarray

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of points (n, 3), in world coordinates, to the nearest triangle [m]."""
        # what is listed, and what is above and below a point: the nearest triangle is not farther
        nearest = super().distance(points)
        for rows in groups_by_tile(self.pieces, points[:, :2]):
            feet = Feet.rounded(points[rows, :2])
            nearest[rows] = self._nearer(points[rows], nearest[rows], partial(_same, feet))
        found = nearest.copy()
        for rows in self._groups(points, nearest):
            some, known = points[rows], nearest[rows]
            around = partial(_around, points=some, reach=known)
            found[rows] = self._nearer(some, known, around)
        return found

    def _groups(self, points: np.ndarray, reach: np.ndarray) -> Iterator[np.ndarray]:
        """Rows of points in groups whose cells are listed together."""
        lattices = [
            source.lattice for source, strips in zip(self.pieces.sources, self.pieces.strips,
                                                     strict=True) if strips is not None
        ]  # fmt: skip
        n_cell = np.zeros(len(points))
        for lattice in lattices:
            assert lattice is not None  # only lattices have strips
            low, high = lattice.survey.box[:2], lattice.survey.box[3:5]
            cell = np.sqrt((high - low).prod() / max(lattice.n_node, 1))
            n_cell += (2.0 * _reach_in_map(lattice, points, reach) / max(cell, 1e-9) + 2.0) ** 2
        for rows in groups_by_tile(self.pieces, points[:, :2]):
            group = (np.cumsum(n_cell[rows]) / MOST_CELLS).astype(np.int64)
            yield from np.split(rows, np.flatnonzero(np.diff(group)) + 1)

    def _nearer(
        self, points: np.ndarray, known: np.ndarray, region: Callable[[Lattice], Region]
    ) -> np.ndarray:
        """The same, or the distance to the nearest triangle of runs in a region of each grid."""
        pieces, n_core = self.pieces, len(self.pieces.triangles)
        for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
            if strips is None:
                continue
            assert source.lattice is not None  # only lattices have strips
            cells = region(source.lattice).cells(source.lattice)
            keys, run = in_runs(pieces, i, (2 * cells[:, None] + np.arange(2)).reshape(-1))
            front, behind = self.sides[n_core + run].T
            corners = source.lattice.corners_of_keys(keys[front != behind])
            if len(corners):
                used, triangles = np.unique(corners, return_inverse=True)
                x = source.places_of_nodes(used) - pieces.origin
                part = Boundaries(pieces.origin, *tree_over(x, triangles.reshape(-1, 3)))
                known = np.minimum(known, part.distance(points))
        return known


def _reach_in_map(lattice: Lattice, points: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """How far aside of points the nodes of a grid are at most, if they are within reach [m].

    Below 0 where none is.
    """
    bottom, top = lattice.survey.box[[2, 5]].tolist()
    gap = np.maximum(np.maximum(bottom - points[:, 2], points[:, 2] - top), 0.0)
    wide = reach * (1.0 + 1e-9) + 1e-9 * np.abs(points).max(initial=0.0)  # more than rounding
    found: np.ndarray = np.where(wide < gap, -1.0, np.sqrt(np.maximum(wide**2 - gap**2, 0.0)))
    return found


def _same(region: Region, _: Lattice) -> Region:
    """One region for all grids."""
    return region


def _around(lattice: Lattice, points: np.ndarray, reach: np.ndarray) -> Boxes:
    """Boxes in the map around the points that a grid may be within reach of."""
    aside = _reach_in_map(lattice, points, reach)
    some = aside >= 0.0
    places, aside = points[some, :2], aside[some, None]
    return Boxes(places - aside, places + aside)


def stored_boundaries_of(units: Units) -> StoredBoundaries:
    """Put the listed triangles that bound a unit into a tree; runs of grids are read later."""
    pieces, sides = units.piece_sides
    front, behind = sides[: len(pieces.triangles)].T
    tree = tree_over(pieces.x, pieces.triangles[front != behind])
    return StoredBoundaries(pieces.origin, *tree, pieces, sides)


__all__ = ["StoredBoundaries", "stored_boundaries_of"]
