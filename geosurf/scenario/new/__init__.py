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
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from geosurf.conventions import METRES_PER_UNIT, check_word, counted, did_you_mean, toml_key
from geosurf.errors import GeosurfWarning, InputError, OutputError, SurfaceError
from geosurf.files import write_into_folder
from geosurf.model.expected import path_of
from geosurf.scenario.new.judge import (
    OUT,
    Answers,
    Found,
    Question,
    Ready,
    judged,
    nearest_horizon,
    overlap_in_map,
)
from geosurf.scenario.new.network import (
    SIDES,
    Divider,
    End,
    dividers_among,
    faults_of,
    truncations_among,
)
from geosurf.scenario.new.recognise import recognised
from geosurf.scenario.validate import read_scenario
from geosurf.triangulate.fault_polygons import dip_of_polygon, dips_in_horizons

FILE = "scenario.toml"
CERTIFICATE = "certificate.txt"  # of a folder with the results of a run
SMEARED = 5.0  # degrees between the dip of a fault polygon and that of the horizons below it
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
        If a file does not exist, or none of them holds a horizon or a sealed model.
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
        recognised_files = [one for file in _files_of(files) for one in recognised(file)]
        # Before anything is compared: without a horizon nothing else makes sense.
        _require_model(recognised_files)
        ready = judged(recognised_files, Answers(positive, length_unit))
        faults = faults_of(ready)
        ends = truncations_among(ready, faults)
        dividers = dividers_among(faults, ends)
    # Paths in the text are relative to the folder of the scenario.
    text, questions = scenario_text(path.parent, ready, ends, dividers)
    write_into_folder(path, text.encode("utf-8"), "the scenario")
    read_scenario(path)  # what geosurf writes it reads
    return NewScenario(path, tuple(ready.found), questions)


def _check_words(positive: str | None, length_unit: str | None) -> None:
    """Refuse words that readers do not know, before a file is read."""
    # The words are those of readers, so that their messages fit.
    if positive not in (None, "up", "down"):
        raise InputError(f"--positive is {positive!r}; give up or down.")
    if length_unit is not None:
        refusal = f"--length-unit is {length_unit!r}; give one of {', '.join(METRES_PER_UNIT)}."
        check_word(length_unit, METRES_PER_UNIT, refusal)


def _files_of(files: list[str] | list[Path]) -> list[Path]:
    """Paths as they were given, each once; a folder stands for all files below it, by name."""
    # A dict keeps the order and drops files that are given twice.
    paths: dict[Path, None] = {}
    for word in files:
        path = path_of(word, "geosurf new")
        if not path.exists():
            beside = did_you_mean(path.name, [sibling.name for sibling in path.parent.glob("*")])
            remedy = beside or " Check the folder and the suffix."
            raise InputError(f"{path}: no file has such a name.{remedy}")
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
        paths |= dict.fromkeys(inside)
    if not paths:
        raise InputError("no files are given. Write: geosurf new FOLDER FILES...")
    return list(paths)


def _is_hidden(parts: tuple[str, ...]) -> bool:
    """Whether a file or a folder around it is hidden."""
    return any(part.startswith(".") for part in parts)


def _require_model(files: list[Found]) -> None:
    """Without a horizon or a sealed model there is nothing to build."""
    if any(file.kind in ("horizon", "model") for file in files):
        return
    # The message says what the files hold instead, so that the missing one is obvious.
    left = [file for file in files if file.kind == OUT]
    others = Counter(file.kind for file in files if file.kind != OUT)
    held = [counted(n, kind) for kind, n in others.items()]
    reasons = [f"{file.path.name}: {file.note.rstrip('.')}" for file in left[:MOST_NAMED]]
    more = [f"and {len(left) - MOST_NAMED} more"] if len(left) > MOST_NAMED else []
    raise InputError(
        f"none of these files holds a horizon or a sealed model: {'; '.join(held + reasons + more)}"
        ". Give at least one grid or points file of a horizon."
    )


__all__ = ["FILE", "NewScenario", "new_scenario"]


# ---- text ----------------------------------------
# The scenario as text; each open question is a comment at its key.


