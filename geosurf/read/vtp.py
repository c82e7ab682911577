"""Surfaces in VTK XML: PolyData (.vtp), which keeps float64 and names, and UnstructuredGrid (.vtu).

All encodings that VTK writes are read, but lz4: see `geosurf.read.vtp`.
"""

from __future__ import annotations

import base64
import bisect
import lzma
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from geosurf.errors import FormatError
from geosurf.model import TriSurface
from geosurf.read._common import Request
from geosurf.read._guard import ALLOWANCE, damaged, read_bytes, reading_with, refuse_large
from geosurf.read._placed import surface_from_mesh, triangles_of_cells

# ---- vtkxml ----------------------------------------
# Arrays of VTK's XML files: ascii, inline base64, appended base64 or raw; plain, zlib or lzma.
#
# Nothing is unpacked before its size is known: blocks of compressed arrays announce theirs, and
# the sum over a file has a limit. Documents may not declare entities, which expand without end.


DTYPES = {
    f"{word}{bits}": f"{kind}{bits // 8}"
    for word, kind in (("Int", "i"), ("UInt", "u"), ("Float", "f"))
    for bits in (8, 16, 32, 64)
    if (word, bits) not in (("Float", 8), ("Float", 16))
}
COMPRESSORS = ("vtkZLibDataCompressor", "vtkLZMADataCompressor")
COPIES = 6  # of an array in 64 bits that are there at a time, from bytes to the surface
REAL = re.compile(r"[0-9eE.+\-\snaifNAIF]*")
WHOLE = re.compile(r"[0-9+\-\s]*")


@dataclass
class XmlFile:
    """The XML tree, and how its arrays are encoded."""

    path: Path
    size: int
    tree: Element
    appended: bytes
    raw: bool
    order: str
    header: np.dtype
    compressor: str | None
    offsets: list[int] = field(default_factory=list)  # where appended arrays begin, sorted
    taken: int = 0  # bytes of all arrays so far

    def array(self, node: Element | None, what: str) -> np.ndarray:
        """Return the flat values of a DataArray element."""
        kind = None if node is None else DTYPES.get(str(node.get("type")))
        if node is None or kind is None:
            found = "no array" if node is None else f"an array of type {node.get('type')!r}"
            raise damaged(f"{self.path}: found {found} for {what}, expected numbers")

        # byte order is that of the root element
        dtype = np.dtype(self.order + kind)
        with reading_with(self.path, f"the decoder (array {what})"):
            if node.get("format") == "ascii":
                return _of_text(node.text or "", dtype)
            values = np.frombuffer(self.payload(node, what, dtype.itemsize), dtype=dtype)
            node.text = None  # of a large file; each array is read once
            return values

    def payload(self, node: Element, what: str, itemsize: int = 1) -> bytes | memoryview:
        """Bytes of one binary array: block sizes first, then one or several blocks."""
        if node.get("format") == "appended":
            start = int(node.get("offset", "0"))
            # An appended array ends where the next one begins.
            after = bisect.bisect_right(self.offsets, start)
            end = self.offsets[after] if after < len(self.offsets) else len(self.appended)
            self.take(end - start, what, itemsize)
            part = self.appended[max(start, 0) : end]
            stream = part if self.raw else _unbase64(part)
        else:
            stream = _unbase64((node.text or "").encode("ascii"))

        size = self.header.itemsize
        if not stream:
            return b""
        # Without compression: a length, then the bytes.
        if self.compressor is None:
            length = int(np.frombuffer(stream[:size], self.header)[0])
            if length > len(stream) - size:
                raise ValueError(f"{length} bytes announced, {len(stream) - size} found")
            return memoryview(stream)[size : size + length]
        return self._unpacked(stream, what, itemsize)

    def take(self, n_byte: int, what: str, itemsize: int) -> None:
        """Count bytes in 64 bits that will be taken, and refuse more than the file may ask for."""
        self.taken += max(n_byte, 0) * 8 // itemsize
        refuse_large(self.path, COPIES * self.taken, self.size, f"array {what}")

    def _unpacked(self, stream: bytes, what: str, itemsize: int) -> bytes:
        """Unpack the blocks of a compressed array, none beyond its announced size."""
        size = self.header.itemsize
        # Header: number of blocks, their size, size of the last block (0: whole), packed sizes.
        n_block = int(np.frombuffer(stream[:size], self.header)[0])

        # an empty array has no blocks
        if n_block == 0:
            return b""

        # the header has a number for each block: more blocks than numbers are damage
        if 3 + n_block > len(stream) // size:
            raise ValueError(f"{n_block} blocks announced in {len(stream)} bytes")
        head = np.frombuffer(stream[: (3 + n_block) * size], self.header).tolist()
        whole, last, packed = head[1], head[2] or head[1], head[3:]

        # the announced size is checked against the limit before anything is unpacked
        self.take((n_block - 1) * whole + last, what, itemsize)
        parts, at = [], (3 + n_block) * size
        for k, n_packed in enumerate(packed):
            length = last if k == n_block - 1 else whole
            part = _unpack(str(self.compressor), stream[at : at + n_packed], length)
            if len(part) != length:
                raise ValueError(f"block {k} has another size than the {length} bytes announced")
            parts.append(part)
            at += n_packed
        return b"".join(parts)

    def word(self, key: str) -> str | None:
        """Return the first string of an Array in the field data, if it can be read."""
        for node in self.tree.iterfind("*/FieldData/Array"):
            if node.get("Name") == key:
                try:
                    if node.get("format") == "ascii":  # characters as numbers
                        codes = bytes(_of_text(node.text or "", np.dtype("u1")))
                    else:
                        codes = bytes(self.payload(node, key))
                    return codes.split(b"\0")[0].decode("utf-8") or None
                except (
                    ValueError,
                    OverflowError,
                    zlib.error,
                    lzma.LZMAError,
                    EOFError,
                    FormatError,
                ):
                    return None
        return None

    def whole_number(self, node: Element, key: str, default: int) -> int:
        """Return an attribute that counts something."""
        text = node.get(key) or str(default)
        if not (text.isascii() and text.isdecimal() and len(text) < 19):
            raise damaged(
                f"{self.path}: {key} of a <{node.tag}> is {text[:40]!r}, expected a whole number"
            )
        return int(text)


