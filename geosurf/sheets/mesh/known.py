"""What attempts to close one sheet have in common, found once: a repair changes one place.

Most of a torn mesh, and on which side of the faults its nodes are, stays as it was in the attempt
before.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from threading import Lock

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.sheets.faults.cut_edges import Cuts
from geosurf.sheets.faults.fault_distance import Blocks, side_at_own_height
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.mesh.rings import grown_at, grown_over
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles, tear

CLEARLY = 0.3  # cells from a fault at which a node's side is clear

Ring = Collection[tuple[int, int]]


class Known:
    """What attempts to close one sheet have found out.

    Attributes
    ----------
    frame : Frame
    triangles : Triangles
    meshes : list of (FaultMesh, Blocks)
        The faults in the frame of the lattice, and blocks to search them by.
    reach : float
        Cells from a trace within which sides are looked at.
    """

    def __init__(
        self,
        frame: Frame,
        triangles: Triangles,
        meshes: Sequence[tuple[FaultMesh, Blocks]],
        reach: float,
    ) -> None:
        self.frame, self.triangles = frame, triangles
        self.meshes, self.reach = list(meshes), reach
        # what all of this follows from, besides links, rings and heights
        self._state: Heights | None = None
        # links that tear the last mesh, and the mesh without rings, with one, with two ..
        self._cuts: Cuts | None = None
        self._rings: list[Ring] = []
        self._torn: list[Torn] = []
        # heights at which nodes were asked for, NaN for others, and what came of it
        self._height = np.full(len(triangles.present), np.nan)
        self._is_own = np.zeros(len(triangles.present), dtype=bool)
        self._lock = Lock()

    def mesh(self, cuts: Cuts, state: Heights, rings: Sequence[Ring]) -> Torn:
        """The mesh torn by some links, with rings of ghosts.

        It starts from the last one, with as many of its rings as are the same.
        """
        self._forget_unless_like(state)
        if self._cuts is None or not _same(cuts, self._cuts):
            torn = grown_over(tear(cuts, self.triangles), self.triangles, state)
            self._cuts, self._rings, self._torn = cuts, [], [torn]
        pairs = zip(self._rings, rings, strict=False)
        n = next((k for k, (old, new) in enumerate(pairs) if old != new), None)
        n = min(len(self._rings), len(rings)) if n is None else n
        del self._rings[n:], self._torn[n + 1 :]
        for ring in rings[n:]:
            self._torn.append(grown_at(self._torn[-1], self.triangles, ring))
            self._rings.append(ring)
        return self._torn[-1]

    def is_own(self, nodes: np.ndarray, state: Heights) -> np.ndarray:
        """Whether nodes are clearly on their own side of all faults, at their solved heights.

        `state` is that of the last mesh.
        """
        # islands ask side by side
        with self._lock:
            changed = nodes[state.values[nodes] != self._height[nodes]]
            if len(changed):
                changed = distinct(changed)
                self._is_own[changed] = self._asked(changed, state)
                self._height[changed] = state.values[changed]
            return self._is_own[nodes]

    def _forget_unless_like(self, state: Heights) -> None:
        """Forget everything if traces or walls are others; their heights may change."""
        old, self._state = self._state, state
        if old is None or (
            old.network is state.network
            and old.walls is state.walls
            and all(a is b for a, b in zip(old.near, state.near, strict=True))
        ):
            return
        self._cuts = None
        self._height[:] = np.nan

    def _asked(self, nodes: np.ndarray, state: Heights) -> np.ndarray:
        points = np.column_stack([self.frame.cells_of_node(nodes), state.values[nodes]])
        out = np.ones(len(nodes), dtype=bool)
        # Sides at the solved height: a fault that dips is elsewhere at another elevation.
        network = state.network
        sides = {
            k: side_at_own_height(*self.meshes[k], points, self.reach)
            for k in {trace.fault for trace in network.traces}
        }
        for trace, limits, near in zip(network.traces, network.mesh, state.near, strict=True):
            far, side = sides[trace.fault]

            # rows of nodes near the trace (-1: far); off the torn part, or where the fault is out
            # of reach (side 0), a node has no wrong side
            at = near.look_up(nodes)
            inside = (at >= 0) & (side != 0)
            inside &= (near.place[at] > limits[0]) & (near.place[at] < limits[1])
            out &= ~inside | ((side == near.side[at]) & (far > CLEARLY))
        return out


def _same(one: Cuts, other: Cuts) -> bool:
    """Whether the same links are cut, by the same traces at the same places."""
    return (
        np.array_equal(one.node, other.node)
        and np.array_equal(one.kind, other.kind)
        and np.array_equal(one.trace, other.trace)
    )
