"""Grids of CF conventions: NetCDF files and Zarr stores, and faults as parametric grids.

The file has ``positive`` and ``units`` on its elevation (or depth) variable, or
the caller does. Horizontal coordinates without ``units`` are metres.
"""

from __future__ import annotations

import math
import os
import warnings
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from geosurf.conventions import FAULT_DIMS, HORIZON_DIMS, counted, did_you_mean, is_word
from geosurf.conventions.axes import MAP_NAMES, map_coordinates
from geosurf.conventions.crs import crs_of
from geosurf.conventions.machine import need
from geosurf.errors import FormatError
from geosurf.lazy import h5py
from geosurf.read._common import Request, agreed_scale
from geosurf.read._guard import (
    COPIES,
    damaged,
    opened,
    reading_with,
    refuse_beyond_memory,
    refuse_bombs,
    refuse_empty,
    refuse_large,
    same_file,
)
from geosurf.read._placed import AXES

# ---- datasets ----------------------------------------
# Files and stores -> datasets: in memory, or as Dask arrays where a grid is large.


LARGE = 1 << 26  # values: smaller arrays are read when a file is opened, which takes half a GB
PART, LONG = 1000, 4000  # nodes along a side of what is read at once, and of a chunk in a file


def dataset_of_file(path: Path) -> xr.Dataset:
    """Return a NetCDF file in memory; grids of more than `LARGE` values as Dask arrays."""
    # the library opens the very file that was checked: the path may lead elsewhere by then
    with opened(path) as (file, size), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of attributes: what is wrong with them is an error below
        engine, name = _engine(path, file.read(4)), same_file(path, file)
        how: dict[str, Any] = {"engine": engine, "decode_times": False}
        stays = LARGE if find_spec("dask") else math.inf
        with reading_with(path, engine, name):
            if engine == "h5netcdf":
                with h5py.File(name, "r") as held:
                    # a damaged file fails here: h5netcdf would print as it fails
                    held.attrs.get("_nc3_strict")
                    how["drop_variables"] = refuse_bombs(path, held, size, stays)
            with xr.open_dataset(name, **how) as dataset:
                chunks = _chunks(dataset, stays)
                if not chunks:
                    values = sum(variable.size for variable in dataset.variables.values())
                    what = f"a dataset of {values} values"
                    refuse_large(path, 8 * COPIES * values, size, what)
                    return dataset.load()
            # by its path: it is read as long as the horizon is in use
            return xr.open_dataset(path, chunks=chunks, **how)


def dataset_of_store(path: Path) -> xr.Dataset:
    """Return a Zarr store in memory; with grids of more than `LARGE` values as Dask arrays."""
    need(f"{path}: this store needs", "zarr")
    with warnings.catch_warnings(), reading_with(path, "zarr"):
        warnings.simplefilter("ignore")  # of attributes, and of metadata that is not consolidated
        dataset = xr.open_zarr(path, decode_times=False, chunks=None)
        chunks = _chunks(dataset, LARGE)
        if chunks:
            need(f"{path}: grids of more than {LARGE} nodes need", "dask")
            _refuse_empty_arrays(path, dataset)
            return xr.open_zarr(path, decode_times=False, chunks=chunks)
        refuse_beyond_memory(path, 8 * sum(one.size for one in dataset.variables.values()))
        numbers = [key for key, one in dataset.variables.items() if one.dtype.kind in "fiub"]
        return dataset[numbers].load()


def _engine(path: Path, head: bytes) -> str:
    """Return the library for files that begin so, never by suffix: both kinds are called .nc."""
    if not head:
        raise damaged(f"{path}: the file is empty (0 bytes)")
    if head.startswith(b"\x89HDF"):
        need(f"{path}: NetCDF-4 needs", "h5netcdf", "h5py")  # h5netcdf comes without h5py
        return "h5netcdf"
    if head.startswith((b"CDF\x01", b"CDF\x02")):
        return "scipy"
    raise FormatError(
        f"{path}, byte 0: found {head!r}, expected the signature of NetCDF (CDF or HDF). "
        "Export it as NetCDF-4, or set format= to its format."
    )


