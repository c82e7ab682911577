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
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import FAULT_DIMS, HORIZON_DIMS, counted, did_you_mean, is_word
from geosurf.conventions.crs import crs_of
from geosurf.errors import DependencyError, FormatError
from geosurf.read._common import Request, agreed_scale
from geosurf.read._guard import refuse_beyond_memory
from geosurf.read._netcdf_file import DAMAGE, LARGE, chunks_of, in_parts, load, refuse_empty

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr


# ---- zarr store ----------------------------------------
# Zarr stores: gridded horizons in folders; large ones are opened, and read when needed.
#
# What a variable and its coordinates have to be is the same as in NetCDF files.


def read_zarr_horizon(path: Path, request: Request) -> xr.DataArray:
    """
    Read a horizon from a Zarr store.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`, `positive`, `length_unit`, `variable`: As for
        `geosurf.read.netcdf.read_netcdf_horizon`.

    Returns
    -------
    xarray.DataArray
        Elevation [m], positive up. Grids of more than 2**26 nodes are opened, not read (Dask).

    Raises
    ------
    FormatError
        If the store is damaged, or has no gridded variable, or no coordinates.
    InputError
        If `positive` or `length_unit` is missing, unknown or contradicted.
    DependencyError
        If Zarr is not installed, or Dask where grids are not read.
    """
    dataset = _opened(path)
    try:
        return horizon_of(path, dataset, request)
    except DAMAGE as error:
        if isinstance(error, FormatError):
            raise
        raise _damaged(path, error) from error


