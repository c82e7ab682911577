"""The parser of the command line: all commands, their options and their help."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import geosurf
from geosurf.cli.curves_command import curves_command
from geosurf.cli.ensemble_command import ensemble_command
from geosurf.cli.info_command import info_command
from geosurf.cli.install_commands import doctor_command, warmup_command
from geosurf.cli.new_command import VARIANTS, new_command
from geosurf.cli.scenario_commands import (
    SHOW,
    VIEW,
    check_command,
    render_command,
    report_command,
    run_command,
    validate_command,
)
from geosurf.cli.stress_command import stress_command

EXIT_CODES = """exit codes: 0 done, 2 invalid input, 3 impossible geometry or a failed check,
4 a bug in geosurf, 128 + n stopped by signal n (Ctrl-C: 130)"""


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands and options.

    Returns
    -------
    argparse.ArgumentParser
    """
    # the raw formatter leaves the lines of EXIT_CODES as they are
    parser = argparse.ArgumentParser(
        prog="geosurf",
        description="Build sealed, exact and certified reservoir units from horizons and faults.",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"geosurf {geosurf.__version__}")
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    def add(name: str, run: Callable[[argparse.Namespace], int], help_: str) -> Any:
        """Add a command with the options that all commands have."""
        command = commands.add_parser(name, help=help_, description=help_)

        # `main` calls `options.run`, so no table of commands exists twice
        command.set_defaults(run=run)
        # no default here: `run` would override `geosurf --debug run`
        command.add_argument(
            "--debug",
            action="store_true",
            default=argparse.SUPPRESS,
            help="show the traceback of an error",
        )
        return command

    _add_new(add)
    _add_scenario_commands(add)
    _add_curves(add)
    info = add("info", info_command, "show what files hold and how geosurf reads them")
    info.add_argument("files", metavar="FILE", nargs="+", help="files of any format")
    info.add_argument("--json", action="store_true", help="print a list of objects in JSON")
    add("doctor", doctor_command, "check the installation")
    add("warmup", warmup_command, "pre-compile the kernels (not needed with a wheel)")
    _add_tests(add)
    return parser


def _add_scenario_commands(add: Callable[..., Any]) -> None:
    """Add the commands that take a scenario."""
    run = add("run", run_command, "build the model of a scenario: volumes, pictures and a report")
    validate = add(
        "validate", validate_command, "list all mistakes of a scenario; nothing is built"
    )
    validate.add_argument("--json", action="store_true", help="print JSON")
    validate.epilog = "example: geosurf validate field/scenario.toml"
    check = add(
        "check",
        check_command,
        "check the model of a scenario and print its certificate",
    )
    render = add("render", render_command, "draw one picture of the model of a scenario")
    report = add("report", report_command, "write the report of a scenario and its pictures")
    ensemble = add(
        "ensemble", ensemble_command, "compute P90, P50 and P10 of the volumes of a scenario"
    )
    for command in (run, validate, check, render, report, ensemble):
        command.add_argument(
            "scenario", help="scenario file (TOML); its keys are in docs/scenario.md"
        )
    for command in (run, check, report):
        command.add_argument(
            "--merge-slivers",
            action="store_true",
            help="merge units too small to count into neighbours, as [slivers] merge = true does",
        )
    _add_ensemble_options(ensemble)
    for command in (run, report):
        command.add_argument(
            "-o", "--out", required=True, help="output folder, created if it is missing"
        )
        command.add_argument("--no-pictures", action="store_true", help="do not draw pictures")
        command.add_argument("--quiet", action="store_true", help="do not print progress")
        command.add_argument(
            "--cache-dir",
            metavar="FOLDER",
            help="store torn horizons and pictures there; later runs redo only what changed",
        )

    _add_render_options(render)


def _add_render_options(render: argparse.ArgumentParser) -> None:
    """Add the options of pictures."""
    # no defaults here: `_draw_view` takes them from the scenario, and `_draw_section` refuses what
    # is given for views only
    render.add_argument("-o", "--out", required=True, help="output file (.png)")
    render.add_argument("--view", help=f"direction of view: north, top ... (default: {VIEW})")
    render.add_argument(
        "--show", help=f"what to draw, also walls, patches, units (default: {SHOW})"
    )
    render.add_argument(
        "--section",
        metavar="LINE",
        help='draw a vertical section along this line, as in "0,2500 6000,2500 ..." [m]',
    )
    render.add_argument(
        "--exaggeration",
        type=float,
        help="vertical exaggeration (default: chosen by the shape of the model)",
    )
    render.add_argument("--clip", action=argparse.BooleanOptionalAction,
                        help="draw the inside of the model only")  # fmt: skip


def _add_curves(add: Callable[..., Any]) -> None:
    """Add the command that takes two surfaces."""
    curves = add("curves", curves_command, "find the intersection lines of two surface files")
    curves.add_argument("first", help="surface file: .gri .zmap .nc .ts .vtp .pol .obj ...")
    curves.add_argument("second", help="second surface file")
    curves.add_argument("-o", "--out", required=True, help="output file (.vtp, .pl or .pol)")
    curves.add_argument(
        "--positive", choices=("up", "down"), help="direction of z, if a file does not state it"
    )
    curves.add_argument("--length-unit", help="length unit, if a file does not state it")


def _add_ensemble_options(ensemble: argparse.ArgumentParser) -> None:
    """Add the options of ensembles."""
    ensemble.add_argument(
        "-o", "--out", required=True,
        help="output folder, created if it is missing; one with a part of the same ensemble is "
        "continued",
    )  # fmt: skip
    ensemble.add_argument("-n", type=int, help="number of realisations (default: [ensemble], 100)")
    ensemble.add_argument("--seed", type=int, help="seed (default: that of [ensemble], or 0)")
    ensemble.add_argument("--workers", type=int, help="realisations at once (default: all cores)")
    ensemble.add_argument("--processes", action="store_true", help="worker processes, not threads")
    ensemble.add_argument("--quiet", action="store_true", help="print no progress and no table")


def _add_new(add: Callable[..., Any]) -> None:
    """Add the command that writes a scenario."""
    new = add("new", new_command, "write a scenario from files: horizons, faults, well tops ...")
    new.epilog = "example: geosurf new field data/*.gri data/*.pol"
    new.add_argument("folder", metavar="FOLDER", help="where scenario.toml is written")
    new.add_argument("files", metavar="FILES", nargs="*", help="files of the field, or folders")
    new.add_argument(
        "--positive", choices=("up", "down"), help="direction of z, if files do not state it"
    )
    new.add_argument("--length-unit", help="unit of z, if files do not state it (default: m)")
    new.add_argument("--replace", action="store_true", help="replace an existing scenario")
    new.add_argument(
        "--example",
        nargs="?",
        const="grids",
        choices=VARIANTS,
        help="write a synthetic field with known volumes into FOLDER, and its scenario",
    )


def _add_tests(add: Callable[..., Any]) -> None:
    """Add the commands that test geosurf."""
    stress = add(
        "stress",
        stress_command,
        "test the engine on difficult cases",
    )
    stress.add_argument(
        "--cases", type=int, default=70, help="number of cases per family (default: 70, about 30 s)"
    )
    stress.add_argument("--seed", type=int, default=0, help="seed of the random cases (default: 0)")
    stress.add_argument(
        "--family", action="append", metavar="NAME", help="test only this family; can be repeated"
    )
    stress.add_argument("-o", "--out", help="output file (.json) for the table and the failures")
    stress.add_argument("--replay", metavar="FILE", help="repeat one failed case (.npz)")
    stress.add_argument("--quiet", action="store_true", help="do not print the table")
