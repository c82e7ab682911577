"""The curves of a scene: those of one pair of surfaces, and those of all pairs together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from geosurf.arrangement import KnownPairs, find_contacts
from geosurf.intersect import curves_of, intersect_surfaces, merge_curves
from geosurf.model import Curves, TriSurface
from geosurf.model.chunked import ChunkedLattice

Pair = tuple[int, int]


def curves_of_pair(
    pair: Sequence[TriSurface],
    origin: np.ndarray,
    *,
    voxel_size: float | None,
    tolerance: float | None,
    known: Callable[[Sequence[TriSurface]], KnownPairs],
) -> Curves:
    """Return the curves of two surfaces, or along which one surface crosses itself.

    Parameters
    ----------
    pair : one or two TriSurface
    origin : ndarray of float64, shape (3,)
        Of the local frame; without a tolerance only.
    voxel_size, tolerance : float or None
        As for `Scene`.
    known : callable
        Where candidates of a pair are held, for the model that is built later: only those of
        horizons in their store are worth the memory.
    """
    alone = len(pair) == 1
    if tolerance is not None:
        return intersect_surfaces(
            pair, tolerance=tolerance, voxel_size=voxel_size, self_intersections=alone
        )
    pairs = [(0, len(pair) - 1)]
    held = known(pair) if any(isinstance(one.lattice, ChunkedLattice) for one in pair) else None
    how: dict[str, Any] = {"pairs": pairs, "origin": origin, "voxel_size": voxel_size}
    return curves_of(find_contacts(pair, known=held, **how))


def curves_of_all(
    pairs: Sequence[Pair], between: Callable[[int, int], Curves | None]
) -> list[tuple[Pair, Curves]]:
    """Return the curves of all pairs that have some, in the order of the pairs.

    Parameters
    ----------
    pairs : sequence of (int, int)
        Rows of two surfaces, or of one twice.
    between : callable
        Curves of two surfaces by their rows; None where they do not meet.
    """
    found = [((i, j), between(i, j)) for i, j in pairs]
    return [(pair, curves) for pair, curves in found if curves is not None]


def merge_pairs(
    names: tuple[str, ...],
    origin: np.ndarray,
    parts: list[tuple[Pair, Curves]],
    *,
    smooth: bool,
) -> Curves:
    """Return the curves of all pairs as one; smooth ones have no segments in common."""
    return merge_curves(names, origin, parts, smooth=smooth)


__all__ = ["curves_of_all", "curves_of_pair", "merge_pairs"]
