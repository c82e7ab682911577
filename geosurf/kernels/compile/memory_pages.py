"""Memory that one call gives back serves the next one.

The C library of Linux gives freed memory back to the system until a program has freed something
large: then it keeps up to twice the size of that, 64 MB at most. Every page that it has to ask for
anew is a fault, 0.3 to 5 microseconds each: on a virtual machine a third of the time in which a
scene of 16 MB is cut. What was measured, and what it costs: docs/decisions/0010.
"""

from __future__ import annotations

import numpy as np

LARGEST = 32 * 2**20 - 2**16  # [bytes]; the C library learns nothing from more


def retain_pages() -> None:
    """Free a large block that was never touched. No memory is used, and nothing is set."""
    np.empty(LARGEST, dtype=np.uint8)
