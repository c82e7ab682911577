"""The command ``completion``: a script that lets a shell complete commands and options.

The script is written from the parser. It starts no Python, so a key press costs nothing. The
library shtab writes such scripts for bash, zsh and tcsh, not for fish.
"""

from __future__ import annotations

import argparse

from geosurf.cli.arguments import Parser, commands_of, options_of
from geosurf.cli.console import Answer

SHELLS = ("bash", "zsh", "fish")
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
    shell : {"bash", "zsh", "fish"}

    Returns
    -------
    str
    """
    if shell == "fish":
        return _fish(parser)
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


def _fish(parser: Parser) -> str:
    """One line for each command and option."""
    lines = []
    for name, command in commands_of(parser).items():
        about = _quoted(command.description or "")
        lines.append(f"complete -c geosurf -n __fish_use_subcommand -f -a {name} -d {about}")
        for action in command._actions:
            words = [
                f"-{'s' if len(word) == 2 else 'l'} {word.lstrip('-')}"
                for word in action.option_strings
            ]
            if words:
                inside = f"'__fish_seen_subcommand_from {name}'"
                about = _quoted(action.help or "")
                lines.append(f"complete -c geosurf -n {inside} {' '.join(words)} -d {about}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """Text between single quotes, as fish reads it."""
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
