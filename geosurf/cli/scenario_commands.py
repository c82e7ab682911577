"""The commands ``run``, ``validate`` and ``check`` of a scenario."""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from collections.abc import Iterable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from geosurf.cli.console import Answer, step_lines
from geosurf.cli.parser import FILES
from geosurf.conventions import counted
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model import Certificate, Units
from geosurf.model.units import left_out
from geosurf.report.page import as_plain_text
from geosurf.report.tables import volume_table
from geosurf.scenario import read_scenario, run
from geosurf.scenario.execute import Outcome, compute, will_draw
from geosurf.scenario.keys import Scenario
from geosurf.scenario.output import input_files, output_files
from geosurf.scenario.step_log import StepLog
from geosurf.scenario.validate import find_mistakes
from geosurf.scene import Scene
from geosurf.scene.result_cache import cache_in, check_with_cache

# ---- results ----------------------------------------
# What commands answer in common: units, warnings, and the verdict of a certificate.


CHECK_FAILED = 3  # exit code


def exit_code_of(certificate: Certificate) -> int:
    """Return the exit code of a certificate; print the checks that failed."""
    # the code of geometry: the model was built, and the check says that it must not be used
    failed = [f"{check.name} ({check.detail})" for check in certificate.checks if not check.passed]
    if not failed:
        return 0
    print(
        f"geosurf: the model fails its check: {'; '.join(failed)}. Inspect these places "
        "before you use the model.",
        file=sys.stderr,
    )
    return CHECK_FAILED


def units_data(units: Units, include: str) -> list[dict[str, Any]]:
    """Return one dict per unit that tables show, with the columns of the table of volumes."""
    table = units.included(include).table
    columns = ["unit", *map(str, table.data_vars), *(str(k) for k in table.coords if k != "unit")]
    values = (table[key].values.tolist() for key in columns)
    return [dict(zip(columns, row, strict=True)) for row in zip(*values, strict=True)]


def warnings_data(warnings: Iterable[GeosurfWarning]) -> list[dict[str, Any]]:
    """Return one dict per warning."""
    keys = ("kind", "subject", "effect", "remedy", "place")
    return [{key: getattr(one, key) for key in keys} for one in warnings]


def certificate_data(certificate: Certificate) -> dict[str, Any]:
    """Return the lines of a certificate and whether all of them passed."""
    return {"ok": certificate.ok, "checks": list(map(asdict, certificate.checks))}


def run_command(options: argparse.Namespace) -> Answer:
    """Run a scenario and write everything, or what ``--only`` names."""
    # time counts from here: reading is part of the run
    progress = step_lines(options, steps=True)
    start = time.perf_counter()
    scenario = _only(read_scenario(options.scenario, options.set), options.only)
    if options.dry_run:
        return _planned(scenario, options)
    outcome = run(
        scenario,
        options.out,
        pictures=_draws(options),
        report=_reports(options),
        progress=progress,
        cache_dir=options.cache_dir,
    )
    for note in outcome.notes:  # on stderr, so that a script can read the answer from stdout
        print(f"geosurf: {note}", file=sys.stderr)

    # the table is for people; files hold the same numbers
    units, seconds = outcome.scene.units, time.perf_counter() - start
    include = scenario.output.include
    table = as_plain_text(volume_table(units, include), "GRV [million m³]")
    left = left_out(units, "To list them: --set output.include=all.", include)
    notes = left, units.included(include).ends_at_box
    lines = [f"\n{table}\n", *filter(None, notes), f"{len(units)} units in {seconds:.1f} s."]
    if units.slivers:
        lines.append(f"{units.slivers_in_words}. To merge them: --set slivers.merge=true.")
    elif units.merged:
        lines.append(f"{units.merged_in_words}; certificate.txt lists them.")
    data = {
        "scenario": scenario.path,
        "settings": scenario.settings,
        "out": outcome.out,
        "report": outcome.out / "report" / "index.html" if _reports(options) else None,
        "seconds": seconds,
        "notes": outcome.notes,
        **_model_data(outcome.scene, scenario),
        "certificate": certificate_data(outcome.certificate),
    }
    code = exit_code_of(outcome.certificate)
    return Answer(data, "\n".join(lines), code, tuple(_closing(outcome, options)))


