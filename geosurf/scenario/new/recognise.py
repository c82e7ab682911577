"""One file -> what it holds: a horizon, a fault, something else, or nothing that a scenario takes.

The content picks the readers that a run will use; where it is open, the suffix does.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geosurf.errors import GeosurfError
from geosurf.read import (
    GRID_FORMATS,
    MESH_FORMATS,
    POINT_FORMATS,
    POLYGON_FORMATS,
    read_fault,
    read_horizon,
)
from geosurf.read._common import read_text
from geosurf.read._detect import detect
from geosurf.read.line_names import NAMED_LINES
from geosurf.read.netcdf import holds_fault
from geosurf.scenario.new.found import OUT, Found, name_from
from geosurf.scenario.new.reading import surface_of_file
from geosurf.scenario.new.surfaces import grid, mesh, pieces, resqml, tsurfs
from geosurf.scenario.new.tables import named_faults, table


def recognised(path: Path) -> list[Found]:
    """Return what a file holds: one object, or several in a file with several surfaces."""
    # A folder stands for its files, but for the results of geosurf.
    if path.is_dir():
        return [Found(path, OUT, note="a folder with results of an earlier run", name=path.name)]
    try:
        found = _by_suffix(path)
    except GeosurfError as error:
        # The table names the file in its own column.
        reason = str(error).replace(f"{path}: ", "").replace(f"{path}, ", "")
        found = [Found(path, OUT, note=reason)]
    for one in found:
        one.name = one.name or name_from(path)
    return found


def _by_suffix(path: Path) -> list[Found]:
    suffix = path.suffix.lower()
    shown = detect(path) if path.is_file() else None

    def among(formats: Any) -> bool:
        """Whether the content, or else the suffix, is that of one of some formats."""
        if shown is not None:
            return shown in formats
        return any(suffix in suffixes for *_, suffixes in formats.values())

    # From formats with one meaning to those whose content decides.
    if suffix == ".ml" or shown == "model3d":
        return [Found(path, "model", "sealed model", "GOCAD Model3d")]
    # Parametric grids of faults are NetCDF files as well; their dimensions tell.
    if among({"netcdf": GRID_FORMATS["netcdf"]}) and holds_fault(path):
        return [
            surface_of_file(path, read_fault, "parametric grid", "fault", "has fault dimensions")
        ]
    if among(GRID_FORMATS):
        return [grid(path)]
    if among({"tsurf": MESH_FORMATS["tsurf"]}):
        return tsurfs(path)
    if shown == "resqml":
        return resqml(path)
    if among(MESH_FORMATS):
        return pieces(mesh(path, path.stem, lambda words: read_horizon(path, **words)))
    if shown in NAMED_LINES:
        return named_faults(path, shown)
    points, lines = (
        any(suffix in suffixes for *_, suffixes in formats.values())
        for formats in (POINT_FORMATS, POLYGON_FORMATS)
    )
    if points or lines:
        return [table(path, points, lines)]
    # Reading raises the usual message about a missing file.
    if not path.exists():
        read_text(path)  # the reason why it cannot be opened
    return [Found(path, OUT, note=f"geosurf reads no files with the suffix {suffix!r}")]


__all__ = ["recognised"]
