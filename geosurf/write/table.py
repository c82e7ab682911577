"""The table of units as csv: one row per unit, the unit of measure in the column name."""

from __future__ import annotations

import csv
import io

from geosurf.model import Units


def csv_of_units(units: Units, name: str | None) -> tuple[bytes, list[str]]:
    """Return name, zone, block (contact) and all numbers of each unit, full precision."""
    table = units.table
    labels = [key for key in ("zone", "block", "contact", "zone_index") if key in table.coords]
    numbers = [str(key) for key in table.data_vars if table[key].dims == ("unit",)]
    heads = [f"{key}_{table[key].attrs.get('units', '')}".rstrip("_") for key in numbers]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["unit", *labels, *heads])
    columns = [table["unit"].values.tolist()]
    columns += [table[key].values.tolist() for key in labels + numbers]
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue().encode("utf-8"), []
