"""geosurf as users have it: an installed wheel of these very sources, to time how it starts.

From a checkout, a wheel is built (as ``make wheel`` does: minutes) and unpacked into a folder that
lasts as long as this process; an installed geosurf is copied as it is. Where no wheel can be built
(no compiler, no network), the sources are timed, and the table says so.
"""

from __future__ import annotations

import atexit
import functools
import os
import shutil
import subprocess
import sys
import tempfile
import weakref
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import geosurf

PACKAGE = Path(geosurf.__file__).resolve().parent
_LONGEST = 1800  # [s] that building may take
_WHERE = "import geosurf; print(geosurf.__file__)"


@dataclass(frozen=True)
class Installed:
    """What is started.

    Attributes
    ----------
    site : str
        Folder that holds the package; empty: the sources themselves, as they are imported here.
    words : str
        For people.
    """

    site: str
    words: str


@functools.cache
def installed() -> Installed:
    """Return an installed geosurf, made once in a process.

    Returns
    -------
    Installed
    """
    root = PACKAGE.parent
    holder = Path(tempfile.mkdtemp(prefix="geosurf-bench-"))
    atexit.register(shutil.rmtree, holder, ignore_errors=True)
    try:
        if (root / "hatch_build.py").is_file():
            unpack(build_wheel(root, holder), holder / "site")
        else:
            copy_of(root, holder / "site")
    except (OSError, subprocess.SubprocessError) as reason:
        said = str(getattr(reason, "stderr", "") or reason).strip().splitlines()
        return Installed("", f"from sources, no wheel: {said[-1][:200] if said else reason}")
    frozen = (holder / "site" / "geosurf" / "kernels" / "frozen").is_dir()
    words = "installed wheel" if frozen else "installed pure wheel, kernels compiled by numba"
    return Installed(str(holder / "site"), words)


def build_wheel(root: Path, out: Path) -> Path:
    """Build the wheel of a checkout with pip; what fails is a `subprocess.SubprocessError`."""
    command = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(out), str(root)]
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=_LONGEST)
    return next(out.glob("geosurf-*.whl"))


def unpack(wheel: Path, site: Path) -> None:
    """Lay a wheel out as an installer does, without bytecode.

    Parameters
    ----------
    wheel : pathlib.Path
    site : pathlib.Path
        New folder.
    """
    with zipfile.ZipFile(wheel) as held:
        held.extractall(site)


def copy_of(root: Path, site: Path) -> None:
    """Copy the package out of a folder into a new one, without bytecode."""
    skip = shutil.ignore_patterns("__pycache__")
    shutil.copytree(root / "geosurf", site / "geosurf", ignore=skip)


@dataclass(eq=False)
class Start:
    """One start: the environment of its process, and a folder that goes with this object."""

    environment: dict[str, str]
    folder: Path | None


def prepare_start(options: dict[str, Any]) -> Start:
    """
    Return what a start is timed in.

    Parameters
    ----------
    options : dict
        ``"site"``: as in `Installed`; ``"first"``: whether nothing may be there from before: no
        bytecode of geosurf, no kept kernels.

    Returns
    -------
    Start

    Examples
    --------
    >>> "GEOSURF_CACHE_DIR" in prepare_start({"site": "", "first": True}).environment
    True
    """
    environment, folder = dict(os.environ), None
    site = options.get("site", "")
    if options.get("first"):
        folder = Path(tempfile.mkdtemp(prefix="geosurf-start-"))
        copy_of(Path(site) if site else PACKAGE.parent, folder / "site")
        environment["GEOSURF_CACHE_DIR"] = str(folder / "cache")
        site = str(folder / "site")
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    if site:
        environment["PYTHONPATH"] = site
    start = Start(environment, folder)
    if folder is not None:
        weakref.finalize(start, shutil.rmtree, folder, ignore_errors=True)
    return start


def place_of(start: Start) -> Path:
    """Return the folder of the package that a start imports."""
    said = subprocess.run(
        [sys.executable, "-P", "-c", _WHERE],
        env=start.environment, check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    return Path(said.strip()).parents[1]
