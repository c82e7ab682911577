"""Which columns of a file hold the paths of wells, and their numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import check_word, did_you_mean, metres_per_unit, real_numbers
from geosurf.errors import FormatError, InputError
from geosurf.read._common import is_number, noted, number, number_rows, read_text, with_point
from geosurf.read._guard import damaged
from geosurf.read._table import one_column
from geosurf.read.registry import detect
from geosurf.read.tops import USUAL as OF_TOPS
from geosurf.read.tops import check_widths, layout_of, plain_name, unit_in_name

# ---- names ----------------------------------------
# Usual names of the columns of well paths: lower case, letters and digits only.


USUAL: dict[str, tuple[str, ...]] = {
    "well": (*OF_TOPS["well"], "wlbwellborename"),
    "x": OF_TOPS["x"],
    "y": OF_TOPS["y"],
    "z": (*OF_TOPS["z"], "tvdmsl"),
    "datum": ("kb", "rkb", "rt", "datum", "kbelevation", "rkbelevation", "gl", "groundlevel"),
    "md": ("md", "mdepth", "mdrkb", "mdmsl", "measureddepth", "mdkb"),
    "inclination": ("inc", "incl", "inclination", "deviation", "devi", "dev", "incdeg", "incldeg"),
    "azimuth": (
        "azi", "azim", "azimuth", "azimgn", "azigrid", "azimuthgn", "azimuthgrid", "gridazimuth",
        "azideg",
    ),
}  # fmt: skip
HORIZON = OF_TOPS["horizon"]


# ---- layouts ----------------------------------------
# Layouts of files of well paths -> names of columns, rows of words, and what the header states.
#
# Four are recognised by their content:
#
# - well traces of Petrel (``# WELL TRACE FROM PETREL``);
# - wells of RMS: four lines or more of a header, then x, y, z and logs;
# - wells of ResInsight: a name before the rows x, y, TVD, MD of each well;
# - tables with one line of column names, of one well or several.


Rows = list[tuple[int, list[str]]]
NAME = re.compile(r"#\s*WELL NAME:\s*(.*)", re.I)
HEAD = re.compile(r"#\s*WELL HEAD ([XY])-COORDINATE:\s*(\S+)\s*(?:\(([^)]*)\))?", re.I)
DATUM = re.compile(r"#\s*WELL (?:DATUM|KB)\b[^:]*:\s*(\S+)\s*(?:\(([^)]*)\))?", re.I)
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
    trace = _taken_apart(path, decimal, numbered)
    if not trace.rows:
        raise damaged(f"{path}: the file has no points of wells")
    check_widths(path, trace.header, trace.rows)
    return trace


def _taken_apart(path: Path, decimal: str, numbered: bool) -> Trace:
    """The file as it is, by its layout."""
    key = detect(path)
    if key == "rms_well":
        return _rms(path)
    lines = read_text(path).split("\n")
    if key == "petrel_well":
        return _petrel(path, lines)
    if begins_with_name(lines):
        return _sections(path, lines)
    layout = layout_of(path, decimal)
    if layout.header is None and not numbered:
        line, words = layout.rows[0]
        raise FormatError(
            f"{path}, line {line}: the file has no line with names of columns, and the line has "
            f"{len(words)} values. Give the columns, counted from 1, as in columns={{'md': 1, "
            "'x': 2, 'y': 3, 'z': 4}."
        )
    return Trace("table", layout.header or [], layout.rows)


# ----------------------------------------------------------------------- Petrel
def _petrel(path: Path, lines: list[str]) -> Trace:
    """A well trace of Petrel: comments, a line of names between two rulers, and rows."""
    head: dict[str, float] = {}
    units: dict[str, str] = {}
    trace = Trace("well trace of Petrel", [], [], head=head, units=units)
    for i, line in enumerate(lines, start=1):
        text = line.strip()
        if match := NAME.match(text):
            trace = replace(trace, well=match[1].strip().strip("\"'") or None)
        elif match := HEAD.match(text):
            head[match[1].lower()] = number(match[2], path, i, "place of the well head")
            units["xy"] = (match[3] or units.get("xy", "m")).strip().lower()
        elif match := DATUM.match(text):
            head["z"] = number(match[1], path, i, "elevation of the well datum")
            units.setdefault("z", (match[2] or "m").strip().lower())
        elif match := SYSTEM.match(text):
            trace = replace(trace, crs=match[1].strip() or None)
        elif match := DEPTHS.match(text):
            units["z"] = match[1].lower()
        elif text and not text.startswith(("#", "===")):
            words = text.split()
            if trace.header:
                trace.rows.append((i, words))
            else:
                trace.header.extend(words)
    if not trace.rows or any(map(is_number, trace.header)):
        raise damaged(
            f"{path}: the well trace has no line with names of columns and rows below it, such as "
            "'MD X Y Z TVD DX DY AZIM_TN INCL DLS AZIM_GN'"
        )
    return trace


# -------------------------------------------------------------------------- RMS
def _rms(path: Path) -> Trace:
    """Wells of RMS, one below the other: version, kind, name and place, count of logs, a line for
    each, and rows. The version and kind of further wells may be left out.
    """
    lines = [line.split() for line in read_text(path).split("\n")]
    wells: list[tuple[str, list[str], Rows]] = []
    at = 2
    while at < len(lines):
        # name, x, y and perhaps the elevation of the rig; names may have blanks, and end by number
        words = lines[at]
        n = len(words) - (3 if len(words) > 3 and is_number(words[-3]) else 2)
        count = int(lines[at + 1][0])
        logs = [words[0] for words in lines[at + 2 : at + 2 + count] if words]
        if len(logs) < count:
            raise damaged(
                f"{path}, line {at + 2}: the header announces {count} logs, but not each has a line"
            )
        first = at = at + 2 + count
        while at < len(lines) and not _begins_well(lines, at):
            at += 1
        rows = [(i + 1, lines[i]) for i in range(first, at) if lines[i]]
        header = ["x", "y", "z", *logs]
        check_widths(path, header, rows)
        if len(words) - n == 3:  # the elevation of the rig goes along as a column
            header, rows = [*header, "kb"], [(line, [*row, words[-1]]) for line, row in rows]
        wells.append((" ".join(words[:n]), header, rows))
        at += 2 * (at < len(lines) and len(lines[at]) == 1)

    # columns that all wells have, by name: each well has logs of its own
    common = [word for word in wells[0][1] if all(word in header for _, header, _ in wells)]
    rows_with_names = [
        (line, [name, *(row[header.index(word)] for word in common)])
        for name, header, rows in wells
        for line, row in rows
    ]
    return Trace("well of RMS", ["well", *common], rows_with_names)


def _begins_well(lines: list[list[str]], at: int) -> bool:
    """Whether a well of RMS begins on a line: by its version and kind, or by its name and place."""
    at += 2 * (len(lines[at]) == 1 and is_number(lines[at][0]))
    if at + 1 >= len(lines) or len(lines[at]) < 3 or len(lines[at + 1]) != 1:
        return False
    words, count = lines[at], lines[at + 1][0]
    return not is_number(words[0]) and all(map(is_number, words[-2:])) and count.isdecimal()


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
    match = SECTION.fullmatch(line.rstrip())
    if match is None or any(sign in match[1] for sign in ",;\t"):
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
            raise damaged(
                f"{path}, line {i}: found {len(words)} values, expected x, y, TVD and MD below the "
                "name of a well"
            )
        else:
            rows.append((i, [well, *words]))
    header = ["well", "x", "y", "z", "md"]
    return Trace("wells of ResInsight", header, rows, positive="down")


# ---- heads ----------------------------------------
# Where wells begin: the place at measured depth 0, by the name of each well.


Heads = dict[str, tuple[float, float, float]]
DRILL_FLOOR = (*USUAL["datum"], "elevation", "z", "rtelevation")
HOW = "Give {'W-1': (easting, northing, elevation)} in metres, or a table with Well, X, Y and KB."


def heads_of(heads: Any, decimal: str) -> Heads:
    """
    Return easting, northing and elevation [m] of wells at measured depth 0.

    Parameters
    ----------
    heads : mapping, path-like or None
        A mapping, or a table with the columns ``Well``, ``X``, ``Y`` and ``KB`` (elevation of the
        drill floor above sea level).
    decimal : {".", ","}

    Raises
    ------
    InputError, FormatError
        If it is neither, or a value is not a number.

    Examples
    --------
    >>> heads_of({"W-1": (500, 900, 25)}, ".")
    {'W-1': (500.0, 900.0, 25.0)}
    """
    if heads is None:
        return {}
    if isinstance(heads, Mapping):
        return {_name(name): _place(name, place) for name, place in heads.items()}
    if not hasattr(heads, "__fspath__") and not isinstance(heads, str):
        raise InputError(f"heads is a {type(heads).__name__}, not places of wells. {HOW}")
    path = Path(heads)
    layout = layout_of(path, decimal)
    header = layout.header or []
    words = list(map(plain_name, header))
    spelled = {key: USUAL[key] for key in ("well", "x", "y")} | {"KB": DRILL_FLOOR}
    at = [one_column(str(path), header, words, *one, HOW) for one in spelled.items()]
    units = [unit_in_name(layout.header[k]) if layout.header else None for k in at]
    scale = [metres_per_unit(unit or "m", f"{path.name}: heads of wells") for unit in units]
    result: Heads = {}
    for line, row in layout.rows:
        place = (with_point(row[k], decimal) for k in at[1:])
        x, y, z = (number(word, path, line, "x, y or KB") for word in place)
        if row[at[0]] in result:
            raise FormatError(f"{path}, line {line}: well {row[at[0]]!r} is there twice. Keep one.")
        result[row[at[0]]] = (x * scale[1], y * scale[2], z * scale[3])
    return result


def holds_heads(head: bytes) -> bool:
    """
    Return whether a table begins as one of well heads: names, places, and the drill floor.

    Examples
    --------
    >>> holds_heads(b"Well,X,Y,KB"), holds_heads(b"Well,X,Y,Z")
    (True, False)
    """
    first = head.decode("utf-8", "replace").lstrip().split("\n", 1)[0]
    words = [plain_name(word) for word in re.split(r"[,;\t]" if "," in first else r"[;\t]", first)]
    known = (USUAL["well"], USUAL["x"], USUAL["y"], DRILL_FLOOR[:4])
    return len(words) >= 4 and all(any(word in names for word in words) for names in known)


def _name(name: Any) -> str:
    if not isinstance(name, str) or not name:
        raise InputError(f"heads has the name {name!r}, expected the name of a well. {HOW}")
    return name


def _place(name: str, place: Any) -> tuple[float, float, float]:
    try:
        x, y, z = real_numbers(place).tolist()
    except (TypeError, ValueError) as error:
        raise InputError(f"heads[{name!r}] is {place!r}, not three numbers. {HOW}") from error
    if not all(abs(value) < float("inf") for value in (x, y, z)):
        raise InputError(f"heads[{name!r}] is {place!r}, which is not finite. {HOW}")
    return float(x), float(y), float(z)


SURVEY = ("md", "inclination", "azimuth")
PLACES = ("x", "y", "z")


def holds_wells(head: bytes) -> bool:
    """
    Return whether a table begins as one of well paths: places or directions, and no horizon.

    Parameters
    ----------
    head : bytes
        The first bytes of a file.

    Examples
    --------
    >>> holds_wells(b"Well,MD,Inc,Azi"), holds_wells(b"Well,X,Y,Z,Top"), holds_wells(b"X,Y,Z")
    (True, False, False)
    """
    lines = head.decode("utf-8", "replace").splitlines()
    if begins_with_name(lines):
        return True
    for line in lines:
        words = [plain_name(word) for word in line.replace(";", ",").replace("\t", ",").split(",")]
        if len(words) < 3:
            words = [plain_name(word) for word in line.split()]
        has = {key for key, names in USUAL.items() if any(word in names for word in words)}
        if any(word in HORIZON for word in words):
            return False
        if "md" in has and {"inclination", "azimuth"} <= has:
            return True
        if {*PLACES} <= has:
            return "md" in has or ("well" in has and _names_repeat(line, lines))
        if line.strip() and not line.lstrip().startswith(("#", "!", "--")):
            return False
    return False


def _names_repeat(header: str, lines: list[str]) -> bool:
    """Whether a well has several rows, as a path has; each of some picks may be in another one."""
    sign = next((sign for sign in ",;\t" if sign in header), None)
    at = [plain_name(word) in USUAL["well"] for word in header.split(sign)].index(True)
    rows = [line.split(sign) for line in lines[lines.index(header) + 1 :]]
    names = [row[at].strip() for row in rows if len(row) > at]
    return len(set(names)) < len(names) or len(names) < 2


def checked_columns(columns: Any) -> dict[str, str | int]:
    """Columns that the caller names, or the reason why not."""
    if columns is None:
        return {}
    how = f"Give a mapping of {', '.join(USUAL)} to names or numbers, as in {{'md': 'DEPT'}}."
    if not isinstance(columns, Mapping):
        raise InputError(f"columns is a {type(columns).__name__}. {how}")
    for key, word in columns.items():
        check_word(key, USUAL, f"columns has the key {key!r}.", f" {how}")
        if not isinstance(word, str) and not (type(word) is int and word > 0):
            raise InputError(f"columns[{key!r}] is {word!r}. {how}")
    return dict(columns)


def three_names(given: dict[str, str | int]) -> list[str | int] | None:
    """Names of x, y and z for readers that take three."""
    if not given:
        return None
    return [given.get(key, key) for key in PLACES]


def places_of(path: Path, trace: Trace, given: dict[str, str | int]) -> dict[str, int]:
    """Where the columns are that the file has, by their usual names or the caller's."""
    words = [plain_name(word) for word in trace.header]
    width = len(words) or min(len(row) for _, row in trace.rows)
    places: dict[str, int] = {}
    for key, usual in USUAL.items():
        word = given.get(key)
        if isinstance(word, int):
            if word > width:
                raise FormatError(f"{path}: a line has {width} values, but {key} is column {word}.")
            places[key] = word - 1
            continue
        names = usual if word is None else (plain_name(word),)
        at = [k for k, one in enumerate(words) if one in names]
        if key == "datum":  # a table may have several, KB and GL: depths count from the floor
            at = sorted(at, key=lambda k: names.index(words[k]))[:1]
        if len(at) > 1:
            raise FormatError(
                f"{path}: the columns {' and '.join(trace.header[k] for k in at)} may both be "
                f"{key}. Name one, as in columns={{{key!r}: {trace.header[at[0]]!r}}}."
            )
        if word is not None and not at:
            raise FormatError(
                f"{path}: no column is called {word!r}, only {', '.join(trace.header)}."
                f"{did_you_mean(word, trace.header)}"
            )
        if at:
            places[key] = at[0]
    return places


