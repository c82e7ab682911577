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

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from geosurf.conventions.crs import label
from geosurf.errors import FormatError, InputError, warn_of
from geosurf.lazy import xarray as xr
from geosurf.model import FaultSticks, TriSurface
from geosurf.model.base import in_crs_of, with_crs
from geosurf.read._common import (
    Request,
    check_name,
    chosen,
    integer,
    is_looking,
    noted,
    number_rows,
    read_text,
)
from geosurf.read._gocad import Draft, Header, Line, bodies, fill, row_of
from geosurf.read._guard import damaged, read_bytes, refuse_large
from geosurf.read._placed import fault_dataset, points_dataset
from geosurf.read.grids import nodes_from_places

# ---- gocad lines ----------------------------------------
# GOCAD VSet and PLine: points, and polylines that segments join.
#
# Headers, axes, units and direction of z are those of TSurf (`geosurf.read.gocad`). A PLine holds
# ``ILINE`` parts of vertices and ``SEG a b``; segments that follow one another form one line, and a
# closed line repeats its first point. Properties are not used.


BREAK = (-1, -1)  # between two parts: their lines do not join, even at a shared vertex


def read_vset(path: Path, request: Request) -> xr.Dataset:
    r"""
    Read the points of all VSet of a GOCAD file.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`: For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
        `length_unit`: Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point`` [m], positive up.

    Raises
    ------
    FormatError
        If the file has no VSet, is cut short, or a line cannot be understood.
    InputError
        If `positive` or `length_unit` contradicts the file.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "a.vs"
    >>> _ = file.write_text("GOCAD VSet 1\nVRTX 1 5 6 7\nVRTX 2 8 9 1\nEND\n")
    >>> read_vset(file, Request()).elevation.values
    array([7., 1.])
    """
    drafts = [draft for draft, _ in _objects(path, "vset")]
    parts = [_places(draft, request) for draft in drafts]
    return points_dataset(np.concatenate(parts), path.name, _crs(path, drafts))


def read_pline(path: Path, request: Request) -> list[np.ndarray]:
    r"""
    Read the lines of all PLine of a GOCAD file.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`: As for `read_vset`.
        `name`: Only the lines of the object of this name.

    Returns
    -------
    list of ndarray of float64, each (n, 3)
        Easting, northing, elevation [m], in the order of the file.

    Raises
    ------
    FormatError
        If the file has no PLine or no segments, is cut short, or a line cannot be understood.
    InputError
        If `positive` or `length_unit` contradicts the file.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "a.pl"
    >>> _ = file.write_text("GOCAD PLine 1\nILINE\nVRTX 1 0 0 5\nVRTX 2 9 0 5\nSEG 1 2\nEND\n")
    >>> read_pline(file, Request())[0].tolist()
    [[0.0, 0.0, 5.0], [9.0, 0.0, 5.0]]
    """
    return _lines(path, request)[0]


def read_pline_sticks(path: Path, request: Request) -> FaultSticks:
    """
    Read the lines of a GOCAD file as the sticks of one fault.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Name of the fault; default: the file name without suffix.
        `positive`, `length_unit`: As for `read_vset`.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError
        As `read_pline`.
    """
    lines, drafts = _lines(path, request)
    made = FaultSticks(request.named(path), tuple(lines))
    return in_crs_of(made, [SimpleNamespace(crs=_crs(path, drafts))])


def _lines(path: Path, request: Request) -> tuple[list[np.ndarray], list[Draft]]:
    """Lines of all PLine, or of those of a name, and the objects of the file."""
    lines, drafts = [], []
    for draft, segments in _objects(path, "pline"):
        drafts.append(draft)
        points = _places(draft, request)
        if request.name in (None, draft.header.name or path.stem):
            lines += [points[rows] for rows in _chains(segments)]
    check_name(path, [draft.header.name or path.stem for draft in drafts], request.name)
    if not lines:
        raise damaged(f"{path}: the file has no segments (SEG)")
    return lines, drafts


def crs_of_gocad_lines(path: Path) -> str | None:
    """Return the reference system that the PLine of a file declare; None without one.

    Parameters
    ----------
    path : pathlib.Path

    Raises
    ------
    FormatError
        If they declare several.
    """
    return _crs(path, [draft for draft, _ in _objects(path, "pline")])


