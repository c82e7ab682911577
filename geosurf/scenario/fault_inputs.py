"""One ``[[faults]]`` -> a fault: a file, a piece of its mesh, or polygons on horizons."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted
from geosurf.errors import ScenarioError
from geosurf.read import read_fault, read_polygons
from geosurf.scenario.fault_keys import FaultInput, PolygonInput
from geosurf.triangulate import triangulate_fault


def fault_of(entry: FaultInput, words: dict[str, Any]) -> Any:
    """
    Read one fault.

    Parameters
    ----------
    entry : FaultInput
    words : dict of str to str or None
        ``positive`` and ``length_unit`` of its files.

    Returns
    -------
    TriSurface, FaultSticks or xarray.Dataset

    Raises
    ------
    InputError
        If a file cannot be read, or has no such piece or polygon.
    """
    table: dict[str, Any] = {}
    if entry.columns is not None or entry.decimal != ".":
        table = {"columns": entry.columns, "decimal": entry.decimal}
    if entry.polygons:
        from geosurf.triangulate import fault_from_polygons  # loaded by those who have polygons

        rings = {one.horizon: _polygon(one, entry.name, words | table) for one in entry.polygons}
        return fault_from_polygons(rings, name=entry.name)
    assert entry.file is not None
    fault = read_fault(entry.file, name=entry.name_in_file or entry.name, **words, **table)
    return fault if entry.piece is None else _piece(fault, entry, entry.piece, entry.file)


def _piece(fault: Any, entry: FaultInput, number: int, path: Path) -> Any:
    """One piece of a mesh, under the name of the fault."""
    from geosurf.faults import split_fault  # loaded by those who take a piece

    parts = list(split_fault(triangulate_fault(fault, name=entry.name)).values())
    if number > len(parts):
        raise ScenarioError(
            f"{path}: piece {number} is requested for fault {entry.name!r}, and the mesh has "
            f"{counted(len(parts), 'piece')}. Give a piece from 1 to {len(parts)}."
        )
    return parts[number - 1].renamed(entry.name, "fault")


def _polygon(entry: PolygonInput, fault: str, words: dict[str, Any]) -> np.ndarray:
    """One polygon of a file."""
    rings = read_polygons(entry.file, **words)
    if entry.polygon is None and len(rings) == 1:
        return rings[0]
    if entry.polygon is None or entry.polygon > len(rings):
        asked = "which one is not stated"
        if entry.polygon is not None:
            asked = f"{entry.polygon} is requested"
        raise ScenarioError(
            f"{entry.file}: the file has {counted(len(rings), 'polygon')}, and {asked} for fault "
            f"{fault!r}. Give polygon = 1 to {len(rings)} in [[faults.polygons]]."
        )
    return rings[entry.polygon - 1]


__all__ = ["fault_of"]
