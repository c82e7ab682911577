"""Horizons on one map that do not meet, found without a search for curves."""

from __future__ import annotations

import numpy as np

from geosurf.model import TriSurface
from geosurf.model.chunked import ChunkedLattice

_EVEN = 0.1  # of a step: second differences of axes below this keep cubics of axes rising


def are_apart(one: TriSurface, two: TriSurface) -> bool:
    """
    Return whether two grids with the same nodes in the map are known to have no point in common.

    Parameters
    ----------
    one, two : TriSurface
        With cubics: `geosurf.intersect.sides.has_cubics`.

    Returns
    -------
    bool
        True: neither their triangles nor their cubics meet. False: they may meet.

    Examples
    --------
    >>> from geosurf import Lattice
    >>> axis, z = np.arange(9.0), np.add.outer(np.arange(9.0) ** 2, np.arange(9.0))
    >>> top, base, steep = (
    ...     TriSurface(name, lattice=Lattice(axis, axis, values))
    ...     for name, values in (("Top", z), ("Base", z - 5.0), ("Steep", -z))
    ... )
    >>> are_apart(top, base), are_apart(top, steep)
    (True, False)
    """
    first, second = one.lattice, two.lattice
    if first is None or second is None:
        return False
    for lattice in (first, second):
        if isinstance(lattice, ChunkedLattice) or not lattice.has_rising_axes or not lattice.whole:
            return False
    if not first.shares_map(second):
        return False
    for axis in (first.easting, first.northing):
        steps = np.diff(axis)
        if np.abs(np.diff(steps)).max(initial=0.0) > _EVEN * steps.min():
            return False
    from geosurf.kernels.smooth.layers import surely_apart

    return bool(surely_apart(first.elevation, second.elevation))


__all__ = ["are_apart"]
