r"""Gaussian random fields on a regular lattice, by FFT, and conditioned to known values.

A stationary covariance on a torus is a circulant matrix :math:`C = F^* E F`: the Fourier transform
diagonalises it, and its eigenvalues :math:`E` are the transform of one row. White noise
:math:`\xi` becomes a field of exactly this covariance: :math:`f = F^* \sqrt{E} F \xi`. The torus is
so much larger than the lattice that two ends of the lattice are independent across its seam
(`Covariance.independent`), and it takes the covariance summed over all images, whose
eigenvalues are never negative.

Known values :math:`W f = d` are met by simple kriging of the residual with the same covariance:
:math:`f + C W^T (W C W^T)^{-1} (d - W f)`. The product with :math:`C` is one more transform.

Dietrich and Newsam (1997), SIAM J. Sci. Comput. 18(4); Chiles and Delfiner (2012), Geostatistics,
sections 7.3 and 7.5.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.fft import next_fast_len
from scipy.sparse import csr_matrix

from geosurf.conventions import check_word, is_number, length_text, place
from geosurf.errors import InputError
from geosurf.model import Lattice

# ---- field grid ----------------------------------------
# The regular lattice that a random field is simulated on: nodes of a horizon, or its own.


REGULAR = 1e-6  # of a cell: how far nodes may be off for distances, which decide nothing else


@dataclass(frozen=True, eq=False)
class FieldGrid:
    """
    Nodes in rows and columns of equal steps, at any angle.

    Attributes
    ----------
    corner : ndarray of float64, shape (2,)
        Easting and northing of the first node [m].
    steps : ndarray of float64, shape (2, 2)
        From row to row, and from column to column [m]; at right angles.
    shape : (n_row, n_col)

    Examples
    --------
    >>> grid = FieldGrid.around(np.array([[0.0, 0.0], [100.0, 40.0]]), 20.0)
    >>> float(grid.cell[0]), (grid.weights_at(np.array([[50.0, 20.0]])).sum().round(12)).item()
    (20.0, 1.0)
    """

    corner: np.ndarray
    steps: np.ndarray
    shape: tuple[int, int]

    @classmethod
    def of_lattice(cls, lattice: Lattice) -> FieldGrid | None:
        """Return the grid of a horizon's nodes; None if these are not in equal steps."""
        n_row, n_col = lattice.shape
        # A single row has no step across.
        if min(n_row, n_col) < 2:
            return None
        x, y = lattice.horizontal()
        # Steps from the first to the last node average what rounding did to each.
        corner = np.array([x[0, 0], y[0, 0]])
        last_row = np.array([x[-1, 0], y[-1, 0]]) - corner
        last_col = np.array([x[0, -1], y[0, -1]]) - corner
        steps = np.stack([last_row / (n_row - 1), last_col / (n_col - 1)])
        cell = np.hypot(*steps.T)
        # Absent corners: the grid may be regular, but nothing proves it.
        if not (np.isfinite(steps).all() and cell.min() > 0):
            return None

        # every node where the steps lead, and rows at right angles to columns
        i, j = np.arange(n_row)[:, None], np.arange(n_col)[None, :]
        off = max(
            float(np.abs(values - (corner[k] + i * steps[0, k] + j * steps[1, k])).max())
            for k, values in enumerate((x, y))
        )
        skew = abs(float(steps[0] @ steps[1])) / float(cell[0] * cell[1])
        if not (off <= REGULAR * cell.min() and skew <= REGULAR):
            return None
        return cls(corner, steps, (n_row, n_col))

    @classmethod
    def around(cls, places: np.ndarray, cell: float) -> FieldGrid:
        """Return an axis-parallel grid around places (n, 2), two nodes wider on each side."""
        low, high = places.min(axis=0), places.max(axis=0)
        # Two nodes more on each side, so that cubic interpolation finds its neighbours.
        n_col, n_row = (np.ceil((high - low) / cell).astype(int) + 5).tolist()
        # Rows run north, columns east.
        steps = np.array([[0.0, cell], [cell, 0.0]])
        return cls(low - 2.0 * cell, steps, (n_row, n_col))

    @property
    def cell(self) -> np.ndarray:
        """Distance between rows and between columns [m], float64 (2,)."""
        made: np.ndarray = np.hypot(*self.steps.T)
        return made

    @property
    def n_node(self) -> int:
        """Number of nodes."""
        return self.shape[0] * self.shape[1]

    def weights_at(self, places: np.ndarray) -> Any:
        """
        Return the weights of nodes in the values at places, by cubic convolution.

        Parameters
        ----------
        places : ndarray of float64, shape (n, 2)
            Inside of the grid.

        Returns
        -------
        scipy.sparse.csr_matrix
            (n, n_node): 1 for one node where a place is a node.
        """
        # Rows and columns as real numbers, also for a rotated lattice.
        offset = (places - self.corner) @ np.linalg.inv(self.steps)
        # The last node belongs to the last cell.
        base = np.clip(np.floor(offset), 0, np.array(self.shape) - 2).astype(np.int64)
        rows, rising = _cubic(offset[:, 0] - base[:, 0], base[:, 0], self.shape[0])
        cols, across = _cubic(offset[:, 1] - base[:, 1], base[:, 1], self.shape[1])
        nodes = rows[:, :, None] * self.shape[1] + cols[:, None, :]
        # The weights of a product of two cubics.
        weights = rising[:, :, None] * across[:, None, :]
        n = len(places)
        indptr = np.arange(n + 1) * 16
        matrix = csr_matrix((weights.ravel(), nodes.ravel(), indptr), shape=(n, self.n_node))
        # At the boundary a node stands for several: its weights add up.
        matrix.sum_duplicates()
        matrix.eliminate_zeros()
        return matrix


