"""Tables of faults: extension and truncation, juxtaposition, fault polygons, throw and heave."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from geosurf.model import Extension, Truncation
from geosurf.report.page import NOTHING, Table, number


def fault_tables(actions: Iterable[Extension | Truncation]) -> tuple[Table, Table]:
    """Return two tables: how far faults were extended, and what truncation removed."""
    extended, truncated = [], []

    # one pass over the run log of the fault stage, in the order in which it acted; the two kinds of
    # action have different figures
    for a in actions:
        if isinstance(a, Extension):
            numbers = (number(a.shortest, 1), number(a.distance, 1), number(a.area))
            extended.append((a.fault, a.side, a.until, a.lines, *numbers))
        else:
            numbers = (number(a.length, 1), number(a.kept_area), number(a.dropped_area))
            truncated.append((a.fault, a.main, f"{a.keep} ({a.side})", *numbers))
    head = ("Fault", "Side", "Extended to", "Method", "Min [m]", "Max [m]", "Area added [m²]")
    cut = (
        "Fault",
        "Ends at",
        "Part kept",
        "Contact line [m]",
        "Area kept [m²]",
        "Area removed [m²]",
    )
    return Table(head, tuple(extended), n_label=4), Table(cut, tuple(truncated), n_label=3)


def juxtaposition_table(found: Iterable[Any]) -> Table:
    """Return the zones juxtaposed across each fault, from datasets of `Scene.juxtaposition`.

    Units of one zone are added up. Pairs of different zones come first, the largest area first.
    """
    rows: list[tuple[str, ...]] = []

    # one dataset per fault [m²]; its rows are pairs of units, so one pair of zones may come several
    # times
    for dataset in found:
        areas: dict[tuple[str, str, str], float] = {}
        columns = (dataset.zone_plus, dataset.zone_minus, dataset.kind, dataset.area)
        for plus, minus, kind, area in zip(*(c.values for c in columns), strict=True):
            key = (str(plus), str(minus), str(kind))
            areas[key] = areas.get(key, 0.0) + float(area)

        # a share of the fault's area inside the model: the rows of one fault add up to 100 %
        whole = float(dataset.attrs["area"])

        # False sorts before True: contacts of different zones, through which fluids may pass, lead
        for key, area in sorted(
            areas.items(), key=lambda item: (item[0][0] == item[0][1], -item[1])
        ):
            share = f"{number(100.0 * area / whole, 1)} %"
            rows.append((str(dataset.attrs["fault"]), *key, number(area), share))
    head = ("Fault", "Hanging wall", "Footwall", "Kind", "Area [m²]", "Share of fault")
    return Table(head, tuple(rows), n_label=4)


def polygon_table(found: Iterable[Any]) -> Table:
    """Return the fault polygons of each horizon, from datasets of `Scene.fault_polygons`."""
    rows = []
    for dataset in found:
        columns = (dataset.fault, dataset.part, dataset.kind, dataset["count"], dataset.map_area)
        for fault, part, kind, n, area in zip(*(c.values for c in columns), strict=True):
            name = str(dataset.attrs["horizon"])
            numbers = (number(int(part)), number(int(n)), number(float(area), 1))
            rows.append((name, str(fault), str(kind), *numbers))
    head = ("Horizon", "Fault", "Kind", "Part", "Points", "Map area [m²]")
    return Table(head, tuple(rows), n_label=3)


def sheet_table(sheets: Mapping[str, Any]) -> Table:
    """Return throw and heave of torn horizons at each fault, from torn sheets by name."""
    rows = []
    for name, sheet in sheets.items():
        for cut in sheet.cuts.values():
            # throw is NaN at stations where a wall has no cut-off
            known = np.isfinite(cut.throw)
            if not known.any():
                rows.append((name, cut.fault, ", ".join(cut.ends), *([NOTHING] * 4)))
                continue

            # heave is signed (negative where the walls overlap, as at a reverse fault); the table
            # shows the larger opening or overlap
            throw, heave = cut.throw[known], cut.heave[known]
            values = (cut.along[known].max(), throw.min(), throw.max(), np.abs(heave).max())
            rows.append((name, cut.fault, ", ".join(cut.ends), *(number(v, 1) for v in values)))
    head = ("Horizon", "Fault", "Ends", "Length [m]", "Min throw [m]", "Max throw [m]")
    return Table((*head, "Max heave [m]"), tuple(rows), n_label=3)
