"""How far off ignored data are, by distance from a fault, and how much weight that leaves them.

Gridding smears a horizon over its faults: a datum is off by a share of the throw, the less the
farther it is from the fault. A sheet that was rebuilt without such data shows how much, near all
faults alike. Where two faults leave a wedge without trusted data, the ignored data there are used
with the weight that data at their distance from a fault deserve elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.sheets.heights.inputs import NearPicks
from geosurf.sheets.lattice.noise import GAIN, Noise
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.solve import Graph, on_the_way

BIN = 0.25  # cells of distance from a fault over which data are taken together
FEWEST = 8  # data that a bin has to have
TENTH = 1.645  # a tenth of normal errors is larger than this many standard deviations


@dataclass(frozen=True, eq=False)
class Smear:
    """Spread of the errors of ignored data [m], by distance from the nearest fault.

    Attributes
    ----------
    spread : ndarray (n,)
        Of data from k to k + 1 bins away; never smaller nearer to the fault.
    """

    spread: np.ndarray

    def weight(self, far: np.ndarray, noise: Noise) -> np.ndarray:
        """Weight (n,) of data at some distances from a fault [cells].

        An average over h cells errs by about signal h^3. Errors that neighbours share, unlike
        noise (`geosurf.sheets.lattice.noise.weight_of`), do not average out: both are equal at
        h^-6 = (signal / spread)^2.
        """
        # the square of what neighbours share: noise averages out and is taken off
        # bin of each datum; beyond the last bin its spread goes on
        at = np.minimum(far / BIN, len(self.spread) - 1).astype(np.int64)
        shared = np.maximum(self.spread[at] ** 2 - noise.deviation**2, 0.0)
        most = 1.0 if noise.weight is None else noise.weight

        # where the spread is less than noise allows for, the usual weight holds; 1 avoids 0 / 0
        hard = most * shared <= GAIN * noise.signal**2
        shared = np.where(hard, 1.0, shared)
        return np.where(hard, most, GAIN * noise.signal**2 / shared)


def smear_of(far: np.ndarray, misfit: np.ndarray) -> Smear | None:
    """Spread of misfits (n,) at some distances from a fault [cells]; None if they are too few."""
    # 90th percentile of the misfit in each bin, as a standard deviation
    number = (far / BIN).astype(np.int64)
    spread = np.full(int(number.max(initial=-1)) + 1, np.nan)
    for k in range(len(spread)):
        mine = misfit[number == k]
        if len(mine) >= FEWEST:
            spread[k] = float(np.percentile(mine, 90)) / TENTH
    known = np.flatnonzero(np.isfinite(spread))
    if not len(known):
        return None

    # bins with too few data lie between their neighbours; nearer to the fault is never better
    spread = np.interp(np.arange(len(spread)), known, spread[known])
    return Smear(np.maximum.accumulate(spread[::-1])[::-1])


def distances(near: Sequence[NearPicks]) -> tuple[np.ndarray, np.ndarray]:
    """Picks near any fault, increasing, and how far each is from the nearest one [cells]."""
    rows = np.concatenate([np.empty(0, np.int64), *(fault.rows for fault in near)])
    far = np.concatenate([np.empty(0), *(fault.far for fault in near)])

    # a pick near several faults counts with the nearest one
    order = np.lexsort((far, rows))
    rows, far = rows[order], far[order]
    first = np.append(True, rows[1:] != rows[:-1])[: len(rows)]
    return rows[first], far[first]


def distance_of_nodes(picks: Picks, near: Sequence[NearPicks], nodes: np.ndarray) -> np.ndarray:
    """Distance (n,) of the nearest pick of some nodes from any fault, at its own height."""
    rows, far = distances(near)

    # the nearest pick of each node counts; infinite for nodes without picks near a fault
    found = np.full(picks.n_node, np.inf)
    np.minimum.at(found, picks.nodes_of(rows), far)
    return found[nodes]


def wedge_nodes(graph: Graph, steps: np.ndarray, reach: int, smear: Smear | None) -> np.ndarray:
    """Nodes of a graph, so many steps (n,) from trusted data, at which ignored data are used.

    Those farther than `reach`. Once the smear is known also those on shortest ways there: good data
    near trusted ones keep a wedge from turning about those. The worst place of 72 acute faults
    (docs/validation/torn_sheets.md) misses 1.2 % instead of 1.7, with a trim of two cells.
    """
    if smear is None or not (steps > reach).any():
        return np.flatnonzero(steps > reach)
    return on_the_way(graph, steps, reach)
