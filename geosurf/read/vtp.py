"""VTK XML PolyData (.vtp): the mesh format that keeps float64 and names.

meshio does not know it. Read here are the encodings that VTK writes: ascii, inline
base64, appended base64 or raw; plain or with zlib or lzma.
"""

from __future__ import annotations

import base64
import binascii
import lzma
import re
import zlib
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from geosurf.errors import FormatError
from geosurf.model import TriSurface
from geosurf.read._common import read_bytes
from geosurf.read.mesh import split_quads, surface_from_mesh

DTYPES = {
    f"{word}{bits}": f"{kind}{bits // 8}"
    for word, kind in (("Int", "i"), ("UInt", "u"), ("Float", "f"))
    for bits in (8, 16, 32, 64)
    if (word, bits) not in (("Float", 8), ("Float", 16))
}
DECOMPRESS = {
    "vtkZLibDataCompressor": zlib.decompress,
    "vtkLZMADataCompressor": lzma.decompress,
}
DAMAGE = (binascii.Error, zlib.error, lzma.LZMAError, ValueError, MemoryError, EOFError)


@dataclass(frozen=True)
class _File:
    """The XML tree, and how its arrays are encoded."""

    path: Path
    tree: ElementTree.Element
    appended: bytes
    raw: bool
    order: str
    header: np.dtype
    compressor: str | None


