"""Write, read back, compare: one row for each kind of object and suffix of the registry."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import geosurf as gs
from benchmarks.formats.subjects import CRS, UPRIGHT, difference, grid_of, nodes, places
from geosurf.errors import GeosurfError
from geosurf.read.registry import HORIZON_FORMATS, MESH_FORMATS, POINT_FORMATS, POLYGON_FORMATS
from geosurf.write import WRITERS

MESHES = ("TriSurface", "Unit", "Patches")
NEEDS = {".parquet": "pyarrow", ".egrid": "xtgeo", ".roff": "xtgeo"}


@dataclass
class Row:
    """
    One kind of object in one format.

    Attributes
    ----------
    kind, suffix : str
    files : list of pathlib.Path
    lost : tuple of Loss
    truth : ndarray or None
        What the file should hold.
    read_with : str
        The function of geosurf that reads it, or nothing.
    back : float or None
        Largest difference of what that function returns [m].
    peers : dict of str to str
        What other packages make of it.
    missing : str
        The package that is not installed.
    """

    kind: str
    suffix: str
    files: list[Path] = field(default_factory=list)
    lost: tuple[Any, ...] = ()
    truth: np.ndarray | None = None
    read_with: str = ""
    back: float | None = None
    peers: dict[str, float | str] = field(default_factory=dict)
    missing: str = ""


def suffixes(formats: Any) -> set[str]:
    """All suffixes of some formats."""
    return {suffix for _, _, names in formats.values() for suffix in names}


def reader(kind: str, suffix: str) -> str:
    """Name of the function of geosurf that reads a kind back, or nothing."""
    if suffix == ".epc" and kind == "surfaces":
        return ""  # several surfaces are read one by one
    if kind == "horizon (DataArray)":
        return "read_horizon" if suffix in suffixes(HORIZON_FORMATS) else "read_points"
    if kind == "Units" and suffix in (".ml", ".epc"):
        return "read_units"
    one_mesh = ("TriSurface", "Unit") if suffix in (".glb", ".gltf") else MESHES
    if kind in one_mesh and suffix in suffixes(MESH_FORMATS) | {".epc"}:
        return "read_fault"
    if kind == "Dataset of points" and suffix in suffixes(POINT_FORMATS):
        return "read_points"
    lines = ("Curves", "FaultSticks", "Dataset of lines", "list of lines")
    return "read_polygons" if kind in lines and suffix in suffixes(POLYGON_FORMATS) else ""


def read_back(function: str, path: Path, kind: str) -> np.ndarray:
    """Places that geosurf reads from a file; the direction is given where the file has none."""
    read = getattr(gs, function)
    try:
        found = read(path)
    except GeosurfError:
        found = read(path, positive="up")
    if function == "read_horizon":
        return nodes(found)
    if function == "read_units":
        return np.concatenate([unit.vertices for unit in found.values()])
    if function == "read_points":
        found = found.to_dataframe()
        return found[["easting", "northing", "elevation"]].to_numpy(dtype=np.float64)
    return np.concatenate(found) if isinstance(found, list) else np.asarray(found.vertices)


def round_trips(subjects: dict[str, Any], folder: Path) -> list[Row]:
    """Write every kind under every suffix and read it back."""
    rows = []
    for kind, known in WRITERS.items():
        for suffix in known:
            row = Row(kind, suffix)
            rows.append(row)
            package = NEEDS.get(suffix, "")
            if package and find_spec(package) is None:
                row.missing = package
                continue
            obj = subjects.get(kind)
            if obj is None:
                row.missing = "an example"
                continue
            if suffix in UPRIGHT:
                obj = grid_of(31, 41, 0.0)
            row.truth = places(kind, obj)
            stem = kind.split()[0] + ("s" if kind == "Units" else "")
            written = gs.write(obj, folder / f"{stem}_{len(rows)}{suffix}", crs=CRS)
            row.files, row.lost = list(written), written.lost
            row.read_with = reader(kind, suffix)
            if row.read_with and row.truth is not None:
                row.back = difference(row.truth, read_back(row.read_with, row.files[0], kind))
    return rows


__all__ = ["Row", "read_back", "reader", "round_trips"]
