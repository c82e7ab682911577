"""A horizon torn at its faults."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.conventions.card import Card, small_map
from geosurf.conventions.colours import fault as fault_colour
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model.base import Shown
from geosurf.model.lattice import Lattice
from geosurf.model.sectors import Sector
from geosurf.model.sheet_report import FaultCut, SheetReport, ThrowReport
from geosurf.model.surfaces import TriSurface, torn_sheet
from geosurf.model.tear_plan import TearPlan
from geosurf.model.torn_lattice import TornLattice


@dataclass(frozen=True, eq=False)
class Sheet(Shown):
    """A horizon that is torn at its faults: one sheet per wall.

    Attributes
    ----------
    name : str
    lattice : Lattice
        Nodes with their rebuilt elevations.
    divided : ndarray of int64
        Lattice triangles that faults divide: twice the node at their cell's first corner, plus 1
        for the second of the cell.
    copies : ndarray of int64 (n, 3)
        Triangles that stand for them and reach past the faults: nodes of the lattice, row by row,
        then ghosts.
    ghosts : ndarray of float64 (n_ghost, 3)
        Vertices without data: each sheet continued beyond the fault.
    outer : ndarray of bool (n_ghost,)
        The outermost ghosts, which lie beyond the faults.
    faults : tuple of TriSurface
        The faults that tear it. A model needs all of them.
    cuts : dict of str to FaultCut
        By fault.
    report : SheetReport or ThrowReport
    crs : str or None
        Coordinate reference system of the data, if they declare one.
    extrapolated : ndarray of bool (n_row, n_col) or None
        Nodes of the lattice that `extend_horizon` gave the data, and blocks in which the horizon
        is pinched out.
    mesh : TriSurface or None
        The torn mesh, where parts of it are those of another horizon.
    plan : TearPlan or None
        What closed it, where `tear_horizon` made it: an ensemble tears moved data with it first.
    walls : dict of str to ndarray of int8 (n_node + n_ghost,), or None
        By fault, if throw moved the horizon: the wall of each node and ghost, 1 hanging wall, -1
        footwall.
    sectors : tuple of Sector
        Wedges between faults that cross so close to the horizon that one may be without it.
    fewer_nodes : bool
        Whether a tolerance had left out nodes of its data. What that changes near faults has no
        bound.
    """

    name: str
    lattice: Lattice
    divided: np.ndarray
    copies: np.ndarray
    ghosts: np.ndarray
    outer: np.ndarray
    faults: tuple[TriSurface, ...]
    cuts: Mapping[str, FaultCut]
    report: SheetReport | ThrowReport
    crs: str | None = None
    extrapolated: np.ndarray | None = None
    mesh: TriSurface | None = None
    plan: TearPlan | None = None
    walls: Mapping[str, np.ndarray] | None = None
    sectors: tuple[Sector, ...] = ()
    fewer_nodes: bool = False

    @property
    def warnings(self) -> tuple[GeosurfWarning, ...]:
        """What data show that the sheet has not: those of its report."""
        return self.report.warnings

    @cached_property
    def surface(self) -> TriSurface:
        """The torn mesh, role "horizon", continued beyond its faults.

        ``vertex_data["ghost"]`` marks vertices without data, ``["outer"]`` those beyond faults:
        `rebuild_surfaces` with all faults, then `trim_sheets`, leaves the sheet itself.
        ``["node"]`` numbers the node of the lattice, row by row, that each vertex lies over.
        """
        if self.mesh is not None:
            return self.mesh
        # keys count cells and their halves, `divided` counts nodes: one more in each row
        lattice, n_col = self.lattice, self.lattice.shape[1]
        row, col = np.divmod(self.divided // 2, n_col)
        gone = np.sort(2 * (row * (n_col - 1) + col) + self.divided % 2)

        # triangles that faults divide are replaced by copies on both sides, which end in ghosts;
        # nodes first, then ghosts: rows of vertices stay those of the lattice
        torn = TornLattice.of(lattice, gone, self.copies, self.ghosts)
        present = lattice.present
        n = torn.n_present - len(self.ghosts)
        marks = {
            "ghost": np.repeat([False, True], [n, len(self.ghosts)]),
            "outer": np.concatenate([np.zeros(n, dtype=bool), self.outer]),
        }
        if torn.node_of_ghost is not None:
            marks["node"] = np.concatenate([np.flatnonzero(present), torn.node_of_ghost])

        # ghosts are never extrapolated data: they are not data
        if self.extrapolated is not None:
            no_ghost = np.zeros(len(self.ghosts), dtype=bool)
            marks["extrapolated"] = np.concatenate([self.extrapolated[present], no_ghost])
        # walls of what throw moved: a part that lies in another wedge is dropped by these
        n_node = lattice.n_node
        for fault, wall in (self.walls or {}).items():
            marks["wall of " + fault] = np.concatenate(
                [wall[:n_node][present.ravel()], wall[n_node:]]
            )
        made = torn_sheet(self.name, torn, marks)
        made.crs, made.sectors = self.crs, self.sectors
        return made

    def surface_among(self, others: Callable[[str], TriSurface | None] | None) -> TriSurface:
        """Return `surface`, if these are the very faults that tear the sheet.

        Parameters
        ----------
        others : callable
            Gives the surface of a name; None if there is none.

        Returns
        -------
        TriSurface

        Raises
        ------
        InputError
            If a fault is missing or another surface: the sheet would not end on it.
        """
        # the very same arrays: a sheet fits the fault that cut it, to the last digit, and no other
        # Every fault of the sheet has to be in the scene, as it was when the horizon was torn.
        for fault in self.faults:
            given = None if others is None else others(fault.name)
            if given is None:
                verb, more = "is not in the scene", ""
            elif np.array_equal(given.vertices, fault.vertices) and np.array_equal(
                given.triangles, fault.triangles
            ):
                continue
            else:
                verb = "is another surface here"
                more = (
                    f" If the scene extends or truncates {fault.name!r}, tear the horizon at "
                    f"scene.surface({fault.name!r}) of a scene with the same box=."
                )
            raise InputError(
                f"horizon {self.name!r} is torn at fault {fault.name!r}, which {verb}. Pass "
                "the faults of the sheet to the scene, unchanged: {f.name: f for f in "
                f"sheet.faults}}.{more}"
            )
        return self.surface

    @property
    def ghost(self) -> np.ndarray:
        """Mask of the vertices of `surface` without data."""
        # Ghosts are vertices that only continue a wall beyond its fault.
        mask: np.ndarray = self.surface.vertex_data["ghost"]
        return mask

    def _card(self) -> Card:
        """Return a small map, the throw at each fault, and the report."""
        rows = []
        for name, cut in self.cuts.items():
            throw = np.abs(cut.throw[np.isfinite(cut.throw)])
            most = f"{throw.max():.1f} m" if len(throw) else "none"
            rows.append((name, str(len(cut.stations)), most))
        title = f"Sheet {self.name}: {self.lattice.shape[0]} x {self.lattice.shape[1]} nodes"
        notes = repr(self.report).splitlines()
        head = ("fault", "cut-off points", "largest throw")
        colours = [fault_colour(number) for number in range(len(rows))]
        return Card(title, rows, head, colours, notes, picture=self._map())

    def _map(self) -> str:
        """Return a small map of the grid and the cut-offs."""
        x, y = self.lattice.horizontal()
        corners = np.array([(x[i, j], y[i, j]) for i, j in ((0, 0), (0, -1), (-1, -1), (-1, 0))])
        cutoffs = {
            name: [line[:, :2] for lines in cut.cutoffs.values() for line in lines]
            for name, cut in self.cuts.items()
        }
        return small_map(corners, cutoffs)

    def __repr__(self) -> str:
        return (
            f"<Sheet {self.name!r}: {self.lattice.shape[0]} x {self.lattice.shape[1]} nodes, torn "
            f"by {', '.join(self.cuts) or 'nothing'}>"
        )
