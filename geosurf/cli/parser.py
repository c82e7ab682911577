"""The parser of the command line: all commands, their options and their help."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NoReturn

import geosurf
from geosurf.cli.console import Answer

# ---- arguments ----------------------------------------
# Arguments of the command line: refused in one sentence, with the word that was meant.


# ---- completion ----------------------------------------
# The command ``completion``: a script that lets a shell complete commands and options.
#
# The script is written from the parser. It starts no Python, so a key press costs nothing.


SHELLS = ("bash", "zsh")
BASH = """_geosurf() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" command="${{COMP_WORDS[1]}}" words
    if [ "$COMP_CWORD" -eq 1 ]; then
        words="{commands}"
    else
        case "$command" in
{cases}
        esac
    fi
    case "$word" in
        -*) COMPREPLY=($(compgen -W "$words" -- "$word")) ;;
        *) COMPREPLY=($(compgen -f -- "$word"))
           [ "$COMP_CWORD" -eq 1 ] && COMPREPLY=($(compgen -W "$words" -- "$word")) ;;
    esac
}}
complete -o filenames -F _geosurf geosurf
"""


def completion_command(options: argparse.Namespace) -> Answer:
    """Return the script for a shell."""
    text = completion_script(options.parser, options.shell)
    return Answer({"shell": options.shell, "script": text}, text.rstrip("\n"))


def completion_script(parser: Parser, shell: str) -> str:
    """
    Return the script that completes all commands and options of a parser.

    Parameters
    ----------
    parser : Parser
    shell : {"bash", "zsh"}

    Returns
    -------
    str
    """
    commands = commands_of(parser)
    cases = [
        f'            {name}) words="{" ".join(options_of(command))}" ;;'
        for name, command in commands.items()
    ]
    script = BASH.format(
        commands=" ".join([*commands, *options_of(parser)]), cases="\n".join(cases)
    )
    # zsh runs scripts of bash
    first = "autoload -U +X bashcompinit && bashcompinit\n" if shell == "zsh" else ""
    return first + script


WRONG = 2  # exit code: that of InputError
REQUIRED = re.compile("the following arguments are required: (.*)")
EXPLICIT = re.compile(": ignored explicit argument .*", re.DOTALL)
OF_ARGUMENT = re.compile("argument ([^:]+): (.*)", re.DOTALL)


class Parser(argparse.ArgumentParser):
    """An `ArgumentParser` whose refusals are sentences of geosurf."""

    def __init__(self, *args: Any, **options: Any) -> None:
        # abbreviations of options would change their meaning when an option is added
        super().__init__(*args, **{**options, "allow_abbrev": False})

    def error(self, message: str) -> NoReturn:
        """Print one sentence and the command that helps, and exit."""
        if found := REQUIRED.fullmatch(message):
            words = found[1].split(", ")
            message = f"{' and '.join(words)} {'is' if len(words) == 1 else 'are'} missing"
        elif found := OF_ARGUMENT.fullmatch(message):
            message = f"{found[1]}: {found[2]}".replace(": expected one argument", " needs a value")
            message = EXPLICIT.sub(" takes no value", message)
        # programs that read stderr expect one sentence, not argparse's usage before it
        end = "" if message.endswith((".", "?")) else "."
        self.exit(WRONG, f"{self.prog}: {message}{end} See {self.prog} --help.\n")

    def parse(self, words: Sequence[str] | None) -> argparse.Namespace:
        """Return the options of a command; an unknown command or option is named."""
        words = sys.argv[1:] if words is None else words
        command = next((word for word in words if not word.startswith("-")), None)
        known = commands_of(self)
        if command == "help":  # other programs take `help run`, too
            command = next((word for word in words if word in known), None)
            words = ["--help"] if command is None else [command, "--help"]
        if command is not None and command not in known:
            guess = did_you_mean(command, known)
            self.error(f"unknown command {command!r}.{guess} Commands are {', '.join(known)}")

        if command is None:
            strange = [word for word in words if word not in options_of(self)]
            if strange:
                self.error(_about(strange[0], self))
        options, unknown = self.parse_known_args(words)
        if unknown:
            parser = known[command] if command is not None else self
            parser.error(_about(unknown[0], parser))
        return options


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ' Did you mean ...?' for a misspelt word; the module is loaded for mistakes only."""
    from geosurf.conventions import did_you_mean

    return did_you_mean(word, known)


