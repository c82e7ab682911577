"""The command ``new``: a scenario from the files of a field."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from geosurf.errors import InputError

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.scenario.new import NewScenario

VARIANTS = ("grids", "points", "network")
MOST_REPEATED = 200  # characters of a command that is shown again


def new_command(options: argparse.Namespace) -> int:
    """Write a scenario from files, and print how each file is used."""
    from geosurf.scenario.new import new_scenario
    from geosurf.scenario.new.text import table_text

    files = list(options.files)
    if options.example is not None:
        files = _example(options)
    new = new_scenario(
        options.folder,
        files,
        positive=options.positive,
        length_unit=options.length_unit,
        replace=options.replace,
    )
    print(table_text(new.found))
    print()
    _print_end(new, options)
    return 0


def _example(options: argparse.Namespace) -> list[str]:
    """Write the files of a synthetic field into the folder, and return their paths."""
    from geosurf.errors import OutputError
    from geosurf.scenario.new import FILE
    from geosurf.synthetic import field_export

    if options.files:
        raise InputError("--example writes its own files. Leave the files or --example out.")
    folder = Path(options.folder)
    if folder.exists() and any(folder.iterdir()) and not options.replace:
        raise OutputError(
            f"{folder}: the folder is not empty. Give another one, or replace the files of the "
            f"example and {FILE} with --replace."
        )
    truth = field_export(folder, options.example)
    print(f"{folder / 'truth' / 'volumes.csv'}: the true volumes of this synthetic field\n")
    return [str(path) for name, path in truth.files.items() if name != "scenario"]


def _print_end(new: NewScenario, options: argparse.Namespace) -> None:
    """Print the questions with their lines, and the next command."""
    for question in new.questions:
        need = "needs an answer" if question.stops else "optional"
        print(f"{new.path}, line {question.line} ({need}): {question.text}")
    if new.questions:
        print()
    run = f"geosurf run {shlex.quote(str(new.path))} -o {shlex.quote(str(new.path.parent / 'out'))}"
    if new.runs:
        print(f"{new.path} is written. Next: {run}")
        return
    again = " ".join(map(shlex.quote, ["new", str(options.folder), *options.files]))
    if len(again) > MOST_REPEATED:
        again = f"new {shlex.quote(str(options.folder))} FILES..."
    unit = "" if options.length_unit is None else f" --length-unit {options.length_unit}"
    print(f"{new.path} is written, but a run needs the answer above. Edit that line, or repeat")
    print("with down if z is depth, with up if it is elevation:")
    print(f"  geosurf {again} --positive down --replace{unit}")
    print(f"  geosurf {again} --positive up --replace{unit}")
    print(f"Then: {run}")


__all__ = ["VARIANTS", "new_command"]
