"""Zarr stores: block models, as the NetCDF file of the same dataset has them.

Format 2, with consolidated metadata: `xarray.open_zarr` and older programs read it. The store is
made in memory; its files then replace those of an older one together.
"""

from __future__ import annotations

import json
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from geosurf.conventions.crs import crs_of
from geosurf.conventions.packages import need
from geosurf.errors import OutputError
from geosurf.write.netcdf import with_cf_words
from geosurf.write.vti import AXES

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

    from geosurf.write.written import Loss

INDEX = ".zmetadata"  # names all arrays of the store
OF_GROUP = {INDEX, ".zgroup", ".zattrs"}
OF_ARRAY = {".zarray", ".zattrs"}


def zarr_of_grid(
    dataset: xr.Dataset, name: str | None
) -> tuple[dict[PurePosixPath, bytes], list[Loss]]:
    """Return the files of a store, by path in it; cells are named, or numbered with `names`."""
    need("Writing Zarr needs", "zarr")
    store: dict[str, Any] = {}
    whole = with_cf_words(dataset, crs_of(dataset), lists=True)
    try:
        whole.to_zarr(store, mode="w", zarr_format=2, consolidated=True)
    except (TypeError, ValueError) as error:
        raise OutputError(
            f"dataset: Zarr cannot hold it ({type(error).__name__}: {error}). Drop or convert "
            "that variable."
        ) from error
    return {PurePosixPath(key): data.to_bytes() for key, data in sorted(store.items())}, []


def is_block_model(folder: Path) -> bool:
    """
    Whether a folder holds a block model as `zarr_of_grid` makes it, and no other file.

    Only such a folder may be replaced: not an ensemble, other stores, or notes of a user.

    Parameters
    ----------
    folder : pathlib.Path

    Raises
    ------
    OSError
        If it cannot be looked at.
    """
    try:
        listed = json.loads((folder / INDEX).read_text(encoding="utf-8"))["metadata"]
        arrays = {str(key).removesuffix("/.zarray") for key in listed if key.endswith("/.zarray")}
    except (FileNotFoundError, NotADirectoryError):
        return False
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return False
    if not arrays.issuperset(AXES):
        return False
    # a chunk is named by its place along each axis: 0.3.1
    for path in folder.iterdir():
        if path.is_symlink() or (path.is_dir() and path.name not in arrays):
            return False
        if path.is_dir():
            inner = [one for one in path.iterdir() if one.name not in OF_ARRAY]
            if not all(one.is_file() and one.name.replace(".", "0").isdecimal() for one in inner):
                return False
        elif path.name not in OF_GROUP:
            return False
    return True


__all__ = ["is_block_model", "zarr_of_grid"]
