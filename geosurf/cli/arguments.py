"""Arguments of the command line: refused in one sentence, with the word that was meant."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from geosurf.cli.console import Answer

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
