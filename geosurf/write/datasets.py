"""Tables and grids: csv and Parquet, CF NetCDF and Zarr through xarray.

The coordinate reference system is the attribute ``crs``, and for other programs the grid mapping
``spatial_ref``, as rioxarray and GDAL have it.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas

from geosurf.conventions import elevation_sign, metres_per_unit
from geosurf.conventions.crs import crs_of, epsg_of, proj_system
from geosurf.conventions.machine import need
from geosurf.errors import OutputError
from geosurf.model import Units
from geosurf.stopping import temporary_folder
from geosurf.write.text_grids import refuse_odd_nodes
from geosurf.write.vtp import AXES
from geosurf.write.written import Loss

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

    from geosurf.model import Units
    from geosurf.write.written import Loss


# ---- tables ----------------------------------------
# Tables as csv and Parquet: units, wells, tops; the unit of measure is in the column name.


# what spreadsheets take for the beginning of a formula, also in the wide letters of East Asia
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "\uff1d", "\uff0b", "\uff0d", "\uff20")
LABELS = ("zone", "block", "region", "contact", "zone_index", "reservoir", "sliver")
GUARDED = Loss(
    "data",
    "Texts that begin with = + - or @ start with an apostrophe in the file, so that "
    "spreadsheets do not run them as formulas.",
)
TABLE_ONLY = Loss("data", "The file holds the table of the units, not their surfaces; .vtm does.")

Columns = dict[str, list[Any]]


def csv_of_units(units: Units, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return name, zone, block (contact) and all numbers of each unit, full precision."""
    data, lost = csv_of_columns(columns_of_units(units))
    return data, [TABLE_ONLY, *lost]


def csv_of_table(table: xr.Dataset, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return a table of one dimension."""
    return csv_of_columns(columns_of_table(table))


def csv_of_frame(frame: pandas.DataFrame, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return a table of pandas, without its index."""
    return csv_of_columns({str(key): frame[key].tolist() for key in frame.columns})


def parquet_of_units(units: Units, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return the same columns as in csv."""
    data, lost = _parquet(columns_of_units(units), units.crs)
    return data, [TABLE_ONLY, *lost]


def parquet_of_table(table: xr.Dataset, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return a table of one dimension."""
    return _parquet(columns_of_table(table), crs_of(table))


def parquet_of_frame(frame: pandas.DataFrame, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return a table of pandas, without its index."""
    return _parquet(
        {str(key): frame[key].tolist() for key in frame.columns}, frame.attrs.get("crs")
    )


def columns_of_units(units: Units) -> Columns:
    """Columns of the table of units, by their names with the unit of measure."""
    table = units.table
    labels = [key for key in LABELS if key in table.coords]
    numbers = [str(key) for key in table.data_vars if table[key].dims == ("unit",)]
    columns = {"unit": table["unit"].values.tolist()}
    columns |= {key: table[key].values.tolist() for key in labels}

    # the unit stands in the name of the column: csv has no other place for it
    return columns | {_head(table, key): table[key].values.tolist() for key in numbers}


def columns_of_table(table: xr.Dataset) -> Columns:
    """Columns of a Dataset whose variables all lie along one dimension.

    Values at ``end`` (entry and exit of an interval in a well) are one column for each end.
    """
    if "end" in table.dims and "end" in table.coords:
        table = _with_ends_as_columns(table)
    dims = {dim for variable in table.data_vars.values() for dim in variable.dims}
    if len(dims) != 1:
        raise OutputError(
            f"this Dataset lies along {sorted(map(str, dims))}; a table has one dimension. "
            "Write .nc instead."
        )
    # names and labels first, then what is measured
    keys = [k for k in (*table.coords, *table.data_vars) if set(table[k].dims) == dims]
    return {_head(table, str(key)): table[key].values.tolist() for key in keys}


def _with_ends_as_columns(table: xr.Dataset) -> xr.Dataset:
    """Return a Dataset with ``md_entry`` and ``md_exit`` for ``md`` at both ends."""
    found: dict[str, xr.DataArray] = {}
    for key, variable in table.data_vars.items():
        if "end" in variable.dims:
            ends = {f"{key}_{end}": variable.sel(end=end) for end in table["end"].values.tolist()}
            found |= {name: one.drop_vars("end") for name, one in ends.items()}
        else:
            found[str(key)] = variable
    return table.drop_dims("end").assign(found)[list(found)]


def csv_of_columns(columns: Columns) -> tuple[bytes, list[Loss]]:
    """Return csv of columns of one length."""
    return csv_of_rows(list(columns), zip(*columns.values(), strict=True))


def _head(table: xr.Dataset, key: str) -> str:
    """Name of a column with its unit of measure."""
    unit = table[key].attrs.get("units", "")
    return f"{key}_{unit}".rstrip("_")


def _parquet(columns: Columns, crs: str | None) -> tuple[bytes, list[Loss]]:
    """Return Parquet by pandas and pyarrow; the reference system is in the metadata of pandas."""
    need("writing Parquet needs", "pyarrow")
    frame = pandas.DataFrame(columns)
    if crs is not None:
        frame.attrs["crs"] = crs
    out = io.BytesIO()
    frame.to_parquet(out, engine="pyarrow", index=False)
    return out.getvalue(), []


def csv_of_rows(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> tuple[bytes, list[Loss]]:
    r"""
    Return csv whose words are words in spreadsheets, too, and a note if one had to be changed.

    Examples
    --------
    >>> csv_of_rows(["name", "z"], [["=1+1", -5.0], ["F1+", 2.0]])[0]
    b"name,z\n'=1+1,-5.0\nF1+,2.0\n"
    """
    lines, changed = [], False
    for row in (header, *rows):
        cells = [_guarded(cell) for cell in row]
        changed = changed or any(a is not b for a, b in zip(cells, row, strict=True))
        line = io.StringIO()
        csv.writer(line).writerow(cells)  # ends with CR LF, so that either in a cell is quoted
        lines.append(line.getvalue().removesuffix("\r\n") + "\n")
    return "".join(lines).encode("utf-8"), [GUARDED] if changed else []


def _guarded(cell: Any) -> Any:
    """A word that begins as a formula does gets an apostrophe; numbers stay numbers."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(FORMULA) else cell


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
    need("table of units: writing NetCDF needs", "h5netcdf")
    data, losses = _bytes(units.table, "table of units", units.crs)
    return data, [TABLE_ONLY, *losses]


def netcdf_of_dataset(dataset: xr.Dataset, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return any dataset, such as a table or a parametric fault."""
    return _bytes(dataset, "dataset", crs_of(dataset))


def _bytes(dataset: xr.Dataset, what: str, crs: str | None = None) -> tuple[bytes, list[Loss]]:
    """Return NetCDF-4 bytes; attributes that it cannot hold become text."""
    need(f"{what}: writing NetCDF needs", "h5netcdf")
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
    system = proj_system(crs)
    if system is None:
        return found  # a name that PROJ does not know is still a text
    words = system.to_cf()
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
