"""What one realisation changes of a model, gathered from all uncertainties before it is built."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.ensemble.draws import Draws
from geosurf.ensemble.horizon_data import HorizonData
from geosurf.errors import InputError
from geosurf.model import TriSurface
from geosurf.model.tops import Tops


class Given(Protocol):
    """The inputs that realisations change, as they were given."""

    horizon_names: tuple[str, ...]
    fault_names: tuple[str, ...]
    contacts: dict[str, Any]
    tops: Tops | None

    def horizon(self, name: str) -> HorizonData:
        """Return the data of a horizon, before it is torn or thrown."""

    def fault(self, name: str) -> TriSurface:
        """Return a fault, before it is extended and truncated."""


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
