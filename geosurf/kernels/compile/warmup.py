"""Compile all kernels ahead of time: ``geosurf warmup``.

numba holds one lock while it compiles, so threads do not help; processes with one cache do, one for
each core. A file is compiled by one process.
"""

from __future__ import annotations

import gc
import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from importlib import import_module

from geosurf.errors import OutputError
from geosurf.kernels.compile import jit
from geosurf.kernels.compile.gate import ROOT, kernel_files, module_of

Progress = Callable[[int, int], object]


def warm(progress: Progress | None = None) -> str:
    """
    Compile every kernel that is not compiled yet, and cache it.

    Parameters
    ----------
    progress : callable, optional
        Called with the number of files done, and of all.

    Returns
    -------
    str
        One sentence: what was done, or why there is nothing to do.

    Raises
    ------
    OutputError
        If compiled kernels cannot be saved.
    """
    what = jit.RUNNER.describe()
    if not jit.RUNNER.compiles:
        return f"Nothing to compile: {what}"
    from geosurf.kernels.compile.numba_runner import kernel_folder

    obstacle = jit.RUNNER.obstacle()
    if obstacle:
        raise OutputError(f"Compiled kernels could not be reused. {obstacle}")
    start = time.perf_counter()
    found = _compile_all([module_of(path) for path in kernel_files(ROOT)], progress)
    n_loaded = sum(found.values())
    n_new = len(found) - n_loaded
    done = f"{n_new} kernels compiled in {time.perf_counter() - start:.0f} s"
    return f"{done}, {n_loaded} were compiled before; cached in {kernel_folder()}."


def _compile_all(names: list[str], progress: Progress | None) -> dict[str, bool]:
    """Whether each kernel was there already; files are shared out among processes."""
    there_before: dict[str, bool] = {}
    # Workers of somebody else, a notebook for example, are left alone.
    others = set(multiprocessing.active_children())
    spawn = multiprocessing.get_context("spawn")  # a fork would take over threads and their locks
    waiting, n_file = list(names), len(names)
    pools = [ProcessPoolExecutor(1, spawn, _begin_worker) for _ in range(n_processes())]
    # Half of the processes take files from the front, the others from the end: neighbours share
    # helpers, and a process compiles a helper once.
    jobs = {
        pool.submit(_compile_file, waiting.pop(-(k % 2))): (pool, -(k % 2))
        for k, pool in enumerate(pools[:n_file])
    }
    try:
        while jobs:
            done, _ = wait(jobs, return_when=FIRST_COMPLETED)
            for job in done:
                pool, end = jobs.pop(job)
                there_before |= job.result()
                if waiting:
                    jobs[pool.submit(_compile_file, waiting.pop(end))] = pool, end
            if progress is not None:
                progress(n_file - len(waiting) - len(jobs), n_file)
    finally:
        for pool in pools:
            pool.shutdown(wait=not jobs, cancel_futures=True)
        if jobs:  # an error must not wait for the other jobs
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
    return there_before


def n_processes() -> int:
    """Number of cores that this process may use."""
    cores = getattr(os, "sched_getaffinity", None)
    return len(cores(0)) if cores else os.cpu_count() or 1


def _begin_worker() -> None:
    """Let a worker end with its parent, whatever ends that one: nobody else would end it."""
    # Ctrl-C reaches the whole group: workers end without a traceback each.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent.sentinel,), daemon=True).start()
    gc.disable()  # numba makes millions of small objects; collecting them takes a tenth of it all


def _end_after(parent: int) -> None:
    """Wait for the end of the parent, which closes its end of a pipe; cached files stay whole."""
    multiprocessing.connection.wait([parent])
    os.kill(os.getpid(), signal.SIGTERM)


def _compile_file(name: str) -> dict[str, bool]:
    module = import_module(name).__name__
    return {
        kernel.name: kernel.compile()
        # Importing a file imports others; only its own entries are compiled in this job.
        for kernel in jit.ENTRIES.values()
        if kernel.python.__module__ == module
    }
