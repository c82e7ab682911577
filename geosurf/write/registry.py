"""The registry of writers: which function writes which kind of object under which suffix."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

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

MESHES = (".vtu", ".vtk", ".obj", ".stl", ".ply")
LINES = {
    ".pol": ("points_and_lines", "pol_of_lines"),
    ".csv": ("points_and_lines", "csv_of_lines"),
    ".geojson": ("points_and_lines", "geojson_of_lines"),
}
RESQML = {".epc": ("resqml", "resqml_of_surfaces")}
TABLE = {".csv": ("table", "csv_of_table"), ".parquet": ("table", "parquet_of_table")}

# kind of object -> suffix -> (module, function)
WRITERS: dict[str, dict[str, tuple[str, str]]] = {
    "TriSurface": {
        ".ts": ("gocad", "tsurf"),
        ".vtp": ("vtp", "vtp_of_surface"),
        **dict.fromkeys(MESHES, ("mesh", "mesh_of_surface")),
        **dict.fromkeys((".glb", ".gltf"), ("mesh", "gltf_of_surface")),
        **RESQML,
    },
    "Curves": {".pl": ("gocad", "pline"), ".vtp": ("vtp", "vtp_of_curves"), **LINES},
    "Patches": {
        ".vtp": ("vtp", "vtp_of_patches"),
        ".vtu": ("mesh", "mesh_of_patches"),
        **dict.fromkeys((".glb", ".gltf"), ("mesh", "gltf_of_patches")),
    },
    "Unit": {
        ".vtp": ("vtp", "vtp_of_unit"),
        ".ts": ("gocad", "tsurf_of_unit"),
        **dict.fromkeys((".stl", ".vtu", ".obj", ".ply"), ("mesh", "mesh_of_unit")),
        **dict.fromkeys((".glb", ".gltf"), ("mesh", "gltf_of_unit")),
    },
    "Units": {
        ".vtm": ("vtp", "vtm_of_units"),
        ".ml": ("model3d", "model3d"),
        ".epc": ("resqml_framework", "resqml_of_units"),
        ".csv": ("table", "csv_of_units"),
        ".parquet": ("table", "parquet_of_units"),
        ".nc": ("netcdf", "netcdf_of_units"),
        **dict.fromkeys((".glb", ".gltf"), ("mesh", "gltf_of_units")),
    },
    "TetMesh": {
        **dict.fromkeys((".vtu", ".msh", ".inp"), ("mesh", "mesh_of_tets")),
        **dict.fromkeys((".exo", ".e"), ("mesh", "exodus_of_tets")),
    },
    "FaultSticks": LINES,
    "horizon (DataArray)": {
        ".nc": ("netcdf", "netcdf_of_horizon"),
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
    "Dataset of lines": {".nc": ("netcdf", "netcdf_of_dataset"), **LINES},
    "Dataset of points": {
        ".nc": ("netcdf", "netcdf_of_dataset"),
        **dict.fromkeys((".xyz", ".poi"), ("points_and_lines", "xyz_of_points")),
        ".csv": ("points_and_lines", "csv_of_points"),
        ".vs": ("points_and_lines", "vset_of_points"),
        ".geojson": ("points_and_lines", "geojson_of_points"),
        ".parquet": ("table", "parquet_of_table"),
    },
    "Dataset on a grid": {
        ".nc": ("netcdf", "netcdf_of_dataset"),
        ".zarr": ("netcdf", "zarr_of_grid"),
        ".vti": ("vtp", "vti_of_grid"),
    },
    "Dataset of fault multipliers": {
        ".nc": ("netcdf", "netcdf_of_dataset"),
        ".inc": ("grdecl", "inc_of_multipliers"),
    },
    "Dataset": {".nc": ("netcdf", "netcdf_of_dataset"), **TABLE},
    "DataFrame": {".csv": ("table", "csv_of_frame"), ".parquet": ("table", "parquet_of_frame")},
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
AXES = ("easting", "northing", "elevation")


def kind_of(obj: Any) -> str | None:
    """Return the row of `WRITERS` for an object; xarray and pandas are not loaded for it."""
    for kind, cls in KINDS.items():
        if isinstance(obj, cls):
            return kind

    # an object of another package exists only if the package was imported
    xr, pandas = sys.modules.get("xarray"), sys.modules.get("pandas")
    if xr is not None and isinstance(obj, xr.DataArray):
        return "Dataset" if obj.ndim == 1 and obj.name else "horizon (DataArray)"
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
    if not set(AXES) <= set(dataset.variables):
        return "Dataset"
    dims = [dataset[axis].dims for axis in AXES]
    if "count" in dataset.variables and "line" in dataset.dims:
        return "Dataset of lines"
    if len(dims[0]) == 1 and dims[0] == dims[1] == dims[2]:
        return "Dataset of points"
    return "Dataset on a grid" if dims == [(axis,) for axis in AXES] else "Dataset"
