"""The parser of the command line: all commands, their options and their help."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Sequence
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
        if match := REQUIRED.fullmatch(message):
            words = match[1].split(", ")
            message = f"{' and '.join(words)} {'is' if len(words) == 1 else 'are'} missing"
        elif match := OF_ARGUMENT.fullmatch(message):
            message = f"{match[1]}: {match[2]}".replace(": expected one argument", " needs a value")
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


# what commands take, known before a command is loaded
FILES = ("vtm", "vtp", "csv", "nc", "pl", "ml", "epc")
RESULTS = (*FILES, "grid", "pictures", "report")
VARIANTS = ("grids", "points", "network")
VIEW, SHOW = "southwest", "horizons,faults,curves"
EXIT_CODES = """exit codes: 0 done, 2 invalid input, 3 impossible geometry or a failed check,
4 a bug in geosurf, 128 + n stopped by signal n (Ctrl-C: 130)"""

# Columns are separated by two spaces or more: name, module of the function, meaning, example.
COMMANDS = """
new         new_command        write a scenario from files: horizons, faults, well tops ...
            field data/*.gri data/*.pol
run         scenario_commands  build the model of a scenario: volumes, pictures and a report
            field/scenario.toml -o field/out --set tear.trim_cells=2
validate    scenario_commands  list all mistakes of a scenario; nothing is built
            field/scenario.toml
check       scenario_commands  check the model of a scenario and print its certificate
            field/scenario.toml
render      render_command     draw one picture of the model of a scenario
            field/scenario.toml -o top.png --view top --set 'output.size_px=[1280,800]'
ensemble    ensemble_command   compute P90, P50 and P10 of the volumes of a scenario
            field/scenario.toml -o field/ensemble -n 200
curves      convert_command    find the intersection lines of two surface files
            Top.gri F1.ts -o curves.vtp
convert     convert_command    write a file in another format, and list what is lost
            Top.gri Top.zmap
info        info_commands      show what files hold and how geosurf reads them
            Top.gri
doctor      info_commands      check the installation
warmup      info_commands      pre-compile the kernels (not needed with a wheel)
completion  parser             print a script that lets a shell complete commands and options
            bash >> ~/.bash_completion
"""
# Below the names of commands: the words of an option or argument, what it takes (a key of `KINDS`,
# or its word in the help), meaning; a line without words continues the one above.
# `render` has no defaults: `_draw_section` refuses what is given for views only. What pictures look
# like is in the scenario, and `--set` changes it.
OPTIONS = """
new
    folder           FOLDER    where scenario.toml is written
    files            FILES     files of the field, or folders
    --positive       up|down   direction of z, if files do not state it
    --length-unit    UNIT      unit of z, if files do not state it (default: m)
    --replace        switch    replace an existing scenario
    --example        example   write a synthetic field with known volumes into FOLDER, and its
                               scenario: {variants} (default: grids)
run validate check render ensemble
    scenario         -         scenario file (TOML); its keys are in docs/scenario.md
    --set            KEY=VALUE  give a key of the scenario another value, as in --set
                               output.maps=false or --set horizons.Top.file=New.gri; can be
                               repeated
run
    -o --out         required  output folder, created if it is missing
    --no-pictures    switch    do not draw pictures
ensemble
    -o --out         required  output folder, created if it is missing; one with a part of the same
                               ensemble is continued
run check render ensemble
    --cache-dir      FOLDER    store torn horizons, certificates and pictures there; later commands
                               on the same field redo only what changed
run
    --only           RESULTS   write only these results, with commas between them, and
                               certificate.txt: {results}
    --dry-run        switch    list what a run would read and write; build nothing
render
    -o --out         required  output file (.png)
    --view           -         direction of view: north, top ... (default: {view})
    --show           -         what to draw, also walls, patches, units (default: {show})
    --section        LINE      draw a vertical section along this line, as in
                               "0,2500 6000,2500 ..." [m]
    --only           NAMES     draw these surfaces, units, zones, blocks
    --colour-by      -         colours of units: unit, zone, block, contact or z (elevation)
    --title          -         text above the picture (default: what is shown)
ensemble
    -n               count     number of realisations (default: [ensemble], 100)
    --seed           seed      seed (default: that of [ensemble], or 0)
    --workers        count     realisations at once (default: all cores)
    --processes      yes or no  worker processes, not threads (default: from 50 realisations on)
curves
    first            -         surface file: .gri .zmap .nc .ts .vtp .pol .obj ...
    second           -         second surface file
    -o --out         required  output file (.vtp, .pl or .pol)
    --positive       up|down   direction of z, if a file does not state it
    --length-unit    UNIT      unit of z, if a file does not state it
convert
    source           SOURCE    file of any format
    target           TARGET    its suffix picks the format
    --positive       up|down   direction of z, if the file does not state it
    --length-unit    UNIT      unit of z, if the file does not state it
    --crs            EPSG:CODE  coordinate reference system, if the file states none
    --name           -         name to store; of several surfaces: which one
    --as             read_as   what the file holds, if its content does not show it: horizon, fault,
                               points, polygons, tops or wells
    --columns        X,Y,Z     columns of easting, northing and z in a table, by name or counted
                               from 1; of wells, those that differ: md=DEPT,well=3
    --decimal        .|,       decimal sign of a table
    --heads          FILE      table of the heads of wells that have directions only
info
    files            FILE...   files of any format
completion
    shell            SHELL     bash or zsh
"""


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
    for name, module, meaning, *example in _rows(COMMANDS):
        end = " ".join(["example: geosurf", name, *example])
        command = commands.add_parser(name, help=meaning, description=meaning, epilog=end)

        # `main` imports and calls it, so no table of commands exists twice
        command.set_defaults(
            command=name, module=module, kept=lambda _: "No file was left half-written."
        )
        _add_common(command)
    known = commands_of(parser)
    for row in _rows(OPTIONS):
        if len(row) == 1:
            chosen = [known[name] for name in row[0].split()]
            continue
        words, takes, *meanings = row
        more = KINDS.get(takes, {} if takes == "-" else {"metavar": takes})
        help_ = " ".join(meanings).format(
            variants=", ".join(VARIANTS), results=", ".join(RESULTS), view=VIEW, show=SHOW
        )
        for command in chosen:
            command.add_argument(*words.split(), help=help_, **more)
    known["run"].set_defaults(kept=_kept)
    known["ensemble"].set_defaults(
        kept=lambda options: (
            f"Finished realisations are in {options.out}; the same command continues there."
        )
    )
    known["completion"].set_defaults(parser=parser)
    return parser


def _rows(table: str) -> list[list[str]]:
    """The cells of each row of a table; what stands far to the right continues the row above."""
    rows: list[list[str]] = []
    for line in table.strip("\n").split("\n"):
        cells = re.split(" {2,}", line.strip())
        if line.startswith(" " * 8):
            rows[-1] += cells
        else:
            rows.append(cells)
    return rows


def _add_common(command: argparse.ArgumentParser) -> None:
    """Add the options that all commands have; they mean the same everywhere."""
    common = command.add_argument_group("output")
    switch: dict[str, Any] = {"action": "store_true"}
    common.add_argument("--json", **switch, help="print one object in JSON instead of text")
    common.add_argument("--quiet", **switch, help="print warnings and errors only")
    verbose = "also print steps, their times and the peak memory, on stderr"
    common.add_argument("--verbose", **switch, help=verbose)
    # no default here: `run` would override `geosurf --debug run`
    hidden = argparse.SUPPRESS
    common.add_argument("--debug", **switch, default=hidden, help="show the traceback of an error")


def _kept(options: argparse.Namespace) -> str:
    """What a run that is stopped leaves."""
    kept = f"{options.out} has the results of an earlier run, if there was one, or all new ones."
    if options.cache_dir is None:
        return kept
    return f"{kept} Finished steps are in {options.cache_dir}; the same command continues there."


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


KINDS: dict[str, dict[str, Any]] = {
    "switch": {"action": "store_true"},
    "yes or no": {"action": argparse.BooleanOptionalAction},
    "required": {"required": True},
    "count": {"type": whole_number(1)},
    "seed": {"type": whole_number(0)},
    "FILES": {"metavar": "FILES", "nargs": "*"},
    "FILE...": {"metavar": "FILE", "nargs": "+"},
    "up|down": {"metavar": "up|down", "type": one_of("up", "down")},
    ".|,": {"metavar": ".|,", "type": one_of(".", ",")},
    "UNIT": {"metavar": "UNIT", "type": length_unit},
    "SHELL": {"metavar": "SHELL", "type": one_of(*SHELLS)},
    "RESULTS": {"metavar": "RESULTS", "action": "extend", "type": list_of(*RESULTS)},
    "NAMES": {"metavar": "NAMES", "action": "append"},
    "KEY=VALUE": {"metavar": "KEY=VALUE", "action": "append", "default": []},
    "example": {"metavar": "KIND", "nargs": "?", "const": "grids", "type": _example_kind},
    "read_as": {
        "metavar": "KIND", "dest": "read_as",
        "type": one_of("horizon", "fault", "points", "polygons", "tops", "wells"),
    },
}  # fmt: skip
