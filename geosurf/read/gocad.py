"""GOCAD TSurf: triangulated surfaces in text.

What files in the wild do, and what is done with it:

- ``ZPOSITIVE Depth`` turns z over; without the word z is elevation.
- ``AXIS_UNIT`` scales each axis to metres; without it lengths are metres.
- ``AXIS_NAME "Z" "Y" "X"`` puts columns in another order.
- ``NAME`` of the coordinate system (else ``DATUM`` and ``PROJECTION``) is the attribute `crs`.
- Keys are in upper or lower case.
- Several TFACE blocks are parts of one surface; ids run through all of them, may
  begin anywhere and skip.
- ``ATOM`` and ``PATOM`` are other names of a vertex: triangles share that vertex.
- Words after the coordinates (``CNXYZ``) are control-node flags and dropped.
- Other objects in the file (SGrid, VSet ...) are ignored.
"""

from __future__ import annotations

import shlex
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.errors import FormatError, InputError
from geosurf.model import TriSurface
from geosurf.read._common import integer, line_blocks, number_rows, read_text
from geosurf.read._gocad_bulk import PlainObject, plain_objects
from geosurf.read._gocad_header import Header
from geosurf.read._guard import refuse_large

VERTEX_WORDS = ("VRTX", "PVRTX")
ALIAS_WORDS = ("ATOM", "PATOM")
AT_A_TIME = 60_000  # words of vertices that become numbers together

Line = tuple[int, list[str]]


@dataclass
class Draft:
    """One TSurf while its lines go by."""

    path: Path
    size: int  # of the file
    line: int
    header: Header = field(default_factory=Header)
    row_of_id: dict[str, int] = field(default_factory=dict)
    n_vertex: int = 0
    words: list[str] = field(default_factory=list)  # of coordinates, three a vertex
    lines: list[int] = field(default_factory=list)  # of those words
    points: list[np.ndarray] = field(default_factory=list)
    valued: list[np.ndarray] = field(default_factory=list)  # rows of vertices with properties
    values: list[np.ndarray] = field(default_factory=list)
    corners: array[int] = field(default_factory=lambda: array("q"))
    pending: list[tuple[int, int, list[str]]] = field(default_factory=list)

    def flush(self) -> None:
        """Turn words of vertices into numbers."""
        # Words of a vertex become numbers in bulk; lines serve for errors only.
        rows = [self.words[k : k + 3] for k in range(0, len(self.words), 3)]
        if rows:
            self.points.append(number_rows(rows, self.lines, self.path, "x, y or z"))
        if self.pending:
            # rows of vertices that have values: VRTX and PVRTX may be mixed
            numbered, lines, values = zip(*self.pending, strict=True)
            self.valued.append(np.array(numbered, dtype=np.int64))
            what = "value of a property"
            self.values.append(number_rows(list(values), lines, self.path, what))
        self.words, self.lines, self.pending = [], [], []


