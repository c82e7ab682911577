"""Peak memory of reading a file, in a process of its own, over the arrays that come out.

``python -m benchmarks.formats.memory FUNCTION SMALL LARGE [WORD=VALUE ...]`` reads a small file of
the format first, which loads what the reader imports, and prints the ratio for the large one.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

import geosurf as gs

ROOT = Path(__file__).resolve().parents[2]


def read_memory(function: str, small: Path, large: Path, **words: str) -> float:
    """
    Return the peak of resident memory while a file is read, over the arrays.

    Parameters
    ----------
    function : str
        Such as ``"read_horizon"``.
    small, large : pathlib.Path
        Files of one format.
    **words : str
        Arguments of the function.

    Returns
    -------
    float
    """
    command = [sys.executable, "-m", "benchmarks.formats.memory", function, str(small), str(large)]
    ended = subprocess.run(
        [*command, *(f"{key}={word}" for key, word in words.items())],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    return float(ended.stdout)


def arrays_of(found: Any) -> int:
    """Bytes of the arrays of a surface, a horizon or points."""
    if hasattr(found, "triangles"):
        data = sum(np.asarray(one).nbytes for one in found.vertex_data.values())
        return int(found.vertices.nbytes + found.triangles.nbytes + data)
    return int(found.nbytes + (0 if hasattr(found, "data_vars") else _axes(found)))


def _axes(found: Any) -> int:
    return sum(axis.nbytes for axis in found.coords.values())


def _kilobytes(key: str) -> int:
    """One line of what Linux knows of this process."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key):
            return int(line.split()[1])
    raise OSError(f"/proc/self/status has no {key}")


def main(function: str, small: str, large: str, *words: str) -> None:
    """Measure in this process."""
    given: dict[str, Any] = dict(word.split("=", 1) for word in words)
    read = getattr(gs, function)
    read(Path(small), **given)
    Path("/proc/self/clear_refs").write_text("5")  # the peak starts again from here
    before = _kilobytes("VmRSS")
    found = read(Path(large), **given)
    sys.stdout.write(f"{1024 * (_kilobytes('VmHWM') - before) / arrays_of(found)}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])


__all__ = ["arrays_of", "read_memory"]
