"""How the command line prints: in any encoding, and warnings once, the moment they arise."""

from __future__ import annotations

import io
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from geosurf.errors import GeosurfWarning


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
