"""The neighbourhood of holes: all that is cut again while repairs change nothing else.

A repair changes a sheet at one place. Attempts look there first, and the whole sheet is cut once no
hole is left in the window. What is open at the rim of a window is open because the window ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.model.base import all_of
from geosurf.sheets.faults.fault_distance import Blocks
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.drape import around
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.mesh.holes import Hole
from geosurf.sheets.mesh.torn_mesh import Torn

REACH = 7  # cells around a hole and the ghosts behind it
RIM = 2  # cells of it along the rim, where nothing counts as open
MOST = 0.4  # of the ghosts of a sheet: more of them are cut with all others
FEWEST = 500  # ghosts: a smaller sheet is cut as a whole, which costs about as much as a window


@dataclass(frozen=True, eq=False)
class Window:
    """Some nodes of a lattice.

    Attributes
    ----------
    nodes : ndarray of int64
        Increasing; triangles between them are cut.
    inner : ndarray of int64
        Those away from its rim.
    """

    nodes: np.ndarray
    inner: np.ndarray

    @classmethod
    def around(
        cls,
        holes: Sequence[Hole],
        edges: Sequence[Sequence[Any]],
        torn: Torn,
        frame: Frame,
        before: Window | None,
    ) -> Window | None:
        """Around holes and open edges, and all of a window before.

        None if it has most of the sheet, or the sheet is small. `edges` start with two vertices of
        the mesh. One hole may open edges everywhere: then they do not count.
        """
        places = frame.to_lattice(np.array([hole.place[:2] for hole in holes]).reshape(-1, 2))
        at = _nodes_at(places, frame.shape)
        behind = torn.node_of(distinct(*(hole.ghosts for hole in holes)))
        ends = torn.node_of(np.array([edge[:2] for edge in edges], dtype=np.int64).ravel())
        some = np.concatenate([at, behind])
        return cls._of([np.concatenate([some, ends]), some], torn, frame, before)

    @classmethod
    def at_ends(cls, state: Heights, torn: Torn) -> Window | None:
        """Around the ends of all traces; None if it has most of the sheet, or that is small."""
        frame, places = state.network.frame, []
        for trace in state.network.traces:
            vertex = np.arange(len(trace.line))
            for place in (trace.start, trace.stop):
                places.append([np.interp(place, vertex, trace.line[:, c]) for c in (0, 1)])
        at = _nodes_at(np.array(places).reshape(-1, 2) / frame.stretch, frame.shape)
        return cls._of([at], torn, frame, None)

    @classmethod
    def _of(
        cls, middles: Sequence[np.ndarray], torn: Torn, frame: Frame, before: Window | None
    ) -> Window | None:
        """Around the first of some sets of nodes that leaves most of a sheet out; None if none."""
        if len(torn.node_of_ghost) < FEWEST:
            return None
        for middle in middles:
            nodes = around(middle, frame.shape, REACH)
            inner = around(middle, frame.shape, REACH - RIM)
            if before is not None:
                nodes, inner = distinct(nodes, before.nodes), distinct(inner, before.inner)
            if is_among(torn.node_of_ghost, nodes).sum() <= MOST * len(torn.node_of_ghost):
                return cls(nodes, inner)
        return None

    def has(self, nodes: np.ndarray) -> np.ndarray:
        """Whether nodes (n, k) are all away from its rim, bool (n,)."""
        return all_of(is_among(nodes.ravel(), self.inner).reshape(nodes.shape))

    def faults(self, frame: Frame, blocks: Sequence[Blocks]) -> list[int]:
        """Numbers of the faults that come near it."""
        places = frame.cells_of_node(self.nodes)
        return [k for k, of in enumerate(blocks) if len(of.of(places)[0])]


def _nodes_at(places: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """The nodes nearest to some places (n, 2) of a lattice: column and row."""
    n_row, n_col = shape
    col, row = np.rint(places).astype(np.int64).T
    return np.clip(row, 0, n_row - 1) * n_col + np.clip(col, 0, n_col - 1)
