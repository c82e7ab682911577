"""Determine how much memory is free, and give back what is not used."""

from __future__ import annotations

import math
import re
import sys
from functools import cache
from pathlib import Path
from typing import Any


def free_memory() -> int | None:
    """Return how many bytes of memory this process can still use, or None if that is unknown.

    The least of what the system has available, and of what the limits of a container (cgroup) and
    of the process (``ulimit -v``) leave.
    """
    # Any of the three may be the tightest, and each may be unknown.
    found = [_of_system(), _of_group(), _of_process()]
    known = [free for free in found if free is not None]
    return max(0, min(known)) if known else None


def _of_system() -> int | None:
    """Bytes that the system has available."""
    try:
        # Linux; other systems have no such file, and nothing is known.
        text = Path("/proc/meminfo").read_bytes()
    except OSError:
        return None
    match = re.search(rb"^MemAvailable:\s+(\d+) kB", text, re.MULTILINE)
    return int(match[1]) << 10 if match else None


# Version 2 of cgroups; "max" stands for no limit.
def _of_group() -> int | None:
    """Bytes that the limit of a container leaves."""
    folder = Path("/sys/fs/cgroup")
    try:
        most, used = (
            (folder / name).read_text().strip() for name in ("memory.max", "memory.current")
        )
    except OSError:
        return None
    return int(most) - int(used) if most.isdigit() and used.isdigit() else None


def _of_process() -> int | None:
    """Bytes that the limit of the process leaves (``ulimit -v``)."""
    try:
        import resource

        most, _ = resource.getrlimit(resource.RLIMIT_AS)
        # Without a limit the system decides.
        if most == resource.RLIM_INFINITY:
            return None
        # The first number of statm is all of the address space, which the limit counts.
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        return most - pages * resource.getpagesize()
    except (ImportError, OSError):
        return None


def most_memory_so_far() -> float:
    """Return the most memory that this process has had [bytes]; infinity if that is unknown.

    Examples
    --------
    >>> most_memory_so_far() > 0
    True
    """
    try:
        import resource
    except ImportError:  # Windows
        return math.inf
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(peak if sys.platform == "darwin" else peak << 10)


def give_back_memory() -> None:
    """Give memory that has been freed back to the system, where the C library knows how.

    Arrays of up to 32 MB are freed into a heap, of which later arrays fill some gaps only.

    Examples
    --------
    >>> give_back_memory()
    """
    trim = of_glibc("malloc_trim")
    if trim is not None:
        trim(0)


@cache
def of_glibc(name: str) -> Any:
    """Return a function of the GNU C library; None with another one."""
    import ctypes

    try:
        library = ctypes.CDLL(None)
        # others have functions of the same name that do something else
        return getattr(library, name) if hasattr(library, "gnu_get_libc_version") else None
    except (OSError, AttributeError, TypeError):  # TypeError: Windows takes no None
        return None
