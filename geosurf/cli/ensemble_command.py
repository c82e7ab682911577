"""The command ``ensemble``: P90, P50 and P10 of volumes and fluids in place of a scenario."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from geosurf.cli.console import Answer
from geosurf.conventions.machine import missing_sentence
from geosurf.ensemble import run_ensemble
from geosurf.ensemble.results import quantile_frame, quantile_text, realisations_csv
from geosurf.files import refused_writing, write_whole
from geosurf.scenario import read_scenario
from geosurf.scenario.output import input_files

EVERY = 30.0  # s between two lines of progress in a log file


def ensemble_command(options: argparse.Namespace) -> Answer:
    """Build many realisations of a scenario, and write quantiles of volumes."""
    out, start = Path(options.out), time.perf_counter()
    scenario = read_scenario(options.scenario, options.set)  # before a folder is made
    watched = sys.stderr is None or sys.stderr.isatty()
    with refused_writing(f"{out}: results", out, "Choose another folder."):
        out.mkdir(parents=True, exist_ok=True)
    ensemble = run_ensemble(
        scenario,
        options.n,
        seed=options.seed,
        store=out / "ensemble.zarr",
        cache_dir=options.cache_dir,
        workers=options.workers,
        processes=options.processes,
        progress=not (options.quiet or options.json) and (watched or _Log()),
    )
    include, parts = scenario.output.include, ensemble.parts
    groups: dict[str, tuple[str, ...]] = {
        "total": (), "region": ("region", parts), "zone": ("zone", parts), "unit": ("unit",)
    }  # fmt: skip
    tables = {by: quantile_frame(ensemble, keys, include) for by, keys in groups.items()}
    for by, table in tables.items():
        text = table.to_csv(index=False, na_rep="nan", lineterminator="\n")
        write_whole(out / f"quantiles_{by}.csv", text.encode("utf-8"))
    each = realisations_csv(ensemble, include)
    write_whole(out / "realisations.csv", each.encode("utf-8"))
    # clusters have no matplotlib; the report can be written elsewhere, from the store
    missing, page = missing_sentence("charts need", "matplotlib"), None
    if not missing:
        page = ensemble.report(
            out,
            title=scenario.heading,
            inputs=input_files(scenario),
            relative_to=scenario.path.parent,
            include=include,
        )
    seconds, count = time.perf_counter() - start, ensemble.data.sizes["realisation"]
    data = {
        "scenario": scenario.path,
        "settings": scenario.settings,
        "out": out,
        "realisations": count,
        "seconds": seconds,
        "report": page,
        "quantiles": {by: table.to_dict("records") for by, table in tables.items()},
    }
    return Answer(
        data,
        f"\n{quantile_text(ensemble, include)}\n\n{count} realisations in {seconds:.1f} s.",
        closing=(
            f"There is no report: {missing}" if page is None else f"Open {page}.",
            f"Tables: {out}/quantiles_*.csv and realisations.csv",
            f"All results: {out / 'ensemble.zarr'}",
        ),
    )


class _Log:
    """Prints progress on stderr, a line every half minute: for log files."""

    def __init__(self) -> None:
        self._shown = time.monotonic()

    def __call__(self, line: str) -> None:
        """Print a line, or leave it out."""
        if time.monotonic() - self._shown > EVERY:
            self._shown = time.monotonic()
            print(line, file=sys.stderr, flush=True)