def read_vtp(
    path: Path, *, name: str | None = None, positive: str | None = None, units: str | None = None
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
    units : str, optional
        Unit of elevations. Default ``"m"``. Easting and northing are metres.

    Returns
    -------
    TriSurface
        Role ``"fault"``; quads are split, lines and points passed over, numeric point
        data kept.

    Raises
    ------
    FormatError
        If the file is damaged, cut short, or has strips or polygons of more than four corners.
    InputError
        If `positive` or `units` are unknown.
    """
    file = _open(path)
    points, triangles, columns = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], []
    n_point = 0
    for piece in file.tree.iterfind("PolyData/Piece"):
        piece_points = _points(file, piece)
        triangles.append(_polys(file, piece, len(piece_points)) + n_point)
        columns.append(_point_data(file, piece, len(piece_points)))
        points.append(piece_points.astype(np.float64))
        n_point += len(piece_points)
    shared = set.intersection(*(set(column) for column in columns)) if columns else set()
    keys = [key for key in (columns[0] if columns else {}) if key in shared]
    data = {key: np.concatenate([column[key] for column in columns]) for key in keys}
    name = name or _stored_name(file) or path.stem
    return surface_from_mesh(
        path, name, np.concatenate(points), np.concatenate(triangles), data, positive, units
    )


def _open(path: Path) -> _File:
    """Parse the XML; raw appended data are not XML and are set aside first."""
    data = read_bytes(path)
    appended, raw = b"", False
    mark = re.search(rb"<AppendedData([^>]*)>\s*_", data)
    if mark:
        end = data.rfind(b"</AppendedData>")
        if end < mark.end():
            raise FormatError(
                f"{path}, byte {mark.start()}: AppendedData has no end. "
                "The file is cut short; export it again."
            )
        appended, raw = data[mark.end() : end], b"base64" not in mark.group(1)
        data = data[: mark.start()] + data[end + len(b"</AppendedData>") :]
    try:
        tree = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise FormatError(
            f"{path}: no complete XML ({error}). The file is damaged or cut short; export it again."
        ) from error
    if tree.tag != "VTKFile" or tree.get("type") != "PolyData":
        raise FormatError(
            f"{path}: found <{tree.tag} type={tree.get('type')!r}>, expected "
            "<VTKFile type='PolyData'>. Save the surface as PolyData."
        )
    compressor = tree.get("compressor")
    if compressor is not None and compressor not in DECOMPRESS:
        raise FormatError(
            f"{path}: arrays are packed with {compressor}, expected one of "
            f"{', '.join(DECOMPRESS)}, or none. Save the file without compression."
        )
    order = ">" if tree.get("byte_order") == "BigEndian" else "<"
    header = np.dtype(order + ("u8" if tree.get("header_type") == "UInt64" else "u4"))
    return _File(path, tree, appended, raw, order, header, compressor)


def _array(file: _File, node: ElementTree.Element | None, what: str) -> np.ndarray:
    """Return the flat values of a DataArray element."""
    kind = None if node is None else DTYPES.get(str(node.get("type")))
    if node is None or kind is None:
        found = "no array" if node is None else f"an array of type {node.get('type')!r}"
        raise FormatError(
            f"{file.path}: found {found} for {what}, expected numbers. "
            "The file is damaged or no surface; export it again."
        )
    dtype = np.dtype(file.order + kind)
    try:
        if node.get("format") == "ascii":
            return np.array((node.text or "").split(), dtype=dtype)
        return np.frombuffer(_payload(file, node), dtype=dtype)
    except DAMAGE as error:
        raise FormatError(
            f"{file.path}: array {what} cannot be decoded ({error}). "
            "The file is damaged or cut short; export it again."
        ) from error


def _payload(file: _File, node: ElementTree.Element) -> bytes:
    """Bytes of one binary array: block sizes first, then one or several blocks."""
    if node.get("format") == "appended":
        start = int(node.get("offset", "0"))
        offsets = (int(other.get("offset", "0")) for other in file.tree.iter())
        end = min((offset for offset in offsets if offset > start), default=len(file.appended))
        stream = file.appended[start:end] if file.raw else _unbase64(file.appended[start:end])
    else:
        stream = _unbase64((node.text or "").encode("ascii"))
    size = file.header.itemsize
    if not stream:
        return b""
    if file.compressor is None:
        length = int(np.frombuffer(stream[:size], file.header)[0])
        if length > len(stream) - size:
            raise ValueError(f"{length} bytes announced, {len(stream) - size} found")
        return stream[size : size + length]
    n_block = int(np.frombuffer(stream[:size], file.header)[0])
    if n_block == 0:
        return b""
    if 3 + n_block > len(stream) // size:
        raise ValueError(f"{n_block} blocks announced in {len(stream)} bytes")
    packed = np.frombuffer(stream[3 * size : (3 + n_block) * size], file.header)
    ends = np.cumsum(packed.astype(np.int64)) + (3 + n_block) * size
    starts = ends - packed.astype(np.int64)
    unpack = DECOMPRESS[file.compressor]
    return b"".join(
        unpack(stream[a:b]) for a, b in zip(starts.tolist(), ends.tolist(), strict=True)
    )


def _unbase64(text: bytes) -> bytes:
    """Decode base64 that may consist of several runs, each with its own padding."""
    runs = re.findall(rb"[^=]+={0,2}", b"".join(text.split()))
    return b"".join(base64.b64decode(run, validate=True) for run in runs)


def _points(file: _File, piece: ElementTree.Element) -> np.ndarray:
    """Points (n, 3) of a piece."""
    values = _array(file, piece.find("Points/DataArray"), "Points")
    if len(values) % 3:
        raise FormatError(
            f"{file.path}: found {len(values)} numbers for Points, expected three for each. "
            "The file is damaged or cut short; export it again."
        )
    return values.reshape(-1, 3)


def _whole_number(file: _File, node: ElementTree.Element, key: str, default: int) -> int:
    """An attribute that counts something."""
    text = node.get(key) or str(default)
    if not (text.isascii() and text.isdecimal()):
        raise FormatError(
            f"{file.path}: {key} of a <{node.tag}> is {text!r}, expected a whole number. "
            "The file is damaged; export it again."
        )
    return int(text)


def _polys(file: _File, piece: ElementTree.Element, n_point: int) -> np.ndarray:
    """Triangles (n, 3) of a piece; quads are split."""
    if piece.get("NumberOfPoints") != str(n_point):
        raise FormatError(
            f"{file.path}: found {n_point} points, expected {piece.get('NumberOfPoints')}. "
            "The file is damaged; export it again."
        )
    if _whole_number(file, piece, "NumberOfStrips", 0):
        raise FormatError(
            f"{file.path}: found triangle strips, expected triangles. "
            "Triangulate the surface before saving it."
        )
    if piece.get("NumberOfPolys") in (None, "0"):
        return np.empty((0, 3), dtype=np.int64)
    arrays = {node.get("Name"): node for node in piece.iterfind("Polys/DataArray")}
    corners = _array(file, arrays.get("connectivity"), "connectivity").astype(np.int64)
    ends = _array(file, arrays.get("offsets"), "offsets").astype(np.int64)
    count = np.diff(ends, prepend=0)
    if str(len(ends)) != piece.get("NumberOfPolys") or count.sum() != len(corners):
        raise FormatError(
            f"{file.path}: found {len(ends)} cells with {len(corners)} corners, expected "
            f"{piece.get('NumberOfPolys')} cells with {count.sum()}. "
            "The file is damaged; export it again."
        )
    odd = np.flatnonzero((count != 3) & (count != 4))
    if len(odd):
        raise FormatError(
            f"{file.path}: cell {odd[0]} has {count[odd[0]]} corners, expected 3 or 4. "
            "Triangulate the surface before saving it."
        )
    bad = np.flatnonzero((corners < 0) | (corners >= n_point))
    if len(bad):
        raise FormatError(
            f"{file.path}: a cell names point {corners[bad[0]]}, expected 0 to {n_point - 1}. "
            "The file is damaged; export it again."
        )
    # per cell, so that the order of cells is kept
    starts = ends - count
    quads = count == 4
    out = np.empty((len(count), 2, 3), dtype=np.int64)
    out[:, 0] = corners[starts[:, None] + np.arange(3)]
    out[quads] = split_quads(corners[starts[quads, None] + np.arange(4)]).reshape(-1, 2, 3)
    keep = np.ones((len(count), 2), dtype=bool)
    keep[:, 1] = quads
    return out[keep]


def _point_data(file: _File, piece: ElementTree.Element, n_point: int) -> dict[str, np.ndarray]:
    """Numeric point data of a piece, (n_point,) or (n_point, n)."""
    data = {}
    for node in piece.iterfind("PointData/DataArray"):
        key = node.get("Name") or ""
        values = _array(file, node, repr(key))
        width = _whole_number(file, node, "NumberOfComponents", 1)
        if len(values) != n_point * width:
            raise FormatError(
                f"{file.path}: point data {key!r} have {len(values)} values, expected "
                f"{n_point * width}. The file is damaged; export it again."
            )
        data[key] = values if width == 1 else values.reshape(n_point, width)
    return data


def _stored_name(file: _File) -> str | None:
    """Return the string array ``name`` of the field data, if it can be read."""
    for node in file.tree.iterfind("PolyData/FieldData/Array"):
        if node.get("Name") == "name":
            try:
                if node.get("format") == "ascii":  # characters as numbers
                    codes = bytes(int(word) for word in (node.text or "").split())
                else:
                    codes = _payload(file, node)
                return codes.split(b"\0")[0].decode("utf-8") or None
            except DAMAGE:
                return None
    return None
