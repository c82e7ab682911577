"""Where the numbers of a realisation come from: streams of a seed, or medians for the base case."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.ensemble.fields import GaussianField
from geosurf.ensemble.streams import probability_of, stream_of
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


__all__ = ["Draws"]