def _crs(path: Path, drafts: list[Draft]) -> str | None:
    """The system of all objects of a file."""
    systems = list(dict.fromkeys(draft.header.crs for draft in drafts))
    if len(systems) > 1:
        names = ", ".join("none" if one is None else label(one) for one in systems)
        raise FormatError(
            f"{path}: its objects are in several coordinate reference systems: {names}. Write one "
            "file for each."
        )
    return systems[0]


def _objects(path: Path, kind: str) -> Iterator[tuple[Draft, list[tuple[int, int]]]]:
    """Each object of one kind, with its segments as rows of vertices."""
    text, count = read_text(path, final_line_end=False), 0
    for i, body in bodies(path, text, kind):
        draft = Draft(path, len(text), i)
        segments: list[tuple[int, int]] = []
        fill(draft, _without_segments(draft, body, segments))
        count += 1
        yield draft, segments
    noted("objects", f"{count} of the kind {kind}")


def _without_segments(
    draft: Draft, body: Iterator[Line], segments: list[tuple[int, int]]
) -> Iterator[Line]:
    """Lines of an object except ``SEG a b``, which are taken here."""
    for i, words in body:
        if words[0].upper() == "ILINE":
            segments.append(BREAK)
        elif words[0].upper() != "SEG":
            yield i, words
        elif len(words) < 3:
            raise damaged(
                f"{draft.path}, line {i}: SEG has {len(words) - 1} values, expected 2 vertex ids"
            )
        else:
            segments.append((row_of(draft, i, words[1]), row_of(draft, i, words[2])))


def _places(draft: Draft, request: Request) -> np.ndarray:
    """Vertices (n, 3) of an object in metres, elevation up."""
    name = draft.header.name or draft.path.stem
    if not draft.points:
        raise damaged(
            f"{draft.path}: object {name!r}, which begins on line {draft.line}, has no vertices"
        )
    what = f"{draft.path.name}: {name!r}"
    return draft.header.to_metres(np.concatenate(draft.points), request, what) + 0.0


def _chains(segments: list[tuple[int, int]]) -> list[list[int]]:
    """Rows of vertices of each line: a segment goes on where the one before it ended."""
    chains: list[list[int]] = []
    before = BREAK
    for first, last in segments:
        if (first, last) != BREAK and before[1] == first:
            chains[-1].append(last)
        elif (first, last) != BREAK:
            chains.append([first, last])
        before = (first, last)
    return chains


# ---- sgrid ----------------------------------------
# GOCAD SGrid of one layer: a grid of nodes with its points in a second file.
#
# The header (.sg) has AXIS_N and the name of the file of points: ``POINTS_FILE``, big-endian
# float32 (float64 with ``double_precision_binary: on``), or ``ASCII_DATA_FILE``, x y z and
# properties on each line. The first axis runs fastest. Header, axes, units and direction of z are
# those of TSurf. Flags, which mark dead cells and split faces, have no public description and are
# not used.


NULL = 1e20  # coordinates from here on are undefined
WIDE = re.compile(r"\bdouble_precision_binary\s*:\s*on\b", re.IGNORECASE)


@dataclass
class SGrid:
    """What the header of one grid states."""

    path: Path
    header: Header
    shape: tuple[int, ...] = ()
    words: dict[str, str] = field(default_factory=dict)  # of the files
    wide: bool = False  # float64

    def without_own(self, body: Iterator[Line]) -> Iterator[Line]:
        """Lines of an object except those that only grids have, which are taken here."""
        for i, words in body:
            key = words[0].upper()
            if key == "AXIS_N":
                self.shape = tuple(integer(word, self.path, i, "AXIS_N") for word in words[1:4])
                if len(self.shape) != 3 or min(self.shape) < 1:
                    raise damaged(
                        f"{self.path}, line {i}: AXIS_N is {' '.join(words[1:])!r}, expected three "
                        "numbers of nodes"
                    )
            elif key in ("POINTS_FILE", "POINTS_OFFSET", "ASCII_DATA_FILE", "FLAGS_FILE"):
                self.words[key] = " ".join(words[1:])
            else:
                self.wide |= WIDE.search(" ".join(words)) is not None
                yield i, words

    def companion(self, key: str) -> Path:
        """A file next to the header."""
        name = self.words[key].strip("\"'").strip()
        # only files of the same folder: a header from elsewhere may point anywhere
        if not name or Path(name).name != name:
            raise FormatError(
                f"{self.path}: {key} is {name!r}, expected a file of the same folder. Copy it "
                "there and correct the line."
            )
        return self.path.parent / name


