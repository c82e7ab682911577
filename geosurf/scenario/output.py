"""The output folder: the results of one run, all of them or those of the run before.

Results are made in a folder of their own inside the output folder, and move into
place when the last of them is there. What an earlier run left under names that are
ours goes away; files of anybody else are never touched.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from geosurf.errors import OutputError
from geosurf.model.expected import path_of

# what runs write, as patterns of paths relative to the output folder
OURS = tuple(
    re.compile(pattern)
    for pattern in (
        r"units\.vtm",
        r"units/\d{3,}_.*\.vtp",
        r"curves\.(vtp|pl)",
        r"volumes\.(csv|nc)",
        r"certificate\.txt",
        r"failure\.png",
        r"report/index\.html",
        r"pictures/(view_[a-z]+|(map|isochore|allan|section)_.*|units_exploded|search)\.png",
    )
)
FOLDERS = ("units", "pictures", "report")
FILES = ("units.vtm", "curves.vtp", "curves.pl", "volumes.csv", "volumes.nc", "certificate.txt")
STAGE = ".geosurf-"


@contextmanager
def new_results(out: str | os.PathLike[str]) -> Iterator[Path]:
    """
    Give a folder to write into, and move everything in it to `out` at the end.

    Parameters
    ----------
    out : path-like
        Is created if need be. What an earlier run wrote there is replaced as a whole; if
        the ``with`` block fails, it stays as it was.

    Yields
    ------
    Path

    Raises
    ------
    OutputError
        If nothing can be written there: before the block runs, not after.
    """
    out = path_of(out, "the folder of results")
    stage = _open_stage(out)
    try:
        yield stage
        _replace(out, stage)
    finally:
        shutil.rmtree(stage, ignore_errors=True)


def require_writable(out: str | os.PathLike[str]) -> None:
    """Create a folder if need be, and raise `OutputError` if nothing can be written there."""
    try:
        Path(out).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise _refusal(Path(out), error) from error


def _open_stage(out: Path) -> Path:
    try:
        out.mkdir(parents=True, exist_ok=True)
        for name in FOLDERS:
            if (out / name).exists() and not (out / name).is_dir():
                raise NotADirectoryError(20, f"{name} is a file and should be a folder")
            if (out / name).is_dir() and not os.access(out / name, os.W_OK | os.X_OK):
                raise PermissionError(13, f"the folder {name} in it is read-only")
        for name in FILES:
            if (out / name).is_dir():
                raise IsADirectoryError(21, f"{name} is a folder and should be a file")
        return Path(tempfile.mkdtemp(prefix=STAGE, dir=out))
    except OSError as error:
        raise _refusal(out, error) from error


def _replace(out: Path, stage: Path) -> None:
    new = sorted(path.relative_to(stage) for path in stage.rglob("*") if path.is_file())
    try:
        for relative in new:
            (out / relative).parent.mkdir(parents=True, exist_ok=True)
            (stage / relative).replace(out / relative)
        for old in set(_earlier(out)) - set(new):
            (out / old).unlink()
        for name in FOLDERS:
            if (out / name).is_dir() and not any((out / name).iterdir()):
                (out / name).rmdir()
    except OSError as error:
        raise _refusal(out, error) from error


def _earlier(out: Path) -> Iterator[Path]:
    """Files in the output folder that a run wrote, this one or one before."""
    for folder in (out, *(out / name for name in FOLDERS)):
        for path in folder.iterdir() if folder.is_dir() else ():
            relative = path.relative_to(out)
            if any(pattern.fullmatch(relative.as_posix()) for pattern in OURS) and path.is_file():
                yield relative


def _refusal(out: Path, error: OSError) -> OutputError:
    reason = error.strerror or type(error).__name__
    return OutputError(
        f"{out}: results cannot be written there ({reason}). Choose another folder with out= "
        "(on the command line: -o)."
    )
