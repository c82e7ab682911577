"""Distributions of one uncertain number: normal, uniform, triangular, discrete, or of scipy.

Each is drawn by its quantile function from one uniform number, so that a realisation needs one
number for each parameter, and the same number always gives the same value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, Protocol

import numpy as np

from geosurf.conventions import is_number
from geosurf.errors import InputError

# Ranges of parameters are needed ahead, for memory and for boxes; normal distributions have no
# ends.
TAIL = 1e-6  # probability that is left out on either side where a range is needed
HOW = "Give a number, Normal(0, 10), Uniform(-5, 5), Triangular(-5, 0, 5) or Discrete([0, 5])"


class Distribution(Protocol):
    """What can be drawn from: a quantile for each probability."""

    def quantile(self, probability: float) -> float:
        """Return the value that is not exceeded with a probability between 0 and 1."""


@dataclass(frozen=True)
class Constant:
    """One certain value.

    Examples
    --------
    >>> Constant(3.0).quantile(0.9)
    3.0
    """

    value: float

    def __post_init__(self) -> None:
        _check_parameters(self, finite=("value",))

    def quantile(self, probability: float) -> float:
        """Return the value."""
        return float(self.value)


@dataclass(frozen=True)
class Normal:
    """A normal distribution, truncated where limits are given.

    Parameters
    ----------
    mean, sd : float
        Mean and standard deviation before truncation, in the unit of the parameter.
    low, high : float, optional
        Limits; values beyond them are not drawn.

    Raises
    ------
    InputError
        If a number is not finite, ``sd`` is not above 0, or no value lies between the limits.

    Examples
    --------
    >>> Normal(0.0, 10.0).quantile(0.5), round(Normal(0.0, 10.0).quantile(0.9), 2)
    (0.0, 12.82)
    >>> round(Normal(0.0, 10.0, low=0.0).quantile(0.5), 2)
    6.74
    """

    mean: float
    sd: float
    low: float | None = None
    high: float | None = None

    def __post_init__(self) -> None:
        # Checked when it is made: a mistake in a scenario shows before the first realisation.
        _check_parameters(self, finite=("mean", "sd"), or_none=("low", "high"))
        if self.sd <= 0:
            raise InputError(f"{self}: sd must be above 0. For a certain value, give a number.")
        if self.low is not None and self.high is not None and self.low >= self.high:
            raise InputError(f"{self}: low must be below high.")
        lowest, highest = self._probabilities_of_limits()
        if highest - lowest < TAIL:
            raise InputError(f"{self}: almost no value lies between the limits. Widen them.")

    def _probabilities_of_limits(self) -> tuple[float, float]:
        """Probabilities below both limits, of the distribution that is not truncated."""
        plain = NormalDist(self.mean, self.sd)
        lowest = 0.0 if self.low is None else plain.cdf(self.low)
        highest = 1.0 if self.high is None else plain.cdf(self.high)
        return lowest, highest

    def quantile(self, probability: float) -> float:
        """Return the value that is not exceeded with a probability between 0 and 1."""
        lowest, highest = self._probabilities_of_limits()
        plain_probability = lowest + probability * (highest - lowest)

        # never 0 or 1, at which the quantile is infinite; rounding must not pass the limits either
        plain_probability = min(max(plain_probability, 5e-324), 1.0 - 2**-53)
        value = NormalDist(self.mean, self.sd).inv_cdf(plain_probability)
        low = -math.inf if self.low is None else float(self.low)
        high = math.inf if self.high is None else float(self.high)
        return min(max(value, low), high)


@dataclass(frozen=True)
class Uniform:
    """All values between two limits, equally likely.

    Examples
    --------
    >>> Uniform(-5.0, 5.0).quantile(0.9)
    4.0
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        _check_parameters(self, finite=("low", "high"))
        if self.low >= self.high:
            raise InputError(f"{self}: low must be below high.")

    def quantile(self, probability: float) -> float:
        """Return the value that is not exceeded with a probability between 0 and 1."""
        return float(self.low + probability * (self.high - self.low))


@dataclass(frozen=True)
class Triangular:
    """Values between two limits, most likely at the mode.

    Examples
    --------
    >>> Triangular(0.0, 2.0, 4.0).quantile(0.5)
    2.0
    """

    low: float
    mode: float
    high: float

    def __post_init__(self) -> None:
        _check_parameters(self, finite=("low", "mode", "high"))
        if not (self.low <= self.mode <= self.high and self.low < self.high):
            raise InputError(f"{self}: give low, mode and high in rising order.")

    def quantile(self, probability: float) -> float:
        """Return the value that is not exceeded with a probability between 0 and 1."""
        # the distribution function is a parabola on each side of the mode; its inverse, a root
        width, rise = self.high - self.low, self.mode - self.low
        if probability * width <= rise:
            return float(self.low + math.sqrt(probability * width * rise))
        return float(self.high - math.sqrt((1.0 - probability) * width * (self.high - self.mode)))