def read_sgrid(path: Path, request: Request) -> xr.DataArray:
    r"""
    Read a horizon from an SGrid of one layer.

    Parameters
    ----------
    path : pathlib.Path
        The header; the file of points lies next to it.
    request : Request
        `name`: Name of the horizon.
        `positive`: For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
        `length_unit`: Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    xarray.DataArray
        Elevation [m]; easting and northing for each node, or along the axes.

    Raises
    ------
    FormatError
        If there are several layers, or points are missing, too many or not numbers.
    InputError
        If `positive` or `length_unit` contradicts the file.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.sg"
    >>> _ = file.write_text("GOCAD SGrid 1\nAXIS_N 2 2 1\nASCII_DATA_FILE top.dat\nEND\n")
    >>> _ = file.with_suffix(".dat").write_text("0 0 5\n9 0 6\n0 9 7\n9 9 8\n")
    >>> read_sgrid(file, Request(name="Top")).values.tolist()
    [[5.0, 6.0], [7.0, 8.0]]
    """
    grid, nodes = _nodes(path, request)

    return nodes_from_places(nodes, request.named(path), path, grid.header.crs)


def read_sgrid_fault(path: Path, request: Request) -> xr.Dataset:
    """
    Read a fault from an SGrid of one layer, as a parametric grid.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`: As for `read_sgrid`.
        `name`: Name of the fault. Default: the name in the file, else the file name without suffix.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``(down_dip, along_strike)``.

    Raises
    ------
    FormatError, InputError
        As `read_sgrid`.
    """
    grid, nodes = _nodes(path, request)
    title = request.name or grid.header.name or path.stem
    return fault_dataset(nodes, title, path.name, grid.header.crs)


def _nodes(path: Path, request: Request) -> tuple[SGrid, np.ndarray]:
    """Header, and the nodes (row, column, 3) in metres, elevation up; NaN where undefined."""
    grid = _header(path)
    # a layer may be any of the three axes
    shape = tuple(n for n in grid.shape if n > 1)
    if len(shape) != 2:
        counts = " x ".join(map(str, grid.shape))
        raise FormatError(
            f"{path}: the SGrid has {counts} nodes, expected one layer of them, as in AXIS_N 50 40 "
            "1. Export one layer, or the surface as TSurf."
        )
    expected = shape[0] * shape[1]
    points = _nodes_of_file(grid, expected)
    points[(np.abs(points) >= NULL).any(axis=1)] = np.nan
    if not np.isfinite(points).any():
        raise damaged(f"{path}: all nodes of the SGrid are undefined")
    title = grid.header.name or path.stem
    world = grid.header.to_metres(points, request, f"{path.name}: {title!r}")
    _warn_of_flags(grid, expected)
    noted("names", title)
    noted("nodes", f"{shape[0]} columns x {shape[1]} rows")
    noted("order of values", "the first axis runs fastest")
    return grid, world.reshape(shape[1], shape[0], 3) + 0.0


def _header(path: Path) -> SGrid:
    """The header of the first SGrid of a file."""
    text = read_text(path, final_line_end=False)
    line, body = next(bodies(path, text, "sgrid"))
    draft = Draft(path, len(text), line)
    grid = SGrid(path, draft.header)
    fill(draft, grid.without_own(body))
    if not grid.shape or not {"POINTS_FILE", "ASCII_DATA_FILE"} & set(grid.words):
        raise damaged(
            f"{path}: the SGrid has no line AXIS_N, or no file of points (POINTS_FILE, "
            "ASCII_DATA_FILE)"
        )
    return grid


def _nodes_of_file(grid: SGrid, expected: int) -> np.ndarray:
    """Points (expected, 3) as they stand in their file."""
    if "POINTS_FILE" not in grid.words:
        return _text_points(grid.companion("ASCII_DATA_FILE"), expected)
    path = grid.companion("POINTS_FILE")
    data = read_bytes(path)
    offset = integer(grid.words.get("POINTS_OFFSET", "0"), grid.path, 0, "POINTS_OFFSET")
    width = 8 if grid.wide else 4
    found = (len(data) - offset) / (3 * width)
    if offset < 0 or found != expected:
        raise damaged(f"{path}: found {found:g} points of {3 * width} bytes, expected {expected}")
    refuse_large(path, 24 * expected, len(data), f"{expected} points")
    noted("kind", f"binary points, float{8 * width}")
    values = np.frombuffer(data, f">f{width}", offset=offset).astype(np.float64)
    if not np.isfinite(values).all():
        bad = int(np.argmin(np.isfinite(values))) // 3
        raise damaged(f"{path}: point {bad} is not finite")
    return values.reshape(-1, 3)


