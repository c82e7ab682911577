"""CF NetCDF, through xarray: horizons, fault grids, tables of units.

The coordinate reference system is the attribute ``crs``, and for other programs the grid mapping
``spatial_ref``, as rioxarray and GDAL have it.
"""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import elevation_sign, metres_per_unit
from geosurf.conventions.crs import crs_of, epsg_of
from geosurf.conventions.packages import need
from geosurf.errors import DependencyError, OutputError
from geosurf.stopping import temporary_folder
from geosurf.write.table import TABLE_ONLY
from geosurf.write.text_grids import refuse_odd_nodes
from geosurf.write.vtp import AXES

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

    from geosurf.model import Units
    from geosurf.write.written import Loss


# ---- zarr ----------------------------------------
# Zarr stores: block models, as the NetCDF file of the same dataset has them.
#
# Format 2, with consolidated metadata: `xarray.open_zarr` and older programs read it. The store is
# made in memory; its files then replace those of an older one together.


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


MAPPING = "spatial_ref"  # the name that rioxarray looks for
STANDARD_NAMES = {"easting": "projection_x_coordinate", "northing": "projection_y_coordinate"}


def netcdf_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes, list[Loss]]:
    """Return a horizon as one variable ``elevation`` (or ``depth``) with CF attributes."""
    # The name of the variable says what is positive, as CF readers expect.
    what = f"horizon {name!r}"
    sign = elevation_sign(horizon.attrs.get("positive"), what)
    metres_per_unit(horizon.attrs.get("units"), what)
    key = "elevation" if sign > 0 else "depth"

    refuse_odd_nodes(horizon, name)
    data = horizon.rename(key)
    data.attrs = dict(horizon.attrs) | {"long_name": name}
    if (crs := crs_of(horizon)) is not None:
        data.attrs["crs"] = crs
    data.attrs["standard_name"] = "height_above_mean_sea_level" if sign > 0 else "depth"
    return _bytes(data.to_dataset(), what, crs)


def netcdf_of_units(units: Units, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return the table of units; names are stored as strings."""
    _need_h5netcdf("table of units")
    data, losses = _bytes(units.table, "table of units", units.crs)
    return data, [TABLE_ONLY, *losses]


def netcdf_of_dataset(dataset: xr.Dataset, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return any dataset, such as a table or a parametric fault."""
    return _bytes(dataset, "dataset", crs_of(dataset))


def _bytes(dataset: xr.Dataset, what: str, crs: str | None = None) -> tuple[bytes, list[Loss]]:
    """Return NetCDF-4 bytes; attributes that it cannot hold become text."""
    _need_h5netcdf(what)
    dataset = with_cf_words(dataset, crs)
    # h5netcdf writes to a path; the bytes then take the way of all other files.
    with temporary_folder() as folder:
        file = Path(folder) / "out.nc"
        try:
            dataset.to_netcdf(file, engine="h5netcdf")
        except (OSError, TypeError, ValueError) as error:
            raise OutputError(
                f"{what}: NetCDF cannot hold it ({type(error).__name__}: {error}). Drop or "
                "convert that variable."
            ) from error
        return file.read_bytes(), []


def with_cf_words(dataset: xr.Dataset, crs: str | None, *, lists: bool = False) -> xr.Dataset:
    """
    Return a dataset with the attributes of CF, as its file holds it.

    Parameters
    ----------
    dataset : xarray.Dataset
    crs : str or None
        Reference system: it becomes the grid mapping ``spatial_ref``.
    lists : bool
        Whether the format holds lists of words as attributes; else they become one text.
    """
    dataset = dataset.copy()
    # encodings are those of the file it was read from, and may not fit
    dataset = dataset.drop_encoding()

    # coordinates state their unit and meaning as CF wants it, unless they do already
    dataset.attrs = _plain(dataset.attrs, lists=lists)
    for key, variable in dataset.variables.items():
        variable.attrs = _plain(variable.attrs, lists=lists)
        if key in STANDARD_NAMES:
            variable.attrs.setdefault("units", "m")
            variable.attrs.setdefault("standard_name", STANDARD_NAMES[str(key)])

    dataset.attrs.setdefault("Conventions", "CF-1.11")
    return dataset if crs is None else _with_mapping(dataset, crs)


def _need_h5netcdf(what: str) -> None:
    """Raise an error where NetCDF cannot be written."""
    if find_spec("h5netcdf") is None:
        raise DependencyError(
            f"{what}: writing NetCDF needs h5netcdf, which is not installed. "
            'Install it with: pip install "geosurf[io]"'
        )


def _with_mapping(dataset: xr.Dataset, crs: str) -> xr.Dataset:
    """Add the grid mapping ``spatial_ref`` for all variables in space, unless there is one."""
    axes = [dataset[key].dims for key in STANDARD_NAMES if key in dataset.variables]
    dims = {dim for one in axes for dim in one}
    named = [key for key, one in dataset.data_vars.items() if dims and dims <= set(one.dims)]
    if not named or any("grid_mapping" in dataset[key].attrs for key in named):
        return dataset
    mapping = dataset.variables.get(MAPPING)
    if mapping is not None and mapping.ndim:
        return dataset  # data of that name
    if mapping is None or not mapping.attrs:
        dataset = dataset.drop_vars(MAPPING, errors="ignore")
        dataset[MAPPING] = ((), 0, _mapping(crs))
    for key in named:
        dataset[key].attrs["grid_mapping"] = MAPPING
    return dataset


def _mapping(crs: str) -> dict[str, Any]:
    """Attributes of a grid mapping: those of CF where pyproj is installed, else the text alone."""
    found: dict[str, Any] = {"spatial_ref": crs}
    if epsg_of(crs) is not None:
        found["epsg_code"] = f"EPSG:{epsg_of(crs)}"
    elif "[" in crs:
        found["crs_wkt"] = crs
    try:
        from pyproj import CRS
        from pyproj.exceptions import CRSError
    except ImportError:
        return found
    try:
        words = CRS.from_user_input(crs).to_cf()
    except CRSError:
        return found  # a name that PROJ does not know is still a text
    return found | _plain(words) | {"spatial_ref": words.get("crs_wkt", crs)}


def _plain(attrs: dict[Any, Any], *, lists: bool = False) -> dict[str, Any]:
    """Attributes as numbers, lists of numbers, perhaps of words, or text; None is left out."""
    out: dict[str, Any] = {}
    for key, value in attrs.items():
        # HDF5 has no None, and truth values only as numbers
        array = np.asarray(value)
        if value is None:
            continue
        if isinstance(value, (bool, np.bool_)):
            out[str(key)] = int(value)
        elif array.dtype.kind in "iuf" and array.ndim <= 1:
            out[str(key)] = array.item() if array.ndim == 0 else array
        elif lists and array.ndim == 1 and all(isinstance(word, str) for word in array):
            out[str(key)] = array.tolist()
        else:
            out[str(key)] = str(value)
    return out
