"""Layouts of files of well paths -> names of columns, rows of words, and what the header states.

Four are recognised by their content:

- well traces of Petrel (``# WELL TRACE FROM PETREL``);
- wells of RMS: four lines or more of a header, then x, y, z and logs;
- wells of ResInsight: a name before the rows x, y, TVD, MD of each well;
- tables with one line of column names, of one well or several.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

from geosurf.errors import FormatError
from geosurf.read._common import is_number, number, read_text
from geosurf.read._detect import detect
from geosurf.read._tops_layout import COMMENTS, layout_of, plain_name
from geosurf.read.wells.names import USUAL

Rows = list[tuple[int, list[str]]]
NAME = re.compile(r"#\s*WELL NAME:\s*(.*)", re.I)
HEAD = re.compile(r"#\s*WELL HEAD ([XY])-COORDINATE:\s*(\S+)\s*(?:\(([^)]*)\))?", re.I)
DATUM = re.compile(r"#\s*WELL DATUM[^:]*:\s*(\S+)\s*(?:\(([^)]*)\))?", re.I)
SYSTEM = re.compile(r"#\s*XYZ TRACE IS GIVEN IN COORDINATE SYSTEM\s*(.*)", re.I)
DEPTHS = re.compile(r"#\s*DEPTH\b.*\bGIVEN IN (\w+)-UNITS", re.I)
# a line that begins a well of ResInsight: the name stands in quotes or behind the word
SECTION = re.compile(r"\s*(?:well\s*)?name\b\s*:?\s*(.*)", re.I)
QUOTED = re.compile(r"[\"'`\u2018\u2019\u00b4](.+?)[\"'`\u2018\u2019\u00b4]")


@dataclass(frozen=True)
class Trace:
    """
    A file of well paths, taken apart.

    Attributes
    ----------
    kind : str
        What the file is, in words.
    header : list of str
        Names of the columns, as they are written.
    rows : list of (int, list of str)
        Line number from 1, and its words.
    well : str or None
        Name of the only well, if the file states it.
    head : dict of str to float
        What the header states of the place with measured depth 0: ``x``, ``y``, ``z`` (elevation),
        in units of the file.
    units : dict of str to str
        Of ``xy`` and of ``z``, if the file states them.
    positive : str or None
        Direction of z, if the format states it.
    crs : str or None
    """

    kind: str
    header: list[str]
    rows: Rows
    well: str | None = None
    head: dict[str, float] | None = None
    units: dict[str, str] | None = None
    positive: str | None = None
    crs: str | None = None


def trace_of(path: Path, decimal: str, numbered: bool) -> Trace:
    """
    Return what a file of well paths holds, in words.

    Parameters
    ----------
    path : pathlib.Path
    decimal : {".", ","}
    numbered : bool
        Whether the caller gives columns by their numbers, so that no header is needed.

    Raises
    ------
    FormatError
        If the file has no header, no rows, or a row that does not fit.
    """
    key = detect(path)
    if key == "rms_well":
        return _rms(path)
    lines = read_text(path).split("\n")
    if key == "petrel_well":
        return _petrel(path, lines)
    if begins_with_name(lines):
        return _sections(path, lines)
    layout = layout_of(path, decimal)
    header = layout.header or _commented_header(lines)
    if header is None and not numbered:
        line, words = layout.rows[0]
        raise FormatError(
            f"{path}, line {line}: the file has no line with names of columns, and the line has "
            f"{len(words)} values. Give the columns, counted from 1, as in columns={{'md': 1, "
            "'x': 2, 'y': 3, 'z': 4}."
        )
    found = Trace("table", header or [], layout.rows)
    _check_widths(path, found)
    return found


def _commented_header(lines: list[str]) -> list[str] | None:
    """Names of columns in the last comment before the rows, as in ``# MD INC AZI``."""
    last: str | None = None
    for line in lines:
        text = line.strip()
        if text and not text.startswith(COMMENTS):
            break
        last = text.lstrip("#!- ") or last
    words = (last or "").replace(",", " ").replace(";", " ").split()
    known = [word for word in words if any(plain_name(word) in names for names in USUAL.values())]
    return words if len(known) >= 3 else None


def _check_widths(path: Path, found: Trace) -> None:
    """Refuse rows that are shorter or longer than the header."""
    for line, words in found.rows:
        if found.header and len(words) != len(found.header):
            raise FormatError(
                f"{path}, line {line}: found {len(words)} values, expected {len(found.header)} as "
                f"the columns {', '.join(found.header)}. Correct that line or export the file "
                "again."
            )


