"""Uncertain throw of faults, for horizons that are continuous before they are torn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geosurf.conventions import is_number
from geosurf.ensemble.change import Change, Given, names_among
from geosurf.ensemble.depths import of_names
from geosurf.errors import InputError
from geosurf.model.distributions import Distribution, distribution_of, reach_of
from geosurf.sheets import EllipticThrow


@dataclass(frozen=True)
class Throw:
    """
    The throw of a fault, for horizons that are still continuous; see `throw_horizon`.

    Parameters
    ----------
    fault : str
    throw : distribution, float, or what `throw_horizon` takes, optional
        [m], negative for a reverse fault. Left out: as the scenario has it.
    factor : distribution or float, optional
        By which a throw that is a profile, a map or an ellipse is multiplied.
    name : str, optional
        Of the parameter in all results; default ``"throw F1"``.

    Raises
    ------
    InputError
        If neither `throw` nor `factor` is given.

    Notes
    -----
    List the youngest fault first. Each throw acts on all horizons of the scene.

    Examples
    --------
    >>> Throw("F1", 30.0).parameter
    'throw F1'
    """

    fault: str
    throw: Any = None
    factor: Any = None
    name: str = ""

    def __post_init__(self) -> None:
        if self.throw is None and self.factor is None:
            raise InputError(f"{self.parameter}: give throw= [m], or factor=.")

    @property
    def unit(self) -> str:
        """Unit of the parameter."""
        return "m" if self.factor is None else "1"

    @property
    def parameter(self) -> str:
        """Name of the parameter."""
        return self.name or of_names("throw", self.fault)

    def prepare(self, given: Given) -> PreparedThrow:
        """Check names and distribution."""
        names_among(self.fault, given.fault_names, "fault")
        name = self.parameter
        # A factor multiplies a form that is given here, or the one of the scenario.
        if self.factor is not None:
            by = distribution_of(self.factor, f"{name}: factor")
            return PreparedThrow(name, self.fault, by, self.throw, True)
        if _is_shape(self.throw):  # certain: its number is 1
            return PreparedThrow(name, self.fault, distribution_of(1.0, name), self.throw, True)
        return PreparedThrow(name, self.fault, distribution_of(self.throw, name))


@dataclass(frozen=True)
class Factor:
    """A throw in any form, or the one of a scenario (None), to be multiplied."""

    by: float
    shape: Any = None

    def of(self, shape: Any) -> Any:
        """Return the throw: its own form, or else the one that is given."""
        return times(shape if self.shape is None else self.shape, self.by)


@dataclass(frozen=True, eq=False)
class PreparedThrow:
    """A `Throw` of a given model."""

    parameter: str
    fault: str
    by: Distribution
    shape: Any = None
    is_factor: bool = False

    def reach(self) -> float:
        """Return how far horizons may move from the base case [m]."""
        # Throw moves horizons relative to the base case, which has the median.
        middle = self.by.quantile(0.5)
        spread = reach_of(_Off(self.by, middle))
        return spread if self.shape is None else spread * largest_throw(self.shape)

    def apply(self, change: Change) -> None:
        """Set the throw."""
        by = change.numbers[self.parameter] = change.draws.number(self.parameter, self.by)
        change.throws[self.fault] = Factor(by, self.shape) if self.is_factor else by


@dataclass(frozen=True)
class _Off:
    """A distribution, counted from a value."""

    of: Distribution
    value: float

    def quantile(self, probability: float) -> float:
        """Return the value that is not exceeded with a probability between 0 and 1."""
        return self.of.quantile(probability) - self.value


def _is_shape(throw: Any) -> bool:
    """Whether a throw is a profile, a map, a function or an ellipse: no number."""
    # Forms of `throw_horizon` other than a number.
    if isinstance(throw, EllipticThrow | np.ndarray | list | tuple) or hasattr(throw, "dims"):
        return True
    # Distributions can be called for quantiles; plain functions are throws.
    return callable(throw) and not hasattr(throw, "quantile") and not hasattr(throw, "ppf")


def times(throw: Any, factor: float) -> Any:
    """Return a throw of any form, multiplied by a factor.

    Examples
    --------
    >>> times(EllipticThrow(40.0), 0.5).largest, times([[0.0, 10.0], [900.0, 30.0]], 2.0).tolist()
    (20.0, [[0.0, 20.0], [900.0, 60.0]])
    """
    if isinstance(throw, EllipticThrow):
        return replace(throw, largest=throw.largest * factor)
    if is_number(throw):
        return float(throw) * factor
    # An array keeps its coordinates.
    if hasattr(throw, "dims"):
        return throw * factor
    if callable(throw):
        return _Times(throw, factor)
    # Pairs of distance and throw: only the second column is multiplied.
    return np.asarray(throw, dtype=np.float64) * np.array([1.0, factor])


@dataclass(frozen=True)
class _Times:
    """A function of the distance along strike, multiplied; other processes can be sent it."""

    throw: Callable[[Any], Any]
    factor: float

    def __call__(self, along: Any) -> Any:
        return self.factor * self.throw(along)


def largest_throw(throw: Any) -> float:
    """Return the largest throw of any form [m]; 0 for a function, whose values are not known.

    Examples
    --------
    >>> largest_throw([[0.0, 10.0], [900.0, -30.0]])
    30.0
    """
    if isinstance(throw, EllipticThrow):
        return abs(float(throw.largest))
    if is_number(throw):
        return abs(float(throw))
    # Its values are not known ahead.
    if callable(throw) and not hasattr(throw, "dims"):
        return 0.0
    values = throw.values if hasattr(throw, "dims") else np.asarray(throw, dtype=np.float64)[:, 1]
    return float(np.nanmax(np.abs(values)))