def _text_points(path: Path, expected: int) -> np.ndarray:
    """Points of text: x y z first on each line; ``*`` and ``#`` begin comments."""
    texts: list[str] = []
    lines: list[int] = []
    for i, line in enumerate(read_text(path).split("\n"), start=1):
        words = line.split()
        if not words or words[0][0] in "*#":
            continue
        if len(words) < 3:
            raise damaged(f"{path}, line {i}: found {len(words)} values, expected x y z")
        texts += words[:3]
        lines.append(i)
    points = number_rows(texts, lines, path, "x, y or z")
    if len(points) != expected:
        raise damaged(f"{path}: found {len(points)} points, expected {expected}")
    noted("kind", "points in text")
    return points


def _warn_of_flags(grid: SGrid, expected: int) -> None:
    """Name flags that differ between nodes: dead cells may be among them."""
    if "FLAGS_FILE" not in grid.words:
        return
    path = grid.companion("FLAGS_FILE")
    if not path.exists():
        noted("flags", f"none: {path.name} is missing")
        return
    flags = np.frombuffer(read_bytes(path)[: 4 * expected], dtype=">u4")
    count = int((flags != np.median(flags)).sum()) if len(flags) else 0
    noted("flags", f"not used; {count} of {expected} nodes differ from the others")
    if count and not is_looking():
        effect = (
            f"'{path.name}' marks {count} of {expected} nodes of '{grid.path.name}'. geosurf does "
            "not use these flags: dead cells among them become part of the surface."
        )
        remedy = "If cells are dead there, export the surface as TSurf."
        warn_of("flags", grid.header.name or grid.path.stem, effect, remedy)


def read_gocad(path: Path, request: Request) -> TriSurface:
    r"""
    Read the one TSurf of a file, or the one called `name`.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Which surface, where the file has several; otherwise the name to give.
        `positive`: For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
        `length_unit`: Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

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
    >>> read_gocad(file, Request())
    <TriSurface 'F1' (fault): 3 vertices, 1 triangles>
    """
    surfaces = read_tsurf(path, request)
    named = [(surface.name, surface) for surface in surfaces]
    title, matching = chosen(path, named, request.name, "surfaces")
    if len(matching) > 1:
        raise InputError(
            f"{path}: {len(matching)} of {len(surfaces)} surfaces are called {title!r}. Read all "
            "with geosurf.read.read_tsurf."
        )
    return matching[0] if request.name is None else matching[0].renamed(request.name)


def read_tsurf(path: str | Path, request: Request) -> list[TriSurface]:
    r"""
    Read all TSurf of a GOCAD file.

    Parameters
    ----------
    path : str or pathlib.Path
    request : Request
        `positive`: For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
        `length_unit`: Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

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
    >>> read_tsurf(file, Request())[0].vertices[2].tolist()
    [0.0, 9.0, -9.0]
    """
    path = Path(path)
    text = read_text(path, final_line_end=False)
    surfaces = []
    for i, body in bodies(path, text, "tsurf"):
        draft = Draft(path, len(text), i)
        fill(draft, body)
        surfaces.append(_finish(draft, request))
    return surfaces


def _finish(draft: Draft, request: Request) -> TriSurface:
    """Turn a draft into a surface in metres, elevation up."""
    path, header = draft.path, draft.header
    name = header.name or path.stem
    what = f"{path.name}: surface {name!r}"

    # points alone are no surface
    triangles = np.array(draft.corners, dtype=np.int64).reshape(-1, 3)
    if not len(triangles):
        raise FormatError(
            f"{path}: surface {name!r}, which begins on line {draft.line}, has no TRGL lines. "
            "Export it as a triangulated surface."
        )

    # order, units and direction of the axes are settled here, once for all vertices
    points = header.to_metres(np.concatenate(draft.points), request, what)
    surface = TriSurface(name, "fault", points, triangles, vertex_data=_vertex_data(draft))
    return with_crs(surface, header.crs)


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
