"""Files of ``[output] formats``: which of them can be written here, and writing them."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from geosurf.errors import DependencyError, GeosurfWarning, ScenarioError
from geosurf.model.chunked import ChunkedLattice
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
NO_TRIANGLES = GeosurfWarning(
    "format",
    "units.vtm",
    "File 'units.vtm' was not written: it lists all triangles of units, and horizons stay in their "
    "store.",
    'Leave "vtm" out of formats in [output], or keep fewer nodes in memory: tolerance_m = 1.0.',
)
LISTS = ("vtm", "ml", "epc")  # files that list all triangles


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
    """Refuse files that list all triangles of horizons in their store, where they are requested."""
    asked = [word for word in scenario.output.formats if word in LISTS]
    if set(asked) <= set(OutputSettings().formats) or not (stored := _stored(scene)):
        return
    raise ScenarioError(
        f"{scenario.path}: output.formats has {', '.join(map(repr, asked))}, which list all "
        f"triangles, and horizon {stored[0]!r} stays in its store. Leave them out, or keep "
        "fewer nodes in memory: tolerance_m = 1.0."
    )


def without_lists(scenario: Scenario, scene: Scene) -> Scenario:
    """The scenario without files that list all triangles, if horizons stay in their store."""
    rest = tuple(word for word in scenario.output.formats if word not in LISTS)
    if rest == scenario.output.formats or not _stored(scene):
        return scenario
    with scene._graph.memory.collecting():
        warn(NO_TRIANGLES)
    return replace(scenario, output=replace(scenario.output, formats=rest))


def write_files(scene: Scene, scenario: Scenario, folder: Path) -> None:
    """Write the files of ``[output] formats`` into a folder."""
    # keys of the scenario; the name of the file says what goes into it
    for word in scenario.output.formats:
        file, _ = FORMATS[word]
        kind = file.partition(".")[0]
        write({"curves": scene.curves, "surfaces": scene}.get(kind, scene.units), folder / file)


def _stored(scene: Scene) -> list[str]:
    """Horizons that stay in their store."""
    names = scene.horizon_names
    return [one for one in names if isinstance(scene.surface(one).lattice, ChunkedLattice)]


__all__ = ["NO_NETCDF", "refuse_lists", "without_lists", "writable_formats", "write_files"]
