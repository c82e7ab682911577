"""All tables and pictures as one HTML page, and tables as lines of text."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.stats import count_text, metres_text, seconds_text
from geosurf.report.page import (
    NOTHING,
    Section,
    Table,
    fill_page,
    html_pictures,
    html_table,
    paragraph,
)

Row = dict[str, Any]
WAITED = 1.3  # wall clock over processor time, from which on others were at work
TITLES = {
    "error": "Run time against error",
    "growth": "Cost against size",
    "questions": "Run time against what is asked",
    "targets": "Targets",
}
WORDS = {
    "error": (
        "A smooth horizon and a smooth fault whose true curve and volumes are known. The error of "
        "a curve is its Hausdorff distance to the true one, the larger of both ways; that of units "
        "the largest relative error of a volume. Lower left is better. Methods of search give the "
        "same curve, so they differ in time only."
    ),
    "growth": (
        "Noisy hills and one listric fault. geosurf starts from two grids (kept search: from "
        "surfaces that were intersected before), other packages from arrays and meshes of "
        "their own that were made beside the clock. Memory is the peak of what was resident, less "
        "what was resident before the call. Exponents are fitted to the larger half of the sizes."
    ),
    "questions": (
        "Two horizons, one fault and a box. Each question is put to a fresh scene, from grids."
    ),
    "targets": (
        "faster: their time over ours, at least as asked. slower: our time over theirs, at most. "
        "exponent: of our time over two decades, at most. per edge: our microseconds for each "
        "edge, at most. memory: the inputs and the peak beyond them over the inputs, at most."
    ),
}
PICTURES = {
    "error": "Run time against error. Hollow: a wrong answer.",
    "growth": "Run time and memory against the number of triangles. Hollow: a wrong answer.",
    "questions": "Run time against what is asked; thin lines go from the fastest to the slowest.",
}


def tables_of(name: str, found: dict[str, Any]) -> Table:
    """Return one of the four tables as words.

    Parameters
    ----------
    name : str
        A key of `TITLES`.
    found : dict
        As measured.

    Returns
    -------
    Table
    """
    return _LAYOUT[name](found)


def _state(row: Row) -> str:
    if row["error"]:
        return row["error"]
    state = "wrong: " + "; ".join(row["wrong"]) if row["wrong"] else "right"
    waited = row["seconds"] > WAITED * row["cpu_seconds"] and row["seconds"] > 0.01
    return f"{state}; waited for the core" if waited else state


def _time(row: Row) -> tuple[str, str]:
    if row["error"]:
        return NOTHING, NOTHING
    spread = f"{seconds_text(row['fastest'])} to {seconds_text(row['slowest'])}, {row['repeats']} x"
    return seconds_text(row["seconds"]), spread if row["repeats"] > 1 else "once"


def _count(row: Row) -> str:
    return count_text(row.get("triangles", row["size"]))


def _errors(found: dict[str, Any]) -> Table:
    rows = []
    for row in found["rows"]:
        reached = NOTHING
        if "error_m" in row:
            reached = metres_text(row["error_m"])
        elif "volume_error" in row:
            reached = f"{row['volume_error']:.1e}"
        asked = row["options"].get("tolerance")
        route = row["route"] + (f", {metres_text(asked)}" if asked else "")
        result = "units" if row["task"] == "units" else "curve"
        rows.append((route, result, _count(row), *_time(row), reached, _state(row)))
    head = ("Route", "Result", "Triangles", "Time", "Spread", "Error", "Answer")
    return Table(head, tuple(rows), n_label=2, n_remark=1)


def _growth(found: dict[str, Any]) -> Table:
    rows = []
    for row in found["rows"]:
        powers = found["exponents"].get(row["series"], {})
        power = [f"{powers[k]:.2f}" if k in powers else NOTHING for k in ("seconds", "extra_bytes")]
        memory = (NOTHING, NOTHING)
        if not row["error"]:
            memory = f"{row['extra_bytes'] / 1e6:.1f} MB", f"{row['times_input']:.1f} x"
        rows.append((row["series"], _count(row), *_time(row), *memory, *power, _state(row)))
    head = ("Call", "Triangles", "Time", "Spread", "Memory", "of inputs", "n^ time", "n^ memory",
            "Answer")  # fmt: skip
    return Table(head, tuple(rows), n_remark=1)


def _questions(found: dict[str, Any]) -> Table:
    rows = [(row["asked"], _count(row), *_time(row), _state(row)) for row in found["rows"]]
    head = ("Asked", "Triangles", "Time", "Spread", "Answer")
    return Table(head, tuple(rows), n_remark=1)


def _number(value: float | None) -> str:
    return NOTHING if value is None else f"{value:g}"


def _targets(found: dict[str, Any]) -> Table:
    rows = []
    for row in found["rows"]:
        met = {True: "met", False: "not met", None: NOTHING}[row["met"]]
        ratio = NOTHING if row["ratio"] is None else f"{row['ratio']:.3g}"
        asked = row["asked"] if isinstance(row["asked"], str) else _number(row["asked"])
        theirs = " ".join(filter(None, [row["theirs"], row.get("peer", "")])) or NOTHING
        rows.append((row["name"], row["what"], row["ours"] or NOTHING, theirs, row["kind"],
                     row["why"] or NOTHING, ratio, asked, met))  # fmt: skip
    head = ("Target", "What", "geosurf", "The other", "Kind", "Remark", "Ratio", "Asked", "Met")
    return Table(head, tuple(rows), n_label=6)


_LAYOUT = {"error": _errors, "growth": _growth, "questions": _questions, "targets": _targets}


def text_table(table: Table) -> list[str]:
    """Return a table as lines of text with aligned columns.

    Examples
    --------
    >>> text_table(Table(("Call", "Time"), (("curve", "2 s"), ("split", "13 s"))))
    ['Call   Time', 'curve   2 s', 'split  13 s']
    """
    rows = [table.head, *table.rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = [
            cell.ljust(width) if table.holds_words(k) else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return lines


def machine_lines(machine: dict[str, Any], settings: dict[str, Any]) -> list[str]:
    """Return what was measured on, and how, in sentences."""
    versions = ", ".join(f"{k} {v}" for k, v in machine["versions"].items())
    there = [f"{k} {v}" for k, v in machine["peers"].items() if v]
    missing = [k for k, v in machine["peers"].items() if not v]
    load = machine["load"]
    system = f"{machine['system']}, Python {machine['python']}"
    repeats = f"{settings['repeats']} repeats or more within {settings['budget']:g} s"
    lines = [
        f"{machine['processor']}, {machine['cores']} cores, {machine['memory_gb']:g} GB, {system}.",
        f"{versions}.",
        f"Peers: {', '.join(there) or 'none'}; not installed: {', '.join(missing) or 'none'}.",
        f"Pinned to core {settings['core']}; {repeats}, the median counts.",
        f"A measurement is given up after {settings['limit']:g} s.",
    ]
    if settings["quick"]:
        lines.append("Quick: one cold call of each on tiny sizes. These times measure nothing.")
    if load:
        busy = " The machine was busy: do not trust these times." if load[0] > 0.5 else ""
        lines.append(f"Load before: {', '.join(f'{x:.2f}' for x in load)}.{busy}")
    return lines


def write_page(found: dict[str, Any], folder: Path) -> str:
    """Return the page of all that was measured, with the pictures of a folder inside.

    Parameters
    ----------
    found : dict
        What `run_bench` writes as JSON.
    folder : Path
        Holds ``bench_error.png`` and its like.

    Returns
    -------
    str
    """
    header = "".join(
        paragraph(line, "faint") for line in machine_lines(found["machine"], found["settings"])
    )
    for sentence in found["wrong"]:
        header += paragraph(f"WRONG: {sentence}", "verdict failed")
    sections = []
    for name, table in found["tables"].items():
        body = paragraph(WORDS[name])
        body += "".join(paragraph(note, "faint") for note in table["notes"])
        if name in PICTURES:
            body += html_pictures({PICTURES[name]: folder / f"bench_{name}.png"})
        sections.append(Section(TITLES[name], body + html_table(tables_of(name, table))))
    return fill_page("geosurf: benchmarks", header, sections)
