"""How far data are smeared over their faults: `propose_trim`.

Sheets are rebuilt without any datum near a fault, and the ignored data are compared with the sheet
of their side. Smeared data miss it by a share of the throw; data farther away miss it only by the
error of the rebuild. So the misfit drops at the end of the smear.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions.running import running
from geosurf.errors import GeometryError
from geosurf.model import TrimProposal, TriSurface
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.passes import ignored_misfits, picks_in_gaps, single_pass, solver_of
from geosurf.sheets.heights.state import Trims
from geosurf.sheets.lattice.data import picks_of
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.mesh.finish import fault_surfaces

HIDDEN = 6  # cells from a fault within which data are ignored
DROP = 2.0  # a misfit this many times that of the next cell may be smear
OF_MOST = 0.2  # share of the largest misfit below which one is the error of the rebuild
OF_THROW = 0.05  # share of the largest throw below which a misfit is not counted as smear
SHARE = 1.5  # cells of trim for each cell of smear
SPARE = 0.5  # cells more than that
LEAST, WIDEST = 1.5, 4.0  # cells: trims of one fault that are chosen without being asked for
USUAL = 2.0  # cells of trim where smear cannot be determined
SEVERAL = 3  # faults that show together how wide trims have to be
FEWEST = 20  # data that a bin has to have


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
        Smear and trim [cells of the grid], and the misfits that they were read from. It is a
        proposal: give ``trim=`` what you choose.

    Raises
    ------
    HorizonError
        If the data cannot be used.
    GeometryError
        If too few data are near the faults.

    Notes
    -----
    Sheets are rebuilt without the data closer to a fault than six cells. The smear
    ends with the last cell whose misfit (90th percentile) is twice that of the next one, a
    twentieth of the largest throw, and a fifth of the largest misfit. A fault that shows no such
    cell has the trim of all faults together.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=61, smear=2)
    >>> gs.propose_trim(world.horizons["Top"], world.faults).trim
    3.5
    """
    surfaces = fault_surfaces(faults)
    picks = picks_of(data, name, positive, length_unit)
    seen = _seen(picks, surfaces)
    if (seen.counts < FEWEST).any():
        raise GeometryError(
            f"horizon {picks.name!r} has {int(seen.counts.sum())} data within {HIDDEN} cells of "
            "its faults that can be predicted from the others, too few to measure the smear. Set "
            "trim to one and a half times the half width of the gridding's smear."
        )
    trim, smear = seen.trim()
    return TrimProposal(trim, smear, tuple(seen.tenths()), _by_fault(seen, surfaces, trim))


def trims_of(
    trim: float | str | Mapping[str, Any], picks: Picks, faults: Sequence[TriSurface]
) -> Trims:
    """The trim of each fault [cells]: as given, or ``"auto"``, as the data of each show.

    Grids show how far they are smeared. A fault with too few data shows nothing: there the trim is
    that of all faults together. Points of both walls are not smeared, and get 2 cells.
    """
    given = trim if isinstance(trim, Mapping) else {}
    if not isinstance(trim, Mapping | str):
        return Trims((float(trim),) * len(faults))

    # what was given stays; only "auto" needs a rebuild
    known = {name: value for name, value in given.items() if value != "auto"}
    if all(fault.name in known for fault in faults) and faults:
        return Trims(tuple(float(known[fault.name]) for fault in faults))
    proposed, widest = dict.fromkeys((fault.name for fault in faults), USUAL), WIDEST
    # scattered points are not smeared, and picks of both walls at one node were not gridded
    if shows_smear(picks) and faults:
        seen = _seen(picks, faults)
        usual = USUAL
        if (seen.counts >= FEWEST).all():
            usual, _ = seen.trim()
        proposed = _by_fault(seen, faults, usual)
        # one gridder smears all faults alike: what one alone shows may be another one beside it
        several = len(faults) >= SEVERAL
        widest = max(WIDEST, float(np.median(list(proposed.values()))) if several else usual)
    return Trims(
        tuple(
            float(known.get(name, min(max(value, LEAST), widest)))
            for name, value in proposed.items()
        )
    )


