"""Well tops: where wells meet horizons, from csv, text, Petrel and RMS."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted, did_you_mean, elevation_sign
from geosurf.conventions.checks import HUGE, NO_DATA, no_data_in
from geosurf.errors import FormatError, InputError, warn_of
from geosurf.lazy import xarray as xr
from geosurf.model.expected import path_of
from geosurf.read._common import (
    Otherwise,
    Request,
    agreed_scale,
    agreed_sign,
    is_number,
    noted,
    number,
    otherwise,
    read_text,
    with_point,
)
from geosurf.read._guard import damaged
from geosurf.read._table import checked_columns, checked_decimal, one_column
from geosurf.read.las import tops_of_las
from geosurf.read.registry import detect, refuse_foreign

# ---- measured tops ----------------------------------------
# Well tops that have measured depths only: their places lie on the paths of the wells.


Paths = dict[str, tuple[np.ndarray, np.ndarray]]


def paths_with_depths(wells: Any) -> Paths:
    """
    Return measured depths (n,) and places (n, 3) of each well, or name what is missing.

    Parameters
    ----------
    wells : xarray.Dataset
        As `read_wells` returns it.

    Raises
    ------
    InputError
    """
    names = ("well", "md", "easting", "northing", "elevation")
    lacking = [name for name in names if name not in getattr(wells, "data_vars", ())]
    if lacking:
        raise InputError(
            f"wells= has no {', '.join(lacking)}. Pass what gs.read_wells returns for paths with "
            "measured depths."
        )
    label = wells["well"].values
    columns = {name: np.asarray(wells[name].values, dtype=np.float64) for name in names[1:]}
    paths: Paths = {}
    for name in dict.fromkeys(label.tolist()):
        at = (label == name) & ~np.isnan(columns["md"])
        md = columns["md"][at]
        if len(md) < 2 or not (np.diff(md) > 0).all():
            raise InputError(
                f"wells=: the measured depths of well {name!r} do not rise from point to point. "
                "Read its path with measured depths."
            )
        places = np.column_stack([columns[axis][at] for axis in names[2:]])
        paths[str(name)] = (md, places)
    return paths


def place_along(path: Path, line: int, well: str, md: float, paths: Paths) -> np.ndarray | None:
    """
    Return easting, northing and elevation at a measured depth; None beyond the path.

    Raises
    ------
    FormatError
        If the well has no path.
    """
    if well not in paths:
        raise FormatError(
            f"{path}, line {line}: well {well!r} has no path in wells=.{did_you_mean(well, paths)} "
            f"Wells with paths are {', '.join(list(paths)[:12])}."
        )
    depths, places = paths[well]
    if not depths[0] <= md <= depths[-1]:
        return None
    return np.array([np.interp(md, depths, axis) for axis in places.T])


# usual names of the five columns: lower case, letters and digits only
USUAL = {
    "well": ("well", "wellname", "wellbore", "wellborename", "wellidentifier", "uwi", "borehole"),
    "x": ("x", "xutme", "easting", "east", "xcoord", "xcoordinate"),
    "y": ("y", "yutmn", "northing", "north", "ycoord", "ycoordinate"),
    "z": ("z", "ztvdss", "tvdss", "sstvd", "elevation", "depth"),
    "horizon": (
        "horizon", "surface", "top", "marker", "pick", "formation",
        "horizonname", "surfacename", "topname", "markername",
    ),
}  # fmt: skip
OF_PATHS = {
    "well": USUAL["well"],
    "md": ("md", "mdrkb", "measureddepth"),
    "horizon": USUAL["horizon"],
}
# those of well paths, too: three of them on a line are a header
ANY_NAME = {name for names in (*USUAL.values(), *OF_PATHS.values()) for name in names} | {
    "inc", "incl", "inclination", "azi", "azim", "azimuth",
}  # fmt: skip
PLACES = ("x", "y", "z")
MEASURED = ("md", "mdrkb", "measureddepth", "tvd", "tvdrkb")  # depths along or below the rig
# what programs write for an undefined value
UNDEFINED = {*(mark for mark in NO_DATA if mark > 1e6), *(-mark for mark in NO_DATA)}
UNDEFINED_WORDS = ("", "undef", "undefined", "null", "nan", "none", "-")
MOST_NAMED = 6  # tops in one warning
Places = dict[str, int]
Usual = dict[str, tuple[str, ...]]


def read_tops(
    path: str | PathLike[str],
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
    wells: xr.Dataset | None = None,
) -> xr.Dataset:
    r"""
    Read well tops: where wells meet horizons.

    Parameters
    ----------
    path : path-like
        Petrel well tops, RMS points with attributes, or a table with a header, separated by
        commas, semicolons, tabs or blanks; the content determines which. Columns are found by
        name, in any order: well (``Well``, ``UWI`` ...), ``X``, ``Y``, ``Z`` or ``TVDSS``, and
        ``Surface`` or ``Horizon``.
    positive : {"up", "down"}
        Whether z is elevation or depth. Only Petrel files may leave it out: they hold elevations.
    length_unit : str, optional
        Unit of z. Default: as the file declares it, else ``"m"``.
    columns : sequence of str or of int, optional
        Names of the columns of well, easting, northing, z and horizon, or their numbers, counted
        from 1.
    decimal : {".", ","}, optional
        Decimal sign of the file.
    wells : xarray.Dataset, optional
        Paths with measured depths, as `read_wells` returns them. Each top is then at its measured
        depth (column ``MD``) on the path of its well; columns of places are not used, and
        `columns` are well, measured depth and horizon.

    Returns
    -------
    xarray.Dataset
        ``well``, ``horizon``, ``easting``, ``northing`` and ``elevation`` [m], positive up, over
        ``top``. ``attrs["unused"]`` lists rows without a top, each with its reason.

    Raises
    ------
    FormatError
        If a column is missing or there twice, or a line does not fit the header.
    InputError
        If the file cannot be opened, or `positive` is missing.

    Warns
    -----
    GeosurfWarning
        Of rows that are not used: undefined values (-999, 1e30, UNDEF ...), repeated rows, tops of
        faults.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "tops.csv"
    >>> _ = file.write_text("Surface,Well,X,Y,TVDSS\nTop,W-1,500,900,1612.5\n")
    >>> tops = read_tops(file, positive="down")
    >>> tops.well.values.tolist(), tops.horizon.values.tolist(), tops.elevation.values.tolist()
    (['W-1'], ['Top'], [-1612.5])
    """
    path = path_of(path, "read_tops")
    if positive is not None:
        elevation_sign(positive, f"{path.name}: well tops")
    sign = checked_decimal(decimal)
    if detect(path) == "las":
        request = Request(positive=positive, length_unit=length_unit, columns=columns)
        return _as_dataset(path, *tops_of_las(path, request))
    refuse_foreign(path)
    layout = layout_of(path, sign)
    if wells is not None:
        paths = paths_with_depths(wells)
        places = _places(path, layout, columns, OF_PATHS)
        unit = unit_of_column(layout.header, places["md"], layout.length_unit)
        scale = agreed_scale(unit, length_unit, "m", f"{path.name}: measured depths")
        return _dataset(path, layout, places, scale, sign, paths)
    places = _places(path, layout, columns)
    what = f"{path.name}: well tops"

    # Petrel writes elevations; nobody else states it
    default = otherwise({"positive": "up"})["positive"] if layout.petrel else None
    unit = unit_of_column(layout.header, places["z"], layout.length_unit)
    # what a caller assumes gives way to it
    asked = None if isinstance(positive, Otherwise) and layout.petrel else positive
    scale = agreed_sign(None, asked or default, what)
    if layout.petrel and asked is None:
        noted("sign", "positive up, as Petrel writes well tops")
    scale *= agreed_scale(unit, length_unit, "m", what)
    return _dataset(path, layout, places, scale, sign)


# ---------------------------------------------------------------------- columns
def _places(path: Path, layout: Layout, columns: Any, usual: Usual = USUAL) -> Places:
    """Where the columns are: by their usual names, or the caller's names or numbers from 1."""
    titles = ["measured depth" if key == "md" else key for key in usual]
    example = "('Well', 'X', 'Y', 'TVDSS', 'Surface')"
    example = "('Well', 'MD', 'Surface')" if usual is OF_PATHS else example
    given = checked_columns(columns, titles, example)
    if given is not None and not isinstance(given[0], str):
        # without a header the shortest row bounds the columns
        rows = [layout.header] if layout.header else [words for _, words in layout.rows]
        width = min(map(len, rows))
        if max(given) > width:
            raise FormatError(
                f"{path}: a line has {width} values, but columns={given}. Columns are counted "
                "from 1."
            )
        return {key: int(k) - 1 for key, k in zip(usual, given, strict=True)}
    if layout.header is None:
        line, words = layout.rows[0]
        raise FormatError(
            f"{path}, line {line}: the file has no header, and the line has {len(words)} values. "
            f"Give the columns of {', '.join(titles)}, counted from 1, as in columns="
            f"{tuple(range(1, len(titles) + 1))}."
        )
    # names from the caller are matched as they stand; usual ones without unit and punctuation
    if given is not None:
        words = [word.strip().lower() for word in layout.header]
        spelled: Usual = {key: (str(word),) for key, word in zip(usual, given, strict=True)}
    else:
        words = [plain_name(word) for word in layout.header]
        spelled = dict(usual)
        if not any(word in usual["well"] for word in words):
            spelled["well"] = ("name",)  # only where no better column is there
    places = {}
    for key, spellings in spelled.items():
        lacks = key in PLACES and not any(word in spellings for word in words)
        below = lacks and any(word in MEASURED for word in words)
        if below:
            raise FormatError(
                f"{path}: the file has depths below the rig (MD or TVD), but no places with "
                "elevation or depth below sea level; its columns are "
                f"{', '.join(layout.header)}. Export the tops with X, Y and Z or TVDSS. If they "
                "have MD, pass wells=gs.read_wells(...)."
            )
        remedy = f"Set columns=, as in columns={example}."
        places[key] = one_column(str(path), layout.header, words, key, spellings, remedy)
    return places


