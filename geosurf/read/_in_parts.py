"""NetCDF files with grids that are too large to be loaded: opened as Dask arrays."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.read._hdf5 import refuse_bombs

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

LARGE = 1 << 26  # values: smaller arrays are read when a file is opened, which takes half a GB
PART, LONG = 1000, 4000  # nodes along a side of what is read at once, and of a chunk in a file


def opened_in_parts(path: Path, engine: str, name: str, size: int) -> xr.Dataset | None:
    """
    Return a file with a large grid as Dask arrays, or None if it has none.

    Parameters
    ----------
    path : pathlib.Path
    engine : str
        The library that reads it.
    name : str
        Opens the file that was checked; `path` opens it while its values are in use.
    size : int
        Bytes of the file.
    """
    import xarray as xr

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        texts: list[str] = []
        if engine == "h5netcdf":
            import h5py

            with h5py.File(name, "r") as found:
                if not any(getattr(one, "size", 0) > LARGE for one in found.values()):
                    return None
                texts = refuse_bombs(path, found, size, LARGE)
        how: dict[str, Any] = {
            "engine": engine, "decode_times": False, "drop_variables": texts
        }  # fmt: skip
        with xr.open_dataset(name, **how) as dataset:
            large = [one for one in dataset.variables.values() if one.size > LARGE]
            if not large:
                return None
            chunks = {dim: n for one in large for dim, n in chunks_of(one).items()}

        # by its path: it is read as long as the horizon is in use
        return xr.open_dataset(path, chunks=chunks, **how)


def chunks_of(variable: xr.Variable) -> dict[Any, int]:
    """Return chunks of a variable along its dimensions: those of its store, unless very long."""
    stored = variable.encoding.get("chunksizes") or variable.encoding.get("chunks")
    own = dict(zip(variable.dims, stored or (), strict=False))
    return {
        dim: own[dim] if 0 < own.get(dim, 0) <= LONG else min(PART, n)
        for dim, n in variable.sizes.items()
    }
