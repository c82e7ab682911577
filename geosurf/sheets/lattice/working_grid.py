"""Heights of all nodes of a lattice, of which a band is made anew again and again."""

from __future__ import annotations

import numpy as np

from geosurf.sheets.lattice.data import Picks
from geosurf.sheets.lattice.sets import distinct


class Canvas:
    """The means of all picks, changed in a band: each change costs as much as its band has nodes.

    Attributes
    ----------
    values : ndarray (n_node,)
        NaN where there is nothing. One array for good: who keeps it sees the next change.
    """

    def __init__(self, picks: Picks) -> None:
        self.picks = picks
        self.values = picks.means.copy()
        self._changed = [np.empty(0, dtype=np.int64)]

    def without(self, left_out: np.ndarray) -> np.ndarray:
        """Take back all changes; leave out some picks, bool (n_pick,). Nodes that lose all theirs.

        Increasing; their values are NaN.
        """
        for nodes in self._changed:
            self.values[nodes] = self.picks.means[nodes]
        nodes = distinct(self.picks.nodes_of(np.flatnonzero(left_out)))
        several = self.picks.several is not None
        self.values[nodes] = self.picks.means_at(nodes, ~left_out) if several else np.nan
        self._changed = [nodes]
        return nodes[np.isnan(self.values[nodes])]

    def changing(self, nodes: np.ndarray) -> None:
        """Remember that the values of some nodes are about to change."""
        self._changed.append(nodes)
