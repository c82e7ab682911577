"""Uncertain fluid contacts: their elevation, or a shift of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geosurf.conventions import is_number
from geosurf.ensemble.change import Change, Given, names_among
from geosurf.ensemble.depths import of_names
from geosurf.ensemble.horizon_data import HorizonData
from geosurf.errors import InputError
from geosurf.model import FluidContact, TriSurface
from geosurf.model.distributions import Distribution, distribution_of


@dataclass(frozen=True)
class ContactLevel:
    """
    A fluid contact at an uncertain elevation.

    Parameters
    ----------
    contact : str
        Its name in ``Scene(contacts=)``.
    elevation : distribution or float, optional
        [m], positive up, in place of the given one. For a contact that is the same in all blocks.
    shift : distribution or float, optional
        [m], positive up, added to the given elevation, or to a gridded contact, in all blocks.
    name : str, optional
        Of the parameter in all results; default ``"contact OWC"``.

    Raises
    ------
    InputError
        If not exactly one of `elevation` and `shift` is given.

    Examples
    --------
    >>> ContactLevel("OWC", shift=-3.0).parameter
    'contact OWC'
    """

    contact: str
    elevation: Any = None
    shift: Any = None
    name: str = ""

    unit = "m"

    def __post_init__(self) -> None:
        # Both would contradict each other, neither would change nothing.
        if (self.elevation is None) == (self.shift is None):
            raise InputError(f"{self.parameter}: give either elevation= or shift=.")

    @property
    def parameter(self) -> str:
        """Name of the parameter."""
        return self.name or of_names("contact", self.contact)

    def prepare(self, given: Given) -> PreparedContact:
        """Check names and distribution."""
        names_among(self.contact, tuple(given.contacts), "fluid contact")
        value = given.contacts[self.contact]
        # One elevation can replace only one: contacts of several blocks differ.
        absolute = self.elevation is not None
        if absolute and _count(value) > 1:
            raise InputError(
                f"{self.parameter}: the contact is given for several blocks or zones. Give shift= "
                "in place of elevation=."
            )
        found = distribution_of(self.elevation if absolute else self.shift, self.parameter)
        return PreparedContact(self.parameter, self.contact, found, absolute)


@dataclass(frozen=True)
class PreparedContact:
    """A `ContactLevel` of a given model."""

    parameter: str
    contact: str
    level: Distribution
    absolute: bool

    def reach(self) -> float:
        """Return how far horizons may move [m]."""
        return 0.0

    def apply(self, change: Change) -> None:
        """Move the contact."""
        level = change.numbers[self.parameter] = change.draws.number(self.parameter, self.level)
        # As other uncertainties have left it, else as given.
        value = change.contacts.get(self.contact, change.given.contacts[self.contact])

        def at(old: Any) -> Any:
            """The new place of one contact: a number, or a surface."""
            if self.absolute:
                return level
            # A level contact is a number, a gridded one moves node by node.
            if is_number(old):
                return float(old) + level
            data = HorizonData.of(self.contact, old)
            return data.moved(np.full(len(data.points), level))

        change.contacts[self.contact] = _each(value, at)


def _each(value: Any, at: Callable[[Any], Any]) -> Any:
    """A contact with each of its elevations replaced; see ``Scene(contacts=)`` for its forms."""
    # Recursive: a list may hold contacts, and a mapping may have lists.
    if isinstance(value, FluidContact):
        return replace(value, at=_each(value.at, at))
    if isinstance(value, list | tuple):
        return [_each(one, at) for one in value]
    # A surface is one contact, not a mapping of blocks.
    if isinstance(value, Mapping) and not isinstance(value, TriSurface):
        return {block: _each(one, at) for block, one in value.items()}
    return at(value)


def _count(value: Any) -> int:
    """How many elevations a contact has."""
    # The same walk as for changes, with a function that only looks.
    seen: list[Any] = []
    _each(value, seen.append)
    return len(seen)
