"""How the command line prints: in any encoding, and warnings once, the moment they arise."""

from __future__ import annotations

import argparse
import errno
import io
import json
import math
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from geosurf.errors import GeosurfError, GeosurfWarning, InputError
from geosurf.stopping import STOPPED

# ---- exit codes ----------------------------------------
# Exit codes: an error or a signal ends a command with a code and at most one message.
#
# Errors that geosurf raises on purpose have their code: 2 input, 3 geometry, 4 a bug in geosurf.
# A full disk is an input error. A closed pipe is not an error. Signals: `geosurf.stopping`.
# Everything else is a bug in geosurf.


OUR_FAULT = 4
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)


class ExitCode:
    """Turn the end of a command into an exit code and at most one message."""

    def __init__(self, debug: bool, kept: Callable[[], str] = str) -> None:
        self.code = 0
        self._debug = debug
        self._kept = kept  # says what a command that is stopped leaves

    def __enter__(self) -> None:
        """Begin."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        """Print the error on stderr; only deliberate exits pass through."""
        # SystemExit has a code of its own
        if error is None or isinstance(error, SystemExit | GeneratorExit):
            return False

        # the line of the running step may still be there
        clear_line()

        # an end that the user asked for: what is left of the work
        if isinstance(error, KeyboardInterrupt):
            self.code = STOPPED + signal.SIGINT
            if sys.stderr is not None:
                with suppress(OSError):  # the terminal may be closed: SIGHUP
                    print(f"geosurf: stopped. {self._kept()}".strip(), file=sys.stderr)
            return True
        if isinstance(error, BrokenPipeError):  # the reader of the output has closed it
            _forget_output()
            return True

        # the traceback comes first and the sentence last, where a reader looks
        if self._debug:
            traceback.print_exception(kind, error, trace)

        # ends that geosurf explains: the message, and what was found out about it on the way
        if isinstance(error, GeosurfError):
            self.code = error.exit_code
            for line in (error, *getattr(error, "__notes__", ())):
                print(f"geosurf: {line}", file=sys.stderr)
        elif isinstance(error, GeosurfWarning):  # Python was asked to treat warnings as errors
            self.code = InputError.exit_code
            print(f"geosurf: warning: {error}", file=sys.stderr)
        elif isinstance(error, OSError) and error.errno in NO_ROOM:
            self.code = InputError.exit_code
            what = error.filename or "the output"

            # the output that cannot be flushed is dropped, or Python would complain again at its
            # end
            if not _is_printed():
                _forget_output()
            print(f"geosurf: {what} cannot be written: {error.strerror}. Free some space, or "
                  "write to another place.", file=sys.stderr)  # fmt: skip
        else:
            self.code = OUR_FAULT
            print(_apology(error), file=sys.stderr)
        return True


def _is_printed() -> bool:
    """Whether all that was printed is out; stdout may be closed from the beginning."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        return False
    return True


def _forget_output() -> None:
    """Send what is still to be printed nowhere, or Python would fail to print it at its exit."""
    # later flushes, that of the interpreter too, go nowhere instead of failing
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _apology(error: BaseException) -> str:
    return (
        f"geosurf: unexpected {type(error).__name__}: {error}. This is a bug in geosurf. "
        "Please report it with your scenario and the output of --debug."
    )


# ---- lines ----------------------------------------
# Lines of finished steps; `geosurf.conventions.running` shows the one that is running below them.


def step_lines(options: argparse.Namespace, *, steps: bool) -> Callable[[str], None]:
    """
    Return what prints the line of a finished step, with the peak memory if all is asked for.

    Parameters
    ----------
    options : argparse.Namespace
        With ``quiet``, ``verbose`` and ``json``.
    steps : bool
        Whether the command prints its steps without ``--verbose``, too.
    """
    # stdout holds the answer: steps that were not asked for, or go with JSON, are on stderr
    shown = options.verbose or (steps and not (options.quiet or options.json))

    def show(line: str) -> None:
        """Print the line of a finished step."""
        clear_line()
        if options.verbose:
            print(f"{line}  {peak_megabytes():6.0f} MB at most", file=sys.stderr, flush=True)
        elif shown:
            print(line, flush=True)

    return show


