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

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.leaks import raise_leak
from geosurf.carve.zones import ABOVE, UNKNOWN
from geosurf.errors import InputError
from geosurf.model import Patches
from geosurf.model.column import BASE as LAPPED
from geosurf.model.column import CONFORMABLE, ERODES, EROSIONAL, IS_LAPPED


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
