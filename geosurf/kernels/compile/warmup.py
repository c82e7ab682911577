"""Compile all kernels ahead of time: ``geosurf warmup``.

numba holds one lock while it compiles, so threads do not help; two processes with one cache do. A
file is compiled by one process, those with the largest imports first.
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
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib import import_module

from geosurf.errors import OutputError
from geosurf.kernels.compile import jit
from geosurf.kernels.compile.sources import ROOT, kernel_files, module_of

N_PROCESS = 2
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
    from geosurf.kernels.compile.numba_runner import closure, kernel_folder

    obstacle = jit.RUNNER.obstacle()
    if obstacle:
        raise OutputError(f"Compiled kernels could not be reused. {obstacle}")
    start = time.perf_counter()
    files = {module_of(path): path for path in kernel_files(ROOT)}
    # Files with the largest imports take longest and go first: both processes end together.
    weight = {name: -sum(p.stat().st_size for p in closure(files[name])) for name in files}
    found = _compile_all(sorted(weight, key=weight.__getitem__), progress)
    n_loaded = sum(found.values())
    n_new = len(found) - n_loaded
    done = f"{n_new} kernels compiled in {time.perf_counter() - start:.0f} s"
    return f"{done}, {n_loaded} were compiled before; cached in {kernel_folder()}."


def warm_library() -> str:
    """
    Compile all kernels into one library in the cache, as a wheel has it.

    Returns
    -------
    str
        One sentence: what was done, or why there is nothing to do.

    Raises
    ------
    DependencyError
        If there is no C compiler.
    OutputError
        If the library cannot be saved.
    """
    if not jit.RUNNER.compiles:
        return f"Nothing to compile: {jit.RUNNER.describe()}"
    from geosurf.kernels.compile.own_library import freeze_into_cache

    return freeze_into_cache()


def _compile_all(names: list[str], progress: Progress | None) -> dict[str, bool]:
    """Whether each kernel was there already; files are shared out among processes."""
    found: dict[str, bool] = {}
    # Workers of somebody else, a notebook for example, are left alone.
    others = set(multiprocessing.active_children())
    spawn = multiprocessing.get_context("spawn")  # a fork would take over threads and their locks
    with ProcessPoolExecutor(N_PROCESS, spawn, _begin_worker) as pool:
        jobs = [pool.submit(_compile_file, name) for name in names]
        try:
            # As they end: an error shows at once.
            for n_done, job in enumerate(as_completed(jobs), start=1):
                found |= job.result()
                if progress is not None:
                    progress(n_done, len(jobs))
        finally:
            if not all(job.done() for job in jobs):  # an error must not wait for the other jobs
                pool.shutdown(wait=False, cancel_futures=True)
                for worker in set(multiprocessing.active_children()) - others:
                    worker.terminate()
    return found


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