def check_kind(path: Path, trace: Trace, places: dict[str, int]) -> None:
    """Refuse a file that has neither positions nor measured depths with directions."""
    if all(key in places for key in PLACES) or all(key in places for key in SURVEY):
        names = ", ".join(trace.header[k] if trace.header else str(k + 1) for k in places.values())
        noted("columns", f"{', '.join(places)} are {names}")
        return
    survey = sum(key in places for key in SURVEY) >= sum(key in places for key in PLACES)
    missing = [key for key in (SURVEY if survey else PLACES) if key not in places]
    true_north = any("tn" in plain_name(word)[-2:] for word in trace.header)
    hint = (
        " Azimuths from true north differ from grid north by the convergence; name such a column "
        "only if that is 0."
        if "azimuth" in missing and true_north
        else ""
    )
    raise FormatError(
        f"{path}: no column is {' or '.join(missing)}; columns are "
        f"{', '.join(trace.header) or 'not named'}. A path needs x, y, z, or md, inclination, "
        f"azimuth. Name them, as in columns={{{missing[0]!r}: '...'}}.{hint}"
    )


def column_of(path: Path, trace: Trace, place: int, key: str, decimal: str) -> np.ndarray:
    """Numbers of one column, all of them finite."""
    words = [with_point(row[place], decimal) for _, row in trace.rows]
    return number_rows(words, [line for line, _ in trace.rows], path, f"{key} of a well").ravel()


def rows_of_wells(path: Path, trace: Trace, places: dict[str, int]) -> dict[str, np.ndarray]:
    """Rows of each well, in the order of the wells' first rows."""
    if "well" not in places:
        return {trace.well or path.stem: np.arange(len(trace.rows))}
    rows: dict[str, list[int]] = {}
    for k, (line, words) in enumerate(trace.rows):
        name = words[places["well"]].strip()
        if not name:
            raise damaged(f"{path}, line {line}: the name of the well is missing")
        rows.setdefault(name, []).append(k)
    return {name: np.array(at) for name, at in rows.items()}
