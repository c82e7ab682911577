"""What is running, on one line that appears after two seconds, where somebody watches.

A terminal shows it on stderr, a notebook as an output; it disappears at the end. Scripts without a
terminal and workers of ensembles show nothing.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from geosurf.errors import InputError

AFTER, EVERY = 2.0, 0.5  # s until the line appears, and between two of them
GRACE = 0.3  # s: steps that follow each other are one piece of work
CHOICE = "GEOSURF_PROGRESS"  # "off" in the environment silences all processes

Show = Callable[[str], object]


class _Board:
    """What runs in this process, and the thread that shows it."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.running: list[str] = []
        self.counts: dict[str, str] = {}
        self.silent = 0
        self.watcher: threading.Thread | None = None
        self.show: Show = print
        self.drawn = False
        self.began = self.ended = -GRACE

    def push(self, words: str, show: Show) -> None:
        """Add a step, and begin to watch if nobody does."""
        with self.changed:
            now = time.monotonic()
            if not self.running and now - self.ended > GRACE:
                self.began = now
            self.running.append(words)
            if self.watcher is None:
                self.show = show
                self.watcher = threading.Thread(target=self._watch, daemon=True)
                self.watcher.start()

    def pop(self, words: str) -> None:
        """Take the step away; the line of the last one goes before its caller prints anything."""
        with self.changed:
            # the last of this name: the same step may run in two threads
            row = len(self.running) - 1 - self.running[::-1].index(words)
            del self.running[row]
            self.ended = time.monotonic()
            if not self.running and self.drawn:
                self.show("")
                self.drawn = False

    def _watch(self) -> None:
        """Show the line until nothing has run for a while."""
        pause = AFTER
        while pause:
            time.sleep(pause)
            with self.changed:
                now = time.monotonic()
                seconds = now - self.began
                if self.running and seconds >= AFTER:
                    self.show(line_of(self.running, self.counts, seconds))
                    self.drawn, pause = True, EVERY
                elif self.running or now - self.ended < GRACE:
                    pause = max(AFTER - seconds, GRACE) if self.running else GRACE
                else:
                    self.watcher, pause = None, 0.0
                    self.counts.clear()


_board = _Board()


def line_of(running: list[str], counts: dict[str, str], seconds: float) -> str:
    """
    Return the line: the outermost and the innermost step, and the time so far.

    Examples
    --------
    >>> line_of(["report", "tear Top"], {"tear Top": "2 of 4"}, 12.4)
    'report, tear Top (2 of 4), 12 s ...'
    """
    if not running:
        return f"{seconds:.0f} s ..."
    steps = dict.fromkeys((running[0], running[-1]))
    words = (f"{step} ({counts[step]})" if step in counts else step for step in steps)
    return f"{', '.join(words)}, {seconds:.0f} s ..."


@contextmanager
def running(words: str) -> Iterator[None]:
    """Name what the ``with`` block does, for those who watch.

    Examples
    --------
    >>> with running("tear Top"):
    ...     pass
    """
    said = os.environ.get(CHOICE, "on").strip().lower()
    if said not in ("on", "off", ""):
        raise InputError(f"the environment variable {CHOICE} is {said!r}; give on or off.")
    show = None if _board.silent or said == "off" else _sink()
    if show is None:
        yield
        return
    _board.push(words, show)
    try:
        yield
    finally:
        _board.pop(words)


def count_of(words: str, number: int, count: int, more: str = "") -> None:
    """Remember that a step is one of several, and what else there is to say of them."""
    if count > 1:
        _board.counts[words] = f"{number} of {count}{more}"


@contextmanager
def silence() -> Iterator[None]:
    """Show nothing of what the ``with`` block does: its caller has a display of its own."""
    with _board.changed:
        _board.silent += 1
    try:
        yield
    finally:
        with _board.changed:
            _board.silent -= 1


_hushed = [False]


def show_progress(on: bool = True) -> None:
    """
    Turn on or off the line that shows what has been running for more than two seconds.

    It is on at first, on terminals and in notebooks. ``GEOSURF_PROGRESS=off`` in the environment
    turns it off for all processes.

    Parameters
    ----------
    on : bool

    Returns
    -------
    None

    Raises
    ------
    InputError
        If `on` is not True or False.

    Examples
    --------
    >>> import geosurf as gs
    >>> gs.show_progress(False)
    >>> gs.show_progress()
    """
    if not isinstance(on, bool):
        raise InputError(f"on is {on!r}; give True or False.")
    if on == _hushed[0]:
        with _board.changed:
            _board.silent += -1 if on else 1
        _hushed[0] = not on


# ---- where somebody watches ----------------------------------------------------------------


def _sink() -> Show | None:
    """Return what shows a line here; None where nobody watches."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if type(shell).__name__ == "ZMQInteractiveShell":
        return _notebook_line()
    stream = sys.stderr
    return _terminal_line if stream is not None and stream.isatty() else None


def _terminal_line(line: str) -> None:
    """Show a line in place of the one before; an empty one clears it."""
    stream: Any = sys.stderr
    width = max(20, os.get_terminal_size(stream.fileno()).columns - 1)
    # back to the start of the line, clear it, and leave the cursor there: what is printed meanwhile
    # takes the place of the line
    stream.write(f"\r\x1b[K{line[:width]}\r")
    stream.flush()


def _notebook_line() -> Show:
    """Return what shows lines in one output of the running cell."""
    handle: list[Any] = []

    def show(line: str) -> None:
        """Fill the output, which is made when there is something to show."""
        # a notebook has loaded it; elsewhere nobody gets here
        display: Any = import_module("IPython.display").display

        # plain text in a mapping: no name of a surface is read as HTML
        # an empty page takes no room in the saved notebook, an empty text does
        data = {"text/plain": line} if line else {"text/plain": "", "text/html": ""}
        if handle:
            handle[0].update(data, raw=True)
        elif line:
            handle.append(display(data, raw=True, display_id=True))

    return show
