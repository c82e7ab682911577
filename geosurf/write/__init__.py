"""Anything -> files: the object and the suffix pick the writer.

A file is written completely or left as it was, and the same object always gives the same bytes.
``lost`` of the returned list names what a format cannot hold.
"""

from __future__ import annotations

import copy
import re
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from os import PathLike
from pathlib import Path, PurePath
from types import ModuleType
from typing import Any

from geosurf.conventions import did_you_mean
from geosurf.conventions.axes import COORDINATES, on_map_axes
from geosurf.conventions.crs import are_same, label
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
from geosurf.model.base import Noun, with_crs
from geosurf.model.expected import name_of, path_of
from geosurf.write.datasets import is_block_model
from geosurf.write.written import (
    Loss,
    Written,
    commit,
    commit_folder,
    commit_set,
    declared_crs,
    own_name,
    prj_of,
)

# ---- registry ----------------------------------------
# The registry of writers: which function writes which kind of object under which suffix.


MESHES = (".vtu", ".vtk", ".obj", ".stl", ".ply")
LINES = {
    ".pol": ("points_and_lines", "pol_of_lines"),
    ".csv": ("points_and_lines", "csv_of_lines"),
    ".geojson": ("points_and_lines", "geojson_of_lines"),
}
RESQML = {".epc": ("resqml", "resqml_of_surfaces")}
TABLE = {".csv": ("datasets", "csv_of_table"), ".parquet": ("datasets", "parquet_of_table")}

# kind of object -> suffix -> (module, function)
WRITERS: dict[str, dict[str, tuple[str, str]]] = {
    "TriSurface": {
        ".ts": ("gocad", "tsurf"),
        ".vtp": ("datasets", "vtp_of_surface"),
        **dict.fromkeys(MESHES, ("mesh", "mesh_of_surface")),
        **dict.fromkeys((".glb", ".gltf"), ("mesh", "gltf_of_surface")),
        **RESQML,
    },
    "Curves": {".pl": ("gocad", "pline"), ".vtp": ("datasets", "vtp_of_curves"), **LINES},
    "Patches": {
        ".vtp": ("datasets", "vtp_of_patches"),
        ".vtu": ("mesh", "mesh_of_patches"),
        **dict.fromkeys((".glb", ".gltf"), ("mesh", "gltf_of_patches")),
    },
    "Unit": {
        ".vtp": ("datasets", "vtp_of_unit"),
        ".ts": ("gocad", "tsurf_of_unit"),
        **dict.fromkeys((".stl", ".vtu", ".obj", ".ply"), ("mesh", "mesh_of_unit")),
        **dict.fromkeys((".glb", ".gltf"), ("mesh", "gltf_of_unit")),
    },
    "Units": {
        ".vtm": ("datasets", "vtm_of_units"),
        ".ml": ("model3d", "model3d"),
        ".epc": ("resqml_framework", "resqml_of_units"),
        **TABLE,
        ".nc": ("datasets", "netcdf_of_units"),
        **dict.fromkeys((".glb", ".gltf"), ("mesh", "gltf_of_units")),
    },
    "TetMesh": {
        **dict.fromkeys((".vtu", ".msh", ".inp"), ("mesh", "mesh_of_tets")),
        **dict.fromkeys((".exo", ".e"), ("mesh", "exodus_of_tets")),
    },
    "FaultSticks": LINES,
    "horizon (DataArray)": {
        ".nc": ("datasets", "netcdf_of_horizon"),
        **dict.fromkeys((".gri", ".irap", ".irapbin"), ("text_grids", "irap_binary")),
        **dict.fromkeys((".irapasc", ".irapascii", ".fgr"), ("text_grids", "irap_classic")),
        **dict.fromkeys((".zmap", ".zmp"), ("text_grids", "zmap_of_horizon")),
        **dict.fromkeys((".cps3", ".cps"), ("text_grids", "cps3_of_horizon")),
        ".asc": ("text_grids", "esri_of_horizon"),
        ".xyz": ("text_grids", "xyz_of_horizon"),
        **RESQML,
    },
    # several surfaces: a Scene, or a list or mapping of horizons and faults
    "surfaces": RESQML,
    "Dataset of lines": {".nc": ("datasets", "netcdf_of_dataset"), **LINES},
    "Dataset of points": {
        ".nc": ("datasets", "netcdf_of_dataset"),
        **dict.fromkeys((".xyz", ".poi"), ("points_and_lines", "xyz_of_points")),
        ".csv": ("points_and_lines", "csv_of_points"),
        ".vs": ("points_and_lines", "vset_of_points"),
        ".geojson": ("points_and_lines", "geojson_of_points"),
        ".parquet": ("datasets", "parquet_of_table"),
    },
    "Dataset on a grid": {
        ".nc": ("datasets", "netcdf_of_dataset"),
        ".zarr": ("datasets", "zarr_of_grid"),
        ".vti": ("datasets", "vti_of_grid"),
    },
    "Dataset of fault multipliers": {
        ".nc": ("datasets", "netcdf_of_dataset"),
        ".inc": ("grdecl", "inc_of_multipliers"),
    },
    "Dataset": {".nc": ("datasets", "netcdf_of_dataset"), **TABLE},
    "DataFrame": TABLE,
    "list of lines": LINES,
    "CornerPointGrid": {
        ".grdecl": ("grdecl", "grdecl_of_grid"),
        ".inc": ("grdecl", "inc_of_grid"),
        **dict.fromkeys((".egrid", ".roff"), ("grdecl", "binary_of_grid")),
    },
}
# suffixes of formats with a place for a coordinate reference system
KEEP_CRS = (
    ".nc", ".ts", ".pl", ".vs", ".vtp", ".vtm", ".vti", ".grdecl", ".zmap", ".zmp", ".geojson",
    ".glb", ".gltf", ".parquet", ".ml", ".zarr",
)  # fmt: skip
WITH_PRJ = (".asc",)  # a file .prj next to it holds the system
# formats that do not state whether z is elevation or depth, and have no custom for it
NO_DIRECTION = (
    ".gri", ".irap", ".irapbin", ".irapasc", ".irapascii", ".fgr", ".zmap", ".zmp", ".cps3",
    ".cps", ".asc", ".xyz", ".poi", ".pol", ".csv",
)  # fmt: skip
SETS = (".vtm", ".epc")  # an index and its parts, which replace their files together
WITH_SUFFIX = ("mesh_of", "gltf_of", "binary_of")  # functions that take the suffix, too