def open_xml(path: Path, kind: str) -> XmlFile:
    """
    Parse a VTK XML file of one kind; raw appended data are not XML and are set aside first.

    Parameters
    ----------
    path : pathlib.Path
    kind : {"PolyData", "UnstructuredGrid"}

    Raises
    ------
    FormatError
        If the XML is incomplete, of another kind, declares entities, or has an unknown
        compression.
    """
    data = read_bytes(path)
    size = len(data)
    appended, raw = b"", False
    mark = re.search(rb"<AppendedData([^>]*)>\s*_", data)
    # Raw bytes after the underscore are not XML; cut them out before parsing.
    if mark:
        end = data.rfind(b"</AppendedData>")
        if end < mark.end():
            raise damaged(f"{path}, byte {mark.start()}: AppendedData has no end")
        appended, raw = data[mark.end() : end], b"base64" not in mark.group(1)
        data = data[: mark.start()] + data[end + len(b"</AppendedData>") :]

    tree = xml_of(path, data)
    if tree.tag != "VTKFile" or tree.get("type") != kind:
        raise FormatError(
            f"{path}: found <{tree.tag} type={tree.get('type')!r}>, expected "
            f"<VTKFile type={kind!r}>. Save the surface as {kind}."
        )

    compressor = tree.get("compressor")
    if compressor is not None and compressor not in COMPRESSORS:
        raise FormatError(
            f"{path}: arrays are compressed with {compressor}, which geosurf cannot read "
            f"({', '.join(COMPRESSORS)} work). Save the file without compression."
        )

    order = ">" if tree.get("byte_order") == "BigEndian" else "<"
    header = np.dtype(order + ("u8" if tree.get("header_type") == "UInt64" else "u4"))
    file = XmlFile(path, size, tree, appended, raw, order, header, compressor)

    # offsets of all arrays, sorted: each array ends where the next one begins
    found = {file.whole_number(node, "offset", 0) for node in tree.iter()}
    file.offsets = sorted(found)
    return file


def xml_of(path: Path, data: bytes, part: str = "the XML") -> Element:
    """Return the tree of a document without a type: entities of one may expand without end."""
    # in wide encodings the letters have zero bytes between them
    plain = data.replace(b"\0", b"") if b"\0" in data[:8] else data  # UTF-16, UTF-32
    if b"<!DOCTYPE" in plain or b"<!ENTITY" in plain:
        raise FormatError(
            f"{path}: {part} declares a document type or entities, which data do not need. Export "
            "the file again, or delete that declaration."
        )
    try:
        return ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise damaged(f"{path}: {part} is incomplete ({error})") from error


def _of_text(text: str, dtype: np.dtype) -> np.ndarray:
    """Numbers in text, as every program takes them."""
    # one check of the whole text: Python would also take underscores and other scripts
    pattern = REAL if dtype.kind == "f" else WHOLE
    if not text.isascii() or not pattern.fullmatch(text):
        raise ValueError("a word is not a number")
    convert = float if dtype.kind == "f" else int
    return np.array(list(map(convert, text.split())), dtype=dtype)


