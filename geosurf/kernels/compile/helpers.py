"""Helpers of kernels under numba: typed and lowered once, optimised only inside their entries.

numba makes a library of its own for every compiled function: it links in the finished libraries
of all that is called, optimises the whole anew, and turns it into machine code. With helpers
ten calls deep, LLVM would see the same code dozens of times, and nearly all machine code would
never run, since Python calls nothing but entries. Here a helper stays what its lowering made of
it. An entry links each helper below it once, and LLVM optimises that one module, callees
first, as a C compiler does with one file.

This is the one place where options of numba are chosen, and a change here
makes cached kernels stale (`numba_runner`). ``fastmath`` stays off everywhere: it would
break exact arithmetic. No index is counted from the end of an array (`_indices_as_they_are`).
``boundscheck`` is off when compiled: NUMBA_BOUNDSCHECK=1, with a GEOSURF_CACHE_DIR of its own,
compiles kernels that check every index, and NUMBA_DISABLE_JIT=1 runs them as plain Python.

It leans on private parts of numba (the code library, the lowering pass, the index of an array and
the resolution of calls), as the cache and the freezer do.
"""

from __future__ import annotations

import gc
import itertools
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.binding as llvm
from numba.core import types
from numba.core.bytecode import FunctionIdentity
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary
from numba.core.compiler import Compiler, CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.targetconfig import ConfigStack, TargetConfig
from numba.core.typed_passes import NativeLowering
from numba.core.types.functions import BaseFunction
from numba.np import arrayobj

# nogil: stages call kernels from threads. The error model of numpy: a division by zero gives
# infinity instead of an exception and a branch.
_OPTIONS = {"nopython": True, "nogil": True, "error_model": "numpy"}
# what makes arrays or lists inside a kernel; a maker that is missing here does not compile
_MAKERS = frozenset(
    "append arange argsort array asarray concatenate copy empty empty_like flatten full ones "
    "searchsorted sort unique zeros zeros_like".split()
)


class HelperLibrary(JITCodeLibrary):
    """The code of one helper as it was lowered; what it calls is linked by the entry."""

    def finalize(self) -> None:
        """Leave it as it is, ready to be merged into any number of entries."""
        self._raise_if_finalized()
        # Several entries may be linked into one process: equal helpers count as one definition.
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "linkonce_odr"
        self._shared_module = self._final_module
        self._finalized = True


class EntryLibrary(JITCodeLibrary):
    """The code of one entry with that of all helpers below it."""

    def finalize(self) -> None:
        """Link everything below, each library once, then optimise."""
        # Helpers of helpers too, each once; numba would link finished copies.
        self._linking_libraries = below(self)
        super().finalize()

    def _optimize_final_module(self) -> None:
        """Let LLVM know that nobody else calls the helpers, then optimise.

        So it may drop the parts of an array that a helper never looks at: an array goes by value,
        in seven words or nine, and exact cutting hands on ten. A third of its time is gone.
        """
        # Only helpers: numba's own runtime keeps its linkage.
        helpers = {
            function.name
            for library in self._linking_libraries
            if isinstance(library, HelperLibrary)
            for function in library._final_module.functions
        }
        # Internal functions have no other callers, so LLVM may drop and reorder their arguments.
        for function in self._final_module.functions:
            if function.name in helpers and not function.is_declaration:
                function.linkage = llvm.Linkage.internal
        super()._optimize_final_module()


def optimise(module: Any) -> Any:
    """Run over a module the passes that numba runs over an entry with all that it needs."""
    library = EntryLibrary(cpu_target.target_context.codegen(), "optimised")
    library._final_module = module
    library._optimize_final_module()
    return library._final_module


def below(*libraries: CPUCodeLibrary) -> list[CPUCodeLibrary]:
    """All libraries that some need, each once, in an order in which they can be linked.

    The linker takes from a library what has been asked for so far. So a helper comes after its
    callers, and numba's own libraries, which hold what they need themselves, come last.
    """
    helpers: dict[CPUCodeLibrary, None] = {}
    finished: dict[CPUCodeLibrary, None] = {}

    # Reversed, since the list is worked off from its end.
    waiting = [part for library in reversed(libraries) for part in library._linking_libraries[::-1]]
    while waiting:
        needed = waiting.pop()
        if not isinstance(needed, HelperLibrary):
            finished[needed] = None
        # A helper that is reached again is in the list already.
        elif needed not in helpers:
            helpers[needed] = None
            waiting += needed._linking_libraries[::-1]
    return [*helpers, *finished]


def makes_arrays(function: Callable[..., Any]) -> bool:
    """Whether a helper makes arrays or lists, or calls one that does.

    Only such a helper has to count who holds an array. To all others arrays are lent by their
    caller: counting there, atomic and once per argument and call, took half of the time of
    exact cutting, where helpers have ten arrays and a few nanoseconds of work.
    """
    # Names that the code refers to: an upper bound of what it calls.
    names = function.__code__.co_names
    if not _MAKERS.isdisjoint(names):
        return True
    # The helpers it calls are defined before it, so they know the answer.
    called = (function.__globals__.get(name) for name in names)
    return any(getattr(helper, "counts", False) for helper in called)


class Helper(CPUDispatcher):
    """What `scalar` makes of a function: code for other kernels; Python runs it as it is written.

    Parameters
    ----------
    function : callable
    counts : bool, optional
        Whether it counts who holds an array; by default if it makes some.
    """

    def __init__(self, function: Callable[..., Any], counts: bool | None = None) -> None:
        self.counts = makes_arrays(function) if counts is None else counts
        # Without wrappers for Python and C, which nothing calls.
        options = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": self.counts}
        super().__init__(function, {}, _OPTIONS | options, _HelperCompiler)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.py_func(*arguments, **named)

    def add_overload(self, result: Any) -> None:
        """Remember a version, for callers in kernels only."""
        self.overloads[tuple(result.signature.args)] = result

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """One version per types: constants are passed as plain numbers.

        numba would compile one for each constant (180 functions instead of 130 for one scene).
        """
        named = {name: types.unliteral(kind) for name, kind in dict(kws).items()}
        return super().get_call_template(tuple(map(types.unliteral, args)), named)


