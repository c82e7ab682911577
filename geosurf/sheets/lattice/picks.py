"""The lattice of a horizon, whatever way the grid is turned, and the data on it: its picks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.conventions import rising_diagonal
from geosurf.errors import HorizonError
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
    def rising(self) -> bool:
        """Whether the diagonals of cells rise to the north-east, as those of gridded horizons."""
        return rising_diagonal(self.easting, self.northing)

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

    def to_cells(self, xy: np.ndarray) -> np.ndarray:
        """Places (n, 2) in cells of places (n, 2) [m]."""
        return self.to_lattice(xy) * self.stretch

    def from_cells(self, points: np.ndarray) -> np.ndarray:
        """Easting and northing [m] of points (n, 2 or more) in cells; other columns stay."""
        xy = self.to_world(points[:, :2] / self.stretch)
        return np.column_stack([xy, points[:, 2:]])

    def node_places(self, node: np.ndarray) -> np.ndarray:
        """Easting and northing (n, 2) of nodes, as they were given."""
        row, col = np.divmod(node, self.shape[1])
        if self.easting.ndim == 1:
            return np.stack([self.easting[col], self.northing[row]], axis=1)
        return np.stack([self.easting[row, col], self.northing[row, col]], axis=1)

    def cells_of_node(self, node: np.ndarray) -> np.ndarray:
        """Places (n, 2) of nodes in cells: columns and rows, stretched."""
        row, col = np.divmod(node, self.shape[1])
        return np.stack([col, row], axis=1) * self.stretch

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


@dataclass(frozen=True, eq=False)
class Picks:
    """Horizon data on a lattice.

    Attributes
    ----------
    name : str
    frame : Frame
    given_node : ndarray of int64, shape (n,), or None
        Row times n_col plus column; several picks may share one. None: pick k is that of node k.
    z : ndarray of float64, shape (n,)
        Elevation [m].
    """

    name: str
    frame: Frame
    given_node: np.ndarray | None
    z: np.ndarray

    @cached_property
    def node(self) -> np.ndarray:
        """Node of each pick, int64 (n,); requested for some picks, `nodes_of` costs less."""
        return np.arange(len(self.z)) if self.given_node is None else self.given_node

    def nodes_of(self, rows: np.ndarray) -> np.ndarray:
        """Nodes of some picks."""
        return rows if self.one_each else self.node[rows]

    @property
    def n_node(self) -> int:
        """Number of nodes of the lattice."""
        return self.frame.shape[0] * self.frame.shape[1]

    @cached_property
    def _rising(self) -> bool:
        """Whether picks come node by node, one each."""
        return self.given_node is None or bool((self.node[1:] > self.node[:-1]).all())

    @cached_property
    def one_each(self) -> bool:
        """Whether pick k is that of node k, for all nodes."""
        if self.given_node is None:
            return True
        return self._rising and len(self.node) == self.n_node

    @cached_property
    def _by_node(self) -> tuple[np.ndarray, np.ndarray]:
        """Picks node by node, and their nodes."""
        order = np.argsort(self.node, kind="stable")
        return order, self.node[order]

    @cached_property
    def several(self) -> np.ndarray | None:
        """Whether nodes have more than one pick, bool (n_node,); None if none has."""
        if self._rising or not (many := np.bincount(self.node, minlength=self.n_node) > 1).any():
            return None
        return many

    @cached_property
    def means(self) -> np.ndarray:
        """Mean of the picks of each node (n_node,), NaN without; not to be written to."""
        # most grids have one pick per node, in order: no other array is made for them
        if self.one_each:
            return self.z

        # without doubles the mean is the pick itself, bit for bit
        if self.several is None:
            found = np.full(self.n_node, np.nan)
            found[self.node] = self.z
            return found
        count = np.bincount(self.node, minlength=self.n_node)
        with np.errstate(invalid="ignore"):
            return np.bincount(self.node, self.z, self.n_node) / count

    def of_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """Picks of some nodes, both increasing."""
        if self.one_each:
            return nodes
        if self._rising:
            at = np.searchsorted(self.node, nodes)
            return at[self.node[np.minimum(at, len(self.node) - 1)] == nodes]

        # runs of picks of each node in the sorted list, all at once
        order, node = self._by_node
        start, stop = (np.searchsorted(node, nodes, side=side) for side in ("left", "right"))
        count = stop - start
        rows = np.repeat(start - np.cumsum(count) + count, count) + np.arange(count.sum())
        return np.sort(order[rows])

    def means_at(self, nodes: np.ndarray, used: np.ndarray) -> np.ndarray:
        """Mean of the picks in use, bool (n_pick,), at some increasing nodes; NaN without."""
        # sums and counts over the asked nodes only; 0 / 0 is NaN where no pick is in use
        rows = self.of_nodes(nodes)
        rows = rows[used[rows]]
        at = np.searchsorted(nodes, self.nodes_of(rows))
        count = np.bincount(at, minlength=len(nodes))
        with np.errstate(invalid="ignore"):
            return np.bincount(at, self.z[rows], len(nodes)) / count

    def columns(self, rows: np.ndarray) -> np.ndarray:
        """Column and row (n, 2) of some picks."""
        return self.frame.uv_of_node(self.nodes_of(rows))

    def corners_of(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nodes (n, k) that some picks lie between, and their shares (n, k): one node each."""
        return self.nodes_of(rows)[:, None].copy(), np.ones((len(rows), 1))

    @property
    def on_nodes(self) -> bool:
        """Whether each pick is the height of a node."""
        return True

    def missed(self, values: np.ndarray, used: np.ndarray) -> np.ndarray:
        """Picks in use, bool (n_pick,), that heights (n_node,) do not meet bit for bit."""
        values = values if self.one_each else values[self.node]
        return np.flatnonzero((values != self.z) & used)

    def misfit(self, values: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Distance [m] of some picks from heights (n_node,) of a sheet."""
        return np.abs(values[self.nodes_of(rows)] - self.z[rows])

    def places(self, picks: np.ndarray) -> np.ndarray:
        """World coordinates (n, 3) of some picks."""
        return np.column_stack([self.frame.node_places(self.nodes_of(picks)), self.z[picks]])


# ---- noise ----------------------------------------
# Noise of data on a lattice, and the weight of noisy data against the smoothness of the surface.
#
# Third differences are taken at steps of one node and more. Those of a smooth signal grow with the
# cube of the step, those of noise do not: this separates the two.


ROWS = 400  # rows and columns that are looked at
STEPS = (1, 2, 4, 8)  # nodes
SEEN = 3.0  # variance of third differences, in those of noise, from which there is a signal
LOUD = 0.01  # cells: noise below this does not move a cut-off, data are then met exactly
# of the weight: docs/validation/torn_sheets.md has what 5 to 40 do on known worlds
GAIN = 10.0
# of the signal: noise below this leaves fourth differences; docs/decisions/heights_at_faults.md
FAINT = 0.15
LEAST = 1e-4  # weight: means over five cells, a third of the collar in which noise is smoothed


@dataclass(frozen=True)
class Noise:
    """Noise of the data of a horizon, and what follows for a solve.

    Attributes
    ----------
    deviation : float
        Standard deviation of the noise [m].
    weight : float or None
        Weight of data against the smoothness of the surface; None: data are met exactly.
    signal : float
        Typical third difference of the surface itself [m].
    highest : int
        Order of differences that is not exceeded, whatever data allow: 3 or 4.
    is_given : bool
        Whether the deviation was given, so that data are to be averaged; estimated otherwise.
    """

    deviation: float = 0.0
    weight: float | None = None
    signal: float = 0.0
    highest: int = 4
    is_given: bool = False

    @property
    def energy(self) -> float:
        """Energy of one standard deviation of noise; 0 for data that are met exactly."""
        return 0.0 if self.weight is None else self.weight * self.deviation**2

    @property
    def scale(self) -> float:
        """Cells over which noisy data are averaged; 1 for data that are met exactly."""
        return scale_of(self.weight)

    @property
    def order(self) -> int:
        """Of the highest differences that are small in the surface: 4 where data allow it, or 3."""
        is_exact = self.weight is None and self.deviation < FAINT * self.signal
        return min(4 if is_exact else 3, self.highest)


def noise_of(heights: np.ndarray) -> tuple[float, float]:
    """Standard deviation of noise, and typical third difference of the signal, of a grid [m]."""
    # Variance of third differences over 1 and 2 cells: noise gives both the same, a smooth
    # signal gives the second one 2**6 = 64 times as much.
    single, double = map_threads(_spread, [(heights, step) for step in STEPS[:2]])
    if not np.isfinite(double):
        return 0.0, 0.0
    signal = max((double - single) / 63.0, 0.0)
    noise = max(single - signal, 0.0)

    # wider steps see a faint signal under strong noise: it grows as step**6, noise does not
    for step in STEPS[1:]:
        now = double if step == STEPS[1] else _spread(heights, step)
        if np.isfinite(now):  # the first step at which the signal stands out measures it best
            signal = max((now - noise) / (step**6 - 1), 0.0)
            if now > SEEN * noise:
                break

    # a third difference of independent noise has 1 + 9 + 9 + 1 = 20 times its variance
    return float(np.sqrt(noise / 20.0)), float(np.sqrt(signal))


def signal_of(heights: np.ndarray) -> float:
    """Typical third difference of a grid that noise was taken out of [m], by its widest steps."""
    for step in STEPS[::-1]:
        spread = _spread(heights, step)
        if np.isfinite(spread):
            return float(np.sqrt(spread)) / step**3
    return 0.0


def _spread(heights: np.ndarray, step: int) -> float:
    """Variance of third differences over rows and columns, none of them across a hole."""
    # a sample of rows and columns is enough for two variances
    n_row, n_col = (max(n // ROWS, 1) for n in heights.shape)
    sizes = np.concatenate([_third(z, step) for z in (heights[::n_row], heights[:, ::n_col].T)])
    if not len(sizes):
        return np.nan
    # medians, since data beside faults may have outliers: 1.4826 makes them deviations
    return float((1.4826 * np.median(sizes, overwrite_input=True)) ** 2)


def _third(lines: np.ndarray, step: int) -> np.ndarray:
    """Sizes of third differences along lines (n, n_node), of nodes with no hole between them."""
    reach = 3 * step
    if lines.shape[1] <= reach:
        return np.empty(0)
    a, b, c = (lines[:, k * step : lines.shape[1] - reach + k * step] for k in range(3))
    holes = np.cumsum(np.pad(np.isnan(lines), ((0, 0), (1, 0))), axis=1)
    whole = holes[:, reach + 1 :] == holes[:, : -reach - 1]
    return np.abs((lines[:, reach:] - a) - 3.0 * (c - b))[whole]


def weight_of(noise: float, signal: float, cell: float) -> float | None:
    """Weight of noisy data against the smoothness of the sheet; None to meet them exactly.

    An average over h cells errs by about signal h^3 and noise / h. Both are equal at
    h^-6 = (signal / noise)^1.5, and h^-6 is the weight at which third differences average over h.
    """
    # the ratio of signal to noise sets over how many cells data are averaged
    if noise <= LOUD * cell:
        return None
    return float(np.clip(GAIN * (signal / noise) ** 1.5, LEAST, 1.0))


def scale_of(weight: float | None) -> float:
    """Cells over which data of a weight are averaged; 1 where they are met exactly."""
    return 1.0 if weight is None else weight ** (-1.0 / 6.0)
