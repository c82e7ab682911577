"""Warn of input vertices that a repair moved."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.errors import GeosurfWarning
from geosurf.model import Patches, TriSurface

_REPORTED = 1e-6  # metres: smaller moves are below any measurement; most repairs move by 2 nm


def warnings_of_moves(given: Sequence[TriSurface], patches: Patches) -> tuple[GeosurfWarning, ...]:
    """
    Return a warning if a repair moved input vertices, because rounding would break triangles.

    Parameters
    ----------
    given : sequence of TriSurface
        Input surfaces of the rebuild.
    patches : Patches

    Returns
    -------
    tuple of GeosurfWarning
        At most one, for moves of more than 1 micrometre, with the place of the largest move.
        ``patches.report`` has all moves.
    """
    if patches.report["largest_move"] <= _REPORTED:
        return ()

    names, far, place = [], 0.0, None
    for old, new in zip(given, patches.sources, strict=True):
        before = old.vertices
        steps = np.linalg.norm(new.vertices - before, axis=1)
        if not steps.any():
            continue
        names.append(old.name)
        row = int(steps.argmax())
        if steps[row] > far:
            far, place = float(steps[row]), before[row]

    n = patches.report["moved_vertices"]
    count = "1 vertex" if n == 1 else f"{n} vertices"
    listed = ", ".join(repr(name) for name in names[:4]) + (" and others" if len(names) > 4 else "")
    warning = GeosurfWarning(
        "moved",
        names[0],
        f"{count} of {listed} moved by up to {far:.1e} m: surfaces almost touch there, "
        "and float64 cannot represent the exact result.",
        "To avoid this, round the coordinates of these surfaces and of the box: "
        "np.round(x * 1024) / 1024.",
        place,
    )
    return (warning,)