def _cubic(t: np.ndarray, base: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Four nodes along one axis and their weights (n, 4); beyond an end, the end itself."""
    # Outside, the value at the boundary.
    t = np.clip(t, 0.0, 1.0)
    # Cubic convolution (Keys 1981) with a = -1/2: exact at nodes and for parabolas.
    weights = 0.5 * np.stack(
        [
            t * (t * (2.0 - t) - 1.0),
            t * t * (3.0 * t - 5.0) + 2.0,
            t * (t * (4.0 - 3.0 * t) + 1.0),
            t * t * (t - 1.0),
        ],
        axis=1,
    )
    return np.clip(base[:, None] + np.arange(-1, 3), 0, n - 1), weights


# ---- covariance ----------------------------------------
# How errors at two places are related: covariance as a function of their distance.


# correlation of each model, 5 % (0 for the spherical one) at a distance of one range
_MODELS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "gaussian": lambda h: np.exp(-3.0 * h * h),
    "exponential": lambda h: np.exp(-3.0 * h),
    "spherical": lambda h: np.where(h < 1.0, 1.0 - 1.5 * h + 0.5 * h**3, 0.0),
}
MODELS = tuple(_MODELS)
# beyond so many ranges two errors are independent, to 1e-5 (gaussian) and 1e-4 of the variance
_INDEPENDENT = {"gaussian": 2.0, "exponential": 3.0, "spherical": 1.0}
# field nodes per range where a field is not simulated on the nodes of a horizon
_NODES_PER_RANGE = {"gaussian": 16, "exponential": 40, "spherical": 40}


@dataclass(frozen=True)
class Covariance:
    """
    Covariance of a stationary field, which depends on distance in the map only.

    Parameters
    ----------
    sd : float
        Standard deviation [m]; the sill is its square.
    range : float
        Distance at which the correlation has fallen to 5 % (``"spherical"``: to 0) [m].
    model : {"gaussian", "exponential", "spherical"}
        Gaussian: smooth errors, as of depth conversion. The others are rough.

    Raises
    ------
    InputError
        If a number is not above 0, or the model is unknown.

    Examples
    --------
    >>> smooth = Covariance(sd=10.0, range=1000.0)
    >>> smooth.at([0.0, 1000.0]).round(1).tolist()
    [100.0, 5.0]
    """

    sd: float
    range: float
    model: str = "gaussian"

    def __post_init__(self) -> None:
        # The message shows what a sensible value looks like.
        for key, example in (("sd", 10), ("range", 1500)):
            value = getattr(self, key)
            if not (is_number(value) and value > 0):
                raise InputError(
                    f"depth error: {key} is {value!r}; give metres above 0, as in {key}={example}."
                )
        refusal = f"depth error: model is {self.model!r}; it must be one of {', '.join(MODELS)}."
        check_word(self.model, MODELS, refusal)

    @property
    def independent(self) -> float:
        """Distance from which two errors are practically independent [m]."""
        # Errors beyond this distance need no common lattice: it sets the size of the torus.
        return float(self.range) * _INDEPENDENT[self.model]

    @property
    def cell(self) -> float:
        """Cell of a lattice that resolves the field [m]."""
        # Rough fields change within a cell: they need more nodes per range.
        return float(self.range) / _NODES_PER_RANGE[self.model]

    def at(self, distance: np.ndarray | list[float]) -> np.ndarray:
        """Return the covariance [m2] at distances [m]."""
        # In units of the range, so that one formula serves all ranges.
        h = np.asarray(distance, dtype=np.float64) / float(self.range)
        return float(self.sd) ** 2 * _MODELS[self.model](h)


LARGEST = 1 << 24  # nodes of a torus
MET = 1e-6  # of the standard deviation: how near a conditioned field comes to known values


class GaussianField:
    """
    A random field with mean 0 on the nodes of a lattice.

    Parameters
    ----------
    grid : FieldGrid
    covariance : Covariance
    known : scipy.sparse matrix, shape (n_known, n_node), optional
        Weights of the nodes in each known value.
    values : ndarray of float64, shape (n_known,), optional
        What these are [m].
    places : ndarray of float64, shape (n_known, 2), optional
        Where they are, for messages.

    Raises
    ------
    InputError
        If the range needs too many nodes, or known values contradict each other.

    Examples
    --------
    >>> grid = FieldGrid.around(np.array([[0.0, 0.0], [4000.0, 3000.0]]), 50.0)
    >>> field = GaussianField(grid, Covariance(sd=10.0, range=800.0))
    >>> error = field.simulate(np.random.default_rng(1))
    >>> error.shape == grid.shape, bool(5 < error.std() < 15)
    (True, True)
    """

    def __init__(
        self,
        grid: FieldGrid,
        covariance: Covariance,
        known: Any = None,
        values: np.ndarray | None = None,
        places: np.ndarray | None = None,
    ) -> None:
        self.grid, self.covariance = grid, covariance
        self.torus = torus_of(grid, covariance)
        # An empty matrix conditions nothing.
        self.known: Any = known if known is not None and known.shape[0] else None
        self.values = np.zeros(0) if values is None else np.asarray(values, dtype=np.float64)
        self.places = places
        if self.known is not None:
            self._check_known()

    def __getstate__(self) -> dict[str, Any]:
        """What goes to other processes: without what a transform gives again to the last bit."""
        # Large arrays that each process computes again, instead of sending them.
        again = ("row", "eigenvalues", "_roots", "_between_known")
        return {key: value for key, value in self.__dict__.items() if key not in again}

    # ---- the covariance on the torus -----------------------------------------------------

    @cached_property
    def row(self) -> np.ndarray:
        """Covariance of the first node of the torus with all nodes [m2], over all images."""
        total: np.ndarray = np.zeros(self.torus)
        # The neighbouring images of the lattice on the torus; farther ones add nothing.
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                down = (np.arange(self.torus[0]) + i * self.torus[0]) * self.grid.cell[0]
                right = (np.arange(self.torus[1]) + j * self.torus[1]) * self.grid.cell[1]
                total += self.covariance.at(np.hypot(down[:, None], right[None, :]))
        # symmetric to rounding; made so exactly, so that the eigenvalues are real
        total += _turned(total, 0)
        total += _turned(total, 1)
        return 0.25 * total

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """Of the covariance, for the half of the frequencies that a real transform has."""
        # Rounding may leave small negative ones.
        found: np.ndarray = np.maximum(np.fft.rfft2(self.row).real, 0.0)
        return found

    @cached_property
    def _roots(self) -> np.ndarray:
        roots: np.ndarray = np.sqrt(self.eigenvalues)
        return roots

    def _filtered(self, source: np.ndarray, factor: np.ndarray) -> np.ndarray:
        """A product with the covariance or its root, on the nodes of the lattice."""
        # One real transform there and back: n log n for n nodes.
        made = np.fft.irfft2(factor * np.fft.rfft2(source), s=self.torus, norm="forward")
        # The torus beyond the lattice only separates its ends.
        inside: np.ndarray = made[: self.grid.shape[0], : self.grid.shape[1]]
        # scaled once, not axis by axis
        return inside * (1.0 / (self.torus[0] * self.torus[1]))

    # ---- known values --------------------------------------------------------------------

    @cached_property
    def _between_known(self) -> np.ndarray:
        """Covariance between known values (n_known, n_known) [m2]."""
        weights = self.known.tocoo()
        # Covariance depends on the lag only, so rows of the torus give all of it.
        n, n_col = self.known.shape[0], self.grid.shape[1]
        row, col = np.divmod(weights.col.astype(np.int64), n_col)
        covariance = np.zeros((n, n))
        for k in range(n):
            of_place = weights.row == k
            lags = np.abs(row[of_place, None] - row), np.abs(col[of_place, None] - col)
            with_all = (weights.data[of_place, None] * self.row[lags]).sum(axis=0) * weights.data
            covariance[k] = np.bincount(weights.row, with_all, minlength=n)
        # Symmetric to the last bit: the inverse relies on it.
        return 0.5 * (covariance + covariance.T)

    @cached_property
    def _inverse(self) -> np.ndarray:
        """Of the covariance between known values; directions without variance are left out."""
        found: np.ndarray = np.linalg.pinv(self._between_known, rcond=1e-14, hermitian=True)
        return found

    def _check_known(self) -> None:
        """Refuse known values that no field of this covariance takes."""
        # The test is the result itself: does kriging meet the values?
        met = self._kriged(self.values)
        off = np.abs(self.known @ met.ravel() - self.values)
        worst = int(off.argmax())
        if off[worst] <= MET * max(self.covariance.sd, float(np.abs(self.values).max())):
            return
        where, nearest = "", ""
        # The nearest other pick is mostly the one that contradicts it.
        if self.places is not None:
            gap = np.hypot(*(self.places - self.places[worst]).T)
            gap[worst] = np.inf
            where = f" at {place(self.places[worst])}"
            nearest = f"; the next pick is {length_text(float(gap.min()))} away"
        raise InputError(
            f"a pick{where} cannot be met together with the others, to "
            f"{length_text(float(off[worst]))}{nearest}. Leave one of them out, or give a shorter "
            'range or model="exponential".'
        )

    def _kriged(self, residual: np.ndarray) -> np.ndarray:
        """The smoothest correction that takes some values; in two passes, so that it meets them."""
        # The second pass takes up what rounding left of the first.
        total = np.zeros(self.grid.shape)
        left = residual
        for _ in range(2):
            source = np.zeros(self.torus)
            # no BLAS here: its sums depend on the number of threads
            spread = self.known.T @ (self._inverse * left).sum(axis=1)
            source[: self.grid.shape[0], : self.grid.shape[1]] = spread.reshape(self.grid.shape)
            total = total + self._filtered(source, self.eigenvalues)
            left = residual - self.known @ total.ravel()
        return total

    # ---- realisations --------------------------------------------------------------------

    def simulate(self, stream: np.random.Generator) -> np.ndarray:
        """Return one realisation on the nodes of the lattice [m], float64 (n_row, n_col)."""
        # White noise, filtered by the root of the covariance.
        field: np.ndarray = self._filtered(stream.standard_normal(self.torus), self._roots)
        # Kriging of the residual: conditional simulation.
        if self.known is not None:
            field = field + self._kriged(self.values - self.known @ field.ravel())
        return field

    def mean(self) -> np.ndarray:
        """Return the mean of all realisations [m]: 0, or what known values make of it."""
        return np.zeros(self.grid.shape) if self.known is None else self._kriged(self.values)


def torus_of(grid: FieldGrid, covariance: Covariance) -> tuple[int, int]:
    """Return how many nodes a torus needs so that opposite ends of the lattice are independent.

    Raises
    ------
    InputError
        If there would be too many.
    """
    # Wide enough that errors at two ends are independent across the seam.
    wanted = np.array(grid.shape) + np.ceil(covariance.independent / grid.cell)
    if wanted.prod() > LARGEST:
        raise InputError(
            f"depth error: range {covariance.range:g} m with cells of {grid.cell.min():g} m "
            f"needs {wanted.prod():.2g} nodes, more than {LARGEST:.2g}. Give a longer range for "
            "horizons of this size, or a smaller area."
        )
    n_row, n_col = (next_fast_len(int(n), real=True) for n in wanted)
    return n_row, n_col


def _turned(row: np.ndarray, *axes: int) -> np.ndarray:
    """A row of the torus, counted backwards from its first node along some axes."""
    # The first node stays where it is.
    return np.roll(np.flip(row, axes), 1, axes)
