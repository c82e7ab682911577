"""Tables as csv and Parquet: units, wells, tops; the unit of measure is in the column name."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from geosurf.errors import DependencyError, OutputError
from geosurf.model import Units
from geosurf.write.written import Loss

if TYPE_CHECKING:  # pragma: no cover - types only
    import pandas
    import xarray as xr

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
    from geosurf.conventions.crs import crs_of

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
    if find_spec("pyarrow") is None:
        raise DependencyError(
            "writing Parquet needs pyarrow, which is not installed. Install the extra: "
            'pip install "geosurf[table]"; or write .csv.'
        )
    import pandas

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
