"""The command ``new``: a scenario from the files of a field."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable
from pathlib import Path

from geosurf.cli.console import Answer
from geosurf.errors import InputError, OutputError
from geosurf.files import write_whole
from geosurf.scenario.new import FILE, NewScenario, new_scenario, table_text
from geosurf.synthetic import field_export

# Of the example: depths of its horizons, so that `geosurf ensemble` runs on it.
UNCERTAIN = """
# How uncertain are depths between wells? Only `geosurf ensemble` reads this.

[[uncertain]]
kind = "depth error"
of = ["Top"]
sd_m = 8.0
range_m = 1500.0

[[uncertain]]
kind = "depth error"
of = ["Base"]
sd_m = 12.0
range_m = 1500.0

# How much oil is in place? Without the '#', `geosurf run` and `geosurf ensemble` answer.

# [[contacts]]
# name = "OWC"
# elevation_m = -1780.0

# [volumetrics]
# net_to_gross = {triangular = [0.6, 0.75, 0.85]}
# porosity = {"Top/Middle" = {normal = [0.25, 0.02]}, elsewhere = 0.2}
# water_saturation = {uniform = [0.2, 0.35]}
# formation_volume_factor = 1.3
"""
MOST_REPEATED = 200  # characters of a command that is shown again


def new_command(options: argparse.Namespace) -> Answer:
    """Write a scenario from files, and list how each file is used."""
    files, truth = list(options.files), None
    if options.example is not None:
        files, truth = _example(options)
    new = new_scenario(
        options.folder,
        files,
        positive=options.positive,
        length_unit=options.length_unit,
        replace=options.replace,
    )
    questions = [
        {"line": one.line, "needed": one.stops, "question": one.text} for one in new.questions
    ]
    data = {"scenario": new.path, "runs": new.runs, "questions": questions}
    lines = [table_text(new.found), "", *_questions(new)]
    if truth is not None:
        write_whole(new.path, new.path.read_bytes() + UNCERTAIN.encode())
        data["truth"] = truth
        lines = [f"{truth}: the true volumes of this synthetic field", "", *lines]
    return Answer(data, "\n".join(lines), closing=tuple(_end(new, options)))


def _example(options: argparse.Namespace) -> tuple[list[str], Path]:
    """Write the files of a synthetic field; return their paths, and that of its volumes."""
    if options.files:
        raise InputError("--example writes its own files. Leave the files or --example out.")
    folder = Path(options.folder)
    if folder.exists() and any(folder.iterdir()) and not options.replace:
        raise OutputError(
            f"{folder}: the folder is not empty. Give another one, or replace the files of the "
            f"example and {FILE} with --replace."
        )
    truth = field_export(folder, options.example)
    files = [str(path) for name, path in truth.files.items() if name != "scenario"]
    return files, folder / "truth" / "volumes.csv"


def _questions(new: NewScenario) -> Iterable[str]:
    """The questions, with their lines."""
    for question in new.questions:
        need = "needs an answer" if question.stops else "optional"
        yield f"{new.path}, line {question.line} ({need}): {question.text}"
    if new.questions:
        yield ""


def _end(new: NewScenario, options: argparse.Namespace) -> Iterable[str]:
    """The next command, or what has to be answered before it."""
    run = f"geosurf run {shlex.quote(str(new.path))} -o {shlex.quote(str(new.path.parent / 'out'))}"
    if new.runs:
        yield f"{new.path} is written. Next: {run}"
        if new.questions:  # so there will be a second run
            cache = shlex.quote(str(new.path.parent / "cache"))
            yield f"With --cache-dir {cache}, a run after an answer redoes only what it changes."
        return
    again = " ".join(map(shlex.quote, ["new", str(options.folder), *options.files]))
    if len(again) > MOST_REPEATED:
        again = f"new {shlex.quote(str(options.folder))} FILES..."
    unit = "" if options.length_unit is None else f" --length-unit {options.length_unit}"
    yield f"{new.path} is written, but a run needs the answer above. Edit that line, or repeat"
    yield "with down if z is depth, with up if it is elevation:"
    yield f"  geosurf {again} --positive down --replace{unit}"
    yield f"  geosurf {again} --positive up --replace{unit}"
    yield f"Then: {run}"
