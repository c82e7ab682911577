"""By throw: what is found between the cut-offs of a sheet, beside what was asked for.

Both cut-offs are read along lines down the dip of the fault (`diplines`): in the plane of s and
z, each point of a line is named by where its line is at one level, and compared there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geosurf.model import FaultCut
from geosurf.sheets.cutoffs import LONGEST, met
from geosurf.sheets.diplines import FAR_STEPS
from geosurf.sheets.frame import Frame
from geosurf.sheets.slip import Slip


def down_dip(cut: FaultCut, slip: Slip, frame: Frame) -> FaultCut:
    """Throw and heave along the lines down the dip of a fault, as they were asked for."""
    section, n = slip.section, len(cut.stations)
    if n == 0:
        return cut
    level = float(cut.stations[:, 2].mean())

    def named(points: np.ndarray) -> np.ndarray:
        """Where the lines through points (n, 3) are at one level; across strike; elevation."""
        s, r = section.of(points[:, :2] - frame.corner)
        z = points[:, 2]
        at = slip.along(s, z, np.full(len(z), level), FAR_STEPS)
        return np.column_stack([at, r, z])

    stations = named(cut.stations)
    across = np.broadcast_to([0.0, 1.0], (n, 2))
    found = {}
    for wall, lines in cut.cutoffs.items():
        t, z = met(stations[:, :2], across, [named(line) for line in lines], LONGEST * frame.cell)
        known = np.isfinite(z)
        s = np.full(n, np.nan)
        s[known] = slip.along(stations[known, 0], np.full(known.sum(), level), z[known], FAR_STEPS)
        found[wall] = np.column_stack([s, t, z])
    plus, minus = found["+"], found["-"]
    gap = plus - minus
    heave = np.copysign(np.hypot(gap[:, 0], gap[:, 1]), gap[:, 1])
    return replace(cut, throw=-gap[:, 2], heave=heave)