def entry_dispatcher(function: Callable[..., Any]) -> Any:
    """What numba's decorator gives, with our compiler."""
    return CPUDispatcher(function, {}, _OPTIONS, _EntryCompiler)


def names_of_its_own() -> None:
    """Let the names of functions that are compiled next be like no others, whoever compiled those.

    numba names each function by a count that begins at 1 in every process, and links kernels
    that it finds in a cache by these names. Two that were compiled in two processes may then
    call each other's parts: a kernel that sorted in place was linked to the `argsort` of
    another, which crashed. So each kernel counts from a place that is its own.
    """
    # 56 random bits: two processes do not meet.
    FunctionIdentity._unique_ids = itertools.count(int.from_bytes(os.urandom(7), "big"))


class _Handle:
    """Stands for a helper where numba keeps the machine code of a function."""


@contextmanager
def _indices_as_they_are(module: str) -> Iterator[None]:
    """While a function of ours is lowered, an index below 0 is not counted from the end.

    Kernels have none, and to ask at each index took a fifth of their time and of compiling them.
    Functions of numba's own that are compiled meanwhile, each in a module of its own, keep it.

    Parameters
    ----------
    module : str
        Of the function that is lowered.
    """
    # numba has no option for this, so its function is exchanged while one of ours is lowered.
    from_end = arrayobj.fix_integer_index

    def index(context: Any, builder: Any, kind: Any, value: Any, size: Any) -> Any:
        # Unsigned indices, and functions of other modules, go numba's way.
        if builder.module.name != module or not kind.signed:
            return from_end(context, builder, kind, value, size)
        return context.cast(builder, value, kind, types.intp)

    arrayobj.fix_integer_index = index
    try:
        yield
    finally:
        arrayobj.fix_integer_index = from_end


_resolved: dict[Any, tuple[BaseFunction, Any]] = {}
_resolving: list[bool] = []


@contextmanager
def _calls_resolved_once() -> Iterator[None]:
    """While an entry is compiled, numba finds out once what ``a + b`` of two types means.

    It tries dozens of templates for each operator wherever one stands, and compares all options
    each time: a quarter of the time that kernels take to compile. Another eighth goes to looking
    for garbage among millions of objects that are all in use; that waits until the end.
    """
    if _resolving:  # the entry above does so already
        yield
        return
    resolve, is_equal = BaseFunction.get_call_type, TargetConfig.__eq__

    def call_type(function: Any, context: Any, args: Any, kws: Any) -> Any:
        options = ConfigStack.top_or_none()
        chosen = "" if options is None else str(options._values)
        key = id(function), tuple(args), tuple(kws.items()), chosen
        if key not in _resolved:
            # With the function, so that its identity stays taken.
            _resolved[key] = function, resolve(function, context, args, kws)
        return _resolved[key][1]

    def equal(options: Any, others: Any) -> Any:
        same = type(options) is type(others) and options._values == others._values
        return same or is_equal(options, others)

    BaseFunction.get_call_type, TargetConfig.__eq__ = call_type, equal
    _resolving.append(True)
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()
        _resolving.clear()
        BaseFunction.get_call_type, TargetConfig.__eq__ = resolve, is_equal


@register_pass(mutates_CFG=True, analysis_only=False)
class _HelperLowering(NativeLowering):
    """Lower a helper, and tell numba where callers find it; nothing is compiled."""

    _name = "geosurf_helper_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower without machine code."""
        # Machine code is made for entries only.
        state.flags.no_compile = True
        state.library = _library(state, HelperLibrary)
        with _indices_as_they_are(state.func_id.unique_name):
            super().run_pass(state)
        lowered = state["cr"]

        # numba identifies code by an object with this attribute; no code stands behind it.
        state["cr"] = lowered._replace(cfunc=_Handle())
        state.library.finalize()
        state.targetctx.insert_user_function(state["cr"].cfunc, lowered.fndesc, [state.library])
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class _EntryLowering(NativeLowering):
    """Lower an entry into a library that gathers its helpers."""

    _name = "geosurf_entry_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower, link, optimise and compile."""
        state.library = _library(state, EntryLibrary)
        # What is compiled can be pickled, for the cache.
        state.library.enable_object_caching()
        with _indices_as_they_are(state.func_id.unique_name):
            return super().run_pass(state)


def _library(state: Any, kind: type[JITCodeLibrary]) -> JITCodeLibrary:
    return kind(state.targetctx.codegen(), state.func_id.func_qualname)


def _with(lowering: type[NativeLowering]) -> type[CompilerBase]:
    """numba's compiler with another lowering."""

    class Lowering(Compiler):
        def define_pipelines(self) -> list[Any]:
            passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
            # All passes of numba stay as they are, except the one that lowers.
            places = [i for i, (kind, _) in enumerate(passes.passes) if kind is NativeLowering]
            passes.passes[places[0]] = (lowering, "lowering")
            passes._finalized = False
            passes.finalize()
            return [passes]

        def compile_extra(self, func: Any) -> Any:
            with _calls_resolved_once():
                return super().compile_extra(func)

    return Lowering


_HelperCompiler = _with(_HelperLowering)
_EntryCompiler = _with(_EntryLowering)