# ------------------------------------------------------------------------- rows
def _dataset(
    path: Path,
    layout: Layout,
    places: Places,
    scale: float,
    decimal: str,
    paths: Paths | None = None,
) -> xr.Dataset:
    """Tops of all rows that have one; the others are listed with their reason."""
    names: list[tuple[str, str]] = []
    points: list[list[float]] = []
    unused: list[str] = []
    seen = set()
    kind = _place_of_type(layout)
    for line, words in layout.rows:
        well, horizon = (_name(path, line, words[places[key]], key) for key in ("well", "horizon"))
        top = f"{horizon!r} in well {well!r} (line {line})"

        # Petrel lists picks of faults among the tops
        if kind is not None and words[kind].strip().lower() not in ("horizon", ""):
            unused.append(f"{top} has the type {words[kind]!r}, not Horizon")
            continue

        # a top without a place is left out and listed; one that is there twice counts once
        axes = ("x", "y", "z") if paths is None else ("md",)
        values = [_value(path, line, words[places[key]], decimal) for key in axes]

        # which of them are undefined, for the list of rows that are not used
        lacking = [word for word, v in zip(axes, values, strict=True) if v is None]
        if paths is not None and values[0] is not None:
            on_path = place_along(path, line, well, scale * values[0], paths)
            values = [] if on_path is None else list(on_path)
        if not values:
            unused.append(f"{top} is beyond the path of its well")
        elif lacking:
            unused.append(f"{top} has undefined {', '.join(lacking)}")
        elif (row := (well, horizon, *values)) in seen:
            unused.append(f"{top} is there twice")
        else:
            seen.add(row)
            names.append((well, horizon))
            points.append([value for value in values if value is not None])
    # 0.0 is added to z so that depths of 0 do not become -0.0
    factor = scale if paths is None else 1.0  # paths are in metres, positive up
    moved = np.array(points).reshape(-1, 3) * [1.0, 1.0, factor] + 0.0
    return _as_dataset(path, names, moved, unused)


