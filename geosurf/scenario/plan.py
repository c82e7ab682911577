"""What a run reads and writes, from the scenario alone: for ``geosurf run --dry-run``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.errors import ScenarioError
from geosurf.read import otherwise, read_points
from geosurf.scenario.keys import FORMATS, Scenario
from geosurf.write import write

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.scene import Scene


# ---- wells ----------------------------------------
# Paths of wells of a scenario: read, drawn on pictures, and listed with the units they cross.


FILE = "wells.csv"
WORDS = ("positive", "length_unit")


def wells_of_scenario(scenario: Scenario) -> dict[str, Any]:
    """
    Return the paths of all wells of ``[wells]`` by their names.

    Parameters
    ----------
    scenario : Scenario

    Returns
    -------
    dict of str to xarray.Dataset
        Empty without that table.

    Raises
    ------
    ScenarioError
        If two files have a well of one name.
    InputError
        If a file cannot be read.
    """
    entry = scenario.wells
    found: dict[str, Any] = {}
    for file in entry.files if entry is not None else ():
        for name, path in _read(scenario, entry, file).items():
            if name in found:
                raise ScenarioError(
                    f"{scenario.path}: wells.files: {file.name} has the well {name!r}, as a file "
                    "before it. Rename one of them, or leave one file out."
                )
            found[name] = path
    return found


def _read(scenario: Scenario, entry: Any, file: Path) -> dict[str, Any]:
    """The wells of one file by their names."""
    from geosurf.measure.places import wells_of
    from geosurf.read import read_wells  # loaded by those who have wells

    # several files share these words: they hold where a file states nothing
    words = {key: getattr(entry, key) or getattr(scenario, key) for key in WORDS}
    return wells_of(read_wells(file, heads=entry.heads, **otherwise(words))) or {}


def drawn_wells(scenario: Scenario) -> dict[str, Any]:
    """
    Return the paths that pictures show: of ``[wells]``, and of ``[pictures] wells``.

    Parameters
    ----------
    scenario : Scenario

    Returns
    -------
    dict of str to xarray.Dataset
    """
    from geosurf.measure.places import wells_of
    from geosurf.read import read_wells
    from geosurf.read.file_info import kind_of_file  # loaded by those who draw wells

    known: dict[str, Any] = {key: getattr(scenario, key) for key in WORDS}
    softer = otherwise(known)
    found = wells_of_scenario(scenario)
    for name, file in (scenario.pictures.wells or {}).items():
        if kind_of_file(file)[1] != "read_wells":
            found[name] = read_points(file, **known)
            continue
        wells = wells_of(read_wells(file, **softer)) or {}
        # the name is that of the file's only well; several keep their own
        found |= {name: next(iter(wells.values()))} if len(wells) == 1 else wells
    return found


def write_wells(scene: Scene, wells: dict[str, Any], folder: Path) -> list[str]:
    """
    Write the units that each well goes through into a folder.

    Parameters
    ----------
    scene : Scene
    wells : dict of str to xarray.Dataset
    folder : pathlib.Path

    Returns
    -------
    list of str
        Names of the files that were written.
    """
    if not wells:
        return []
    write(scene.well_intervals(wells), folder / FILE)
    return [FILE]


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