def _opened(path: Path) -> xr.Dataset:
    """The dataset in a store; grids that are large as Dask arrays, others in memory."""
    import xarray as xr

    if find_spec("zarr") is None:
        raise DependencyError(
            f"{path}: reading this store needs zarr. Install it with: "
            "pip install 'geosurf[ensemble]'"
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of attributes, and of metadata that is not consolidated
        try:
            how: dict[str, Any] = {"decode_times": False, "chunks": None}
            dataset = xr.open_zarr(path, **how)
            large = [one for one in dataset.variables.values() if one.size > LARGE]
            if large and find_spec("dask") is None:
                raise DependencyError(
                    f"{path}: grids of more than {LARGE} nodes are read with dask. Install it "
                    "with: pip install 'geosurf[ensemble]'"
                )
            if large:
                _refuse_empty_arrays(path, dataset)
                chunks = {dim: n for one in large for dim, n in chunks_of(one).items()}
                return xr.open_zarr(path, **{**how, "chunks": chunks})
            refuse_beyond_memory(path, 8 * sum(one.size for one in dataset.variables.values()))
            numbers = [key for key, one in dataset.variables.items() if one.dtype.kind in "fiub"]
            found: xr.Dataset = dataset[numbers].load()
        except DAMAGE as error:
            if isinstance(error, FormatError):
                raise
            raise _damaged(path, error) from error
    return found


def _refuse_empty_arrays(path: Path, dataset: xr.Dataset) -> None:
    """Refuse large arrays of which nearly no chunk is there."""
    for name, one in dataset.variables.items():
        # a file for each chunk, or for each shard of several
        sizes = one.encoding.get("shards") or one.encoding.get("chunks")
        if one.size > LARGE and sizes:
            parts = math.prod(-(-n // step) for n, step in zip(one.shape, sizes, strict=True))
            files = (file for _, _, some in os.walk(path / str(name)) for file in some)
            stored = sum(file != "zarr.json" and not file.startswith(".z") for file in files)
            refuse_empty(path, str(name), one.shape, stored, parts)


def _damaged(path: Path, error: BaseException) -> FormatError:
    return FormatError(
        f"{path}: zarr cannot read it ({type(error).__name__}: {str(error)[:300]}). The store is "
        "damaged or incomplete; export it again."
    )


# ---- netcdf ----------------------------------------
# CF NetCDF: gridded horizons, and faults as parametric grids.
#
# The file has ``positive`` and ``units`` on its elevation (or depth) variable, or
# the caller does. Horizontal coordinates without ``units`` are metres.


EASTING = ("easting", "x", "e", "utm_easting", "projection_x_coordinate")
NORTHING = ("northing", "y", "n", "utm_northing", "projection_y_coordinate")
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
    dataset = in_parts(path)
    return horizon_of(path, load(path) if dataset is None else dataset, request)


def horizon_of(path: Path, dataset: xr.Dataset, request: Request) -> xr.DataArray:
    """Return the horizon in a dataset; see `read_netcdf_horizon`. Dask arrays stay lazy."""
    data = _pick(path, dataset, request.variable, request.named(path))
    what = f"{path}: variable {data.name!r}"

    # direction and unit as the file states them, or the caller; both have to agree
    stated = {"positive": _attribute(data, "positive"), "unit": _attribute(data, "units")}
    scale = request.scale(what, **stated, default=None)

    # The dimension that runs north comes first; other dimensions of length 1 are dropped.
    easting = _coordinate(path, data, EASTING)
    northing = _coordinate(path, data, NORTHING)
    data = data.transpose(*_dims(path, data, easting, northing))

    kept = ("rotation", "xori", "yori", "xinc", "yinc", "ncol", "nrow")
    attrs = {key: _plain(data.attrs[key]) for key in kept if key in data.attrs}
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
    import xarray as xr

    dataset = load(path).reset_coords()

    # one variable for each of the three, over both dimensions of the fault
    found = {}
    for key, spellings in (
        ("easting", EASTING),
        ("northing", NORTHING),
        ("elevation", ELEVATION),
    ):
        # exactly one variable with a known name, over both dimensions of the fault
        words = [str(word) for word in dataset.data_vars if str(word).lower() in spellings]
        if len(words) != 1 or set(dataset[words[0]].dims) != set(FAULT_DIMS):
            shape = {str(word): dataset[word].dims for word in dataset.data_vars}
            raise FormatError(
                f"{path}: expected one variable {key!r} with dims {FAULT_DIMS}, found {shape}. "
                "Rename variables and dimensions. If this is a gridded horizon, use "
                "read_horizon."
            )
        found[key] = dataset[words[0]].transpose(*FAULT_DIMS)

    z = found["elevation"]
    what = f"{path}: fault {request.named(path)!r}"
    stated = {"positive": _attribute(z, "positive"), "unit": _attribute(z, "units")}
    scale = request.scale(what, **stated, default=None)
    arrays = {
        "easting": _metres(path, found["easting"]),
        "northing": _metres(path, found["northing"]),
        "elevation": scale * _finite_or_nan(path, z) + 0.0,
    }
    out = xr.Dataset(
        {key: (FAULT_DIMS, value, {"units": "m"}) for key, value in arrays.items()},
        attrs={
            "long_name": request.named(path),
            "source": path.name,
            **_crs(z, dataset),
            **_crs(dataset, dataset),
        },
    )
    out["elevation"].attrs["positive"] = "up"
    return out


def holds_fault(path: Path) -> bool:
    """Return whether a NetCDF file holds a parametric grid and not a horizon."""
    dataset = in_parts(path)
    return set(FAULT_DIMS) <= {
        str(dim) for dim in (load(path) if dataset is None else dataset).dims
    }


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


def _coordinate(path: Path, data: xr.DataArray, spellings: tuple[str, ...]) -> xr.DataArray:
    """Return the coordinate whose name or standard_name is one of `spellings`."""
    # by name, or by the standard_name of the CF conventions
    found = [
        coordinate
        for key, coordinate in data.coords.items()
        if str(key).lower() in spellings or _attribute(coordinate, "standard_name") in spellings
    ]
    if len(found) != 1 or found[0].ndim not in (1, 2):
        raise FormatError(
            f"{path}: variable {data.name!r} has {len(found)} coordinates called one of "
            f"{', '.join(spellings)} among {list(data.coords)}, expected 1. "
            "Rename or add the coordinate."
        )
    return found[0]


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
    import xarray as xr

    metre = {"units": "m"}

    # a rotated grid has places for each node, and no order of axes to turn
    if easting.ndim == 2:
        coords = {
            "easting": (("row", "column"), easting, metre),
            "northing": (("row", "column"), northing, metre),
        }
        return xr.DataArray(
            values, dims=("row", "column"), coords=coords, name=attrs["long_name"], attrs=attrs
        )
    # Both axes are made to increase; values follow.
    for axis, (key, coordinate) in enumerate((("northing", northing), ("easting", easting))):
        step = np.diff(coordinate)
        if not ((step > 0).all() or (step < 0).all()):
            at = int(np.flatnonzero(np.sign(step) != np.sign(step[0]))[:1].sum())
            raise FormatError(
                f"{path}: {key} is not monotonic: {coordinate[at + 1]} follows "
                f"{coordinate[at]} at position {at}. Sort the grid."
            )
        if len(step) and step[0] < 0:
            values = values[::-1] if axis == 0 else values[:, ::-1]
    return xr.DataArray(
        values if hasattr(values, "dask") else np.ascontiguousarray(values),
        dims=HORIZON_DIMS,
        coords={
            "northing": ("northing", np.sort(northing), metre),
            "easting": ("easting", np.sort(easting), metre),
        },
        name=attrs["long_name"],
        attrs=attrs,
    )


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


def _plain(value: Any) -> Any:
    """Numpy scalars as Python ones."""
    return value.item() if isinstance(value, np.generic) else value
