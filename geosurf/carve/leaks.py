"""Where a horizon or contact leaks: its rim is open inside cells whose sides matter."""

from __future__ import annotations

import math

import numpy as np

from geosurf.carve.beyond import first_beyond
from geosurf.carve.cells import Cells
from geosurf.carve.zones import own_sides, owned_by
from geosurf.conventions import length_text, place
from geosurf.errors import OpenUnitError
from geosurf.model import Patches


def raise_leak(patches: Patches, cells: Cells, surface: int, torn: np.ndarray) -> None:
    """State where the rim of a horizon or contact is open, inside cells where that matters."""
    source = patches.sources[surface]
    what, name = source.role, source.name
    if not torn[own_sides(cells, surface)[2]].any():
        cells = cells.in_full
        rows = torn[cells.cell_of_side].any(axis=1)
        where = patches.local[cells.triangles[rows]].mean(axis=(0, 1)) + patches.origin
        remedy = (
            f"Extend the {what} into the block, or keep the box on one side of it. Where two "
            f"faults cross closer to the {what} than their throws together, the block between "
            "them has no room for it: move a fault until they cross farther away."
        )
        if source.sectors:
            remedy = (
                f"Faults cross next to the {what} there, and the piece between them is narrower "
                f"than its cells. Give the {what} on finer cells to throw_horizon, as from its "
                ".interp(easting=..., northing=...)."
            )
        raise OpenUnitError(
            f"cannot determine whether {place(where)} lies above or below {what} {name!r}: "
            f"the {what} is not in that block, and the blocks around it lie on both sides. "
            f"{remedy}",
            place=where,
            surfaces=(name,),
        )
    rim = rim_of_leak(patches, cells, surface, torn)
    if rim is None:
        raise OpenUnitError(
            f"{what} {name!r} does not separate the space above from the space below: it "
            "folds back, or a surface crosses itself and was not split there. Check the "
            "orientation of its triangles, or rebuild with self_intersections=True.",
            surfaces=(name,),
        )
    whole, middle = rim
    raise OpenUnitError(
        f"units leak around {what} {name!r}: {length_text(whole)} of its rim are open "
        f"inside the model box, for example at {place(middle)}.{_gap(patches, middle, surface)} "
        f"Shrink the box to the {what}, or extend or fill the {what}.",
        place=middle,
        surfaces=(name,),
    )


def _gap(patches: Patches, middle: np.ndarray, surface: int) -> str:
    """How far a rim ends from the next surface, in a sentence."""
    found = first_beyond(patches, middle, surface)
    if found is None:
        return ""
    other = patches.sources[found[0]]
    wall = other.role == "wall"
    next_one = f"{other.role} {other.name!r}"
    if wall:
        of_area = other.name == "aoi"
        next_one = f"the {'area of interest' if of_area else f'{other.name} side of the model'}"
        next_one = f"the side of {next_one}" if of_area else next_one
    return f" It ends {length_text(found[1])} before {next_one} there."


def rim_of_leak(
    patches: Patches,
    cells: Cells,
    surface: int,
    torn: np.ndarray,
    near: np.ndarray | None = None,
) -> tuple[float, np.ndarray] | None:
    """Return length [m] and a place of the open rim of a surface in some cells; None without one.

    The place is the middle of the longest edge, or that which is nearest to one of the points
    `near` (n, 3), in local coordinates.
    """
    cells = cells.in_full
    mine = owned_by(cells, surface)
    mine = mine[torn[cells.cell_of_side[mine]].any(axis=1)]
    t = cells.triangles

    # open rim: edges of the surface that no other triangle has
    ends = np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=2), axis=2)
    keys = ends[:, :, 0] * len(patches.local) + ends[:, :, 1]
    every, times = np.unique(keys, return_counts=True)
    rim = np.intersect1d(np.unique(keys[mine]), every[times == 1])
    if len(rim) == 0:
        return None
    a = patches.local[rim // len(patches.local)]
    b = patches.local[rim % len(patches.local)]
    length = np.linalg.norm(b - a, axis=1)
    middles = 0.5 * (a + b)
    if near is None:
        middles = middles[length == length.max()]
    else:
        from scipy.spatial import KDTree

        away = KDTree(near).query(middles)[0]
        middles = middles[away == away.min()]
    middle = middles[np.lexsort(middles.T[::-1])[0]] + patches.origin  # whatever the order of edges
    return math.fsum(length), middle