# ----------------------------------------------------------------------- Petrel
def _petrel(path: Path, lines: list[str]) -> Trace:
    """A well trace of Petrel: comments, a line of names between two rulers, and rows."""
    head: dict[str, float] = {}
    units: dict[str, str] = {}
    found = Trace("well trace of Petrel", [], [], head=head, units=units)
    for i, line in enumerate(lines, start=1):
        text = line.strip()
        if match := NAME.match(text):
            found = replace(found, well=match[1].strip().strip("\"'") or None)
        elif match := HEAD.match(text):
            head[match[1].lower()] = number(match[2], path, i, "place of the well head")
            units["xy"] = (match[3] or units.get("xy", "m")).strip().lower()
        elif match := DATUM.match(text):
            head["z"] = number(match[1], path, i, "elevation of the well datum")
            units.setdefault("z", (match[2] or "m").strip().lower())
        elif match := SYSTEM.match(text):
            found = replace(found, crs=match[1].strip() or None)
        elif match := DEPTHS.match(text):
            units["z"] = match[1].lower()
        elif text and not text.startswith(("#", "===")):
            words = text.split()
            if found.header:
                found.rows.append((i, words))
            else:
                found.header.extend(words)
    if not found.rows or any(map(is_number, found.header)):
        raise FormatError(
            f"{path}: the well trace has no line with names of columns and rows below it, such as "
            "'MD X Y Z TVD DX DY AZIM_TN INCL DLS AZIM_GN'. Export it again."
        )
    _check_widths(path, found)
    return found


# -------------------------------------------------------------------------- RMS
def _rms(path: Path) -> Trace:
    """A well of RMS: version, kind, name and place, number of logs, one line for each, rows."""
    lines = [line.strip() for line in read_text(path).split("\n")]
    words = lines[2].split()
    # name, x, y and perhaps the elevation of the rig; names may have blanks, and end with a number
    n = len(words) - (3 if len(words) > 3 and is_number(words[-3]) else 2)
    count = int(lines[3])
    logs = [line.split()[0] if line else "" for line in lines[4 : 4 + count]]
    if len(logs) < count or not all(logs):
        raise FormatError(
            f"{path}, line 4: the header announces {count} logs, but not each has a line. Export "
            "the well again."
        )
    rows = [(i, text.split()) for i, text in enumerate(lines, start=1) if text and i > 4 + count]
    found = Trace("well of RMS", ["x", "y", "z", *logs], rows, " ".join(words[:n]))
    if not rows:
        raise FormatError(f"{path}: the well has no points below its header. Export it again.")
    _check_widths(path, found)
    return found


# ------------------------------------------------------------------- ResInsight
def begins_with_name(lines: list[str]) -> bool:
    """Return whether a text has the name of a well before its first row of numbers."""
    for line in lines[:50]:
        if _section(line) is not None:
            return True
        if line.strip()[:1] in "+-.0123456789" and line.strip():
            return False
    return False


def _section(line: str) -> str | None:
    """The name in a line that begins a well, or None."""
    match = SECTION.fullmatch(line)
    if match is None or any(sign in line for sign in ",;\t"):
        return None
    quoted = QUOTED.search(match[1])
    name = quoted[1] if quoted else match[1]
    # names of columns may begin alike
    is_header = not quoted and any(plain_name(word) in USUAL["md"] for word in name.split())
    return None if is_header else name.strip() or None


def _sections(path: Path, lines: list[str]) -> Trace:
    """Wells of ResInsight: a name, then x, y, TVD (depth below sea level) and MD on each line."""
    rows: Rows = []
    well: str | None = None
    for i, line in enumerate(lines, start=1):
        name = _section(line)
        words = line.split()
        if name is not None:
            well = name
        elif not words or not is_number(words[0]) or words == ["-999"]:
            continue  # comments, names of columns, and the end of a well
        elif well is None or len(words) != 4:
            raise FormatError(
                f"{path}, line {i}: found {len(words)} values, expected x, y, TVD and MD below the "
                "name of a well. Correct that line or export the file again."
            )
        else:
            rows.append((i, [well, *words]))
    if not rows:
        raise FormatError(f"{path}: the wells have no points. Export the file again.")
    header = ["well", "x", "y", "z", "md"]
    return Trace("wells of ResInsight", header, rows, positive="down")


__all__ = ["Trace", "begins_with_name", "trace_of"]
