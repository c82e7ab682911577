"""Files -> a scenario: what each file holds, in which order, and what stays open.

================  =============================================================
recognise.py      one file -> what it holds
judge.py          what one file holds: direction, unit, order, names, and what stays out
network.py        faults that end at others
text.py           the scenario as text, and the table for the console
================  =============================================================
"""

from __future__ import annotations

import os
import warnings
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from geosurf.conventions import METRES_PER_UNIT, counted, did_you_mean
from geosurf.errors import GeosurfWarning, InputError, OutputError
from geosurf.files.atomic import write_whole
from geosurf.model.expected import path_of
from geosurf.scenario.new.judge import OUT, Answers, Found, Question, judged
from geosurf.scenario.new.network import dividers_among, faults_of, truncations_among
from geosurf.scenario.new.recognise import recognised
from geosurf.scenario.new.text import scenario_text
from geosurf.scenario.validate import read_scenario

FILE = "scenario.toml"
CERTIFICATE = "certificate.txt"  # of a folder with the results of a run
MOST_NAMED = 6  # files in one message


@dataclass(frozen=True)
class NewScenario:
    """
    A scenario that was written from files.

    Attributes
    ----------
    path : pathlib.Path
    found : tuple of Found
        What each file holds; horizons youngest first.
    questions : tuple of Question
        What the files do not state; those that stop a run come first.
    """

    path: Path
    found: tuple[Found, ...]
    questions: tuple[Question, ...]

    @property
    def runs(self) -> bool:
        """Whether no question must be answered before a run."""
        return not any(question.stops for question in self.questions)


def new_scenario(
    folder: str | os.PathLike[str],
    files: list[str] | list[Path],
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    replace: bool = False,
) -> NewScenario:
    """
    Write ``scenario.toml`` from the files of a field.

    Parameters
    ----------
    folder : path-like
        Is created if it is missing.
    files : list of path-like
        Files of any kind; a folder stands for all files in it and in its folders.
    positive : {"up", "down"}, optional
        Whether z is elevation or depth in files that do not state it.
    length_unit : str, optional
        Unit of z in files that do not state it.
    replace : bool
        Whether an existing scenario is replaced.

    Returns
    -------
    NewScenario

    Raises
    ------
    InputError
        If there are no files, or none of them holds a horizon or a sealed model.
    OutputError
        If the scenario exists and `replace` is False, or the folder cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import geosurf as gs
    >>> folder = tempfile.mkdtemp()
    >>> truth = gs.synthetic.field_export(folder)
    >>> new = new_scenario(folder, [folder])
    >>> [one.name for one in new.found if one.kind == "horizon"], new.runs
    (['Top', 'Middle', 'Base'], True)
    """
    # An existing scenario may hold answers of the user: it is never overwritten silently.
    path = path_of(folder, "geosurf new") / FILE
    if path.exists() and not replace:
        raise OutputError(
            f"{path}: the file exists. Give another folder, or replace it with --replace."
        )
    _check_words(positive, length_unit)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GeosurfWarning)  # the run prints them
        found = [one for file in _files_of(files) for one in recognised(file)]
        # Before anything is compared: without a horizon nothing else makes sense.
        _require_model(found)
        ready = judged(found, Answers(positive, length_unit))
        faults = faults_of(ready)
        ends = truncations_among(ready, faults)
        dividers = dividers_among(faults, ends)
    # Paths in the text are relative to the folder of the scenario.
    text, questions = scenario_text(path.parent, ready, ends, dividers)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text.encode("utf-8"))
    except OSError as error:
        file = next((one for one in path.parents if one.is_file()), None)
        reason = error.strerror if file is None else f"{file} is a file, not a folder"
        raise OutputError(
            f"{path}: the scenario cannot be written ({reason}). Give another folder."
        ) from error
    read_scenario(path)  # what geosurf writes it reads
    return NewScenario(path, tuple(ready.found), questions)


def _check_words(positive: str | None, length_unit: str | None) -> None:
    """Refuse words that readers do not know, before a file is read."""
    # The words are those of readers, so that their messages fit.
    if positive not in (None, "up", "down"):
        raise InputError(f"--positive is {positive!r}; give up or down.")
    if length_unit is not None and length_unit not in METRES_PER_UNIT:
        raise InputError(
            f"--length-unit is {length_unit!r}; give one of {', '.join(METRES_PER_UNIT)}."
            f"{did_you_mean(length_unit, METRES_PER_UNIT)}"
        )


def _files_of(files: list[str] | list[Path]) -> list[Path]:
    """Paths as they were given, each once; a folder stands for all files below it, by name."""
    # A dict keeps the order and drops files that are given twice.
    found: dict[Path, None] = {}
    for word in files:
        path = path_of(word, "geosurf new")
        if not path.exists() and any(sign in str(path) for sign in "*?["):  # the shell found none
            raise InputError(f"{path}: no file has such a name. Check the folder and the suffix.")
        inside = [path]
        if path.is_dir():
            # exports keep horizons and faults in folders of their own; hidden files are not data
            below = [(p, p.relative_to(path).parts) for p in sorted(path.rglob("*"))]
            results = {p.parent for p, _ in below if p.name == CERTIFICATE}
            inside = [
                p
                for p, parts in below
                if (p.is_file() and not _is_hidden(parts) and results.isdisjoint(p.parents))
                or p in results
            ]
            if not inside:
                raise InputError(f"{path}: the folder has no files. Give the files of a field.")
        found |= dict.fromkeys(inside)
    if not found:
        raise InputError("no files are given. Write: geosurf new FOLDER FILES...")
    return list(found)


def _is_hidden(parts: tuple[str, ...]) -> bool:
    """Whether a file or a folder around it is hidden."""
    return any(part.startswith(".") for part in parts)


def _require_model(found: list[Found]) -> None:
    """Without a horizon or a sealed model there is nothing to build."""
    if any(one.kind in ("horizon", "model") for one in found):
        return
    # The message says what the files hold instead, so that the missing one is obvious.
    left = [one for one in found if one.kind == OUT]
    others = Counter(one.kind for one in found if one.kind != OUT)
    held = [counted(n, kind) for kind, n in others.items()]
    reasons = [f"{one.path.name}: {one.note.rstrip('.')}" for one in left[:MOST_NAMED]]
    more = [f"and {len(left) - MOST_NAMED} more"] if len(left) > MOST_NAMED else []
    raise InputError(
        f"none of these files holds a horizon or a sealed model: {'; '.join(held + reasons + more)}"
        ". Give at least one grid or points file of a horizon."
    )


__all__ = ["FILE", "NewScenario", "new_scenario"]