@dataclass(frozen=True)
class Discrete:
    """One of several values.

    Parameters
    ----------
    values : sequence of float
    weights : sequence of float, optional
        Of each value, above 0; default: all equal. They need not add up to 1.

    Examples
    --------
    >>> levels = Discrete([-1700.0, -1710.0, -1720.0], [1, 2, 1])
    >>> [levels.quantile(p) for p in (0.2, 0.5, 0.8)]
    [-1700.0, -1710.0, -1720.0]
    """

    values: Sequence[float]
    weights: Sequence[float] | None = None

    def __post_init__(self) -> None:
        values = _finite_numbers(self.values, f"{self}: values")
        weights = (1.0,) * len(values)
        if self.weights is not None:
            weights = _finite_numbers(self.weights, f"{self}: weights")
        if not values or len(weights) != len(values) or min(weights) <= 0:
            raise InputError(f"{self}: give one weight above 0 for each value, one or more.")
        # Frozen dataclass: tuples replace whatever sequences were given.
        self.__dict__.update(values=values, weights=weights)

    def quantile(self, probability: float) -> float:
        """Return the value at a probability between 0 and 1, in the order of the values."""
        # weights need not add up to 1: the probability is scaled to their sum
        sums: np.ndarray = np.cumsum(np.asarray(self.weights))
        row = int(np.searchsorted(sums, probability * sums[-1]))
        # Rounding of the sum may lead one place too far.
        return float(self.values[min(row, len(self.values) - 1)])


@dataclass(frozen=True)
class OfScipy:
    """A frozen distribution of `scipy.stats`, which has ``ppf``."""

    frozen: Any

    def quantile(self, probability: float) -> float:
        """Return the value that is not exceeded with a probability between 0 and 1."""
        return float(self.frozen.ppf(probability))


def distribution_of(value: Any, what: str) -> Distribution:
    """
    Return a distribution: a number is certain, a frozen distribution of `scipy.stats` is wrapped.

    Parameters
    ----------
    value : float, Distribution or frozen distribution of scipy.stats
    what : str
        What is uncertain, for messages.

    Raises
    ------
    InputError

    Examples
    --------
    >>> distribution_of(5, "the throw of 'F1'")
    Constant(value=5.0)
    >>> distribution_of("wide", "the throw of 'F1'")
    Traceback (most recent call last):
    geosurf.errors.InputError: the throw of 'F1' is 'wide', which is not a distribution. Give a number, Normal(0, 10), Uniform(-5, 5), Triangular(-5, 0, 5) or Discrete([0, 5]).
    """  # noqa: E501 - a message
    if is_number(value):
        return Constant(float(value))

    if callable(getattr(value, "quantile", None)) and not isinstance(value, type):
        distribution: Distribution = value
    # scipy is not imported: its frozen distributions are known by `ppf` and `args`
    elif callable(getattr(value, "ppf", None)) and hasattr(value, "args"):
        distribution = OfScipy(value)
    else:
        raise InputError(f"{what} is {value!r}, which is not a distribution. {HOW}.")
    try:
        # Three quantiles show at once whether it can be drawn from.
        are_finite = all(is_number(distribution.quantile(p)) for p in (TAIL, 0.5, 1.0 - TAIL))
    except (TypeError, ValueError, ArithmeticError, AttributeError) as error:
        raise InputError(f"{what}: {value!r} cannot be drawn from ({error}). {HOW}.") from error
    if not are_finite:
        raise InputError(f"{what}: {value!r} has quantiles that are not finite. {HOW}.")
    return distribution


def is_distribution(value: Any) -> bool:
    """Whether a value is one of the classes above, or a frozen distribution of `scipy.stats`."""
    classes = Constant, Normal, Uniform, Triangular, Discrete, OfScipy
    return isinstance(value, classes) or callable(getattr(value, "ppf", None))


def medians(value: Any) -> Any:
    """Return a value with medians in place of distributions, also inside mappings.

    Examples
    --------
    >>> medians({"porosity": {"oil": Uniform(0.2, 0.3), "water": 0.2}})
    {'porosity': {'oil': 0.25, 'water': 0.2}}
    """
    if isinstance(value, Mapping):
        return {key: medians(entry) for key, entry in value.items()}
    return distribution_of(value, "").quantile(0.5) if is_distribution(value) else value


def ends_of(value: Any, what: str) -> tuple[float, float]:
    """Return the lowest and the highest value that is likely: `TAIL` lies beyond either."""
    distribution = distribution_of(value, what)
    if isinstance(distribution, Discrete):  # its values need not rise
        return min(distribution.values), max(distribution.values)
    return distribution.quantile(TAIL), distribution.quantile(1.0 - TAIL)


def reach_of(distribution: Distribution) -> float:
    """Return the largest absolute value that is likely: all except `TAIL` on either side."""
    return max(abs(distribution.quantile(p)) for p in (TAIL, 1.0 - TAIL))


def _check_parameters(
    distribution: Any, finite: tuple[str, ...], or_none: tuple[str, ...] = ()
) -> None:
    """Refuse parameters that are not finite numbers."""
    kind = type(distribution).__name__
    for key in (*finite, *or_none):
        value = getattr(distribution, key)
        if not (is_number(value) or (value is None and key in or_none)):
            raise InputError(f"{kind}: {key} is {value!r}; give a finite number.")


def _finite_numbers(values: Any, what: str) -> tuple[float, ...]:
    """Finite numbers as a tuple."""
    try:
        listed = tuple(values)
    except TypeError:
        # Not a sequence: None fails the test below, with the same message.
        listed = (None,)
    if not all(map(is_number, listed)):
        raise InputError(f"{what} must be finite numbers, as in Discrete([0, 5], [1, 2]).")
    return tuple(map(float, listed))
