"""Where realisations run: in local threads or processes, or on any cluster of Dask with a client.

Results come back one by one, in any order, and are handed on at once: nothing waits for the end.
`workers_for` chooses and starts local processes (`Workers`), `run_on_dask` runs the realisations.
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
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

from geosurf.arrangement.threads import n_threads, on_one_core
from geosurf.conventions.machine import need
from geosurf.ensemble.plan import Plan
from geosurf.ensemble.record import Record
from geosurf.ensemble.uncertain import ContactLevel
from geosurf.errors import GeosurfError, InputError, WorkerError

# ---- worker processes ----------------------------------------
# Worker processes of one machine: each reads the plan once, then realisations one by one.
#
# Workers are plain Python processes that talk over pipes. They never read the script that called:
# it needs no ``if __name__ == "__main__":``. A worker whose caller is gone ends by itself.


_CODE_OF_WORKER = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from geosurf.ensemble.on_dask import serve; serve()"
)

# What a worker reports to its caller; `Plan.run` has made records of what geosurf raises.
_ERRORS = (
    GeosurfError, ArithmeticError, AssertionError, AttributeError, ImportError, LookupError,
    MemoryError, OSError, RuntimeError, TypeError, ValueError, pickle.PickleError,
)  # fmt: skip

Runner = Callable[[int], Record]


def interpreter() -> str:
    """The Python program that workers run; empty inside of a program that only has Python in it.

    Such a program, as QGIS is one, would be started once more.
    """
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
            record: Record = self._answer_of(process, pickle.dumps(realisation))
            return record

        ready: Runner = _Failed(WorkerError(lost(f"{self.n} worker processes")))
        try:
            self._answer_of(process, data)
            ready = runner
        except _ERRORS as error:  # `run` raises it in the thread that asks
            ready = _Failed(error)
        finally:
            self.free.put(ready)

    def _answer_of(self, process: subprocess.Popen[bytes], question: bytes) -> Any:
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
        [interpreter(), "-c", _CODE_OF_WORKER, path],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        env={"GEOSURF_THREADS": "1", **os.environ},
    )  # fmt: skip


def _end(processes: list[subprocess.Popen[bytes]]) -> None:
    """End processes, whatever they do, and close their pipes."""
    for process in processes:
        process.kill()
    for process in processes:
        process.wait()
        for pipe in filter(None, (process.stdin, process.stdout)):
            with suppress(OSError):  # what a killed worker had not read is not missing
                pipe.close()


def serve() -> None:
    """What a worker does: read a plan, then numbers of realisations, and answer each."""
    # Whatever prints writes to stderr: answers have the pipe for themselves.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    # Ctrl-C is for the caller, which ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    plan: Plan | None = None
    with suppress(EOFError, OSError):  # of the pipe: the caller is gone
        while True:
            answer: Any = None
            failure: Exception | None = None
            try:
                question = pickle.load(sys.stdin.buffer)
                if plan is None:
                    plan = question
                    # What is there stays: nobody has to look for garbage in it.
                    gc.freeze()
                else:
                    answer = plan.run(question)
            except EOFError:
                raise
            except _ERRORS as error:  # such as a function of a module that is not found here
                failure = error
            answers.write(_answer_as_bytes(answer, failure))
            answers.flush()


def _answer_as_bytes(answer: Any, error: Exception | None) -> bytes:
    """An answer or an error, as bytes."""
    try:
        return pickle.dumps((answer, error))
    except _ERRORS:  # an error that holds what cannot be sent
        return pickle.dumps((None, RuntimeError(f"{type(error).__name__}: {error}")))


# ---- realisations ----------------------------------------


OnRecord = Callable[[Record], None]
_PROCESSES_FROM = 50  # realisations that move surfaces, from which they run in processes
_NOT_PICKLED = (TypeError, AttributeError, pickle.PicklingError)
_PLANS: dict[str, Plan] = {}  # of a worker of a cluster: the plan that it works on


def require_extra() -> None:
    """Raise an error that names the extra, if a package of it is missing."""
    need("ensembles need", "zarr")


def check_workers(workers: Any) -> int:
    """Return how many realisations run at once; None: the number of threads of geosurf.

    Examples
    --------
    >>> check_workers(3)
    3
    """
    if workers is None:
        return n_threads()
    # type(): True is an int.
    if type(workers) is not int or workers < 1:
        raise InputError(f"workers is {workers!r}; give a whole number above 0.")
    return workers


def workers_for(plan: Plan, n: int, client: Any, workers: int, processes: bool | None) -> Workers:
    """Return the worker processes of an ensemble, none where it runs in threads.

    Where `processes` is left open, long ensembles that move surfaces run in processes, and this one
    is a worker, too. Functions that build scenes stay in threads: they may have effects here.

    Raises
    ------
    InputError
        If `processes` is True inside a program that only has Python in it.
    """
    if client is not None or processes is False:
        return Workers(0)
    if processes:
        if not interpreter():
            raise InputError(
                f"{sys.executable or 'this program'} is not a Python program, and cannot start "
                "workers. Leave out processes=True."
            )
        return Workers(min(workers, n))
    moves = any(not isinstance(uncertain, ContactLevel) for uncertain in plan.uncertain)
    pays = n >= _PROCESSES_FROM and moves and plan.model.is_data and interpreter()
    return Workers(min(workers, n) - 1 if pays else 0)


def give_plan(plan: Plan, pool: Workers, processes: bool | None) -> None:
    """Give the started plan to worker processes, if there are any."""
    if not pool.n:
        return
    try:
        pool.give(dumps(plan))
    except _NOT_PICKLED:  # threads take any plan
        if processes:
            raise


def run_on_dask(
    plan: Plan,
    numbers: Iterable[int],
    on_record: OnRecord,
    *,
    client: Any = None,
    workers: int = 1,
    processes: bool | None = None,
    pool: Workers,
) -> None:
    """
    Run realisations and hand on the record of each as soon as it is there.

    Parameters
    ----------
    plan : Plan
        Started.
    numbers : iterable of int
        Of the realisations.
    on_record : callable
        Is called in the calling thread, in any order of the realisations.
    client : distributed.Client, optional
        Runs them; the others count without it.
    workers : int
        Realisations at once.
    processes : bool, optional
        As for `workers_for`.
    pool : Workers
        Of `workers_for`; `give_plan` may have given them the plan.

    Raises
    ------
    WorkerError
        If a worker is lost for good.
    """
    waiting = list(numbers)
    if not waiting:
        return
    # A client has its own workers: `workers` and `processes` count without it only.
    if client is not None:
        _run_on_cluster(plan, waiting, on_record, client)
        return
    run: Runner = pool.run
    if not pool.given:  # in threads of this process; a single one may use several cores
        at_once = min(workers, len(waiting))
        run = plan.run if at_once == 1 else _on_one_core(plan.run)
    elif processes:
        at_once = pool.n
    else:  # this process is a worker, too
        at_once = pool.n + 1
        pool.free.put(_on_one_core(plan.run))
    _run_in_threads(run, waiting, on_record, min(at_once, len(waiting)))


def _run_in_threads(
    run: Runner, realisations: list[int], on_record: OnRecord, n_thread: int
) -> None:
    """Run realisations in their order; hand on each result, then begin another one."""
    pool, numbers = ThreadPoolExecutor(n_thread), iter(realisations)
    try:
        waiting = {pool.submit(run, k) for k in islice(numbers, n_thread)}
        while waiting:
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                on_record(future.result())
                waiting |= {pool.submit(run, k) for k in islice(numbers, 1)}
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _on_one_core(run: Runner) -> Runner:
    """A runner that uses one core, where other realisations run on the other cores."""

    def run_on_one_core(realisation: int) -> Record:
        """Run a realisation."""
        with on_one_core():
            return run(realisation)

    return run_on_one_core


def _run_on_cluster(plan: Plan, realisations: list[int], on_record: OnRecord, client: Any) -> None:
    """Run on a cluster, which repeats the realisations of a lost worker by itself, a few times."""
    from distributed import as_completed
    from distributed.client import FutureCancelledError
    from distributed.comm.core import CommClosedError
    from distributed.scheduler import KilledWorker

    # Sent to each worker once.
    remote = client.scatter(dumps(plan), broadcast=True, hash=False)
    token = plan.identity
    # Keys of their own: a cluster remembers results by key, and another run must not get these.
    futures = client.map(
        lambda k, data: run_from_bytes(token, data, k), realisations, data=remote, pure=False,
        key=[f"geosurf-realisation-{os.urandom(4).hex()}-{k}" for k in realisations],
    )  # fmt: skip
    try:
        in_any_order: Any = as_completed  # its annotations lack a loop over pairs
        for _, record in in_any_order(futures, with_results=True):
            on_record(record)
    except (KilledWorker, FutureCancelledError, CommClosedError) as error:
        raise WorkerError(lost("the Dask cluster")) from error
    finally:
        # What has not started is not needed after an error.
        client.cancel(futures)


def run_from_bytes(token: str, data: bytes, realisation: int) -> Record:
    """Run a realisation on a worker of a cluster; its plan is opened once."""
    plan = _PLANS.get(token)
    if plan is None:
        plan = pickle.loads(data)
        _PLANS.clear()
        _PLANS[token] = plan
    return plan.run(realisation)
