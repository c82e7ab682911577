"""Surfaces in VTK XML: PolyData (.vtp), which keeps float64 and names, and UnstructuredGrid (.vtu).

All encodings that VTK writes are read, but lz4: see `geosurf.read._vtkxml`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from geosurf.errors import FormatError
from geosurf.model import TriSurface
from geosurf.read._triangles import surface_from_mesh, triangles_of_cells
from geosurf.read._vtkxml import XmlFile, open_xml

# cells of an UnstructuredGrid: type -> corners; those without an area are ignored
CORNERS = {5: 3, 9: 4}
PASSED_OVER = (1, 3, 21)  # vertex, line, line of three points


def read_vtp(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> TriSurface:
    """
    Read a triangulated surface from VTK XML PolyData.

    Parameters
    ----------
    path : pathlib.Path
    name : str, optional
        Default: the field data ``name`` (as `geosurf.write` puts it there), else the
        file name without suffix.
    positive : {"up", "down"}, optional
        Default ``"up"``.
    length_unit : str, optional
        Unit of elevations. Default ``"m"``. Easting and northing are metres.

    Returns
    -------
    TriSurface
        Role ``"fault"``; quads are split, lines and points ignored, numeric point
        data kept.

    Raises
    ------
    FormatError
        If the file is damaged, cut short, or has strips or polygons of more than four corners.
    InputError
        If `positive` or `length_unit` is unknown.
    """
    file = open_xml(path, "PolyData")
    return _surface(file, file.tree.findall("PolyData/Piece"), _polys, name, positive, length_unit)


def read_vtu(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> TriSurface:
    """
    Read a triangulated surface from a VTK XML UnstructuredGrid.

    Parameters
    ----------
    path, name, positive, length_unit
        As for `read_vtp`.

    Returns
    -------
    TriSurface
        As `read_vtp`.

    Raises
    ------
    FormatError
        If the file is damaged, cut short, or has cells other than triangles and quads.
    InputError
        If `positive` or `length_unit` is unknown.
    """
    file = open_xml(path, "UnstructuredGrid")
    pieces = file.tree.findall("UnstructuredGrid/Piece")
    return _surface(file, pieces, _cells, name, positive, length_unit)


def _surface(
    file: XmlFile,
    pieces: list[Element],
    cells_of: Callable[[XmlFile, Element, int], np.ndarray],
    name: str | None,
    positive: str | None,
    length_unit: str | None,
) -> TriSurface:
    """Join the pieces of a file: points, triangles, point data that all of them have."""
    points, triangles, columns = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], []
    n_point = 0
    # Corners of each piece count from its own first point.
    for piece in pieces:
        piece_points = _points(file, piece)
        cells = cells_of(file, piece, len(piece_points))
        triangles.append(cells + n_point if n_point else cells)
        columns.append(_point_data(file, piece, len(piece_points)))
        points.append(piece_points.astype(np.float64, copy=False))
        n_point += len(piece_points)

    # Point data that not all pieces have cannot become one column.
    shared = set.intersection(*(set(column) for column in columns)) if columns else set()
    keys = [key for key in (columns[0] if columns else {}) if key in shared]
    try:
        data = {key: np.concatenate([column[key] for column in columns]) for key in keys}
    except ValueError as error:
        raise FormatError(
            f"{file.path}: point data of its pieces do not fit together ({error}). "
            "Export the file again."
        ) from error
    found = surface_from_mesh(
        file.path,
        name or file.word("name") or file.path.stem,
        _joined(points),
        _joined(triangles),
        data,
        positive,
        length_unit,
    )
    found.crs = file.word("crs")
    return found


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    """All rows; those of one piece are not copied. The first part is empty."""
    return parts[1] if len(parts) == 2 else np.concatenate(parts)


def _points(file: XmlFile, piece: Element) -> np.ndarray:
    """Points (n, 3) of a piece."""
    # a truncated array seldom ends between two points
    values = file.array(piece.find("Points/DataArray"), "Points")
    if len(values) % 3:
        raise FormatError(
            f"{file.path}: found {len(values)} numbers for Points, expected three for each. "
            "The file is damaged or truncated; export it again."
        )
    return values.reshape(-1, 3)


def _polys(file: XmlFile, piece: Element, n_point: int) -> np.ndarray:
    """Triangles (n, 3) of a piece; quads are split."""
    _refuse_other_count(file, piece, n_point)
    if file.whole_number(piece, "NumberOfStrips", 0):
        raise FormatError(
            f"{file.path}: found triangle strips, expected triangles. "
            "Triangulate the surface before saving it."
        )
    if piece.get("NumberOfPolys") in (None, "0"):
        return np.empty((0, 3), dtype=np.int64)

    # count (n,): corners of each cell, from where cells end
    corners, ends = _corners_and_ends(file, piece, "Polys", "NumberOfPolys")
    return triangles_of_cells(file.path, corners, ends, np.diff(ends, prepend=0), n_point)


def _cells(file: XmlFile, piece: Element, n_point: int) -> np.ndarray:
    """Triangles (n, 3) of a piece of an UnstructuredGrid; quads are split, lines ignored."""
    _refuse_other_count(file, piece, n_point)
    if piece.get("NumberOfCells") in (None, "0"):
        return np.empty((0, 3), dtype=np.int64)
    corners, ends = _corners_and_ends(file, piece, "Cells", "NumberOfCells")

    count = np.diff(ends, prepend=0)
    nodes = {node.get("Name"): node for node in piece.iterfind("Cells/DataArray")}

    # types (n,): one number of VTK for each cell
    types = file.array(nodes.get("types"), "types").astype(np.int64)
    if len(types) != len(ends):
        raise FormatError(
            f"{file.path}: found {len(types)} types for {len(ends)} cells. "
            "The file is damaged; export it again."
        )

    # Types of VTK: 5 triangle, 9 quad; points and lines without area are ignored.
    surface = np.isin(types, list(CORNERS))
    other = np.flatnonzero(~surface & ~np.isin(types, PASSED_OVER))
    if len(other):
        raise FormatError(
            f"{file.path}: cell {other[0]} is of VTK type {types[other[0]]}, expected triangles "
            "(5) or quads (9). Export the surface only, triangulated."
        )

    # the type states how many corners a cell has: a damaged file may disagree
    wanted = np.where(types == 9, 4, 3)
    odd = np.flatnonzero(surface & (count != wanted))
    if len(odd):
        raise FormatError(
            f"{file.path}: cell {odd[0]} has {count[odd[0]]} corners, expected {wanted[odd[0]]}. "
            "The file is damaged; export it again."
        )
    return triangles_of_cells(file.path, corners, ends[surface], count[surface], n_point)


def _refuse_other_count(file: XmlFile, piece: Element, n_point: int) -> None:
    if piece.get("NumberOfPoints") != str(n_point):
        raise FormatError(
            f"{file.path}: found {n_point} points, expected {piece.get('NumberOfPoints')}. "
            "The file is damaged; export it again."
        )


def _corners_and_ends(
    file: XmlFile, piece: Element, place: str, key: str
) -> tuple[np.ndarray, np.ndarray]:
    """Corners of all cells, and where each cell's end."""
    arrays = {node.get("Name"): node for node in piece.iterfind(f"{place}/DataArray")}
    corners = file.array(arrays.get("connectivity"), "connectivity").astype(np.int64, copy=False)
    ends = file.array(arrays.get("offsets"), "offsets").astype(np.int64, copy=False)
    # Offsets are the ends of cells in `connectivity`: they rise up to its length.
    falls = bool((np.diff(ends, prepend=0) < 0).any())
    if str(len(ends)) != piece.get(key) or falls or ends[-1:].sum() != len(corners):
        raise FormatError(
            f"{file.path}: found {len(ends)} cells with {len(corners)} corners, expected "
            f"{piece.get(key)} cells with {ends[-1:].sum()}. The file is damaged; export it again."
        )
    return corners, ends


def _point_data(file: XmlFile, piece: Element, n_point: int) -> dict[str, np.ndarray]:
    """Numeric point data of a piece, (n_point,) or (n_point, n)."""
    data = {}
    for node in piece.iterfind("PointData/DataArray"):
        key = node.get("Name") or ""

        # width: values for each point, as for a vector
        values = file.array(node, repr(key))
        width = file.whole_number(node, "NumberOfComponents", 1)
        if len(values) != n_point * width:
            raise FormatError(
                f"{file.path}: point data {key!r} have {len(values)} values, expected "
                f"{n_point * width}. The file is damaged; export it again."
            )
        data[key] = values if width == 1 else values.reshape(n_point, width)
    return data
