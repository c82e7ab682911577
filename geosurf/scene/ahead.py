"""Steps that threads run before their turn: results, warnings and errors come when they are due."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Generic, TypeVar

from geosurf.errors import GeosurfError, GeosurfWarning
from geosurf.warning import collected, warn

Result = TypeVar("Result")


class Ahead(Generic[Result]):
    """
    A step that is run once, in any thread; calling it gives what it gave.

    Parameters
    ----------
    run : callable
        () -> the result.

    Attributes
    ----------
    seconds : float
        What it took.

    Examples
    --------
    >>> step = Ahead(lambda: 3)
    >>> step.work(), step()
    (True, 3)
    """

    def __init__(self, run: Callable[[], Result]) -> None:
        self.seconds = 0.0
        self._run = run
        self._found: list[Result] = []
        self._error: GeosurfError | None = None
        self._warnings: list[GeosurfWarning] = []

    def work(self) -> bool:
        """Run the step; return whether it gave a result."""
        start = time.perf_counter()
        with collected() as self._warnings:
            try:
                self._found.append(self._run())
            except GeosurfError as error:  # for whoever calls the step; a defect ends all at once
                self._error = error
        self.seconds = time.perf_counter() - start
        return self._error is None

    def __call__(self) -> Result:
        """Warn as the step did, and return its result or raise its error."""
        if self._error is None and not self._found:
            self.work()
        for warning in self._warnings:
            warn(warning)
        if self._error is not None:
            raise self._error
        return self._found[0]


__all__ = ["Ahead"]
