"""Cells -> zones: above or below which horizon is each cell, and which zone is that.

A cell in front of a horizon (its upper side) is above it, one behind it is below; both
hold across any other horizon, so that cells which do not touch a horizon learn from
their neighbours above and below; across faults only cells that have no such neighbour
(throw brings what is above beside what is below). The zone of a cell is the first horizon,
youngest first, that it is above: where horizons cross, the younger one wins and the older
ones end on it (zero thickness).
"""

from __future__ import annotations

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.conventions import place
from geosurf.errors import GeometryError, OpenUnitError
from geosurf.model import Patches


def faces_between(cells: Cells) -> np.ndarray:
    """Triangles with different cells in front and behind: rows of `Cells.triangles`."""
    return np.flatnonzero(cells.cell_of_side[:, 0] != cells.cell_of_side[:, 1])


def upper_sides(patches: Patches, cells: Cells, horizon: int) -> np.ndarray:
    """(cell above, cell below) of each triangle of a horizon, int64 (n, 2)."""
    mine = owned_by(cells, horizon)
    t = cells.triangles[mine]
    a, b, c = (patches.local[t[:, k]] for k in range(3))
    rise = np.cross(b - a, c - a)[:, 2]
    sides = cells.cell_of_side[mine]
    return sides if rise.sum() >= 0 else sides[:, ::-1]


def owned_by(cells: Cells, surface: int) -> np.ndarray:
    """Rows of the triangles of a surface, those that it shares with others included."""
    mine = cells.surface_of == surface
    mine[[i for i, listed in cells.also.items() if surface in listed]] = True
    return np.flatnonzero(mine)


def distinct_pairs(pairs: np.ndarray, n_cell: int) -> np.ndarray:
    """Pairs of cells inside the box, lower first, each once."""
    low, high = pairs.min(axis=1, initial=n_cell), pairs.max(axis=1, initial=0)
    keys = np.unique((low * (n_cell + 1) + high)[low > 0])
    return np.stack(np.divmod(keys, n_cell + 1), axis=1)


def zones_of(patches: Patches, cells: Cells, horizons: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Zone of each cell (1..n_cell; row 0 is the outside, -1), and whether horizons cross there.

    Raises
    ------
    OpenUnitError
        If a horizon does not separate what is above it from what is below.
    GeometryError
        If a horizon is not in the box at all.
    """
    above = np.zeros((len(horizons), cells.n_cell + 1), dtype=np.int64)
    pairs = cells.cell_of_side[faces_between(cells)]
    for k, horizon in enumerate(horizons):
        sides = upper_sides(patches, cells, horizon)
        if len(sides) == 0:
            raise GeometryError(
                f"horizon {patches.names[horizon]!r} does not reach the model box; enlarge the "
                "box, or leave the horizon out."
            )
        for side, sign in ((0, 1), (1, -1)):
            touched = np.unique(sides[:, side])
            touched = touched[touched > 0]
            if (above[k, touched] == -sign).any():
                _raise_leak(patches, cells, horizon)
            above[k, touched] = sign
        # throw parts what is above from what is below, so faults carry only what nothing else tells
        _spread(above[k], _neighbours_across(cells, pairs, horizon, horizons))
        _spread(above[k], _neighbours_across(cells, pairs, horizon))
        if (above[k, 1:] == 0).any():
            _raise_leak(patches, cells, horizon)
    is_above = above > 0
    lowest = np.ones((1, cells.n_cell + 1), dtype=bool)  # below all horizons, if there are any
    zone = np.concatenate([is_above, lowest]).argmax(axis=0)
    first = zone[None, :] <= np.arange(len(horizons))[:, None]
    crossed = (first & ~is_above).any(axis=0)
    zone[0] = -1
    return zone, crossed


def _neighbours_across(
    cells: Cells, pairs: np.ndarray, horizon: int, through: list[int] | None = None
) -> np.ndarray:
    """Pairs of cells with a surface between them other than one horizon: any, or some of them."""
    wanted = np.zeros(len(cells.triangles), dtype=bool)
    if through is None:
        wanted[:] = True
    else:
        for other in through:
            wanted[owned_by(cells, other)] = True
    wanted[owned_by(cells, horizon)] = False
    return distinct_pairs(pairs[wanted[faces_between(cells)]], cells.n_cell)


def _spread(values: np.ndarray, links: np.ndarray) -> None:
    """Carry +1 and -1 over links to cells that have 0."""
    while True:
        a, b = values[links[:, 0]], values[links[:, 1]]
        onward = links[(a != 0) & (b == 0)]
        back = links[(a == 0) & (b != 0)]
        if len(onward) + len(back) == 0:
            return
        values[onward[:, 1]] = values[onward[:, 0]]
        values[back[:, 0]] = values[back[:, 1]]


def _raise_leak(patches: Patches, cells: Cells, horizon: int) -> None:
    """Say where the rim of a horizon is open inside the box."""
    mine = owned_by(cells, horizon)
    t = cells.triangles
    ends = np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=2), axis=2)
    keys = ends[:, :, 0] * len(patches.local) + ends[:, :, 1]
    every, times = np.unique(keys, return_counts=True)
    rim = np.intersect1d(np.unique(keys[mine]), every[times == 1])
    name = patches.names[horizon]
    if len(rim) == 0:
        raise OpenUnitError(
            f"horizon {name!r} does not separate what lies above it from what lies below: it "
            "turns back on itself. Check the orientation of its triangles."
        )
    a = patches.local[rim // len(patches.local)]
    b = patches.local[rim % len(patches.local)]
    length = np.linalg.norm(b - a, axis=1)
    i = int(length.argmax())
    raise OpenUnitError(
        f"units leak around horizon {name!r}: {length.sum():.6g} m of its rim are open inside the "
        f"model box, for one at {place(0.5 * (a[i] + b[i]) + patches.origin)}. Shrink the box to "
        "where the horizon is, or extend or fill the horizon."
    )
