"""Horizon data on a lattice: which node, what elevation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.sheets.lattice.frame import Frame


@dataclass(frozen=True, eq=False)
class Picks:
    """Horizon data on a lattice.

    Attributes
    ----------
    name : str
    frame : Frame
    given_node : ndarray of int64, shape (n,), or None
        Row times n_col plus column; several picks may share one. None: pick k is that of node k.
    z : ndarray of float64, shape (n,)
        Elevation [m].
    """

    name: str
    frame: Frame
    given_node: np.ndarray | None
    z: np.ndarray

    @cached_property
    def node(self) -> np.ndarray:
        """Node of each pick, int64 (n,); requested for some picks, `nodes_of` costs less."""
        return np.arange(len(self.z)) if self.given_node is None else self.given_node

    def nodes_of(self, rows: np.ndarray) -> np.ndarray:
        """Nodes of some picks."""
        return rows if self.one_each else self.node[rows]

    @property
    def n_node(self) -> int:
        """Number of nodes of the lattice."""
        return self.frame.shape[0] * self.frame.shape[1]

    @cached_property
    def _rising(self) -> bool:
        """Whether picks come node by node, one each."""
        return self.given_node is None or bool((self.node[1:] > self.node[:-1]).all())

    @cached_property
    def one_each(self) -> bool:
        """Whether pick k is that of node k, for all nodes."""
        if self.given_node is None:
            return True
        return self._rising and len(self.node) == self.n_node

    @cached_property
    def _by_node(self) -> tuple[np.ndarray, np.ndarray]:
        """Picks node by node, and their nodes."""
        order = np.argsort(self.node, kind="stable")
        return order, self.node[order]

    @cached_property
    def several(self) -> np.ndarray | None:
        """Whether nodes have more than one pick, bool (n_node,); None if none has."""
        if self._rising or not (many := np.bincount(self.node, minlength=self.n_node) > 1).any():
            return None
        return many

    @cached_property
    def means(self) -> np.ndarray:
        """Mean of the picks of each node (n_node,), NaN without; not to be written to."""
        # most grids have one pick per node, in order: no other array is made for them
        if self.one_each:
            return self.z

        # without doubles the mean is the pick itself, bit for bit
        if self.several is None:
            found = np.full(self.n_node, np.nan)
            found[self.node] = self.z
            return found
        count = np.bincount(self.node, minlength=self.n_node)
        with np.errstate(invalid="ignore"):
            return np.bincount(self.node, self.z, self.n_node) / count

    def of_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """Picks of some nodes, both increasing."""
        if self.one_each:
            return nodes
        if self._rising:
            at = np.searchsorted(self.node, nodes)
            return at[self.node[np.minimum(at, len(self.node) - 1)] == nodes]

        # runs of picks of each node in the sorted list, all at once
        order, node = self._by_node
        start, stop = (np.searchsorted(node, nodes, side=side) for side in ("left", "right"))
        count = stop - start
        rows = np.repeat(start - np.cumsum(count) + count, count) + np.arange(count.sum())
        return np.sort(order[rows])

    def means_at(self, nodes: np.ndarray, used: np.ndarray) -> np.ndarray:
        """Mean of the picks in use, bool (n_pick,), at some increasing nodes; NaN without."""
        # sums and counts over the asked nodes only; 0 / 0 is NaN where no pick is in use
        rows = self.of_nodes(nodes)
        rows = rows[used[rows]]
        at = np.searchsorted(nodes, self.nodes_of(rows))
        count = np.bincount(at, minlength=len(nodes))
        with np.errstate(invalid="ignore"):
            return np.bincount(at, self.z[rows], len(nodes)) / count

    def columns(self, rows: np.ndarray) -> np.ndarray:
        """Column and row (n, 2) of some picks."""
        return self.frame.uv_of_node(self.nodes_of(rows))

    def corners_of(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nodes (n, k) that some picks lie between, and their shares (n, k): one node each."""
        return self.nodes_of(rows)[:, None].copy(), np.ones((len(rows), 1))

    @property
    def on_nodes(self) -> bool:
        """Whether each pick is the height of a node."""
        return True

    def missed(self, values: np.ndarray, used: np.ndarray) -> np.ndarray:
        """Picks in use, bool (n_pick,), that heights (n_node,) do not meet bit for bit."""
        values = values if self.one_each else values[self.node]
        return np.flatnonzero((values != self.z) & used)

    def misfit(self, values: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Distance [m] of some picks from heights (n_node,) of a sheet."""
        return np.abs(values[self.nodes_of(rows)] - self.z[rows])

    def places(self, picks: np.ndarray) -> np.ndarray:
        """World coordinates (n, 3) of some picks."""
        return np.column_stack([self.frame.node_places(self.nodes_of(picks)), self.z[picks]])
