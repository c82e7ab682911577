"""GOCAD TSurf: triangulated surfaces in text.

What files in the wild do, and what is done with it:

- ``ZPOSITIVE Depth`` turns z over; without the word z is elevation.
- ``AXIS_UNIT`` scales each axis to metres; without it lengths are metres.
- Several TFACE blocks are parts of one surface; ids run through all of them, may
  begin anywhere and skip.
- ``ATOM`` and ``PATOM`` are other names of a vertex: triangles share that vertex.
- Words after the coordinates (``CNXYZ``) are control-node flags and dropped.
- Other objects in the file (SGrid, VSet ...) are passed over.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.errors import FormatError, InputError
from geosurf.model import TriSurface
from geosurf.read._common import agreed_scale, agreed_sign, integer, number, read_text

DIRECTIONS = {"elevation": "up", "depth": "down"}
VERTEX_WORDS = ("VRTX", "PVRTX")
ALIAS_WORDS = ("ATOM", "PATOM")

Line = tuple[int, list[str]]


@dataclass
class _Draft:
    """One TSurf while its lines go by."""

    line: int
    name: str | None = None
    positive: str | None = None
    axis_units: list[str] = field(default_factory=list)
    properties: list[str] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)
    no_data: list[float] = field(default_factory=list)
    row_of_id: dict[int, int] = field(default_factory=dict)
    points: list[tuple[float, float, float]] = field(default_factory=list)
    values: list[list[float]] = field(default_factory=list)
    triangles: list[tuple[int, int, int]] = field(default_factory=list)


def read_gocad(
    path: Path, *, name: str | None = None, positive: str | None = None, units: str | None = None
) -> TriSurface:
    r"""
    Read the one TSurf of a file, or the one called `name`.

    Parameters
    ----------
    path : pathlib.Path
    name : str, optional
        Which surface, where the file has several; otherwise the name to give.
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    units : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    TriSurface
        Role ``"fault"``.

    Raises
    ------
    InputError
        If there are several surfaces and `name` is none of them, or only one of several
        equally named ones; or if `positive` or `units` contradict the file.
    FormatError
        As `read_tsurf`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "F1.ts"
    >>> _ = file.write_text("GOCAD TSurf 1\nHEADER {\nname: F1\n}\nTFACE\n"
    ...     "VRTX 5 0 0 0\nVRTX 6 9 0 0\nVRTX 9 0 9 9\nTRGL 5 6 9\nEND\n")
    >>> read_gocad(file)
    <TriSurface 'F1' (fault): 3 vertices, 1 triangles>
    """
    surfaces = read_tsurf(path, positive=positive, units=units)
    if len(surfaces) == 1:
        return surfaces[0] if name is None else surfaces[0].renamed(name)
    names = [surface.name for surface in surfaces]
    found = [surface for surface in surfaces if surface.name == name]
    if len(found) != 1:
        guess = "" if name is None else did_you_mean(name, names)
        asked = "none was asked for" if name is None else f"{len(found)} are called {name!r}"
        raise InputError(
            f"{path}: the file has {len(surfaces)} surfaces, {names}, and {asked}.{guess} "
            "Pick one with name=, or read all with geosurf.read.read_tsurf."
        )
    return found[0]


def read_tsurf(
    path: str | Path, *, positive: str | None = None, units: str | None = None
) -> list[TriSurface]:
    r"""
    Read all TSurf of a GOCAD file.

    Parameters
    ----------
    path : str or pathlib.Path
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    units : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    list of TriSurface
        In file order, role ``"fault"``. Vertices in metres, elevation positive up;
        numeric properties in ``vertex_data``, NaN where the file says "no data".

    Raises
    ------
    FormatError
        If the file has no TSurf, is cut short, or a line cannot be understood.
    InputError
        If `positive` or `units` contradict the file or are unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "F1.ts"
    >>> _ = file.write_text("GOCAD TSurf 1\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\n"
    ...     "ZPOSITIVE Depth\nEND_ORIGINAL_COORDINATE_SYSTEM\nTFACE\n"
    ...     "VRTX 1 0 0 0\nVRTX 2 9 0 0\nVRTX 3 0 9 9\nTRGL 1 2 3\nEND\n")
    >>> read_tsurf(file)[0].vertices[2].tolist()
    [0.0, 9.0, -9.0]
    """
    path = Path(path)
    lines = enumerate(read_text(path, final_line_end=False).splitlines(), start=1)
    surfaces = []
    for i, line in lines:
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].upper() != "GOCAD":
            raise FormatError(
                f"{path}, line {i}: found {line[:40]!r}, expected 'GOCAD TSurf 1'. "
                "This is not a GOCAD file, or an object before this line ended too early."
            )
        kind = words[1].lower() if len(words) > 1 else ""
        draft = _Draft(line=i)
        body = _body(path, lines, i)
        if kind == "tsurf":
            _fill(draft, path, body)
            surfaces.append(_finish(draft, path, positive, units))
        else:
            for _ in body:  # another kind of object: pass over it
                pass
    if not surfaces:
        raise FormatError(
            f"{path}: found no TSurf, expected 'GOCAD TSurf 1' at the top of one. "
            "Faults are read from TSurf objects; export the surface as such."
        )
    return surfaces


def _body(path: Path, lines: Iterator[tuple[int, str]], start: int) -> Iterator[Line]:
    """Lines of one object, as words, up to its END."""
    for i, line in lines:
        try:
            words = shlex.split(line) if '"' in line else line.split()
        except ValueError:  # an odd quote, as in free-text headers
            words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] == "END":
            return
        if words[0] == "GOCAD":
            raise FormatError(
                f"{path}, line {i}: another object begins, expected END of the one that began on "
                f"line {start}. Export the file again."
            )
        yield i, words
    raise FormatError(
        f"{path}: found no END for the object that began on line {start}. "
        "The file is cut short; export it again."
    )


def _fill(draft: _Draft, path: Path, body: Iterator[Line]) -> None:
    """Sort the lines of one TSurf into the draft."""
    block = ""  # HEADER, PROPERTY_CLASS_HEADER: lines between braces
    for i, words in body:
        if block:
            if block == "HEADER":
                _header_line(draft, " ".join(words))
            if "}" in words[-1]:
                block = ""
        elif "{" in " ".join(words):
            opened, _, rest = " ".join(words).partition("{")
            key = opened.split()[0] if opened.split() else ""
            if key == "HEADER":
                _header_line(draft, rest)
            block = "" if rest.rstrip().endswith("}") else key or "?"
        elif words[0] in VERTEX_WORDS:
            _vertex_line(draft, path, i, words)
        elif words[0] in ALIAS_WORDS:
            _alias_line(draft, path, i, words)
        elif words[0] == "TRGL":
            _triangle_line(draft, path, i, words)
        else:
            _settings_line(draft, path, i, words)


def _header_line(draft: _Draft, text: str) -> None:
    """Take the name from ``name: F1``, also from ``{name: F1}``."""
    key, colon, value = text.strip().strip("{}").partition(":")
    if colon and key.strip() == "name" and value.strip():
        draft.name = value.strip()


def _settings_line(draft: _Draft, path: Path, i: int, words: list[str]) -> None:
    """Direction of z, units, properties; anything else is of no concern here."""
    key, rest = words[0], words[1:]
    if key == "ZPOSITIVE":
        direction = DIRECTIONS.get(rest[0].lower()) if rest else None
        if direction is None:
            raise FormatError(
                f"{path}, line {i}: ZPOSITIVE is {' '.join(rest)!r}, expected Elevation or Depth. "
                "Mend that line."
            )
        draft.positive = direction
    elif key == "AXIS_UNIT":
        if len(rest) != 3:
            raise FormatError(
                f"{path}, line {i}: AXIS_UNIT has {len(rest)} units, expected 3 (x, y, z). "
                "Mend that line."
            )
        draft.axis_units = rest
    elif key == "PROPERTIES":
        draft.properties = [word.strip() for word in rest]
    elif key == "ESIZES":
        draft.sizes = [integer(word, path, i, "size of a property") for word in rest]
    elif key == "NO_DATA_VALUES":
        draft.no_data = [number(word, path, i, "no-data value") for word in rest]


def _vertex_line(draft: _Draft, path: Path, i: int, words: list[str]) -> None:
    """``VRTX id x y z`` or ``PVRTX id x y z value ...``, then perhaps words."""
    n_value = sum(_sizes(draft, path)) if words[0] == "PVRTX" else 0
    if len(words) < 5 + n_value:
        raise FormatError(
            f"{path}, line {i}: {words[0]} has {len(words) - 1} values, expected {4 + n_value} "
            "(id, x, y, z, properties). Mend that line or export the file again."
        )
    x, y, z = (number(word, path, i, "x, y or z") for word in words[2:5])
    values = [number(word, path, i, "value of a property") for word in words[5 : 5 + n_value]]
    _new_id(draft, path, i, words[1], len(draft.points))
    draft.points.append((x, y, z))
    draft.values.append(values)


def _alias_line(draft: _Draft, path: Path, i: int, words: list[str]) -> None:
    """``ATOM id other``: another name of vertex `other`, so of one and the same vertex."""
    if len(words) < 3:
        raise FormatError(
            f"{path}, line {i}: {words[0]} has {len(words) - 1} values, expected its id and that "
            "of a vertex. Mend that line or export the file again."
        )
    _new_id(draft, path, i, words[1], _row(draft, path, i, words[2]))


def _triangle_line(draft: _Draft, path: Path, i: int, words: list[str]) -> None:
    """``TRGL id id id``."""
    if len(words) < 4:
        raise FormatError(
            f"{path}, line {i}: TRGL has {len(words) - 1} values, expected 3 vertex ids. "
            "Mend that line or export the file again."
        )
    a, b, c = (_row(draft, path, i, word) for word in words[1:4])
    draft.triangles.append((a, b, c))


def _new_id(draft: _Draft, path: Path, i: int, word: str, row: int) -> None:
    key = integer(word, path, i, "id of a vertex")
    if key in draft.row_of_id:
        raise FormatError(
            f"{path}, line {i}: vertex id {key} is there twice, expected ids to be unique within "
            "a surface. Export the file again."
        )
    draft.row_of_id[key] = row


def _row(draft: _Draft, path: Path, i: int, word: str) -> int:
    key = integer(word, path, i, "id of a vertex")
    row = draft.row_of_id.get(key)
    if row is None:
        raise FormatError(
            f"{path}, line {i}: vertex {key} is named but not defined above, expected one of "
            f"{len(draft.row_of_id)} ids. Export the file again."
        )
    return row


def _sizes(draft: _Draft, path: Path) -> list[int]:
    """Values per property; 1 each unless ESIZES says otherwise."""
    sizes = draft.sizes or [1] * len(draft.properties)
    if len(sizes) != len(draft.properties) or min(sizes, default=1) < 1:
        raise FormatError(
            f"{path}: the surface that begins on line {draft.line} has {len(draft.properties)} "
            f"PROPERTIES but ESIZES {sizes}, expected one positive size each. Mend the header."
        )
    return sizes


def _finish(draft: _Draft, path: Path, positive: str | None, units: str | None) -> TriSurface:
    """Turn a draft into a surface in metres, elevation up."""
    name = draft.name or path.stem
    what = f"{path.name}: surface {name!r}"
    asked = positive if positive is not None or draft.positive is not None else "up"
    sign = agreed_sign(draft.positive, asked, what)
    declared = draft.axis_units or [None] * 3
    asked_units = (None, None, units)  # a caller's word is that of elevations
    scale = np.array(
        [agreed_scale(*pair, "m", what) for pair in zip(declared, asked_units, strict=True)]
    )
    if not draft.triangles:
        raise FormatError(
            f"{path}: surface {name!r}, which begins on line {draft.line}, has no TRGL lines. "
            "Export it as a triangulated surface."
        )
    points = np.array(draft.points) * scale * [1.0, 1.0, sign]
    data = _vertex_data(draft, path)
    return TriSurface(name, "fault", points, np.array(draft.triangles), vertex_data=data)


def _vertex_data(draft: _Draft, path: Path) -> dict[str, np.ndarray]:
    """Property arrays, (n_vertex,) or (n_vertex, size); NaN for no data."""
    sizes = _sizes(draft, path)
    table = np.full((len(draft.points), sum(sizes)), np.nan)
    for row, values in enumerate(draft.values):
        if values:
            table[row] = values
    data, at = {}, 0
    for k, (key, size) in enumerate(zip(draft.properties, sizes, strict=True)):
        part = table[:, at : at + size].copy()
        if k < len(draft.no_data):
            part[part == draft.no_data[k]] = np.nan
        data[key] = part[:, 0].copy() if size == 1 else part
        at += size
    return data
