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

from functools import cached_property
from typing import Any

import numpy as np

from geosurf.conventions import length_text, place
from geosurf.ensemble.covariance import Covariance
from geosurf.ensemble.field_grid import FieldGrid
from geosurf.errors import InputError

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
        found = np.zeros((n, n))
        for k in range(n):
            mine = weights.row == k
            lags = np.abs(row[mine, None] - row), np.abs(col[mine, None] - col)
            with_all = (weights.data[mine, None] * self.row[lags]).sum(axis=0) * weights.data
            found[k] = np.bincount(weights.row, with_all, minlength=n)
        # Symmetric to the last bit: the inverse relies on it.
        return 0.5 * (found + found.T)

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
    n_row, n_col = (_fast_length(int(n)) for n in wanted)
    return n_row, n_col


def _fast_length(n: int) -> int:
    """The least number from n on without prime factors above 5: such lengths transform fastest.

    `scipy.fft` has one, and takes a quarter of a second to load.
    """
    odds = (3**i * 5**j for i in range(25) for j in range(17))
    # times the power of two that brings each to n at least
    fitting: list[int] = [odd << (-(-n // odd) - 1).bit_length() for odd in odds]
    return min(fitting)


def _turned(row: np.ndarray, *axes: int) -> np.ndarray:
    """A row of the torus, counted backwards from its first node along some axes."""
    # The first node stays where it is.
    return np.roll(np.flip(row, axes), 1, axes)
