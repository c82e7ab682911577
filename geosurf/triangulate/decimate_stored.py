"""Every k-th node of horizons that stay in their store: a grid in memory, with a proven bound."""

from __future__ import annotations

from collections.abc import Sequence

from geosurf.model import Lattice, TriSurface
from geosurf.model.chunk_store import STAYS
from geosurf.model.chunked import ChunkedLattice
from geosurf.triangulate.decimate import (
    STRIDES,
    Differences,
    Frame,
    decimate_horizon,
    kept_nodes,
    least_nodes,
    measure_differences,
)
from geosurf.triangulate.decimate_bands import are_near_in_band

MOST_KEPT = 1 << 24  # nodes of a grid: with its bounds it takes 400 MB
_LARGE_STRIDES = (100, 50, 40, 25, 16)  # of grids that are too large for memory


def strides_in_store(shape: tuple[int, int]) -> list[int]:
    """Return every how many nodes of a grid in its store may be kept, the largest first.

    Examples
    --------
    >>> strides_in_store((20_000, 20_000)), strides_in_store((300, 301))
    ([100, 50, 40, 25, 20, 16, 10, 8, 5], [3, 2])
    """
    n_node = shape[0] * shape[1]
    more = _LARGE_STRIDES if n_node > STAYS else ()
    strides = sorted({*more, *STRIDES}, reverse=True)
    return [k for k in strides if least_nodes(k) <= n_node <= MOST_KEPT * k * k]


def decimate_stored(frame: Sequence[TriSurface], tolerance: float) -> list[TriSurface]:
    """
    Return horizons with as few nodes as a tolerance allows; none if they need too many.

    A band of chunks shows which k are hopeless. The largest k that is left takes one pass over each
    horizon.

    Parameters
    ----------
    frame : sequence of TriSurface
        For which `can_be_decimated` holds, with the same nodes in the map. Some are in their store.
    tolerance : float
        [m].

    Returns
    -------
    list of TriSurface
        As `decimate_horizon` makes them, all with the same rows and columns.
    """
    lattices = [one.lattice for one in frame if one.lattice is not None]
    shape = lattices[0].shape
    strides, worst, place = strides_in_store(shape), 0, 0.5
    while strides:
        kept = [(kept_nodes(shape[0], k), kept_nodes(shape[1], k)) for k in strides]
        asked = lattices[worst]
        if isinstance(asked, ChunkedLattice):
            near = are_near_in_band(asked, kept, tolerance, place)
            strides = [k for k, may_pass in zip(strides, near, strict=True) if may_pass]
            kept = [both for both, may_pass in zip(kept, near, strict=True) if may_pass]
        if not strides:
            break
        nodes = Frame.of_nodes(lattices[0], *kept[0])
        found: dict[int, Differences] = {}
        for k in sorted(range(len(frame)), key=lambda k: k != worst):  # the last that failed first
            one = measure_differences(lattices[k], nodes, tolerance, place)
            if not isinstance(one, Differences):
                worst, place = k, one
                break
            found[k] = one
        else:
            return [decimate_horizon(one, nodes, found[k]) for k, one in enumerate(frame)]
        strides = strides[1:]
    return []


def is_in_store(lattice: Lattice | None) -> bool:
    """Whether the elevations of a lattice stay in their store."""
    return isinstance(lattice, ChunkedLattice)


__all__ = ["decimate_stored", "is_in_store", "strides_in_store"]
