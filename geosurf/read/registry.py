"""The registry of formats: which module reads each, and which one a file gets.

`format=` goes before the content, and the content before the suffix. Signatures of first bytes
exclude each other, so their order does not matter. A table of numbers has no signature: what it
holds follows from the function that reads it. Each reader is imported when it is first needed.
"""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Callable
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any

from geosurf.conventions import check_word, did_you_mean, is_word
from geosurf.errors import FormatError, InputError
from geosurf.model.expected import path_of
from geosurf.read._guard import damaged, is_zarr, opened
from geosurf.read.grids.node_lists import looks_like_ijxyz

Formats = dict[str, tuple[str, str, tuple[str, ...]]]  # key -> (module, function, suffixes)
_FEATURES = {
    "read_fault": "read_feature_sticks",
    "read_points": "read_feature_points",
    "read_polygons": "read_feature_polygons",
}
_MESH = "read_horizon", "read_fault"
# key -> (what people call it, suffixes, module, which function of the module reads it for whom)
_TABLE: dict[str, tuple[str, str, str, dict[str, str]]] = {
    "irap": ("IRAP classic and binary", ".gri .irap .irapbin .irapasc .irapascii .fgr",
             "grids.binary_grids", {"read_horizon": "read_irap"}),
    "netcdf": ("NetCDF", ".nc .nc4", "netcdf",
               {"read_horizon": "read_netcdf_horizon", "read_fault": "read_netcdf_fault"}),
    "zarr": ("Zarr store", ".zarr", "netcdf", {"read_horizon": "read_zarr_horizon"}),
    "zmap": ("ZMAP+", ".zmap .zmp", "grids.text_grids", {"read_horizon": "read_zmap"}),
    "cps3": ("CPS-3", ".cps3 .cps", "grids.text_grids", {"read_horizon": "read_cps3"}),
    "surfer": ("Surfer 6 and 7", ".grd", "grids.binary_grids", {"read_horizon": "read_surfer"}),
    "storm": ("STORM", ".storm", "grids.binary_grids", {"read_horizon": "read_storm"}),
    "esri": ("ESRI text", ".asc", "grids.text_grids", {"read_horizon": "read_esri"}),
    "gxf": ("GXF", ".gxf", "grids.text_grids", {"read_horizon": "read_gxf"}),
    "earthvision": ("EarthVision grid", ".evgrid", "grids.node_lists",
                    {"read_horizon": "read_earthvision"}),
    "sgrid": ("GOCAD SGrid", ".sg", "gocad",
              {"read_horizon": "read_sgrid", "read_fault": "read_sgrid_fault"}),
    "geotiff": ("GeoTIFF", ".tif .tiff", "grids.binary_grids", {"read_horizon": "read_geotiff"}),
    "ijxyz": ("seismic grid (IJXYZ)", ".ijxyz", "grids.node_lists", {"read_horizon": "read_ijxyz"}),
    "sticks": ("fault sticks", ".pol .csv .dat .txt", "polylines", {"read_fault": "read_sticks"}),
    "polygons": ("polygons", ".pol .csv .txt .dat .xyz", "polylines",
                 {"read_polygons": "read_polylines"}),
    "xyz": ("points", ".poi .xyz .txt .csv .dat", "polylines", {"read_points": "read_xyz"}),
    "charisma": ("Charisma fault sticks", ".charisma", "polylines",
                 {"read_fault": "read_charisma_sticks"}),
    "cps3_lines": ("CPS-3 lines", ".cps3lines", "polylines",
                   {"read_fault": "read_cps3_sticks", "read_polygons": "read_cps3_polygons"}),
    "attributes": ("points and lines with attributes", ".rmsattr", "polylines",
                   {"read_fault": "read_attribute_sticks", "read_points": "read_attribute_points",
                    "read_polygons": "read_attribute_polygons"}),
    "pline": ("GOCAD PLine", ".pl", "gocad",
              {"read_fault": "read_pline_sticks", "read_polygons": "read_pline"}),
    "vset": ("GOCAD VSet", ".vs", "gocad", {"read_points": "read_vset"}),
    "las": ("LAS", ".las", "las", {"read_points": "read_las_points"}),
    "geojson": ("GeoJSON", ".geojson .json", "features", _FEATURES),
    "shapefile": ("ESRI shapefile", ".shp", "features", _FEATURES),
    "tsurf": ("GOCAD TSurf", ".ts", "gocad", dict.fromkeys(_MESH, "read_gocad")),
    "vtp": ("VTK XML", ".vtp", "vtp", dict.fromkeys(_MESH, "read_vtp")),
    "vtk": ("legacy VTK", ".vtk", "vtk_legacy", dict.fromkeys(_MESH, "read_vtk")),
    "gltf": ("glTF", ".glb .gltf", "mesh", dict.fromkeys(_MESH, "read_gltf")),
    "mesh": ("other meshes", ".vtu .vtk .obj .stl .ply .off .msh .inp", "mesh",
             dict.fromkeys(_MESH, "read_mesh")),
    "resqml": ("RESQML 2.0.1", ".epc", "resqml.surfaces",
               {"read_horizon": "read_resqml_horizon", "read_fault": "read_resqml_fault",
                "read_points": "read_resqml_points", "read_polygons": "read_resqml_polygons"}),
}  # fmt: skip


