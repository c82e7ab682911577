"""How the command ``geosurf`` ends at a signal: at once, at any moment, and with nothing half-done.

Ctrl-C, SIGTERM (batch systems, `timeout`) and SIGHUP (a terminal that closes) raise no exception:
one in a destructor or in a callback is lost, one in machine code becomes another error, and one in
the first import of VTK ends Python by a fault. What must not stay behind is named while it is
there; it is removed, and the process ends.

This file imports nothing that takes time: it works before anything else does.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

STOPPED = 128  # and the number of the signal, as shells count: 130 for Ctrl-C
_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
_undo: list[Callable[[], Any]] = []
_kept: list[Callable[[], str]] = []


def end_at_signals() -> None:
    """Let signals end this process; those that are ignored, as by nohup, stay so."""
    for name in _SIGNALS:
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _end)


def keeping(words: Callable[[], str]) -> None:
    """Say what is kept, in the last line before the end."""
    _kept[:] = [words]


@contextmanager
def undone(action: Callable[[], Any]) -> Iterator[None]:
    """Do something if a signal ends the process inside the ``with`` block, such as remove a folder.

    Examples
    --------
    >>> with undone(lambda: print("removed")):
    ...     pass
    """
    _undo.append(action)
    try:
        yield
    finally:
        _undo.remove(action)


@contextmanager
def in_the_end(action: Callable[[], Any]) -> Iterator[None]:
    """Do something at the end of the ``with`` block, be it an error or a signal.

    Examples
    --------
    >>> with in_the_end(lambda: print("removed")):
    ...     print("made")
    made
    removed
    """
    with undone(action):
        try:
            yield
        finally:
            action()


@contextmanager
def interrupted_later() -> Iterator[None]:
    """Let Ctrl-C wait for the end of the ``with`` block: a library in it makes other errors of it.

    Examples
    --------
    >>> with interrupted_later():
    ...     pass
    """
    came: list[int] = []
    usual = signal.getsignal(signal.SIGINT)
    try:
        if usual is signal.default_int_handler:  # whoever handles it in another way raises nothing
            signal.signal(signal.SIGINT, lambda number, _: came.append(number))
    except ValueError:  # only the main thread is interrupted
        usual = None
    try:
        yield
    finally:
        if usual is signal.default_int_handler:
            signal.signal(signal.SIGINT, usual)
    if came:
        raise KeyboardInterrupt


@contextmanager
def temporary_folder() -> Iterator[str]:
    """Yield the path of a folder that goes with the ``with`` block, and with the process."""
    import tempfile

    folder = tempfile.mkdtemp(prefix="geosurf-")
    with in_the_end(lambda: _remove(folder)):
        yield folder


def _remove(folder: str) -> None:
    import shutil

    shutil.rmtree(folder, ignore_errors=True)


def _end(number: int, frame: Any) -> None:
    """Undo what is half-done, print one line, and end."""
    for name in _SIGNALS:  # a second signal ends the process at once
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)
    for action in [*_undo][::-1]:
        with suppress(Exception):
            action()
    clear = "\r\x1b[K" if os.isatty(2) else ""
    kept = "".join(f" {words()}" for words in _kept)
    with suppress(OSError, RuntimeError, AttributeError, ValueError):
        sys.stdout.flush()
    with suppress(OSError):  # the terminal may be closed: SIGHUP
        os.write(2, f"{clear}geosurf: stopped.{kept}\n".encode())
    os._exit(STOPPED + number)
