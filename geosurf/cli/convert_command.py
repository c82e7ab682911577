"""The command ``convert``: one file to another format, and what that format cannot hold."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import geosurf
from geosurf import read
from geosurf.cli.console import Answer
from geosurf.conventions import area_text, counted, did_you_mean, length_text
from geosurf.conventions.axes import COORDINATES
from geosurf.conventions.crs import are_same, label
from geosurf.errors import FormatError, InputError, OutputError
from geosurf.intersect import intersect_surfaces
from geosurf.model import TriSurface
from geosurf.read._common import collected, otherwise
from geosurf.read.features import features
from geosurf.read.file_info import kind_of_file
from geosurf.read.registry import MESH_FORMATS, TITLES
from geosurf.read.resqml.surfaces import function_of
from geosurf.triangulate import triangulate_fault, triangulate_horizon, triangulate_sticks
from geosurf.write import NO_DIRECTION, WRITERS, kind_of, write
from geosurf.write.written import Loss, Written

# ---- curves command ----------------------------------------
# The command ``curves``: the intersection lines of two surface files.


def curves_command(options: argparse.Namespace) -> Answer:
    """Find the curves of two surface files, and write them."""
    surfaces = [_surface(Path(path), options) for path in (options.first, options.second)]

    # curves name their surfaces: files of one name are distinguished by their paths
    if surfaces[0].name == surfaces[1].name:
        surfaces = [surfaces[0].renamed(options.first), surfaces[1].renamed(options.second)]
    curves = intersect_surfaces(surfaces)
    closed = int(curves.closed.sum())
    paths = write(curves, options.out)
    lines = [
        f"{path}: {counted(curves.n_curve, 'curve')}, {closed} closed, "
        f"{length_text(curves.length, 5)}"
        for path in paths
    ]

    # the file holds curves only: other contacts are printed
    points = sum(contact.kind == "point" for contact in curves.contacts)
    if points:
        lines.append(f"The surfaces also touch at {counted(points, 'point')}.")
    area = sum(contact.area for contact in curves.contacts)
    if len(curves.contacts) > points:
        covered = area_text(area, 6)
        lines.append(f"They coincide over {covered}; curves follow the outline of that area.")
    data = {
        "files": [str(path) for path in paths],
        "curves": curves.n_curve,
        "closed": closed,
        "length_m": curves.length,
        "touching_points": points,
        "coincident_area_m2": area,
    }
    return Answer(data, "\n".join(lines))


def _surface(path: Path, options: argparse.Namespace) -> TriSurface:
    """Read one surface: what `convert` would write as triangles."""
    asked = dict.fromkeys(("read_as", "name", "columns", "decimal", "heads")) | vars(options)
    source = _read(path, OF_SURFACES, argparse.Namespace(**asked))
    _fit(source, OF_SURFACES, None)
    if not isinstance(source.obj, TriSurface):
        raise FormatError(
            f"{path}: this is a file of {TITLES.get(source.key, source.key)}, read with "
            f"{source.function}, and curves need surfaces. Give a grid, a mesh or fault sticks."
        )
    return source.obj


OF_SURFACES = ".ts"  # the suffix of files that hold surfaces only
SPLIT = re.compile(rb"[,;\t]")


@dataclass
class Source:
    """
    What a file holds.

    Attributes
    ----------
    path : pathlib.Path
    key : str
        Name of its format.
    function : str
        Which function of geosurf reads it.
    obj : object
        What that function returned.
    crs : str or None
        Reference system, where the object has no place for it.
    is_open : bool
        The file does not state whether z is elevation or depth, and neither does the user.
    lost : list of Loss
        What the reader left out.
    """

    path: Path
    key: str
    function: str
    obj: Any = None
    crs: str | None = None
    is_open: bool = False
    lost: list[Loss] = field(default_factory=list)


def convert_command(options: argparse.Namespace) -> Answer:
    """Read one file, write another, and list what was lost."""
    source, written = _converted(options)
    data = {"source": str(source.path), "format": source.key, "read_with": source.function}
    title = TITLES.get(source.key, source.key)
    lost = "" if written.lost else "\n  nothing was lost"
    return Answer(
        data | written.to_dict(),
        f"{source.path}: {title}, read with {source.function}\n{written}{lost}",
    )


def _converted(options: argparse.Namespace) -> tuple[Source, Written]:
    """Return what was read, and what was written of it."""
    path, target = Path(options.source), Path(options.target)
    suffix = target.suffix.lower()
    _refuse_unknown(target, suffix)
    if target.exists() and path.exists() and target.samefile(path):
        raise InputError(f"{path}: source and target are the same file. Name another target.")
    source = _read(path, suffix, options)
    _fit(source, suffix, options.name)

    crs = options.crs
    if crs is None or source.crs is None:
        crs = crs or source.crs
    elif are_same(crs, source.crs) is False:
        raise InputError(
            f"{path}: the file is in {label(source.crs)}, and --crs is {label(crs)}. Leave --crs "
            "out; geosurf.reproject converts."
        )
    written = write(source.obj, target, name=options.name, crs=crs)
    lost = [*source.lost, *written.lost]
    if source.is_open:
        # the writer states a direction that nobody knows
        words = f"{path.name} does not state whether z is elevation or depth, nor its unit"
        lost = [one for one in lost if one.what not in ("direction", "unit")]
        lost.append(Loss("direction", f"{words}: values are as in the source."))
    return source, Written(written, lost)


def _refuse_unknown(target: Path, suffix: str) -> None:
    """Refuse a suffix that nothing is written to, with the nearest one and all others."""
    if target.is_dir():
        raise OutputError(f"{target}: this is a folder. Give the name of a file in it.")
    known = sorted({one for suffixes in WRITERS.values() for one in suffixes})
    if suffix not in known:
        raise OutputError(
            f"{target}: geosurf writes no files with the suffix {suffix!r}."
            f"{did_you_mean(suffix, known)} It writes {', '.join(known)}."
        )


def _read(path: Path, suffix: str, options: argparse.Namespace) -> Source:
    """Read a file by its content; z keeps the direction of the file where nobody states one."""
    key, functions = kind_of_file(path)
    source = Source(path, key, _function(path, functions, suffix, options.read_as))
    words = otherwise({"positive": options.positive or "up", "length_unit": options.length_unit})
    with collected() as notes:
        if key == "netcdf" and options.read_as is None:
            from geosurf.read.netcdf import holds_fault  # it loads xarray, too

            source.function = "read_fault" if holds_fault(path) else "read_horizon"
        if key == "resqml" and options.read_as is None:
            source.function = function_of(path, options.name, suffix in WRITERS["Units"])
        # which one, where a file has several; elsewhere the name of what is written
        several = (*MESH_FORMATS, "resqml", "netcdf", "zarr")
        named = source.function == "read_fault" or key in several
        if options.name is not None and named and source.function != "read_points":
            words["name"] = options.name
        words |= _of_table(source, options)
        module = read if hasattr(read, source.function) else geosurf
        source.obj = getattr(module, source.function)(path, **words)

    is_open = notes.get("sign", "").startswith("open")
    meshes = (*MESH_FORMATS, "pline", "vset", "model3d")  # elevations where they state nothing
    source.is_open = is_open and options.positive is None and key not in meshes
    if isinstance(source.obj, list) and not any(line[:, 2].any() for line in source.obj):
        source.is_open = False  # drawn on a map
    if source.is_open and suffix not in NO_DIRECTION:
        raise InputError(
            f"{path}: the file does not state whether z is elevation or depth, and {suffix} files "
            "do. Add --positive down for depth, or --positive up."
        )
    obj: Any = source.obj
    if is_open and options.positive == "down" and kind_of(obj) == "horizon (DataArray)":
        # a map of depths stays one, where the format lets it
        source.obj = (0.0 - obj).assign_attrs(obj.attrs | {"positive": "down"})
    _attributes(source)
    return source


def _of_table(source: Source, options: argparse.Namespace) -> dict[str, Any]:
    """Arguments of the reader on columns, decimal sign and heads, where it has them."""
    wells = source.function == "read_wells"
    arguments: dict[str, Any] = {}
    if options.columns is not None:
        words = [word.strip() for word in options.columns.split(",")]
        parts = [word.partition("=")[::2] if wells else ("", word) for word in words]
        if wells and not all(key and word for key, word in parts):
            raise InputError(
                f"{source.path}: --columns of wells are pairs, as in --columns md=DEPT,well=3; "
                f"found {options.columns!r}."
            )
        columns = [(key, int(word) if word.isdecimal() else word) for key, word in parts]
        arguments["columns"] = dict(columns) if wells else tuple(word for _, word in columns)
    if options.decimal is not None:
        arguments["decimal"] = options.decimal
    if options.heads is not None:
        arguments["heads"] = options.heads
    takes = {
        "columns": ("read_points", "read_polygons", "read_fault", "read_tops", "read_wells"),
        "decimal": ("read_points", "read_polygons", "read_fault", "read_tops", "read_wells"),
        "heads": ("read_wells",),
    }
    for key in arguments:
        if source.function not in takes[key]:
            raise InputError(
                f"{source.path}: --{key} has no effect on {source.function}. Leave it out, or add "
                f"--as {' or '.join(name.removeprefix('read_') for name in takes[key])}."
            )
    return arguments


def _function(path: Path, functions: str, suffix: str, read_as: str | None) -> str:
    """Return which function reads a file: the one asked for, or the one that fits the target."""
    if read_as is not None:
        return f"read_{read_as}"
    if not functions:
        raise InputError(
            f"{path}: geosurf does not know what this file holds. See geosurf info {path}, and add "
            "--as horizon, fault, points or polygons."
        )
    names = functions.split(" or ")
    if "read_polygons" in names and suffix not in WRITERS["list of lines"]:
        return "read_fault"
    return names[-1] if names[0] == "read_horizon" else names[0]


def _attributes(source: Source) -> None:
    """Names and numbers of lines and points: carried along where readers know them, else listed."""
    if source.key in ("geojson", "shapefile"):
        _features(source)
    elif source.key in ("xyz", "polygons") and source.path.suffix.lower() == ".csv":
        with source.path.open("rb") as file:
            n_column = len(SPLIT.split(file.readline()))
        if n_column > (3 if source.key == "xyz" else 4):
            words = f"{source.function} reads coordinates only: other columns were left out."
            source.lost.append(Loss("data", words))


def _features(source: Source) -> None:
    """Lines of GeoJSON and shapefiles with their attributes, and their reference system."""
    from geosurf.measure.section import ragged  # it loads xarray, which curves do without

    read = features(source.path)
    source.crs = read.crs
    items = [feature for feature in read.items if feature.kind != "point"]
    if source.function != "read_polygons" or len(items) != len(source.obj):
        return
    keys = list(dict.fromkeys(key for feature in items for key in feature.words))
    words: dict[str, tuple[list[Any], dict[str, str]]] = {
        key: ([feature.words.get(key) for feature in items], {}) for key in keys
    }
    axes = {axis: ("m", axis) for axis in COORDINATES}
    attrs = {} if read.crs is None else {"crs": read.crs}
    source.obj = ragged(source.obj, axes, words, attrs)


def _fit(source: Source, suffix: str, name: str | None) -> None:
    """Make a surface of what is none, where the target holds surfaces only."""
    kind = kind_of(source.obj)
    if kind is None or suffix in WRITERS[kind] or suffix not in WRITERS["TriSurface"]:
        return
    name = name or source.path.stem
    if kind == "horizon (DataArray)":
        source.obj = triangulate_horizon(source.obj, name=name)
        words = "rows, columns and steps of the grid are lost"
    elif kind == "FaultSticks":
        source.obj = triangulate_sticks(source.obj, name=name)
        words = "which points are one stick is lost"
    elif source.function == "read_fault":
        source.obj = triangulate_fault(source.obj, name=name)
        words = "rows and columns of the grid are lost"
    else:
        return
    n = source.obj.n_triangle
    source.lost.append(Loss("grid", f"The file holds {n} triangles: {words}."))
