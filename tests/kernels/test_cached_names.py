"""Kernels that two processes compiled: what one of them calls is never a part of another."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.long  # of the compile machinery: an edit of kernels, not of the model

SAID = """
import gc
from geosurf.kernels.meshes import (mesh)
from geosurf.kernels.compile.numba_runner import JitKernel
for kernel in gc.get_objects():
    if isinstance(kernel, JitKernel) and kernel._compiled.__name__ == "number_by_bits":
        kernel.compile()
        (made,) = kernel._compiled.overloads.values()
        for function in made.library._final_module.functions:
            if not (function.is_declaration or function.name.startswith("NRT_")):  # all alike
                print(function.name)
"""


def names_in(folder):
    """Names of all functions in a kernel that a process of its own compiles."""
    env = {**os.environ, "GEOSURF_CACHE_DIR": str(folder), "GEOSURF_JIT": "1"}
    said = subprocess.run([sys.executable, "-c", SAID], env=env, check=True,
                          capture_output=True, text=True).stdout  # fmt: skip
    return set(said.split())


def test_two_processes_give_no_function_one_name(tmp_path):
    """`np.sort` and `np.argsort` of numba have parts of one name, but for a count in it."""
    one = names_in(tmp_path / "one")
    two = names_in(tmp_path / "two")
    assert one
    assert two
    assert not one & two
