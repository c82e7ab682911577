"""One part of the page per fault: Allan diagram, throw profile, juxtaposition, what was changed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from html import escape
from pathlib import Path

from geosurf.model.protocols import ReportedModel
from geosurf.report import fault_tables, page
from geosurf.report.page import Table

# files of pictures that show one fault, as `geosurf.scene.pictures` names them: kind and row
OF_FAULT = re.compile(r"(allan|throw)_(\d+)_.*\.png")


def pictures_of_faults(
    scene: ReportedModel, pictures: Mapping[str, Path]
) -> tuple[dict[str, dict[str, Path]], dict[str, Path]]:
    """Return the pictures of each fault, and all other pictures."""
    names = scene.fault_names
    of_faults: dict[str, dict[str, Path]] = {}
    others = {}
    for caption, path in pictures.items():
        found = OF_FAULT.fullmatch(path.name)
        if found and int(found[2]) < len(names):
            of_faults.setdefault(names[int(found[2])], {})[caption] = path
        else:
            others[caption] = path
    return of_faults, others


def fault_parts(
    scene: ReportedModel, pictures: Mapping[str, Mapping[str, Path]]
) -> list[tuple[str, str]]:
    """Return the name and the HTML of each fault with something to show."""
    extended, truncated = fault_tables.fault_tables(scene.fault_actions)
    thrown = fault_tables.sheet_table(scene.sheets)
    inside = set(scene.faults_inside)
    changed = {row[0] for table in (extended, truncated) for row in table.rows}

    # in the order of the inputs; faults outside of the model count where they were changed
    found: list[tuple[str, str]] = []
    for name in dict.fromkeys([*scene.fault_names, *scene.faults_inside, *sorted(changed)]):
        if name not in inside | changed and name not in pictures:
            continue
        across = [scene.juxtaposition(name)] if name in inside else []
        parts = [
            page.html_pictures(pictures.get(name, {})),
            _part("Juxtaposition", _rows(fault_tables.juxtaposition_table(across), name, 0)),
            _part("Throw and heave of torn horizons", _rows(thrown, name, 1)),
            _part("Extended", _rows(extended, name, 0)),
            _part("Truncated", _rows(truncated, name, 0)),
        ]
        head = f'<h3 id="{page.part_name("fault", len(found))}">{escape(name)}</h3>'
        found.append((name, "\n".join([head, *filter(None, parts)])))
    return found


def _rows(table: Table, fault: str, column: int) -> Table:
    """The rows of one fault, without the column of its name."""
    rows = tuple((*row[:column], *row[column + 1 :]) for row in table.rows if row[column] == fault)
    head = (*table.head[:column], *table.head[column + 1 :])
    return replace(table, head=head, rows=rows, n_label=table.n_label - 1)


def _part(heading: str, table: Table) -> str:
    return f"<h4>{heading}</h4>\n{page.html_table(table)}" if table.rows else ""
