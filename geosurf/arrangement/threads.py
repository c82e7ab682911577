"""Run independent tasks in threads, with results in order; kernels release the lock of Python."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from queue import SimpleQueue
from threading import Lock, Thread
from typing import Any

import numpy as np

from geosurf.conventions.machine import free_memory
from geosurf.errors import InputError

# ---- room ----------------------------------------
# Arrays with room for more rows than they have yet, or got.


def shortened(array: np.ndarray, n: int) -> np.ndarray:
    """
    Shorten an array to its first rows, in place: what lay behind them is given back.

    A view would keep all of the memory, a copy needs as much again. Nothing else may look into the
    array.

    Parameters
    ----------
    array : ndarray
        Owns its memory.
    n : int
        Rows that remain, at most all.

    Returns
    -------
    ndarray
        The same array.

    Examples
    --------
    >>> shortened(np.arange(5), 2)
    array([0, 1])
    """
    if n < len(array):
        # without a check, since it counts names of this array, too, which stay valid
        array.resize((n, *array.shape[1:]), refcheck=False)
    return array


# ---- memory limit ----------------------------------------
# Check that pairs of triangles fit into memory, before they are stored.
#
# Most scenes have a few pairs for each triangle near a curve. Where thousands of triangles
# coincide, or all pass through one point, the number of pairs is their square. Then an error with
# numbers comes before the system has to end the process.


PAIR = 80  # bytes of a candidate pair, over all steps
CONTACT = 400  # bytes of two triangles that meet
IN_PLANE = 1200  # bytes of two that lie in one plane
_SMALL = 256 << 20  # bytes, below which there is no check


class TooManyPairs(Exception):
    """More pairs than fit into memory; the caller makes an `InputError` with names of surfaces.

    Attributes
    ----------
    n : int
        Number of pairs.
    """

    def __init__(self, n: int) -> None:
        super().__init__(n)
        self.n = n


def check_pairs(n: int) -> None:
    """Raise `TooManyPairs` if `n` candidate pairs need more memory than is free."""
    if lack_of_room(n * PAIR) is not None:
        raise TooManyPairs(n)


def refusal(
    n: int, names: list[str], size: int = PAIR, what: str = "pairs of triangles that may meet"
) -> InputError:
    """Return the error for `n` pairs of `size` bytes each, between named surfaces.

    Examples
    --------
    >>> print(refusal(5_000_000_000, ["Salt", "Salt"]))  # doctest: +ELLIPSIS
    surface 'Salt' has 5 000 000 000 pairs of triangles that may meet, which need 400 GB of ...
    """
    named = sorted(set(names))
    if len(named) == 1:
        who = f"surface {named[0]!r} has"
    elif len(named) == 2:
        who = f"surfaces {named[0]!r} and {named[1]!r} have"
    else:
        who = f"{len(named)} surfaces have"
    free = free_memory()
    have = "" if free is None else f" and {gigabytes(free)} are free"
    count = f"{n:,}".replace(",", " ")
    return InputError(
        f"{who} {count} {what}, which need {gigabytes(n * size)} of memory{have}. "
        "Remove duplicate surfaces, coarsen the others (triangulate_horizon(..., "
        "tolerance=...)), or use a larger machine.",
        surfaces=named,
    )


def lack_of_room(needed: int) -> int | None:
    """Return the bytes of free memory if they are fewer than needed, else None."""
    if needed < _SMALL:
        return None
    free = free_memory()
    return free if free is not None and free < needed else None


def gigabytes(n: int) -> str:
    """A number of bytes in GB.

    Examples
    --------
    >>> gigabytes(5_200_000_000), gigabytes(12_300_000_000)
    ('5.2 GB', '12 GB')
    """
    return f"{n / 1e9:,.0f} GB".replace(",", " ") if n >= 1e10 else f"{n / 1e9:.1f} GB"


# ---- threads ----------------------------------------
# Threads that wait for tasks, and nothing that a keyboard interrupt could leave behind.
#
# An interrupt may come at any moment in the thread that asks: while a thread starts, or while it
# waits. So threads are daemons, which Python does not wait for at its end; no task depends on one,
# since who asks does what no thread has begun; and who waits for a task goes on waiting until the
# task has ended, then raises the interrupt. `concurrent.futures` promises none of these.

_CORES: ContextVar[int | None] = ContextVar("cores", default=None)


@contextmanager
def on_one_core() -> Iterator[None]:
    """Use one thread only: others of this process, or other processes, have the other cores.

    Examples
    --------
    >>> with on_one_core():
    ...     n_threads()
    1
    """
    token = _CORES.set(1)
    try:
        yield
    finally:
        _CORES.reset(token)


def n_threads() -> int:
    """Number of threads: GEOSURF_THREADS, or the cores that this process may use.


    Raises
    ------
    InputError
        If GEOSURF_THREADS is not a whole number above 0.
    """
    count = _CORES.get()
    if count is not None:
        return count
    said = os.environ.get("GEOSURF_THREADS")
    if said is None:
        cores = getattr(os, "sched_getaffinity", None)
        return len(cores(0)) if cores else os.cpu_count() or 1
    if not said.isdecimal() or int(said) < 1:
        raise InputError(f"GEOSURF_THREADS is {said!r}; give a whole number above 0.")
    return int(said)


def map_threads(work: Callable[..., Any], rows: Sequence[tuple], worth: bool = True) -> list[Any]:
    """Return ``[work(*row) for row in rows]``, on several threads if that is worth it.

    The thread that asks is one of them: it takes rows from the end, others from the front. What no
    other thread has begun is done here, so nobody waits for threads that are busy with others.

    Examples
    --------
    >>> map_threads(divmod, [(7, 2), (9, 4)])
    [(3, 1), (2, 1)]
    """
    n = min(n_threads(), len(rows)) if worth else 1
    if n <= 1:
        return [work(*row) for row in rows]
    queue = _Rows(work, rows)
    helpers: list[Task] = []
    try:
        _waiting.grow(n_threads() - 1)
        for _ in range(n - 1):
            helpers.append(_waiting.submit(queue.do_first))
        queue.do_last()
    finally:  # also after a keyboard interrupt: nothing runs on afterwards
        queue.close()
        for helper in helpers:
            if not helper.cancel():
                helper.result()
    return queue.results()


class _Rows:
    """Rows of one call of `map_threads`, which several threads take from both ends."""

    def __init__(self, work: Callable[..., Any], rows: Sequence[tuple]) -> None:
        self._work = work
        self._rows: Sequence[tuple] = rows
        self._found: list[Any] = [None] * len(rows)
        self._errors: dict[int, Exception] = {}
        self._first, self._end, self._lock = 0, len(rows), Lock()

    def do_first(self) -> None:
        """Do rows from the front, until none is left."""
        while True:
            with self._lock:
                k = self._first
                if k >= self._end:
                    return
                self._first += 1
            self._do(k)

    def do_last(self) -> None:
        """Do rows from the end, until none is left."""
        while True:
            with self._lock:
                k = self._end - 1
                if k < self._first:
                    return
                self._end = k
            self._do(k)

    def _do(self, k: int) -> None:
        """Do one row; `results` raises its error."""
        with _NoneBehind(self, k):
            self._found[k] = self._work(*self._rows[k])

    def failed(self, k: int, error: Exception) -> None:
        """Begin no row behind one that has failed, as with one thread."""
        with self._lock:
            self._errors[k] = error
            self._end = min(self._end, k)

    def close(self) -> None:
        """Let no further row begin."""
        with self._lock:
            self._end = self._first

    def results(self) -> list[Any]:
        """Return results in order, or raise the error of the first row that has one."""
        # a helper that was cancelled is held until its thread is free: it shall hold no arrays
        returned, errors = self._found, self._errors
        self._rows, self._found, self._errors = (), [], {}
        if errors:
            raise errors[min(errors)]
        return returned


class _NoneBehind:
    """Hand the error of a row to the rows of its call: one of another thread may come before it."""

    def __init__(self, rows: _Rows, k: int) -> None:
        self._rows, self._k = rows, k

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> bool:
        if not isinstance(error, Exception):  # nor a keyboard interrupt
            return False
        self._rows.failed(self._k, error)
        return True


class Task:
    """Work for another thread, which who asked may take back while no thread has begun it."""

    def __init__(self, work: Callable[[], Any]) -> None:
        self._work: Callable[[], Any] | None = work
        self._taken, self._ended = Lock(), False
        self._news: SimpleQueue[None] = SimpleQueue()
        self._value: Any = None
        self._error: BaseException | None = None

    def cancel(self) -> bool:
        """Take it back; False if a thread has begun it."""
        if not self._taken.acquire(blocking=False):
            return False
        self._work, self._ended = None, True  # nobody waits for it
        return True

    def run(self) -> None:
        """Do it, in another thread, unless it was taken back."""
        if self._taken.acquire(blocking=False):
            with self:
                self._value = self._work() if self._work else None

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> bool:
        self._work, self._error, self._ended = None, error, True
        self._news.put(None)
        return True  # raised by `result`

    def wait(self) -> None:
        """Wait for the end of what was begun; a keyboard interrupt is raised then."""
        stopped: KeyboardInterrupt | None = None
        while not self._ended:
            try:
                self._news.get()
            except KeyboardInterrupt as interrupt:
                stopped = interrupt
        if stopped:
            raise stopped

    def result(self) -> Any:
        """Wait for its end, and return its value or raise its error."""
        self.wait()
        if self._error:
            raise self._error
        return self._value


class Threads:
    """Threads that take tasks one by one, in the order in which these are submitted."""

    def __init__(self) -> None:
        self._tasks: SimpleQueue[Task | None] = SimpleQueue()
        self._n, self._lock = 0, Lock()

    def grow(self, n: int) -> None:
        """Have at least n threads."""
        with self._lock:
            while self._n < n:
                # Counted before: an interrupt while a thread starts costs a thread, nothing else.
                self._n += 1
                Thread(target=self._serve, name="geosurf", daemon=True).start()

    def submit(self, work: Callable[[], Any]) -> Task:
        """Give a task to the next thread that is free."""
        task = Task(work)
        self._tasks.put(task)
        return task

    def end(self) -> None:
        """Let all threads end after the tasks that they have."""
        for _ in range(self._n):
            self._tasks.put(None)

    def _serve(self) -> None:
        while (task := self._tasks.get()) is not None:
            task.run()
            del task  # a waiting thread holds nothing


# They live as long as the process: to start a thread takes 0.1 ms, and a change asks 30 times.
_waiting = Threads()


def _have_no_threads() -> None:
    """Forget the threads of the process that this one was forked from: they are not here."""
    global _waiting
    _waiting = Threads()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_have_no_threads)


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
def spare_threads(worth: bool = True) -> Iterator[Threads | None]:
    """Give all threads but the one that asks; None if there are none.

    Examples
    --------
    >>> with spare_threads(worth=False) as spare:
    ...     in_turn([lambda: 1, lambda: 2], spare)
    [1, 2]
    """
    if not worth or n_threads() == 1:
        yield None
        return
    spare = Threads()
    spare.grow(n_threads() - 1)
    try:
        yield spare
    finally:
        spare.end()


def in_turn(tasks: Sequence[Callable[[], Any]], spare: Threads | None) -> list[Any]:
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
    try:
        returned = [task() for task in tasks[:1]]
        for task, given in zip(tasks[1:], later, strict=True):
            returned.append(task() if given.cancel() else given.result())
    finally:  # nothing runs on after an error
        for given in later:
            if not given.cancel():
                given.wait()
    return returned
