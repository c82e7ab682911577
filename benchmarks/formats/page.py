"""The format matrix as a page of the documentation."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.formats.round_trips import Row
from benchmarks.formats.speed import Timing

HEAD = """# The format matrix

**What.** Every kind of object is written in every format that `gs.write` knows, read back by
geosurf, and opened by other packages. Difference: the largest distance between a place that was
written and the nearest one that was read, in both directions. Loss: what the writer lists.

**Command.** `python -m benchmarks.formats --peer PYTHON -o docs/validation/formats.md`, where
PYTHON is an interpreter with the other packages; `--peer` may be repeated. `--keep FOLDER` lets a
run that was ended go on. Times are processor
times, the best of three.

**When.** {date}. Other packages: {peers}.
"""
KINDS = """
## Written

Maps have a rim and a hole without values; they are rotated by 30 degrees where the format has a
rotation. `no peer` means that none of the packages above reads the format.

| object | suffix | read back with | difference [m] | other packages: difference [m] | loss |
|---|---|---|---|---|---|
"""
HOSTILE = """
## Hostile objects

Maps of one node, without values, with values that formats take for undefined, with odd axes;
surfaces with odd names and data; lines and points that end files. Each comes back, or is refused
in a sentence and leaves no file.

| object | suffixes | came back | refused | wrong |
|---|---|---|---|---|
"""
DAMAGED = """
## Hostile files

Each file above is changed: line ends of Windows, a byte order mark, a blank line at its end; and
cut in the middle, cut at the end of a line, a letter in a number, zero bytes, UTF-16, nothing. It
reads as before, or is refused in a sentence. A file of points or triangles without counts that is
cut at the end of a line reads as fewer of them, which nobody can notice.

| object | suffixes | read as before | refused | differs |
|---|---|---|---|---|
"""
FIELD = """
## Files of others

Each file of the [real fields](real_fields.md) and small GOCAD files, as `gs.info` names it, read by
geosurf and by others with z as it stands in the file.

| format | read with | files | other packages: difference [m] |
|---|---|---|---|
"""
SPEED = """
## Speed

Maps of 1000 x 1000 nodes (rotated where the format has a rotation) and a mesh of 1 000 000
triangles, all numbers with 16 digits. Asked: for writing and reading together. Ratio: the time of
the other package to read the same file, over that of geosurf. Memory: the peak while writing and
while reading, over the arrays.

| suffix | write [s] | read [s] | asked [s] | other | its read [s] | ratio | memory: write | read |
|---|---|---|---|---|---|---|---|---|
"""


def page(
    rows: Sequence[Row],
    hostile: Sequence[tuple[str, str, int, int, list[str]]],
    damaged: Sequence[tuple[str, str, int, int, list[str]]],
    field: Sequence[tuple[str, ...]],
    speed: Sequence[Timing],
    peers: Sequence[str],
    date: str,
) -> str:
    """Return the page in Markdown."""
    parts = [HEAD.format(date=date, peers=", ".join(peers) or "none")]
    parts += [KINDS, *_written(rows)]
    parts += [HOSTILE, *_by_object(hostile)]
    parts += [DAMAGED, *_by_object(damaged)]
    parts += [FIELD, *_by_format(field)] if field else []
    parts += [SPEED, *(_speed(one) for one in speed)]
    return "".join(parts)


def _written(rows: Sequence[Row]) -> list[str]:
    """Rows of what is written; suffixes with the same results share one."""
    suffixes: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        suffixes.setdefault((row.kind, _results(row)), []).append(f"`{row.suffix}`")
    return [
        f"| {kind} | {' '.join(some)} | {words} |\n" for (kind, words), some in suffixes.items()
    ]


def _results(row: Row) -> str:
    """The results of one row of what is written."""
    if row.missing:
        return f"needs {row.missing} | | | "
    peers = "; ".join(f"{name} {_difference(value)}" for name, value in row.peers.items())
    lost = ", ".join(dict.fromkeys(one.what for one in row.lost)) or "none"
    back = "" if row.back is None else _difference(row.back)
    function = f"`{row.read_with}`" if row.read_with else "not read"
    return f"{function} | {back} | {peers or 'no peer'} | {lost}"


def _difference(value: float | str) -> str:
    """A difference in metres, or the answer of another package."""
    if isinstance(value, str):
        first = " ".join(value.split()).split(": ")[0]
        return value if value == "opens" else f"refuses ({first})"
    return "0" if value == 0 else f"{value:.1e}"


def _by_object(rows: Sequence[tuple[str, str, int, int, list[str]]]) -> list[str]:
    """One row for each kind of object, summed over its suffixes."""
    lines = []
    for kind in dict.fromkeys(row[0] for row in rows):
        mine = [row for row in rows if row[0] == kind]
        back, refused = (sum(row[k] for row in mine) for k in (2, 3))
        wrong = [f"{row[1]} {one}".replace("|", " ") for row in mine for one in row[4]]
        words = "; ".join(" ".join(one.split())[:120] for one in wrong) or "0"
        lines.append(f"| {kind} | {len(mine)} | {back} | {refused} | {words} |\n")
    return lines


def _by_format(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """One row for each format of other people's files, and reader."""
    lines = []
    for kind in dict.fromkeys(row[1:3] for row in rows):
        mine = [row for row in rows if row[1:3] == kind]
        peers = "; ".join(dict.fromkeys(row[4] for row in mine if row[4]))
        lines.append(f"| {kind[0]} | {kind[1]} | {len(mine)} | {peers} |\n")
    return lines


def _speed(one: Timing) -> str:
    """One row of times."""
    asked = "" if one.asked is None else f"{one.asked:g}"
    theirs, ratio = "", ""
    if one.peer_read is not None:
        theirs, ratio = f"{one.peer_read:.2f}", f"{one.peer_read / max(one.read, 1e-9):.1f}"
    return (
        f"| `{one.suffix}` | {one.write:.2f} | {one.read:.2f} | {asked} "
        f"| {one.peer or 'no peer'} | {theirs} | {ratio} "
        f"| {one.memory:.1f} | {one.read_memory:.1f} |\n"
    )


__all__ = ["page"]