def trims_alike(picks: Picks, faults: Sequence[TriSurface]) -> Trims | None:
    """One trim for all faults: the median of those that show more smear than a cell; or None.

    One gridder smears all faults alike, but a fault with little throw does not show it.
    """
    if not (shows_smear(picks) and faults):
        return None
    seen = _seen(picks, faults)
    proposed = _by_fault(seen, faults, usual=LEAST).values()
    smeared = [trim for trim in proposed if trim > USUAL]
    return Trims((float(np.median(smeared)),) * len(faults)) if smeared else None


def shows_smear(picks: Picks) -> bool:
    """Whether data can show how far they are smeared: grids can, points of both walls cannot."""
    return picks.on_nodes and picks.several is None


@dataclass(frozen=True, eq=False)
class Seen:
    """Misfits of held-out data near faults.

    Attributes
    ----------
    fault : ndarray of int64 (n,)
        The nearest one.
    far : ndarray (n,)
        Distance from it [cells].
    misfit : ndarray (n,)
        From a sheet without them [m].
    least : ndarray (n_fault,)
        Misfits up to this are not counted as smear, next to each fault [m].
    """

    fault: np.ndarray
    far: np.ndarray
    misfit: np.ndarray
    least: np.ndarray

    @property
    def counts(self) -> np.ndarray:
        """How many data each bin of a cell has."""
        return np.bincount(self.far.astype(np.int64), minlength=HIDDEN)[:HIDDEN]

    def tenths(self) -> list[float]:
        """90th percentile of the misfit in each bin."""
        number = self.far.astype(np.int64)
        return [float(np.percentile(self.misfit[number == k], 90)) for k in range(HIDDEN)]

    def of(self, fault: int) -> Seen:
        """Those next to one fault."""
        mine = self.fault == fault
        return Seen(self.fault[mine], self.far[mine], self.misfit[mine], self.least[[fault]])

    def trim(self) -> tuple[float, float | None]:
        """Trim and smear [cells] from the misfit in each cell of distance."""
        tenth, least = self.tenths(), float(self.least.max())
        most = max(tenth)
        # smear ends where the misfit drops by DROP to the next cell; the farthest such drop counts
        smeared = [
            k + 1
            for k in range(HIDDEN - 1)
            if tenth[k] > max(DROP * tenth[k + 1], least, OF_MOST * most)
        ]
        if smeared:
            return SHARE * smeared[-1] + SPARE, float(smeared[-1])
        if tenth[0] > least:  # missed at all distances: by the error of the sheets, or by noise
            return USUAL, None
        return 1.0, 0.0


def _seen(picks: Picks, faults: Sequence[TriSurface]) -> Seen:
    """Rebuild the horizon without data near its faults, and compare those with it."""
    # a trim far beyond any smear, so that the sheet is free of it
    meshes = [mesh_in_frame(surface, picks.frame) for surface in faults]
    solver = solver_of(picks, meshes, Trims((float(HIDDEN),) * len(meshes)), highest=3)
    _, state = single_pass(solver, float(HIDDEN))
    state = state.with_walls(picks.frame)
    in_gap = picks_in_gaps(solver.inputs, state)
    rows, far, misfit = ignored_misfits(picks, solver.inputs.nearby, state, in_gap)

    # the fault that each is nearest to
    nearest, of = np.full(len(picks.z), np.inf), np.full(len(picks.z), -1)
    for number, near in enumerate(solver.inputs.nearby):
        closer = near.far < nearest[near.rows]
        nearest[near.rows[closer]] = near.far[closer]
        of[near.rows[closer]] = number
    close = far < HIDDEN
    throws = np.zeros(len(faults))
    for trace, walls in zip(state.network.traces, state.walls, strict=True):
        throws[trace.fault] = np.abs(walls.throw).max(initial=throws[trace.fault])
    return Seen(of[rows[close]], far[close], misfit[close], OF_THROW * throws)


def _by_fault(seen: Seen, faults: Sequence[TriSurface], usual: float) -> dict[str, float]:
    """The trim of each fault; `usual` where too few data are near it, or do not show it."""
    found = {}
    for number, fault in enumerate(faults):
        own = seen.of(number)
        trim, smear = own.trim() if (own.counts >= FEWEST).all() else (usual, None)
        found[fault.name] = usual if smear is None else trim
    return found
