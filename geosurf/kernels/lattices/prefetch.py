"""Prefetching: memory is requested before it is read.

A number that is in no cache takes a hundred nanoseconds to arrive. Where a kernel knows early what
it will read, at scattered addresses, it requests it and continues with other work. Results do not
change. One horizon of 40 MB and twenty faults: nodes of faces are loaded in half the time, pairs of
triangles found in nine tenths.
"""

from __future__ import annotations

from typing import Any

from geosurf.kernels.compile.jit import RUNNER

_READ, _KEEP, _DATA = 0, 3, 1  # arguments of llvm.prefetch: for reading, into all caches, data


def prefetch(values, i):
    """Request the memory at row i of an array; the row need not exist. Does nothing in plain
    Python.
    """


def _instruction() -> Any:
    """`prefetch` for compiled kernels: one instruction, for which numba has no name."""
    from llvmlite import ir
    from numba.core import cgutils, types
    from numba.extending import intrinsic

    # Called by numba while it generates code: builds the address and the instruction.
    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind, word, byte = signature.args[0], ir.IntType(32), ir.IntType(8).as_pointer()
        array = context.make_array(kind)(context, builder, value=arguments[0])
        row = context.cast(builder, arguments[1], signature.args[1], types.intp)
        # Address arithmetic without a bounds check: an invalid address is ignored by the processor.
        step = cgutils.unpack_tuple(builder, array.strides, kind.ndim)[0]
        start = builder.ptrtoint(array.data, step.type)
        place = builder.inttoptr(builder.add(start, builder.mul(row, step)), byte)
        takes = ir.FunctionType(ir.VoidType(), [byte, word, word, word])
        llvm_prefetch = cgutils.get_or_insert_function(builder.module, takes, "llvm.prefetch.p0")
        builder.call(llvm_prefetch, [place, word(_READ), word(_KEEP), word(_DATA)])
        return context.get_dummy_value()

    def typed(context: Any, values: Any, i: Any) -> Any:
        return types.void(values, i), emit

    return intrinsic(typed)


# Plain Python uses the empty function above.
if RUNNER.compiles:
    prefetch = _instruction()