def _unpack(compressor: str, packed: bytes, length: int) -> bytes:
    """Unpack one block, at most one byte more than it should have."""
    if compressor == "vtkZLibDataCompressor":
        return zlib.decompressobj().decompress(packed, length + 1)
    return lzma.LZMADecompressor(memlimit=ALLOWANCE).decompress(packed, length + 1)


def _unbase64(text: bytes) -> bytes:
    """Decode base64 that may consist of several runs, each with its own padding."""
    # header and data are encoded apart, each with its own padding in the middle of the text
    text = text.strip()
    if any(blank in text for blank in (b"\n", b"\r", b" ", b"\t")):
        text = b"".join(text.split())
    parts, at = [], 0
    while at < len(text):
        end = text.find(b"=", at)
        end = len(text) if end < 0 else end + 1 + (text[end + 1 : end + 2] == b"=")
        parts.append(base64.b64decode(text[at:end], validate=True))
        at = end
    return parts[0] if len(parts) == 1 else b"".join(parts)


# cells of an UnstructuredGrid: type -> corners; those without an area are ignored
CORNERS = {5: 3, 9: 4}
PASSED_OVER = (1, 3, 21)  # vertex, line, line of three points


def read_vtp(path: Path, request: Request) -> TriSurface:
    """
    Read a triangulated surface from VTK XML PolyData.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Default: the field data ``name`` (as `geosurf.write` puts it there), else the file
        name without suffix.
        `positive`: Default ``"up"``.
        `length_unit`: Unit of elevations. Default ``"m"``. Easting and northing are metres.

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
    return _surface(file, file.tree.findall("PolyData/Piece"), _polys, request)


def read_vtu(path: Path, request: Request) -> TriSurface:
    """
    Read a triangulated surface from a VTK XML UnstructuredGrid.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`, `positive`, `length_unit`: As for `read_vtp`.

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
    return _surface(file, pieces, _cells, request)


def _surface(
    file: XmlFile,
    pieces: list[Element],
    cells_of: Callable[[XmlFile, Element, int], np.ndarray],
    request: Request,
) -> TriSurface:
    """Join the pieces of a file: points, triangles, point data that all of them have."""
    points, triangles, columns = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], []
    n_point = 0
    # Corners of each piece count from its own first point.
    for piece in pieces:
        piece_points = _points(file, piece)
        if piece.get("NumberOfPoints") != str(len(piece_points)):
            raise damaged(
                f"{file.path}: found {len(piece_points)} points, expected "
                f"{piece.get('NumberOfPoints')}"
            )
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
        raise damaged(
            f"{file.path}: point data of its pieces do not fit together ({error})"
        ) from error
    return surface_from_mesh(
        file.path,
        request.name or file.word("name") or file.path.stem,
        _joined(points),
        _joined(triangles),
        data,
        request,
        file.word("crs"),
    )


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    """All rows; those of one piece are not copied. The first part is empty."""
    return parts[1] if len(parts) == 2 else np.concatenate(parts)


def _points(file: XmlFile, piece: Element) -> np.ndarray:
    """Points (n, 3) of a piece."""
    # a truncated array seldom ends between two points
    values = file.array(piece.find("Points/DataArray"), "Points")
    if len(values) % 3:
        raise damaged(
            f"{file.path}: found {len(values)} numbers for Points, expected three for each"
        )
    return values.reshape(-1, 3)


def _polys(file: XmlFile, piece: Element, n_point: int) -> np.ndarray:
    """Triangles (n, 3) of a piece; quads are split."""
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
    if piece.get("NumberOfCells") in (None, "0"):
        return np.empty((0, 3), dtype=np.int64)
    corners, ends = _corners_and_ends(file, piece, "Cells", "NumberOfCells")

    count = np.diff(ends, prepend=0)
    nodes = {node.get("Name"): node for node in piece.iterfind("Cells/DataArray")}

    # types (n,): one number of VTK for each cell
    types = file.array(nodes.get("types"), "types").astype(np.int64)
    if len(types) != len(ends):
        raise damaged(f"{file.path}: found {len(types)} types for {len(ends)} cells")

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
        raise damaged(
            f"{file.path}: cell {odd[0]} has {count[odd[0]]} corners, expected {wanted[odd[0]]}"
        )
    return triangles_of_cells(file.path, corners, ends[surface], count[surface], n_point)


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
        raise damaged(
            f"{file.path}: found {len(ends)} cells with {len(corners)} corners, expected "
            f"{piece.get(key)} cells with {ends[-1:].sum()}"
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
            raise damaged(
                f"{file.path}: point data {key!r} have {len(values)} values, expected "
                f"{n_point * width}"
            )
        data[key] = values if width == 1 else values.reshape(n_point, width)
    return data
