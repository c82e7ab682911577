"""Exit codes: an error or a signal ends a command with a code and at most one message.

Errors that geosurf raises on purpose have their code: 2 input, 3 geometry, 4 a bug in geosurf.
SIGTERM (batch systems, `timeout`) and SIGHUP (a terminal that closes)
clean up as Ctrl-C does. A full disk is an input error. A closed pipe is not an error.
Everything else is a bug in geosurf.
"""

from __future__ import annotations

import errno
import os
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any

from geosurf.cli.console import clear_line
from geosurf.errors import GeosurfError, GeosurfWarning, InputError

OUR_FAULT = 4
STOPPED = 128  # and the number of the signal, as shells count: 130 for Ctrl-C
_SIGNALS = ("SIGTERM", "SIGHUP")
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)


class Stopped(KeyboardInterrupt):
    """A signal asks the process to end; it cleans up as after Ctrl-C."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


class ExitCode:
    """Turn the end of a command into an exit code and at most one message."""

    def __init__(self, debug: bool, kept: Callable[[], str] = str) -> None:
        self.code = 0
        self._debug = debug
        self._kept = kept  # says what a command that is stopped leaves
        self._handlers: dict[int, Any] = {}

    def __enter__(self) -> None:
        """Begin; a signal that is ignored, as by nohup, or handled by others stays so."""
        # SIGHUP does not exist on Windows; a signal that the parent ignores (nohup) stays ignored
        for number in (getattr(signal, name) for name in _SIGNALS if hasattr(signal, name)):
            if signal.getsignal(number) is signal.SIG_DFL:
                with suppress(ValueError):  # not in the main thread: nothing is changed
                    self._handlers[number] = signal.signal(number, self._stop)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        """Turn the first signal into an exception; a second one ends the process at once."""
        # back to the default first: a second signal ends the process at once
        self._forget_signals()
        raise Stopped(number)

    def _forget_signals(self) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self._handlers.clear()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        """Print the error on stderr; only deliberate exits pass through."""
        self._forget_signals()

        # SystemExit has a code of its own
        if error is None or isinstance(error, SystemExit | GeneratorExit):
            return False

        # the line of the running step may still be there
        clear_line()

        # an end that the user asked for: what is left of the work
        if isinstance(error, KeyboardInterrupt):
            self.code = STOPPED + getattr(error, "number", int(signal.SIGINT))
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
