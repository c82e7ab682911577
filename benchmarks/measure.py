"""Runs jobs for the tables: knows what is right, remembers what gave up, says what it does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from benchmarks.jobs import Job, Result, run_jobs
from benchmarks.judge import UNITS, judge, known_truth
from benchmarks.peers import HOW_TO_INSTALL, find_peer
from benchmarks.stats import count_text, median, seconds_text


@dataclass
class Measuring:
    """
    How to measure, and what is known so far.

    Attributes
    ----------
    core : int or None
        Core that measuring processes are pinned to.
    repeats : int
    budget : float
        Seconds for the repeats of one measurement.
    limit : float
        Seconds after which a measurement is given up.
    say : callable
        Takes a line of progress.
    warm : bool
        Whether each measurement runs a small case first.
    wrong : list of str
        What geosurf itself answered wrongly, or failed at; must stay empty.
    """

    core: int | None = None
    repeats: int = 5
    budget: float = 20.0
    limit: float = 600.0
    say: Callable[[str], object] = lambda line: None
    wrong: list[str] = field(default_factory=list)
    warm: bool = True
    _truths: dict[tuple[str, float], dict[str, Any]] = field(default_factory=dict)
    _gave_up: dict[tuple[str, str, str], float] = field(default_factory=dict)
    _known: dict[str, Result] = field(default_factory=dict)
    _said: set[str] = field(default_factory=set)

    def job(self, task: str, scene: str, size: float, peer: str = "", **options: Any) -> Job:
        """Return a job with this run's repeats and budget."""
        return Job(task, scene, size, peer, options, self.repeats, self.budget, self.warm)

    def rows(self, jobs: Sequence[Job]) -> list[dict[str, Any]]:
        """
        Measure, judge, and return one row for each job.

        Parameters
        ----------
        jobs : sequence of Job

        Returns
        -------
        list of dict
            The job, its times and sizes, its answer; ``"wrong"`` has what is wrong with it,
            ``"error"`` why there is no answer.
        """
        return [self._row(job) for job in jobs]

    def prefetch(self, jobs: Sequence[Job]) -> None:
        """Measure jobs in one process for geosurf and one for each peer: quick, less clean.

        Parameters
        ----------
        jobs : sequence of Job
            `rows` finds their results.
        """
        scenes = dict.fromkeys((job.scene, job.size) for job in jobs)
        truths = [known_truth(*scene) for scene in scenes]
        jobs = [*jobs, *(found for found in truths if isinstance(found, Job))]
        for peer in dict.fromkeys(job.peer for job in jobs):
            self._run([job for job in jobs if job.peer == peer])

    def _row(self, job: Job) -> dict[str, Any]:
        [result] = self._run([job])
        truth = self.truth(job.scene, job.size) if self._is_judged(job, result) else {}
        if job.task == "one curve":
            truth = truth.get("first", {})
        if job.scene in UNITS:
            truth = truth | {"units": UNITS[job.scene]}
        wrong = judge(result, truth)
        who = job.peer or "geosurf"
        what = f"{job.scene} {count_text(job.size)}: {job.task}"
        if not job.peer and (wrong or result.error):
            found = f"{what}: {'; '.join(wrong) or result.error}"
            self.wrong += [found] if found not in self.wrong else []
        if repr(job) not in self._said:
            self._said.add(repr(job))
            verdict = f"   WRONG: {'; '.join(wrong)}" if wrong else ""
            self.say(f"{who:<12} {what:<44} {result.error or seconds_text(result.time)}{verdict}")
        return _as_row(result, wrong)

    def _is_judged(self, job: Job, result: Result) -> bool:
        return "length" in result.answer and not job.options.get("tolerance")

    def _run(self, jobs: Sequence[Job]) -> list[Result]:
        """Results of jobs, from memory where the same was measured in this run."""
        todo = []
        for job in jobs:
            if repr(job) in self._known:
                continue
            reason = self._reason_to_skip(job)
            if reason:
                self._known[repr(job)] = Result(job, error=reason)
            else:
                todo.append(job)
        for job, result in zip(todo, run_jobs(todo, core=self.core, limit=self.limit), strict=True):
            self._known[repr(job)] = result
            if result.error:
                key = (job.peer, job.task, job.scene)
                self._gave_up[key] = min(job.size, self._gave_up.get(key, job.size))
        return [self._known[repr(job)] for job in jobs]

    def _reason_to_skip(self, job: Job) -> str:
        if not job.peer:
            return ""
        peer = find_peer(job.peer)
        if not peer.available:
            return HOW_TO_INSTALL
        if job.size > peer.most:
            return f"not asked beyond {count_text(peer.most)} triangles"
        gave_up = self._gave_up.get((job.peer, job.task, job.scene))
        if gave_up is not None and job.size > gave_up:
            return f"gave up at {count_text(gave_up)}"
        return ""

    def truth(self, scene: str, size: float) -> dict[str, Any]:
        """Return length and number of segments of a scene's curves; empty where nobody knows."""
        key = (scene, size)
        if key not in self._truths:
            found = known_truth(scene, size)
            if isinstance(found, Job):
                [result] = self._run([found])
                found = result.answer
                if result.error:
                    self.wrong.append(f"{scene} {count_text(size)}: no truth: {result.error}")
            self._truths[key] = found
        return self._truths[key]


def _as_row(result: Result, wrong: list[str]) -> dict[str, Any]:
    """A result as plain data, for tables and files."""
    job, (low, high) = result.job, result.spread
    row: dict[str, Any] = {
        "who": job.peer or "geosurf",
        "task": job.task,
        "scene": job.scene,
        "size": job.size,
        "options": job.options,
        "error": result.error,
        "wrong": wrong,
    }
    if result.error:
        return row
    return row | {
        "triangles": result.n_triangle,
        "seconds": result.time,
        "fastest": low,
        "slowest": high,
        "cpu_seconds": median(result.cpu_seconds or result.seconds),
        "repeats": len(result.seconds),
        "prepared_seconds": min(result.fresh_seconds),
        "extra_bytes": result.extra_bytes,
        "peak_bytes": result.peak_bytes,
        "input_bytes": result.input_bytes,
        "answer": result.answer,
    }
