"""The registry of formats: which module reads each, and which one a file gets.

`format=` goes before the content, and the content before the suffix (`_detect`). Each reader is
imported when it is first needed.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any

from geosurf.conventions import did_you_mean, is_word
from geosurf.errors import FormatError
from geosurf.model.expected import path_of
from geosurf.read._detect import detect, detect_foreign, head_of
from geosurf.read._guard import damaged, is_zarr, opened
from geosurf.read.grids.node_lists import looks_like_ijxyz

# format -> (module, function, suffixes)
MESH_FORMATS = {
    "tsurf": ("gocad", "read_gocad", (".ts",)),
    "vtp": ("vtp", "read_vtp", (".vtp",)),
    "vtk": ("vtk_legacy", "read_vtk", (".vtk",)),
    "gltf": ("gltf", "read_gltf", (".glb", ".gltf")),
    "mesh": (
        "mesh",
        "read_mesh",
        (".vtu", ".vtk", ".obj", ".stl", ".ply", ".off", ".msh", ".inp", ".xdmf"),
    ),
}
GRID_FORMATS = {
    "irap": (
        "grids.binary_grids",
        "read_irap",
        (".gri", ".irap", ".irapbin", ".irapasc", ".irapascii", ".fgr"),
    ),
    "netcdf": ("netcdf", "read_netcdf_horizon", (".nc", ".nc4")),
    "zarr": ("netcdf", "read_zarr_horizon", (".zarr",)),
    "zmap": ("grids.text_grids", "read_zmap", (".zmap", ".zmp")),
    "cps3": ("grids.text_grids", "read_cps3", (".cps3", ".cps")),
    "surfer": ("grids.binary_grids", "read_surfer", (".grd",)),
    "storm": ("grids.binary_grids", "read_storm", (".storm",)),
    "esri": ("grids.text_grids", "read_esri", (".asc",)),
    "gxf": ("grids.text_grids", "read_gxf", (".gxf",)),
    "earthvision": ("grids.node_lists", "read_earthvision", (".evgrid",)),
    "sgrid": ("gocad", "read_sgrid", (".sg",)),
    "geotiff": ("grids.geotiff", "read_geotiff", (".tif", ".tiff")),
    "ijxyz": ("grids.node_lists", "read_ijxyz", (".ijxyz",)),
}
HORIZON_FORMATS = {
    **GRID_FORMATS,
    **MESH_FORMATS,
    "resqml": ("resqml.surfaces", "read_resqml_horizon", (".epc",)),  # grids or meshes
}
FAULT_FORMATS = {
    "sticks": ("polylines", "read_sticks", (".pol", ".csv", ".dat", ".txt")),
    "charisma": ("polylines", "read_charisma_sticks", (".charisma",)),
    "cps3_lines": ("polylines", "read_cps3_sticks", (".cps3lines",)),
    "attributes": ("polylines", "read_attribute_sticks", (".rmsattr",)),
    "netcdf": ("netcdf", "read_netcdf_fault", (".nc", ".nc4")),
    "pline": ("gocad", "read_pline_sticks", (".pl",)),
    "sgrid": ("gocad", "read_sgrid_fault", (".sg",)),
    "geojson": ("features", "read_feature_sticks", (".geojson", ".json")),
    "shapefile": ("features", "read_feature_sticks", (".shp",)),
    "resqml": ("resqml.surfaces", "read_resqml_fault", (".epc",)),
    **MESH_FORMATS,
}
POINT_FORMATS = {
    "xyz": ("polylines", "read_xyz", (".poi", ".xyz", ".txt", ".csv", ".dat")),
    "vset": ("gocad", "read_vset", (".vs",)),
    "las": ("las", "read_las_points", (".las",)),
    "geojson": ("features", "read_feature_points", (".geojson", ".json")),
    "shapefile": ("features", "read_feature_points", (".shp",)),
    "attributes": ("polylines", "read_attribute_points", (".rmsattr",)),
    "resqml": ("resqml.surfaces", "read_resqml_points", (".epc",)),
}
POLYGON_FORMATS = {
    "polygons": ("polylines", "read_polylines", (".pol", ".csv", ".txt", ".dat")),
    "pline": ("gocad", "read_pline", (".pl",)),
    "geojson": ("features", "read_feature_polygons", (".geojson", ".json")),
    "shapefile": ("features", "read_feature_polygons", (".shp",)),
    "cps3_lines": ("polylines", "read_cps3_polygons", (".cps3lines",)),
    "attributes": ("polylines", "read_attribute_polygons", (".rmsattr",)),
    "resqml": ("resqml.surfaces", "read_resqml_polygons", (".epc",)),
}
# what people call the formats; the table of docs/formats.md is tested against it
TITLES = {
    "irap": "IRAP classic and binary",
    "zmap": "ZMAP+",
    "netcdf": "NetCDF",
    "zarr": "Zarr store",
    "cps3": "CPS-3",
    "surfer": "Surfer 6 and 7",
    "storm": "STORM",
    "esri": "ESRI text",
    "gxf": "GXF",
    "earthvision": "EarthVision grid",
    "ijxyz": "seismic grid (IJXYZ)",
    "geotiff": "GeoTIFF",
    "sgrid": "GOCAD SGrid",
    "resqml": "RESQML 2.0.1",
    "las": "LAS",
    "tsurf": "GOCAD TSurf",
    "model3d": "GOCAD Model3d",
    "pline": "GOCAD PLine",
    "vset": "GOCAD VSet",
    "vtp": "VTK XML",
    "vtk": "legacy VTK",
    "gltf": "glTF",
    "geojson": "GeoJSON",
    "shapefile": "ESRI shapefile",
    "mesh": "other meshes",
    "sticks": "fault sticks",
    "charisma": "Charisma fault sticks",
    "cps3_lines": "CPS-3 lines",
    "attributes": "points and lines with attributes",
    "polygons": "polygons",
    "xyz": "points",
    "petrel_tops": "well tops",
    "tops": "well tops",
    "petrel_well": "well trace of Petrel",
    "rms_well": "well of RMS",
    "wells": "paths of wells",
    "well_heads": "heads of wells",
}
# recognised by content, and read by functions without a choice of formats
OF_ONE_FUNCTION = {
    "petrel_tops": "read_tops",
    "petrel_well": "read_wells",
    "rms_well": "read_wells",
}


def known_formats() -> dict[str, Mapping[str, tuple[str, str, tuple[str, ...]]]]:
    """Formats by the function that reads them."""
    return {
        "read_horizon": HORIZON_FORMATS,
        "read_fault": FAULT_FORMATS,
        "read_points": POINT_FORMATS,
        "read_polygons": POLYGON_FORMATS,
    }


def _who_reads(suffix: str) -> str:
    """A sentence on the functions that know a suffix, or nothing."""
    known = known_formats().items()
    found = [name for name, formats in known if any(suffix in s for *_, s in formats.values())]
    if not found:
        return ""
    torn = "; pass the points to tear_horizon" if "read_points" in found else ""
    return f" Read such a file with {', '.join(found)}{torn}."


def reader_of(
    path: str | PathLike[str],
    formats: Mapping[str, tuple[str, str, tuple[str, ...]]],
    format: str | None,  # noqa: A002
    caller: str,
) -> tuple[Path, str, Any]:
    """Return the path, the name of its format, and the function that reads it."""
    path = path_of(path, caller)
    if format is not None and not is_word(format, formats):
        raise FormatError(
            f"{caller}({path.name!r}): format={format!r} is unknown, expected one of "
            f"{', '.join(formats)}.{did_you_mean(format, formats)}"
        )

    # a folder is a store or nothing
    if "zarr" in formats and format in (None, "zarr") and is_zarr(path):
        module, function, _ = formats["zarr"]
        return path, "zarr", getattr(import_module(f"geosurf.read.{module}"), function)

    # format= goes before the content, and the content before the suffix
    suffix_of = {suffix: key for key, (_, _, names) in formats.items() for suffix in names}
    by_suffix = suffix_of.get(path.suffix.lower())
    # a name that the system does not allow is not there either; `Path.exists` raises for it
    is_there = os.path.exists(path)  # noqa: PTH110
    # what has no known suffix and is not there gets the list of suffixes as an answer
    key = format or (_by_content(path, formats, caller) if by_suffix or is_there else None)
    key = key or by_suffix
    # five columns could be anything to other functions; the reader of grids proves that they fit
    if key is None and "ijxyz" in formats and is_there and looks_like_ijxyz(head_of(path)):
        key = "ijxyz"
    foreign = detect_foreign(path) if key is None and is_there else None
    if foreign is not None:
        raise FormatError(
            f"{path}: this is a file of the kind {foreign}, which {caller} does not read. Export "
            "it in a format of docs/formats.md, or set format=."
        )
    if key is None:
        raise FormatError(
            f"{path}: {caller} does not read files with the suffix {path.suffix!r}; it reads "
            f"{', '.join(suffix_of)}.{did_you_mean(path.suffix.lower(), suffix_of)}"
            f"{_who_reads(path.suffix.lower())} "
            f"Or set format= to one of {', '.join(formats)}."
        )
    with opened(path) as (_, size):  # before anything is asked of it: a regular file with content
        pass
    if size == 0:
        raise damaged(f"{path}: the file is empty (0 bytes)")
    module, function, _ = formats[key]
    return path, key, getattr(import_module(f"geosurf.read.{module}"), function)


def _by_content(
    path: Path, formats: Mapping[str, tuple[str, str, tuple[str, ...]]], caller: str
) -> str | None:
    """Return the format that the content shows, if it is open None."""
    found = detect(path)
    if found in formats:
        return found
    # recognised, but another function reads it, or none does
    readers = [name for name, known in known_formats().items() if found in known]
    if found in OF_ONE_FUNCTION:
        readers = [OF_ONE_FUNCTION[found]]
    if found == "model3d":
        raise FormatError(
            f"{path}: this is a GOCAD Model3d, a sealed model of many surfaces. Read it with "
            "geosurf.read_units, or its surfaces with geosurf.read.model3d.read_model3d."
        )
    if readers and found is not None:
        raise FormatError(
            f"{path}: this is a file of the format {found!r}, which {caller} does not read. Read "
            f"it with {' or '.join(readers)}."
        )
    return None
