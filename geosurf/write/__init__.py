"""Anything -> files: the object and the suffix pick the writer.

A file is written completely or left as it was, and the same object always gives the same bytes.
``notes`` of the returned list name what a format cannot hold.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from os import PathLike
from types import ModuleType
from typing import Any

from geosurf.conventions import did_you_mean
from geosurf.conventions.crs import crs_of, label
from geosurf.errors import OutputError
from geosurf.model import (
    CornerPointGrid,
    Curves,
    FaultSticks,
    Patches,
    TetMesh,
    TriSurface,
    Unit,
    Units,
)
from geosurf.model.base import Noun
from geosurf.model.expected import name_of, path_of
from geosurf.write._files import Written, commit, commit_set

__all__ = ["Written", "write"]

# kind of object -> suffix -> (module, function)
WRITERS: dict[str, dict[str, tuple[str, str]]] = {
    "TriSurface": {
        ".ts": ("gocad", "tsurf"),
        ".vtp": ("vtp", "vtp_of_surface"),
        **dict.fromkeys((".vtu", ".vtk", ".obj", ".stl", ".ply"), ("mesh", "mesh_of_surface")),
    },
    "Curves": {
        ".pl": ("gocad", "pline"),
        ".vtp": ("vtp", "vtp_of_curves"),
        ".pol": ("polylines", "pol_of_curves"),
    },
    "Patches": {".vtp": ("vtp", "vtp_of_patches"), ".vtu": ("mesh", "mesh_of_patches")},
    "Unit": {
        ".vtp": ("vtp", "vtp_of_unit"),
        ".ts": ("gocad", "tsurf_of_unit"),
        **dict.fromkeys((".stl", ".vtu", ".obj", ".ply"), ("mesh", "mesh_of_unit")),
    },
    "Units": {
        ".vtm": ("vtp", "vtm_of_units"),
        ".csv": ("table", "csv_of_units"),
        ".nc": ("netcdf", "netcdf_of_units"),
    },
    "TetMesh": dict.fromkeys((".vtu", ".msh", ".inp"), ("mesh", "mesh_of_tets")),
    "FaultSticks": {".pol": ("polylines", "pol_of_sticks")},
    "horizon (DataArray)": {
        ".nc": ("netcdf", "netcdf_of_horizon"),
        ".irap": ("irap", "irap_classic"),
        ".gri": ("irap", "irap_binary"),
    },
    "Dataset": {
        ".nc": ("netcdf", "netcdf_of_dataset"),
        ".vti": ("vti", "vti_of_grid"),
        ".pol": ("polylines", "pol_of_lines"),
        ".csv": ("polylines", "csv_of_lines"),
    },
    "CornerPointGrid": {
        ".grdecl": ("grdecl", "grdecl_of_grid"),
        ".inc": ("grdecl", "inc_of_grid"),
        **dict.fromkeys((".egrid", ".roff"), ("egrid", "binary_of_grid")),
    },
}
# suffixes of formats with a place for a coordinate reference system
KEEP_CRS = (".nc", ".ts", ".pl", ".vtp", ".vtm", ".vti", ".grdecl")
# advice for objects that cannot be written
INSTEAD = {
    "Sheet": " For the horizon cut at its faults, write scene.patches.surface(name).",
    "Scene": " Write its scene.units, scene.curves or scene.patches.",
}
KINDS = {
    "TriSurface": TriSurface,
    "Curves": Curves,
    "Patches": Patches,
    "Unit": Unit,
    "Units": Units,
    "TetMesh": TetMesh,
    "FaultSticks": FaultSticks,
    "CornerPointGrid": CornerPointGrid,
}


def write(obj: Any, path: str | PathLike[str], *, name: str | None = None) -> Written:
    """
    Write a surface, curves, patches, units, a horizon or a table to a file.

    Parameters
    ----------
    obj : object
        TriSurface, Curves, Patches, Unit, Units, TetMesh, CornerPointGrid, FaultSticks, DataArray
        or Dataset.
    path : path-like
        The suffix picks the format. TriSurface: ``.ts .vtp .vtu .vtk .obj .stl .ply``.
        Curves: ``.pl .vtp .pol``. Patches: ``.vtp .vtu``. Unit: ``.vtp .ts .stl .vtu .obj
        .ply``. Units: ``.vtm`` (and a folder of ``.vtp`` next to it), ``.csv``, ``.nc``.
        TetMesh: ``.vtu .msh .inp``. FaultSticks: ``.pol``. Horizon: ``.nc .irap``
        and ``.gri`` (float32). Dataset: ``.nc``; lines, such as fault polygons: ``.pol .csv``, too;
        regular grids: ``.vti``.
        CornerPointGrid: ``.grdecl`` (pillars, depths, active cells, faults), ``.inc`` (zones,
        blocks and regions), ``.egrid`` and ``.roff`` (with xtgeo).
    name : str, optional
        Name to store. Default: the object's own, else the file name without suffix.

    Returns
    -------
    Written
        List of the paths written; its ``notes`` name what the format could not hold,
        with the largest rounding error.

    Raises
    ------
    OutputError
        If the suffix does not suit the object, the format cannot hold the values, or
        the folder or file cannot be written. Then nothing is left behind.
    InputError
        If a horizon has no ``positive`` or no known ``units`` and the format needs them.
    DependencyError
        If NetCDF support is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geosurf.model import TriSurface
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [9, 0, 0], [0, 9, 9]], [[0, 1, 2]])
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> [path.name for path in write(ramp, folder / "F1.ts")]
    ['F1.ts']
    >>> write(ramp, folder / "F1.stl").notes[0]
    'The format does not store names.'
    """
    path = path_of(path, "write")
    if name is not None:
        name = name_of(name, "thing to write")
    kind = _kind(obj)
    if kind is None:
        raise OutputError(
            f"{path}: geosurf cannot write an object of type {type(obj).__name__}; it writes "
            f"{', '.join(WRITERS)}.{INSTEAD.get(type(obj).__name__, '')}"
        )

    # a DataArray over other dimensions is a table, and no grid format holds it
    suffix, known = path.suffix.lower(), WRITERS[kind]
    if kind == "horizon (DataArray)" and getattr(obj, "ndim", 2) != 2:
        raise OutputError(
            f"{path}: a DataArray over {tuple(obj.dims)} is not a horizon and cannot be "
            "written. Write scene.units (.csv, .nc) for the table of volumes, or "
            "da.to_dataset() (.nc)."
        )
    if suffix not in known:
        raise OutputError(
            f"{path}: {kind} cannot be written as {suffix or 'a file without suffix'!r}. Use one "
            f"of the suffixes {', '.join(known)}.{did_you_mean(suffix, known)}"
        )

    # writers are loaded when needed: meshio and xarray cost time
    module, function = known[suffix]
    encode: Callable[..., Any] = getattr(import_module(f"geosurf.write.{module}"), function)

    # an index and its parts replace their files together; the index is named first
    if suffix == ".vtm":
        files, notes = encode(obj, path.stem)
        return Written(reversed(commit_set(path, files)), notes)
    title = name or _own_name(obj)
    if kind in ("TriSurface", "Unit", "horizon (DataArray)"):
        title = str(title or path.stem)
    extra = (suffix,) if module in ("mesh", "egrid") else ()
    data, notes = encode(obj, title, *extra)
    return Written(commit(path, data), [*notes, *_lost_crs(obj, suffix)])


def _lost_crs(obj: Any, suffix: str) -> list[str]:
    """A note where the coordinate reference system of an object is not in its file."""
    crs = getattr(obj, "crs", None) if isinstance(obj, Noun) else crs_of(obj)
    if crs is None or suffix in KEEP_CRS:
        return []
    return [f"The format does not store the coordinate reference system (CRS), {label(crs)}."]


def _own_name(obj: Any) -> str | None:
    """Return what an object calls itself: its name, or its ``long_name`` attribute."""
    own = getattr(obj, "name", None)
    if own is None:
        own = getattr(obj, "attrs", {}).get("long_name")
    return None if own is None else str(own)


def _kind(obj: Any) -> str | None:
    """Return the row of WRITERS for an object; xarray is only looked at if it is loaded."""
    for kind, cls in KINDS.items():
        if isinstance(obj, cls):
            return kind

    # an object of xarray exists only if xarray was imported
    xr = sys.modules.get("xarray")
    if xr is not None and isinstance(obj, xr.DataArray):
        return "horizon (DataArray)"
    if xr is not None and isinstance(obj, xr.Dataset):
        return "Dataset"
    return None


class _Room(ModuleType):
    """The folder `geosurf.write`, which answers a call as the function of the same name.

    Importing a folder binds it in its parent, over the function that
    ``geosurf.write`` means to users; so the folder can be called, too.
    """

    def __call__(self, obj: Any, path: str | PathLike[str], *, name: str | None = None) -> Written:
        return write(obj, path, name=name)


sys.modules[__name__].__class__ = _Room
__doc__ = write.__doc__ or ""
