"""Faults that tears make longer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from geosurf.model.surfaces import TriSurface


@dataclass(frozen=True)
class Extended:
    """A fault that was extended because a sheet leaves it above or below.

    Attributes
    ----------
    fault : str
    lengths : dict of {"up", "down", "start", "end"} to float
        Along its dip or strike [m].
    place : ndarray (3,)
        Where the sheet left it [m].
    """

    fault: str
    lengths: Mapping[str, float]
    place: np.ndarray


@dataclass(frozen=True, eq=False)
class NeededFaults:
    """Faults as long as one horizon needs them.

    Attributes
    ----------
    extensions : tuple of Extended
    faults : dict of str to TriSurface
        Those that are longer, by name.
    trims : dict of str to float
        Of all its faults, as given or as the data showed before these were longer [cells].
    """

    extensions: tuple[Extended, ...]
    faults: dict[str, TriSurface]
    trims: dict[str, float]


__all__ = ["Extended", "NeededFaults"]
