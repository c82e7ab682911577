"""How far data are smeared over their faults: `propose_trim`.

Sheets are rebuilt without any datum near a fault, and the ignored data are compared with the sheet
of their side. Smeared data miss it by a share of the throw, towards the other wall. The error of
the rebuild moves both walls alike, and the mean over both is near 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geosurf.conventions.running import running
from geosurf.errors import GeometryError
from geosurf.kernels.lattices.sets import is_among
from geosurf.model import TrimProposal, TriSurface
from geosurf.model.surfaces import cutoffs_among
from geosurf.sheets.faults.traces import FaultMesh, mesh_in_frame
from geosurf.sheets.heights.cutoffs import drawn_by_polygons, walls_at
from geosurf.sheets.heights.passes import ignored_misfits, picks_in_gaps, single_pass, solver_of
from geosurf.sheets.heights.state import Cutoffs, Evidence, Trims, two_nearest
from geosurf.sheets.lattice.data import read_data
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.mesh.finish import fault_surfaces
from geosurf.sheets.mesh.tear_ends import tall

HIDDEN = 6  # cells from a fault within which data are ignored
WIDE = 12  # and next to faults with a polygon
WIDEST = 6.0  # cells of smear there: data farther away than the trim have to hold the sheet
SMEARED = 0.05  # share of the throw that smear has, or by which it falls to the next cell
# share that smear has somewhere, or by which it falls from one cell to the next: drag has less
RAMP, STEP = 0.12, 0.08
CLEARLY = 2.0  # standard errors by which that share is more than 0
BESIDE = 6.0  # data side by side that say the same
SURE = 0.05  # standard error up to which a share shows that there is no smear
NARROWER = 2.0  # cells by which that is less than the smear of all: one cell is chance
SHARE = 1.5  # cells of trim for each cell of smear
SPARE = 0.5  # cells more than that
LEAST = 2.0  # cells: the smallest trim that is chosen without being asked for
NO_THROW = 1e-3  # cells: what a rebuild without the data near a fault may differ without any
FEWEST = 10  # data that a wall has to have in a cell of distance


@running("trim")
def propose_trim(
    data: Any,
    faults: Mapping[str, Any] | Sequence[TriSurface],
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> TrimProposal:
    """
    Propose the trim of `tear_horizon`, from how far the data are smeared over their faults.

    Parameters
    ----------
    data, faults, name, positive, length_unit
        As for `tear_horizon`.

    Returns
    -------
    TrimProposal
        Smear and trim [cells of the grid], and the shares that they were read from. It is a
        proposal: give ``trim=`` what you choose.

    Raises
    ------
    HorizonError
        If the data cannot be used.
    GeometryError
        If too few data are near the faults.

    Notes
    -----
    Sheets are rebuilt without the data closer to a fault than six cells. Data in each cell of
    distance miss the sheet of their side, towards the other wall, by a share of the throw. The
    smear ends with the last cell whose share is 5 % of the throw, or falls by that to the next, and
    is more than two standard errors. Shares that are below 12 %, and
    fall by less than 8 % from cell to cell, are drag. A fault has a
    trim of its own if it clearly shows a wider smear, or one narrower by two cells.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=61, smear=2)
    >>> gs.propose_trim(world.horizons["Top"], world.faults).trim
    3.5
    """
    surfaces = fault_surfaces(faults)
    picks = read_data(data, name, positive, length_unit, on_lattice=True).picks
    seen = _seen(picks, surfaces)
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]
    cutoffs = by_wall(picks, meshes, cutoffs_among(surfaces, picks.name))
    shares, _ = seen.shares()
    if np.isnan(shares).any():
        raise GeometryError(
            f"horizon {picks.name!r} has {len(seen.far)} data within {HIDDEN} cells of its faults "
            "that can be predicted from the others, too few to measure the smear. Set trim to one "
            "and a half times the half width of the gridding's smear."
        )
    smear = seen.smear_of_all()
    trims = {
        fault.name: _trim(own)
        for fault, own in zip(surfaces, _smears(seen, picks, surfaces, cutoffs), strict=True)
    }
    return TrimProposal(_trim(smear), smear, tuple(shares.tolist()), trims)


def _trim(smear: float | None) -> float:
    """The trim for a smear [cells]."""
    return max(SHARE * (smear or 0.0) + SPARE, LEAST)


def trims_of(
    trim: float | str | Mapping[str, Any],
    picks: Picks,
    faults: Sequence[TriSurface],
    cutoffs: Cutoffs | None = None,
) -> Trims:
    """The trim of each fault [cells]: as given, or ``"auto"``, as the data of each show.

    Grids show how far they are smeared. A fault with too few data shows nothing: there the trim is
    that of all faults together. Points of both walls are not smeared, and get 2 cells. A fault with
    a polygon (`cutoffs`) has the trim at which data agree with it.
    """
    given = trim if isinstance(trim, Mapping) else {}
    if not isinstance(trim, Mapping | str):
        return Trims((float(trim),) * len(faults))

    # what was given stays; only "auto" needs a rebuild
    known = {name: float(value) for name, value in given.items() if value != "auto"}
    smears: list[float | None] = [None] * len(faults)
    # scattered points are not smeared, and picks of both walls at one node were not gridded
    if shows_smear(picks) and not all(fault.name in known for fault in faults):
        smears = _smears(_seen(picks, faults), picks, faults, cutoffs)
    return Trims(
        tuple(known.get(f.name, _trim(own)) for f, own in zip(faults, smears, strict=True))
    )


def shows_smear(picks: Picks) -> bool:
    """Whether data can show how far they are smeared: grids can, points of both walls cannot."""
    return picks.on_nodes and picks.several is None


@dataclass(frozen=True, eq=False)
class Seen:
    """Held-out data near faults, and how far each is from its wall towards the other one.

    Attributes
    ----------
    fault : ndarray of int64 (n,)
        The nearest one.
    side : ndarray (n,)
        Its wall: 1 hanging wall, -1 footwall.
    far : ndarray (n,)
        Distance from it [cells].
    off : ndarray (n,)
        Distance from the sheet without them [m], positive towards the other wall.
    throw : ndarray (n,)
        Throw of that sheet [m], without its sign.
    hidden : int
        Cells of distance from a fault that were held out.
    """

    fault: np.ndarray
    side: np.ndarray
    far: np.ndarray
    off: np.ndarray
    throw: np.ndarray
    hidden: int

    def of(self, fault: int) -> Seen:
        """Those next to one fault."""
        mine = self.fault == fault
        columns = ("fault", "side", "far", "off", "throw")
        return replace(self, **{name: getattr(self, name)[mine] for name in columns})

    def shares(self) -> tuple[np.ndarray, np.ndarray]:
        """Share of the throw by which data are off, and its error (hidden,), by distance; or NaN.

        The mean of both walls, of which relief moves one up and the other down. Where a horizon
        overlaps, data near the fault are of one wall only.
        """
        estimates = np.full((2, self.hidden), np.nan)
        number = self.far.astype(np.int64)
        for k in range(self.hidden):
            walls = [np.flatnonzero((number == k) & (self.side == side)) for side in (1, -1)]
            sides = [
                _share(self.off[rows], self.throw[rows]) for rows in walls if len(rows) >= FEWEST
            ]
            if sides:
                share, error = np.array(sides).T
                estimates[:, k] = share.mean(), np.hypot.reduce(error) / len(sides)
        return estimates[0], estimates[1]

    def smear(self) -> tuple[float, bool]:
        """Smear [cells], and whether the data show that it ends there."""
        # the error of a rebuild from noisy data lowers all shares, and changes little between cells
        share, error = self.shares()
        falls = share - np.append(share[1:], 0.0)
        clear = share > CLEARLY * error
        steep = clear & ((share > RAMP) | (falls > STEP))
        smeared = np.flatnonzero(clear & steep.any() & (np.maximum(share, falls) > SMEARED))
        end = int(smeared[-1]) + 1 if len(smeared) else 0
        ends = (error[end:] < SURE) & (share[end:] < SMEARED)
        return float(end), bool(ends.all() and np.isfinite(share[0]))

    def smear_of_all(self) -> float | None:
        """Smear next to all faults; None if the data do not show any, nor that there is none."""
        smear, is_sure = self.smear()
        return smear if smear or is_sure else None

    def smear_of_each(self, n_fault: int) -> list[float | None]:
        """Smear next to each fault: that of all, but for faults that clearly show another one."""
        # one gridder smears all faults alike; it goes farther where walls overlap
        common = self.smear_of_all()
        smears = []
        for fault in range(n_fault):
            own, is_sure = self.of(fault).smear()
            differs = is_sure and (common is None or own > common or own <= common - NARROWER)
            smears.append(own if differs else common)
        return smears


def _smears(
    seen: Seen, picks: Picks, faults: Sequence[TriSurface], cutoffs: Cutoffs | None
) -> list[float | None]:
    """Smear next to each fault, with more data held out at those with a polygon."""
    smears = seen.smear_of_each(len(faults))
    if cutoffs:  # a polygon holds the sheet at its fault, however far the data are
        beside = _seen(picks, faults, WIDE, cutoffs)
        for number, fault in enumerate(faults):
            own, is_sure = beside.of(number).smear()
            if fault.name in cutoffs and (is_sure or own > (smears[number] or 0.0)):
                smears[number] = min(own, WIDEST)
    return smears


def by_wall(picks: Picks, meshes: list[FaultMesh], cutoffs: Cutoffs) -> Cutoffs:
    """
    Return lines of polygons by fault, that of the hanging wall first.

    A normal fault has the lower line in its hanging wall, a reverse fault the upper one. Each line
    is of the wall that is nearer to it, without the data that may be smeared.
    """
    if not cutoffs:
        return {}
    solver = solver_of(picks, meshes, Trims((float(WIDE),) * len(meshes)), highest=3)
    _, state = single_pass(solver, float(WIDE))
    ordered = dict(cutoffs)
    for name, (first, second) in cutoffs.items():
        traces = [
            number
            for number, trace in enumerate(state.network.traces)
            if meshes[trace.fault].name == name
        ]
        off = [
            sum(
                float(np.abs(wall.off).sum())
                for number in traces
                for wall in walls_at(solver.inputs, state, number, lines)
            )
            for lines in ((first, second), (second, first))
        ]
        if off[1] < off[0]:
            ordered[name] = second, first
    return ordered


def _share(off: np.ndarray, throw: np.ndarray) -> tuple[float, float]:
    """How far data are off as share of the throw, and the standard error of that."""
    share = off.sum() / throw.sum()
    error = np.sqrt(BESIDE * ((off - share * throw) ** 2).sum()) / throw.sum()
    return float(share), float(error)


def _past_data(fault: TriSurface, picks: Picks) -> TriSurface:
    """A fault that goes on up and down past all data in its part of the map.

    So data show the same smear at a fault that is too short for its horizon, and at a longer one.
    """
    uv = mesh_in_frame(fault, picks.frame).points[:, :2] / picks.frame.stretch
    (left, front), (right, back) = uv.min(axis=0) - WIDE, uv.max(axis=0) + WIDE
    row, col = (slice(max(int(a), 0), max(int(b), 0)) for a, b in ((front, back), (left, right)))
    z = picks.means.reshape(picks.frame.shape)[row, col]
    z = z[np.isfinite(z)]
    return tall(fault, float(z.min()), float(z.max())) if len(z) else fault


def _seen(
    picks: Picks, faults: Sequence[TriSurface], hidden: int = HIDDEN, cutoffs: Cutoffs | None = None
) -> Seen:
    """Rebuild the horizon without data near its faults, and compare those with it."""
    # a trim far beyond any smear, so that the sheet is free of it
    meshes = [mesh_in_frame(_past_data(surface, picks), picks.frame) for surface in faults]
    trims = Trims((float(hidden),) * len(meshes))
    solver = solver_of(picks, meshes, trims, highest=3, cutoffs=cutoffs)
    selection, state = single_pass(solver, float(hidden))
    drawn = drawn_by_polygons(solver.inputs, state)
    if drawn is not None:
        state = solver.solve(selection, state.tears, Evidence(drawn=drawn))
    state = state.with_walls(picks.frame)
    in_gap = picks_in_gaps(solver.inputs, state)
    rows, far, _ = ignored_misfits(picks, solver.inputs.nearby, state, in_gap)

    # what two faults are near to shows the smear of neither
    fault, side, (_, second) = two_nearest(solver.inputs.nearby, len(picks.z))
    alone = (far < hidden) & (second[rows] > hidden)
    rows, far = rows[alone], far[alone]
    off = (picks.z[rows] - state.values[picks.nodes_of(rows)]) * side[rows]
    throw = np.zeros(len(rows))
    for trace, near, walls in zip(state.network.traces, state.near, state.walls, strict=True):
        if len(walls.place):
            beside = np.flatnonzero(fault[rows] == trace.fault)
            at = near.look_up(picks.nodes_of(rows[beside]))
            beside, place = beside[at >= 0], near.place[at[at >= 0]]
            torn = (place > trace.start) & (place < trace.stop)
            throw[beside[torn]] = np.interp(place[torn], walls.place, walls.throw)
    # blocks without data of their own, and faults without throw, show no smear
    number, size = np.bincount(fault[rows], minlength=len(faults)), NO_THROW * picks.frame.cell
    mean = np.bincount(fault[rows], abs(throw), len(faults)) / np.maximum(number, 1)
    shows = (throw != 0.0) & (mean[fault[rows]] > size)
    shows &= ~is_among(picks.nodes_of(rows), state.stray)
    rows, far, off, throw = (of[shows] for of in (rows, far, off, throw))
    return Seen(fault[rows], side[rows], far, off * np.sign(throw), np.abs(throw), hidden)
