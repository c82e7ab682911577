"""Throw measured between the cut-offs of a moved sheet, next to the throw that was requested.

Both cut-offs are read along lines down the dip of the fault (`dip_lines`): in the plane of s and
z, each point of a line is named by where its line is at one level, and compared there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geosurf.model import FaultCut, LostThrow
from geosurf.sheets.faults.dip_lines import FAR_STEPS
from geosurf.sheets.faults.slip import Slip
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.report.cutoffs import met

LOST = 0.02  # of the largest throw: less than this may be missing next to a tip without a report
BESIDE = 2.0  # cells from a tip within which it is looked for
DYING = 1.5  # throw that dies at a tip is lost on a lattice as this power of its cell


def down_dip(cut: FaultCut, slip: Slip, frame: Frame, reach: float) -> tuple[FaultCut, np.ndarray]:
    """Throw and heave along the lines down the dip of a fault; and the requested throw (n,).

    `reach` is how far cut-offs may be from their stations [cells]. Requested is what the rock had
    to move by that is the footwall cut-off now; NaN where none is.
    """
    section, n = slip.section, len(cut.stations)
    if n == 0:
        return cut, np.empty(0)

    # a line down the dip is named by its s at this level, so that cut-offs of one line match
    level = float(cut.stations[:, 2].mean())

    def named(points: np.ndarray) -> np.ndarray:
        """Where the lines through points (n, 3) are at one level; across strike; elevation."""
        s, r = section.of(points[:, :2] - frame.corner)
        z = points[:, 2]
        at = slip.along(s, z, np.full(len(z), level), FAR_STEPS)
        return np.column_stack([at, r, z])

    # where the line of each station meets both cut-offs: s and r along strike and across, z
    stations = named(cut.stations)
    across = np.broadcast_to([0.0, 1.0], (n, 2))
    found = {}
    for wall, lines in cut.cutoffs.items():
        t, z = met(stations[:, :2], across, [named(line) for line in lines], reach * frame.cell)
        known = np.isfinite(z)
        s = np.full(n, np.nan)
        s[known] = slip.along(stations[known, 0], np.full(known.sum(), level), z[known], FAR_STEPS)
        found[wall] = np.column_stack([s, t, z])

    # heave is the gap in the map, negative where walls overlap; throw is positive down
    plus, minus = found["+"], found["-"]
    gap = plus - minus
    heave = np.copysign(np.hypot(gap[:, 0], gap[:, 1]), gap[:, 1])
    throw = -gap[:, 2]
    known = np.isfinite(throw)

    # the requested throw belongs to the rock that is the footwall cut-off now
    z = (minus[:, 2] - (1.0 - slip.share) * throw)[known]  # before the footwall rose
    s = slip.along(stations[known, 0], np.full(len(z), level), z, FAR_STEPS)
    requested = np.full(n, np.nan)
    rock = section.places(s, section.across(s, z))
    requested[known] = slip.amount(np.clip(s, 0.0, section.length), z, rock)
    return replace(cut, throw=throw, heave=heave), requested


def lost_at_tips(
    cut: FaultCut, requested: np.ndarray, largest: float, cell: float
) -> list[LostThrow]:
    """Places next to tips where more of the requested throw is missing than may go unreported.

    Throw that dies at a tip as its distance to the power of 3/2 is read from nodes of a lattice:
    what is lost is largest next to the tip, and falls as the cell to that power.
    """
    if len(cut.along) == 0:
        return []  # this fault tears nothing, while others do
    found = []

    # `along` starts at 0 for each trace: stations between two zeros are one trace
    first = np.flatnonzero(cut.along == 0.0)
    for k, rows in enumerate(np.split(np.arange(len(cut.along)), first[1:])):
        for end, at in zip(cut.ends[2 * k : 2 * k + 2], (rows[0], rows[-1]), strict=True):
            if end != "tip":
                continue
            near = rows[np.abs(cut.along[rows] - cut.along[at]) <= BESIDE * cell]

            # what is missing of the throw, in its direction: more than requested is below 0
            lost = np.copysign(1.0, requested[near]) * (requested[near] - cut.throw[near])

            # stations without a cut-off count as no loss
            lost = np.where(np.isfinite(lost), lost, 0.0)
            worst = int(near[lost.argmax()])
            if lost.max() > LOST * largest:
                # the loss falls as cell**DYING: the cell at which it would be as small as LOST
                finer = cell * (LOST * largest / float(lost.max())) ** (1.0 / DYING)
                where = tuple(cut.stations[worst].tolist())
                amounts = float(requested[worst]), float(cut.throw[worst])
                found.append(LostThrow(cut.fault, where, *amounts, cell, finer))
    return found
