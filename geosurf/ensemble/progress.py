"""Progress of an ensemble with the time that is left, on one line of the console."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TextIO

from geosurf.conventions import counted

EVERY = 0.2  # s between two lines
WARM = 2  # realisations that are not typical: caches are empty


class Progress:
    """
    Counts realisations and estimates the time that is left from the last ones.

    Parameters
    ----------
    n : int
        All realisations.
    done : int
        Those that are stored already.
    show : callable, optional
        Is called with a line of text; default: the console, where it is one.

    Examples
    --------
    >>> lines = []
    >>> progress = Progress(3, 1, lines.append)
    >>> for failed in (False, True):
    ...     progress.add(failed)
    >>> lines[0].split(",")[0], lines[-1].split(",")[:2]
    ('2 of 3 realisations', ['3 of 3 realisations', ' 1 failed'])
    """

    def __init__(self, n: int, done: int, show: Callable[[str], object] | None = None) -> None:
        self.n, self.done, self.failed = n, done, 0
        self.show = show or console_line
        # Monotonic: the clock of the computer may be set meanwhile.
        self._times = [time.monotonic()]
        self._shown = -EVERY

    def add(self, failed: bool) -> None:
        """Count one more."""
        self.done += 1
        self.failed += failed
        now = time.monotonic()
        self._times.append(now)
        # Not more often than people read, and always the last one.
        if now - self._shown >= EVERY or self.done == self.n:
            self._shown = now
            self.show(self.line())

    def line(self) -> str:
        """Return progress in words."""
        parts = [f"{self.done} of {counted(self.n, 'realisation')}"]
        if self.failed:
            parts.append(f"{self.failed} failed")
        seconds = self.seconds_left()
        if seconds is not None and self.done < self.n:
            parts.append(f"{duration(seconds)} left")
        return ", ".join(parts)

    def seconds_left(self) -> float | None:
        """Estimate the time that is left [s]; None at the beginning."""
        # The last ones: an ensemble that shares a computer changes its pace.
        recent = self._times[-200:]
        if len(self._times) <= WARM + 1:
            return None
        # The first realisations fill caches and are slower.
        recent = recent[WARM:] if len(self._times) < 50 else recent
        each = (recent[-1] - recent[0]) / max(len(recent) - 1, 1)
        return each * (self.n - self.done)


def duration(seconds: float) -> str:
    """Return a duration as people read it.

    Examples
    --------
    >>> duration(4.4), duration(250), duration(7300)
    ('4 s', '4 min 10 s', '2 h 1 min')
    """
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def console_line(line: str, stream: TextIO | None = None) -> None:
    """Show a line in place of the one before, on stderr if that is a console."""
    stream = sys.stderr if stream is None else stream
    # Files and pipes get no lines that overwrite each other.
    if stream is None or not stream.isatty():
        return
    done, _, rest = line.partition(" of ")
    end = "\n" if done == rest.split(" ", 1)[0] else ""  # the last line stays
    # Back to the start of the line, and clear it.
    stream.write(f"\r\x1b[K{line}{end}")
    stream.flush()


__all__ = ["Progress", "duration"]
