"""Whether a torn sheet that nobody has cut ends on its faults: seen in the model that cuts it.

`build` looks for leaks after a cut of its own. The cut of a model shows the same edges: a sheet
that is closed there is closed. Of every other one a cut of the sheet alone decides: `NotShown` has
the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.model import Sheet
from geosurf.model.base import all_of, any_of
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild.closed_sheets import SheetInModel
from geosurf.rebuild.wall_sides import WALL
from geosurf.sheets.mesh.build import Built
from geosurf.sheets.mesh.cut import walls_of_vertices
from geosurf.sheets.mesh.leaks import open_edges


class NotShown(Exception):
    """A model does not show that a sheet is closed; its text is the reason."""


class Proof:
    """
    What has to hold for a sheet in a model; `done` once it does.

    Calling it raises `NotShown`, unless the sheet in the model is shown to be closed.

    Parameters
    ----------
    built : Built
        That nobody has cut, or only in a window; with `Built.is_own`.
    names : list of str
        Of the faults.
    lattice : TornLattice
        Of the sheet.
    """

    def __init__(self, built: Built, names: Sequence[str], lattice: TornLattice) -> None:
        self.built, self.names, self.lattice = built, names, lattice
        self.done = False

    def __call__(self, found: SheetInModel | None) -> None:
        """Look at a sheet in a model; None where the model cannot show it."""
        if found is None:
            raise NotShown("the model looks at the sheet as a list")
        if found.has_false_rim:
            raise NotShown("a part stays next to one that is dropped")
        if self._loses_a_wall(found):
            raise NotShown("a fault has no cut-off of one wall")
        if self._drops_own(found):
            raise NotShown("a part with data on their own side is dropped")
        number = self.lattice.node_of_vertex
        corner = np.where(found.corner >= 0, number[found.corner], -1)
        if open_edges(
            found.triangles, corner, found.rim, found.stays, len(found.on_fault),
            self.built.torn, self.built.triangles,
        ):  # fmt: skip
            raise NotShown("an outer edge stays open")
        self.done = True

    def _loses_a_wall(self, found: SheetInModel) -> bool:
        """Whether a fault that tears the sheet has no cut-off of one of its walls."""
        traces = self.built.state.network.traces
        for fault in {traces[k].fault for k in distinct(self.built.cuts.trace).tolist()}:
            row = found.at_faults.get(self.names[fault], np.empty(0, dtype=np.int64))
            row = distinct(found.parent[row[found.stays[row]]])
            vertex = self.lattice.node_of_vertex[self._corners(row)]
            side = self._walls(fault, vertex)
            if not ((side > 0).any() and (side < 0).any()):
                return True
        return False

    def _walls(self, fault: int, vertex: np.ndarray) -> np.ndarray:
        """Wall of triangles at a fault (n,), by their corners (n, 3): above 0 its hanging wall.

        Of sheets that throw moved all corners have to agree; of others most of them decide, as for
        cut-offs.
        """
        built = self.built
        if built.walls is None:
            side = built.state.sides_of(fault, built.torn.anchored(vertex))
            found: np.ndarray = side.sum(axis=1)
            return found
        walls = walls_of_vertices(built.walls, built.torn, vertex.ravel())
        side = walls[WALL + self.names[fault]].reshape(-1, 3)
        return np.where(all_of(side > 0), 1, np.where(all_of(side < 0), -1, 0))

    def _drops_own(self, found: SheetInModel) -> bool:
        """Whether a part is dropped that has whole triangles clearly on their own side."""
        row = np.flatnonzero(~found.stays & (found.parent < self.lattice.n_whole))
        real = (found.corner[row] >= 0) & ~found.on_fault[found.triangles[row]]
        corners = self._corners(np.concatenate([found.parent[row[any_of(real)]], found.dropped]))
        nodes = distinct(corners)
        assert self.built.is_own is not None
        own = self.built.is_own(self.lattice.node_of_vertex[nodes])
        return bool(len(nodes)) and bool(all_of(own[np.searchsorted(nodes, corners)]).any())

    def _corners(self, rows: np.ndarray) -> np.ndarray:
        """Corners (n, 3) of triangles of the sheet, as vertices."""
        nodes = self.lattice.corners_of_keys(self.lattice.keys_of_rows(rows))
        found: np.ndarray = self.lattice.vertex_of_node[nodes]
        return found


def prover(built: Built, names: Sequence[str]) -> Callable[[TornLattice], Proof]:
    """What makes the proof of a sheet from its lattice; `names` are those of its faults."""
    return lambda lattice: Proof(built, names, lattice)


def is_proven(sheets: Iterable[Sheet]) -> bool:
    """Whether a model has looked at each of its uncut sheets, and so shown them to be closed."""
    proofs = [sheet.surface.proof for sheet in sheets]
    return all(proof is None or proof.done for proof in proofs)


__all__ = ["NotShown", "Proof", "is_proven", "prover"]
