"""Tables of an ensemble, for people and for spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

from geosurf.conventions import counted
from geosurf.ensemble.record import MILLION, STATISTICS, TOTAL


def quantile_csv(ensemble: Any, by: Sequence[str], include: str = "reservoir") -> str:
    """
    Return quantiles of all columns as text with commas.

    Parameters
    ----------
    ensemble : Ensemble
    by : sequence of str
    include : {"reservoir", "all"}

    Returns
    -------
    str
        One row for each column and sum that is not 0 everywhere; ``n`` and ``failed`` count
        realisations.
    """
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow([*by, "quantity", "units", *STATISTICS, "n", "failed"])
    for of in ensemble.columns:
        for labels, found in ensemble.rows(of, include, [by]):
            # repr() keeps all digits.
            numbers = [repr(found[key]) for key in STATISTICS]
            units = ensemble.data[of].attrs["units"]
            writer.writerow([*labels, of, units, *numbers, ensemble.n_built, ensemble.n_failed])
    return file.getvalue()


def realisations_csv(ensemble: Any, include: str = "reservoir") -> str:
    """Return one row for each realisation and region as text: rock by fluid, and drawn numbers."""
    data, keys = ensemble.data, ["realisation", "region"]
    frame = ensemble.to_dataframe("region", include).set_index(keys)
    parts = ensemble.to_dataframe(("region", ensemble.parts), include)
    rock = parts.pivot_table("bulk", keys, ensemble.parts, sort=False, dropna=False).fillna(0.0)
    for k, name in enumerate(word for word in rock.columns if word):
        frame.insert(k + 1, f"bulk {name}", rock[name].where(frame.bulk.notna()))
    units = {name: data[name.partition(" ")[0]].attrs["units"] for name in frame.columns}
    frame = frame.rename(columns={name: f"{name} [{unit}]" for name, unit in units.items()})
    drawn = data.drawn.to_pandas()
    drawn.columns = [
        f"{name} [{unit}]"
        for name, unit in zip(data.parameter.values, data.parameter_unit.values, strict=True)
    ]
    return frame.reset_index().join(drawn, on="realisation").to_csv(index=False)


def quantile_text(ensemble: Any, include: str = "reservoir") -> str:
    """Return P90, P50 and P10 by region and fluid for the console: oil and gas in place first."""
    asked = [of for of, _ in ensemble.answers]
    lines = [f"{counted(ensemble.n_built, 'realisation')}, {ensemble.n_failed} failed"]
    for of in dict.fromkeys([*asked, "bulk"]):
        rows = [
            (" ".join(labels) or TOTAL[include], found)
            for labels, found in ensemble.rows(of, include)
            if not labels or found["P10"] or found["base"]  # others are in the files
        ]
        head = ensemble.name(of)
        width = max(len(head), *(len(label) for label, _ in rows))
        lines += ["", f"{head:<{width}}" + "".join(f"{key:>12}" for key in STATISTICS[:3])]
        for label, found in rows:
            # Millions, as in messages.
            numbers = "".join(f"{found[key] / MILLION:12.3f}" for key in STATISTICS[:3])
            lines.append(f"{label:<{width}}{numbers}")
    return "\n".join([*lines, *filter(None, [ensemble.left_out(include)])])
