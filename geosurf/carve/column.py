"""Apply the rules of the stratigraphic column: sides of horizons -> zones, cell by cell.

Layers are laid down oldest first. Each horizon, when its turn comes, first stops at the
base below it (onlap), unless it erodes; then all older horizons end on it. So for each
pair that crosses one rule counts: the younger one wins where it is ``erosional`` or
``discontinuous``; else the older one where it is a ``base`` or ``discontinuous``; else, of
two conformable ones, the younger (what is between them has no thickness there). After
each turn the horizons are in order, so the zone of a cell is the first horizon that it is above.

What is unknown may stay so where no rule asks: in three-valued logic (Kleene 1952), "and" is
the lower of two sides, "or" the higher.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.zones import ABOVE, UNKNOWN, own_sides, owned_by
from geosurf.conventions import length_text, place
from geosurf.errors import InputError, OpenUnitError
from geosurf.model import Patches
from geosurf.model.column import BASE as LAPPED
from geosurf.model.column import CONFORMABLE, ERODES, EROSIONAL, IS_LAPPED

# ---- leaks ----------------------------------------
# Where a horizon or contact leaks: its rim is open inside cells whose sides matter.


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


# ---- what a surface does not reach: the first surface that its open rim would meet if it went on -


BLOCK = 1 << 17  # triangles that are looked at together


def first_beyond(patches: Patches, middle: np.ndarray, surface: int) -> tuple[int, float] | None:
    """
    Return the surface that a rim would meet straight on, and how far away [m]; None without one.

    Parameters
    ----------
    patches : Patches
    middle : ndarray of float64, shape (3,)
        Middle of an edge of the rim, in world coordinates.
    surface : int
        Row of `patches.sources` that the rim belongs to.
    """
    at = middle - patches.origin
    own = patches.surface_of_triangle == surface
    direction = _outward(patches.local[patches.triangles[own]], at)
    others = np.flatnonzero(~own)
    best: tuple[int, float] | None = None
    for start in range(0, len(others), BLOCK):
        rows = others[start : start + BLOCK]
        away = _along(patches.local[patches.triangles[rows]], at, direction)
        k = int(np.argmin(away))
        if np.isfinite(away[k]) and (best is None or away[k] < best[1]):
            best = int(patches.surface_of_triangle[rows[k]]), float(away[k])
    return best


def _outward(corners: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Unit vector out of a surface, in its plane, at the middle of an edge."""
    ends = np.roll(corners, -1, axis=1)
    away = ((0.5 * (corners + ends) - at) ** 2).sum(axis=2)
    row, k = np.unravel_index(int(np.argmin(away)), away.shape)
    along = ends[row, k] - corners[row, k]
    out = at - corners[row, (k + 2) % 3]
    out = out - (out @ along) / (along @ along) * along
    direction: np.ndarray = out / np.linalg.norm(out)
    return direction


