"""Realisations on Dask: local threads or processes, or any cluster that has a client.

Results come back one by one, in any order, and are handed on at once: nothing waits for the end.
"""

from __future__ import annotations

import os
import pickle
import time
from collections.abc import Callable, Iterable
from functools import partial
from importlib.util import find_spec
from typing import Any

from geosurf.arrangement.threads import n_threads
from geosurf.ensemble.contact_levels import ContactLevel
from geosurf.ensemble.plan import Plan
from geosurf.ensemble.record import Record
from geosurf.ensemble.worker_processes import (
    EarlyWorkers,
    Workers,
    dumps,
    interpreter,
    lost,
    processes_pay,
)
from geosurf.errors import DependencyError, InputError, WorkerError

OnRecord = Callable[[Record], None]
_FEW = 8  # realisations: fewer are in threads
_MANY = 50  # realisations that move surfaces: a worker starts before the first one is timed
_PLANS: dict[str, Plan] = {}  # of a worker of a cluster: the one that it works on


def require_extra() -> None:
    """Raise an error that names the extra, if a package of it is missing."""
    # Found without importing: dask takes a second to load.
    missing = [name for name in ("dask", "zarr") if find_spec(name) is None]
    if missing:
        raise DependencyError(
            f"ensembles need {' and '.join(missing)}, which cannot be imported. Install the extra: "
            'pip install "geosurf[ensemble]"'
        )


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


def early_workers(
    plan: Plan, n: int, client: Any, workers: int, processes: bool | None
) -> EarlyWorkers:
    """Return the workers that start before the base case is built.

    All of them where `processes` is True. Where the first realisation decides, all but this process
    for long ensembles that move surfaces: these end as processes on nearly all machines. At worst,
    another core has imported geosurf in vain.
    """
    if client is not None or processes is False or not interpreter():
        return EarlyWorkers(0)
    if processes:
        return EarlyWorkers(min(workers, n))
    moves = any(not isinstance(one, ContactLevel) for one in plan.uncertain)
    return EarlyWorkers(min(workers, n) - 1 if moves and plan.model.is_data and n >= _MANY else 0)


def run_on_dask(
    plan: Plan,
    numbers: Iterable[int],
    on_record: OnRecord,
    *,
    client: Any = None,
    workers: int = 1,
    processes: bool | None = None,
    early: EarlyWorkers | None = None,
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
        Whether workers are processes, not threads. Default: whatever is expected to end earlier,
        by the time of the first realisation.
    early : EarlyWorkers, optional
        Processes that have started already.

    Raises
    ------
    WorkerError
        If a worker is lost for good.
    """
    wanted = list(numbers)
    if not wanted:
        return
    # A client has its own workers: `workers` and `processes` count without it only.
    if client is not None:
        _on_cluster(plan, wanted, on_record, client)
        return
    early = EarlyWorkers(0) if early is None else early
    if processes:
        _in_processes(plan, dumps(plan), wanted, on_record, workers, early, here=False)
        return
    data = _tried(plan, wanted, on_record, workers, early) if processes is None else None
    if data is not None:
        _in_processes(plan, data, wanted, on_record, workers, early, here=True)
    else:
        from dask.threaded import get

        _streamed(get, _graph(plan.run, wanted), on_record, num_workers=workers)


def _streamed(get: Callable[..., Any], graph: dict, on_record: OnRecord, **options: Any) -> None:
    """Compute a graph of Dask; hand on each result when it is there, and forget it."""
    from dask.callbacks import Callback

    def done(key: Any, record: Record, _: Any, state: dict[str, Any], __: Any) -> None:
        """Take one result from the scheduler."""
        # Dask would keep all results until the end; maps of thousands would fill memory.
        state["cache"][key] = None
        on_record(record)

    with Callback(posttask=done):  # type: ignore[no-untyped-call]
        get(graph, list(graph), **options)


def _in_processes(
    plan: Plan,
    data: bytes,
    wanted: list[int],
    on_record: OnRecord,
    workers: int,
    early: EarlyWorkers,
    here: bool,
) -> None:
    """Worker processes, each asked by a thread of this one."""
    from dask.threaded import get

    with Workers(plan, data, min(workers, len(wanted)), here=here, early=early) as pool:
        _streamed(get, _graph(pool.run, wanted), on_record, num_workers=workers)


def _tried(
    plan: Plan, wanted: list[int], on_record: OnRecord, workers: int, early: EarlyWorkers
) -> bytes | None:
    """Run the first realisation here; the plan as bytes if processes are faster for the others."""
    # A function may have effects that the caller waits for: it stays in this process.
    if workers == 1 or len(wanted) < _FEW or not plan.model.is_data:
        return None
    start = time.process_time()
    record = plan.run(wanted[0])
    seconds = time.process_time() - start
    on_record(record)
    del wanted[0]
    if not processes_pay(seconds, len(wanted), workers, early.wait):
        return None
    try:
        return dumps(plan)
    except (TypeError, AttributeError, pickle.PicklingError):  # threads take anything
        return None


def _on_cluster(plan: Plan, wanted: list[int], on_record: OnRecord, client: Any) -> None:
    """A cluster: it repeats the realisations of a lost worker by itself, a few times."""
    from distributed import as_completed
    from distributed.client import FutureCancelledError
    from distributed.comm.core import CommClosedError
    from distributed.scheduler import KilledWorker

    # Sent to each worker once.
    remote = client.scatter(dumps(plan), broadcast=True, hash=False)
    token = plan.identity
    # Keys of their own: a cluster remembers results by key, and another run must not get these.
    futures = client.map(
        lambda k, data: run_from_bytes(token, data, k), wanted, data=remote, pure=False,
        key=[f"geosurf-realization-{os.urandom(4).hex()}-{k}" for k in wanted],
    )  # fmt: skip
    try:
        finished: Any = as_completed
        # As they come, in any order; the store puts them in order.
        for _, record in finished(futures, with_results=True):
            on_record(record)
    except (KilledWorker, FutureCancelledError, CommClosedError) as error:
        raise WorkerError(lost("the Dask cluster")) from error
    finally:
        # What has not started is not needed after an error.
        client.cancel(futures)


def _graph(run: Callable[[int], Record], wanted: list[int]) -> dict[str, Any]:
    """Tasks of Dask, named so that it runs the realisations in their order."""
    from dask.order import order

    names = [f"realization-{row:09d}" for row in range(len(wanted))]
    # Dask orders tasks by itself: names are handed out so that its order is ours.
    rank = order(dict.fromkeys(names, (int,)))
    names.sort(key=rank.__getitem__)
    return {name: (partial(run, k),) for name, k in zip(names, wanted, strict=True)}


def run_from_bytes(token: str, data: bytes, realization: int) -> Record:
    """Run a realisation on a worker of a cluster; its plan is opened once."""
    plan = _PLANS.get(token)
    if plan is None:
        plan = pickle.loads(data)
        _PLANS.clear()
        _PLANS[token] = plan
    return plan.run(realization)


__all__ = ["check_workers", "require_extra", "run_on_dask"]
