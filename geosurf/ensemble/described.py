"""What is uncertain, in words with units: for the store and the report of an ensemble."""

from __future__ import annotations

from typing import Any

from geosurf.ensemble.change import Uncertainty
from geosurf.ensemble.depths import DepthError
from geosurf.errors import InputError
from geosurf.model.distributions import (
    Constant,
    Discrete,
    Normal,
    OfScipy,
    Triangular,
    Uniform,
    distribution_of,
)
from geosurf.report.page import number

# Where uncertainties keep their distribution. A factor comes before the shape that it multiplies.
PLACES = ("by", "factor", "throw", "elevation", "shift")
MOST_VALUES = 5  # of a discrete distribution


def words_of_uncertainty(uncertain: Uncertainty) -> str:
    """
    Return the distribution of an uncertainty, with units.

    Parameters
    ----------
    uncertain : Uncertainty

    Returns
    -------
    str

    Examples
    --------
    >>> from geosurf.ensemble import Throw
    >>> words_of_uncertainty(Throw("F1", Normal(60.0, 10.0, low=0.0)))
    'normal: mean 60 m, standard deviation 10 m, at least 0 m'
    >>> words_of_uncertainty(DepthError("Top", sd=8.0, range=900.0))
    'correlated field (gaussian): mean 0 m, standard deviation 8 m, range 900 m'
    """
    if isinstance(uncertain, DepthError):
        return (
            f"correlated field ({uncertain.model}): mean 0 m, standard deviation "
            f"{_number(uncertain.sd)} m, range {_number(uncertain.range)} m"
        )
    for place in PLACES:
        given = getattr(uncertain, place, None)
        if given is not None:
            return words_of_distribution(given, uncertain.unit)
    return "drawn by a function"


def words_of_distribution(given: Any, unit: str) -> str:
    """
    Return a distribution with the unit of its values.

    Parameters
    ----------
    given : distribution, float or shape
        Whatever an uncertainty takes.
    unit : str
        ``"1"``: none.

    Returns
    -------
    str

    Examples
    --------
    >>> words_of_distribution(Uniform(0.5, 5.0), "m")
    'uniform: 0.5 to 5 m'
    >>> words_of_distribution(Discrete([1.0, 2.0], [1, 3]), "1")
    'one of 1, 2; weights 1, 3'
    """
    after = "" if unit == "1" else f" {unit}"
    try:
        made: Any = distribution_of(given, "distribution")
    except InputError:  # a profile, a map or an ellipse: a throw that is certain
        return f"certain: {type(given).__name__}"
    if isinstance(made, Constant):
        return f"certain: {_number(made.value)}{after}"
    if isinstance(made, Normal):
        ends = (("at least", made.low), ("at most", made.high))
        limits = "".join(f", {w} {_number(v)}{after}" for w, v in ends if v is not None)
        middle = f"mean {_number(made.mean)}{after}"
        return f"normal: {middle}, standard deviation {_number(made.sd)}{after}{limits}"
    if isinstance(made, Uniform):
        return f"uniform: {_number(made.low)} to {_number(made.high)}{after}"
    if isinstance(made, Triangular):
        ends_of = f"{_number(made.low)} to {_number(made.high)}{after}"
        return f"triangular: {ends_of}, most likely {_number(made.mode)}{after}"
    if isinstance(made, Discrete):
        weights = tuple(made.weights or ())
        same = len(set(weights)) == 1
        return f"one of {_listed(made.values, after)}" + (
            "" if same else f"; weights {_listed(weights, '')}"
        )
    return f"{_name(made)}: median {_number(made.quantile(0.5))}{after}"


def _name(made: Any) -> str:
    """What a distribution of the user's, or of scipy, is called."""
    if isinstance(made, OfScipy):
        return f"scipy.stats.{getattr(getattr(made.made, 'dist', None), 'name', 'distribution')}"
    return type(made).__name__


def _listed(values: Any, after: str) -> str:
    """The first values with their unit, and how many more there are."""
    shown = ", ".join(map(_number, values[:MOST_VALUES]))
    more = len(values) - MOST_VALUES
    return f"{shown}{after}" + (f" and {more} more" if more > 0 else "")


def _number(value: float) -> str:
    """A number as tables show it, with as many decimals as it needs, at most six."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return number(value, len(text.partition(".")[2]))
