"""LAS 2 and 3: the path of a well where curves hold it, and tops along it.

The format is that of the Canadian Well Logging Society. Only positions are taken: curves of
easting, northing and z (elevation or depth below sea level), and of LAS 3 the section ``~Tops``.
Tops have measured depths; their places are on the straight lines between the stations of the path
in the same file. Logs are not read.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import metres_per_unit
from geosurf.errors import FormatError, InputError
from geosurf.lazy import xarray as xr
from geosurf.read._common import Request, noted, number, number_rows, read_text
from geosurf.read._guard import damaged
from geosurf.read._placed import points_dataset
from geosurf.read._table import checked_columns, first_column

# NAME.UNIT value : description
LINE = re.compile(r"\s*([^.\s][^.]*?)?\s*\.(\S*)\s*(.*?)\s*(?::[^:]*)?$")
CURVES = {
    "x": ("x", "easting", "east", "xcoord", "x_utme", "utmx", "x_coord"),
    "y": ("y", "northing", "north", "ycoord", "y_utmn", "utmy", "y_coord"),
    "z": ("tvdss", "z", "elevation", "elev", "sstvd", "z_tvdss"),
    "md": ("dept", "depth", "md", "mdrkb"),
}
TOPS = {"name": ("topn", "name", "top", "topname", "surface"), "md": ("topt", "tops", "md", "depth",
        "dept", "topdepth", "topd")}  # fmt: skip
NULL = "-999.25"
NEEDED = ("version", "well", "curve", "tops")  # sections


@dataclass
class Section:
    """A section: lines of the header, names and units of columns, and rows of data."""

    words: dict[str, tuple[str, str]] = field(default_factory=dict)  # name -> unit and value
    rows: list[tuple[int, list[str]]] = field(default_factory=list)


@dataclass
class WellPath:
    """The path of a well: name, measured depths (n,) and points (n, 3)."""

    well: str
    md: np.ndarray
    points: np.ndarray


def read_las_points(path: Path, request: Request) -> xr.Dataset:
    r"""
    Read the path of a well from the curves of a LAS file.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`: Whether z is elevation or depth; the format does not state it.
        `length_unit`: Unit of z, if its curve states none. Default ``"m"``.
        `columns`: Names of the curves of easting, northing and z.
        `decimal`: Has no effect: numbers in LAS have a point.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` and ``md`` over ``point`` [m]. ``attrs["well"]`` is
        the name of the well.

    Raises
    ------
    FormatError
        If the file has no curves of positions, is wrapped, or a line is incomplete.
    InputError
        If `positive` is missing.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "w.las"
    >>> head = "~V\nVERS. 2.0 :\nWRAP. NO :\n~W\nWELL. W-1 :\nNULL. -999.25 :\n"
    >>> curves = "~C\nDEPT.M :\nX.M :\nY.M :\nTVDSS.M :\n~A\n"
    >>> _ = file.write_text(head + curves + "0 5 6 -20\n100 5 6 80\n")
    >>> read_las_points(file, Request(positive="down")).elevation.values
    array([ 20., -80.])
    """
    found = path_of_las(path, request)
    md = {"md": ("point", found.md, {"units": "m"})}
    return points_dataset(found.points, path.name, others=md, well=found.well)


def path_of_las(path: Path, request: Request) -> WellPath:
    """Return the path of the well; the arguments are those of `read_las_points`."""
    return _well_path(path, _sections(path), request)


def tops_of_las(
    path: Path, request: Request
) -> tuple[list[tuple[str, str]], np.ndarray, list[str]]:
    """
    Return (well, horizon), places (n, 3) in metres, and reasons of tops that are left out.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`, `columns`: As for `read_las_points`.

    Raises
    ------
    FormatError
        If the file has no tops, or no path to place them on.
    """
    sections = _sections(path)
    section = sections.get("tops")
    if section is None or not section.rows:
        raise FormatError(
            f"{path}: the LAS file has no section ~Tops with data, as LAS 3 has. Read the path of "
            "the well with read_points, and tops from a table."
        )
    well = _well_path(path, sections, request)
    header = [word.lower() for word in section.words]
    places = {key: first_column(header, usual) for key, usual in TOPS.items()}
    if None in places.values():
        raise FormatError(
            f"{path}: the columns of ~Tops are {', '.join(header)}, expected TOPN (name) and TOPT "
            "(measured depth) among them. Rename them."
        )
    name_at, md_at = int(places["name"] or 0), int(places["md"] or 0)
    unit = list(section.words.values())[md_at][0] or "m"
    factor = metres_per_unit(unit, f"{path.name}: ~Tops")
    names: list[tuple[str, str]] = []
    places_of_tops: list[np.ndarray] = []
    unused: list[str] = []
    for line, words in section.rows:
        if len(words) != len(header):
            raise damaged(
                f"{path}, line {line}: found {len(words)} values, expected {len(header)} as in "
                "~Tops_Definition"
            )
        title = words[name_at].strip("\"' ")
        md = number(words[md_at], path, line, "measured depth of a top") * factor
        if not well.md[0] <= md <= well.md[-1]:
            unused.append(f"{title!r} in well {well.well!r} (line {line}) is outside of the path")
            continue
        names.append((well.well, title))
        places_of_tops.append(
            np.array([np.interp(md, well.md, well.points[:, k]) for k in range(3)])
        )
    noted("tops", f"{len(names)} of the section ~Tops, on straight lines between stations")
    return names, np.array(places_of_tops).reshape(-1, 3), unused


def holds_tops(path: Path) -> bool:
    """Whether a LAS file has a section of tops with data."""
    try:
        return bool(_sections(path).get("tops", Section()).rows)
    except (FormatError, InputError):
        return False


def _sections(path: Path) -> dict[str, Section]:
    """Sections by their names: version, well, curve, ascii, tops ..."""
    sections: dict[str, Section] = {}
    current, key, data, sign = Section(), "", False, None
    for i, line in enumerate(read_text(path, final_line_end=False).split("\n"), start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        if text.startswith("~"):
            title = text[1:].split("|")[0].strip().lower()
            key = _key(title)
            current = sections.setdefault(key, Section())
            data = key == "ascii" or title.split(" ")[0].endswith("_data")
            continue
        if data:
            words = text.split(sign) if sign else text.split()
            current.rows.append((i, [word.strip() for word in words]))
            continue
        if key not in NEEDED:  # parameters and notes, which may be free text
            continue
        match = LINE.match(line)
        if match is None:
            raise damaged(
                f"{path}, line {i}: found {text[:40]!r}, expected NAME.UNIT value : description"
            )
        name = match[1] or "UNKNOWN"
        # a name that is there twice is one column more
        taken = name if name not in current.words else f"{name}:{len(current.words)}"
        current.words[taken] = (match[2], match[3])
        if name.upper() == "DLM":
            sign = {"COMMA": ",", "TAB": "\t"}.get(match[3].upper())
    return sections


def _key(title: str) -> str:
    """One name for the sections of LAS 2, which its first letter tells, and of LAS 3."""
    if title.startswith("tops"):
        return "tops"
    if title.startswith("log"):
        return "ascii" if title.startswith("log_data") else "curve"
    letters = {"v": "version", "w": "well", "c": "curve", "p": "parameter", "a": "ascii"}
    return letters.get(title[:1], title)


def _well_path(path: Path, sections: dict[str, Section], request: Request) -> WellPath:
    """The path that the curves of a file hold."""
    version, well = (sections.get(key, Section()).words for key in ("version", "well"))
    curves, rows = sections.get("curve", Section()).words, sections.get("ascii", Section()).rows
    if _value(version, "WRAP").upper().startswith("Y"):
        raise FormatError(f"{path}: the LAS file is wrapped. Export it with WRAP. NO.")
    names = list(curves)
    at = _curves(path, names, request.columns)
    null = number(_value(well, "NULL") or NULL, path, 0, "NULL")
    values = _values(path, rows, len(names), list(at.values()))
    left_out = (values == null).any(axis=1)
    values = values[~left_out]
    if not len(values):
        raise damaged(f"{path}: the LAS file has no station with a position")

    units = {key: curves[names[k]][0].lower() or None for key, k in at.items()}
    what = f"{path.name}: well path"
    scale = request.scale(what, unit=units["z"])
    factors = [metres_per_unit(units[key] or "m", what) for key in ("x", "y")]
    points = values[:, :3] * [*factors, scale] + 0.0
    md = values[:, 3] * metres_per_unit(units["md"] or "m", what)
    if (np.diff(md) <= 0).any():
        k = int(np.argmax(np.diff(md) <= 0))
        raise damaged(f"{path}: measured depths do not increase after {md[k]:g} m")
    title = _value(well, "WELL") or path.stem
    taken = ", ".join(f"{key} is {names[k]}" for key, k in at.items())
    noted("columns", f"{taken}; other curves are not read")
    noted("names", f"well {title}")
    noted("left out", f"{int(left_out.sum())} stations with {null:g}")
    return WellPath(title, md, points)


def _value(words: dict[str, tuple[str, str]], name: str) -> str:
    """Value of a line of the header, or nothing."""
    return next((value for key, (_, value) in words.items() if key.upper() == name), "")


def _curves(path: Path, names: list[str], columns: Any) -> dict[str, int]:
    """Places of the curves of x, y, z and measured depth."""
    header = [name.lower() for name in names]
    spellings = dict(CURVES)
    given = checked_columns(columns, ("easting", "northing", "z"), "('X', 'Y', 'TVDSS')")
    spellings |= {key: (str(word),) for key, word in zip("xyz", given or (), strict=False)}
    at = {key: first_column(header, usual) for key, usual in spellings.items()}
    missing = [key for key, place in at.items() if place is None]
    if missing:
        raise FormatError(
            f"{path}: no curve of the LAS file is {' or '.join(missing)}; curves are "
            f"{', '.join(names[:12]) or 'absent'}{' ...' * (len(names) > 12)}. geosurf takes the "
            "path of a well only: easting, northing, and depth below sea level. Name them, as in "
            "columns=('X', 'Y', 'TVDSS')."
        )
    return {key: int(place) for key, place in at.items() if place is not None}


def _values(
    path: Path, rows: list[tuple[int, list[str]]], width: int, places: list[int]
) -> np.ndarray:
    """Numbers (n, 4) of x, y, z and measured depth."""
    for line, words in rows:
        if len(words) != width:
            raise damaged(
                f"{path}, line {line}: found {len(words)} values, expected {width}, one for each "
                "curve"
            )
    flat = [words[place] for _, words in rows for place in places]
    return number_rows(flat, [line for line, _ in rows], path, "x, y, z or measured depth")
