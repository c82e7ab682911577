"""The scenario as text; each open question is a comment at its key."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

from geosurf.conventions import toml_key
from geosurf.scenario.new.judge import OUT, Found, Question, Ready, nearest_horizon, overlap_in_map
from geosurf.scenario.new.network import SIDES, Divider, End


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
    for one in ready.of("model"):
        page.add("", "[model]", *_file(folder, one))
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
        page.add(*(f"# {_path(folder, one.path)}: {one.note}" for one in left))
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
    silent = [one for one in ready.of("horizon", "fault") if not one.states_unit]
    units = {one.length_unit for one in silent}
    if len(units) == 1 and None not in units:
        page.add(f'length_unit = "{units.pop()}"  # of z, as given with --length-unit')
        for one in ready.found:
            one.length_unit = None
    elif None in units:
        page.add('# length_unit = "ft"  # if z is in feet: these files do not state it')


def _surfaces(page: Page, folder: Path, ready: Ready, joined: set[str]) -> None:
    """Tables of horizons and faults; faults of a truncation reach across all horizons."""
    sides = ", ".join(f'"{side}"' for side in SIDES)
    for kind, table in (("horizon", "horizons"), ("fault", "faults")):
        found = ready.of(kind)
        # The order of horizons is the one thing that the user has to check.
        if found and kind == "horizon":
            page.add("", "# Horizons, youngest first.")
            page.add(*(f"# Note: {_comment(note)}." for note in ready.notes))
        for one in found:
            page.add("", f"[[{table}]]", f"name = {quoted(one.name)}", *_file(folder, one, ready))
            if one.kind == "fault" and one.in_file and one.in_file != one.name:
                page.add(f"name_in_file = {quoted(one.in_file)}")
            if one.piece:
                page.add(f"piece = {one.piece}  # of a mesh in several pieces, the largest first")
            if one.kind == "fault" and one.name in joined:
                page.add(f"extend = [{sides}]  # so that it is cut through, see truncations below")
            for answer, question in one.asks:
                page.ask(f"{_comment(question)}. If so, uncomment:", answer)


def _file(folder: Path, one: Found, ready: Ready | None = None) -> list[str]:
    """The keys of a file."""
    lines = [f"file = {quoted(_path(folder, one.path))}"]
    # Only where the file differs from the top of the scenario.
    if one.positive is not None and (ready is None or ready.positive is None):
        lines.append(f'positive = "{one.positive}"')
    if one.length_unit is not None:
        why = f"  # {_comment(one.why)}" if one.why else ""
        lines.append(f'length_unit = "{one.length_unit}"{why}')
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
    dying = [repr(one.fault) for one in dividers if one.walls]
    many = len(dying) > 1
    page.add("")
    page.ask(
        f"{' and '.join(filter(None, [', '.join(dying[:-1]), dying[-1]]))} "
        f"{'die' if many else 'dies'} inside the field and {'bound' if many else 'bounds'} no "
        f"block. {'Do they' if many else 'Does it'} separate regions? Virtual walls without throw "
        f"continue {'them' if many else 'it'}.",
        "[compartments]",
        *(f'{toml_key(one.fault)} = "nearest"  # {_comment(one.reason)}' for one in dividers),
    )


def _tear(page: Page, ready: Ready) -> None:
    """Grids and points that faults cross are torn there."""
    faults = ready.of("fault")
    horizons = ready.of("horizon")
    # Meshes are not torn: they have their cuts already.
    torn = [
        one
        for one in horizons
        if one.form == "points"
        or (one.form == "grid" and any(overlap_in_map(one.points, f.points) for f in faults))
    ]
    if not torn:
        return
    how = "# Grids and points are continuous across faults: they are cut there."
    page.add("", how if faults else "# Points are gridded.", "[tear]")
    # Without a list [tear] takes all horizons.
    if len(torn) < len(horizons):
        page.add(f"horizons = [{', '.join(quoted(one.name) for one in torn)}]")


def _polygons(page: Page, folder: Path, ready: Ready) -> None:
    """Fault polygons, which may stand for faults."""
    taken = {one.name for one in ready.of("horizon", "fault", "contact")}
    for one in ready.of("polygons"):
        horizon = nearest_horizon(ready, one)
        lines = []
        for k in range(1, len(one.parts) + 1):
            # short names, since names of blocks consist of them
            name = f"P{k}" if f"P{k}" not in taken else f"{one.name} {k}"
            taken.add(name)
            lines += ["[[faults]]", f"name = {quoted(name)}"]
            lines += [] if one.positive is None or ready.positive else _file(folder, one, ready)[1:]
            lines += ["[[faults.polygons]]", f"horizon = {quoted(horizon)}"]
            lines += [f"file = {quoted(_path(folder, one.path))}", f"polygon = {k}"]
        page.add("")
        page.ask(
            f"has {one.path.name} fault polygons of {horizon!r}? Each may be a fault, at which "
            "horizons are cut. Without them the model has no faults.",
            *lines, "[tear]",
        )  # fmt: skip


def _others(page: Page, folder: Path, ready: Ready) -> None:
    """Fluid contacts, well tops and an outline."""
    for one in ready.of("contact"):
        named = "named" in one.note
        lines = ["[[contacts]]", f"name = {quoted(one.name)}", *_file(folder, one, ready)]
        page.add("")
        if named:
            page.add(f"# {_comment(one.note)}: a fluid contact.", *lines)
        else:
            # A level grid may also be a horizon: the user decides.
            page.ask(f"is {one.path.name} a fluid contact? {_comment(one.note)}.", *lines)
    for one in ready.of("tops"):
        page.add("", "[tops]", *_file(folder, one, ready))
        page.add("# tie = true  # correct horizons smoothly so that they meet their tops")
    for one in ready.of("outline"):
        page.add("")
        page.ask(
            f"is {one.path.name} the area of the model? Without it: all that the horizons share.",
            "[aoi]",
            f"file = {quoted(_path(folder, one.path))}",
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


def table_text(found: Iterable[Found]) -> str:
    """How each file is used, for the console."""
    # The same words as in the scenario, one line per file.
    rows = [("file", "used as", "name", "why")]
    for one in found:
        what = one.kind if one.kind in (OUT, one.form) else f"{one.kind} ({one.form})"
        rows.append((one.path.name, what, "" if one.kind == OUT else one.name, _comment(one.note)))
    widths = [max(len(row[k]) for row in rows) for k in range(3)]
    return "\n".join(
        "  ".join([*(row[k].ljust(widths[k]) for k in range(3)), row[3]]).rstrip() for row in rows
    )