def _as_dataset(
    path: Path, names: list[tuple[str, str]], points: np.ndarray, unused: list[str]
) -> xr.Dataset:
    """Tops with their names and places in metres; rows that are not used are named."""
    if not names:
        first = f": {unused[0]}" if unused else ""
        raise damaged(f"{path}: the file has no well tops{first}")
    # a depth of 999.25 m may be measured; those that are left out are negative
    if absent := no_data_in(points, elevations=False):
        well, horizon = names[absent[0]]
        raise damaged(
            f"{path}: the place of {horizon!r} in well {well!r} has {absent[1]:g}, a usual mark of "
            "no data"
        )
    _warn_of_unused(path, unused, len(names) + len(unused))
    metre = {"units": "m"}
    return xr.Dataset(
        {
            "well": ("top", np.array([well for well, _ in names], dtype=object)),
            "horizon": ("top", np.array([horizon for _, horizon in names], dtype=object)),
            "easting": ("top", points[:, 0].copy(), metre),
            "northing": ("top", points[:, 1].copy(), metre),
            "elevation": ("top", points[:, 2].copy(), metre | {"positive": "up"}),
        },
        attrs={"source": path.name, "unused": unused},
    )


def _place_of_type(layout: Layout) -> int | None:
    """Column of Petrel's type of a top: Horizon, Fault or Other."""
    words = [word.strip().lower() for word in layout.header or ()] if layout.petrel else []
    return words.index("type") if "type" in words else None


