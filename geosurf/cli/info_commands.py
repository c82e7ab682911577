"""The commands ``info``, ``doctor`` and ``warmup``: what files hold, and what is installed."""

from __future__ import annotations

import argparse
import importlib.metadata
import os
import platform
import sys
from dataclasses import asdict
from typing import NamedTuple

from geosurf.cli.console import Answer, clear_line
from geosurf.conventions.machine import (
    DRAWING,
    EXTRAS,
    REQUIRED,
    distribution,
    install_line,
    is_installed,
    missing_sentence,
)
from geosurf.errors import InputError
from geosurf.kernels.compile.jit import RUNNER
from geosurf.kernels.compile.warmup import warm
from geosurf.read.file_info import info
from geosurf.render.backend import CHOICE, find_backend, views_obstacle


class Part(NamedTuple):
    """A part of the installation.

    Attributes
    ----------
    name : str
    ok : bool
        Whether it works.
    detail : str
        One sentence: the version, or how to fix it.
    extra : bool
        Whether geosurf works without it.
    """

    name: str
    ok: bool
    detail: str
    extra: bool = False

    @property
    def state(self) -> str:
        """One word for people."""
        if self.ok:
            return "ok"
        return "absent" if self.extra else "MISSING"


def installation() -> list[Part]:
    """Check the installation.

    Returns
    -------
    list of Part

    Examples
    --------
    >>> [part.name for part in installation()][:8]
    ['python', 'numpy', 'numba', 'xarray', 'pandas', 'scipy', 'meshio', 'kernels']
    >>> [part.name for part in installation() if part.extra]
    ['render', 'io', 'table', 'crs', 'gis', 'grid', 'ensemble', 'tet']
    """
    version = platform.python_version()
    parts = [
        Part("python", sys.version_info >= (3, 11), f"Python {version} on {platform.system()}."),
        *map(_required, REQUIRED),
        Part("kernels", not RUNNER.obstacle(), RUNNER.describe()),
    ]
    # a driver is missed only by those who have what draws
    if not missing_sentence("", *DRAWING):
        parts.append(_pictures())
    return [*parts, *(_extra(name, packages) for name, packages in EXTRAS.items())]


def _version(package: str) -> str:
    """Name and version of a package."""
    name = distribution(package)
    try:
        return f"{name} {importlib.metadata.version(name)}"
    except importlib.metadata.PackageNotFoundError:  # not installed by an installer
        return name


def _required(package: str) -> Part:
    if is_installed(package):
        return Part(package, True, f"{_version(package)} is installed.")
    detail = f"{package} is not installed. Install it with: {install_line(package)}"
    return Part(package, False, detail)


def _extra(name: str, packages: tuple[str, ...]) -> Part:
    missing = [package for package in packages if not is_installed(package)]
    if not missing:
        return Part(name, True, f"{', '.join(map(_version, packages))}.", extra=True)
    names = ", ".join(map(distribution, missing))
    detail = f"not installed: {names}. To add: {install_line(missing[0])}"
    return Part(name, False, detail, extra=True)


def _pictures() -> Part:
    if obstacle := views_obstacle():
        return Part("pictures", False, obstacle)
    if not sys.platform.startswith("linux"):
        how = f"by the drivers of {platform.system()}"
    else:
        found = find_backend(os.environ.get(CHOICE) or "")
        how = f"through {found.backend.name.upper()}, {found.renderer}"
    return Part("pictures", True, f"drawn off-screen {how}.")


def doctor_command(options: argparse.Namespace) -> Answer:
    """Check the installation: versions, kernels, display, extras."""
    parts = installation()

    # one row per part of the installation; extras that are absent are no fault
    lines = [f"{part.state:<7}  {part.name:<9} {part.detail}" for part in parts]
    data = [
        {"part": part.name, "ok": part.ok, "extra": part.extra, "detail": part.detail}
        for part in parts
    ]
    code = 0 if all(part.ok or part.extra for part in parts) else InputError.exit_code
    return Answer(data, "\n".join(lines), code)


def warmup_command(options: argparse.Namespace) -> Answer:
    """Compile all kernels, so that the next command starts at once."""
    # a line that is overwritten makes no sense in a file or a pipe
    show = sys.stderr.isatty() and not options.quiet

    def progress(n_done: int, n_file: int) -> None:
        """Show how many files are done, on one line."""
        print(f"\r{n_done} of {n_file} kernel files compiled", end="", file=sys.stderr, flush=True)

    done = warm(progress if show else None)
    clear_line()
    return Answer({"kernels": done}, done)


def info_command(options: argparse.Namespace) -> Answer:
    """Return what each file holds."""
    infos, code = [], 0
    for path in options.files:
        try:
            infos.append(info(path))
        except InputError as error:  # the others are shown all the same
            print(f"geosurf: {error}", file=sys.stderr)
            code = error.exit_code
    return Answer([asdict(one) for one in infos], "\n".join(map(str, infos)), code)