def _along(corners: np.ndarray, at: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Distances along a ray to triangles (n, 3, 3), infinite where it misses; to rounding.

    T. Moeller, B. Trumbore (1997), Fast, Minimum Storage Ray/Triangle Intersection.
    """
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(direction, two)
    size = np.einsum("nc,nc->n", one, p)
    parallel = size == 0.0
    size = np.where(parallel, 1.0, size)
    from_corner = at - corners[:, 0]
    u = np.einsum("nc,nc->n", from_corner, p) / size
    q = np.cross(from_corner, one)
    v = (q @ direction) / size
    t = np.einsum("nc,nc->n", two, q) / size
    # a ray through an edge may miss both of its triangles by rounding
    slack = 1e-9
    hits = ~parallel & (u >= -slack) & (v >= -slack) & (u + v <= 1.0 + slack) & (t >= 0.0)
    return np.where(hits, t, np.inf)


@dataclass(frozen=True)
class Turn:
    """One horizon that yielded to another, in some cells.

    Attributes
    ----------
    loser, winner : int
        Numbers of the horizons, 0 for the youngest.
    rule : str
    before, after : ndarray of int64, shape (n_cell + 1,)
        Side of the loser, as clipped so far, that each cell is on.
    """

    loser: int
    winner: int
    rule: str
    before: np.ndarray
    after: np.ndarray


def apply_column(signature: np.ndarray, rules: Sequence[str]) -> tuple[np.ndarray, list[Turn]]:
    """
    Side of each horizon, as the column leaves it, that each cell is on.

    Parameters
    ----------
    signature : ndarray of int64, shape (n_horizon, n_cell + 1)
        Side of each horizon as given, youngest first.
    rules : sequence of str
        One for each horizon.

    Returns
    -------
    ndarray of int64, shape (n_horizon, n_cell + 1)
        What is above a horizon is above all older ones.
    list of Turn
        All that changed a cell, in the order of time.

    Examples
    --------
    A cell below Top and above Base is where they cross the wrong way; erosion takes it away:

    >>> import numpy as np
    >>> sides, turns = apply_column(np.array([[1, 1], [-1, 1]]), ["erosional", "conformable"])
    >>> sides.tolist(), [(turn.loser, turn.winner, turn.rule) for turn in turns]
    ([[1, 1], [1, 1]], [(1, 0, 'erosional')])
    """
    side = signature.copy()
    turns: list[Turn] = []

    def clip(loser: int, winner: int, rule: str, after: np.ndarray) -> None:
        """One surface yields to another; note it where that changes anything."""
        if not np.array_equal(after, side[loser]):
            turns.append(Turn(loser, winner, rule, side[loser].copy(), after))
            side[loser] = after

    # from the oldest to the youngest, as layers were laid down
    for k in reversed(range(len(rules))):
        older = range(k + 1, len(rules))

        # an eroding horizon cuts through the base below it instead of ending on it
        if rules[k] not in ERODES:
            # horizons are in order by now, so that the youngest base is the highest
            base = next((j for j in older if rules[j] in IS_LAPPED), None)
            if base is not None:
                # "above both": a cell counts as above k only if it is above the base, so k ends on
                # it
                clip(k, base, LAPPED, np.minimum(side[k], side[base]))

        # older horizons end at k: what is above k is above them
        rule = EROSIONAL if rules[k] in ERODES else CONFORMABLE
        for j in older:
            clip(j, k, rule, np.maximum(side[j], side[k]))
    return side, turns


def zones_of(patches: Patches, cells: Cells, side: np.ndarray, horizons: list[int]) -> np.ndarray:
    """
    Zone of each cell, int64 (n_cell + 1,): the first horizon that it is above; -1 outside.

    Raises
    ------
    OpenUnitError
        If a horizon does not separate what is above it from what is below, where it counts.
    """
    # a cell whose side nobody knows was reached around the rim of the horizon: a leak
    for k, horizon in enumerate(horizons):
        unknown = side[k] == UNKNOWN
        unknown[0] = False
        if unknown.any():
            raise_leak(patches, cells, horizon, unknown)

    # argmax finds the first horizon that a cell is above; the last row catches what is below all of
    # them
    lowest = np.ones((1, side.shape[1]), dtype=bool)  # below all horizons, if there are any
    zone = np.concatenate([side == ABOVE, lowest]).argmax(axis=0)
    zone[0] = -1
    return zone


def names_of_zones(horizons: Sequence[str]) -> list[str]:
    """
    Names of the zones between horizons, youngest first.

    Raises
    ------
    InputError
        If two would have one name.

    Examples
    --------
    >>> names_of_zones(["Top", "Base"])
    ['above Top', 'Top/Base', 'below Base']
    """
    if not horizons:
        return ["box"]
    between = [f"{a}/{b}" for a, b in pairwise(horizons)]
    names = [f"above {horizons[0]}", *between, f"below {horizons[-1]}"]

    # 'A/B' between 'A' and 'B' may also be the name of a horizon
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"two zones would have the name {name!r} because names of horizons contain '/'. "
                "Rename one of the horizons."
            )
    return names
