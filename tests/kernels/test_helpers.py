"""Helpers under numba, names that two processes give, and where the sources of kernels lie."""

from __future__ import annotations

import ast

import numpy as np
import pytest

from geosurf.kernels.compile.gate import ROOT, file_of, kernel_files, module_of
from geosurf.kernels.compile.helpers import Helper, entry_dispatcher
from tests.processes import told_by

numba = pytest.importorskip("numba")
if numba.config.DISABLE_JIT:
    pytest.skip("nothing is compiled", allow_module_level=True)


pytestmark = pytest.mark.long  # of the compile machinery: an edit of kernels, not of the model


def half(x):
    return 0.5 * x if x >= 0.0 else -0.5 * x


half = Helper(half)


def ends(x):
    return half(x[0]), half(x[x.shape[0] - 1])


ends = Helper(ends)


def widest(x):
    low, high = ends(x)
    return max(half(x[0]), low + high)


widest = Helper(widest)


def spread(x):
    return widest(x) + half(x[0])


def rows(x, out):
    for i in range(x.shape[0]):
        out[i] = widest(x[i])


X = np.array([-3.0, 7.0, 1.5])


def test_entries_share_helpers_and_say_what_python_says():
    one, two = entry_dispatcher(spread), entry_dispatcher(rows)
    out = np.zeros(2)
    two(np.stack([X, -X]), out)
    assert one(X) == spread(X) == 2.25 + 1.5
    assert out.tolist() == [2.25, 2.25]
    assert all(len(helper.overloads) == 1 for helper in (half, ends, widest))


def test_a_constant_is_a_plain_number():
    def twice(x):
        return half(1.0) + half(3.0) + half(x)

    assert entry_dispatcher(twice)(-4.0) == 4.0
    assert len(half.overloads) == 1


def at(x, i):
    return x[i]


at = Helper(at)


def in_order(x):
    return np.sort(x)[0] + at(x, 0)


def test_an_index_is_used_as_it_is_by_kernels_only():
    entry = entry_dispatcher(in_order)
    assert entry(X) == -6.0  # numba's sort, compiled meanwhile, is its own
    (helper,) = at.overloads.values()
    if not numba.config.BOUNDSCHECK:  # which compares, too
        assert "icmp slt" not in str(helper.library._final_module)
    assert numba.njit(lambda x: x[-1])(X) == 1.5


def kernel_functions():
    for path in kernel_files(ROOT):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and node.decorator_list:
                yield path.name, node


def test_no_kernel_counts_from_the_end():
    """Where an index is computed, NUMBA_BOUNDSCHECK=1 tells (docs/contributing.md)."""
    found = list(kernel_functions())
    assert len(found) > 300
    for name, function in found:
        for node in ast.walk(function):
            if isinstance(node, ast.Subscript):
                index = node.slice
                for part in index.elts if isinstance(index, ast.Tuple) else [index]:
                    negative = isinstance(part, ast.UnaryOp) and isinstance(part.op, ast.USub)
                    assert not negative, f"{name}:{node.lineno}"


def test_no_kernel_asks_an_array_for_what_cannot_be_frozen():
    """`max` of an array goes through `reshape` in numba's runtime, which no wheel brings."""
    asked = {"max", "min", "reshape", "ravel", "flatten", "take", "repeat"}
    found = [
        f"{path.name}:{call.lineno}: {call.func.attr}"
        for path in kernel_files(ROOT)
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute)
        if call.func.attr in asked
        and not (isinstance(call.func.value, ast.Name) and call.func.value.id == "np")
    ]
    assert not found


# ---- Kernels that two processes compiled: what one of them calls is never a part of another.

SAID = """
import gc
from geosurf.kernels.meshes import (mesh)
from geosurf.kernels.compile.numba_runner import JitKernel
for kernel in gc.get_objects():
    if isinstance(kernel, JitKernel) and kernel._compiled.__name__ == "first_seen":
        kernel.compile()
        (made,) = kernel._compiled.overloads.values()
        for function in made.library._final_module.functions:
            if not (function.is_declaration or function.name.startswith("NRT_")):  # all alike
                print(function.name)
"""


def names_in(folder):
    """Names of all functions in a kernel that a process of its own compiles."""
    return set(told_by("-c", SAID, GEOSURF_CACHE_DIR=str(folder), GEOSURF_JIT="1").split())


def test_two_processes_give_no_function_one_name(tmp_path):
    """`np.sort` and `np.argsort` of numba have parts of one name, but for a count in it."""
    one = names_in(tmp_path / "one")
    two = names_in(tmp_path / "two")
    assert one
    assert two
    assert not one & two


# ---- Where the sources of kernels lie.


def test_no_two_kernel_files_have_one_name() -> None:
    """Compiled kernels are cached and frozen under the names of file and function."""
    names = [path.stem for path in kernel_files(ROOT)]
    assert len(names) == len(set(names)) > 30


def test_modules_and_files_name_each_other() -> None:
    assert all(file_of(module_of(path)) == path for path in kernel_files(ROOT))


def test_the_machinery_holds_no_kernels() -> None:
    assert not [path for path in kernel_files(ROOT) if path.parent.name == "compile"]