def _read_by(caller: str) -> Formats:
    """Formats that a function reads."""
    return {
        key: (module, functions[caller], tuple(suffixes.split()))
        for key, (_, suffixes, module, functions) in _TABLE.items()
        if caller in functions
    }


HORIZON_FORMATS = _read_by("read_horizon")  # grids or meshes
FAULT_FORMATS = _read_by("read_fault")
POINT_FORMATS = _read_by("read_points")
POLYGON_FORMATS = _read_by("read_polygons")
MESH_FORMATS = {key: HORIZON_FORMATS[key] for key in ("tsurf", "vtp", "vtk", "gltf", "mesh")}
GRID_FORMATS = {
    key: row for key, row in HORIZON_FORMATS.items() if key not in (*MESH_FORMATS, "resqml")
}
# what people call the formats
TITLES = {key: title for key, (title, *_) in _TABLE.items()} | {
    "model3d": "GOCAD Model3d", "petrel_tops": "well tops", "tops": "well tops",
    "petrel_well": "well trace of Petrel", "rms_well": "well of RMS", "wells": "paths of wells",
    "well_heads": "heads of wells",
}  # fmt: skip
# recognised by content, and read by functions without a choice of formats
OF_ONE_FUNCTION = {
    "petrel_tops": "read_tops",
    "petrel_well": "read_wells",
    "rms_well": "read_wells",
}


def known_formats() -> dict[str, Formats]:
    """Formats by the function that reads them."""
    return {
        "read_horizon": HORIZON_FORMATS,
        "read_fault": FAULT_FORMATS,
        "read_points": POINT_FORMATS,
        "read_polygons": POLYGON_FORMATS,
    }


# formats with columns: tables of text, and those where columns= names attributes or curves
WITH_COLUMNS = ("sticks", "polygons", "xyz", "attributes", "geojson", "shapefile", "las")


def refuse_columns(path: Path, key: str, columns: Any, decimal: Any) -> None:
    """
    Refuse ``columns=`` and ``decimal=`` for a format that has no columns.

    Raises
    ------
    InputError
    """
    if key not in WITH_COLUMNS and (columns is not None or not is_word(decimal, (".",))):
        raise InputError(
            f"{path}: columns= and decimal= apply to tables of text, but this is "
            f"{TITLES.get(key, key)}. Leave them out."
        )


def _who_reads(suffix: str) -> str:
    """A sentence on the functions that know a suffix, or nothing."""
    known = known_formats().items()
    functions = [name for name, formats in known if any(suffix in s for *_, s in formats.values())]
    if not functions:
        return ""
    torn = "; pass the points to tear_horizon" if "read_points" in functions else ""
    return f" Read such a file with {', '.join(functions)}{torn}."


def reader_of(
    path: str | PathLike[str],
    formats: Formats,
    format: str | None,  # noqa: A002
    caller: str,
) -> tuple[Path, str, Any]:
    """Return the path, the name of its format, and the function that reads it."""
    path = path_of(path, caller)
    if format is not None:
        unknown = f"{caller}({path.name!r}): format={format!r} is unknown, expected one of "
        check_word(format, formats, f"{unknown}{', '.join(formats)}.", error=FormatError)

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
    if format is None and is_there and key in (None, "zmap", *TABLES):
        refuse_foreign(path)
        if key is None:
            head = head_of(path)
            key = next((name for name in TABLES if name in formats and TABLES[name](head)), None)
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


