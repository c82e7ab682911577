"""What a run reads and writes, from the scenario alone: for ``geosurf run --dry-run``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geosurf.scenario.keys import FORMATS, Scenario
from geosurf.scenario.wells import FILE


def input_files(scenario: Scenario) -> dict[str, Path]:
    """Return the files that a scenario names, and its own, by name."""
    entries: tuple[Any, ...] = (*scenario.horizons, *scenario.contacts)
    single = {"sealed model": scenario.model, "area": scenario.aoi, "well tops": scenario.tops}
    others = [(name, getattr(table, "file", None)) for name, table in single.items()]
    named = dict([*((one.name, one.file) for one in entries), *others])
    for entry in scenario.faults:
        named |= entry.files
    if scenario.wells is not None:
        named |= {f"wells: {file.name}": file for file in scenario.wells.files}
        named["heads of wells"] = scenario.wells.heads
    drawn = (scenario.pictures.wells, scenario.pictures.polygons, scenario.pictures.points)
    for files in drawn:
        named |= {f"picture: {name}": file for name, file in (files or {}).items()}
    return {"scenario": scenario.path, **{name: file for name, file in named.items() if file}}


def output_files(scenario: Scenario, *, pictures: bool = True, report: bool = True) -> list[str]:
    """Return what a run writes into its folder; pictures are one entry."""
    files = [FORMATS[word][0] for word in scenario.output.formats]
    if "units.vtm" in files:
        files.append("units/*.vtp")
    if "surfaces.epc" in files:
        files.append("surfaces.h5")
    if scenario.wells is not None:
        files.append(FILE)
    if scenario.grid is not None:
        files += ["grid.grdecl", "grid.inc"]
    files.append("certificate.txt")
    if pictures:
        files.append("pictures/*.png")
    if report:
        files.append("report/index.html")
    return files
