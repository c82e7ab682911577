"""Prove that 2-D coordinates in a store are those of a rotated grid, chunk by chunk.

Each step between neighbours has to be near the mean step, as for grids in memory that are known not
to fold. Other grids are refused: whether they fold is decided from all triangles.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from geosurf.conventions import place
from geosurf.conventions.axes import compare_sums, gain_of_diagonals, sums_of_diagonals
from geosurf.errors import HorizonError
from geosurf.kernels.contacts.aligned_grids import first_uneven_step
from geosurf.model import Lattice
from geosurf.model.chunk_store import Store

_KERNEL_DECIDES = 1e-3  # as in `rising_diagonal`


class MapSurvey:
    """What is found of a grid with 2-D coordinates while its chunks pass by.

    Parameters
    ----------
    name : str
    easting, northing : Store
    """

    def __init__(self, name: str, easting: Store, northing: Store) -> None:
        self.name, self.stores = name, (easting, northing)
        n_row, n_col = easting.shape
        corners = [
            [float(of.read((i, i + 1), (j, j + 1))[0, 0]) for of in self.stores]
            for i, j in ((0, 0), (0, n_col - 1), (n_row - 1, 0))
        ]
        self.first = np.array(corners[0])
        self.frame = frame_of_steps(np.array(corners), n_row, n_col)
        self.off = 0.0
        self.sums: list[tuple[float, float, float]] = []

    def check(self, lattice: Lattice, corner: tuple[int, int]) -> None:
        """Refuse a part of the grid, from node `corner` on, of which a step is not near the mean.

        Raises
        ------
        HorizonError
        """
        x, y, _ = lattice.coordinates
        bad = int(first_uneven_step(x, y, lattice.places, self.frame))
        if bad >= 0:
            row, col = divmod(bad, lattice.shape[1])
            raise HorizonError(
                f"horizon {self.name!r}: its 2-D coordinates are not those of a rotated grid with "
                f"even steps: the step from node ({corner[0] + row}, {corner[1] + col}) at "
                f"{place((x[bad], y[bad]))} is far from the mean step. geosurf reads such grids in "
                "memory only: load it with da.load(), or select a part with da.isel(...).",
                surfaces=[self.name],
            )
        self.off = max(self.off, self._off(lattice, corner))
        if min(lattice.shape) > 1:  # tiles without cells add nothing
            self.sums.append(gain_of_diagonals(lattice.easting, lattice.northing))

    def _off(self, lattice: Lattice, corner: tuple[int, int]) -> float:
        """How far a node is from even steps, in cells."""
        det, ux, uy, vx, vy = self.frame.tolist()
        x, y = lattice.easting - self.first[0], lattice.northing - self.first[1]
        col, row = (vy * x - vx * y) / det, (ux * y - uy * x) / det
        rows, cols = (first + np.arange(n) for first, n in zip(corner, lattice.shape, strict=True))
        return max(float(np.abs(row - rows[:, None]).max()), float(np.abs(col - cols).max()))

    def found(self) -> np.ndarray:
        """`ChunkBounds.of_map` once all parts have passed."""
        gain, reach, size = (math.fsum(of) for of in zip(*self.sums, strict=True))
        if abs(gain) - reach > _KERNEL_DECIDES * size and size < 1e150:
            rising = gain > 0
        else:
            rising = self._rising_by_every_cell()
        marks = least_height(self.frame), float(self.frame[0] > 0), float(rising), self.off
        return np.array([*marks, *self.first, *self.frame[1:]])

    def _rising_by_every_cell(self) -> bool:
        """The rule of `rising_diagonal` from sums over all cells: near-ties of both diagonals."""
        rows, sums = self.stores[0].row_starts.tolist(), []
        for first, last in pairwise(rows):
            span = max(first - 1, 0), last
            if span[1] - span[0] > 1:
                x, y = (of.read(span, (0, of.shape[1])) for of in self.stores)
                sums.append(sums_of_diagonals(x, y))
        choice = compare_sums([math.fsum(of) for of in zip(*sums, strict=True)])
        if choice is None:
            raise HorizonError(
                f"horizon {self.name!r}: rounding decides which diagonals of its cells run from "
                "south-west to north-east, and geosurf decides that in memory only. Load it with "
                "da.load(), or turn its coordinates by a millionth of a degree.",
                surfaces=[self.name],
            )
        return choice > 0


def frame_of_steps(corners: np.ndarray, n_row: int, n_col: int) -> np.ndarray:
    """Return the frame of the mean steps of a lattice (5,), as `first_uneven_step` takes it.

    `corners` (3, 2) are its first node, and those at the end of the first row and column.
    """
    first, along, up = corners
    ux, uy = ((along - first) / (n_col - 1)).tolist()
    vx, vy = ((up - first) / (n_row - 1)).tolist()
    return np.array([ux * vy - uy * vx, ux, uy, vx, vy])


def least_height(frame: np.ndarray) -> float:
    """Return the least height of a triangle in the map [m], as ``Lattice.map_height``."""
    det, ux, uy, vx, vy = frame.tolist()
    return 0.3 * abs(det) / (math.sqrt(ux * ux + uy * uy) + math.sqrt(vx * vx + vy * vy))


__all__ = ["MapSurvey"]
