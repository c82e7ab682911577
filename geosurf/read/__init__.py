"""Files -> xarray horizons, fault surfaces, points, polygons.

The content of a file picks the reader, or `format=` does; where the content is open, as in
tables of numbers, the suffix does. Each reader is imported when it is first needed. Every result
is in metres, elevation positive up.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from geosurf.conventions.checks import no_data_in
from geosurf.errors import FormatError
from geosurf.lazy import lazily
from geosurf.lazy import xarray as xr
from geosurf.model.expected import name_of
from geosurf.read._common import Request, otherwise
from geosurf.read._guard import damaged
from geosurf.read.registry import (
    FAULT_FORMATS,
    GRID_FORMATS,
    HORIZON_FORMATS,
    MESH_FORMATS,
    POINT_FORMATS,
    POLYGON_FORMATS,
    reader_of,
    refuse_columns,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    import numpy as np

    from geosurf.model import FaultSticks, TriSurface
    from geosurf.read.tops import read_tops as read_tops
    from geosurf.read.wells import read_wells as read_wells
else:
    __getattr__, _ = lazily(__name__)

__all__ = [
    "FAULT_FORMATS",
    "GRID_FORMATS",
    "HORIZON_FORMATS",
    "MESH_FORMATS",
    "POINT_FORMATS",
    "POLYGON_FORMATS",
    "otherwise",
    "read_fault",
    "read_horizon",
    "read_points",
    "read_polygons",
    "read_tops",
    "read_tsurf",
    "read_wells",
]


def read_horizon(
    path: str | PathLike[str],
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
    format: str | None = None,  # noqa: A002 - the word users know
    variable: str | None = None,
) -> xr.DataArray | TriSurface:
    r"""
    Read a horizon: a grid, or a triangulated surface.

    Parameters
    ----------
    path : path-like
        Recognised by content, whatever the suffix: IRAP classic and binary, CF NetCDF, Zarr, ZMAP+,
        CPS-3, Surfer 6 and 7, STORM, ESRI text, GXF, EarthVision, IJXYZ; GOCAD TSurf, RESQML,
        ``.vtp``. Other triangle meshes by their suffix.
    name : str, optional
        Name of the horizon; for a file with several surfaces: which one. Default: the file
        name without suffix; for meshes the name in the file, if it has one.
    positive : {"up", "down"}, optional
        Whether values are elevations or depths, if the file does not state it; meshes are
        elevations by default.
    length_unit : str, optional
        Unit of the values, if the file does not state it: ``"m"``, ``"ft"`` ...
        Default metres for IRAP and ZMAP+, which have no place for it. Horizontal
        coordinates are not scaled by it.
    format : str, optional
        ``"irap"``, ``"netcdf"``, ``"zarr"``, ``"zmap"``, ``"cps3"``, ``"surfer"``, ``"storm"``,
        ``"esri"``, ``"gxf"``, ``"earthvision"``, ``"ijxyz"``, ``"tsurf"``, ``"resqml"``,
        ``"vtp"`` or ``"mesh"``.
        Overrides content and suffix.
    variable : str, optional
        Which variable of a NetCDF file or Zarr store, where there are several. Default: the one
        with the name of the horizon.

    Returns
    -------
    xarray.DataArray
        Elevation [m], positive up, float64, NaN where absent; ``attrs`` hold ``units``,
        ``positive``, ``long_name``, ``source`` (file name). Unrotated: dims
        ``("northing", "easting")``, both increasing. Rotated: dims ``("row", "column")``
        with 2-D coordinates ``easting`` and ``northing``; columns, rows and up
        are right-handed. Regular grids also carry ``rotation`` (degrees
        counter-clockwise from east), ``xori``, ``yori``, ``xinc``, ``yinc``, ``ncol``, ``nrow``.
        A `TriSurface` (role ``"horizon"``) for meshes.

    Raises
    ------
    FormatError
        If the suffix is unknown, or the file is not what it should be: path,
        line or byte, found, expected.
    InputError
        If the file cannot be opened, if `positive` or `length_unit` is missing, or file and
        argument disagree.
    DependencyError
        If NetCDF support is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.irap"
    >>> header = "-996 2 10 10\n500 510 0 10\n2 0 500 0\n0 0 0 0 0 0 0\n"
    >>> _ = file.write_text(header + "1600 1610\n1605 9999900.0\n")
    >>> top = read_horizon(file, positive="down")
    >>> top.dims, top.easting.values.tolist(), top.values.tolist()
    (('northing', 'easting'), [500.0, 510.0], [[-1600.0, -1610.0], [-1605.0, nan]])
    """
    path, key, read = reader_of(path, HORIZON_FORMATS, format, "read_horizon")

    # only NetCDF and Zarr hold several variables; elsewhere the argument would have no effect
    several = ("netcdf", "zarr")
    if variable is not None and key not in several:
        raise FormatError(
            f"{path}: variable={variable!r} selects a variable of a NetCDF file or Zarr store, "
            f"but this file is {key}. Leave variable= out."
        )
    name = None if name is None else name_of(name, "horizon") or None
    found = read(path, Request(name, positive, length_unit, variable=variable))
    # mesh readers call all surfaces faults: here it is a horizon
    return found.renamed(found.name, "horizon") if key in MESH_FORMATS else found


def read_fault(
    path: str | PathLike[str],
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
    format: str | None = None,  # noqa: A002 - the word users know
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> TriSurface | FaultSticks | xr.Dataset:
    r"""
    Read a fault: a triangulated surface, sticks, or a parametric grid.

    Parameters
    ----------
    path : path-like
        ``.ts`` (GOCAD TSurf), ``.vtp`` and other triangle meshes, ``.pol`` and ``.csv`` (fault
        sticks), ``.nc`` (parametric grid).
    name : str, optional
        Name of the fault; for a file with several surfaces or faults: which one.
        Default: the name in the file, else the file name without suffix.
    positive : {"up", "down"}, optional
        Whether z is elevation or depth, if the file does not state it. Required
        for sticks; TSurf and meshes are elevations by default.
    length_unit : str, optional
        Unit of elevations, where the file does not declare it. Default metres, but required for
        NetCDF. Easting and northing are metres unless the file declares another unit for them.
    format : {"tsurf", "sticks", "netcdf", "charisma", "geojson", "vtp", "mesh" ...}, optional
        Overrides content and suffix.
    columns, decimal : optional
        Of sticks: which columns x, y and z are, and the decimal sign, as in `read_points`. A fourth
        column has the number of the stick, a fifth the name of the fault: ``(4, 5, 6, 8, 7)``.

    Returns
    -------
    TriSurface, FaultSticks or xarray.Dataset
        A `TriSurface` (role ``"fault"``) for meshes. `FaultSticks` for sticks: join
        them with `triangulate_sticks`. A Dataset ``easting``, ``northing``, ``elevation`` over
        ``(down_dip, along_strike)`` for ``.nc``: hand it to `triangulate_fault`.

    Raises
    ------
    FormatError
        If the suffix is unknown, or the file is not what it should be: path,
        line or byte, found, expected.
    InputError
        If the file cannot be opened, has several surfaces, does not state `positive`
        where it must be known, or contradicts the arguments.
    DependencyError
        If NetCDF support is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "F1.pol"
    >>> _ = file.write_text("0 0 1500\n0 50 1600\n999 999 999\n")
    >>> read_fault(file, positive="down")
    <FaultSticks 'F1': 1 sticks, 2 points>
    """
    path, key, read = reader_of(path, FAULT_FORMATS, format, "read_fault")
    if name is not None:
        name = name_of(name, "fault")
    refuse_columns(path, key, columns, decimal)
    return read(path, Request(name, positive, length_unit, columns, decimal))


def read_tsurf(
    path: str | PathLike[str], *, positive: str | None = None, length_unit: str | None = None
) -> list[TriSurface]:
    r"""
    Read all triangulated surfaces of a GOCAD file.

    Parameters
    ----------
    path : path-like
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    list of TriSurface
        In file order, role ``"fault"``, metres, elevation positive up.

    Raises
    ------
    FormatError
        If the file has no TSurf, is cut short, or a line cannot be understood.
    InputError
        If `positive` or `length_unit` contradicts the file or is unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "two.ts"
    >>> body = "TFACE\nVRTX 1 0 0 0\nVRTX 2 9 0 0\nVRTX 3 0 9 9\nTRGL 1 2 3\nEND\n"
    >>> one = "GOCAD TSurf 1\n" + body
    >>> _ = file.write_text(one + one)
    >>> len(read_tsurf(file))
    2
    """
    from geosurf.read import gocad

    return gocad.read_tsurf(Path(path), Request(None, positive, length_unit))


def read_points(
    path: str | PathLike[str],
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    format: str | None = None,  # noqa: A002 - the word users know
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> xr.Dataset:
    r"""
    Read scattered points.

    Parameters
    ----------
    path : path-like
        ``.poi``, ``.xyz``, ``.txt``, ``.dat``: x, y, z are the only numbers on each line, or
        there is a header, or `columns` names them. A last line ``999 999 999`` ends the points.
        ``.csv``: a header with the columns ``X_UTME,Y_UTMN,Z_TVDSS`` or ``X,Y,Z`` among others.
    positive : {"up", "down"}
        Whether z is elevation or depth; the formats do not state it.
    length_unit : str, optional
        Unit of z. Default ``"m"``.
    format : {"xyz"}, optional
        Overrides the suffix.
    columns : sequence of str or of int, optional
        Names of easting, northing and z in the header, or numbers of their columns, counted
        from 1: ``(3, 4, 5)`` for files with inline and crossline first.
    decimal : {".", ","}, optional
        Decimal sign of the file; with ``","``, values are separated by blanks or semicolons.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point`` [m], positive up; ``well`` and
        ``md`` where a header names them. Paths of wells: `read_wells`.

    Raises
    ------
    FormatError
        If the suffix is unknown, a line is not three numbers, which columns are coordinates
        is unclear, or a column is missing.
    InputError
        If the file cannot be opened, or `positive` is missing.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "picks.csv"
    >>> _ = file.write_text("X,Y,TVDSS,formation\n1,2,30,Fault\n")
    >>> read_points(file, positive="down", columns=("X", "Y", "TVDSS")).elevation.values
    array([-30.])
    >>> file = file.with_suffix(".dat")
    >>> _ = file.write_text("815 1210 777574.2 6736507.8 1000.0\n")
    >>> read_points(file, positive="down", columns=(3, 4, 5)).easting.values
    array([777574.2])
    """
    path, key, read = reader_of(path, POINT_FORMATS, format, "read_points")
    refuse_columns(path, key, columns, decimal)
    return read(path, Request(None, positive, length_unit, columns, decimal))


def read_polygons(
    path: str | PathLike[str],
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    format: str | None = None,  # noqa: A002 - the word users know
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
    name: str | None = None,
) -> list[np.ndarray]:
    r"""
    Read polygons or polylines: outlines, fault polygons.

    Parameters
    ----------
    path : path-like
        ``.pol``, ``.txt``: x, y, z per line, each polygon ended by ``999 999 999``. ``.csv``:
        with a column ``POLY_ID``.
    positive : {"up", "down"}, optional
        Whether z is elevation or depth; may be left out where all z are 0.
    length_unit : str, optional
        Unit of z. Default ``"m"``.
    format : {"polygons"}, optional
        Overrides the suffix.
    columns, decimal : optional
        Which columns x, y and z are, and the decimal sign, as in `read_points`.
    name : str, optional
        Only the lines of this name, where the file names them. Default: all lines.

    Returns
    -------
    list of ndarray of float64, each (n, 3)
        Easting, northing, elevation [m]. A closed polygon repeats its first point
        if the file does.

    Raises
    ------
    FormatError
        If the suffix is unknown, a line is not three numbers, or the last
        polygon is not ended.
    InputError
        If the file cannot be opened, or `positive` is missing.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "outline.pol"
    >>> _ = file.write_text("0 0 0\n9 0 0\n9 9 0\n999 999 999\n")
    >>> read_polygons(file)[0].shape
    (3, 3)
    """
    path, key, read = reader_of(path, POLYGON_FORMATS, format, "read_polygons")
    refuse_columns(path, key, columns, decimal)
    if name is not None:
        name = name_of(name, "line")
    lines: list[np.ndarray] = read(path, Request(name, positive, length_unit, columns, decimal))
    for k, line in enumerate(lines, 1):
        if absent := no_data_in(line):
            raise damaged(
                f"{path}: point {absent[0] + 1} of line {k} has {absent[1]:g}, a usual mark of no "
                "data"
            )
    return lines
