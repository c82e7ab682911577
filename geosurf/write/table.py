"""Tables as csv: the table of units, one row per unit, the unit of measure in the column name."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from typing import Any

from geosurf.model import Units

# what spreadsheets take for the beginning of a formula, also in the wide letters of East Asia
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "\uff1d", "\uff0b", "\uff0d", "\uff20")
LABELS = ("zone", "block", "contact", "zone_index", "sliver")
GUARDED = (
    "Texts that begin with = + - or @ start with an apostrophe in the file, so that "
    "spreadsheets do not run them as formulas."
)


def csv_of_units(units: Units, name: str | None) -> tuple[bytes, list[str]]:
    """Return name, zone, block (contact) and all numbers of each unit, full precision."""
    table = units.table
    labels = [key for key in LABELS if key in table.coords]
    numbers = [str(key) for key in table.data_vars if table[key].dims == ("unit",)]

    # the unit stands in the name of the column: csv has no other place for it
    heads = [f"{key}_{table[key].attrs.get('units', '')}".rstrip("_") for key in numbers]
    columns = [table["unit"].values.tolist()]
    columns += [table[key].values.tolist() for key in labels + numbers]
    return csv_of_rows(["unit", *labels, *heads], zip(*columns, strict=True))


def csv_of_rows(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> tuple[bytes, list[str]]:
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
