"""Import without collecting garbage.

Modules stay, and to walk over them again and again takes a tenth of the start of a command. Only
the process of a command does this: other programs that call `geosurf.cli.main` have objects of
their own, which must not count as lasting.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

_own_process = False


def in_own_process() -> None:
    """State that this process runs one command and ends."""
    global _own_process
    _own_process = True


@contextmanager
def loading() -> Iterator[None]:
    """Collect no garbage in the block, and take all that is there after it as lasting."""
    if not (_own_process and gc.isenabled()):
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


__all__ = ["in_own_process", "loading"]
