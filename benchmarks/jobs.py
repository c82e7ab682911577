"""Measurements in processes of their own: pinned to one core, and free to crash."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from benchmarks.peers import PEERS
from benchmarks.stats import median

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Job:
    """One measurement.

    Attributes
    ----------
    task : str
        One of `benchmarks.tasks.TASKS`, or of the peer's tasks.
    scene : str
    size : float
        See `benchmarks.scenes`.
    peer : str
        Name of another package; empty for geosurf.
    options : dict
        Keywords of the call.
    repeats : int
        At least so many, unless `budget` is spent.
    budget : float
        Seconds after which no repeat begins.
    warm : bool
        Whether to run a small case first, so that kernels are loaded before the clock starts.
    """

    task: str
    scene: str
    size: float
    peer: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    repeats: int = 5
    budget: float = 20.0
    warm: bool = True


@dataclass
class Result:
    """What a measurement came to; times in seconds, sizes in bytes.

    Attributes
    ----------
    job : Job
    seconds : list of float
        Of each repeat, wall clock.
    cpu_seconds : list of float
        Of each repeat, time of the processor.
    fresh_seconds : list of float
        What was prepared beside the clock for each repeat.
    extra_bytes : int
        Peak of resident memory during the first repeat, beyond what was resident before it.
    peak_bytes : int
        The same peak with everything in it.
    input_bytes : int
        Size of the arrays that the call starts from.
    n_triangle : int
    answer : dict
        Length, number of segments, errors ... of what came out.
    error : str
        Why there is no result; empty if there is one.
    """

    job: Job
    seconds: list[float] = field(default_factory=list)
    fresh_seconds: list[float] = field(default_factory=list)
    cpu_seconds: list[float] = field(default_factory=list)
    extra_bytes: int = 0
    peak_bytes: int = 0
    input_bytes: int = 0
    n_triangle: int = 0
    answer: dict[str, Any] = field(default_factory=dict)
    error: str = ""

    @property
    def time(self) -> float:
        """Median of the repeats [s]."""
        return median(self.seconds) if self.seconds else float("nan")

    @property
    def spread(self) -> tuple[float, float]:
        """Fastest and slowest repeat [s]."""
        return (min(self.seconds), max(self.seconds)) if self.seconds else (float("nan"),) * 2


def default_core() -> int | None:
    """Return the last core that this process may use; None where cores cannot be chosen."""
    return max(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None


def run_jobs(jobs: Sequence[Job], *, core: int | None = None, limit: float = 600.0) -> list[Result]:
    """
    Run measurements one after the other in one process; in a new one after a crash.

    Parameters
    ----------
    jobs : sequence of Job
    core : int, optional
        Core that the process is pinned to.
    limit : float
        Seconds that one measurement may take, preparation and judging included.

    Returns
    -------
    list of Result
        One for each job; those that crashed or took too long say so in `Result.error`.
    """
    results: list[Result] = []
    while len(results) < len(jobs):
        rest = list(jobs[len(results) :])
        lines, error = _one_process(rest, core, limit)
        results += [Result(job, **json.loads(line)) for job, line in zip(rest, lines, strict=False)]
        if len(lines) < len(rest):
            results.append(Result(rest[len(lines)], error=error))
    return results


def _one_process(jobs: list[Job], core: int | None, limit: float) -> tuple[list[str], str]:
    """Lines of results, and why there are not as many as jobs."""
    checkout = Path(__file__).resolve().parents[1]
    path = os.pathsep.join(filter(None, [str(checkout), os.environ.get("PYTHONPATH")]))
    environment = os.environ | dict.fromkeys(ONE_THREAD, "1") | {"PYTHONPATH": path}
    command = [sys.executable, "-m", "benchmarks.child"]
    orders = "\n".join(json.dumps({**asdict(job), "core": core}) for job in jobs)
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        late = ""
        try:
            done = subprocess.run(
                command, input=orders.encode(), stdout=out, stderr=err, env=environment,
                timeout=limit * len(jobs), check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            late = f"over {limit * len(jobs):.0f} s"
        out.seek(0)
        err.seek(0)
        lines = [line for line in out.read().decode().splitlines() if line.startswith("{")]
        said = err.read().decode(errors="replace").strip().splitlines()
    if late:
        return lines, late
    if done.returncode < 0:
        return lines, f"crashed: signal {-done.returncode}"
    return lines, said[-1][:300] if said else f"exit code {done.returncode}"


def machine() -> dict[str, Any]:
    """Return what the figures depend on: the machine, its load, and all versions."""
    versions = {}
    for name in ("geosurf", "numpy", "numba", "llvmlite", "xarray"):
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "from sources"
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "memory_gb": _memory_gb(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": platform.python_version(),
        "versions": versions,
        "peers": {peer.name: peer.version for peer in PEERS},
        "load": list(os.getloadavg()) if hasattr(os, "getloadavg") else [],
    }


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _memory_gb() -> float:
    if not hasattr(os, "sysconf") or "SC_PHYS_PAGES" not in os.sysconf_names:
        return 0.0
    return round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9, 1)
