"""Freed memory stays with the process, so that the next call reuses its pages.

The C library of Linux returns freed memory to the system until a program has freed a large block:
then it keeps up to twice that size, 64 MB at most. Each page requested again is a page fault, 0.3
to 5 microseconds: on a virtual machine a third of the time for cutting a scene of 16 MB. When a
changed scene goes, more than 64 MB may be free at once, which the next one needs: who changes
scenes asks for more. Measurements and cost: docs/decisions/0010 and 0115.
"""

from __future__ import annotations

import os
from functools import cache
from typing import Any

import numpy as np

LARGEST = 32 * 2**20 - 2**16  # [bytes]; the C library learns nothing from more
_TRIM_THRESHOLD = -1  # option of `mallopt`, from malloc.h
_SHARE = 32  # of all memory that may be kept
_kept = 2 * LARGEST  # bytes that are kept now


def retain_pages() -> None:
    """Free a large block that was never touched. No memory is used, and nothing is set."""
    # Freed at once: the C library has then seen a block of this size, and keeps pages.
    np.empty(LARGEST, dtype=np.uint8)


def retain_more(n: int) -> None:
    """Let `n` bytes of freed memory stay, a 32nd of all memory at most; never fewer than before.

    What the user has chosen by variables of the C library stays as it is.

    Examples
    --------
    >>> retain_more(80 << 20)
    """
    global _kept
    if n <= _kept:
        return
    chosen = [name for name in os.environ if name.startswith("MALLOC_")]
    set_option = of_glibc("mallopt")
    if chosen or "malloc" in os.environ.get("GLIBC_TUNABLES", "") or set_option is None:
        return
    n = min(n, os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // _SHARE)
    if n > _kept:
        # the library learns nothing more from now on: blocks up to 32 MB come from what is kept
        set_option(_TRIM_THRESHOLD, n)
        _kept = n


@cache
def of_glibc(name: str) -> Any:
    """A function of the GNU C library; None with another one."""
    import ctypes

    try:
        library = ctypes.CDLL(None)
        # others have functions of the same name that do something else
        return getattr(library, name) if hasattr(library, "gnu_get_libc_version") else None
    except (OSError, AttributeError, TypeError):  # TypeError: Windows takes no None
        return None
