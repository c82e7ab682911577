"""The output folder: the results of one run, all of them or those of the run before.

Results are made in a folder of their own inside the output folder, and take the place of the
results of an earlier run when the last of them is there (`geosurf.files.folders`). Files under
names that are not ours are never touched. One run at a time writes into a folder.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from geosurf.arrangement.threads import gigabytes, lack_of_room
from geosurf.errors import DependencyError, GeosurfWarning, OutputError, ScenarioError
from geosurf.files.atomic import PREFIX, random_digits, remove_abandoned
from geosurf.files.folders import (
    MARK,
    Lock,
    Names,
    discard_twins,
    finish,
    replace_files,
    replace_folder,
)
from geosurf.model.expected import path_of
from geosurf.scenario.keys import FORMATS, Scenario
from geosurf.scenario.output_keys import OutputSettings
from geosurf.scene import Scene
from geosurf.warning import warn
from geosurf.write import write

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


FOLDERS = ("units", "pictures", "report")
FILES = (
    *("units.vtm", "curves.vtp", "curves.pl", "volumes.csv", "volumes.nc"),
    *("units.ml", "surfaces.epc", "surfaces.h5"),
    *("certificate.txt", "wells.csv", "grid.grdecl", "grid.inc"),
)
# what runs write, as patterns of paths relative to the output folder
OURS = Names(
    tuple(
        re.compile(pattern)
        for pattern in (
            r"units\.(vtm|ml)",
            r"surfaces\.(epc|h5)",
            r"units/\d{3,}_[^/]*\.vtp",
            r"curves\.(vtp|pl)",
            r"volumes\.(csv|nc)",
            r"wells\.csv",
            r"certificate\.txt",
            r"grid\.(grdecl|inc)",
            r"failure\.png",
            r"report/index\.html",
            r"pictures/(view_[a-z]+|units_exploded|search)\.png",
            r"pictures/(map|isochore|allan|throw|section)_[^/]*\.png",
            MARK.replace(".", r"\."),
        )
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
    try:
        _claim(out, lock)

        # inside `out`, so that the final rename stays on one file system
        stage = _open_stage(out)
        try:
            yield stage
            _replace(out, stage)
        finally:
            shutil.rmtree(stage, ignore_errors=True)
    finally:
        lock.release()


def require_writable(out: str | os.PathLike[str]) -> None:
    """Create a folder if needed, and raise `OutputError` if nothing can be written there."""
    try:
        Path(out).mkdir(parents=True, exist_ok=True)
        # A real file: permissions alone do not show full or read-only disks.
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise _refusal(Path(out), error) from error


def _claim(out: Path, lock: Lock) -> None:
    """Be the only run that writes into a folder."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        taken = lock.take()
    except OSError as error:
        raise _refusal(out, error) from error
    if not taken:
        raise OutputError(
            f"{out}: another run is writing there. Wait until it has ended, or choose another "
            "folder with out= (on the command line: -o)."
        )


def _open_stage(out: Path) -> Path:
    """Finish or remove what killed runs have left, and make a folder for new results."""
    try:
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
        discard_twins(out, OURS)
        remove_abandoned(out)
        for path in out.iterdir():
            # Only folders with our own name pattern, and never through a link.
            if _STAGE.fullmatch(path.name) and path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
        stage = out / f"{PREFIX}{random_digits()}"
        stage.mkdir()
    except OSError as error:
        raise _refusal(out, error) from error
    return stage


def _replace(out: Path, stage: Path) -> None:
    """Swap the folders, or move files one by one with a mark that it is not finished."""
    try:
        for path in stage.glob(f"{LOCK}-*"):  # of a writer that could not remove its own
            path.unlink()
        if replace_folder(out, stage, OURS, LOCK):
            return

        # not every system can swap folders: files move one by one, under a mark
        (stage / MARK).write_text(_MARK_TEXT, encoding="utf-8")
        replace_files(out, stage, OURS.found_in(out), OURS, JOURNAL)
    except OSError as error:
        raise _refusal(out, error) from error


def _refusal(out: Path, error: OSError) -> OutputError:
    reason = error.strerror or type(error).__name__
    file = next((one for one in (out, *out.parents) if one.is_file()), None)
    if file is not None:
        reason = f"{file} is a file, not a folder"
    return OutputError(
        f"{out}: results cannot be written there ({reason}). Choose another folder with out= "
        "(on the command line: -o)."
    )
