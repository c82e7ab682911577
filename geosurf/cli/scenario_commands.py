"""The commands ``run``, ``check``, ``render`` and ``report``: everything made from a scenario."""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.cli.results import exit_code_of, progress_printer
from geosurf.errors import InputError

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.scenario.keys import Scenario


VIEW, SHOW = "southwest", "horizons,faults,curves"


def run_command(options: argparse.Namespace) -> int:
    """Run a scenario and write everything."""
    from geosurf.report.table import as_plain_text
    from geosurf.report.tables import volume_table
    from geosurf.scenario import read_scenario, run

    # time counts from here: reading is part of the run
    report_progress = progress_printer(options.quiet)
    start = time.perf_counter()
    scenario = _merging(read_scenario(options.scenario), options)
    outcome = run(
        scenario,
        options.out,
        pictures=not options.no_pictures,
        progress=report_progress,
        cache_dir=options.cache_dir,
    )

    # notes go to stderr, so that a script can read the table from stdout
    for note in outcome.notes:
        print(f"geosurf: {note}", file=sys.stderr)

    # the table is for people; files hold the same numbers
    if not options.quiet:
        table = volume_table(outcome.scene.units)
        print(f"\n{as_plain_text(table, 'Volumes [million m³]')}\n")
        units = outcome.scene.units
        print(f"{len(units)} units in {time.perf_counter() - start:.1f} s.")
        if units.slivers:
            print(f"{units.slivers_in_words}. To merge them: --merge-slivers.")
        elif units.merged:
            print(f"{units.merged_in_words}; certificate.txt lists them.")
        print(f"Report: {outcome.out / 'report' / 'index.html'}; all other results: {outcome.out}")
    return exit_code_of(outcome.certificate)


def _merging(scenario: Scenario, options: argparse.Namespace) -> Scenario:
    """Return the scenario; with ``--merge-slivers`` it merges them."""
    if not options.merge_slivers:
        return scenario
    return replace(scenario, slivers=replace(scenario.slivers, merge=True))


def validate_command(options: argparse.Namespace) -> int:
    """Print all mistakes of a scenario; nothing is read or built."""
    from geosurf.conventions import counted
    from geosurf.scenario import read_scenario
    from geosurf.scenario.mistakes import find_mistakes

    mistakes = find_mistakes(options.scenario)
    if options.json:
        rows = [{"line": one.line, "mistake": one.sentence} for one in mistakes]
        print(json.dumps({"scenario": options.scenario, "mistakes": rows}, indent=2))
        return 2 if mistakes else 0
    for one in mistakes:
        where = "" if one.line is None else f", line {one.line}"
        print(f"{options.scenario}{where}: {one.sentence}")
    if mistakes:
        print(f"{counted(len(mistakes), 'mistake')}.", file=sys.stderr)
        return 2
    scenario = read_scenario(options.scenario)
    n_horizon, n_fault = len(scenario.horizons), len(scenario.faults)
    print(f"No mistakes: {counted(n_horizon, 'horizon')}, {counted(n_fault, 'fault')}.")
    print(f"Next: geosurf run {options.scenario} -o out")
    return 0


def check_command(options: argparse.Namespace) -> int:
    """Print the certificate of a scenario."""
    from geosurf.scenario import build_scene, read_scenario

    certificate = build_scene(_merging(read_scenario(options.scenario), options)).check()
    print(certificate)
    return exit_code_of(certificate)


def render_command(options: argparse.Namespace) -> int:
    """Draw one picture of a scenario."""
    from geosurf.render.compose import png_path
    from geosurf.scenario import read_scenario

    scenario = read_scenario(options.scenario)
    png_path(options.out)  # refuse a wrong suffix before the computation
    draw = _draw_view if options.section is None else _draw_section
    print(draw(scenario, options))
    return 0


def _draw_view(scenario: Scenario, options: argparse.Namespace) -> Path:
    """Draw a view in space; options that are not given are those of the scenario."""
    from geosurf.render import render_scene
    from geosurf.scenario import build_scene

    def given(option: Any, otherwise: Any) -> Any:
        """Return an option, or its default if it is not given."""
        return otherwise if option is None else option

    # an option wins over the scenario, the scenario over the default
    return render_scene(
        build_scene(scenario),
        options.out,
        view=given(options.view, VIEW),
        show=tuple(word.strip() for word in given(options.show, SHOW).split(",")),
        size=scenario.output.size_px,
        exaggeration=given(options.exaggeration, scenario.output.exaggeration),
        clip=given(options.clip, scenario.output.clip),
    )


def _draw_section(scenario: Scenario, options: argparse.Namespace) -> Path:
    """Draw a vertical section; refuse options of views, which would have no effect."""
    from geosurf.render import render_section
    from geosurf.scenario import build_scene

    # None means "not given": argparse has no other way to tell it from a default
    for word in ("view", "show", "exaggeration", "clip"):
        if getattr(options, word) is not None:
            raise InputError(
                f"--section and --{word} cannot be combined: --{word} applies to views "
                "only. Leave one of them out."
            )

    # the line is checked before the model is built
    line = _line_of(options.section)
    section = build_scene(scenario).section(line)
    return render_section(section, options.out, size=scenario.output.size_px)


def _line_of(text: str) -> list[tuple[float, float]]:
    """Return the points of a line in the map from a text such as ``0,2500 6000,2500``."""
    line = []

    # points are separated by blanks, so that numbers keep their decimal points
    for word in text.split():
        try:
            east, north = map(float, word.split(","))
        except ValueError as error:
            raise InputError(
                f"--section: {word!r} is not a point. Give easting and northing [m] of two or "
                'more points in quotes, as in "0,2500 6000,2500".'
            ) from error
        line.append((east, north))
    return line


def report_command(options: argparse.Namespace) -> int:
    """Write the report of a scenario."""
    from geosurf.scenario import read_scenario
    from geosurf.scenario.execute import write_report

    scenario = _merging(read_scenario(options.scenario), options)
    certificate, path, notes = write_report(
        scenario,
        options.out,
        pictures=not options.no_pictures,
        progress=progress_printer(options.quiet),
        cache_dir=options.cache_dir,
    )
    for note in notes:
        print(f"geosurf: {note}", file=sys.stderr)
    print(path)
    return exit_code_of(certificate)