# advice for objects that cannot be written
INSTEAD = {
    "Sheet": " For the horizon cut at its faults, write scene.patches.surface(name), or as a grid "
    "scene.horizon_grid(name).",
    "TriSurface": " For a grid, write scene.horizon_grid(name).",
    "Scene": " Or write its scene.units, scene.curves or scene.patches.",
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


def kind_of(obj: Any) -> str | None:
    """Return the row of `WRITERS` for an object; xarray and pandas are not loaded for it."""
    for kind, cls in KINDS.items():
        if isinstance(obj, cls):
            return kind

    # an object of another package exists only if the package was imported
    xr, pandas = sys.modules.get("xarray"), sys.modules.get("pandas")
    if xr is not None and isinstance(obj, xr.DataArray):
        return "horizon (DataArray)" if obj.ndim == 2 else "Dataset"
    if xr is not None and isinstance(obj, xr.Dataset):
        return _kind_of_dataset(obj)
    if pandas is not None and isinstance(obj, pandas.DataFrame):
        return "DataFrame"
    if hasattr(obj, "surfaces") and hasattr(obj, "units"):  # a Scene, which lies above this room
        return "surfaces"
    if not isinstance(obj, list | tuple | Mapping) or not obj:
        return None
    several = list(obj.values() if isinstance(obj, Mapping) else obj)
    if any(kind_of(one) in ("TriSurface", "horizon (DataArray)") for one in several):
        return "surfaces"
    if isinstance(obj, Mapping) or any(getattr(one, "ndim", 0) != 2 for one in several):
        return None
    return "list of lines"


def _kind_of_dataset(dataset: Any) -> str:
    """Lines, points, a grid or any other Dataset, by its variables and their dimensions."""
    if "fault_multiplier" in dataset.variables:
        return "Dataset of fault multipliers"
    if not set(COORDINATES) <= set(dataset.variables):
        return "Dataset"
    dims = [dataset[axis].dims for axis in COORDINATES]
    if "count" in dataset.variables and "line" in dataset.dims:
        return "Dataset of lines"
    if len(dims[0]) == 1 and dims[0] == dims[1] == dims[2]:
        return "Dataset of points"
    return "Dataset on a grid" if dims == [(axis,) for axis in COORDINATES] else "Dataset"


__all__ = ["Loss", "Written", "write"]


def write(
    obj: Any, path: str | PathLike[str], *, name: str | None = None, crs: str | None = None
) -> Written:
    """
    Write a surface, curves, patches, units, a horizon or a table to a file.

    Parameters
    ----------
    obj : object
        TriSurface, Curves, Patches, Unit, Units, TetMesh, CornerPointGrid, FaultSticks, DataArray,
        Dataset, DataFrame, or a list of lines (n, 3).
    path : path-like
        The suffix picks the format. TriSurface: ``.ts .vtp .vtu .vtk .obj .stl .ply .glb .gltf``.
        Curves: ``.pl .vtp .pol .csv .geojson``. Patches: ``.vtp .vtu .glb .gltf``. Unit: ``.vtp
        .ts .stl .vtu .obj .ply .glb .gltf``. Units: ``.vtm`` (and a folder of ``.vtp`` next to
        it), ``.ml`` and ``.epc`` (the sealed model with its regions), ``.glb .gltf``; their table:
        ``.csv .parquet .nc``. TetMesh: ``.vtu .msh .inp .exo .e``.
        Horizon: ``.nc``; IRAP text ``.irapasc .irapascii .fgr``; IRAP binary (float32) ``.gri
        .irap .irapbin``; without rotation ``.zmap .zmp .cps3 .cps .asc``; its nodes ``.xyz``.
        Lines (FaultSticks, lists, Datasets such as fault polygons): ``.pol .csv .geojson``.
        Points: ``.xyz .poi .csv .vs .geojson .parquet``. Datasets: ``.nc``; of one dimension
        ``.csv .parquet``; regular grids ``.vti`` and ``.zarr`` (a folder). CornerPointGrid:
        ``.grdecl`` (pillars, depths, active cells, faults), ``.inc`` (zones, blocks and regions),
        ``.egrid`` and ``.roff`` (with xtgeo). Surfaces, a list or mapping of them, Scene:
        ``.epc`` (RESQML).
    name : str, optional
        Name to store. Default: the object's own, else the file name without suffix.
    crs : str, optional
        Coordinate reference system of an object that declares none, as in ``"EPSG:23031"``.

    Returns
    -------
    Written
        List of the paths written; its ``lost`` and ``notes`` name what the format could not hold,
        with the largest rounding error. It prints both.

    Raises
    ------
    OutputError
        If the suffix does not suit the object, the format cannot hold the values, `crs` is not
        that of the object, or the folder or file cannot be written. Then nothing is left behind.
    InputError
        If a horizon has no ``positive`` or no known ``units`` and the format needs them.
    DependencyError
        If NetCDF, Zarr or Parquet support is not installed.

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
    kind = kind_of(obj)
    if kind is None:
        raise OutputError(
            f"{path}: geosurf cannot write an object of type {type(obj).__name__}; it writes "
            f"{', '.join(WRITERS)}.{INSTEAD.get(type(obj).__name__, '')}"
        )
    if kind == "horizon (DataArray)":
        obj = on_map_axes(obj)
    suffix = path.suffix.lower()
    _refuse_suffix(obj, kind, path, suffix)
    if kind != "surfaces":  # these may declare a system each
        obj, crs = _in_crs(obj, crs, path)
    if kind == "Dataset" and hasattr(obj, "to_dataset"):  # scene.volumes, scene.thickness(...)
        obj = obj.to_dataset(name=name or obj.name or path.stem, promote_attrs=True)

    # writers are loaded when needed: meshio and xarray cost time
    module, function = WRITERS[kind][suffix]
    encode: Callable[..., Any] = getattr(import_module(f"geosurf.write.{module}"), function)

    # an index and its parts replace their files together; the index is named first
    if suffix in SETS:
        files, lost, ours = encode(obj, path, name, crs)
        return Written(sorted(commit_set(path, files, ours), key=path.__ne__), lost)
    if suffix == ".zarr":
        files, lost = encode(obj, name)
        return Written(commit_folder(path, files, is_block_model), lost)
    title = name or own_name(obj)
    if kind in ("TriSurface", "Unit", "horizon (DataArray)"):
        title = str(title or path.stem)
    extra = (
        (suffix,) if function.startswith(WITH_SUFFIX) else (crs,) if suffix == ".geojson" else ()
    )
    data, lost = encode(obj, title, *extra)
    if suffix in WITH_PRJ:
        whole = getattr(obj, "attrs", {}).get("crs")  # a description goes before its code
        described = isinstance(whole, str) and "[" in whole
        return _with_prj(path, data, lost, whole if described else crs)
    return Written(commit(path, data), [*lost, *_lost_crs(crs, suffix)])


def _refuse_suffix(obj: Any, kind: str, path: Path, suffix: str) -> None:
    """Refuse a suffix that the kind of object is not written to, with those that it is."""
    known = WRITERS[kind]
    if suffix not in known:
        raise OutputError(
            f"{path}: {kind} cannot be written as {suffix or 'a file without suffix'!r}. Use one "
            f"of the suffixes {', '.join(known)}.{did_you_mean(suffix, known)}"
            f"{INSTEAD.get(type(obj).__name__, '')}"
        )


def _in_crs(obj: Any, crs: str | None, path: Path) -> tuple[Any, str | None]:
    """Return an object with its reference system: that which it declares, or the given one."""
    declared = declared_crs(obj)
    if crs is None:
        return obj, declared
    crs = name_of(crs, "coordinate reference system")
    if declared is not None:
        if are_same(declared, crs) is False:
            raise OutputError(
                f"{path}: the object is in {label(declared)}, and crs= is {label(crs)}. Leave crs= "
                f"out, or convert the object: gs.reproject(obj, {crs!r})."
            )
        return obj, declared
    if isinstance(obj, list | tuple):
        return obj, crs
    if hasattr(obj, "assign_attrs"):
        return obj.assign_attrs(crs=crs), crs
    made = copy.copy(obj)
    if isinstance(obj, Noun):
        with_crs(made, crs)
    else:
        made.attrs = {**obj.attrs, "crs": crs}
    return made, crs


def _with_prj(path: Path, data: bytes, lost: list[Loss], crs: str | None) -> Written:
    """Write a file, and its reference system next to it."""
    prj = path.with_suffix(".prj")
    content, why = (None, []) if crs is None else prj_of(crs)
    if content is None and prj.exists():
        raise OutputError(
            f"{path}: {prj.name} lies next to it and would be read as its coordinate reference "
            f"system, but there is none to write. Remove {prj.name}, or give crs=."
        )
    if content is None:
        return Written(commit(path, data), [*lost, *why])
    pair = {PurePath(path.name): data, PurePath(prj.name): content}
    ours = re.compile("|".join(re.escape(str(name)) for name in pair))
    return Written(sorted(commit_set(path, pair, ours), key=path.__ne__), [*lost, *why])


def _lost_crs(crs: str | None, suffix: str) -> list[Loss]:
    """A loss where the coordinate reference system of an object is not in its file."""
    if crs is None or suffix in KEEP_CRS:
        return []
    return [
        Loss(
            "crs", f"The format does not store the coordinate reference system (CRS), {label(crs)}."
        )
    ]


class _Room(ModuleType):
    """The folder `geosurf.write`, which answers a call as the function of the same name.

    Importing a folder binds it in its parent, over the function that
    ``geosurf.write`` means to users; so the folder can be called, too.
    """

    def __call__(
        self,
        obj: Any,
        path: str | PathLike[str],
        *,
        name: str | None = None,
        crs: str | None = None,
    ) -> Written:
        return write(obj, path, name=name, crs=crs)


sys.modules[__name__].__class__ = _Room
__doc__ = write.__doc__ or ""