def _by_content(path: Path, formats: Formats, caller: str) -> str | None:
    """Return the format that the content shows, if it is open None."""
    detected = detect(path)
    if detected in formats:
        return detected
    # recognised, but another function reads it, or none does
    readers = [name for name, known in known_formats().items() if detected in known]
    if detected in OF_ONE_FUNCTION:
        readers = [OF_ONE_FUNCTION[detected]]
    if detected == "model3d":
        raise FormatError(
            f"{path}: this is a GOCAD Model3d, a sealed model of many surfaces. Read it with "
            "geosurf.read_units, or its surfaces with geosurf.read.model3d.read_model3d."
        )
    if readers and detected is not None:
        raise FormatError(
            f"{path}: this is a file of the format {detected!r}, which {caller} does not read. "
            f"Read it with {' or '.join(readers)}."
        )
    return None


HEAD = 1 << 15  # bytes that decide


def _text(pattern: str) -> Callable[[bytes], bool]:
    """A test of the first words of a text, after a byte order mark and blank lines."""
    found = re.compile(rb"\A(?:\xef\xbb\xbf)?\s*(?:" + pattern.encode() + rb")", re.IGNORECASE)
    return lambda head: found.match(head) is not None


def _comments(*words: bytes) -> Callable[[bytes], bool]:
    """A test of comments that begin with # and hold all of some words."""
    return lambda head: (
        head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"#")
        and all(re.search(rb"^#\s*" + word, head, re.M | re.I) for word in words)
    )


def _is_irap(head: bytes) -> bool:
    """A text that begins with -996, or a Fortran record of 32 bytes that does."""
    binary = head[:8] == struct.pack(">ii", 32, -996)
    return binary or head.lstrip().startswith(b"-996")


VTK = re.compile(
    rb"# vtk DataFile Version[^\n]*\n[^\n]*\n\s*(?:ASCII|BINARY)\s+DATASET\s+POLYDATA\b",
    re.IGNORECASE,
)
GEOJSON = re.compile(
    rb"\A(?:\xef\xbb\xbf)?\s*\{.*?\"type\"\s*:\s*\"(?:FeatureCollection|GeometryCollection|Feature|"
    rb"(?:Multi)?(?:Point|LineString|Polygon))\"",
    re.DOTALL,
)


