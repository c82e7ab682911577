"""Progress on a console: lines of finished steps, and below them the step that is running."""

from __future__ import annotations

import argparse
import shutil
import sys
from typing import TextIO

from geosurf.cli.console import clear_line


class Lines:
    """
    Prints a line for each finished step.

    Parameters
    ----------
    lines : stream or None
        Where they go; None prints nothing.
    memory : bool
        Whether lines end with the peak memory of the process.
    """

    def __init__(self, lines: TextIO | None, *, memory: bool) -> None:
        self._lines = lines
        self._memory = memory

    def __call__(self, line: str) -> None:
        """Print the line of a finished step."""
        clear_line()
        if self._lines is not None:
            more = f"  {peak_megabytes():6.0f} MB at most" if self._memory else ""
            print(f"{line}{more}", file=self._lines, flush=True)


class Live(Lines):
    """Also names the step that is running, on the last line of a terminal."""

    def now(self, words: str) -> None:
        """Name the step that runs now; it is overwritten by the next line."""
        clear_line()
        width = max(20, shutil.get_terminal_size().columns - 1)
        print(f"{words} ..."[:width], end="", file=sys.stderr, flush=True)


def live_progress(options: argparse.Namespace, *, steps: bool) -> Lines:
    """
    Return what shows progress as a command was asked to.

    Parameters
    ----------
    options : argparse.Namespace
        With ``quiet``, ``verbose`` and ``json``.
    steps : bool
        Whether the command prints its steps without ``--verbose``, too.

    Returns
    -------
    Lines
        `Live` on a terminal.
    """
    # stdout holds the answer: steps that were not asked for, or go with JSON, are on stderr
    lines: TextIO | None = None
    if options.verbose:
        lines = sys.stderr
    elif steps and not (options.quiet or options.json):
        lines = sys.stdout
    shown = not options.quiet and sys.stderr is not None and sys.stderr.isatty()
    return (Live if shown else Lines)(lines, memory=options.verbose)


def peak_megabytes() -> float:
    """Return the largest memory of this process so far; NaN where the system does not count it."""
    try:
        import resource
    except ImportError:  # Windows
        return float("nan")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)


__all__ = ["Lines", "Live", "live_progress", "peak_megabytes"]
