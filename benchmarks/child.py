"""The process that measures: orders on stdin, one line of JSON for each on stdout.

Anything that goes wrong ends the process; whoever started it reads the last line of stderr.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import resource
import sys
import time
from pathlib import Path
from typing import Any

from benchmarks.peers import find_peer
from benchmarks.scenes import Setting, make_setting
from benchmarks.tasks import TASKS, Task
from geosurf.conventions import did_you_mean
from geosurf.errors import InputError

WARM_SIZE = 2000.0
ENOUGH_SECONDS = 0.4  # quick calls are repeated until so much time went into them,
MOST = 5  # but not more than so many times as often as asked for


def find_task(peer: str, name: str) -> Task:
    """Return a timed call of geosurf (no peer) or of a peer, or say which there are.

    Examples
    --------
    >>> find_task("", "curve") is TASKS["curve"]
    True
    """
    known = find_peer(peer).tasks if peer else TASKS
    if name not in known:
        raise InputError(
            f"{peer or 'geosurf'} has no task {name!r}; there are {list(known)}."
            f"{did_you_mean(name, known)}"
        )
    return known[name]


def measure(order: dict[str, Any]) -> dict[str, Any]:
    """
    Time one call and look at its result.

    Parameters
    ----------
    order : dict
        The fields of `benchmarks.jobs.Job`.

    Returns
    -------
    dict
        The fields of `benchmarks.jobs.Result`, but for the job.

    Examples
    --------
    >>> job = {"task": "floor", "scene": "S1", "size": 2000, "repeats": 1, "budget": 1}
    >>> found = measure(job)
    >>> found["n_triangle"], len(found["seconds"]) >= 1
    (1960, True)
    """
    task = find_task(order.get("peer", ""), order["task"])
    options = order.get("options", {})
    if order.get("warm", True):
        small = "S1" if order["scene"] == "drogon" else order["scene"]
        _once(task, make_setting(small, min(WARM_SIZE, order["size"])), options)
    setting = make_setting(order["scene"], order["size"])
    seconds, processor, prepared, memory = [], [], [], {}
    while not _enough(seconds, prepared, order["repeats"], order["budget"]):
        result = None  # the last one is gone before the next is made
        gc.collect()  # it empties the processor's caches, too: each repeat begins cold
        start = time.perf_counter()
        fresh = task.fresh(setting, options)
        prepared.append(time.perf_counter() - start)
        # once: a call that finds no page of its own is slower by up to a half
        before = 0 if memory else _reset_peak()
        start, busy = time.perf_counter(), _cpu_seconds()
        result = task.run(fresh, options)
        seconds.append(time.perf_counter() - start)
        processor.append(_cpu_seconds() - busy)
        if not memory:
            peak = _peak()
            memory = {"peak_bytes": peak, "extra_bytes": max(peak - before, 0)}
    return {
        "seconds": seconds,
        "cpu_seconds": processor,
        "fresh_seconds": prepared,
        "input_bytes": _input_bytes(setting),
        "n_triangle": _count(setting),
        "answer": task.answer(setting, result),
        **memory,
    }


def _once(task: Task, setting: Setting, options: dict[str, Any]) -> None:
    """Load what is loaded at the first call: kernels, libraries."""
    task.answer(setting, task.run(task.fresh(setting, options), options))


def _enough(seconds: list[float], prepared: list[float], repeats: int, budget: float) -> bool:
    if not seconds:
        return False
    if sum(seconds) + sum(prepared) >= budget:
        return True
    return len(seconds) >= repeats and (
        sum(seconds) >= ENOUGH_SECONDS or len(seconds) >= MOST * repeats
    )


def _cpu_seconds() -> float:
    """Time that the processor spent on this process and those that it has run."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def _count(setting: Setting) -> int:
    total = 0
    for _, _, value in setting.sources:
        if isinstance(value, tuple):
            total += len(value[1])
        else:
            grid = value["elevation"] if hasattr(value, "data_vars") else value
            total += 2 * (grid.shape[0] - 1) * (grid.shape[1] - 1)
    return total


def _input_bytes(setting: Setting) -> int:
    """Of what the call started from: vertices and triangles for a peer, else grids."""
    meshes = setting.truth.get("meshes")
    if meshes is None:
        return setting.input_bytes
    return sum(array.nbytes for mesh in meshes for array in mesh)


# ---- memory ----------------------------------------------------------------------------


def _status(key: str) -> int:
    """A size from /proc/self/status in bytes; 0 where there is none."""
    path = Path("/proc/self/status")
    if path.exists():
        for line in path.read_text().splitlines():
            if line.startswith(key):
                return 1024 * int(line.split()[1])
    return 0


def _reset_peak() -> int:
    """Forget the peak of resident memory where the system can, and return what is resident."""
    give_back = getattr(ctypes.CDLL(None), "malloc_trim", None) if os.name == "posix" else None
    if give_back is not None:
        give_back(0)  # what was freed must not serve the next call unseen
    path = Path("/proc/self/clear_refs")
    if path.exists() and os.access(path, os.W_OK):
        path.write_text("5")
    return _status("VmRSS") or _maximum()


def _peak() -> int:
    """Peak of resident memory. On Linux `getrusage` starts from the parent's, so not from it."""
    return _status("VmHWM") or _maximum()


def _maximum() -> int:
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


if __name__ == "__main__":
    # libraries that print must not get between the results
    results = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    for line in sys.stdin:
        order = json.loads(line)
        if order.get("core") is not None and hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {order["core"]})
        results.write(json.dumps(measure(order)) + "\n")
        results.flush()
