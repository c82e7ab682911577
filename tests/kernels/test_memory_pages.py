"""Memory that calls give back stays with the process: its pages are not asked for again."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from types import MappingProxyType

import pytest

CALLS = """
import resource
import numpy as np
{first}
def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    parts = [None] * {count}  # at once: a list that grows would end up behind its arrays
    for k in range({count}):
        parts[k] = np.ones(100_000)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
faults()
print(faults())
"""


pytestmark = pytest.mark.skipif(
    platform.libc_ver()[0] != "glibc", reason="other libraries keep memory anyway"
)


def count_faults(first, count, told=MappingProxyType({})):
    """Pages that a second call asks for, in a process of its own."""
    plain = {key: value for key, value in os.environ.items() if not key.startswith("MALLOC_")}
    code = CALLS.format(first=first, count=count)
    run = subprocess.run(
        [sys.executable, "-c", code], env={**plain, **told}, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    return int(run.stdout)


def test_a_second_call_finds_its_pages():
    counts = [count_faults(first, 10) for first in ("", "import geosurf.kernels")]
    assert counts[0] > 1000  # 8 MB in pages of 4 kB; else there is nothing to keep
    assert counts[1] < counts[0] / 10