def _chunks(dataset: xr.Dataset, stays: float) -> dict[Any, int]:
    """Chunks of large arrays along their dimensions: those of the file, unless very long."""
    chunks: dict[Any, int] = {}
    for variable in dataset.variables.values():
        if variable.size > stays:
            stored = variable.encoding.get("chunksizes") or variable.encoding.get("chunks")
            stored_chunks = dict(zip(variable.dims, stored or (), strict=False))
            for dim, n in variable.sizes.items():
                chunks[dim] = (
                    stored_chunks[dim] if 0 < stored_chunks.get(dim, 0) <= LONG else min(PART, n)
                )
    return chunks


def _refuse_empty_arrays(path: Path, dataset: xr.Dataset) -> None:
    """Refuse large arrays of which nearly no chunk is there."""
    for name, variable in dataset.variables.items():
        # a file for each chunk, or for each shard of several
        sizes = variable.encoding.get("shards") or variable.encoding.get("chunks")
        if variable.size > LARGE and sizes:
            parts = math.prod(-(-n // step) for n, step in zip(variable.shape, sizes, strict=True))
            files = (file for _, _, some in os.walk(path / str(name)) for file in some)
            stored = sum(file != "zarr.json" and not file.startswith(".z") for file in files)
            refuse_empty(path, str(name), variable.shape, stored, parts)


# ---- netcdf ----------------------------------------
# CF NetCDF: gridded horizons, and faults as parametric grids.
#
# The file has ``positive`` and ``units`` on its elevation (or depth) variable, or
# the caller does. Horizontal coordinates without ``units`` are metres.


ELEVATION = ("elevation", "depth", "z")


def read_netcdf_horizon(path: Path, request: Request) -> xr.DataArray:
    """
    Read a horizon from a NetCDF file.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Name of the horizon.
        `positive`: If the variable has no attribute ``positive``.
        `length_unit`: If the variable has no attribute ``units``.
        `variable`: Which variable, where several are gridded.

    Returns
    -------
    xarray.DataArray
        Elevation [m], positive up. 1-D coordinates are sorted to increase; 2-D ones
        give dims ``("row", "column")``. Grids of more than 2**26 nodes are opened, not read (Dask).

    Raises
    ------
    FormatError
        If the file is damaged, or has no gridded variable, or no coordinates.
    InputError
        If `positive` or `length_unit` is missing, unknown or contradicted.
    DependencyError
        If no NetCDF engine is installed.
    """
    return horizon_of(path, dataset_of_file(path), request)


def read_zarr_horizon(path: Path, request: Request) -> xr.DataArray:
    """
    Read a horizon from a Zarr store, whose variables and coordinates are those of NetCDF files.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        As for `read_netcdf_horizon`.

    Returns
    -------
    xarray.DataArray

    Raises
    ------
    FormatError, InputError, DependencyError
        As `read_netcdf_horizon`.
    """
    dataset = dataset_of_store(path)
    with reading_with(path, "zarr"):
        return horizon_of(path, dataset, request)


def horizon_of(path: Path, dataset: xr.Dataset, request: Request) -> xr.DataArray:
    """Return the horizon in a dataset; see `read_netcdf_horizon`. Dask arrays stay lazy."""
    data = _pick(path, dataset, request.variable, request.named(path))
    what = f"{path}: variable {data.name!r}"

    # direction and unit as the file states them, or the caller; both have to agree
    scale = _scale(data, what, request)

    # The dimension that runs north comes first; other dimensions of length 1 are dropped.
    easting, northing = (_coordinate(path, data, key) for key in MAP_NAMES)
    data = data.transpose(*_dims(path, data, easting, northing))

    kept = ("rotation", "xori", "yori", "xinc", "yinc", "ncol", "nrow")
    attrs = {key: data.attrs[key] for key in kept if key in data.attrs}
    attrs = {k: v.item() if isinstance(v, np.generic) else v for k, v in attrs.items()}
    attrs |= _crs(data, dataset)
    attrs |= {"units": "m", "positive": "up", "long_name": request.named(path), "source": path.name}
    values: Any = data.data
    if hasattr(values, "dask"):  # in a store: what is infinite is found when it is read
        values = values.astype(np.float64)
        values = values if scale == 1.0 else scale * values
    else:
        values = scale * _finite_or_nan(path, data) + 0.0
    return _horizon(path, values, _metres(path, easting), _metres(path, northing), attrs)


def read_netcdf_fault(path: Path, request: Request) -> xr.Dataset:
    """
    Read a fault given as a parametric grid.

    Parameters
    ----------
    path : pathlib.Path
        With ``easting``, ``northing`` and ``elevation`` (or ``depth``) over ``(down_dip,
        along_strike)``.
    request : Request
        `name`: Name of the fault.
        `positive`: If the elevation has no attribute ``positive``.
        `length_unit`: If the elevation has no attribute ``units``.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``("down_dip", "along_strike")``,
        metres, positive up.

    Raises
    ------
    FormatError
        If the file is damaged or a variable is missing.
    InputError
        If `positive` or `length_unit` is missing, unknown or contradicted.
    DependencyError
        If no NetCDF engine is installed.
    """
    dataset = dataset_of_file(path).reset_coords()

    # one variable for each of the three, over both dimensions of the fault
    axes = {}
    for key, spellings in zip(AXES, (*MAP_NAMES.values(), ELEVATION), strict=True):
        # exactly one variable with a known name, over both dimensions of the fault
        words = [str(word) for word in dataset.data_vars if str(word).lower() in spellings]
        if len(words) != 1 or set(dataset[words[0]].dims) != set(FAULT_DIMS):
            shape = {str(word): dataset[word].dims for word in dataset.data_vars}
            raise FormatError(
                f"{path}: expected one variable {key!r} with dims {FAULT_DIMS}, found {shape}. "
                "Rename variables and dimensions. If this is a gridded horizon, use read_horizon."
            )
        axes[key] = dataset[words[0]].transpose(*FAULT_DIMS)

    z = axes["elevation"]
    what = f"{path}: fault {request.named(path)!r}"
    scale = _scale(z, what, request)
    places = [
        _metres(path, axes["easting"]),
        _metres(path, axes["northing"]),
        scale * _finite_or_nan(path, z) + 0.0,
    ]
    data = {
        key: (FAULT_DIMS, place, dict(meaning))
        for (key, meaning), place in zip(AXES.items(), places, strict=True)
    }
    attrs = {"long_name": request.named(path), "source": path.name}
    return xr.Dataset(data, attrs=attrs | _crs(z, dataset) | _crs(dataset, dataset))


def holds_fault(path: Path) -> bool:
    """Return whether a NetCDF file holds a parametric grid and not a horizon."""
    return set(FAULT_DIMS) <= {str(dim) for dim in dataset_of_file(path).dims}


def _pick(path: Path, dataset: xr.Dataset, variable: str | None, name: str) -> xr.DataArray:
    """Return the gridded variable; of several the one with the name of the horizon, or an error."""
    grids = {}
    for key, data in dataset.data_vars.items():
        # a time or layer of length 1 may come along; a grid may have one row
        grid = data if data.ndim == 2 else data.squeeze(drop=True)
        if grid.ndim == 2 and grid.dtype.kind in "fiu":
            grids[str(key)] = grid

    # A single grid needs no name.
    if variable is None and len(grids) == 1:
        return next(iter(grids.values()))
    wanted = name if variable is None else variable
    if is_word(wanted, grids):
        return grids[str(wanted)]

    # none, or several and no choice: list them, with the nearest name
    asked = "" if variable is None else f" {variable!r} is not one of them."
    guess = "" if variable is None else did_you_mean(variable, grids)
    is_fault = set(FAULT_DIMS) <= {str(dim) for dim in dataset.dims}
    remedy = "Select one with variable= or name=; geosurf convert takes --name."
    if is_fault:
        remedy = "If this is a fault, use read_fault."
    elif not grids:
        remedy = "Export a grid of elevations over easting and northing."
    raise FormatError(
        f"{path}: found {counted(len(grids), 'variable')} on a two-dimensional grid, "
        f"{list(grids)}.{asked}{guess} {remedy}"
    )


def _coordinate(path: Path, data: xr.DataArray, key: str) -> xr.DataArray:
    """Return the coordinate that is easting, or northing, by its name or attributes."""
    matching: list[xr.DataArray] = map_coordinates(data)[key]
    if len(matching) != 1 or matching[0].ndim not in (1, 2):
        raise FormatError(
            f"{path}: variable {data.name!r} has {len(matching)} coordinates called one of "
            f"{', '.join(MAP_NAMES[key])} among {list(data.coords)}, expected 1. "
            "Rename or add the coordinate."
        )
    return matching[0]


def _dims(
    path: Path, data: xr.DataArray, easting: xr.DataArray, northing: xr.DataArray
) -> tuple[Any, ...]:
    """Return the dimensions of `data`, the one that runs north first."""
    # each coordinate along its own dimension, or both over both: a rotated grid
    if easting.ndim == northing.ndim == 1 and {*northing.dims, *easting.dims} == set(data.dims):
        return (northing.dims[0], easting.dims[0])
    if easting.ndim == northing.ndim == 2 and easting.dims == northing.dims == data.dims:
        return data.dims
    raise FormatError(
        f"{path}: variable {data.name!r} has dims {data.dims}, easting {easting.dims}, northing "
        f"{northing.dims}; expected one 1-D coordinate per dimension, or both 2-D like the "
        "variable. Store the coordinates along the dimensions of the grid."
    )


def _horizon(
    path: Path, values: Any, easting: Any, northing: Any, attrs: dict[str, Any]
) -> xr.DataArray:
    """Assemble the DataArray; 1-D coordinates are sorted to increase."""
    places, dims = {"northing": northing, "easting": easting}, HORIZON_DIMS
    if easting.ndim == 2:  # a rotated grid has places for each node, and no order of axes to turn
        places, dims = {"easting": easting, "northing": northing}, ("row", "column")
    else:
        for axis, (key, coordinate) in enumerate(places.items()):
            step = np.diff(coordinate)
            if not ((step > 0).all() or (step < 0).all()):
                at = int(np.flatnonzero(np.sign(step) != np.sign(step[0]))[:1].sum())
                raise FormatError(
                    f"{path}: {key} is not monotonic: {coordinate[at + 1]} follows "
                    f"{coordinate[at]} at position {at}. Sort the grid."
                )
            if len(step) and step[0] < 0:
                values = values[::-1] if axis == 0 else values[:, ::-1]
            places[key] = np.sort(coordinate)
        values = values if hasattr(values, "dask") else np.ascontiguousarray(values)
    coords = {
        key: (dims if place.ndim == 2 else key, place, {"units": "m"})
        for key, place in places.items()
    }
    return xr.DataArray(values, dims=dims, coords=coords, name=attrs["long_name"], attrs=attrs)


def _metres(path: Path, coordinate: xr.DataArray) -> Any:
    """Coordinate values in metres, float64, finite; rotated grids in a store stay there."""
    what = f"{path}: coordinate {coordinate.name!r}"
    data: Any = coordinate.data
    if coordinate.ndim == 2 and hasattr(data, "dask"):  # what is not finite is found in the pass
        scale = agreed_scale(_attribute(coordinate, "units"), None, "m", what)
        return data.astype(np.float64) if scale == 1.0 else data.astype(np.float64) * scale
    values = coordinate.values.astype(np.float64)
    if not np.isfinite(values).all():
        raise FormatError(
            f"{what} has {int((~np.isfinite(values)).sum())} values that are not finite. Give "
            "every node a position."
        )
    return values * agreed_scale(_attribute(coordinate, "units"), None, "m", what)


def _crs(data: Any, dataset: xr.Dataset) -> dict[str, str]:
    """The coordinate reference system, from wherever the file declares it."""
    crs = crs_of(data, dataset.variables)
    return {} if crs is None else {"crs": crs}


def _scale(data: xr.DataArray, what: str, request: Request) -> float:
    """Metres of elevation per unit, by the attributes or the caller, who have to agree."""
    stated = {"positive": _attribute(data, "positive"), "unit": _attribute(data, "units")}
    return request.scale(what, **stated, default=None)


def _attribute(data: xr.DataArray, key: str) -> str | None:
    """Return an attribute as a word, whatever it is."""
    word = data.attrs.get(key)
    return None if word is None else str(word)


def _finite_or_nan(path: Path, data: xr.DataArray) -> np.ndarray:
    """Values as float64; infinite ones are refused."""
    values: np.ndarray = data.values.astype(np.float64)

    # infinite values stand for no-data in some programs: declared ones are NaN by now
    bad = np.argwhere(np.isinf(values))
    if len(bad):
        raise FormatError(
            f"{path}: variable {data.name!r} is infinite at node {bad[0].tolist()}. Missing "
            "nodes must be NaN: declare the value as _FillValue."
        )
    return values