def _name(path: Path, line: int, word: str, what: str) -> str:
    """A name, or the line where it is missing."""
    if not word:
        raise damaged(f"{path}, line {line}: the name of the {what} is missing")
    return word


def _value(path: Path, line: int, word: str, decimal: str) -> float | None:
    """A number, or None where it is undefined."""
    if word.strip().lower() in UNDEFINED_WORDS:
        return None
    word = with_point(word, decimal)
    if is_number(word) and (float(word) in UNDEFINED or abs(float(word)) >= HUGE):
        return None
    return number(word, path, line, "x, y or z")


def _warn_of_unused(path: Path, unused: list[str], n: int) -> None:
    """List the rows that are not used."""
    if unused:
        more = f" and {len(unused) - MOST_NAMED} more" if len(unused) > MOST_NAMED else ""
        effect = (
            f"{len(unused)} of {counted(n, 'row')} of '{path.name}' are not used: "
            f"{'; '.join(unused[:MOST_NAMED])}{more}."
        )
        remedy = "Complete or delete these rows; tops.attrs['unused'] lists all."
        warn_of("tops", path.name, effect, remedy)


# ---- layouts ----------------------------------------
# Layouts of well-top files -> a header and rows of words.
#
# Three are recognised by their first lines:
#
# - Petrel well tops: column names between BEGIN HEADER and END HEADER, names in quotes;
# - RMS points with attributes: lines such as ``String Well`` name what follows x y z in each row;
# - a table, with one header line or none, separated by commas, semicolons, tabs or blanks.


WORD = re.compile(r'"([^"]*)"|\'([^\']*)\'(?=\s|$)|(\S+)')
ATTRIBUTE = re.compile(r"(?i)(float|string|discrete|int|integer)\s+(\S.*)")
UNIT = re.compile(r"(?i)#\s*unit in depth:\s*(\S*)")
TYPED = re.compile(r"(?i)(?:float|double|int|integer|string|bool|date\w*|discrete)\s*[,\s]\s*(.+)")
BRACKETS = re.compile(r"(.*?)\s*[\[(]\s*(.*?)\s*[\])]\s*")
COMMENTS = ("#", "!", "--")
SEPARATORS = (",", ";", "\t")