def _is_gltf(head: bytes) -> bool:
    """An object in JSON with the key "asset" and lists that only glTF has."""
    words = (b'"asset"', b'"accessors"', b'"bufferViews"', b'"meshes"', b'"nodes"', b'"scenes"')
    return (
        head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{")
        and sum(word in head for word in words) >= 2
        and b'"coordinates"' not in head
    )


def _is_resqml(head: bytes) -> bool:
    """A zip file whose first files are those of a package of Energistics."""
    words = (b"obj_", b"EpcExternalPartReference", b"resqml")
    opc = b"[Content_Types].xml" in head or b"_rels/" in head or b"docProps/" in head
    office = any(word in head for word in (b"xl/", b"word/", b"ppt/", b"officedocument", b"3D/"))
    known = any(word in head for word in words) or (opc and not office)
    return head.startswith(b"PK\x03\x04") and known


# lines of RMS such as "Float dip" before numbers, or the header of Petrel
ATTRIBUTES = (
    r"#\s*Petrel Points with attributes\b|(?:#[^\n]*\n\s*)*"
    r"(?:(?:float|string|discrete|int|integer)[ \t]+[^\n]*\n\s*)+"
    r"[-+]?\d\S*[ \t]+[-+]?\d\S*[ \t]+[-+]?\d"
)
# kind of line, inline, crossline, three numbers, perhaps a name, the number of the stick
CHARISMA = (
    r"(?:[#!][^\n]*\n\s*)*(?:INLINE|XLINE|CROSSLINE)[ \t]*-[ \t]*-?\d\S*[ \t]+-?\d\S*"
    r"(?:[ \t]+-?[\d.]\S*){3}(?:[ \t]+\S[^\n]*?)?[ \t]+\d+[ \t]*\r?\n"
)
# version, kind, name with two or three numbers behind it, number of logs
RMS_WELL = (
    r"\d+\.\d+[ \t]*\r?\n[^\n]*\n[ \t]*\S[^\n]*?(?:[ \t]+[-+]?\d[\d.eE+-]*){2,3}[ \t]*\r?\n"
    r"[ \t]*\d+[ \t]*\r?\n[ \t]*(?:[A-Za-z]|[-+]?\d\S*[ \t]+[-+]?\d\S*[ \t]+[-+]?\d)"
)
CELLS = re.compile(rb"^(?:SPECGRID|COORD|ZCORN|MAPAXES)\b", re.M)  # keywords of Eclipse
DXF = re.compile(rb"\A\s*(?:999[ \t]*\r?\n[^\n]*\n\s*)*0[ \t]*\r?\n\s*SECTION\b")
# the header of a horizon, or of fault segments
IESX = re.compile(rb"\A\s*PROFILE\b[^\n]*\bTYPE[ \t]+\d|^[ \t]*SNAPPING PARAMETERS\b", re.M)
GOCAD = r"(?:#[^\n]*\n\s*)*GOCAD[ \t]+"
SGRID = _text(GOCAD + r"SGrid\b")
# name of the format -> test of the first bytes; names of formats as in `geosurf.read`
SIGNATURES: dict[str, Callable[[bytes], bool]] = {
    "irap": _is_irap,
    "zmap": _text(r"(?:![^\n]*\n\s*)*@[^\n]*\bGRID\b"),
    "cps3": _text(r"(?:![^\n]*\n\s*)*FS(?:ASCI|ATTR|LIMI|NROW|XINC)\b"),
    "cps3_lines": _text(r"(?:![^\n]*\n\s*)*FF(?:ASCI|ATTR)\b"),
    "surfer": lambda head: head[:4] in (b"DSAA", b"DSBB", b"DSRB"),
    "storm": _text(r"STORMGRID_(?:BINARY|ASCII)\b"),
    "esri": _text(r"(?:ncols|nrows)[ \t]+\d+[ \t]*\r?\n\s*(?:ncols|nrows|[xy]ll)"),
    # long comments may come before its keys
    "gxf": lambda head: all(
        re.search(rb"^#" + key, head, re.M) for key in (rb"POINTS\s", rb"ROWS\s")
    ),
    "earthvision": _comments(rb"Grid_size:\s*\d", rb"Grid_space:"),
    "netcdf": lambda head: head.startswith((b"CDF\x01", b"CDF\x02", b"CDF\x05", b"\x89HDF\r\n")),
    **{key: _text(rf"{GOCAD}{key}\b") for key in ("tsurf", "model3d", "pline", "vset")},
    "vtp": lambda head: b"<VTKFile" in head and re.search(rb"type=.PolyData.", head) is not None,
    # other data sets of this kind go to meshio by their suffix
    "vtk": lambda head: VTK.match(head) is not None,
    "gltf": lambda head: head.startswith(b"glTF") or _is_gltf(head),
    "geojson": lambda head: GEOJSON.search(head) is not None and b'"Topology"' not in head,
    # the index of a shapefile (.shx) begins alike; its first entry is no record number
    "shapefile": lambda head: (
        head.startswith(b"\x00\x00\x27\x0a") and head[100:104] in (b"", b"\x00\x00\x00\x01")
    ),
    "charisma": _text(CHARISMA),
    "attributes": _text(ATTRIBUTES),
    # a TSurf may follow a grid that it was cut from
    "sgrid": lambda head: SGRID(head) and b"GOCAD TSurf" not in head,
    "las": _text(r"(?:#[^\n]*\n\s*)*~V"),
    "geotiff": lambda head: head[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    "petrel_tops": _text(r"#\s*Petrel well tops\b"),
    "petrel_well": _text(r"#\s*WELL TRACE\b"),
    "rms_well": _text(RMS_WELL),
    "resqml": _is_resqml,
}
# three numbers 999 on a line, numbers for the lines of a table, and three numbers of any kind
END_MARK = re.compile(rb"^\s*999(?:\.0*)?[\s,;]+999(?:\.0*)?[\s,;]+999(?:\.0*)?\s*$", re.M)
LABEL = re.compile(rb"\b(?:poly_id|stick_id|stick|segment_id|segment)\b", re.I)
NUMBERS = re.compile(rb"^\s*(?:[^\n]*[\s,;:])?(?:[+-]?\d[\d.eE+-]*[\s,;]+){2}[+-]?\d", re.M)


def has_numbers(head: bytes) -> bool:
    """Return whether a file is a text with lines of three numbers."""
    return b"\0" not in head and NUMBERS.search(head) is not None


def has_lines(head: bytes) -> bool:
    """Return whether a table of numbers separates its points into lines."""
    first = head.lstrip().split(b"\n", 1)[0]
    return bool(LABEL.search(first) or END_MARK.search(head))


# tables of numbers have no signature: what they hold follows from who reads them
TABLES: dict[str, Callable[[bytes], bool]] = {
    "ijxyz": looks_like_ijxyz,
    **dict.fromkeys(("sticks", "polygons", "xyz"), has_numbers),
}
# what else is recognised, to name it in errors: geosurf does not read these
FOREIGN: dict[str, tuple[Callable[[bytes], bool], str]] = {
    "GOCAD Well": (
        _text(GOCAD + r"Well\b"),
        "Export the path as a table with Well, MD, X, Y and Z, and read that with read_wells.",
    ),
    "GOCAD object other than TSurf, Model3d, PLine, VSet and SGrid": (
        _text(GOCAD + r"(?!(?:TSurf|Model3d|PLine|VSet|SGrid)\b)\w"),
        "Export surfaces as TSurf, lines as PLine, points as VSet.",
    ),
    "ZMAP+ points or lines": (
        _text(r"(?:![^\n]*\n\s*)*@[^\n]*,[ \t]*DATA\b"),
        "Export lines as .pol, points as x y z.",
    ),
    "OpendTect": (
        lambda head: head.startswith(b"dTect V"),
        "Export horizons as IJXYZ, points and fault sticks as x y z, in metres.",
    ),
    "grid of cells": (
        lambda head: CELLS.search(head) is not None or head.startswith(b"roff-"),
        "Export its horizons as grids, its faults as surfaces or sticks.",
    ),
    "XML": (
        lambda head: head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith((b"<?xml", b"<kml")),
        "Export it in a format of docs/formats.md: KML as GeoJSON.",
    ),
    "DXF": (
        lambda head: head.startswith(b"AutoCAD Binary DXF") or DXF.match(head) is not None,
        "Export triangles as .obj, .stl or GOCAD TSurf, lines as a shapefile, GeoJSON or .pol.",
    ),
    "IESX": (
        lambda head: IESX.search(head) is not None,
        "Export horizons as IJXYZ or x y z, faults as Charisma sticks.",
    ),
    "Excel workbook": (
        lambda head: head.startswith(b"PK\x03\x04") and b"xl/" in head,
        "Save its sheet as .csv.",
    ),
    "ZIP archive": (lambda head: head.startswith(b"PK\x03\x04"), "Unpack it."),
    "gzip": (lambda head: head.startswith(b"\x1f\x8b"), "Unpack it."),
}


def detect(path: Path) -> str | None:
    """
    Return the name of the format that the content of a file has, or None where it is open.

    Parameters
    ----------
    path : pathlib.Path

    Returns
    -------
    str or None
        A key of `SIGNATURES`.

    Raises
    ------
    InputError
        If it is not a regular file that can be opened.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.txt"
    >>> _ = file.write_text("FSASCI 0 1 COMPUTED 0 1.0E30 0")
    >>> detect(file)
    'cps3'
    """
    head = head_of(path)
    return next((key for key, fits in SIGNATURES.items() if fits(head)), None)


def detect_foreign(path: Path) -> str | None:
    """Return what a file is that geosurf does not read, in words, or None."""
    head = head_of(path)
    return next((kind for kind, (fits, _) in FOREIGN.items() if fits(head)), None)


def refuse_foreign(path: Path) -> None:
    """
    Refuse a file that geosurf recognises and does not read.

    Raises
    ------
    FormatError
    """
    kind = detect_foreign(path)
    if kind is not None:
        raise FormatError(
            f"{path}: this is a file of the kind {kind}, which geosurf does not read. "
            f"{FOREIGN[kind][1]}"
        )


def head_of(path: Path) -> bytes:
    """Return the first bytes of a regular file."""
    with opened(path) as (file, _):
        return file.read(HEAD)
