"""The parser of the command line: all commands, their options and their help."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import geosurf
from geosurf.cli.arguments import (
    SHELLS,
    Parser,
    did_you_mean,
    length_unit,
    list_of,
    named_file,
    number,
    one_of,
    whole_number,
)

# what commands take, known before a command is loaded
FILES = ("vtm", "vtp", "csv", "nc", "pl", "ml", "epc")
RESULTS = (*FILES, "grid", "pictures", "report")
VARIANTS = ("grids", "points", "network")
VIEW, SHOW = "southwest", "horizons,faults,curves"
SCENARIO = "scenario file (TOML); its keys are in docs/scenario.md"
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

    def add(name: str, module: str, help_: str, example: str) -> Any:
        """Add a command with the options that all commands have, and where its function is."""
        end = f"example: geosurf {name} {example}".rstrip()
        command = commands.add_parser(name, help=help_, description=help_, epilog=end)

        # `main` imports and calls it, so no table of commands exists twice
        command.set_defaults(
            command=name, module=module, kept=lambda _: "No file was left half-written."
        )
        _add_common(command)
        return command

    _add_new(add)
    _add_scenario_commands(add)
    _add_ensemble(add)
    _add_curves(add)
    _add_convert(add)
    info = add(
        "info", "info_commands", "show what files hold and how geosurf reads them", "Top.gri"
    )
    info.add_argument("files", metavar="FILE", nargs="+", help="files of any format")
    add("doctor", "info_commands", "check the installation", "")
    add("warmup", "info_commands", "pre-compile the kernels (not needed with a wheel)", "")
    completion = add(
        "completion",
        "arguments",
        "print a script that lets a shell complete commands and options",
        "bash >> ~/.bash_completion",
    )
    completion.set_defaults(parser=parser)
    completion.add_argument("shell", type=one_of(*SHELLS), metavar="SHELL", help="bash or zsh")
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
        "scenario_commands",
        "build the model of a scenario: volumes, pictures and a report",
        f"{of} {out} --set tear.trim_cells=2",
    )
    validate = add(
        "validate", "scenario_commands", "list all mistakes of a scenario; nothing is built", of
    )
    check = add(
        "check", "scenario_commands", "check the model of a scenario and print its certificate", of
    )
    render = add(
        "render",
        "render_command",
        "draw one picture of the model of a scenario",
        f"{of} -o top.png --view top",
    )
    report = add(
        "report",
        "scenario_commands",
        "write the report of a scenario and its pictures",
        f"{of} {out}",
    )
    for command in (run, validate, check, render, report):
        command.add_argument("scenario", help=SCENARIO)
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
        action="extend",
        type=list_of(*RESULTS),
        help="write only these results, with commas between them, and certificate.txt: "
        + ", ".join(RESULTS),
    )
    run.add_argument(
        "--dry-run", action="store_true", help="list what a run would read and write; build nothing"
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
        type=number,
        help="vertical exaggeration (default: chosen by the shape of the model)",
    )
    render.add_argument(
        "--camera",
        metavar="ANGLES",
        help='azimuth and height of the viewer in degrees, in place of --view: "225,30"',
    )
    render.add_argument("--zoom", type=number, help="2 shows the middle twice as large")
    render.add_argument(
        "--only", metavar="NAMES", action="append", help="draw these surfaces, units, zones, blocks"
    )
    render.add_argument(
        "--colour-by", help="colours of units: unit, zone, block, contact or z (elevation)"
    )
    render.add_argument("--title", help="text above the picture (default: what is shown)")
    render.add_argument("--theme", help="light or dark")
    render.add_argument(
        "--transparent", action=argparse.BooleanOptionalAction, help="leave the background out"
    )
    for kind, what in (
        ("wells", "the path of a well, from the top down"),
        ("polygons", "polygons such as a licence"),
        ("points", "data points"),
    ):
        render.add_argument(
            f"--{kind}",
            metavar="NAME=FILE",
            action="append",
            default=[],
            type=named_file,
            help=f"also draw {what}; can be repeated",
        )
    render.add_argument(
        "--size", metavar="W,H", help='pixels (default: of the scenario): "1280,800"'
    )
    render.add_argument("--clip", action=argparse.BooleanOptionalAction,
                        help="draw the inside of the model only")  # fmt: skip


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


def _add_direction(command: argparse.ArgumentParser, when: str, default: str = "") -> None:
    """Add what files may not state: the direction and the unit of z."""
    words = one_of("up", "down")
    command.add_argument(
        "--positive", type=words, metavar="up|down", help=f"direction of z, {when}"
    )
    command.add_argument(
        "--length-unit", type=length_unit, metavar="UNIT", help=f"unit of z, {when}{default}"
    )


def _add_convert(add: Callable[..., Any]) -> None:
    """Add the command that converts one file."""
    convert = add(
        "convert",
        "convert_command",
        "write a file in another format, and list what is lost",
        "Top.gri Top.zmap",
    )
    convert.add_argument("source", metavar="SOURCE", help="file of any format")
    convert.add_argument("target", metavar="TARGET", help="its suffix picks the format")
    _add_direction(convert, "if the file does not state it")
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
        "convert_command",
        "find the intersection lines of two surface files",
        "Top.gri F1.ts -o curves.vtp",
    )
    curves.add_argument("first", help="surface file: .gri .zmap .nc .ts .vtp .pol .obj ...")
    curves.add_argument("second", help="second surface file")
    curves.add_argument("-o", "--out", required=True, help="output file (.vtp, .pl or .pol)")
    _add_direction(curves, "if a file does not state it")


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
        "ensemble_command",
        "compute P90, P50 and P10 of the volumes of a scenario",
        "field/scenario.toml -o field/ensemble -n 200",
    )
    ensemble.set_defaults(
        kept=lambda options: (
            f"Finished realisations are in {options.out}; the same command continues there."
        )
    )
    ensemble.add_argument("scenario", help=SCENARIO)
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
        "new_command",
        "write a scenario from files: horizons, faults, well tops ...",
        "field data/*.gri data/*.pol",
    )
    new.add_argument("folder", metavar="FOLDER", help="where scenario.toml is written")
    new.add_argument("files", metavar="FILES", nargs="*", help="files of the field, or folders")
    _add_direction(new, "if files do not state it", " (default: m)")
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
