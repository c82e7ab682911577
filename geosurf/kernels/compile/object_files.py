"""All kernels as one LLVM module, and the object file of a CPU level from it.

Each step runs in a process of its own, started by `freeze`, since numba reads the CPU from its
environment::

    python -m geosurf.kernels.compile.object_files --package geosurf.kernels --module kernels.bc
    python -m geosurf.kernels.compile.object_files --module kernels.bc --platform linux-x86_64 \
        --level x86-64-v3 --out v3.o

The first lowers every entry like a helper and links it with whatever it calls, each function
once. The module is for 64-bit platforms and says nothing of the CPU. The second makes everything
but the entries internal, optimises the whole as numba would one kernel, and emits it.
"""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Iterable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm
from numba.core.callconv import CPUCallConv
from numba.core.codegen import CPUCodeLibrary
from numba.core.registry import cpu_target
from numba.np import arrayobj

from geosurf.errors import InputError
from geosurf.kernels.compile.frozen_runner import symbol
from geosurf.kernels.compile.gate import kernel_files
from geosurf.kernels.compile.helpers import Helper, below, optimise
from geosurf.kernels.compile.numba_runner import check_results, types_of
from geosurf.kernels.compile.platforms import PLATFORMS, Platform

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.kernels.compile.jit import Entry

# what a frozen kernel may call: what the shim brings, and what libc and libm bring
_BROUGHT = {
    *("NRT_MemInfo_alloc_aligned", "NRT_MemInfo_call_dtor"),
    *("NRT_MemInfo_new_varsize_dtor", "NRT_MemInfo_varsize_realloc"),
    *("NRT_Allocate", "NRT_Free"),
    *("numba_frexp", "numba_ldexp", "memcpy", "memset", "memmove"),
    *("sqrt", "floor", "ceil", "trunc", "rint", "hypot", "_hypot"),  # the last one on Windows
    *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "pow"),
}
_MARK = "geosurf_kernel."


def main(argv: Sequence[str] | None = None) -> int:
    """Lower a package of kernels, or emit a level of it; prints kernels and their arguments."""
    parser = argparse.ArgumentParser(description="Make object files of kernels.")
    parser.add_argument("--module", type=Path, required=True, help="file for the module of LLVM")
    parser.add_argument("--package", help="lower these kernels into it")
    parser.add_argument("--platform", help="make an object file of it for this platform")
    parser.add_argument("--level", help="and for this level of the CPU")
    parser.add_argument("--out", type=Path, help="where the object file goes")
    options = parser.parse_args(argv)
    gc.disable()  # numba makes millions of small objects that live as long as the process
    if options.package:
        module, kernels = lower(options.package)
        options.module.write_bytes(module)
        sys.stdout.write("\n".join(" ".join([name, *of]) for name, of in kernels.items()))
    else:
        options.out.write_bytes(emit(options.module.read_bytes(), options.platform, options.level))
    return 0


# ---- lower -------------------------------------------------------------------------------


def lower(package: str) -> tuple[bytes, dict[str, tuple[str, ...]]]:
    """Lower all entries of a package, with what they call, into one module.

    Parameters
    ----------
    package : str

    Returns
    -------
    module : bytes
        Bitcode; entries bear their names behind a mark.
    kernels : dict of str to tuple of str
        Letters of the arguments of each entry.

    Raises
    ------
    InputError
        If there are no entries.
    """
    # Before anything is lowered: these change what is written into code.
    _forget_folders()
    _forget_shapes()
    _forget_processor()
    entries = _entries(package)
    if not entries:
        raise InputError(f"{package} has no entries, so that there is nothing to freeze.")
    # In order of names, so that equal sources make equal libraries.
    made = {name: _lower(name, kernel) for name, kernel in sorted(entries.items())}
    libraries = [library for library, _ in made.values()]
    for library, name in made.values():
        library._final_module.get_function(name).linkage = "external"  # or nobody asks for it
    module = llvm.parse_assembly("")
    # Callers first: the linker takes from each library what was asked for so far.
    for part in [*libraries, *below(*libraries)]:
        module.link_in(part._get_module_for_linking(), preserve=True)
    # A mark instead of numba's names, which differ from run to run.
    for name, (_, llvm_name) in made.items():
        module.get_function(llvm_name).name = _MARK + name
    return module.as_bitcode(), {name: entries[name].signature.arguments for name in made}


def _entries(package: str) -> dict[str, Entry]:
    from geosurf.kernels.compile.jit import ENTRIES

    folder = Path(str(import_module(package).__file__)).parent
    # Importing a kernel file registers its entries.
    for path in kernel_files(folder):
        import_module(".".join([package, *path.relative_to(folder).with_suffix("").parts]))
    return {n: e for n, e in ENTRIES.items() if e.python.__module__.startswith(f"{package}.")}


def _lower(name: str, kernel: Entry) -> tuple[Any, str]:
    """Code of one entry, and its name there; what it calls lies below it."""
    # As a helper an entry has no wrappers; it counts references, since it may return arrays.
    helper = Helper(kernel.python, counts=True)
    types = types_of(kernel.signature.arguments)
    helper.compile(types)
    result = helper.overloads[types]
    check_results(name, result.signature.return_type, kernel.signature)
    return result.library, result.fndesc.llvm_func_name


def _forget_folders() -> None:
    """Keep the folders of this machine out of what exceptions say about their place."""
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
    # The function object is referenced already, so its code is exchanged.
    named = arrayobj.ol_raise_with_shape_context_cpu
    named.__code__ = arrayobj.ol_raise_with_shape_context_generic.__code__


