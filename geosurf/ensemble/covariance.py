"""How errors at two places are related: covariance as a function of their distance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geosurf.conventions import did_you_mean, is_number
from geosurf.errors import InputError

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
        if self.model not in MODELS:
            raise InputError(
                f"depth error: model is {self.model!r}; it must be one of {', '.join(MODELS)}."
                f"{did_you_mean(str(self.model), MODELS)}"
            )

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
        found: np.ndarray = float(self.sd) ** 2 * _MODELS[self.model](h)
        return found
