"""How far data are smeared over their faults: `propose_trim`.

Sheets are rebuilt without any datum near a fault, and the ignored data are compared with the sheet
of their side. Smeared data miss it by a share of the throw; data farther away miss it only by the
error of the rebuild. So the misfit drops at the end of the smear.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geosurf.errors import GeometryError
from geosurf.model import TrimProposal, TriSurface
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.evidence import ignored_misfits, picks_in_gaps
from geosurf.sheets.heights.passes import single_pass, solver_of
from geosurf.sheets.lattice.data import picks_of
from geosurf.sheets.mesh.finish import fault_surfaces

HIDDEN = 6  # cells from a fault within which data are ignored
DROP = 2.0  # a misfit this many times that of the next cell may be smear
OF_THROW = 0.05  # share of the largest throw below which a misfit is not counted as smear
SHARE = 1.5  # cells of trim for each cell of smear
SPARE = 0.5  # cells more than that
USUAL = 2.0  # cells of trim where smear cannot be determined
FEWEST = 20  # data that a bin has to have


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
    ends with the last cell whose misfit (90th percentile) is twice that of the next one, and a
    twentieth of the largest throw.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=61, smear=2)
    >>> gs.propose_trim(world.horizons["Top"], world.faults).trim
    3.5
    """
    surfaces = fault_surfaces(faults)
    picks = picks_of(data, name, positive, length_unit)
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]

    # predict all data within HIDDEN cells of a fault from those farther away
    solver = solver_of(picks, meshes, float(HIDDEN))
    _, state = single_pass(solver, float(HIDDEN))
    state = state.with_walls(picks.frame)
    in_gap = picks_in_gaps(solver.inputs, state)
    _, far, misfit = ignored_misfits(picks, solver.inputs.nearby, state, in_gap)

    # far (n,): distance from the fault [cells]; misfit (n,): datum against prediction [m]
    far, misfit = far[far < HIDDEN], misfit[far < HIDDEN]
    number = np.bincount(far.astype(np.int64), minlength=HIDDEN)
    if (number[:HIDDEN] < FEWEST).any():
        raise GeometryError(
            f"horizon {picks.name!r} has {int(number.sum())} data within {HIDDEN} cells of its "
            "faults that can be predicted from the others, too few to measure the smear. Set trim "
            "to one and a half times the half width of the gridding's smear."
        )

    # one bin per cell of distance; the 90th percentile sees smear that most data escape
    tenth = [float(np.percentile(misfit[far.astype(np.int64) == k], 90)) for k in range(HIDDEN)]
    throws = np.abs(np.concatenate([walls.throw for walls in state.walls]))
    least = OF_THROW * float(throws.max(initial=0.0))

    # smear ends where misfit drops: the last bin well above the next one and above the throw share
    smeared = [k + 1 for k in range(HIDDEN - 1) if tenth[k] > max(DROP * tenth[k + 1], least)]
    if smeared:
        smear = float(max(smeared))
        return TrimProposal(SHARE * smear + SPARE, smear, tuple(tenth))
    if tenth[0] > least:  # missed at all distances: by the error of the sheets, or by noise
        return TrimProposal(USUAL, None, tuple(tenth))
    return TrimProposal(1.0, 0.0, tuple(tenth))
