"""Contacts of two surfaces, stored for the next search of the same two.

A search decides each candidate pair of triangles alone: how two triangles meet depends on their
coordinates and the origin. So what one search found of two surfaces holds for every other search of
both, whatever other surfaces there are. Which contacts rounding could change is judged by the
largest coordinate of all candidates; with another one, the pairs are decided again.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np

MOST = 1 << 20  # candidates of two surfaces; more are searched again


@dataclass(frozen=True)
class Known:
    """The candidates of two surfaces, and how they meet.

    Attributes
    ----------
    rows : ndarray of int64, shape (n, 2 or 3)
        Keys of both surfaces, and codes where the search knows them.
    spent : dict of str to int
        What the search cost.
    slip : float
        By how much coordinates could move by rounding [m].
    codes : ndarray of int64, shape (n,)
        How each pair meets: see `geosurf.kernels.contacts.packed_contact.settled`.
    """

    rows: np.ndarray
    spent: dict[str, int]
    slip: float
    codes: np.ndarray


@dataclass(frozen=True)
class KnownPairs:
    """Where pairs are stored, by the rows of their surfaces.

    Attributes
    ----------
    get : callable
        Key -> what was stored, or None.
    put : callable
        Key and what is to be stored -> None.
    keys : list of hashable
        One of each surface, which stands for its triangles.
    """

    get: Callable[[Hashable], Any]
    put: Callable[[Hashable, Any], None]
    keys: list[Hashable]

    def of(self, i: int, j: int, *options: Hashable) -> Known | None:
        """What is known of two surfaces; None if they have not been searched."""
        found: Known | None = self.get(("pair", self.keys[i], self.keys[j], *options))
        return found

    def add(self, i: int, j: int, found: Known, *options: Hashable) -> None:
        """Store what a search found, unless that is too much."""
        if len(found.rows) <= MOST:
            self.put(("pair", self.keys[i], self.keys[j], *options), found)
