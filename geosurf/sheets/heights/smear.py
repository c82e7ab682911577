"""How far off are data that were distrusted, seen where the sheets reach them from close by?

Gridding smears a horizon over its faults: a datum is off by a share of the throw, the less the
farther it is from the fault. A sheet that was rebuilt without such data tells how much, near all
faults alike. So where two faults leave a wedge without a trusted datum, what is known of data at
their distance elsewhere says how hard the sheet may be held to those within.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geosurf.sheets.lattice.noise import GAIN
from geosurf.sheets.lattice.solve import Graph, on_the_way

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.sheets.heights.heights import Heights, Near
    from geosurf.sheets.lattice.data import Picks

BIN = 0.25  # cells of distance from a fault over which data are taken together
FEWEST = 8  # data that a bin has to have
TENTH = 1.645  # a tenth of normal errors is larger than so many deviations


@dataclass(frozen=True, eq=False)
class Smear:
    """Spread of what distrusted data are off [m], by distance from the nearest fault.

    Attributes
    ----------
    spread : ndarray (n,)
        Of data from k to k + 1 bins away; never smaller nearer to the fault.
    """

    spread: np.ndarray

    def weight(
        self, far: np.ndarray, noise: float, signal: float, noise_weight: float | None
    ) -> np.ndarray:
        """How hard a sheet may be held to data (n,) at some distances from a fault [cells].

        A mean over h cells errs by about signal h^3. What neighbours are off together, unlike
        noise (`geosurf.sheets.lattice.noise.weight_of`), does not become less by it: both are
        equal at h^-6 = (signal / spread)^2.
        """
        at = np.minimum(far / BIN, len(self.spread) - 1).astype(np.int64)
        shared = np.maximum(self.spread[at] ** 2 - noise**2, 0.0)
        most = 1.0 if noise_weight is None else noise_weight
        hard = most * shared <= GAIN * signal**2
        shared = np.where(hard, 1.0, shared)
        return np.where(hard, most, GAIN * signal**2 / shared)


def distances(near: Sequence[Near]) -> tuple[np.ndarray, np.ndarray]:
    """Picks near any fault, increasing, and how far each is from the nearest one [cells]."""
    rows = np.concatenate([np.empty(0, np.int64), *(fault.rows for fault in near)])
    far = np.concatenate([np.empty(0), *(fault.far for fault in near)])
    order = np.lexsort((far, rows))
    rows, far = rows[order], far[order]
    first = np.append(True, rows[1:] != rows[:-1])[: len(rows)]
    return rows[first], far[first]


def hidden_misfits(
    picks: Picks, near: Sequence[Near], state: Heights, in_gap: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distrusted data of nodes that have no other, outside of gaps: which, how far, how much off.

    Returns
    -------
    rows : ndarray of int64 (n,)
    far : ndarray (n,)
        From the nearest fault, at their own height [cells].
    misfit : ndarray (n,)
        From the sheet of their side of the map [m].
    """
    rows, far = distances(near)
    empty = np.zeros(len(picks.z), dtype=bool)
    empty[in_gap] = True
    keep = state.distrusted[rows] & ~empty[rows]
    if picks.several is not None:
        keep &= ~picks.several[picks.nodes_of(rows)]
    rows, far = rows[keep], far[keep]
    misfit = picks.misfit(state.values, rows)
    known = np.isfinite(misfit)
    return rows[known], far[known], misfit[known]


def smear_of(far: np.ndarray, misfit: np.ndarray) -> Smear | None:
    """Spread of misfits (n,) at some distances from a fault [cells]; None if they are too few."""
    number = (far / BIN).astype(np.int64)
    spread = np.full(int(number.max(initial=-1)) + 1, np.nan)
    for k in range(len(spread)):
        mine = misfit[number == k]
        if len(mine) >= FEWEST:
            spread[k] = float(np.percentile(mine, 90)) / TENTH
    known = np.flatnonzero(np.isfinite(spread))
    if not len(known):
        return None
    spread = np.interp(np.arange(len(spread)), known, spread[known])
    return Smear(np.maximum.accumulate(spread[::-1])[::-1])


class Doubts:
    """Distrusted data of one horizon: how far they are from faults, and how far off.

    Attributes
    ----------
    signal : float
        Typical third difference of the surface [m].
    smear : Smear or None
        None before it was seen, or if too few data tell.
    """

    def __init__(self, picks: Picks, near: Sequence[Near]) -> None:
        self.picks, self.near = picks, near
        self.signal = 0.0
        self.smear: Smear | None = None

    def see(self, state: Heights, in_gap: np.ndarray, reach: float) -> None:
        """Read the smear at nodes that lie within some steps of trusted data of their side."""
        if not len(state.unknown):
            return
        rows, far, misfit = hidden_misfits(self.picks, self.near, state, in_gap)
        nodes = self.picks.nodes_of(rows)
        at = np.minimum(np.searchsorted(state.unknown, nodes), len(state.unknown) - 1)
        close = (state.unknown[at] == nodes) & (state.extrapolation[at] <= reach)
        self.smear = smear_of(far[close], misfit[close])

    def heard(self, graph: Graph, steps: np.ndarray, reach: int) -> np.ndarray:
        """Which nodes of a graph, so many steps (n,) from data, have distrusted data heard.

        Those farther than `reach`, and once the smear is seen also those on shortest ways there:
        good data near trusted ones keep a wedge from turning about those. The worst place of
        72 acute faults (docs/validation/torn_sheets.md) misses 1.2 % instead of 1.7, with a
        trim of two cells.
        """
        if self.smear is None or not (steps > reach).any():
            return np.flatnonzero(steps > reach)
        return on_the_way(graph, steps, reach)

    def far(self, nodes: np.ndarray) -> np.ndarray:
        """Distance (n,) of the nearest pick of some nodes from any fault, at its own height."""
        rows, far = distances(self.near)
        found = np.full(self.picks.n_node, np.inf)
        np.minimum.at(found, self.picks.nodes_of(rows), far)
        return found[nodes]

    def pull(
        self, far: np.ndarray, noise: float, most: float | None, unseen: np.ndarray
    ) -> np.ndarray:
        """How hard a sheet is held to data (n,) at distances from faults [cells].

        See `Smear.weight`; `unseen` (n,) where no smear was seen.
        """
        if self.smear is None:
            return unseen
        return self.smear.weight(far, noise, self.signal, most)