@dataclass(frozen=True)
class Layout:
    """A file of well tops, taken apart.

    Attributes
    ----------
    header : list of str or None
        Names of the columns as they are written; None without a header.
    rows : list of (int, list of str)
        Line number from 1, and its words.
    petrel : bool
        Whether the file is in Petrel's format, which holds elevations.
    length_unit : str or None
        Unit of z, if the file declares one.
    """

    header: list[str] | None
    rows: list[tuple[int, list[str]]]
    petrel: bool = False
    length_unit: str | None = None


def layout_of(path: Path, decimal: str, *, ends: bool = False) -> Layout:
    """Return header and rows of a file of well tops, or of points with attributes.

    With `ends`, lines of ``999 999 999`` may be shorter than the header.

    Raises
    ------
    FormatError
        If the header has no end, or a row has another number of words than the header.
    """
    # line numbers are those of the file: comments and empty lines count, but are not rows
    lines = read_text(path).split("\n")
    unit = next((match[1] for line in lines[:50] if (match := UNIT.match(line.strip()))), None)
    numbered = [
        (number, line.strip())
        for number, line in enumerate(lines, start=1)
        if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    if not numbered:
        raise damaged(f"{path}: the file has comments only")

    # the most particular layout first: a table would take nearly anything
    begins = [k for k, (_, line) in enumerate(numbered[:50]) if line.upper() == "BEGIN HEADER"]
    if begins:
        header, body = _petrel(path, numbered, begins[0])
        header = [_without_type(word) for word in header]
        layout = Layout(header, body, True, unit or None)
    elif ATTRIBUTE.fullmatch(numbered[0][1]):
        layout = _with_attributes(numbered)
    else:
        layout = _table(path, numbered, decimal, _last_comment(lines[: numbered[0][0] - 1]))
    check_widths(path, layout.header, layout.rows, ends=ends)
    return layout


def plain_name(word: str) -> str:
    """Return a name of a column in lower case, letters and digits only, without its unit.

    Examples
    --------
    >>> plain_name("Z_TVDSS [ft]")
    'ztvdss'
    """
    match = BRACKETS.fullmatch(word)
    return re.sub(r"[^a-z0-9]", "", (match[1] if match else word).lower())


def unit_in_name(word: str) -> str | None:
    """Return the unit in brackets behind the name of a column, in lower case; None without."""
    match = BRACKETS.fullmatch(word)
    return (match[2].lower() or None) if match else None


def unit_of_column(header: list[str] | None, place: int, whole: str | None) -> str | None:
    """Return the unit of a column: in brackets after its name, else that of the whole file."""
    return (unit_in_name(header[place]) if header else None) or whole


def _without_type(word: str) -> str:
    """A name without the type that Petrel writes before it, as in ``FLOAT,dip``."""
    found = TYPED.fullmatch(word.strip())
    return (found[1] if found else word).strip("\"' ")


def _petrel(
    path: Path, numbered: list[tuple[int, str]], begin: int
) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Names between BEGIN HEADER and END HEADER, and the rows below."""
    upper = [line.upper() for _, line in numbered]
    if "END HEADER" not in upper[begin:]:
        raise damaged(f"{path}, line {numbered[begin][0]}: BEGIN HEADER has no END HEADER")
    end = upper.index("END HEADER", begin)
    header = [line for _, line in numbered[begin + 1 : end]]
    return header, [(number, _blank_words(line)) for number, line in numbered[end + 1 :]]


def _with_attributes(numbered: list[tuple[int, str]]) -> Layout:
    """RMS points: one line for each attribute, then x y z and the attributes."""
    # attribute lines come first; the first line that is none begins the points
    header = ["x", "y", "z"]
    for _, line in numbered:
        match = ATTRIBUTE.fullmatch(line)
        if match is None:
            break
        header.append(match[2].strip("\"' "))
    body = numbered[len(header) - 3 :]
    return Layout(header, [(number, _blank_words(line)) for number, line in body])


def _last_comment(lines: list[str]) -> list[str]:
    """Words of the last comment that has some, perhaps names of columns: ``# MD INC AZI``."""
    found = [words for line in lines if (words := line.strip().lstrip("#!- ").split())]
    return " ".join(found[-1]).replace(",", " ").replace(";", " ").split() if found else []


def _table(path: Path, numbered: list[tuple[int, str]], decimal: str, comment: list[str]) -> Layout:
    """A table with one header line, or none; or the names of columns in a comment above it."""
    # titles may stand above the names of columns
    names = next((k for k, (_, line) in enumerate(numbered[:50]) if _n_usual(line) >= 3), 0)
    if all(sum(map(is_number, _words(line))) < 3 for _, line in numbered[:names]):
        numbered = numbered[names:]
        noted("titles", f"{names} lines above the names of columns are not read" * (names > 0))

    # the first line by its separator; those below by the same, or by the one that fits them
    first = next((sign for sign in SEPARATORS if sign in numbered[0][1] and sign != decimal), None)
    rows = list(_split(path, numbered[:1], first))
    width, signs = len(rows[0][1]), (first, *SEPARATORS, None)
    fits = (
        sign for sign in signs if all(len(w) == width for _, w in _split(path, numbered[1:2], sign))
    )
    rows += _split(path, numbered[1:], next(fits, first))

    # a header has no number in any column, or names of columns that are usual
    words = rows[0][1]
    numbers = any(is_number(word.replace(",", ".", 1)) for word in words)
    if not numbers or _n_usual(numbered[0][1]) >= 3:
        return Layout(words, rows[1:])
    named = len(comment) == len(words) and not any(map(is_number, comment))
    return Layout(comment if named else None, rows)


def from_header(head: bytes) -> bytes:
    """Return the beginning of a table from its names of columns on, if these are usual ones."""
    lines = head.decode("utf-8", "replace").split("\n")
    names = next((k for k, line in enumerate(lines[:50]) if _n_usual(line) >= 3), 0)
    return "\n".join(lines[names:]).encode()


def holds_picks(first: bytes) -> bool:
    """Return whether names of columns are those of points with the name of a well, not of tops."""
    words = {plain_name(word) for word in _words(first.decode("utf-8", "replace"))}
    places = all(words & {*USUAL[key]} for key in PLACES)
    return places and not words & {*USUAL["horizon"]}


def _n_usual(line: str) -> int:
    """How many usual names of columns a line has."""
    return sum(plain_name(word) in ANY_NAME for word in _words(line))


def _words(line: str) -> list[str]:
    """Words of a line by its separators, or else by blanks."""
    return re.split(r"[,;\t]" if re.search(r"[,;\t]", line) else r"\s+", line)


def _split(
    path: Path, numbered: list[tuple[int, str]], sign: str | None
) -> Iterator[tuple[int, list[str]]]:
    """Words of each line, separated by a sign or by blanks, and perhaps in quotes."""
    for k, line in numbered:
        if sign is None:
            yield k, _blank_words(line)
            continue
        try:
            words = next(csv.reader([line], delimiter=sign, skipinitialspace=True))
        except (csv.Error, StopIteration) as error:
            raise damaged(f"{path}, line {k}: this line is not valid csv ({error})") from error
        yield k, [word.strip() for word in words]


def _blank_words(line: str) -> list[str]:
    """Words between blanks; names in quotes may have blanks inside."""
    return [
        next(part for part in match.groups() if part is not None).strip()
        for match in WORD.finditer(line)
    ]


def check_widths(
    path: Path, header: list[str] | None, rows: list[tuple[int, list[str]]], *, ends: bool = False
) -> None:
    """Refuse rows that are shorter or longer than the header, except perhaps end marks."""
    for line, words in rows if header else ():
        if ends and len(words) >= 3 and all(is_number(w) and float(w) == 999 for w in words[:3]):
            continue
        if len(words) != len(header or ()):
            raise FormatError(
                f"{path}, line {line}: found {len(words)} values, expected {len(header or ())} "
                f"as the columns {', '.join(header or ())}. Put names with blanks in quotes. "
                "Numbers with decimal commas need another separator and decimal=','."
            )
