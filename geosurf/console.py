"""How the command line prints warnings: one line each on stderr, once, the moment they arise."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from geosurf.errors import GeosurfWarning


@contextmanager
def printed_warnings() -> Iterator[None]:
    """Print each `GeosurfWarning` once, without file and line; other warnings as Python does."""
    seen: set[GeosurfWarning] = set()
    with warnings.catch_warnings():
        # what a user asks for with -W or PYTHONWARNINGS comes first
        warnings.simplefilter("always", GeosurfWarning, append=bool(sys.warnoptions))
        as_python_does = warnings.showwarning

        def show(message: Any, *more: Any, **options: Any) -> None:
            """Print one warning."""
            if not isinstance(message, GeosurfWarning):
                as_python_does(message, *more, **options)
            elif message not in seen and sys.stderr is not None:
                seen.add(message)
                print("geosurf: warning:", *str(message).split(), file=sys.stderr, flush=True)

        warnings.showwarning = show
        yield
