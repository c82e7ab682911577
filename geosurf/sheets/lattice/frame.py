"""The lattice of a horizon: places in cells, whatever way the grid is turned."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from geosurf.errors import HorizonError
from geosurf.kernels.sheets.node_bands import places_of_nodes
from geosurf.model import Lattice, frozen

SAMPLE = 4000  # nodes that the lattice is fitted to
KEPT = 1 << 20  # nodes: frames of larger grids are not remembered
REGULAR = 1e-2  # cells: nodes farther from their place than this make no regular lattice


@dataclass(frozen=True, eq=False)
class Frame:
    """A regular lattice: column and row from easting and northing, and back.

    Attributes
    ----------
    shape : (n_row, n_col)
    corner : ndarray, shape (2,)
        Easting and northing of node (0, 0) [m].
    step : ndarray, shape (2, 2)
        One column and one row on [m]; at right angles, right-handed.
    easting, northing : ndarray
        Coordinates of the nodes as they were given, 1-D or 2-D as in `Lattice`.
    """

    shape: tuple[int, int]
    corner: np.ndarray
    step: np.ndarray
    easting: np.ndarray
    northing: np.ndarray

    @cached_property
    def spacing(self) -> np.ndarray:
        """Length of a column and of a row step [m]."""
        return frozen(np.hypot(*self.step.T), np.float64)

    @cached_property
    def cell(self) -> float:
        """Mean step [m]: the length called one cell."""
        return float(np.sqrt(self.spacing.prod()))

    @cached_property
    def stretch(self) -> np.ndarray:
        """Cells per column and per row."""
        return frozen(self.spacing / self.cell, np.float64)

    @cached_property
    def places(self) -> np.ndarray:
        """Places (n_node, 2) of all nodes from the corner, by the steps [m]."""
        return frozen(self.uv_of_node(np.arange(self.shape[0] * self.shape[1])) @ self.step, float)

    def to_lattice(self, xy: np.ndarray) -> np.ndarray:
        """Column and row (n, 2) of places (n, 2) [m]."""
        return np.linalg.solve(self.step.T, (xy - self.corner).T).T

    def to_world(self, uv: np.ndarray) -> np.ndarray:
        """Easting and northing (n, 2) [m] of columns and rows."""
        return self.corner + uv @ self.step

    def node_places(self, node: np.ndarray) -> np.ndarray:
        """Easting and northing (n, 2) of nodes, as they were given."""
        row, col = np.divmod(node, self.shape[1])
        if self.easting.ndim == 1:
            return np.stack([self.easting[col], self.northing[row]], axis=1)
        return np.stack([self.easting[row, col], self.northing[row, col]], axis=1)

    def cells_of_node(self, node: np.ndarray) -> np.ndarray:
        """Places (n, 2) of nodes in cells: columns and rows, stretched."""
        wide, tall = self.stretch.tolist()
        return places_of_nodes(node, self.shape[1], wide, tall)

    def uv_of_node(self, node: np.ndarray) -> np.ndarray:
        """Column and row (n, 2) of nodes, float64."""
        row, col = np.divmod(node, self.shape[1])
        return np.stack([col, row], axis=1).astype(np.float64)


def frame_of_lattice(lattice: Lattice, what: str) -> tuple[Frame, np.ndarray]:
    """The frame of a gridded horizon and its elevations, rows turned so that it is right-handed.

    Raises
    ------
    HorizonError
        If steps are uneven or not at right angles.
    """
    x, y = lattice.easting, lattice.northing
    z = lattice.elevation

    # rows turned around: all stages after this one count anticlockwise from the lower left
    if not lattice.right_handed:
        z = z[::-1]
        x, y = (x, y[::-1]) if x.ndim == 1 else (x[::-1], y[::-1])
    n_row, n_col = z.shape

    if x.ndim == 1 and z.size <= KEPT:
        # of all horizons of a grid, and of all realisations of one
        frame, off, lean = _frame_of_axes(x.tobytes(), y.tobytes())
    else:
        frame, off, lean = _fitted(x, y, (n_row, n_col))
    if off > REGULAR or lean > REGULAR:
        raise HorizonError(
            f"{what}: tearing needs even steps at right angles, but nodes lie up to {off:.3g} "
            f"cells off a regular lattice and its axes lean by {lean:.3g}. Resample it on a "
            "regular grid."
        )
    return frame, np.ascontiguousarray(z)


@lru_cache(maxsize=4)
def _frame_of_axes(x: bytes, y: bytes) -> tuple[Frame, float, float]:
    """What `_fitted` gives of two axes, float64."""
    axes = np.frombuffer(x, np.float64), np.frombuffer(y, np.float64)
    return _fitted(*axes, (len(axes[1]), len(axes[0])))


def _fitted(x: np.ndarray, y: np.ndarray, shape: tuple[int, int]) -> tuple[Frame, float, float]:
    """The frame of some nodes, how far they are off it [cells], and how far its axes lean."""
    # fit the lattice to a sample of nodes, then measure how far they are off it
    n_col = shape[1]
    known = np.arange(shape[0] * n_col)
    if x.ndim == 2:
        known = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if len(known) > SAMPLE:
        known = known[np.linspace(0, len(known) - 1, SAMPLE).astype(np.int64)]
    row, col = np.divmod(known, n_col)
    where = np.stack([x[col], y[row]] if x.ndim == 1 else [x[row, col], y[row, col]], axis=1)
    corner, step = fit_steps(np.stack([col, row], axis=1), where)
    frame = Frame(shape, corner, step, x, y)

    # lean: cosine between both axes, 0 at right angles
    off = np.abs(frame.to_lattice(where) - np.stack([col, row], axis=1)).max()
    lean = abs(float(step[0] @ step[1])) / float(frame.spacing.prod())
    return frame, float(off), lean


def fit_steps(ij: np.ndarray, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corner (2,) and steps (2, 2) of the lattice that fits numbered places best."""
    # from the mean: world coordinates have millions of metres, steps only a few
    middle = xy.mean(axis=0)
    design = np.column_stack([np.ones(len(ij)), ij])
    found, *_ = np.linalg.lstsq(design, xy - middle, rcond=None)
    return found[0] + middle, found[1:]
