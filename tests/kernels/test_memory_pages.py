"""Memory that calls give back stays with the process: its pages are not asked for again."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

CALLS = """
import resource
import numpy as np
{first}
def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    parts = [np.ones(100_000) for _ in range(10)]
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
faults()
print(faults())
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other libraries keep memory anyway")
def test_a_second_call_finds_its_pages():
    told = {key: value for key, value in os.environ.items() if not key.startswith("MALLOC_")}
    counts = [
        int(subprocess.run([sys.executable, "-c", CALLS.format(first=first)], env=told,
                           capture_output=True, text=True, check=True).stdout)
        for first in ("", "import geosurf.kernels")
    ]  # fmt: skip
    assert counts[0] > 1000  # 8 MB in pages of 4 kB; else there is nothing to keep
    assert counts[1] < counts[0] / 10
