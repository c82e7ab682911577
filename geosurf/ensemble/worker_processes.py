"""Worker processes of one machine: each reads the plan once, then realisations one by one.

Workers are plain Python processes that talk over pipes. They never read the script that called:
it needs no ``if __name__ == "__main__":``. A worker whose caller is gone ends by itself.
"""

from __future__ import annotations

import json
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import monotonic
from typing import Any, BinaryIO

from geosurf.ensemble.plan import Plan
from geosurf.ensemble.record import Record
from geosurf.errors import GeosurfError, InputError, WorkerError

START = 2.0  # s until a worker has imported geosurf, loaded kernels and read the plan
LOCKED = 0.37  # share of a realisation that holds the lock of Python: one thread at a time
_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from geosurf.ensemble.worker_processes import serve; serve()"
)

# What a worker reports to its caller; `Plan.run` has made records of what geosurf raises.
_ERRORS = (
    GeosurfError, ArithmeticError, AssertionError, AttributeError, ImportError, LookupError,
    MemoryError, OSError, RuntimeError, TypeError, ValueError, pickle.PickleError,
)  # fmt: skip

Runner = Callable[[int], Record]


def processes_pay(seconds: float, n: int, workers: int, wait: float = START) -> bool:
    """Whether processes end earlier than threads, which wait for the lock of Python.

    Parameters
    ----------
    seconds : float
        Processor time of a realisation.
    n : int
        Realisations.
    workers : int
        Realisations at once.
    wait : float
        Until worker processes have started [s].

    Examples
    --------
    >>> processes_pay(0.2, 100, 2), processes_pay(0.2, 20, 2), processes_pay(9.0, 100, 1)
    (True, False, False)
    >>> processes_pay(0.05, 100, 2), processes_pay(0.05, 100, 2, wait=0.5)
    (False, True)
    """
    if workers == 1 or not interpreter():
        return False
    total = seconds * n
    # This process takes part, and need not start.
    in_processes = (total + wait * (workers - 1)) / workers
    return in_processes < total * (LOCKED + (1.0 - LOCKED) / workers)


def interpreter() -> str:
    """The Python program that workers run; empty inside of a program that only has Python in it."""
    # Such as QGIS: it would be started once more.
    program = sys.executable or ""
    is_python = Path(program).name.lower().startswith(("python", "pypy"))
    return program if is_python and not getattr(sys, "frozen", False) else ""


def dumps(plan: Plan) -> bytes:
    """Return a plan as bytes for another process; functions of a script go along."""
    import cloudpickle

    return bytes(cloudpickle.dumps(plan))


class EarlyWorkers:
    """
    Worker processes that start while the base case is built, as a context: the rest ends with it.

    They import geosurf on cores that the base case leaves idle, and wait for a plan.

    Parameters
    ----------
    n : int
    """

    def __init__(self, n: int) -> None:
        self.n = n
        self.processes: list[subprocess.Popen[bytes]] = []
        self._since = 0.0

    @property
    def wait(self) -> float:
        """How long it takes until they have started [s]; a start from now where there are none."""
        return max(START - (monotonic() - self._since), 0.0) if self.processes else START

    def __enter__(self) -> EarlyWorkers:
        self._since = monotonic()
        self.processes = [_start() for _ in range(self.n)]
        return self

    def __exit__(self, *_: object) -> None:
        _end(self.processes)

    def take(self) -> subprocess.Popen[bytes]:
        """Return the next worker; a new one where none is left."""
        return self.processes.pop() if self.processes else _start()