def _forget_processor() -> None:
    """Link functions of numba's own as they were before machine code was made of them.

    numba makes machine code of them at once, for the processor of this machine, and LLVM leaves
    instructions of that processor behind in the module: for counts of references, for example.
    """
    original = CPUCodeLibrary._finalize_final_module

    def finalize(library: Any) -> None:
        untouched = library._final_module.clone()
        original(library)
        if any(not function.is_declaration for function in untouched.functions):
            compiled, library._final_module = library._final_module, untouched
            library._get_module_for_linking()  # remembered by the library
            library._final_module = compiled

    CPUCodeLibrary._finalize_final_module = finalize


# ---- emit --------------------------------------------------------------------------------


def emit(bitcode: bytes, platform: str, level: str) -> bytes:
    """Optimise a module and make an object file of it.

    Parameters
    ----------
    bitcode : bytes
        As `lower` gives it.
    platform : str
        Key of `PLATFORMS`.
    level : str
        Of its CPU.

    Returns
    -------
    bytes

    Raises
    ------
    InputError
        If a kernel calls what the library will not have.
    """
    # Once per process; numba initialises only the CPU of this machine.
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = PLATFORMS[platform]
    module = llvm.parse_bitcode(bitcode)
    marked = [f.name for f in module.functions if f.name.startswith(_MARK)]
    machine = llvm.Target.from_triple(target.triple).create_target_machine(
        cpu=level, features="", opt=3, reloc="pic", codemodel="default"
    )
    module = _optimised(module, target, marked, machine)
    # All together are quick to test. Only if something is wrong: kernel by kernel, to name it.
    if foreign(module):
        for name in marked:  # which one was it?
            alone = _optimised(llvm.parse_bitcode(bitcode), target, [name], machine)
            refuse_foreign(name.removeprefix(_MARK), alone)
    # Each level has its own names, as all levels share one library.
    for name in marked:
        function = module.get_function(name)
        function.name = symbol(level, name.removeprefix(_MARK))
        if target.format.exports_by_name:
            function.storage_class = "dllexport"
    return bytes(machine.emit_object(module))


def _optimised(module: Any, target: Platform, names: Iterable[str], machine: Any) -> Any:
    """The same functions after numba's passes, and only what they need."""
    # numba's passes ask its machine what is cheap there, and which functions there are.
    cpu_target.target_context.codegen()._tm = machine
    # Lowered by the numba of this machine; sizes of types are the same on all 64-bit platforms.
    module.triple, module.data_layout = target.triple, str(machine.target_data)
    # Before, so that the passes see what is internal; afterwards, to drop what was inlined
    # everywhere.
    _keep(module, set(names), machine)
    module = optimise(module)
    _count_in_place(module, machine)
    _keep(module, set(names), machine)
    return module


# A block of memory belongs to the call that made it: no other thread counts its owners before it is
# a result, whose owner is Python (`shim.c`).
_COUNTS = """
declare void @NRT_MemInfo_call_dtor(ptr)
define void @NRT_incref(ptr %block) alwaysinline nounwind {
  %none = icmp eq ptr %block, null
  br i1 %none, label %done, label %count
count:
  %old = load i64, ptr %block
  %new = add i64 %old, 1
  store i64 %new, ptr %block
  br label %done
done:
  ret void
}
define void @NRT_decref(ptr %block) alwaysinline nounwind {
  %none = icmp eq ptr %block, null
  br i1 %none, label %done, label %count
count:
  %old = load i64, ptr %block
  %new = sub i64 %old, 1
  store i64 %new, ptr %block
  %last = icmp eq i64 %new, 0
  br i1 %last, label %drop, label %done
drop:
  call void @NRT_MemInfo_call_dtor(ptr %block)
  br label %done
done:
  ret void
}
"""


def _count_in_place(module: Any, machine: Any) -> None:
    """Count owners of arrays where that is asked for, and not atomically.

    numba calls a function for that, since its passes drop pairs of such calls; they have run. The
    calls that are left, one for each view of an array, took a fortieth of a realisation with throw.
    """
    there = {function.name: function for function in module.functions}
    names = [name for name in ("NRT_incref", "NRT_decref") if name in there]
    if not names:
        return
    counts = llvm.parse_assembly(_COUNTS)
    counts.triple, counts.data_layout = module.triple, str(machine.target_data)
    for name in names:
        if not there[name].is_declaration:
            there[name].linkage = "linkonce_odr"  # the linker takes ours in its place
    module.link_in(counts)
    passes = llvm.create_new_module_pass_manager()
    passes.add_always_inliner_pass()
    passes.add_sroa_pass()
    passes.add_instruction_combine_pass()
    passes.add_jump_threading_pass()
    passes.add_simplify_cfg_pass()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))


def _keep(module: Any, names: set[str], machine: Any) -> None:
    """Leave some functions, and only what they need."""
    for function in module.functions:
        if not function.is_declaration:
            function.linkage = "external" if function.name in names else "internal"
    for variable in module.global_variables:
        if not variable.is_declaration:
            variable.linkage = "internal"
    # Removes functions and constants that nothing refers to any more.
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
    module.verify()


def foreign(module: Any) -> set[str]:
    """Names that a module calls and the library will not have."""
    # A declaration without a body is something that the library has to find elsewhere.
    called = {f.name for f in module.functions if f.is_declaration}
    return {name for name in called if not name.startswith("llvm.")} - _BROUGHT


def refuse_foreign(name: str, module: Any) -> None:
    """Refuse a kernel that needs more of numba's runtime, or Python itself."""
    called = foreign(module)
    if called:
        raise InputError(
            f"kernel {name} calls {', '.join(sorted(called))}, which a frozen library "
            "does not bring: kernels take and give arrays and numbers, and raise constant texts."
        )


if __name__ == "__main__":
    sys.exit(main())
