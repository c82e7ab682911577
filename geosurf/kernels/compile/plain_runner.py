"""Kernels as plain Python: slow, every index checked, every line open to a debugger."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from geosurf.kernels.compile.gate import Signature


class PlainRunner:
    """Runs kernels as they are written.

    An array that a kernel only reads is handed over read-only, so that numpy itself proves
    the stars of its signature.

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
            return function(
                *(
                    # Writing an argument without a star raises in numpy.
                    _protected(value) if place not in signature.written else value
                    for place, value in enumerate(arguments)
                )
            )

        return run

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
