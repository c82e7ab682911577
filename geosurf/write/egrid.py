"""EGRID and ROFF: binary corner-point grids, written by xtgeo (extra ``xtgeo``)."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from geosurf.model.grids import CornerPointGrid
from geosurf.write.written import Loss

FORMATS = {".egrid": "egrid", ".roff": "roff_binary"}


def binary_of_grid(
    grid: CornerPointGrid, name: str | None, suffix: str
) -> tuple[bytes, list[Loss]]:
    """Return a grid as xtgeo writes it."""
    theirs = grid.to_xtgeo()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"grid{suffix}"
        theirs.to_file(path, fformat=FORMATS[suffix])
        data = path.read_bytes()
    off = max(
        float(np.abs(values - values.astype(np.float32)).max())
        for values in (grid.coord, grid.levels)
    )
    words = (
        f"Coordinates and depths were rounded to float32, by up to {off:.2g} m; elevations are "
        "written as depths. The .grdecl has coordinates to 0.001 m."
    )
    return data, [
        Loss("precision", words, off),
        Loss("data", "Faults, zones and blocks were left out: write .grdecl and .inc, too."),
    ]


__all__ = ["binary_of_grid"]
