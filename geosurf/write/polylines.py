"""Polylines in text: ``x y z`` per line, each polyline ended by ``999 999 999``."""

from __future__ import annotations

import numpy as np

from geosurf.errors import OutputError
from geosurf.model import Curves, FaultSticks

END_OF_LINE = "999.0 999.0 999.0"
DIRECTION = "z is elevation in metres, which .pol does not say: read it with positive='up'."


def pol_of_curves(curves: Curves, name: str | None) -> tuple[bytes, list[str]]:
    """Return the curves as polylines; which surfaces meet there is lost."""
    if curves.n_curve == 0:
        raise OutputError("there are no curves, and a .pol file needs one. Write .vtp instead.")
    lost = "The names of the surfaces are not in the file; .vtp and .pl keep them."
    return _text([curves.points[curve] for curve in curves.curves]), [DIRECTION, lost]


def pol_of_sticks(fault: FaultSticks, name: str | None) -> tuple[bytes, list[str]]:
    """Return the sticks of a fault."""
    return _text(list(fault.sticks)), [DIRECTION]


def _text(polylines: list[np.ndarray]) -> bytes:
    lines = []
    for polyline in polylines:
        lines += [" ".join(map(repr, row)) for row in polyline.tolist()]
        lines.append(END_OF_LINE)
    return ("\n".join(lines) + "\n").encode("ascii")