def _closing(outcome: Outcome, options: argparse.Namespace) -> Iterable[str]:
    """What to check after a run, and what to open."""
    # warnings were printed minutes ago, perhaps above the screen
    count = len(outcome.scene.warnings) + len(outcome.notes)
    if count:
        above = "1 warning or note" if count == 1 else f"{count} warnings and notes"
        yield f"Check first: {above} above; certificate.txt lists warnings, too."
    if _reports(options):
        yield f"Report: {outcome.out / 'report' / 'index.html'}; all other results: {outcome.out}"
    else:
        yield f"Results: {outcome.out}"


def _planned(scenario: Scenario, options: argparse.Namespace) -> Answer:
    """What a run would read and write."""
    draws = will_draw(scenario, _draws(options))
    read = {name: path for name, path in input_files(scenario).items() if name != "scenario"}
    written = output_files(scenario, pictures=draws, report=_reports(options))
    files = [f"  {name:<20} {path}" for name, path in read.items()]
    text = "\n".join(
        [
            f"{scenario.path}: no mistakes. A run would read",
            *files,
            f"and write into {options.out}",
            *(f"  {name}" for name in written),
            "Nothing was built or written.",
        ]
    )
    data = {"scenario": scenario.path, "settings": scenario.settings, "out": options.out}
    return Answer(data | {"reads": read, "writes": written}, text)


def _only(scenario: Scenario, only: tuple[str, ...] | None) -> Scenario:
    """Return the scenario without the files that ``--only`` does not name."""
    if only is None:
        return scenario
    if "grid" in only and scenario.grid is None:
        raise InputError(
            f"--only grid: {scenario.path} asks for no simulation grid. Add a table [grid]."
        )
    formats = tuple(word for word in FILES if word in only)
    return replace(
        scenario,
        output=replace(scenario.output, formats=formats),
        grid=scenario.grid if "grid" in only else None,
    )


def _draws(options: argparse.Namespace) -> bool | None:
    """Whether pictures are drawn; None: where they can be."""
    if options.no_pictures or (options.only is not None and "pictures" not in options.only):
        return False
    return None if options.only is None else True


def _reports(options: argparse.Namespace) -> bool:
    return options.only is None or "report" in options.only


def _model_data(scene: Scene, scenario: Scenario) -> dict[str, Any]:
    units = units_data(scene.units, scenario.output.include)
    return {"units": units, "warnings": warnings_data(scene.warnings)}


def validate_command(options: argparse.Namespace) -> Answer:
    """List all mistakes of a scenario; nothing is read or built."""
    mistakes = find_mistakes(options.scenario, options.set)
    rows = [{"line": mistake.line, "mistake": mistake.sentence} for mistake in mistakes]
    data = {"scenario": options.scenario, "settings": options.set, "mistakes": rows}
    if mistakes:
        if not (options.json or options.quiet):
            print(
                *(mistake.in_file(options.scenario) for mistake in mistakes), sep="\n", flush=True
            )
            print(f"{counted(len(mistakes), 'mistake')}.", file=sys.stderr)
        return Answer(data, code=InputError.exit_code)
    scenario = read_scenario(options.scenario, options.set)
    n_horizon, n_fault = len(scenario.horizons), len(scenario.faults)
    out = Path(options.scenario).parent / "out"
    return Answer(
        data,
        f"No mistakes: {counted(n_horizon, 'horizon')}, {counted(n_fault, 'fault')}.",
        closing=(f"Next: geosurf run {shlex.quote(str(options.scenario))} -o {out}",),
    )


def check_command(options: argparse.Namespace) -> Answer:
    """Print the certificate of a scenario."""
    scenario, cache = read_scenario(options.scenario, options.set), cache_in(options.cache_dir)
    progress = step_lines(options, steps=False)
    log = StepLog(progress)
    scene = compute(scenario, log, cache=cache)
    certificate = check_with_cache(scene, cache)
    log.step("check", "certificate", "valid" if certificate.ok else "FAILED")
    data = {"scenario": scenario.path, "settings": scenario.settings}
    data |= {"certificate": certificate_data(certificate), **_model_data(scene, scenario)}
    return Answer(data, str(certificate), exit_code_of(certificate))
