"""Count what readers do with mutated files.

``python -m tests.field_data.mutated [files] [seconds] [first]``.

Files of every format, whole or compressed, with one to three mutations: bits turned over, cuts,
lines and blocks twice, counts exchanged, huge numbers, compression within compression, marks of
byte order, other encodings and line ends, zeros; and files built to take memory. Each is read in
a process of its own with every warning an error and a limit on its address space: a result, or an
error of ours that names the file. Counted are foreign exceptions, hangs, crashes, and files that
took more memory than `geosurf.read._guard.limit_of` their size. What hangs or crashes inside the
HDF5 library, which cannot be interrupted, is counted apart. The run ends with 1 if a file is wrong.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import warnings
from pathlib import Path

from geosurf.read._guard import limit_of
from tests.counting import count
from tests.field_data import spoiled
from tests.field_data.mutations import case_of, read, whole_files

SECONDS = 30.0  # for one file; most take milliseconds
SLACK = 32 << 20  # bytes that a process takes whatever it reads: buffers, modules loaded late
SPACE = 2 << 30  # bytes of address space beyond those at the start


# ------------------------------------------------------------------------ verdict
def memory_of_this_process() -> int:
    """Bytes of memory that are resident now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


def address_space() -> int:
    """Bytes of address space that are taken now."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def verdict_of(path: Path) -> tuple[str, str]:
    """One of "right", "refused" and "wrong", and why."""
    warnings.simplefilter("error")
    word, why = spoiled.verdict_of(lambda: read(path))
    if word == "refused" and path.name not in why:
        return "wrong", f"no name: {why}"
    return word, why


def read_apart(path: Path) -> tuple[str, str, int]:
    """Verdict on a file, why, and how many bytes its process took to read it."""
    size = path.stat().st_size

    def case() -> tuple[str, ...]:
        """Memory at the start, verdict, and why."""
        resource.setrlimit(resource.RLIMIT_AS, (address_space() + SPACE,) * 2)
        return str(memory_of_this_process()), *verdict_of(path)

    told, stack, peak = spoiled.forked(case, SECONDS)
    if told:
        start, word, why = told.split("\n", 2)
        taken = 1024 * peak - int(start) if peak else 0
        if taken > limit_of(size) + SLACK:
            return "over the limit", f"{taken >> 20} MB for {size} bytes", taken
        return word, why, taken
    where, why = spoiled.at_fault(stack, "crashed" if peak else "hung")
    return where if where != "wrong" else why.split()[0], why, 0


def load_all(files: dict[str, bytes], folder: Path) -> None:
    """Read whole files: they are right, and no case has to load a module."""
    for name, data in files.items():
        (folder / name).write_bytes(data)
        read(folder / name)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        files = whole_files(Path(folder))
        load_all(files, Path(folder))

        def case(seed: int) -> tuple[str, str]:
            """What became of one file."""
            name, data = case_of(seed, files)
            (Path(folder) / name).write_bytes(data)
            word, why, _ = read_apart(Path(folder) / name)
            is_right = word in ("right", "refused") or " in " in word  # a library of HDF5
            return (word, "") if is_right else ("wrong", f"{name}: {word}: {why}")

        sys.exit(count(case, cases=2_000))
