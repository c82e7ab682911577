"""Zarr stores: gridded horizons in folders; large ones are opened, and read when needed.

What a variable and its coordinates have to be is the same as in NetCDF files.
"""

from __future__ import annotations

import math
import os
import warnings
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.errors import DependencyError, FormatError
from geosurf.read._common import Request
from geosurf.read._guard import refuse_beyond_memory
from geosurf.read._hdf5 import refuse_empty
from geosurf.read._in_parts import LARGE, chunks_of
from geosurf.read._netcdf_file import DAMAGE
from geosurf.read.netcdf import horizon_of

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr


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
