"""Whether two lattices may meet next to absent nodes, where walks along cubics end."""

from __future__ import annotations

import numpy as np

from geosurf.intersect.sides import cubic_boxes, nodes_of
from geosurf.kernels.smooth.near_blocks import blocks_at_holes, near_blocks
from geosurf.kernels.smooth.patch_pyramid import BLOCK
from geosurf.model import TriSurface

_NO_PLANES = np.empty((0, 4))
_NOWHERE = np.array([np.inf] * 3 + [-np.inf] * 3)


def meet_at_holes(one: TriSurface, two: TriSurface) -> bool:
    """
    Return whether two lattices with cubics may meet near absent nodes of one of them.

    Parameters
    ----------
    one, two : TriSurface
        With cubics: `geosurf.intersect.sides.has_cubics`.

    Returns
    -------
    bool
        False: blocks of cells around absent nodes are apart from the other surface.

    Examples
    --------
    >>> from geosurf import Lattice
    >>> axis = np.arange(65.0)
    >>> z = np.add.outer(axis, 0.0 * axis)  # it rises to the north
    >>> z[:8, :8] = np.nan
    >>> flat = np.zeros((65, 65))
    >>> slope, low, high = (
    ...     TriSurface(name, lattice=Lattice(axis, axis, values))
    ...     for name, values in (("S", z), ("L", flat + 10.0), ("H", flat + 60.0))
    ... )
    >>> meet_at_holes(slope, low), meet_at_holes(slope, high)
    (True, False)
    """
    origin = np.zeros(3)
    for here, other in ((one, two), (two, one)):
        lattice = here.lattice
        if lattice is None or lattice.whole:
            continue
        boxes, levels = cubic_boxes(here, origin)
        n_row, n_col = levels[0, 1:].tolist()
        boxes[~blocks_at_holes(*nodes_of(lattice), n_row, n_col, BLOCK)] = _NOWHERE
        near, _ = near_blocks(boxes, levels, *cubic_boxes(other, origin), _NO_PLANES)
        if near.any():
            return True
    return False


__all__ = ["meet_at_holes"]
