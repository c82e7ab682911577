"""Cells without any piece of a horizon: on which side of it they lie, by where it would be.

Where two faults cross closer to a horizon than their throws, a wedge between them has no piece of
it, and the wedges next to it lie on both sides. A horizon that throw moved states where it would be
in that wedge (`geosurf.model.sheets`). It is not in the cell, which topology shows exactly; so
all corners of the cell lie on one side of where it would be. Corners on both sides mean that the
horizon ought to be there: the cell stays unknown, which is refused.
"""

from __future__ import annotations

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.model import Patches
from geosurf.model.surfaces import Sector

ROUNDING = 1e-9  # metres: a corner as near as this to where the horizon would be says nothing


def sides_by_sectors(
    patches: Patches, cells: Cells, surface: int, unknown: np.ndarray
) -> dict[int, int]:
    """
    Return the side of cells that follows from where a horizon would be.

    Parameters
    ----------
    patches : Patches
    cells : Cells
    surface : int
        Row of `patches.sources`.
    unknown : ndarray of bool, shape (n_cell + 1,)
        Cells that the horizon does not touch, and whose neighbours lie on both sides.

    Returns
    -------
    dict of int to int
        By cell: 1 above, -1 below. Cells about which nothing is known are left out.
    """
    sectors = patches.sources[surface].sectors
    if not sectors or not unknown.any():
        return {}
    full = cells.in_full
    touched = {name: _touched(patches, full, name) for one in sectors for name in one.faults}
    found = {}
    for cell in np.flatnonzero(unknown).tolist():
        rows = (full.cell_of_side == cell).any(axis=1)
        corners = full.x[np.unique(full.triangles[rows])] + patches.origin
        far = [
            corners[:, 2] - one.at(corners[:, :2]) for one in sectors if _is_in(cell, one, touched)
        ]
        if not far:
            continue
        away = np.concatenate(far)
        above, below = bool((away > ROUNDING).any()), bool((away < -ROUNDING).any())
        if above != below:
            found[cell] = 1 if above else -1
    return found


def _touched(patches: Patches, full: Cells, name: str) -> np.ndarray:
    """Whether each cell touches front and back of a fault, bool (n_cell + 1, 2); slits apart."""
    out = np.zeros((full.n_cell + 1, 2), dtype=bool)
    if name not in patches.names:
        return out
    sides = full.cell_of_side[full.surface_of == patches.names.index(name)]
    sides = sides[sides[:, 0] != sides[:, 1]]
    out[sides[:, 0], 0] = out[sides[:, 1], 1] = True
    return out


def _is_in(cell: int, sector: Sector, touched: dict[str, np.ndarray]) -> bool:
    """Whether a cell lies on the sides of both faults that a sector is on, and on no other."""
    return all(
        touched[name][cell].tolist() == [front, not front]
        for name, front in zip(sector.faults, sector.front, strict=True)
    )