def commands_of(parser: argparse.ArgumentParser) -> dict[str, Parser]:
    """Return the parsers of all commands, by name."""
    (group,) = (one for one in parser._actions if isinstance(one, argparse._SubParsersAction))
    return dict(group.choices)


def options_of(parser: argparse.ArgumentParser) -> list[str]:
    """Return the options of a command, as they are typed."""
    return [word for action in parser._actions for word in action.option_strings]


def _about(word: str, parser: argparse.ArgumentParser) -> str:
    """What is wrong with a word that nothing takes."""
    if word.startswith("-"):
        name = word.partition("=")[0]
        if name in options_of(parser):
            return f"{name} takes no value"
        long = [one for one in options_of(parser) if one.startswith(f"-{name}") and len(name) == 2]
        guess = f" Did you mean {long[0]!r}?" if len(long) == 1 else ""
        return f"unknown option {name}.{guess or did_you_mean(name, options_of(parser))}"
    return f"{word!r} is one argument too many. Put names with blanks between quotes"


def one_of(*known: str) -> Callable[[str], str]:
    """Return a check of an option that takes one of some words."""

    def check(word: str) -> str:
        """Return the word, or refuse it."""
        if word in known:
            return word
        raise argparse.ArgumentTypeError(
            f"{word!r} is not known. Give {' or '.join([', '.join(known[:-1]), known[-1]])}."
            f"{did_you_mean(word, known)}"
        )

    return check


def list_of(*known: str) -> Callable[[str], tuple[str, ...]]:
    """Return a check of an option that takes several words with commas between them."""
    check = one_of(*known)

    def checked(text: str) -> tuple[str, ...]:
        """Return the words, or refuse one of them."""
        words = [word.strip() for word in text.split(",")]
        if not all(words):
            raise argparse.ArgumentTypeError(
                f"{text!r} has a comma with no word next to it. Write the words without blanks: "
                f"{','.join(filter(None, [*words, *known]))[:40]}"
            )
        return tuple(check(word) for word in words)

    return checked


def length_unit(word: str) -> str:
    """
    Check an option that takes a unit of length.

    Examples
    --------
    >>> length_unit("ft")
    'ft'
    """
    from geosurf.conventions import METRES_PER_UNIT  # loads numpy: not for --help

    return one_of(*METRES_PER_UNIT)(word.strip().lower())


def whole_number(least: int) -> Callable[[str], int]:
    """Return a check of an option that takes a whole number."""

    def check(word: str) -> int:
        """Return the number, or refuse the word."""
        try:
            number = int(word)
        except ValueError:
            number = least - 1
        if number < least:
            raise argparse.ArgumentTypeError(
                f"{word!r} is not a whole number of {least} or more. Give one, such as {least + 9}"
            )
        return number

    return check


def named_file(word: str) -> tuple[str, Path]:
    """Check an option that takes a name and a file; the name is that of the file by default.

    Examples
    --------
    >>> named_file("W1=/dev/null")[0], named_file("/dev/null")[0]
    ('W1', 'null')
    """
    name, sign, file = word.partition("=")
    path = Path(file if sign else word)
    if not path.exists():
        raise argparse.ArgumentTypeError(
            f"{path} is not there. Give a name and a file, such as W1=wells/W1.txt"
        )
    return (name if sign else path.stem), path


def number(word: str) -> float:
    """Check an option that takes a number.

    Examples
    --------
    >>> number("2.5")
    2.5
    """
    try:
        return float(word)
    except ValueError as error:
        raise argparse.ArgumentTypeError(
            f"{word!r} is not a number. Give one, such as 2.5"
        ) from error


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
        "parser",
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
