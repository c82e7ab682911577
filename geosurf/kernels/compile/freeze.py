"""Freeze the kernels into a library, when a wheel is built.

By hand: ``python -m geosurf.kernels.compile.freeze --out folder``.

The kernels become one module of LLVM and one object file for each level of the CPU
(`object_files`); a C compiler makes a library of these together with `shim.c`.

This leans on private parts of numba and llvmlite (code libraries, passes, the calling
convention); so the build pins both exactly, and users never run this file.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from geosurf.errors import DependencyError, InputError
from geosurf.kernels.compile.frozen_runner import LEVELS, LIBRARY, MANIFEST, platform_name, stamp_of
from geosurf.kernels.compile.written_arguments import written_arguments

NOT_HERE = 3
_SHIM = Path(__file__).with_name("shim.c")


def freeze(out: Path, package: str = "geosurf.kernels") -> dict[str, Any]:
    """
    Make the frozen library of a package of kernels.

    Parameters
    ----------
    out : pathlib.Path
        Folder for library and manifest.
    package : str
        Name of the package; files that start with an underscore are left out.

    Returns
    -------
    dict
        The manifest.

    Raises
    ------
    DependencyError
        If kernels cannot be frozen here: an unknown platform, no C compiler, no numba.
    InputError
        If a kernel cannot be frozen.
    """
    # First what may be missing: compiling takes minutes.
    compiler = find_compiler()
    folder = Path(str(import_module(package).__file__)).parent

    # The stamp of the sources before they are compiled: a change meanwhile makes the library unfit,
    # not wrong.
    stamp = stamp_of(folder)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        objects, names = _objects(package, Path(scratch))
        _link(compiler, objects, out / LIBRARY)
    # A wheel must not tell where it was built, and builds should be equal to the byte.
    _look_for_paths(
        out / LIBRARY, [folder.parents[1], Path(sys.prefix), Path(tempfile.gettempdir())]
    )
    import llvmlite
    import numba

    # What has to agree before `frozen_runner` loads the library, and which arguments are written.
    manifest = {
        "stamp": stamp,
        "sha256": hashlib.sha256((out / LIBRARY).read_bytes()).hexdigest(),
        "platform": platform_name(),
        "levels": list(LEVELS[platform_name()]),
        "made_with": {"numba": numba.__version__, "llvmlite": llvmlite.__version__},
        "written": {name: written_arguments(str(folder))[name] for name in names},
    }
    (out / MANIFEST).write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
    return manifest


def find_compiler() -> list[str]:
    """Return the command of the C compiler: CC, or the first of cc, gcc and clang."""
    if platform_name() not in LEVELS:
        known = ", ".join(LEVELS)
        raise DependencyError(f"Kernels can be frozen on {known}, not on {platform_name()}.")
    if find_spec("numba") is None:
        raise DependencyError("Kernels cannot be frozen, since numba is not installed.")
    # CC may hold options too, as in `CC="gcc -m64"`.
    for command in filter(None, [os.environ.get("CC"), "cc", "gcc", "clang"]):
        words = shlex.split(command)
        if shutil.which(words[0]):
            return words
    raise DependencyError("Kernels cannot be frozen: no C compiler here (CC, cc, gcc, clang).")


# ---- object files, by processes of their own ----------------------------------------------


def _objects(package: str, scratch: Path) -> tuple[list[Path], list[str]]:
    """Object files, one for each level, and the names of the kernels in each."""
    module = scratch / "kernels.bc"
    levels = LEVELS[platform_name()]
    # Lowering is the same for all levels and is done once, at the lowest.
    (names,) = _run([_start(min(levels), "--package", package, "--module", str(module))])
    targets = {level: scratch / f"{level}.o" for level in levels}

    # Optimising differs by level: one process for each, at the same time.
    _run(
        _start(level, "--module", str(module), "--level", level, "--out", str(target))
        for level, target in targets.items()
    )
    return sorted(targets.values()), names.split()


def _start(level: str, *words: str) -> subprocess.Popen[str]:
    """Start a step for a level; numba reads the CPU from its environment."""
    # numba reads the CPU from these variables when it is imported, hence a process each.
    environment = {
        **os.environ,
        "GEOSURF_JIT": "1",
        "NUMBA_DISABLE_JIT": "0",
        "NUMBA_CPU_NAME": level,
        "NUMBA_CPU_FEATURES": "",
    }
    return subprocess.Popen(
        [sys.executable, "-m", "geosurf.kernels.compile.object_files", *words],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def _run(processes: Iterable[subprocess.Popen[str]]) -> list[str]:
    """Run some steps at the same time; their output."""
    running = list(processes)
    try:
        # Read to the end before any return code: a full pipe would stop a process.
        outputs = [process.communicate() for process in running]
    finally:
        for process in running:
            process.kill()  # does nothing to one that has ended
    for process, (_, complaint) in zip(running, outputs, strict=True):
        if process.returncode:
            raise InputError(f"freezing failed: {shlex.join(process.args)}\n{complaint}")
    return [output for output, _ in outputs]


# ---- all levels together -----------------------------------------------------------------


def _link(compiler: list[str], objects: Sequence[Path], library: Path) -> None:
    """Make one library; whatever it would lack when loaded is an error here."""
    # No contraction of a * b + c into one rounding: results have the bits of `numba_runner`. A
    # symbol that is missing is an error of the linker (-z defs), not of a user.
    command = [
        *compiler,
        *("-std=gnu11", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off"),
        *("-Wl,-z,defs", "-Wl,-z,noexecstack", "-Wl,-z,relro", "-Wl,--build-id=none", "-Wl,-s"),
        *("-o", str(library), _SHIM.name, *map(str, objects), "-lm"),
    ]
    done = subprocess.run(command, cwd=_SHIM.parent, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"the C compiler failed: {shlex.join(command)}\n{done.stderr}")


def _look_for_paths(library: Path, folders: Sequence[Path]) -> None:
    """Refuse a library that contains folders of the machine."""
    held = library.read_bytes()
    for folder in folders:
        # The root folder is part of every path.
        if len(folder.parts) > 1 and str(folder).encode() in held:
            raise InputError(
                f"{library} contains the path {folder}; it must not contain paths of this machine."
            )


def main(argv: Sequence[str] | None = None) -> int:
    """Freeze a package; returns `NOT_HERE` where that cannot be done."""
    parser = argparse.ArgumentParser(description="Freeze kernels into a library.")
    parser.add_argument("--out", type=Path, required=True, help="folder")
    parser.add_argument("--package", default="geosurf.kernels")
    options = parser.parse_args(argv)
    # The build of a wheel goes on without a library where this is returned.
    try:
        manifest = freeze(options.out, options.package)
    except DependencyError as error:
        sys.stderr.write(f"{error}\n")
        return NOT_HERE
    sys.stdout.write(f"{len(manifest['written'])} kernels frozen.\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
