"""The two decorators of the kernels, and the one place where it is decided what runs them.

``@scalar``
    A helper that other kernels call. Never called from Python by the stages.
``@entry("d2 l2 l -> l")``
    A kernel that Python calls. The text gives one letter and the number of
    dimensions for each argument and result (``d`` float64, ``l`` int64, ``b`` bool; no
    digit for a number, a dot for no result, a star for an array that is written), so that
    exactly one machine-code version exists and can be compiled ahead of time. The gate in
    front of it casts and checks (`gate`).

The same sources run under three runners, with the same bits as results. The choice is made once,
when the first kernel is imported, and holds for all of them:

===============  ==================================================  =============================
runner           what runs                                           when
===============  ==================================================  =============================
`plain_runner`   Python itself, every index checked                  NUMBA_DISABLE_JIT=1
`frozen_runner`  machine code of a library, without numba            the wheel has one
`numba_runner`   machine code compiled here by numba, and cached     otherwise, or GEOSURF_JIT=1
===============  ==================================================  =============================

Kernels do not depend on the choice. ``geosurf doctor`` reports it.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from geosurf.errors import DependencyError, InputError
from geosurf.kernels.compile.gate import ROOT, Gate, Signature


class Runner(Protocol):
    """One of the three runners."""

    compiles: bool  # whether kernels have to be compiled here before they run

    def scalar(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return what other kernels call."""
        ...

    def caller(
        self, name: str, function: Callable[..., Any], signature: Signature
    ) -> Callable[..., Any]:
        """Return what runs an entry on arguments that have passed its gate."""
        ...

    def describe(self) -> str:
        """Return one sentence for people."""
        ...

    def obstacle(self) -> str:
        """Return what prevents a fast start, and the remedy; empty if all is well."""
        ...


def choose() -> Runner:
    """Decide what runs the kernels of this process.

    Returns
    -------
    Runner

    Raises
    ------
    DependencyError
        If GEOSURF_FROZEN names a folder whose library cannot be used.
    """
    if _asked("NUMBA_DISABLE_JIT"):
        # Runners are imported where they are chosen: a frozen installation has no numba, and
        # importing numba takes a second.
        from geosurf.kernels.compile.gate import PlainRunner

        return PlainRunner("NUMBA_DISABLE_JIT is set")
    reason = "GEOSURF_JIT is set"
    if os.environ.get("GEOSURF_JIT", "").strip() not in ("", "0", "1"):
        raise InputError(
            f"the environment variable GEOSURF_JIT is {os.environ['GEOSURF_JIT']!r}; give 1 to "
            "compile the kernels here, or 0."
        )
    if not _asked("GEOSURF_JIT"):
        from geosurf.kernels.compile.frozen_runner import FrozenRunner, Library, Unfit, stamp_of

        folder, stamp = os.environ.get("GEOSURF_FROZEN"), stamp_of(ROOT)
        try:
            # A library that fits is taken even where numba is installed: it starts at once.
            return FrozenRunner(Library(Path(folder or ROOT / "frozen"), stamp))
        except Unfit as unfit:
            reason = str(unfit)
            # A library that was asked for by name must not be replaced silently.
            if folder:
                raise DependencyError(
                    f"GEOSURF_FROZEN={folder} cannot be used: {reason}. Unset it, or freeze "
                    "the kernels again."
                ) from unfit
    # No library fits: compile here.
    from geosurf.kernels.compile.numba_runner import JitRunner

    return JitRunner(reason)


def _asked(variable: str) -> bool:
    return os.environ.get(variable, "").strip() not in ("", "0")


RUNNER: Runner = choose()
ENTRIES: dict[str, Entry] = {}


def scalar(function: Callable[..., Any]) -> Callable[..., Any]:
    """A helper for other kernels."""
    return RUNNER.scalar(function)


def entry(signature: str) -> Callable[[Callable[..., Any]], Entry]:
    """A kernel that Python calls, with its arguments and results declared."""

    def wrap(function: Callable[..., Any]) -> Entry:
        kernel = Entry(function, Signature.parse(signature), RUNNER)

        # All kernels by name, for `warmup` and `freeze`.
        ENTRIES[kernel.name] = kernel
        return kernel

    return wrap


class Entry:
    """A kernel behind its gate.

    Parameters
    ----------
    function : callable
        The kernel as it is written.
    signature : Signature
    runner : Runner
    """

    def __init__(self, function: Callable[..., Any], signature: Signature, runner: Runner) -> None:
        self.__name__ = function.__name__
        self.__doc__ = function.__doc__
        # File and function: file names are unique among the kernels.
        self.name = f"{function.__module__.rpartition('.')[2]}.{function.__name__}"
        self.python = function
        self.signature = signature
        self._gate = Gate(function.__name__, signature)
        self._run = runner.caller(self.name, function, signature)

    def compile(self) -> bool:
        """Compile or load it now, check its results, and return whether it was there."""
        from geosurf.kernels.compile.numba_runner import check_results

        results, loaded = self._run.compile()
        check_results(self.name, results, self.signature)
        return loaded

    def __call__(self, *arguments: Any) -> Any:
        # The gate is the only check: machine code behind it checks nothing.
        try:
            return self._run(*self._gate(arguments))
        except SystemError as error:
            cause: BaseException | None = error
            while isinstance(cause, SystemError):
                cause = cause.__cause__
            if isinstance(cause, KeyboardInterrupt):  # it came inside of machine code
                raise cause from None
            raise
