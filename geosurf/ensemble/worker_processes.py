"""Worker processes of one machine: each reads the plan once, then realisations one by one.

Workers are plain Python processes that talk over pipes. They never read the script that called:
it needs no ``if __name__ == "__main__":``. A worker whose caller is gone ends by itself.
"""

from __future__ import annotations

import gc
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
from typing import Any, BinaryIO

from geosurf.ensemble.plan import Plan
from geosurf.ensemble.record import Record
from geosurf.errors import GeosurfError, WorkerError

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


class Workers:
    """
    Some worker processes, as a context: they end with it.

    Each imports geosurf while the caller builds the base case, waits for a plan, and is free when
    it has read it.

    Parameters
    ----------
    n : int
        Processes.

    Attributes
    ----------
    given : bool
        Whether they have a plan.
    """

    def __init__(self, n: int) -> None:
        self.n = n
        self.free: queue.SimpleQueue[Runner] = queue.SimpleQueue()
        self.processes: list[subprocess.Popen[bytes]] = []
        self.given = False

    def __enter__(self) -> Workers:
        self.processes = [_start() for _ in range(self.n)]
        return self

    def __exit__(self, *_: object) -> None:
        # Also where an error stops all: what they work on is not wanted any more.
        _end(self.processes)

    def give(self, data: bytes) -> None:
        """Send a plan, as `dumps` makes it, to all processes."""
        self.given = True
        # Each is waited for by a thread of its own: reading the plan takes a while.
        for process in self.processes:
            threading.Thread(target=self._greet, args=(process, data), daemon=True).start()

    def run(self, realisation: int) -> Record:
        """Run a realisation on the next worker that is free."""
        runner = self.free.get()
        try:
            return runner(realisation)
        finally:
            self.free.put(runner)

    def _greet(self, process: subprocess.Popen[bytes], data: bytes) -> None:
        """Send the plan, and free the worker when it has read it."""

        def runner(realisation: int) -> Record:
            """Run one realisation in this worker."""
            return self._asked(process, pickle.dumps(realisation))

        ready: Runner = _Failed(WorkerError(lost(f"{self.n} worker processes")))
        try:
            self._asked(process, data)
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

    def __call__(self, realisation: int) -> Record:
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
    # Until the caller is gone.
    with suppress(EOFError, OSError):
        while True:
            answer: Any = None
            failed: Exception | None = None
            try:
                asked = pickle.load(sys.stdin.buffer)
                if plan is None:
                    plan = asked
                    # What is there stays: nobody has to look for garbage in it.
                    gc.freeze()
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
