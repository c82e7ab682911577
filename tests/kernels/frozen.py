"""Libraries to test with: frozen once for some sources, then kept beside the compiled kernels."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from importlib import import_module
from pathlib import Path

import pytest

from geosurf.errors import DependencyError
from geosurf.kernels.compile.freeze import freeze
from geosurf.kernels.compile.frozen_runner import MANIFEST, stamp_of
from geosurf.kernels.compile.numba_runner import kernel_folder
from geosurf.kernels.compile.platforms import ELF, PLATFORMS, platform_name


def folder_of(package: str) -> Path:
    return Path(str(import_module(package).__file__)).parent


def library_name() -> str:
    """File name of libraries on this platform; that of Linux where nothing is frozen."""
    here = PLATFORMS.get(platform_name())
    return here.format.library if here else ELF.library


def stamp_for(package: str) -> str:
    """The freezer's own sources count too, whatever package is frozen."""
    return f"{stamp_of(folder_of('geosurf.kernels'))[:12]}-{stamp_of(folder_of(package))[:12]}"


def frozen(package: str) -> Path:
    """Folder with the library of a package; skips the test where none can be made."""
    target = kernel_folder() / "frozen" / stamp_for(package)
    if not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(dir=target.parent))
        try:
            freeze(scratch, package)
        except DependencyError as error:
            shutil.rmtree(scratch)
            pytest.skip(str(error))
        try:
            scratch.rename(target)
        except OSError:  # another run was faster
            shutil.rmtree(scratch)
    return target


def only_level(source: Path, target: Path, level: str) -> Path:
    """The same library, with a manifest that knows one level."""
    target.mkdir()
    os.link(source / library_name(), target / library_name())
    manifest = json.loads((source / MANIFEST).read_text())
    assert level in manifest["levels"]
    (target / MANIFEST).write_text(json.dumps(manifest | {"levels": [level]}))
    return target
