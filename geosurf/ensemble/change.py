"""What one realisation changes of a model, gathered from all uncertainties before it is built."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from geosurf.conventions import did_you_mean, is_whole
from geosurf.ensemble.fields import GaussianField
from geosurf.ensemble.horizon_data import HorizonData
from geosurf.errors import InputError
from geosurf.model import TriSurface
from geosurf.model.distributions import Distribution
from geosurf.model.tops import Tops

# ---- draws ----------------------------------------
# Where the numbers of a realisation come from: streams of a seed, or medians for the base case.


@dataclass(frozen=True)
class Draws:
    """
    Numbers and fields of one realisation, by the name of their parameter.

    Attributes
    ----------
    seed : int
    realisation : int or None
        None: the base case, in which each number is its median and each field its mean.

    Examples
    --------
    >>> from geosurf.model.distributions import Uniform
    >>> Draws(0, None).number("throw F1", Uniform(0.0, 50.0))
    25.0
    """

    seed: int
    realisation: int | None

    def number(self, parameter: str, distribution: Distribution) -> float:
        """Return the value of a parameter."""
        # The base case: the median of each number, which is also its most central value.
        if self.realisation is None:
            return distribution.quantile(0.5)
        # A stream for each parameter: adding one leaves the numbers of the others as they are.
        stream = stream_of(self.seed, self.realisation, parameter)
        return distribution.quantile(probability_of(stream))

    def field(self, parameter: str, field: GaussianField) -> np.ndarray:
        """Return a field on the nodes of its lattice [m]."""
        if self.realisation is None:
            return field.mean()
        return field.simulate(stream_of(self.seed, self.realisation, parameter))


_STEPS = 1 << 53


def check_seed(seed: Any) -> int:
    """Return a seed, or raise an error that names what it must be.

    Examples
    --------
    >>> check_seed(3)
    3
    """
    if not (is_whole(seed) and seed >= 0):
        raise InputError(f"seed is {seed!r}; give a whole number, 0 or above.")
    return int(seed)


def stream_of(seed: int, realisation: int, parameter: str) -> np.random.Generator:
    """
    Return the random numbers of one parameter in one realisation.

    Parameters
    ----------
    seed : int
    realisation : int
    parameter : str
        Name of the parameter.

    Returns
    -------
    numpy.random.Generator

    Examples
    --------
    >>> a, b, c = (stream_of(0, k, p).random() for k, p in ((5, "x"), (5, "x"), (5, "y")))
    >>> a == b, a == c
    (True, False)
    """
    # The name enters by its hash: 128 bits, the same in every process and on every machine.
    words = np.frombuffer(hashlib.sha256(parameter.encode()).digest()[:16], dtype="<u4")
    sequence = np.random.SeedSequence(seed, spawn_key=(realisation, *words.tolist()))
    return np.random.Generator(np.random.PCG64(sequence))


def probability_of(stream: np.random.Generator) -> float:
    """Return a uniform number that is neither 0 nor 1.

    Examples
    --------
    >>> 0.0 < probability_of(stream_of(0, 0, "x")) < 1.0
    True
    """
    # The middle of one of 2**53 equal steps: never 0 or 1, where quantiles are infinite.
    return (int(stream.integers(_STEPS)) + 0.5) / _STEPS


class Given(Protocol):
    """The inputs that realisations change, as they were given."""

    horizon_names: tuple[str, ...]
    fault_names: tuple[str, ...]
    contacts: dict[str, Any]
    velocity: Any
    tops: Tops | None

    def horizon(self, name: str) -> HorizonData:
        """Return the data of a horizon, before it is torn or thrown."""

    def fault(self, name: str) -> TriSurface:
        """Return a fault, before it is extended and truncated."""

    @property
    def deepest(self) -> float:
        """Depth of the floor of the base case [m]."""


@dataclass
class Change:
    """
    New inputs of one realisation; what is not in it stays as it was given.

    Attributes
    ----------
    given : Given
    draws : Draws
    up : dict of str to ndarray
        How far each point of a horizon moves up [m].
    faults : dict of str to TriSurface
    contacts : dict of str to object
    throws : dict of str to object
        Throw by fault, as `throw_horizon` takes it.
    velocity : dict of str to float
        Factors of velocities, by the names that they have.
    numbers : dict of str to float
        Value of each parameter.
    """

    given: Given
    draws: Draws
    # Sums of what each uncertainty adds, point by point; absent: the horizon stays.
    up: dict[str, np.ndarray] = field(default_factory=dict)
    faults: dict[str, TriSurface] = field(default_factory=dict)
    contacts: dict[str, Any] = field(default_factory=dict)
    throws: dict[str, Any] = field(default_factory=dict)
    velocity: dict[str, float] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)

    def lift(self, horizon: str, by: Any) -> None:
        """Move a horizon up [m], in addition to what others have moved it."""
        # Several uncertainties may move one horizon: their moves add up, in any order.
        known = self.up.get(horizon, 0.0)
        self.up[horizon] = known + np.broadcast_to(by, len(self.given.horizon(horizon).points))

    def fault(self, name: str) -> TriSurface:
        """Return a fault as it has been moved so far."""
        # A fault may be shifted and then turned: the second starts from the first.
        return self.faults.get(name) or self.given.fault(name)

    def horizons(self) -> dict[str, Any]:
        """Return the horizons that have moved, as a scene takes them."""
        # Only horizons that have moved: results of the others are shared by all realisations.
        return {name: self.given.horizon(name).moved(up) for name, up in self.up.items()}


class Uncertainty(Protocol):
    """One uncertain input of a model: a number, or a field."""

    @property
    def parameter(self) -> str:
        """Name of its number in all results; it also selects the stream of random numbers."""

    @property
    def unit(self) -> str:
        """Unit of that number."""

    def prepare(self, given: Given) -> Prepared:
        """Check names, and compute what all realisations share."""


class Prepared(Protocol):
    """An uncertainty of a given model."""

    def reach(self) -> float:
        """Return how far up or down it may move horizons from the base case [m]."""

    def apply(self, change: Change) -> None:
        """Draw, and change the inputs."""


def names_among(names: Any, known: tuple[str, ...], what: str) -> tuple[str, ...]:
    """Return names as a tuple, or raise an error for one that is unknown; empty: all.

    Examples
    --------
    >>> names_among("Top", ("Top", "Base"), "horizon"), names_among((), ("Top", "Base"), "horizon")
    (('Top',), ('Top', 'Base'))
    """
    # A single name is a common slip for a list of one.
    listed = (names,) if isinstance(names, str) else tuple(names)
    for name in listed:
        if name not in known:
            raise InputError(
                f"no {what} is called {name!r}; there are {', '.join(known) or 'none'}."
                f"{did_you_mean(str(name), known)}"
            )
    # Nothing listed means everything.
    return listed or known
