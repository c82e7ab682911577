"""The output folder: the results of one run, all of them or those of the run before.

Results are made in a folder of their own inside the output folder, and take the place of the
results of an earlier run when the last of them is there (`geosurf.files`). Files under
names that are not ours are never touched. One run at a time writes into a folder.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from geosurf.arrangement.threads import gigabytes, lack_of_room
from geosurf.errors import (
    DependencyError,
    GeosurfWarning,
    OutputError,
    ScenarioError,
    collected,
    warn_of,
)
from geosurf.files import (
    MARK,
    PREFIX,
    Lock,
    Names,
    finish,
    random_digits,
    refused_writing,
    remove_abandoned,
    replace_files,
)
from geosurf.measure.places import wells_of
from geosurf.model import CornerPointGrid
from geosurf.model.expected import path_of
from geosurf.read import otherwise, read_wells
from geosurf.scenario.keys import Scenario, SealInput
from geosurf.scenario.output_keys import FORMATS, GridInput, OutputSettings
from geosurf.scene import Scene
from geosurf.stopping import in_the_end
from geosurf.write import write

# ---- grid ----------------------------------------
# The simulation grid that a scenario asks for: files, a picture and notes.


GRID_FILES = ("grid.grdecl", "grid.inc")
PICTURE = "section_grid.png"


def write_grid(
    scene: Scene, wanted: GridInput, seal: SealInput | None, folder: Path
) -> tuple[CornerPointGrid, list[str]]:
    """Build the grid and write its files; also return what was assumed."""
    from geosurf.grid import build_grid, fault_multipliers  # loaded by those who want one

    with collected() as warnings:
        grid = build_grid(scene, wanted.cell_m, wanted.layers, min_dip=wanted.min_dip)
    for name in GRID_FILES:
        write(grid, folder / name, name="grid")
    if seal is not None and seal.permeability_md is not None:
        given = {"vshale": seal.vshale, "permeability": seal.permeability_md}
        write(fault_multipliers(scene, grid, **given), folder / MULTIPLIERS)
    return grid, list(map(str, warnings))


def draw_grid(grid: CornerPointGrid, folder: Path) -> dict[str, Path]:
    """Draw the row with most active cells; the caption sums up the grid."""
    from geosurf.render import render_grid_section

    row = int(grid.actnum.sum(axis=(0, 2)).argmax()) + 1
    path = render_grid_section(grid, folder / PICTURE, row=row)
    return {f"Simulation grid: {in_words(grid)}": path}


def in_words(grid: CornerPointGrid) -> str:
    """Size of a grid, and how far its volumes are from those of the zones."""
    nz, ny, nx = grid.shape
    zones = grid.table.groupby("zone").sum()
    worst = float(np.abs(zones.volume / zones.exact - 1.0).max())
    return (
        f"{nx} x {ny} x {nz} cells, {int(grid.actnum.sum())} active; volumes of zones within "
        f"{100 * worst:.2g} % of the model"
    )


# ---- plan ----------------------------------------
# What a run reads and writes, from the scenario alone: for ``geosurf run --dry-run``.


# ---- wells ----------------------------------------
# Paths of wells of a scenario: read, drawn on pictures, and listed with the units they cross.


FILE, CLOSURES, VOLUMETRICS = "wells.csv", "closures.csv", "volumetrics.csv"
SEAL, MULTIPLIERS = "seal.csv", "grid_multipliers.inc"
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
    wells: dict[str, Any] = {}
    for file in entry.files if entry is not None else ():
        for name, path in _read(scenario, entry, file).items():
            if name in wells:
                raise ScenarioError(
                    f"{scenario.path}: wells.files: {file.name} has the well {name!r}, as a file "
                    "before it. Rename one of them, or leave one file out."
                )
            wells[name] = path
    return wells


def _read(scenario: Scenario, entry: Any, file: Path) -> dict[str, Any]:
    """The wells of one file by their names."""
    # several files share these words: they hold where a file states nothing
    words = {key: getattr(entry, key) or getattr(scenario, key) for key in WORDS}
    return wells_of(read_wells(file, heads=entry.heads, **otherwise(words))) or {}


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
    named = dict([*((entry.name, entry.file) for entry in entries), *others])
    for entry in scenario.faults:
        named |= entry.files
    if scenario.wells is not None:
        named |= {f"wells: {file.name}": file for file in scenario.wells.files}
        named["heads of wells"] = scenario.wells.heads
    if scenario.volumetrics is not None:
        for word, value in vars(scenario.volumetrics).items():
            by_words = value.items() if isinstance(value, dict) else [((), value)]
            named |= {
                " ".join((word, *of)): file for of, file in by_words if isinstance(file, Path)
            }
    for files in (scenario.pictures.polygons, scenario.pictures.points):
        named |= {f"picture: {name}": file for name, file in (files or {}).items()}
    for name, polygon in (scenario.regions or {}).items():
        named[f"region: {name}"] = polygon if isinstance(polygon, Path) else None
    return {"scenario": scenario.path, **{name: file for name, file in named.items() if file}}


def output_files(scenario: Scenario, *, pictures: bool = True, report: bool = True) -> list[str]:
    """Return what a run writes into its folder; pictures are one entry."""
    files = [FORMATS[word] for word in scenario.output.formats]
    if "units.vtm" in files:
        files.append("units/*.vtp")
    if "surfaces.epc" in files:
        files.append("surfaces.h5")
    if scenario.output.closures is not None or getattr(scenario.seal, "closures_sgr", None):
        files.append(CLOSURES)
    if scenario.seal is not None:
        files.append(SEAL)
    if scenario.volumetrics is not None:
        files.append(VOLUMETRICS)
    if scenario.wells is not None:
        files.append(FILE)
    if scenario.grid is not None:
        files += GRID_FILES
        files += [MULTIPLIERS] if getattr(scenario.seal, "permeability_md", None) else []
    files.append("certificate.txt")
    if pictures:
        files.append("pictures/*.png")
    if report:
        files.append("report/index.html")
    return files


# ---- output formats ----------------------------------------
# Files of ``[output] formats``: which of them can be written here, and writing them.


NO_NETCDF = GeosurfWarning(
    "format",
    "volumes.nc",
    "File 'volumes.nc' was not written: it needs h5netcdf, which is not installed. 'volumes.csv' "
    "has the same table.",
    'Install it with: pip install "geosurf[io]"; or leave "nc" out of formats in [output].',
)
LISTS = ("vtm", "ml", "epc")  # files that list all triangles
WRITTEN = (
    480  # bytes of memory for each triangle of a horizon, of which units on both sides have one
)


def writable_formats(scenario: Scenario) -> Scenario:
    """Return the scenario; without NetCDF if that is missing here, and nobody requested it."""
    # Asked before the run: the package is needed at its end only.
    usual = OutputSettings().formats
    if scenario.output.formats == usual and find_spec("h5netcdf") is None:
        rest = tuple(word for word in usual if word != "nc")
        return replace(scenario, output=replace(scenario.output, formats=rest))
    for word, package in (("nc", "h5netcdf"), ("epc", "h5py")):
        if word in scenario.output.formats and find_spec(package) is None:
            raise DependencyError(
                f"{scenario.path}: output.formats has {word!r}, which needs {package}. Leave it "
                'out, or install it with: pip install "geosurf[io]"'
            )
    return scenario


def refuse_lists(scenario: Scenario, scene: Scene) -> None:
    """Refuse files that list more triangles than memory holds, where they are requested.

    Scenarios that request none get what can be written, and a warning.
    """
    asked = [word for word in scenario.output.formats if word in LISTS]
    if set(asked) <= set(OutputSettings().formats) or not (why := why_no_lists(scene)):
        return
    raise ScenarioError(
        f"{scenario.path}: output.formats has {', '.join(map(repr, asked))}, which list all "
        f"triangles, and {why}. {_fewer(scenario)}; or leave these formats out."
    )


def without_lists(scenario: Scenario, scene: Scene) -> Scenario:
    """The scenario without files that list all triangles, if memory does not hold these."""
    rest = tuple(word for word in scenario.output.formats if word not in LISTS)
    if rest == scenario.output.formats or not (why := why_no_lists(scene)):
        return scenario
    effect = f"File 'units.vtm' was not written: it lists all triangles of units, and {why}."
    remedy = f'{_fewer(scenario)}; or leave "vtm" out of formats in [output].'
    with scene._graph.memory.collecting():
        warn_of("format", "units.vtm", effect, remedy)
    return replace(scenario, output=replace(scenario.output, formats=rest))


def write_files(scene: Scene, scenario: Scenario, folder: Path) -> None:
    """Write the files of ``[output] formats`` into a folder."""
    # keys of the scenario; the name of the file says what goes into it
    for word in scenario.output.formats:
        file = FORMATS[word]
        kind = file.partition(".")[0]
        volumes = scene.units.included(scenario.output.include)
        things = {"curves": scene.curves, "surfaces": scene, "volumes": volumes}
        write(things.get(kind, scene.units), folder / file)
    rule: Any = scenario.output.closures
    given, shale = scenario.seal, None
    if given is not None:
        shale = given.vshale
        if given.closures_sgr is not None:
            rule = {"elsewhere": {"sgr": given.closures_sgr}}
        numbers: dict[str, Any] = {
            "shale": given.shale, "density_contrast": given.density_contrast_kg_m3,
            "seabed": given.seabed_m,
        }  # fmt: skip
        tables = []
        for name in scene.faults_inside:
            along = scene.seal(name, vshale=shale, **numbers)
            label = np.full(along.sizes["pair"], name, dtype=object)
            polygons = along.drop_dims(["triangle", "corner", "sgr_class"])
            tables.append(polygons.assign_coords(fault=("pair", label)))
        if tables:
            write(xr.concat(tables, "pair", combine_attrs="override"), folder / SEAL)
    if rule is not None:
        closures = scene.closures(faults=rule, vshale=shale)
        write(closures.drop_dims(["leak", "line", "point"]), folder / CLOSURES)


def _fewer(scenario: Scenario) -> str:
    """How a scenario has fewer triangles."""
    if scenario.tear is None:
        return "Keep fewer nodes in memory: tolerance_m = 1.0"
    return "Give grids with fewer nodes"  # a tolerance is not for horizons that are torn


def why_no_lists(scene: Scene) -> str:
    """Why the triangles of a scene cannot be listed and written; empty if they can be."""
    horizons = [scene.surface(one) for one in scene.horizon_names]
    needed = WRITTEN * sum(one.n_triangle for one in horizons)
    free = lack_of_room(needed)
    if free is None:
        return ""
    return f"these need {gigabytes(needed)} of memory, while {gigabytes(free)} are free"


FOLDERS = ("units", "pictures", "report")
FILES = (
    *FORMATS.values(), "surfaces.h5", "certificate.txt", *GRID_FILES, MULTIPLIERS,
    CLOSURES, SEAL, VOLUMETRICS, FILE,
)  # fmt: skip
# what runs write, as patterns of paths relative to the output folder
OURS = Names(
    (
        *(re.compile(re.escape(name)) for name in (*FILES, "failure.png", "report/index.html")),
        re.compile(r"units/\d{3,}_[^/]*\.vtp"),
        re.compile(r"pictures/(view_[a-z]+|units_exploded|search)\.png"),
        re.compile(r"pictures/(map|isochore|allan|throw|section)_[^/]*\.png"),
        re.compile(re.escape(MARK)),
    ),
    FOLDERS,
)
LOCK, JOURNAL = f"{PREFIX}lock", f"{PREFIX}commit"
_STAGE = re.compile(re.escape(PREFIX) + "([0-9a-f]{16}|[0-9a-z_]{8})")
_MARK_TEXT = """geosurf was stopped while it moved results into this folder: they are not complete.
Run the scenario again with this folder as output.
"""


@contextmanager
def new_results(out: str | os.PathLike[str]) -> Iterator[Path]:
    """
    Give a folder to write into, and put everything in it into `out` at the end.

    Parameters
    ----------
    out : path-like
        Is created if needed. What an earlier run wrote there is replaced as a whole; if
        the ``with`` block fails, it stays as it was.

    Yields
    ------
    Path

    Raises
    ------
    OutputError
        If nothing can be written there, or another run is writing there: before the block runs,
        not after.
    """
    out = path_of(out, "the folder of results")

    # taken first and released last: two runs into one folder would mix their results
    lock = Lock(out / LOCK)
    with in_the_end(lock.release):
        _claim(out, lock)

        # inside `out`, so that the final rename stays on one file system
        stage = _open_stage(out)
        with in_the_end(lambda: shutil.rmtree(stage, ignore_errors=True)):
            yield stage
            _replace(out, stage)


def _claim(out: Path, lock: Lock) -> None:
    """Be the only run that writes into a folder."""
    with _refused(out):
        out.mkdir(parents=True, exist_ok=True)
        taken = lock.take()
    if not taken:
        raise OutputError(
            f"{out}: another run is writing there. Wait until it has ended, or choose another "
            "folder with out= (on the command line: -o)."
        )


def _open_stage(out: Path) -> Path:
    """Finish or remove what killed runs have left, and make a folder for new results."""
    with _refused(out):
        # refuse before anything is computed what would fail at the end
        for name in FOLDERS:
            # a link would let a run write outside of its folder
            if (out / name).is_symlink():
                raise NotADirectoryError(20, f"{name} is a link; remove it")
            if (out / name).exists() and not (out / name).is_dir():
                raise NotADirectoryError(20, f"{name} is a file and should be a folder")
            if (out / name).is_dir() and not os.access(out / name, os.W_OK | os.X_OK):
                raise PermissionError(13, f"the folder {name} in it is read-only")
        for name in FILES:
            if (out / name).is_dir():
                raise IsADirectoryError(21, f"{name} is a folder and should be a file")

        # a killed run may have left half-moved results, copies of files, and its own folder
        finish(out, OURS, JOURNAL)
        remove_abandoned(out)
        for path in out.iterdir():
            # Only folders with our own name pattern, and never through a link.
            if _STAGE.fullmatch(path.name) and path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
        stage = out / f"{PREFIX}{random_digits()}"
        stage.mkdir()
    return stage


def _replace(out: Path, stage: Path) -> None:
    """Move files one by one, with a mark that it is not finished."""
    with _refused(out):
        for path in stage.glob(f"{LOCK}-*"):  # of a writer that could not remove its own
            path.unlink()
        (stage / MARK).write_text(_MARK_TEXT, encoding="utf-8")
        replace_files(out, stage, OURS.found_in(out), OURS, JOURNAL)


def _refused(out: Path) -> AbstractContextManager[None]:
    """Say why results cannot be written."""
    remedy = "Choose another folder with out= (on the command line: -o)."
    return refused_writing(f"{out}: results", out, remedy)
