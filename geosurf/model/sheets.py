"""A horizon torn at its faults."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.conventions import place
from geosurf.conventions.card import Card, small_map
from geosurf.conventions.palette import fault as fault_colour
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model.base import Noun, Shown, frozen
from geosurf.model.lattice import Lattice
from geosurf.model.surfaces import Sector, TriSurface, torn_sheet
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


@dataclass(frozen=True, eq=False)
class DataUse:
    """
    What a sheet made of its data.

    Attributes
    ----------
    ignored : ndarray of bool (n_data,)
        Data that were not used.
    wrong : ndarray of bool (n_data,)
        Data among these that are on a wrong side, in the map or at their own height.
    near : tuple of ndarray of int64
        By fault: the data near it, increasing.
    side : tuple of ndarray of int8
        By fault: the side of each of these, 1 in the hanging wall and -1 in the footwall.
    elevation : ndarray of float64 (n_data,)
        Of the data [m].
    """

    ignored: np.ndarray
    wrong: np.ndarray
    near: tuple[np.ndarray, ...]
    side: tuple[np.ndarray, ...]
    elevation: np.ndarray

    def joined(self, other: DataUse) -> DataUse:
        """
        Return what is ignored in this or the other use; data on another side there are wrong.

        Examples
        --------
        >>> none, near = np.zeros(5, dtype=bool), (np.array([1, 3]),)
        >>> z, sides = np.zeros(5), ([1, 1], [1, -1])
        >>> one, two = (DataUse(none, none, near, (np.array(side),), z) for side in sides)
        >>> one.joined(two).wrong.tolist(), one.joined(two).near[0].tolist()
        ([False, False, False, True, False], [1])
        """
        wrong = self.wrong | other.wrong
        near, side = [], []
        for parts in zip(self.near, self.side, other.near, other.side, strict=True):
            both = np.zeros((2, len(wrong)), dtype=np.int8)
            both[0, parts[0]], both[1, parts[2]] = parts[1], parts[3]
            wrong |= both[0] * both[1] < 0
            sides = np.where(both[0] * both[1] < 0, 0, np.where(both[0] != 0, both[0], both[1]))
            near.append(np.flatnonzero(sides))
            side.append(sides[near[-1]])
        ignored = self.ignored | other.ignored
        return DataUse(ignored, wrong, tuple(near), tuple(side), self.elevation)

    def flipped(self, fault: int, near: np.ndarray, side: np.ndarray) -> np.ndarray:
        """
        Return which data near a fault are on its other side now.

        Parameters
        ----------
        fault : int
        near, side : ndarray
            As of the class, of data that have moved.

        Examples
        --------
        >>> none = np.zeros(5, dtype=bool)
        >>> use = DataUse(none, none, (np.array([1, 3]),), (np.array([1, -1]),), np.zeros(5))
        >>> use.flipped(0, np.array([0, 1, 3]), np.array([1, 1, 1])).tolist()
        [3]
        """
        rows, before = self.near[fault], self.side[fault]
        if not len(rows):
            return near[:0]
        at = np.minimum(np.searchsorted(rows, near), len(rows) - 1)
        found: np.ndarray = near[(rows[at] == near) & (before[at] != side)]
        return found


@dataclass(frozen=True, eq=False)
class BaseHeights:
    """
    Heights of a sheet next to its faults, from which traces of slightly other data are drawn.

    Attributes
    ----------
    nodes : ndarray of int64 (n,)
        Nodes that were solved for, increasing.
    off_data : ndarray (n,)
        How far each lies above the mean of its data [m]; NaN without data.
    bridged : ndarray of int64
        Nodes between both walls of a fault.
    walls : tuple of ndarray (4, n)
        By trace: share of its length, distance of the left and the right cut-off [cells], throw
        [m].
    smear : ndarray (n,) or None
        Spread of the errors of ignored data, by distance from a fault [m].
    apart : tuple of int
        Traces whose walls were rebuilt without each other.
    drawn : ndarray of int64 (3, n)
        Nodes that fault polygons draw, and their walls: trace, and 1 or -1.
    """

    nodes: np.ndarray
    off_data: np.ndarray
    bridged: np.ndarray
    walls: tuple[np.ndarray, ...]
    smear: np.ndarray | None
    apart: tuple[int, ...]
    drawn: np.ndarray


@dataclass(frozen=True, eq=False)
class TearPlan:
    """
    The trims and remedies of a sheet, for another sheet of the same lattice and faults.

    Attributes
    ----------
    shape : tuple of int
        Rows and columns of the lattice.
    trims, given_trims : tuple of float
        By fault, in use and as they were at first [cells].
    use : DataUse
    order : int
        Of the differences that are small in the surface.
    traces : tuple of (int, str, str)
        Fault of each trace, and how it ends.
    early : tuple of (int, int, int)
        A trace, 0 for its first or 1 for its last end, and by how many links its tear ends early.
    rings : tuple of tuples of (int, int)
        For each further ring of ghosts the pairs of nodes at whose edges it is.
    level : tuple of (float, float)
        Places around which the sheet goes on level past its fault [cells].
    left_out : tuple of (int, float, float)
        Parts of traces that tear nothing: trace, first and last place along it [cells].
    loss : float
        Throw that is lost there [m times cells].
    searched : bool
        Whether remedies were searched for; False if a given plan closed the sheet.
    base : BaseHeights or None
        None for scattered points, and where blocks without data were filled.
    extensions : tuple of Extended
        By how much its faults became longer.
    polygons : tuple of str
        Faults whose polygons it meets.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=41)
    >>> plan = gs.tear_horizon(world.horizons["Top"], world.faults).plan
    >>> plan.traces, plan.left_out, plan.searched
    (((0, 'tip', 'tip'),), (), True)
    """

    shape: tuple[int, ...]
    trims: tuple[float, ...]
    given_trims: tuple[float, ...]
    use: DataUse
    order: int
    traces: tuple[tuple[int, str, str], ...]
    early: tuple[tuple[int, int, int], ...] = ()
    rings: tuple[tuple[tuple[int, int], ...], ...] = ()
    level: tuple[tuple[float, float], ...] = ()
    left_out: tuple[tuple[int, float, float], ...] = ()
    loss: float = 0.0
    searched: bool = True
    base: BaseHeights | None = None
    extensions: tuple[Extended, ...] = ()
    polygons: tuple[str, ...] = ()

    def with_repairs_of(self, other: TearPlan) -> TearPlan:
        """The same plan with what closed a sheet that was made by it; itself if it closed none."""
        if other.searched:
            return self
        repairs = {key: getattr(other, key) for key in ("early", "rings", "level", "left_out")}
        return replace(self, **repairs, searched=False)


@dataclass(frozen=True, eq=False)
class FaultCut(Noun):
    """Where one fault cuts a sheet.

    Attributes
    ----------
    fault : str
    cutoffs : dict of str to tuple of ndarray (n, 3)
        Lines of the hanging wall ``"+"`` (the side that the fault's normal points into) and of the
        footwall ``"-"``: easting, northing, elevation [m]. Their points lie on the fault.
    stations : ndarray (n, 3)
        Points of the mid trace, about one per cell [m].
    along : ndarray (n,)
        Distance along the trace [m].
    throw, heave : ndarray (n,)
        [m]: throw positive where the hanging wall is down, heave positive where there is a gap; NaN
        where a wall has no cut-off. Of `tear_horizon` both are read straight across, in the map,
        in the dip direction that the fault has at the station; of `throw_horizon` along its lines
        down the dip, as `Scene.throw` reads them. On a plane that is the same.
    ends : tuple of str
        How each trace ends: ``"tip"``, ``"rim"`` (leaves the data), ``"branch of F1"``.
    """

    fault: str
    cutoffs: dict[str, tuple[np.ndarray, ...]]
    stations: np.ndarray
    along: np.ndarray
    throw: np.ndarray
    heave: np.ndarray
    ends: tuple[str, ...]

    def __post_init__(self) -> None:
        # Frozen dataclass: arrays become read-only as they are taken over.
        for key in ("stations", "along", "throw", "heave"):
            object.__setattr__(self, key, frozen(getattr(self, key), np.float64))
        lines = {
            wall: tuple(frozen(line, np.float64) for line in of)
            for wall, of in self.cutoffs.items()
        }
        object.__setattr__(self, "cutoffs", lines)

    def __repr__(self) -> str:
        # Stations where a wall has no cut-off have no throw.
        known = self.throw[np.isfinite(self.throw)]
        throw = f"throw {known.min():.4g} to {known.max():.4g} m" if len(known) else "no throw"
        ends = f", ends: {', '.join(self.ends)}" if self.ends else ""
        return f"<FaultCut {self.fault!r}: {len(self.along)} stations, {throw}{ends}>"


# kinds of warnings about what closed a sheet where its faults alone did not
REMEDIES = (
    "fault extended",
    "tear ended early",
    "tear left out",
    "trim changed",
    "wall made level",
)


def _grouped(number: int) -> str:
    """A whole number with spaces between its thousands."""
    return f"{number:,}".replace(",", " ")


SPREADS = 2.0  # by which a sheet may differ from its data
OF_THROW, METRES = 0.1, 1.0  # but at least this share of the largest throw, and this
IN_A_ROW = 5  # stations that a difference goes on for: a few may be chance


@dataclass(frozen=True, eq=False)
class ThrowAudit(Noun):
    """Throw along one fault: of the sheet, and as the data on both sides show without it.

    Attributes
    ----------
    stations : ndarray (n, 3)
        As in `FaultCut`, about one per cell [m].
    along : ndarray (n,)
        Distance along the trace [m].
    sheet : ndarray (n,)
        Throw between the cut-offs [m], positive where the hanging wall is down.
    data : ndarray (n,)
        Throw between trends of the data beyond `trim` on both sides, continued to the fault [m];
        NaN where there are too few, or another fault is near.
    spread : ndarray (n,)
        How far straight and curved, short and long trends differ, and three standard errors [m].
    trim : float
        Cells from the fault from which on data count: beyond their smear.

    Examples
    --------
    >>> import numpy as np, geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=61, smear=2)
    >>> audit = gs.tear_horizon(world.horizons["Top"], world.faults).report.throw["F1"]
    >>> bool(np.nanmedian(np.abs(audit.sheet - audit.data)) < 2.0), int(audit.differs.sum())
    (True, 0)
    """

    stations: np.ndarray
    along: np.ndarray
    sheet: np.ndarray
    data: np.ndarray
    spread: np.ndarray
    trim: float

    @property
    def differs(self) -> np.ndarray:
        """Stations, bool (n,), where the sheet differs from its data by more than their spread.

        By twice the spread, a tenth of the largest throw, and 1 m, at five stations in a row.
        """
        from scipy.ndimage import binary_opening  # loaded by those who tear

        largest = np.abs(np.concatenate([self.sheet, self.data]))
        least = max(OF_THROW * largest[np.isfinite(largest)].max(initial=0.0), METRES)
        off = np.abs(self.sheet - self.data) > np.maximum(SPREADS * self.spread, least)
        found: np.ndarray = binary_opening(off, np.ones(IN_A_ROW))
        return found

    @property
    def worst(self) -> int | None:
        """The station of those that differ where this is clearest; None if none does."""
        rows = np.flatnonzero(self.differs)
        if not len(rows):
            return None
        spreads = np.abs(self.sheet - self.data)[rows] / self.spread[rows]
        return int(rows[spreads.argmax()])


@dataclass(frozen=True, repr=False)
class SheetReport:
    """How a sheet was made, in numbers; lengths in metres, except where cells are named.

    Attributes
    ----------
    trim : float
        Data closer to a fault than this were ignored [cells of the grid]: the widest of `trims`.
    trims : dict of str to float
        The same by fault.
    cell : float
        One cell [m].
    n_data, n_ignored, n_solved : int
        Data in total, data that were ignored near faults, nodes that were interpolated.
    misfit : dict of str to float
        Misfit of the surface at the data in use: ``mean``, ``median``, ``p95``, ``max`` [m].
    holdout_misfit : dict of str to float
        The same at the ignored data, which test the surface: each against the wall that it is on.
    extrapolation : list of dict
        Places farthest from data of their own side: ``cells``, ``place`` (3,), ``fault``.
    throw : dict of str to ThrowAudit
        By fault, its throw and what the data beside it show; none in realisations of an ensemble,
        whose data are drawn.
    sign_changes : dict of str to int
        By fault, changes of the sign of throw beyond 5 % of the largest: nearly always a
        trim that is too small.
    tips, declared_tips : int
        Tips of the mesh, and free ends of the faults: they should agree.
    shortened : dict of str to int
        Links by which tears end earlier than their faults, by fault.
    noise : float or None
        Standard deviation of the noise that data were taken to have [m].
    filled_blocks : list of dict
        Blocks without data that were filled from a neighbouring block: ``nodes``, ``over`` (the
        fault between the two), ``place`` (2,).
    left_out : list of dict
        Picks on the wrong side of a fault: ``row`` of the data, ``fault``, ``place`` (3,), ``off``
        (metres above the plane of their neighbours).
    notes : list of str
        Sentences for the user.
    warnings : tuple of GeosurfWarning
        What closed the sheet where its faults alone did not (kinds in `REMEDIES`), and throw that
        the data show and the sheet does not have, along a fault or where it ends.
    """

    trim: float = 0.0
    trims: dict[str, float] = field(default_factory=dict)
    cell: float = 0.0
    n_data: int = 0
    n_ignored: int = 0
    n_solved: int = 0
    misfit: dict[str, float] = field(default_factory=dict)
    holdout_misfit: dict[str, float] = field(default_factory=dict)
    extrapolation: list[dict[str, Any]] = field(default_factory=list)
    throw: dict[str, ThrowAudit] = field(default_factory=dict)
    sign_changes: dict[str, int] = field(default_factory=dict)
    tips: int = 0
    declared_tips: int = 0
    shortened: dict[str, int] = field(default_factory=dict)
    noise: float | None = None
    filled_blocks: list[dict[str, Any]] = field(default_factory=list)
    left_out: list[dict[str, Any]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    warnings: tuple[GeosurfWarning, ...] = ()

    @property
    def remedies(self) -> tuple[GeosurfWarning, ...]:
        """Those of ``warnings`` that closed the sheet; none if its faults alone did."""
        return tuple(warning for warning in self.warnings if warning.kind in REMEDIES)

    def _trims(self) -> str:
        """The trim of all faults, or of each."""
        # Mostly one trim for all faults; each by name only where they differ.
        if len(set(self.trims.values())) < 2:
            return f"{self.trim:g}"
        return ", ".join(f"{trim:g} ({name})" for name, trim in self.trims.items())

    def __repr__(self) -> str:
        def figures(values: dict[str, float]) -> str:
            """Figures of a misfit in one line."""
            return ", ".join(f"{key} {value:.3g}" for key, value in values.items()) or "none"

        # Throw that changes its sign along a fault is nearly always an artefact of the trim.
        changes = sum(self.sign_changes.values())
        lines = [
            f"trim {self._trims()} cells of {self.cell:.6g} m",
            f"{_grouped(self.n_ignored)} of {_grouped(self.n_data)} data ignored near faults",
            f"{_grouped(self.n_solved)} nodes interpolated",
            f"misfit at the data in use [m]: {figures(self.misfit)}",
            f"misfit at the ignored data [m]: {figures(self.holdout_misfit)}",
            f"tips: {self.tips} in the mesh, {self.declared_tips} in the faults",
            f"changes of the sign of throw: {changes}",
        ]
        # The worst places only; the report of the scene lists all.
        lines += [
            f"extrapolated over {e['cells']:g} cells next to fault {e['fault']!r} at "
            f"({e['place'][0]:.0f}, {e['place'][1]:.0f}, {e['place'][2]:.0f})"
            for e in self.extrapolation[:3]
        ]
        lines += [
            f"{_grouped(c['nodes'])} nodes without data filled across fault {c['over']!r} at "
            f"({c['place'][0]:.0f}, {c['place'][1]:.0f})"
            for c in self.filled_blocks[:3]
        ]
        return "\n".join([*lines, *self.notes])


@dataclass(frozen=True, repr=False)
class TrimProposal:
    """How far data are smeared across their faults, and the trim that follows.

    Attributes
    ----------
    trim : float
        The proposal for ``tear_horizon(trim=)`` [cells of the grid].
    smear : float or None
        Half width of the smear [cells]. 0 if there is none; None if it cannot be determined,
        because data near the faults are too few or too noisy.
    shares : tuple of float
        Mean distance of ignored data from the sheet of their side, towards the other wall, as
        share of the throw, by distance from the fault: below one cell, one to two, and so on.
    of_fault : dict of str to float
        The proposal for each fault [cells]: `trim`, but where it clearly shows another smear.
    """

    trim: float
    smear: float | None
    shares: tuple[float, ...]
    of_fault: dict[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        # Bins of one cell each, from the fault outwards.
        bins = ", ".join(f"{value:.0%}" for value in self.shares)
        # The reason is part of the proposal: without a smear a small trim is enough.
        why = "the width of the smear cannot be determined"
        if self.smear is not None:
            why = f"data are smeared over {self.smear:g} cells"
        return (
            f"proposed trim: {self.trim:g} cells ({why})\n"
            f"share of the throw by which data miss their wall, by cells from a fault: {bins}"
            + "".join(f"\n{name}: {trim:g} cells" for name, trim in self.of_fault.items())
        )


@dataclass(frozen=True)
class LostThrow:
    """Throw that cells are too coarse for, next to the tip of a fault.

    Attributes
    ----------
    fault : str
    place : (easting, northing, elevation)
        Where most is lost [m].
    requested, measured : float
        Throw there, as given and as read between the cut-offs [m].
    cell : float
        Cell of the horizon [m].
    suggested_cell : float
        Cell on which 2 % of the largest throw would be lost [m].
    """

    fault: str
    place: tuple[float, float, float]
    requested: float
    measured: float
    cell: float
    suggested_cell: float

    def __str__(self) -> str:
        return (
            f"Fault {self.fault!r} has {self.measured:.3g} m of the requested {self.requested:.3g} "
            f"m of throw next to its tip at {place(self.place)}: cells of {self.cell:.3g} m are "
            f"too coarse there. On cells of {self.suggested_cell:.2g} m or less, at most 2 % of "
            "the largest throw is lost."
        )


@dataclass(frozen=True, repr=False)
class ThrowReport:
    """How a sheet was made from a continuous horizon and throw.

    Attributes
    ----------
    throw : dict of str to dict
        By fault, the largest throw that was ``requested`` at the elevations of the horizon, and the
        largest that was ``measured`` between the cut-offs [m]. Throws of branches add to it.
    branches : dict of str to tuple of str
        Faults that end on others, which act on one side of those only.
    tips, declared_tips : int
        As in `SheetReport`.
    shortened : dict of str to int
        Links by which tears end earlier than their faults, by fault; throw is lost there.
    lost : tuple of LostThrow
        Tips next to which more than 2 % of the largest throw of a fault are missing.
    n_outside : int
        Nodes whose rock was outside of the data before it moved: the horizon is extrapolated there.
    farthest_outside : float
        How far, at most [m].
    attempts : int
        Meshes that were cut with the faults until one was closed; 0 where no fault tears.
    notes : list of str
        Sentences for the user.
    warnings : tuple of GeosurfWarning
    """

    throw: dict[str, dict[str, float]] = field(default_factory=dict)
    branches: dict[str, tuple[str, ...]] = field(default_factory=dict)
    tips: int = 0
    declared_tips: int = 0
    shortened: dict[str, int] = field(default_factory=dict)
    lost: tuple[LostThrow, ...] = ()
    n_outside: int = 0
    farthest_outside: float = 0.0
    attempts: int = 0
    notes: list[str] = field(default_factory=list)
    warnings: tuple[GeosurfWarning, ...] = ()

    def __repr__(self) -> str:
        lines = [
            f"throw of {name!r}: up to {of['requested']:.6g} m requested, "
            f"{of['measured']:.6g} m measured"
            for name, of in self.throw.items()
        ]
        lines += [
            f"{name!r} ends on {', '.join(map(repr, mains))}"
            for name, mains in self.branches.items()
        ]
        lines.append(f"tips: {self.tips} in the mesh, {self.declared_tips} in the faults")
        if self.n_outside:
            lines.append(
                f"{_grouped(self.n_outside)} nodes came from up to {self.farthest_outside:.3g} m "
                "outside of the data"
            )
        lines += [
            f"the tear of {name!r} ends {n} lattice links before the fault does"
            for name, n in self.shortened.items()
        ]
        return "\n".join([*lines, *self.notes])


@dataclass(frozen=True)
class Extended:
    """A fault that was extended because a sheet leaves it above or below.

    Attributes
    ----------
    fault : str
    lengths : dict of {"up", "down", "start", "end"} to float
        Along its dip or strike [m].
    place : ndarray (3,)
        Where the sheet left it [m].
    """

    fault: str
    lengths: Mapping[str, float]
    place: np.ndarray
