"""The survey of a lattice: bounds and checks from one pass over its nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geosurf.model.base import frozen

# ---- map frame ----------------------------------------
# Steps of a grid with 2-D coordinates in the map, and how far nodes are from even ones.


@dataclass(frozen=True)
class MapFrame:
    """
    What one pass over eastings and northings proves of a grid.

    Attributes
    ----------
    height : float
        No triangle is lower in the map [m], and none folds over another; 0: nothing is proven.
    column, row : (float, float)
        Mean steps to the next column and to the next row [m].
    off : float
        No node is farther from the first one and mean steps [m]; infinite where nothing is proven.

    Examples
    --------
    >>> MapFrame(10.0, (40.0, 30.0), (-30.0, 40.0), 1e-9).least_step
    (49.999999998, 49.999999998)
    """

    height: float
    column: tuple[float, float]
    row: tuple[float, float]
    off: float

    @classmethod
    def of(cls, found: np.ndarray) -> MapFrame:
        """Make one of what `geosurf.kernels.contacts.aligned_grids.map_frame` returns."""
        height, ux, uy, vx, vy, off = found.tolist()
        return cls(height, (ux, uy), (vx, vy), off)

    @property
    def determinant(self) -> float:
        """Of both steps, columns first [m2]."""
        return self.column[0] * self.row[1] - self.column[1] * self.row[0]

    @property
    def least_step(self) -> tuple[float, float]:
        """No step along columns, and along rows, is shorter [m]; below 0: nothing is proven."""
        return math.hypot(*self.column) - 2.0 * self.off, math.hypot(*self.row) - 2.0 * self.off


# sums over cells, where they were not requested
@dataclass(frozen=True, eq=False)
class Survey:
    """Boxes of blocks of cells, and holes: see `geosurf.kernels.lattices.survey`.

    Attributes
    ----------
    nodes : ndarray of float64, shape (n_node, 6)
        Lower, then upper corner around each block of nodes [m], row by row, and around all that is
        below each node of the pyramid above them; an absent number is ignored.
    levels : ndarray of int64, shape (n_level, 3)
        First node, rows and columns of each level: see `geosurf.kernels.search.tree`.
    n_triangles : tuple of int
        Triangles with three nodes, if diagonals fall and if they rise.
    numbers : tuple of bool
        Whether all eastings, northings and elevations are numbers, not NaN.
    minus_zero : bool
        Whether a coordinate is -0.0, whose bits differ from those of 0.0.
    axes_rise : bool
        Whether easting and northing are axes that rise strictly, with finite ends.
    """

    nodes: np.ndarray
    levels: np.ndarray
    n_triangles: tuple[int, int]
    numbers: tuple[bool, bool, bool]
    minus_zero: bool
    axes_rise: bool

    @classmethod
    def of(
        cls, coordinates: tuple[np.ndarray, np.ndarray, np.ndarray], places: np.ndarray
    ) -> Survey:
        """Pass over all nodes of a lattice once.

        `coordinates` and `places` are those of `geosurf.model.Lattice`.
        """
        from geosurf.kernels.lattices import survey

        nodes, levels, marks = survey.survey_lattice(*coordinates, places)
        counts = marks.tolist()
        return cls(
            nodes=frozen(nodes, np.float64),  # views: kernels take what is below as it is
            levels=frozen(levels, np.int64),
            n_triangles=(counts[survey.N_FALLING], counts[survey.N_RISING]),
            numbers=tuple(count == 0 for count in counts[survey.NOT_A_NUMBER :][:3]),
            minus_zero=bool(counts[survey.MINUS_ZERO]),
            axes_rise=bool(counts[survey.AXES_RISE]),
        )

    @property
    def finite_map(self) -> bool:
        """Whether all eastings and northings are finite, and no coordinate is -0.0."""
        return all(self.numbers[:2]) and self.finite and not self.minus_zero

    def over_same_map(self, elevation: np.ndarray, shape: tuple[int, int]) -> Survey:
        """Return the survey of other elevations, flat, of nodes with the same finite places.

        One pass over elevations alone: boxes in the map are those of this survey.
        """
        n_row, n_col = shape
        layout = np.array([0, 0, 0, 0, 0, 0, 0, n_col, 1, n_row, n_col, 0, 0, 1], dtype=np.int64)
        zero = np.zeros(1)
        found = Survey.of((zero, zero, elevation), layout)
        nodes = found.nodes.copy()
        nodes[:, :2], nodes[:, 3:5] = self.nodes[:, :2], self.nodes[:, 3:5]
        return replace(found, nodes=frozen(nodes, np.float64))

    @property
    def box(self) -> np.ndarray:
        """Lower and upper corner around all nodes [m], float64 (6,); inf and -inf around none."""
        around: np.ndarray = self.nodes[-1]
        return around

    @property
    def relief(self) -> float:
        """The largest difference in elevation inside of a block [m]: no step is higher."""
        # an empty block has its lower bound above its upper one
        leaves = self.nodes[: int(self.levels[0, 1] * self.levels[0, 2])]
        return float((leaves[:, 5] - leaves[:, 2]).max(initial=0.0))

    @cached_property
    def finite(self) -> bool:
        """Whether no coordinate is infinite."""
        # The box of all nodes shows infinite coordinates without another pass.
        box = self.box.tolist()
        return bool(min(box[:3]) > -math.inf and max(box[3:]) < math.inf)
