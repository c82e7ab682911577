"""Freeze the kernels into a library, when a wheel is built.

By hand: ``python -m geosurf.kernels.compile.freeze --out folder``, with ``--platform win32-x86_64``
for another platform than this one.

The kernels become one module of LLVM and one object file for each level of the CPU
(`object_files`); a C compiler makes a library of these together with `shim.c` and the functions of
`call_wrappers`. What differs between platforms is in `platforms`. For another platform the compiler
is zig (``pip install ziglang``), which brings the C libraries of all of them.

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
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from geosurf.errors import DependencyError, InputError
from geosurf.kernels.compile.frozen_runner import MANIFEST, stamp_of
from geosurf.kernels.compile.platforms import (
    COFF,
    PLATFORMS,
    Platform,
    platform_name,
    source_of_wrappers,
)

NOT_HERE = 3
_SHIM = Path(__file__).with_name("shim.c")


def freeze(
    out: Path, package: str = "geosurf.kernels", platform: str | None = None
) -> dict[str, Any]:
    """
    Make the frozen library of a package of kernels.

    Parameters
    ----------
    out : pathlib.Path
        Folder for library and manifest.
    package : str
        Name of the package; files that start with an underscore are left out.
    platform : str, optional
        Key of `PLATFORMS`; by default the platform of this process.

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
    compiler = find_compiler(platform)
    target_name = platform or platform_name()
    target = PLATFORMS[target_name]
    folder = Path(str(import_module(package).__file__)).parent

    # The stamp of the sources before they are compiled: a change meanwhile makes the library unfit,
    # not wrong.
    stamp = stamp_of(folder)
    out.mkdir(parents=True, exist_ok=True)
    library = out / target.format.library
    with tempfile.TemporaryDirectory() as scratch:
        objects, kernels = _objects(package, target_name, Path(scratch))
        calls = Path(scratch) / "calls.c"
        calls.write_text(source_of_wrappers(kernels.values()), encoding="utf-8")
        # Linkers leave other files beside what they make.
        linked = Path(scratch) / library.name
        _link(compiler, target, [calls, *objects], linked)
        if target.format is COFF:
            _forget_time(linked)
        shutil.copy(linked, library)
    # A wheel must not tell where it was built, and builds should be equal to the byte.
    _look_for_paths(library, [folder.parents[1], Path(sys.prefix), Path(tempfile.gettempdir())])
    import llvmlite
    import numba

    # What has to agree before `frozen_runner` loads the library.
    manifest = {
        "stamp": stamp,
        "sha256": hashlib.sha256(library.read_bytes()).hexdigest(),
        "platform": target_name,
        "levels": list(target.levels),
        "made_with": {"numba": numba.__version__, "llvmlite": llvmlite.__version__},
        "kernels": sorted(kernels),
    }
    (out / MANIFEST).write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
    return manifest


def find_compiler(platform: str | None = None) -> list[str]:
    """
    Return the command of the C compiler that links the library.

    Parameters
    ----------
    platform : str, optional
        Key of `PLATFORMS`: then zig. By default this platform: CC, or the first of cc, gcc, clang
        and zig.

    Returns
    -------
    list of str

    Raises
    ------
    DependencyError
        If the platform is unknown, or there is no compiler or no numba.
    """
    name = platform or platform_name()
    if name not in PLATFORMS:
        known = ", ".join(PLATFORMS)
        raise DependencyError(f"Kernels can be frozen for {known}, not for {name}.")
    if find_spec("numba") is None:
        raise DependencyError("Kernels cannot be frozen, since numba is not installed.")
    # CC may hold options too, as in `CC="gcc -m64"`; a compiler for another platform is zig.
    commands = ["cc", "gcc", "clang"] if platform is None else []
    for command in filter(None, [os.environ.get("CC"), *commands]):
        words = shlex.split(command)
        if shutil.which(words[0]):
            return words
    if find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[name].zig]
    raise DependencyError(
        f"Kernels cannot be frozen for {name}: no C compiler here (CC"
        f"{''.join(f', {command}' for command in commands)}, or `pip install ziglang`)."
    )


# ---- object files, by processes of their own ----------------------------------------------


def _objects(package: str, platform: str, scratch: Path) -> tuple[list[Path], dict[str, list[str]]]:
    """Object files, one for each level, and the kernels in each, with letters of arguments."""
    module = scratch / "kernels.bc"
    levels = PLATFORMS[platform].levels
    # Lowering is the same for all levels and is done once.
    (listed,) = _run([_start("--package", package, "--module", str(module))])
    targets = {level: scratch / f"{level}.o" for level in levels}

    # Optimising differs by level: one process for each, at the same time.
    words = ("--module", str(module), "--platform", platform)
    _run(
        _start(*words, "--level", level, "--out", str(target)) for level, target in targets.items()
    )
    kernels = [line.split() for line in listed.splitlines()]
    return sorted(targets.values()), {name: letters for name, *letters in kernels}


def _start(*words: str) -> subprocess.Popen[str]:
    """Start a step; numba reads the CPU from its environment."""
    # numba itself sees no particular CPU: the machine code is for that of the level.
    environment = {
        **os.environ,
        "GEOSURF_JIT": "1",
        "NUMBA_DISABLE_JIT": "0",
        "NUMBA_CPU_NAME": "generic",
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


def _link(compiler: list[str], target: Platform, objects: Sequence[Path], library: Path) -> None:
    """Make one library; whatever it would lack when loaded is an error here."""
    # No contraction of a * b + c into one rounding: results have the bits of `numba_runner`.
    command = [
        *compiler,
        *("-std=gnu11", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-g0"),
        *("-o", str(library), _SHIM.name, *map(str, objects), *target.format.flags),
    ]
    done = subprocess.run(command, cwd=_SHIM.parent, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"the C compiler failed: {shlex.join(command)}\n{done.stderr}")


def _forget_time(library: Path) -> None:
    """Set the times in a library of Windows to 0, which its linker has no option for.

    They are in the header of the file and in the table of exports (Microsoft, *PE Format*).
    """
    held = bytearray(library.read_bytes())
    (header,) = struct.unpack_from("<I", held, 0x3C)
    n_section, options_size = struct.unpack_from("<2xH12xH", held, header + 4)
    options = header + 24
    (exports,) = struct.unpack_from("<I", held, options + 112)  # its address when loaded
    sections = (
        struct.unpack_from("<8xIIII", held, options + options_size + 40 * i)
        for i in range(n_section)
    )
    places = [header + 8] + [
        start + exports - address + 4
        for _, address, size, start in sections
        if address <= exports < address + size
    ]
    for place in places:
        struct.pack_into("<I", held, place, 0)
    library.write_bytes(held)


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
    parser.add_argument("--platform", help=f"one of {', '.join(PLATFORMS)}; default: this one")
    options = parser.parse_args(argv)
    # The build of a wheel goes on without a library where this is returned.
    try:
        manifest = freeze(options.out, options.package, options.platform)
    except DependencyError as error:
        sys.stderr.write(f"{error}\n")
        return NOT_HERE
    sys.stdout.write(f"{len(manifest['kernels'])} kernels frozen.\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
