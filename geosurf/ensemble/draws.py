"""Where the numbers of a realisation come from: streams of a seed, or medians for the base case."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import is_whole
from geosurf.ensemble.fields import GaussianField
from geosurf.errors import InputError
from geosurf.model.distributions import Distribution


@dataclass(frozen=True)
class Draws:
    """
    Numbers and fields of one realisation, by the name of their parameter.

    Attributes
    ----------
    seed : int
    realization : int or None
        None: the base case, in which each number is its median and each field its mean.

    Examples
    --------
    >>> from geosurf.model.distributions import Uniform
    >>> Draws(0, None).number("throw F1", Uniform(0.0, 50.0))
    25.0
    """

    seed: int
    realization: int | None

    def number(self, parameter: str, distribution: Distribution) -> float:
        """Return the value of a parameter."""
        # The base case: the median of each number, which is also its most central value.
        if self.realization is None:
            return distribution.quantile(0.5)
        # A stream for each parameter: adding one leaves the numbers of the others as they are.
        stream = stream_of(self.seed, self.realization, parameter)
        return distribution.quantile(probability_of(stream))

    def field(self, parameter: str, field: GaussianField) -> np.ndarray:
        """Return a field on the nodes of its lattice [m]."""
        if self.realization is None:
            return field.mean()
        return field.simulate(stream_of(self.seed, self.realization, parameter))


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


def stream_of(seed: int, realization: int, parameter: str) -> np.random.Generator:
    """
    Return the random numbers of one parameter in one realisation.

    Parameters
    ----------
    seed : int
    realization : int
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
    sequence = np.random.SeedSequence(seed, spawn_key=(realization, *words.tolist()))
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