def peak_megabytes() -> float:
    """Return the most memory that this process has had [MB]."""
    from geosurf.conventions.machine import most_memory_so_far  # not for --help: it loads numpy

    return most_memory_so_far() / 1e6


# ---- answer ----------------------------------------
# What a command has found: text for people, data for scripts, and the exit code.


@dataclass(frozen=True)
class Answer:
    """
    The result of a command.

    Attributes
    ----------
    data : object
        What ``--json`` prints: dicts, lists, text, numbers; paths become text.
    text : str
        What is printed without ``--json``.
    code : int
        The exit code.
    closing : tuple of str
        Sentences on what to open and what to check; ``--json`` leaves them out.
    """

    data: Any
    text: str = ""
    code: int = 0
    closing: tuple[str, ...] = ()

    def shown(self, *, as_json: bool, quiet: bool) -> str:
        r"""
        Return what is printed on stdout.

        Examples
        --------
        >>> answer = Answer({"volume_m3": float("nan")}, "1 unit", closing=("Report: index.html",))
        >>> answer.shown(as_json=True, quiet=True)
        '{\n  "volume_m3": null\n}'
        >>> answer.shown(as_json=False, quiet=False)
        '1 unit\nReport: index.html'
        >>> answer.shown(as_json=False, quiet=True)
        ''
        """
        if as_json:
            return json.dumps(plain(self.data), indent=2)
        return "" if quiet else "\n".join(filter(None, (self.text, *self.closing)))


def plain(value: Any) -> Any:
    """
    Return a value as JSON holds it: numbers that are not finite become null.

    Examples
    --------
    >>> import pathlib
    >>> plain({"path": pathlib.PurePosixPath("out"), "of": (1, float("inf"))})
    {'path': 'out', 'of': [1, None]}
    """
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    # numpy's numbers and arrays know what they are in Python; everything else is text
    return plain(value.tolist()) if hasattr(value, "tolist") else str(value)


@contextmanager
def encodable_output() -> Iterator[None]:
    r"""Print letters that the encoding of the console or a pipe lacks as escapes, ``\xe4``.

    A name in another script must not end a run whose results are written. What Python has chosen
    to replace letters with, where it does not refuse them, stays.
    """
    # sys.stdout may be None (pythonw) or replaced by a test: only true text streams are changed
    strict = [
        stream
        for stream in (sys.stdout, sys.stderr)
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict"
    ]
    for stream in strict:
        stream.reconfigure(errors="backslashreplace")
    try:
        yield
    finally:
        # as found: the caller may be a program that uses `main` as a function
        for stream in strict:
            if not stream.closed:
                stream.reconfigure(errors="strict")


def clear_line() -> None:
    """Take away what the terminal shows on the line of the running step."""
    if sys.stderr is not None and sys.stderr.isatty():
        # return to the start of the line, and clear it to its end
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)


@contextmanager
def printed_warnings() -> Iterator[None]:
    """Print each `GeosurfWarning` once, without file and line; other warnings as Python does."""
    seen: set[GeosurfWarning] = set()
    with warnings.catch_warnings():
        # what a user asks for with -W or PYTHONWARNINGS comes first
        warnings.simplefilter("always", GeosurfWarning, append=bool(sys.warnoptions))

        # warnings of other packages look as always
        as_python_does = warnings.showwarning

        def show(message: Any, *more: Any, **options: Any) -> None:
            """Print one warning."""
            if not isinstance(message, GeosurfWarning):
                as_python_does(message, *more, **options)

            # one line for each warning, whatever its own line breaks, and each once per run
            elif message not in seen and sys.stderr is not None:
                seen.add(message)
                clear_line()
                print("geosurf: warning:", *str(message).split(), file=sys.stderr, flush=True)

        warnings.showwarning = show
        yield
