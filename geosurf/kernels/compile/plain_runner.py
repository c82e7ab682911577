"""Kernels as plain Python: slow, every index checked, every line open to a debugger."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.kernels.compile.gate import Signature
from geosurf.kernels.compile.sources import folder_of
from geosurf.kernels.compile.written_arguments import cached_arguments


def written_in_source(name: str, function: Callable[..., Any]) -> tuple[int, ...]:
    """Places of the arguments that a kernel writes, from the sources in its folder."""
    return cached_arguments(str(folder_of(Path(function.__code__.co_filename))))[name]


class PlainRunner:
    """Runs kernels as they are written.

    An array that a kernel only reads is handed over read-only, so that numpy itself proves
    the result of `written_arguments`.

    Parameters
    ----------
    reason : str
        Why, for people.
    """

    compiles = False

    def __init__(self, reason: str) -> None:
        self._reason = reason

    def scalar(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the helper as it is."""
        return function

    def caller(
        self, name: str, function: Callable[..., Any], signature: Signature
    ) -> Callable[..., Any]:
        """Return the kernel, with arrays that are only read protected."""

        def run(*arguments: Any) -> Any:
            # Places are asked at each call: cheap after the first, and only in this slow mode.
            written = self.written(name, function)
            return function(
                *(
                    # Writing an argument that the analysis calls read-only raises in numpy.
                    _protected(value) if place not in written else value
                    for place, value in enumerate(arguments)
                )
            )

        return run

    def written(self, name: str, function: Callable[..., Any]) -> tuple[int, ...]:
        """Return the places of the arguments that an entry writes."""
        return written_in_source(name, function)

    def describe(self) -> str:
        """Return one sentence for people."""
        return f"kernels run as plain Python, slowly, since {self._reason}."

    def obstacle(self) -> str:
        """Return nothing: nothing is compiled, so nothing has to be saved."""
        return ""


def _protected(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        # A view, so that the caller's array stays writeable.
        value = value.view()
        value.flags.writeable = False
    return value