def read_gocad(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
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
    length_unit : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    TriSurface
        Role ``"fault"``.

    Raises
    ------
    InputError
        If there are several surfaces and `name` is not one of them, or only one of several
        equally named ones; or if `positive` or `length_unit` contradicts the file.
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
    surfaces = read_tsurf(path, positive=positive, length_unit=length_unit)
    if len(surfaces) == 1:
        return surfaces[0] if name is None else surfaces[0].renamed(name)

    # several surfaces: exactly one of them has to have the name
    names = [surface.name for surface in surfaces]
    found = [surface for surface in surfaces if surface.name == name]
    if len(found) != 1:
        guess = "" if name is None else did_you_mean(name, names)
        asked = "name= is not given" if name is None else f"{len(found)} are called {name!r}"
        raise InputError(
            f"{path}: the file has {len(surfaces)} surfaces, {names}, but {asked}.{guess} "
            "Select one with name=, or read all with geosurf.read.read_tsurf."
        )
    return found[0]


def read_tsurf(
    path: str | Path, *, positive: str | None = None, length_unit: str | None = None
) -> list[TriSurface]:
    r"""
    Read all TSurf of a GOCAD file.

    Parameters
    ----------
    path : str or pathlib.Path
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    list of TriSurface
        In file order, role ``"fault"``. Vertices in metres, elevation positive up;
        numeric properties in ``vertex_data``, NaN where the file has its no-data value.

    Raises
    ------
    FormatError
        If the file has no TSurf, is cut short, or a line cannot be understood.
    InputError
        If `positive` or `length_unit` contradicts the file or is unknown.

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
    # large plain files in bulk; whatever is unusual in them goes line by line
    plain = plain_objects(path)
    if plain is not None:
        try:
            return _from_bulk(path, path.stat().st_size, plain, positive, length_unit)
        except FormatError:
            pass  # read again by lines, so that the error names its line
    text = read_text(path, final_line_end=False)
    surfaces = []
    for i, kind, body in bodies(path, text):
        draft = Draft(path, len(text), i)
        if kind == "tsurf":
            fill(draft, body)
            surfaces.append(_finish(draft, positive, length_unit))
        else:
            for _ in body:  # another kind of object: pass over it
                pass
    if not surfaces:
        raise FormatError(
            f"{path}: the file has no TSurf object (a line 'GOCAD TSurf 1'). Export the "
            "surface as TSurf."
        )
    return surfaces


def _from_bulk(
    path: Path,
    size: int,
    plain: list[PlainObject],
    positive: str | None,
    length_unit: str | None,
) -> list[TriSurface]:
    """Return the surfaces of vertices and triangles that were read in bulk."""
    surfaces = []
    for one in plain:
        for i, kind, body in bodies(path, one.others):
            draft = Draft(path, size, i)
            if kind == "tsurf":
                fill(draft, body)
                draft.points, draft.n_vertex = [one.points], len(one.points)
                surfaces.append(_finish(draft, positive, length_unit, one.triangles))
            else:
                for _ in body:  # another kind of object: pass over it
                    pass
    if not surfaces:
        raise FormatError(f"{path}: the file has no TSurf object.")
    return surfaces


def bodies(path: Path, text: str) -> Iterator[tuple[int, str, Iterator[Line]]]:
    """Yield first line, kind in lower case and lines of each object; those have to be used up."""
    # A file may hold several objects; each starts with GOCAD and ends with END.
    lines = _numbered_lines(text)
    for i, line in lines:
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].upper() != "GOCAD":
            raise FormatError(
                f"{path}, line {i}: found {line[:40]!r}, expected 'GOCAD TSurf 1'. This is not "
                "a GOCAD file, or the object before this line ended too early."
            )
        yield i, words[1].lower() if len(words) > 1 else "", _body(path, lines, i)


def _body(path: Path, lines: Iterator[tuple[int, str]], start: int) -> Iterator[Line]:
    """Lines of one object, as words, up to its END."""
    for i, line in lines:
        words = quoted_words(line)
        if not words or words[0].startswith("#"):
            continue
        key = words[0].upper()
        if key == "END":
            return

        # an object without END was cut short: its triangles may be missing
        if key == "GOCAD":
            raise FormatError(
                f"{path}, line {i}: a new object begins before the END of the object on line "
                f"{start}. Export the file again."
            )
        yield i, words
    raise FormatError(
        f"{path}: the object that begins on line {start} has no END. The file is truncated; "
        "export it again."
    )


def quoted_words(line: str) -> list[str]:
    """Return the words of a line; those between quotes are one."""
    if '"' not in line:
        return line.split()
    try:
        return shlex.split(line)
    except ValueError:  # an odd quote, as in free-text headers
        return line.split()


def _numbered_lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines of a text, counted from 1."""
    for first, piece in line_blocks(text):
        yield from enumerate(piece.split("\n")[: -1 if piece.endswith("\n") else None], first)


def fill(draft: Draft, body: Iterator[Line]) -> None:
    """Sort the lines of one TSurf into the draft."""
    block = ""  # HEADER, PROPERTY_CLASS_HEADER: lines between braces
    key = ""

    for i, words in body:
        before, key = key, words[0].upper()
        # Inside braces only the header's name matters.
        if block:
            if block == "HEADER":
                draft.header.take_brace_line(" ".join(words))
            if "}" in words[-1]:
                block = ""
        elif key in VERTEX_WORDS:
            _vertex_line(draft, i, key, words)
        elif key == "TRGL":
            _triangle_line(draft, i, words)
        elif key in ALIAS_WORDS:
            _alias_line(draft, i, words)
        # A block opens on this line and may close on it, too.
        elif "{" in " ".join(words):
            opened, _, rest = " ".join(words).partition("{")
            key = opened.split()[0].upper() if opened.split() else before
            if key == "HEADER":
                draft.header.take_brace_line(rest)
            block = "" if rest.rstrip().endswith("}") else key or "?"
        else:
            draft.header.take_line(draft.path, i, words)

    draft.flush()


def _vertex_line(draft: Draft, i: int, key: str, words: list[str]) -> None:
    """``VRTX id x y z`` or ``PVRTX id x y z value ...``, then perhaps words."""
    # how many values a PVRTX has follows from the header
    n_value = sum(draft.header.property_sizes(draft.path, draft.line)) if key == "PVRTX" else 0
    if len(words) < 5 + n_value:
        raise FormatError(
            f"{draft.path}, line {i}: {key} has {len(words) - 1} values, expected {4 + n_value} "
            "(id, x, y, z, properties). Correct that line or export the file again."
        )

    # Coordinates wait as words, and properties with the row of their vertex.
    _new_id(draft, i, words[1], draft.n_vertex)
    draft.words += words[2:5]
    draft.lines.append(i)
    if n_value:
        draft.pending.append((draft.n_vertex, i, words[5 : 5 + n_value]))
    draft.n_vertex += 1

    # in portions: words take many times the memory of numbers
    if len(draft.words) >= AT_A_TIME:
        draft.flush()


def _alias_line(draft: Draft, i: int, words: list[str]) -> None:
    """``ATOM id other``: another name of vertex `other`, so of one and the same vertex."""
    if len(words) < 3:
        raise FormatError(
            f"{draft.path}, line {i}: {words[0]} has {len(words) - 1} values, expected its id and "
            "that of a vertex. Correct that line or export the file again."
        )

    # no vertex is made: two ids lead to one row
    _new_id(draft, i, words[1], row_of(draft, i, words[2]))


def _triangle_line(draft: Draft, i: int, words: list[str]) -> None:
    """``TRGL id id id``."""
    if len(words) < 4:
        raise FormatError(
            f"{draft.path}, line {i}: TRGL has {len(words) - 1} values, expected 3 vertex ids. "
            "Correct that line or export the file again."
        )

    # Nearly all ids are written alike, so a plain look-up comes first.
    rows = draft.row_of_id
    try:
        draft.corners.extend((rows[words[1]], rows[words[2]], rows[words[3]]))
    except KeyError:  # unknown, or written in another way
        draft.corners.extend([row_of(draft, i, word) for word in words[1:4]])


def _key(draft: Draft, i: int, word: str) -> str:
    """Return an id as it is written shortest: 7 for 007."""
    # the usual spelling needs no conversion; 007 and +7 are brought to it
    if word.isascii() and word.isdecimal() and word[0] != "0":
        return word
    return str(integer(word, draft.path, i, "id of a vertex"))


def _new_id(draft: Draft, i: int, word: str, row: int) -> None:
    key = _key(draft, i, word)
    if key in draft.row_of_id:
        raise FormatError(
            f"{draft.path}, line {i}: vertex id {key} occurs twice; ids must be unique within "
            "a surface. Export the file again."
        )
    draft.row_of_id[key] = row


def row_of(draft: Draft, i: int, word: str) -> int:
    """Return the row of the vertex that an id names."""
    key = _key(draft, i, word)
    row = draft.row_of_id.get(key)
    if row is None:
        raise FormatError(
            f"{draft.path}, line {i}: vertex {key} is used but not defined above. Export the "
            "file again."
        )
    return row


def _finish(
    draft: Draft,
    positive: str | None,
    length_unit: str | None,
    triangles: np.ndarray | None = None,
) -> TriSurface:
    """Turn a draft, and triangles if it has none, into a surface in metres, elevation up."""
    path, header = draft.path, draft.header
    name = header.name or path.stem
    what = f"{path.name}: surface {name!r}"

    # points alone are no surface
    if triangles is None:
        triangles = np.array(draft.corners, dtype=np.int64).reshape(-1, 3)
    if not len(triangles):
        raise FormatError(
            f"{path}: surface {name!r}, which begins on line {draft.line}, has no TRGL lines. "
            "Export it as a triangulated surface."
        )

    # order, units and direction of the axes are settled here, once for all vertices
    points = draft.points[0] if len(draft.points) == 1 else np.concatenate(draft.points)
    points = header.to_metres(points, positive, length_unit, what)
    surface = TriSurface(name, "fault", points, triangles, vertex_data=_vertex_data(draft))
    surface.crs = header.crs
    return surface


def _vertex_data(draft: Draft) -> dict[str, np.ndarray]:
    """Property arrays, (n_vertex,) or (n_vertex, size); NaN for no data."""
    header = draft.header

    sizes = header.property_sizes(draft.path, draft.line)
    if not sizes:
        return {}
    refuse_large(
        draft.path,
        8 * draft.n_vertex * sum(sizes),
        draft.size,
        f"a table of {sum(sizes)} properties",
    )

    # Vertices without values (VRTX, ATOM) have NaN in all columns.
    table = np.full((draft.n_vertex, sum(sizes)), np.nan)
    for rows, values in zip(draft.valued, draft.values, strict=True):
        table[rows] = values

    data, at = {}, 0
    for k, (key, size) in enumerate(zip(header.properties, sizes, strict=True)):
        # columns of one property; its own no-data value means NaN
        part = table[:, at : at + size].copy()
        if k < len(header.no_data):
            part[part == header.no_data[k]] = np.nan
        data[key] = part[:, 0].copy() if size == 1 else part
        at += size
    return data