class Workers:
    """
    Some worker processes, as a context: they end with it.

    Parameters
    ----------
    plan : Plan
        Started.
    data : bytes
        Of `dumps`.
    n : int
        Realisations at once.
    here : bool
        Whether one of them runs in this process, which has started already.
    early : EarlyWorkers
        Are used first.
    """

    def __init__(self, plan: Plan, data: bytes, n: int, *, here: bool, early: EarlyWorkers) -> None:
        self.n, self.data, self.early = n - here, data, early
        self.free: queue.SimpleQueue[Runner] = queue.SimpleQueue()
        self.processes: list[subprocess.Popen[bytes]] = []
        if here:
            self.free.put(plan.run)

    def __enter__(self) -> Workers:
        if not interpreter():
            raise InputError(
                f"{sys.executable or 'this program'} is not a Python program, and cannot start "
                "workers. Leave out processes=True."
            )
        # Each is waited for by a thread of its own: reading the plan takes a while.
        for _ in range(self.n):
            process = self.early.take()
            self.processes.append(process)
            threading.Thread(target=self._greet, args=(process,), daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        # Also where an error stops all: what they work on is not wanted any more.
        _end(self.processes)

    def run(self, realization: int) -> Record:
        """Run a realisation on the next worker that is free."""
        runner = self.free.get()
        try:
            return runner(realization)
        finally:
            self.free.put(runner)

    def _greet(self, process: subprocess.Popen[bytes]) -> None:
        """Send the plan, and free the worker when it has read it."""

        def runner(realization: int) -> Record:
            """Run one realisation in this worker."""
            found: Record = self._asked(process, pickle.dumps(realization))
            return found

        ready: Runner = _Failed(WorkerError(lost(f"{self.n} worker processes")))
        try:
            self._asked(process, self.data)
            ready = runner
        except _ERRORS as error:  # `run` raises it in the thread that asks
            ready = _Failed(error)
        finally:
            self.free.put(ready)

    def _asked(self, process: subprocess.Popen[bytes], question: bytes) -> Any:
        """Send bytes to a worker, and return what it answers."""
        assert process.stdin is not None  # both are pipes
        assert process.stdout is not None
        try:
            process.stdin.write(question)
            process.stdin.flush()
            answer, error = pickle.load(process.stdout)
        except (OSError, EOFError, pickle.UnpicklingError, ValueError) as gone:
            raise WorkerError(lost(f"{self.n} worker processes")) from gone
        if error is not None:
            raise error
        return answer


class _Failed:
    """A worker that could not start: each realisation that it is asked for fails like it."""

    def __init__(self, error: BaseException) -> None:
        self.error = error

    def __call__(self, realization: int) -> Record:
        raise self.error


def lost(where: str) -> str:
    """The message for a worker that is gone."""
    return (
        f"a worker of {where} was lost (killed, or out of memory). Run the same call again: it "
        "continues with what is stored; fewer workers need less memory."
    )


def _start() -> subprocess.Popen[bytes]:
    """A worker that waits for its plan."""
    # Modules are found where this process finds them; workers share the cores.
    path = json.dumps([str(folder) for folder in sys.path])
    return subprocess.Popen(
        [interpreter(), "-c", _CODE, path],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        env={"GEOSURF_THREADS": "1", **os.environ},
    )  # fmt: skip


def _end(processes: list[subprocess.Popen[bytes]]) -> None:
    """End processes, whatever they do, and close their pipes."""
    for process in processes:
        process.kill()
    for process in processes:
        process.wait()
        for pipe in (process.stdin, process.stdout):
            _close(pipe)


def _close(pipe: BinaryIO | Any) -> None:
    # What a killed worker had not read is not missing.
    with suppress(OSError):
        pipe.close()


def serve() -> None:
    """What a worker does: read a plan, then numbers of realisations, and answer each."""
    # Whatever prints writes to stderr: answers have the pipe for themselves.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    # Ctrl-C is for the caller, which ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    plan: Plan | None = None
    # The answer to the plan is that it could be read; until the caller is gone, or closes the pipe.
    with suppress(EOFError, OSError):
        while True:
            answer, failed = None, None
            try:
                asked = pickle.load(sys.stdin.buffer)
                if plan is None:
                    plan = asked
                else:
                    answer = plan.run(asked)
            except EOFError:
                raise
            except _ERRORS as error:  # such as a function of a module that is not found here
                failed = error
            answers.write(_packed(answer, failed))
            answers.flush()


def _packed(answer: Any, error: Exception | None) -> bytes:
    """An answer or an error, as bytes."""
    try:
        return pickle.dumps((answer, error))
    except _ERRORS:  # an error that holds what cannot be sent
        return pickle.dumps((None, RuntimeError(f"{type(error).__name__}: {error}")))


__all__ = ["EarlyWorkers", "Workers", "dumps", "interpreter", "lost", "processes_pay", "serve"]
