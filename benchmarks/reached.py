"""Targets, measured: our figure, the other one, the ratio, met or not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from benchmarks.installed import installed
from benchmarks.jobs import Job
from benchmarks.measure import Measuring
from benchmarks.stats import exponent, seconds_text
from benchmarks.targets import UNSCALED, Target, select

Row = dict[str, Any]


def target_table(
    run: Measuring, scale: float = 1.0, names: Sequence[str] | None = None
) -> dict[str, Any]:
    """
    Measure the targets.

    Parameters
    ----------
    run : Measuring
    scale : float
        Factor on all sizes; the ratios asked for hold for 1.
    names : sequence of str, optional
        Of `TARGETS`. Default: all.

    Returns
    -------
    dict
        ``"rows"``: ``"ours"`` and ``"theirs"`` in words, ``"ratio"``, ``"asked"``, ``"met"``
        (None where nothing is asked or measured), ``"why"`` if there is no ratio.

    Raises
    ------
    InputError
        For an unknown name.
    """
    rows = [_measure(run, target, scale) for target in select(names)]
    notes = [] if scale == 1.0 else [f"Sizes are scaled by {scale:g}; the names say full sizes."]
    return {"rows": rows, "scale": scale, "notes": notes}


def _measure(run: Measuring, target: Target, scale: float) -> Row:
    task, scene, size = target.ours
    as_it_is = target.name in UNSCALED or target.kind == "start"
    scaled = size if as_it_is else max(float(f"{size * scale:.3g}"), 100.0)
    job = run.job(task, scene, scaled)
    row = {"name": target.name, "what": target.what, "asked": target.asked, "kind": target.kind,
           "ours": "", "theirs": "", "ratio": None, "met": None, "why": ""}  # fmt: skip
    row |= _HOW[target.kind](run, target, job)
    if row["ratio"] is not None and target.asked is not None and scale == 1.0:
        at_least = target.kind == "faster"
        met = row["ratio"] >= target.asked if at_least else row["ratio"] <= target.asked
        row["met"] = bool(met)
    if target.within is not None and scale == 1.0 and row.get("measured"):
        of = f" for {target.part}" if target.part else ""
        row["asked"] = f"{seconds_text(target.within)} at most{of}"
        ours = row["measured"][0]
        if not ours["error"]:
            took = ours["answer"]["cpu_seconds_of_parts"][target.part] if of else ours["seconds"]
            row["met"] = bool(took <= target.within)
    return row


def _pair(run: Measuring, target: Target, job: Job) -> tuple[Row, Row, Row]:
    """Rows of us and of them, and what both amount to in words."""
    peer, task, does = target.theirs
    ours, theirs = run.rows([job, run.job(task, job.scene, job.size, peer)])
    name = f"{peer}: {does}" if peer else does
    found: Row = {"ours": figure(ours), "theirs": figure(theirs), "peer": name,
                  "measured": [ours, theirs], "why": ours["error"] or theirs["error"]}  # fmt: skip
    if ours["wrong"] or theirs["wrong"]:
        found["why"] = f"wrong: {'; '.join([*ours['wrong'], *theirs['wrong']])}"
    return ours, theirs, found


def figure(row: Row) -> str:
    """Return a time with its spread in words.

    Examples
    --------
    >>> figure({"error": "", "seconds": 0.02, "fastest": 0.019, "slowest": 0.031, "repeats": 5})
    '20 ms (19 ms to 31 ms, 5 times)'
    """
    if row["error"]:
        return ""
    low, high = seconds_text(row["fastest"]), seconds_text(row["slowest"])
    times = f"{row['repeats']} times" if row["repeats"] > 1 else "once"
    spread = f"{low} to {high}, {times}" if row["repeats"] > 1 else times
    return f"{seconds_text(row['seconds'])} ({spread})"


def _faster(run: Measuring, target: Target, job: Job) -> Row:
    ours, theirs, found = _pair(run, target, job)
    if not (ours["error"] or theirs["error"] or ours["wrong"]):
        found["ratio"] = theirs["seconds"] / ours["seconds"]
    return found


def _start(run: Measuring, target: Target, job: Job) -> Row:
    """An installed wheel, or the sources where there is none: the words say which."""
    found = installed()
    options = {"site": found.site} | ({"first": True} if target.name.startswith("first") else {})
    job = run.job(job.task, job.scene, job.size, **options)
    timed = _faster if target.theirs[1] else _alone
    return timed(run, target, job) | {"what": f"{target.what} ({found.words})"}


def _slower(run: Measuring, target: Target, job: Job) -> Row:
    ours, theirs, found = _pair(run, target, job)
    if not (ours["error"] or theirs["error"] or ours["wrong"]):
        found["ratio"] = ours["seconds"] / theirs["seconds"]
    return found


def _alone(run: Measuring, target: Target, job: Job) -> Row:
    """Our time, and where processor time went if the task says so."""
    [ours] = run.rows([job])
    parts = ours.get("answer", {}).get("cpu_seconds_of_parts", {})
    words = ", ".join(f"{name} {seconds_text(value)}" for name, value in parts.items())
    why = "; ".join(filter(None, [ours["error"], *ours["wrong"]]))
    found: Row = {"ours": figure(ours), "measured": [ours], "why": why}
    return found | ({"theirs": words, "peer": "processor time of its parts"} if words else {})


def _per_edge(run: Measuring, target: Target, job: Job) -> Row:
    ours, _, found = _pair(run, target, job)
    if not (ours["error"] or ours["wrong"]):
        found["ratio"] = 1e6 * ours["seconds"] / ours["answer"]["edges"]
    return found


def _memory(run: Measuring, target: Target, job: Job) -> Row:
    """What is resident at most, over what the call started from: grids that a user has anyway."""
    [ours] = run.rows([job])
    found: Row = {
        "measured": [ours],
        "why": "; ".join(filter(None, [ours["error"], *ours["wrong"]])),
    }
    if not ours["error"]:
        inputs, extra = ours["input_bytes"], ours["extra_bytes"]
        found["ours"] = f"{inputs / 1e6:.0f} MB of grids, {extra / 1e6:.0f} MB more at the peak"
        found["ratio"] = (inputs + extra) / inputs
    return found


def _exponent(run: Measuring, target: Target, job: Job) -> Row:
    sizes = [job.size / 100.0, job.size / 10.0, job.size]
    rows = run.rows([run.job(job.task, job.scene, size) for size in sizes])
    times = ", ".join(seconds_text(row["seconds"]) for row in rows if not row["error"])
    errors = "; ".join(row["error"] for row in rows if row["error"])
    found: Row = {"ours": times, "measured": rows, "why": errors}
    if not found["why"]:
        sizes, costs = ([row[key] for row in rows] for key in ("triangles", "seconds"))
        found["ratio"] = exponent(sizes, costs)
    return found


_HOW: dict[str, Callable[[Measuring, Target, Job], Row]] = {
    "faster": _faster,
    "slower": _slower,
    "per edge": _per_edge,
    "alone": _alone,
    "exponent": _exponent,
    "memory": _memory,
    "start": _start,
}
