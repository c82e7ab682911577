"""The parser of the command line: all commands, their options and their help."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import geosurf
from geosurf.cli.arguments import (
    SHELLS,
    Parser,
    completion_command,
    did_you_mean,
    length_unit,
    list_of,
    one_of,
    whole_number,
)
from geosurf.cli.console import Answer
from geosurf.cli.convert_command import convert_command, curves_command
from geosurf.cli.info_command import info_command
from geosurf.cli.install_commands import doctor_command, warmup_command
from geosurf.cli.render_command import add_render_options, render_command
from geosurf.cli.scenario_commands import (
    RESULTS,
    VARIANTS,
    check_command,
    ensemble_command,
    new_command,
    report_command,
    run_command,
    validate_command,
)

EXIT_CODES = """exit codes: 0 done, 2 invalid input, 3 impossible geometry or a failed check,
4 a bug in geosurf, 128 + n stopped by signal n (Ctrl-C: 130)"""


def build_parser() -> Parser:
    """Return the parser of all commands and options.

    Returns
    -------
    Parser
    """
    # the raw formatter leaves the lines of EXIT_CODES as they are
    parser = Parser(
        prog="geosurf",
        description="Build sealed, exact and certified reservoir units from horizons and faults.",
        epilog=f"example: geosurf run scenario.toml -o out\n\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "-V", "--version", action="version", version=f"geosurf {geosurf.__version__}"
    )
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    def add(
        name: str, run: Callable[[argparse.Namespace], Answer], help_: str, example: str
    ) -> Any:
        """Add a command with the options that all commands have."""
        command = commands.add_parser(
            name,
            help=help_,
            description=help_,
            epilog=f"example: geosurf {name} {example}".rstrip(),
        )

        # `main` calls `options.run`, so no table of commands exists twice
        command.set_defaults(run=run, kept=lambda _: "No file was left half-written.")
        _add_common(command)
        return command

    _add_new(add)
    _add_scenario_commands(add)
    _add_ensemble(add)
    _add_curves(add)
    _add_convert(add)
    info = add("info", info_command, "show what files hold and how geosurf reads them", "Top.gri")
    info.add_argument("files", metavar="FILE", nargs="+", help="files of any format")
    add("doctor", doctor_command, "check the installation", "")
    add("warmup", warmup_command, "pre-compile the kernels (not needed with a wheel)", "")
    completion = add(
        "completion",
        completion_command,
        "print a script that lets a shell complete commands and options",
        "bash >> ~/.bash_completion",
    )
    completion.set_defaults(parser=parser)
    completion.add_argument(
        "shell", type=one_of(*SHELLS), metavar="SHELL", help="bash, zsh or fish"
    )
    return parser


def _add_common(command: argparse.ArgumentParser) -> None:
    """Add the options that all commands have; they mean the same everywhere."""
    common = command.add_argument_group("output")
    common.add_argument(
        "--json", action="store_true", help="print one object in JSON instead of text"
    )
    common.add_argument("--quiet", action="store_true", help="print warnings and errors only")
    common.add_argument(
        "--verbose",
        action="store_true",
        help="also print steps, their times and the peak memory, on stderr",
    )
    # no default here: `run` would override `geosurf --debug run`
    common.add_argument(
        "--debug",
        action="store_true",
        default=argparse.SUPPRESS,
        help="show the traceback of an error",
    )


def _add_scenario_commands(add: Callable[..., Any]) -> None:
    """Add the commands that take a scenario."""
    of, out = "field/scenario.toml", "-o field/out"
    run = add(
        "run",
        run_command,
        "build the model of a scenario: volumes, pictures and a report",
        f"{of} {out} --set tear.trim_cells=2",
    )
    validate = add(
        "validate", validate_command, "list all mistakes of a scenario; nothing is built", of
    )
    check = add(
        "check", check_command, "check the model of a scenario and print its certificate", of
    )
    render = add(
        "render",
        render_command,
        "draw one picture of the model of a scenario",
        f"{of} -o top.png --view top",
    )
    report = add(
        "report", report_command, "write the report of a scenario and its pictures", f"{of} {out}"
    )
    for command in (run, validate, check, render, report):
        command.add_argument(
            "scenario", help="scenario file (TOML); its keys are in docs/scenario.md"
        )
        _add_set(command)
    for command in (run, check, report):
        command.add_argument(
            "--merge-slivers",
            action="store_true",
            help="merge units too small to count into neighbours, as [slivers] merge = true does",
        )
    for command in (run, report):
        command.set_defaults(kept=_kept)
        command.add_argument(
            "-o", "--out", required=True, help="output folder, created if it is missing"
        )
        command.add_argument("--no-pictures", action="store_true", help="do not draw pictures")
    for command in (run, check, render, report):
        _add_cache(command)
    run.add_argument(
        "--only",
        metavar="RESULTS",
        type=list_of(*RESULTS),
        help="write only these results, with commas between them, and certificate.txt: "
        + ", ".join(RESULTS),
    )
    run.add_argument(
        "--dry-run", action="store_true", help="list what a run would read and write; build nothing"
    )

    add_render_options(render)


def _add_cache(command: argparse.ArgumentParser) -> None:
    """Add the folder that the commands of a scenario have in common."""
    command.add_argument(
        "--cache-dir",
        metavar="FOLDER",
        help="store torn horizons, certificates and pictures there; later commands on the same "
        "field redo only what changed",
    )


def _kept(options: argparse.Namespace) -> str:
    """What a run that is stopped leaves."""
    kept = f"{options.out} has the results of an earlier run, if there was one, or all new ones."
    if options.cache_dir is None:
        return kept
    return f"{kept} Finished steps are in {options.cache_dir}; the same command continues there."


def _add_convert(add: Callable[..., Any]) -> None:
    """Add the command that converts one file."""
    convert = add(
        "convert",
        convert_command,
        "write a file in another format, and list what is lost",
        "Top.gri Top.zmap",
    )
    convert.add_argument("source", metavar="SOURCE", help="file of any format")
    convert.add_argument("target", metavar="TARGET", help="its suffix picks the format")
    convert.add_argument(
        "--positive",
        type=one_of("up", "down"),
        metavar="up|down",
        help="direction of z, if the file does not state it",
    )
    convert.add_argument(
        "--length-unit",
        type=length_unit,
        metavar="UNIT",
        help="unit of z, if the file does not state it",
    )
    convert.add_argument(
        "--crs", metavar="EPSG:CODE", help="coordinate reference system, if the file states none"
    )
    convert.add_argument("--name", help="name to store; of several surfaces: which one")
    convert.add_argument(
        "--as", dest="read_as", metavar="KIND",
        type=one_of("horizon", "fault", "points", "polygons", "tops", "wells"),
        help="what the file holds, if its content does not show it: horizon, fault, points, "
        "polygons, tops or wells",
    )  # fmt: skip
    convert.add_argument(
        "--columns", metavar="X,Y,Z",
        help="columns of easting, northing and z in a table, by name or counted from 1; of wells, "
        "those that differ: md=DEPT,well=3",
    )  # fmt: skip
    convert.add_argument(
        "--decimal", type=one_of(".", ","), metavar=".|,", help="decimal sign of a table"
    )
    convert.add_argument(
        "--heads", metavar="FILE", help="table of the heads of wells that have directions only"
    )


def _add_curves(add: Callable[..., Any]) -> None:
    """Add the command that takes two surfaces."""
    curves = add(
        "curves",
        curves_command,
        "find the intersection lines of two surface files",
        "Top.gri F1.ts -o curves.vtp",
    )
    curves.add_argument("first", help="surface file: .gri .zmap .nc .ts .vtp .pol .obj ...")
    curves.add_argument("second", help="second surface file")
    curves.add_argument("-o", "--out", required=True, help="output file (.vtp, .pl or .pol)")
    curves.add_argument(
        "--positive",
        type=one_of("up", "down"),
        metavar="up|down",
        help="direction of z, if a file does not state it",
    )
    curves.add_argument(
        "--length-unit",
        type=length_unit,
        metavar="UNIT",
        help="length unit, if a file does not state it",
    )


def _add_set(command: argparse.ArgumentParser) -> None:
    """Add ``--set``, which all commands on scenarios have."""
    command.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="give a key of the scenario another value, as in --set output.maps=false or "
        "--set horizons.Top.file=New.gri; can be repeated",
    )


def _add_ensemble(add: Callable[..., Any]) -> None:
    """Add the command that builds many realisations."""
    ensemble = add(
        "ensemble",
        ensemble_command,
        "compute P90, P50 and P10 of the volumes of a scenario",
        "field/scenario.toml -o field/ensemble -n 200",
    )
    ensemble.set_defaults(
        kept=lambda options: (
            f"Finished realisations are in {options.out}; the same command continues there."
        )
    )
    ensemble.add_argument("scenario", help="scenario file (TOML); its keys are in docs/scenario.md")
    _add_set(ensemble)
    ensemble.add_argument(
        "-o", "--out", required=True,
        help="output folder, created if it is missing; one with a part of the same ensemble is "
        "continued",
    )  # fmt: skip
    _add_cache(ensemble)
    ensemble.add_argument(
        "-n", type=whole_number(1), help="number of realisations (default: [ensemble], 100)"
    )
    ensemble.add_argument(
        "--seed", type=whole_number(0), help="seed (default: that of [ensemble], or 0)"
    )
    ensemble.add_argument(
        "--workers", type=whole_number(1), help="realisations at once (default: all cores)"
    )
    ensemble.add_argument(
        "--processes",
        action=argparse.BooleanOptionalAction,
        help="worker processes, not threads (default: from 50 realisations on)",
    )


def _add_new(add: Callable[..., Any]) -> None:
    """Add the command that writes a scenario."""
    new = add(
        "new",
        new_command,
        "write a scenario from files: horizons, faults, well tops ...",
        "field data/*.gri data/*.pol",
    )
    new.add_argument("folder", metavar="FOLDER", help="where scenario.toml is written")
    new.add_argument("files", metavar="FILES", nargs="*", help="files of the field, or folders")
    new.add_argument(
        "--positive",
        type=one_of("up", "down"),
        metavar="up|down",
        help="direction of z, if files do not state it",
    )
    new.add_argument(
        "--length-unit",
        type=length_unit,
        metavar="UNIT",
        help="unit of z, if files do not state it (default: m)",
    )
    new.add_argument("--replace", action="store_true", help="replace an existing scenario")
    new.add_argument(
        "--example",
        nargs="?",
        const="grids",
        metavar="KIND",
        type=_example_kind,
        help="write a synthetic field with known volumes into FOLDER, and its scenario: "
        f"{', '.join(VARIANTS)} (default: grids)",
    )


def _example_kind(word: str) -> str:
    """Check the kind of an example; a folder behind --example is a usual slip."""
    try:
        return one_of(*VARIANTS)(word)
    except argparse.ArgumentTypeError as error:
        if did_you_mean(word, VARIANTS):
            raise
        raise argparse.ArgumentTypeError(
            f"{error} The folder comes first: geosurf new {word} --example"
        ) from error
