"""Freed memory stays with the process, so that the next call reuses its pages.

The C library of Linux returns freed memory to the system until a program has freed a large block:
then it keeps up to twice that size, 64 MB at most. Each page requested again is a page fault, 0.3
to 5 microseconds: on a virtual machine a third of the time for cutting a scene of 16 MB.
Measurements and cost: docs/decisions/memory.md.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

LARGEST = 32 * 2**20 - 2**16  # [bytes]; the C library learns nothing from more


def retain_pages() -> None:
    """Free a large block that was never touched. No memory is used, and nothing is set."""
    # Freed at once: the C library has then seen a block of this size, and keeps pages.
    np.empty(LARGEST, dtype=np.uint8)


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
