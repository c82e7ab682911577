"""Whether a torn sheet that nobody has cut ends on its faults: seen in the model that cuts it.

`build` looks for leaks after a cut of its own. The cut of a model shows the same edges: a sheet
that is closed there is closed. Of every other one a cut of the sheet alone decides: `NotShown` has
the reason.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.model.base import all_of, any_of
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild.closed_sheets import SheetInModel
from geosurf.rebuild.wall_sides import WALL
from geosurf.sheets.mesh.build import Built
from geosurf.sheets.mesh.cut import IsOwn, walls_of_vertices
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
        Uncut.
    is_own : callable
        Which nodes are clearly on their own side of all faults.
    names : list of str
        Of the faults.
    lattice : TornLattice
        Of the sheet.
    """

    def __init__(self, built: Built, is_own: IsOwn, names: list[str], lattice: TornLattice) -> None:
        self.built, self.is_own, self.names, self.lattice = built, is_own, names, lattice
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
            name = self.names[fault]
            row = found.at_faults.get(name, np.empty(0, dtype=np.int64))
            row = distinct(found.parent[row[found.stays[row]]])
            vertex = self.lattice.node_of_vertex[self._corners(row)]
            walls = walls_of_vertices(self.built.walls, self.built.torn, vertex.ravel())
            side = walls[WALL + name].reshape(-1, 3).sum(axis=1)
            if not ((side == 3).any() and (side == -3).any()):
                return True
        return False

    def _drops_own(self, found: SheetInModel) -> bool:
        """Whether a part is dropped that has whole triangles clearly on their own side."""
        row = np.flatnonzero(~found.stays & (found.parent < self.lattice.n_whole))
        real = (found.corner[row] >= 0) & ~found.on_fault[found.triangles[row]]
        corners = self._corners(found.parent[row[any_of(real)]])
        nodes = distinct(corners)
        own = self.is_own(self.lattice.node_of_vertex[nodes])
        return bool(len(nodes)) and bool(all_of(own[np.searchsorted(nodes, corners)]).any())

    def _corners(self, rows: np.ndarray) -> np.ndarray:
        """Corners (n, 3) of triangles of the sheet, as vertices."""
        nodes = self.lattice.corners_of_keys(self.lattice.keys_of_rows(rows))
        found: np.ndarray = self.lattice.vertex_of_node[nodes]
        return found


__all__ = ["NotShown", "Proof"]
