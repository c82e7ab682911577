"""``python -m benchmarks``: run time against error, size and targets, next to other packages.

===========  ===============================================================
scenes       what is measured, by name and size
tasks        the timed calls of geosurf; starts: those of whole processes
peers        the same of other packages
jobs, child  one measurement in a process of its own, pinned to one core
judge        whether a timed answer is right; truth, distance: how that is known
installed    a wheel of these sources, for how long it takes to start
measure      runs jobs for the tables
tables       the three tables;  targets: the table of targets
plots, page  pictures, one page
===========  ===============================================================
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.jobs import Job, default_core, machine
from benchmarks.measure import Measuring
from benchmarks.page import TITLES, machine_lines, tables_of, text_table, write_page
from benchmarks.plots import draw_errors, draw_growth, draw_questions
from benchmarks.reached import target_table
from benchmarks.tables import JOBS, LAYOUT, decades
from benchmarks.targets import FULL_SIZE, select
from geosurf.conventions import did_you_mean
from geosurf.errors import InputError, OutputError
from geosurf.files import write_whole

SIZE = 2e6
SMALLEST = 2e4
QUICK_SIZE = 4e3
_DRAW = {"error": draw_errors, "growth": draw_growth, "questions": draw_questions}


def run_bench(
    tables: Sequence[str] | None = None,
    *,
    size: float | None = None,
    quick: bool = False,
    targets: Sequence[str] | None = None,
    core: int | None = None,
    progress: Callable[[str], object] | None = None,
) -> dict[str, Any]:
    """
    Measure geosurf, and other packages that are installed.

    Parameters
    ----------
    tables : sequence of str, optional
        Of ``"error"``, ``"growth"``, ``"questions"`` and ``"targets"``. Default: the first three.
    size : float, optional
        Largest number of triangles. Default: 2e6; targets have their full sizes, up to 2e7.
    quick : bool
        Tiny sizes, few repeats: to see that it runs, not to measure.
    targets : sequence of str, optional
        Only these rows of the table of targets.
    core : int, optional
        Core to measure on. Default: the last one.
    progress : callable, optional
        Takes lines of text.

    Returns
    -------
    dict
        ``"machine"``, ``"settings"``, ``"tables"``, and ``"wrong"``: what geosurf itself answered
        wrongly. `write_bench` writes it.

    Raises
    ------
    InputError
        For an unknown table or target, a core that is not there, or a size below 1000.
    """
    names = _checked(tables, targets, size, core)
    run = Measuring(core=default_core() if core is None else core, say=progress or (lambda _: None))
    if quick:
        run.repeats, run.budget, run.limit, run.warm = 1, 0.0, 120.0, False
    found: dict[str, Any] = {
        "machine": machine(),
        "settings": {"core": run.core, "repeats": run.repeats, "budget": run.budget,
                     "limit": run.limit, "quick": quick, "size": size},
        "tables": {},
    }  # fmt: skip
    for line in machine_lines(found["machine"], found["settings"]):
        run.say(line)
    if quick:
        run.prefetch([job for name in names for job in _jobs(run, name, size, quick)])
    for name in names:
        run.say(f"\n{TITLES[name]}")
        found["tables"][name] = _one_table(run, name, size, quick, targets)
    found["wrong"] = run.wrong
    return found


def _jobs(run: Measuring, name: str, size: float | None, quick: bool) -> list[Job]:
    """What one of the three tables measures; nothing for the targets, which go one by one."""
    largest = size or (QUICK_SIZE if quick else SIZE)
    count = 2 if quick else max(round(2 * math.log10(largest / SMALLEST)), 1) + 1
    sizes = decades(largest, count)
    if name == "questions":
        sizes = sizes[-1:] if quick else [sizes[-1] / 10.0, sizes[-1]]
    return JOBS[name](run, sizes) if name in JOBS else []


def _one_table(
    run: Measuring, name: str, size: float | None, quick: bool, targets: Sequence[str] | None
) -> dict[str, Any]:
    if name == "targets":
        largest = size or (QUICK_SIZE if quick else FULL_SIZE)
        return target_table(run, largest / FULL_SIZE, targets)
    return LAYOUT[name](run.rows(_jobs(run, name, size, quick)))


def _checked(
    tables: Sequence[str] | None,
    targets: Sequence[str] | None,
    size: float | None,
    core: int | None,
) -> list[str]:
    """Names of tables in their order, after a look at everything else."""
    select(targets)
    for name in tables or ():
        if name not in TITLES:
            raise InputError(
                f"no table is called {name!r}; there are {list(TITLES)}."
                f"{did_you_mean(name, TITLES)}"
            )
    if size is not None and not 1000 <= size <= 1e8:
        raise InputError(f"size is {size:g} triangles, expected 1000 to 1e8. Give 2e6.")
    if core is not None and hasattr(os, "sched_getaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        if core not in cores:
            raise InputError(f"core {core} is not there; choose one of {cores}.")
    wanted = list(tables or ()) + (["targets"] if targets else [])
    return [name for name in TITLES if name in (wanted or list(_DRAW))]


def write_bench(found: dict[str, Any], folder: str | os.PathLike[str]) -> list[Path]:
    """
    Write what was measured: JSON, pictures, tables as text, and one page with everything.

    Parameters
    ----------
    found : dict
        From `run_bench`.
    folder : path-like
        Created if need be.

    Returns
    -------
    list of Path
        The page is the last one.

    Raises
    ------
    OutputError
        If a file cannot be written.
    """
    folder = Path(folder)
    written = []
    for name, table in found["tables"].items():
        if name in _DRAW:
            written.append(_DRAW[name](table, folder / f"bench_{name}.png"))
    texts = {"bench.json": json.dumps(found, indent=1, default=float) + "\n"}
    texts["bench.html"] = write_page(found, folder)
    for name, text in texts.items():
        try:
            folder.mkdir(parents=True, exist_ok=True)
            write_whole(folder / name, text.encode("utf-8"))
        except OSError as error:
            raise OutputError(
                f"{folder / name}: cannot be written ({error}). Choose another -o."
            ) from error
        written.append(folder / name)
    return written


def bench_text(found: dict[str, Any]) -> str:
    """Return all tables as plain text."""
    parts = []
    for name, table in found["tables"].items():
        notes = "".join(f"\n{note}" for note in table["notes"])
        parts.append("\n".join([TITLES[name], *text_table(tables_of(name, table))]) + notes)
    return "\n\n".join(parts)
