"""Tables of quantiles, for people and for spreadsheets."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING

from geosurf.ensemble.results import quantiles

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

COLUMNS = ("P90", "P50", "P10", "mean", "sd", "present")


def quantile_csv(result: xarray.Dataset, by: str) -> str:
    """
    Return quantiles as text with commas: volumes in m3.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble`.
    by : {"unit", "zone", "block", "contact"}

    Returns
    -------
    str
        One row for each unit or sum; the columns ``n`` and ``failed`` count realisations.
    """
    found, file = quantiles(result, by), io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    # Units in the names of columns, since a table of text has no attributes.
    writer.writerow([by, *(f"{c}_m3" if c != "present" else c for c in COLUMNS), "n", "failed"])
    for row, name in enumerate(found[by].values.tolist()):
        # repr() keeps all digits.
        numbers = [repr(float(found[column][row])) for column in COLUMNS]
        writer.writerow([name, *numbers, found.attrs["n"], found.attrs["failed"]])
    return file.getvalue()


def quantile_text(result: xarray.Dataset, by: str = "contact") -> str:
    """
    Return quantiles as a table for the console: volumes in million m3.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble`.
    by : {"unit", "zone", "block", "contact"}

    Returns
    -------
    str
    """
    found = quantiles(result, by)
    names = found[by].values.tolist()
    width = max(len(by), *map(len, names))
    lines = [
        f"Volumes [million m³] of {found.attrs['n']} realisations, {found.attrs['failed']} failed",
        f"{by:<{width}}" + "".join(f"{column:>12}" for column in COLUMNS[:3]),
    ]
    for row, name in enumerate(names):
        # Million cubic metres, as in messages.
        numbers = (float(found[column][row]) / 1e6 for column in COLUMNS[:3])
        lines.append(f"{name:<{width}}" + "".join(f"{number:12.3f}" for number in numbers))
    return "\n".join(lines)