class Page:
    """Lines of a scenario, with the questions that they ask."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.questions: list[Question] = []

    def add(self, *lines: str) -> None:
        """Append lines."""
        self.lines += lines

    def ask(self, question: str, *answers: str, stops: bool = False) -> None:
        """Append a question and the lines that answer it, as comments."""
        # A question stands directly above the lines that answer it.
        self.add(f"# QUESTION: {question}")
        self.questions.append(Question(len(self.lines) + 1, question, stops))
        self.add(*(f"# {answer}" for answer in answers))


def scenario_text(
    folder: Path, ready: Ready, ends: list[End], dividers: Sequence[Divider] = ()
) -> tuple[str, tuple[Question, ...]]:
    """Return the text of a scenario in a folder, and its questions; those that stop a run first."""
    # The order of the file: direction, surfaces, rules, then what is optional.
    page = Page()
    page.add("# Written by `geosurf new`. docs/scenario.md lists all keys.")
    page.add(f"title = {quoted(folder.resolve().name or 'Reservoir model')}", "")
    _direction(page, ready)
    for file in ready.of("model"):
        page.add("", "[model]", *_file(folder, file))
    # Faults that take part in a truncation are extended, both of them.
    joined = {name for end in ends if end.joined for name in (end.row.fault, end.row.other)}
    _surfaces(page, folder, ready, joined)
    _ends(page, ends)
    _compartments(page, dividers)
    _tear(page, ready)
    if ready.of("horizon") and not ready.asks_direction:
        _polygons(page, folder, ready)
    _others(page, folder, ready)
    left = ready.of(OUT)
    if left:
        page.add("", "# Files that are not used:")
        page.add(*(f"# {_path(folder, file.path)}: {file.note}" for file in left))
    # Those that stop a run first; the others in the order of the file.
    questions = sorted(page.questions, key=lambda question: not question.stops)
    return "\n".join(line.rstrip() for line in page.lines) + "\n", tuple(questions)


def _direction(page: Page, ready: Ready) -> None:
    """The direction and unit of all files that do not state theirs."""
    # Commented out: the scenario does not run before the user decides.
    if ready.asks_direction:
        page.ask(
            "is z depth or elevation? The files do not state it. Uncomment one line.",
            'positive = "down"  # z is depth',
            'positive = "up"    # z is elevation',
            stops=True,
        )
    elif ready.positive is not None:
        page.add(f'positive = "{ready.positive}"  # {_comment(ready.reason)}')
    elif ready.reason:
        page.add(f"# Direction of z: {_comment(ready.reason)}.")
    zones = [f"{a.name}/{b.name}" for a, b in pairwise(ready.of("horizon"))]
    if len(zones) > 1:
        listed = ", ".join(map(quoted, zones))
        page.add(f"# reservoir = [{listed}]  # name fewer, if not all are reservoir")
    # One unit for all silent files is written once, at the top.
    silent = [file for file in ready.of("horizon", "fault") if not file.states_unit]
    units = {file.length_unit for file in silent}
    if len(units) == 1 and None not in units:
        page.add(f'length_unit = "{units.pop()}"  # of z, as given with --length-unit')
        for file in ready.found:
            file.length_unit = None
    elif None in units:
        page.add('# length_unit = "ft"  # if z is in feet: these files do not state it')


def _surfaces(page: Page, folder: Path, ready: Ready, joined: set[str]) -> None:
    """Tables of horizons and faults; faults of a truncation reach across all horizons."""
    sides = ", ".join(f'"{side}"' for side in SIDES)
    for kind, table in (("horizon", "horizons"), ("fault", "faults")):
        files = ready.of(kind)
        # The order of horizons is the one thing that the user has to check.
        if files and kind == "horizon":
            page.add("", "# Horizons, youngest first.")
            page.add(*(f"# Note: {_comment(note)}." for note in ready.notes))
        for file in files:
            page.add("", f"[[{table}]]", f"name = {quoted(file.name)}", *_file(folder, file, ready))
            if file.kind == "fault" and file.in_file and file.in_file != file.name:
                page.add(f"name_in_file = {quoted(file.in_file)}")
            if file.piece:
                page.add(f"piece = {file.piece}  # of a mesh in several pieces, the largest first")
            if file.kind == "fault" and file.name in joined:
                page.add(f"extend = [{sides}]  # so that it is cut through, see truncations below")
            for answer, question in file.asks:
                page.ask(f"{_comment(question)}. If so, uncomment:", answer)


def _file(folder: Path, file: Found, ready: Ready | None = None) -> list[str]:
    """The keys of a file."""
    lines = [f"file = {quoted(_path(folder, file.path))}"]
    # Only where the file differs from the top of the scenario.
    if file.positive is not None and (ready is None or ready.positive is None):
        lines.append(f'positive = "{file.positive}"')
    if file.length_unit is not None:
        why = f"  # {_comment(file.why)}" if file.why else ""
        lines.append(f'length_unit = "{file.length_unit}"{why}')
    return lines


def _ends(page: Page, ends: list[End]) -> None:
    """Faults that end at others, or may."""
    for end in ends:
        row = end.row
        keys = [
            f"fault = {quoted(row.fault)}",
            f"main = {quoted(row.other)}",
            f'keep = "{row.keep}"',
            "extend = true",
        ]
        # Centimetres matter where faults nearly touch, metres elsewhere.
        gap = f"{row.distance:.0f}" if row.distance >= 1 else f"{row.distance:.2g}"
        short = f"{row.fault!r} stops {gap} m short of {row.other!r}"
        if end.joined:
            why = f"# {_comment(short)}, with {100 * end.share:.0f} % of its largest throw."
            page.add("", why, "[[truncations]]", *keys)
        else:
            page.add("")
            page.ask(
                f"does it end there? {_comment(short)}, with {100 * end.share:.0f} % of its "
                "largest throw.",
                "[[truncations]]", *keys,
            )  # fmt: skip


def _compartments(page: Page, dividers: Sequence[Divider]) -> None:
    """Faults that die inside the field, which may divide regions all the same."""
    # Geometry does not tell whether a field has regions on the two sides of such a fault.
    if not dividers:
        return
    dying = [repr(divider.fault) for divider in dividers if divider.walls]
    many = len(dying) > 1
    page.add("")
    page.ask(
        f"{' and '.join(filter(None, [', '.join(dying[:-1]), dying[-1]]))} "
        f"{'die' if many else 'dies'} inside the field and {'bound' if many else 'bounds'} no "
        f"block. {'Do they' if many else 'Does it'} separate regions? Virtual walls without throw "
        f"continue {'them' if many else 'it'}.",
        "[compartments]",
        *(
            f'{toml_key(divider.fault)} = "nearest"  # {_comment(divider.reason)}'
            for divider in dividers
        ),
    )


def _tear(page: Page, ready: Ready) -> None:
    """Grids and points that faults cross are torn there."""
    faults = ready.of("fault")
    horizons = ready.of("horizon")
    # Meshes are not torn: they have their cuts already.
    torn = [
        horizon
        for horizon in horizons
        if horizon.form == "points"
        or (
            horizon.form == "grid" and any(overlap_in_map(horizon.points, f.points) for f in faults)
        )
    ]
    if not torn:
        return
    how = "# Grids and points are continuous across faults: they are cut there."
    page.add("", how if faults else "# Points are gridded.", "[tear]")
    # Without a list [tear] takes all horizons.
    if len(torn) < len(horizons):
        page.add(f"horizons = [{', '.join(quoted(horizon.name) for horizon in torn)}]")


def _polygons(page: Page, folder: Path, ready: Ready) -> None:
    """Fault polygons, which may stand for faults, and whether these separate regions."""
    taken = {file.name for file in ready.of("horizon", "fault", "contact")}
    tear = [] if "[tear]" in page.lines else ["[tear]"]
    faults = []
    for file in ready.of("polygons"):
        horizon = nearest_horizon(ready, file)
        clouds = [other.elevations for other in ready.of("horizon")]
        lines = []
        for k, part in enumerate(file.parts, 1):
            # short names, since names of blocks consist of them
            name = f"P{k}" if f"P{k}" not in taken else f"{file.name} {k}"
            taken.add(name)
            faults.append(name)
            lines += ["[[faults]]", f"name = {quoted(name)}"]
            lines += _dip(part * [1.0, 1.0, file.scale], clouds)
            lines += (
                [] if file.positive is None or ready.positive else _file(folder, file, ready)[1:]
            )
            lines += ["[[faults.polygons]]", f"horizon = {quoted(horizon)}"]
            lines += [f"file = {quoted(_path(folder, file.path))}", f"polygon = {k}"]
        page.add("")
        page.ask(
            f"has {file.path.name} fault polygons of {horizon!r}? Each may be a fault, at which "
            "horizons are cut. Without them the model has no faults.",
            *lines, *tear,
        )  # fmt: skip
    if faults:
        page.add("")
        page.ask(
            "do these faults separate regions? One that dies inside the field bounds no block. "
            "Virtual walls without throw continue those that you uncomment here, too.",
            "[compartments]",
            *(f'{toml_key(name)} = "nearest"' for name in faults),
        )


def _dip(polygon: np.ndarray, horizons: list[np.ndarray]) -> list[str]:
    """The dip of a fault polygon, where horizons show one that the polygon does not have."""
    try:
        dips, flat = dips_in_horizons(polygon, horizons), dip_of_polygon(polygon)
    except SurfaceError:
        return []  # the run names what is wrong with the polygon
    if not len(dips) or abs(np.median(dips) - flat) <= SMEARED:
        return []
    low, dip, high = np.percentile(dips, [25, 50, 75])
    spread = f"{low:.0f} to {high:.0f} in half of the sections"
    why = f"from where the horizons are steep, {spread}; the gap of the polygon shows {flat:.0f}"
    return [f"dip = {dip:.0f}  # {why}"]


def _others(page: Page, folder: Path, ready: Ready) -> None:
    """Fluid contacts, well tops and an outline."""
    for file in ready.of("contact"):
        named = "named" in file.note
        lines = ["[[contacts]]", f"name = {quoted(file.name)}", *_file(folder, file, ready)]
        page.add("")
        if named:
            page.add(f"# {_comment(file.note)}: a fluid contact.", *lines)
        else:
            # A level grid may also be a horizon: the user decides.
            page.ask(f"is {file.path.name} a fluid contact? {_comment(file.note)}.", *lines)
    for file in ready.of("tops"):
        page.add("", "[tops]", *_file(folder, file, ready))
        page.add("# tie = true  # correct horizons smoothly so that they meet their tops")
    for file in ready.of("outline"):
        page.add("")
        page.ask(
            f"is {file.path.name} the area of the model? Without it: all that the horizons share.",
            "[aoi]",
            f"file = {quoted(_path(folder, file.path))}",
        )


def _path(folder: Path, path: Path) -> str:
    """A path relative to the scenario if both would be moved together, else an absolute one."""
    whole, home = path.resolve(), folder.resolve()
    try:
        relative = Path(os.path.relpath(whole, home))
    except ValueError:  # another drive
        return whole.as_posix()
    # One folder up is still the same project; farther away a relative path would break when moved.
    ups = sum(part == ".." for part in relative.parts)
    return relative.as_posix() if ups <= 1 else whole.as_posix()


def quoted(text: str) -> str:
    r"""A text as TOML writes it.

    Examples
    --------
    >>> print(quoted('Top "A"'))
    "Top \"A\""
    """
    body = "".join(
        # Control characters cannot stand in TOML text.
        f"\\u{ord(c):04X}" if ord(c) < 32 or ord(c) == 127 else {"\\": "\\\\", '"': '\\"'}.get(c, c)
        for c in text
    )
    return f'"{body}"'


def _comment(text: str) -> str:
    """A text that stays on its line."""
    return " ".join(text.split())


def table_text(files: Iterable[Found]) -> str:
    """How each file is used, for the console."""
    # The same words as in the scenario, one line per file.
    rows = [("file", "used as", "name", "why")]
    for file in files:
        what = file.kind if file.kind in (OUT, file.form) else f"{file.kind} ({file.form})"
        rows.append(
            (file.path.name, what, "" if file.kind == OUT else file.name, _comment(file.note))
        )
    widths = [max(len(row[k]) for row in rows) for k in range(3)]
    return "\n".join(
        "  ".join([*(row[k].ljust(widths[k]) for k in range(3)), row[3]]).rstrip() for row in rows
    )
