"""Files of ``[output] formats``: which of them can be written here, and writing them."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from geosurf.arrangement.memory_limit import gigabytes, lack_of_room
from geosurf.errors import DependencyError, GeosurfWarning, ScenarioError
from geosurf.scenario.keys import FORMATS, Scenario
from geosurf.scenario.output_keys import OutputSettings
from geosurf.scene import Scene
from geosurf.warning import warn
from geosurf.write import write

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
        warn(GeosurfWarning("format", "units.vtm", effect, remedy))
    return replace(scenario, output=replace(scenario.output, formats=rest))


def write_files(scene: Scene, scenario: Scenario, folder: Path) -> None:
    """Write the files of ``[output] formats`` into a folder."""
    # keys of the scenario; the name of the file says what goes into it
    for word in scenario.output.formats:
        file, _ = FORMATS[word]
        kind = file.partition(".")[0]
        write({"curves": scene.curves, "surfaces": scene}.get(kind, scene.units), folder / file)


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


__all__ = ["NO_NETCDF", "refuse_lists", "without_lists", "writable_formats", "write_files"]
