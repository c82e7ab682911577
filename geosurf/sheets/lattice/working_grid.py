"""Heights of all nodes of a lattice, of which a band near the faults is solved again and again."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.sheets.lattice.picks import Picks


class WorkingGrid:
    """The means of all picks, changed in a band: each change costs as much as its band has nodes.

    It is the one thing that passes over a grid share and write to: a copy of all nodes for each
    pass would cost more than the pass.

    Attributes
    ----------
    values : ndarray (n_node,)
        NaN where there is no value. One array throughout: its holders see the next change.
    """

    def __init__(self, picks: Picks) -> None:
        self.picks = picks
        self.values = picks.means.copy()
        self._changed = [np.empty(0, dtype=np.int64)]

    def without(self, left_out: np.ndarray) -> np.ndarray:
        """Undo all changes and leave out some picks, bool (n_pick,).

        Returns the nodes that lose all their picks, increasing; their values are NaN.
        """
        # only what changed since the last call is written again: a pass costs its band, not the
        # grid
        for nodes in self._changed:
            self.values[nodes] = self.picks.means[nodes]
        nodes = distinct(self.picks.nodes_of(np.flatnonzero(left_out)))

        # a node with other picks keeps their mean; one without is lost
        several = self.picks.several is not None
        self.values[nodes] = self.picks.means_at(nodes, ~left_out) if several else np.nan
        self._changed = [nodes]
        return nodes[np.isnan(self.values[nodes])]

    def mark(self, nodes: np.ndarray) -> None:
        """Note nodes whose values the caller is about to change."""
        self._changed.append(nodes)
