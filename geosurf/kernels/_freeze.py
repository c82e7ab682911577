"""Freeze the kernels into a library, when a wheel is built: ``python -m geosurf.kernels._freeze``.

numba compiles each entry to a module of LLVM that holds everything it calls. The modules are
linked, everything but the entries is made internal, what only Python would need falls away,
and a C compiler makes a library of it together with `_shim.c`. Each level of the CPU is made by
a process of its own, since numba reads the CPU from its environment.

This leans on private parts of numba and llvmlite (`_final_module`, `llvm_func_name`, the
calling convention); so the build pins both exactly, and users never run this file.
"""

from __future__ import annotations

import argparse
import gc
import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

from geosurf.errors import DependencyError, InputError
from geosurf.kernels._frozen import LEVELS, LIBRARY, MANIFEST, platform_name, stamp_of, symbol
from geosurf.kernels._writes import written_arguments

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.kernels._jit import Entry

NOT_HERE = 3
_SHIM = Path(__file__).with_name("_shim.c")
# what a frozen kernel may call: what the shim brings, and what libc and libm bring
_BROUGHT = {
    *("NRT_MemInfo_alloc_aligned", "NRT_MemInfo_call_dtor"),
    *("NRT_MemInfo_new_varsize_dtor", "NRT_MemInfo_varsize_realloc"),
    *("NRT_Allocate", "NRT_Free"),
    *("numba_frexp", "numba_ldexp", "memcpy", "memset", "memmove"),
    *("sqrt", "floor", "ceil", "trunc", "rint", "hypot"),
    *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "pow"),
}


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
    compiler = find_compiler()
    folder = Path(str(import_module(package).__file__)).parent
    stamp = stamp_of(folder)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        made = _objects(package, Path(scratch))
        _link(compiler, sorted(made), out / LIBRARY)
    _look_for_paths(
        out / LIBRARY, [folder.parents[1], Path(sys.prefix), Path(tempfile.gettempdir())]
    )
    import llvmlite
    import numba

    manifest = {
        "stamp": stamp,
        "sha256": hashlib.sha256((out / LIBRARY).read_bytes()).hexdigest(),
        "platform": platform_name(),
        "levels": list(LEVELS[platform_name()]),
        "made_with": {"numba": numba.__version__, "llvmlite": llvmlite.__version__},
        "written": {name: written_arguments(str(folder))[name] for name in made[min(made)]},
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
    for command in filter(None, [os.environ.get("CC"), "cc", "gcc", "clang"]):
        words = shlex.split(command)
        if shutil.which(words[0]):
            return words
    raise DependencyError("Kernels cannot be frozen: no C compiler here (CC, cc, gcc, clang).")


# ---- one level, in a process of its own --------------------------------------------------


def _objects(package: str, scratch: Path) -> dict[Path, list[str]]:
    """Let one process per level make an object file; return the entries in each."""
    running = {}
    for level in LEVELS[platform_name()]:
        target = scratch / f"{level}.o"
        environment = {
            **os.environ,
            "GEOSURF_JIT": "1",
            "NUMBA_DISABLE_JIT": "0",
            "NUMBA_CPU_NAME": level,
            "NUMBA_CPU_FEATURES": "",
        }
        command = [sys.executable, "-m", "geosurf.kernels._freeze", "--package", package]
        running[target] = subprocess.Popen(
            [*command, "--level", level, "--out", str(target)],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
    try:
        said = {target: process.communicate() for target, process in running.items()}
    finally:
        for process in running.values():
            process.kill()  # does nothing to one that has ended
    for target, process in running.items():
        if process.returncode:
            raise InputError(f"freezing for {target.stem} failed:\n{said[target][1]}")
    return {target: out.split() for target, (out, _) in said.items()}


def _make_object(package: str, level: str, target: Path) -> list[str]:
    """Compile all entries for one level into one object file; return their names."""
    import llvmlite.binding as llvm

    from geosurf.kernels._jit import ENTRIES

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    gc.disable()  # numba makes millions of small objects that live as long as the process
    kernels = import_module(package)
    for found in iter_modules(kernels.__path__, f"{package}."):
        if not found.name.rpartition(".")[2].startswith("_"):
            import_module(found.name)
    entries = {n: e for n, e in ENTRIES.items() if e.python.__module__.startswith(f"{package}.")}
    _forget_folders()
    _forget_shapes()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=level, features="", opt=3, reloc="pic", codemodel="default"
    )
    linked = None
    names = {}
    for name, kernel in sorted(entries.items()):
        bitcode, llvm_name = _compile(name, kernel)
        names[llvm_name] = symbol(level, name)
        alone = llvm.parse_bitcode(bitcode)
        _keep(alone, {llvm_name: names[llvm_name]}, machine)
        _only_what_we_bring(name, alone)
        if linked is None:
            linked = llvm.parse_bitcode(bitcode)
        else:
            linked.link_in(llvm.parse_bitcode(bitcode))
    if linked is None:
        raise InputError(f"{package} has no entries, so that there is nothing to freeze.")
    _keep(linked, names, machine)
    target.write_bytes(machine.emit_object(linked))
    return sorted(entries)


def _compile(name: str, kernel: Entry) -> tuple[bytes, str]:
    """Bitcode of one entry with all that it calls, and its name there."""
    from geosurf.kernels._numba import check_results, compiled, types_of

    dispatcher = compiled(kernel.python)
    types = types_of(kernel.signature.arguments)
    dispatcher.compile(types)
    result = dispatcher.overloads[types]
    check_results(name, result.signature.return_type, kernel.signature)
    return result.library._final_module.as_bitcode(), result.fndesc.llvm_func_name


def _keep(module: Any, names: dict[str, str], machine: Any) -> None:
    """Leave the entries under their names in the library, and only what they need."""
    import llvmlite.binding as llvm

    for function in module.functions:
        if not function.is_declaration:
            function.linkage = "external" if function.name in names else "internal"
    for variable in module.global_variables:
        if not variable.is_declaration:
            variable.linkage = "internal"
    for old, new in names.items():
        module.get_function(old).name = new
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
    module.verify()


def _only_what_we_bring(name: str, module: Any) -> None:
    """Refuse a kernel that needs more of numba's runtime, or Python itself."""
    foreign = {
        function.name
        for function in module.functions
        if function.is_declaration and not function.name.startswith("llvm.")
    }
    if foreign - _BROUGHT:
        raise InputError(
            f"kernel {name} calls {', '.join(sorted(foreign - _BROUGHT))}, which a frozen library "
            "does not bring: kernels take and give arrays and numbers, and raise constant texts."
        )


def _forget_folders() -> None:
    """Keep the folders of this machine out of what exceptions say about their place."""
    from numba.core.callconv import CPUCallConv

    original = CPUCallConv.build_excinfo_struct

    def nameless(self: Any, exc: Any, exc_args: Any, loc: Any, func_name: Any) -> Any:
        kind, arguments, place = original(self, exc, exc_args, loc, func_name)
        return kind, arguments, place and (place[0], Path(place[1]).name, place[2])

    CPUCallConv.build_excinfo_struct = nameless


def _forget_shapes() -> None:
    """Let an assignment to a slice fail with a constant text.

    By default numba names both shapes, for which the library would need Python's strings. It
    has the text without them for targets that have no strings.
    """
    from numba.np import arrayobj

    named = arrayobj.ol_raise_with_shape_context_cpu
    named.__code__ = arrayobj.ol_raise_with_shape_context_generic.__code__


# ---- all levels together -----------------------------------------------------------------


def _link(compiler: list[str], objects: Sequence[Path], library: Path) -> None:
    """Make one library; whatever it would lack when loaded is an error here."""
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
    """Refuse a library that tells where it was made."""
    held = library.read_bytes()
    for folder in folders:
        if len(folder.parts) > 1 and str(folder).encode() in held:
            raise InputError(f"{library} names {folder}; nothing of the machine may be inside.")


def main(argv: Sequence[str] | None = None) -> int:
    """Freeze a package, or one level of it; returns `NOT_HERE` where that cannot be done."""
    parser = argparse.ArgumentParser(description="Freeze kernels into a library.")
    parser.add_argument("--out", type=Path, required=True, help="folder, or file with --level")
    parser.add_argument("--package", default="geosurf.kernels")
    parser.add_argument("--level", help="only the object file of this level")
    options = parser.parse_args(argv)
    if options.level:
        names = _make_object(options.package, options.level, options.out)
        sys.stdout.write("\n".join(names))
        return 0
    try:
        manifest = freeze(options.out, options.package)
    except DependencyError as error:
        sys.stderr.write(f"{error}\n")
        return NOT_HERE
    sys.stdout.write(f"{len(manifest['written'])} kernels frozen.\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
