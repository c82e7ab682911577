"""Run independent tasks in threads, with results in order; kernels release the lock of Python."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock
from typing import TYPE_CHECKING, Any

from geosurf.errors import InputError

if TYPE_CHECKING:
    from concurrent.futures import Executor


_CORES: ContextVar[Callable[[], int] | None] = ContextVar("cores", default=None)


@contextmanager
def on_one_core() -> Iterator[None]:
    """Use one thread only: others of this process, or other processes, have the other cores.

    Examples
    --------
    >>> with on_one_core():
    ...     n_threads()
    1
    """
    with _cores(lambda: 1):
        yield


@contextmanager
def _cores(count: Callable[[], int]) -> Iterator[None]:
    """Use as many threads as a function gives when it is asked."""
    token = _CORES.set(count)
    try:
        yield
    finally:
        _CORES.reset(token)


def n_threads() -> int:
    """Number of threads: GEOSURF_THREADS, or the cores that this process may use.

    A task of `run_in_threads` has those that other tasks do not use.

    Raises
    ------
    InputError
        If GEOSURF_THREADS is not a whole number above 0.
    """
    count = _CORES.get()
    if count is not None:
        return count()
    said = os.environ.get("GEOSURF_THREADS")
    if said is None:
        cores = getattr(os, "sched_getaffinity", None)
        return len(cores(0)) if cores else os.cpu_count() or 1
    if not said.isdecimal() or int(said) < 1:
        raise InputError(f"GEOSURF_THREADS is {said!r}; give a whole number above 0.")
    return int(said)


def map_threads(work: Callable[..., Any], rows: Sequence[tuple], worth: bool = True) -> list[Any]:
    """Return ``[work(*row) for row in rows]``, on several threads if that is worth it.

    The thread that asks is one of them: it takes rows from the end that no other one has begun.

    Examples
    --------
    >>> map_threads(divmod, [(7, 2), (9, 4)])
    [(3, 1), (2, 1)]
    """
    n = min(n_threads(), len(rows)) if worth else 1
    if n <= 1:
        return [work(*row) for row in rows]
    from concurrent.futures import ThreadPoolExecutor  # a tenth of a short process's own imports

    with ThreadPoolExecutor(n - 1) as pool:
        futures = [pool.submit(work, *row) for row in rows]
        k, last = len(rows), []
        try:
            while k > 0 and futures[k - 1].cancel():
                k -= 1
                last.append(work(*rows[k]))
        finally:  # of several errors the first one is raised, as with one thread
            first = [future.result() for future in futures[:k]]
    return first + last[::-1]


def run_in_threads(
    tasks: Sequence[Callable[[], bool]], on_start: Callable[[int], object] = lambda _: None
) -> None:
    """Run long tasks in threads, in order; after one that returns False no further one begins.

    The thread that asks calls `on_start` with the number of each task that begins, in order, and
    waits. So all before a task that returns False are done.

    Examples
    --------
    >>> found = {}
    >>> run_in_threads([lambda: found.update(a=1) is None, lambda: False], print)
    0
    1
    """
    n = min(n_threads(), len(tasks))
    if n <= 1:
        for number, task in enumerate(tasks):
            on_start(number)
            if not task():
                return
        return
    from concurrent.futures import ThreadPoolExecutor
    from queue import SimpleQueue

    n_core, running, end = n_threads(), [0], len(tasks)
    lock, events = Lock(), SimpleQueue[int | None]()

    def run(number: int) -> None:
        """One task, with the cores that others leave; none behind one that has failed."""
        nonlocal end
        with lock:
            if number > end:
                return
            running[0] += 1
        events.put(number)
        try:
            with _cores(lambda: max(1, n_core - running[0] + 1)):
                if not tasks[number]():
                    with lock:
                        end = min(end, number)
        finally:
            with lock:
                running[0] -= 1

    with ThreadPoolExecutor(n) as pool:
        futures = [pool.submit(run, number) for number in range(len(tasks))]
        for future in futures:
            future.add_done_callback(lambda _: events.put(None))
        try:
            n_begun, n_done = 0, 0
            while n_done < len(tasks):
                event = events.get()
                n_done += event is None
                while event is not None and n_begun <= event:
                    on_start(n_begun)
                    n_begun += 1
        finally:  # also after a keyboard interrupt: what has not begun is left
            with lock:
                end = -1 if n_done < len(tasks) else end
    for future in futures:
        future.result()


def in_ranges(n: int, least: int) -> list[tuple[int, int]]:
    """Divide the numbers below n into a range for each thread, of at least so many; or into one.

    Examples
    --------
    >>> in_ranges(7, 8)
    [(0, 7)]
    """
    n_part = max(1, min(n_threads(), n // least))
    return [(n * k // n_part, n * (k + 1) // n_part) for k in range(n_part)]


@contextmanager
def spare_threads(worth: bool = True) -> Iterator[Executor | None]:
    """Give all threads but the one that asks, as an executor; None if there are none.

    Examples
    --------
    >>> with spare_threads(worth=False) as spare:
    ...     in_turn([lambda: 1, lambda: 2], spare)
    [1, 2]
    """
    if not worth or n_threads() == 1:
        yield None
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(n_threads() - 1) as pool:
        yield pool


def in_turn(tasks: Sequence[Callable[[], Any]], spare: Executor | None) -> list[Any]:
    """Return what tasks return; spare threads take them from the second one on, when they are free.

    What no thread has begun is done here, so no task waits for a thread that is busy with others.

    Examples
    --------
    >>> with spare_threads() as spare:
    ...     in_turn([lambda: 1, lambda: 2], spare)
    [1, 2]
    """
    if spare is None:
        return [task() for task in tasks]
    later = [spare.submit(task) for task in tasks[1:]]
    found = [task() for task in tasks[:1]]
    for task, future in zip(tasks[1:], later, strict=True):
        found.append(task() if future.cancel() else future.result())
    return found
