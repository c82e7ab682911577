"""EGRID and ROFF: binary corner-point grids, written by xtgeo (extra ``xtgeo``)."""

from __future__ import annotations

import tempfile
from pathlib import Path

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
    return data, [
        Loss("precision", "Depths were rounded to float32; elevations are written as depths."),
        Loss("data", "Faults, zones and blocks were left out: write .grdecl and .inc, too."),
    ]


__all__ = ["binary_of_grid"]
