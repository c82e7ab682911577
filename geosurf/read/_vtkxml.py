"""Arrays of VTK's XML files: ascii, inline base64, appended base64 or raw; plain, zlib or lzma.

Nothing is unpacked before its size is known: blocks of compressed arrays announce theirs, and
the sum over a file has a limit. Documents may not declare entities, which expand without end.
"""

from __future__ import annotations

import base64
import binascii
import bisect
import lzma
import re
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._guard import ALLOWANCE, read_bytes, refuse_large

DTYPES = {
    f"{word}{bits}": f"{kind}{bits // 8}"
    for word, kind in (("Int", "i"), ("UInt", "u"), ("Float", "f"))
    for bits in (8, 16, 32, 64)
    if (word, bits) not in (("Float", 8), ("Float", 16))
}
COMPRESSORS = ("vtkZLibDataCompressor", "vtkLZMADataCompressor")
# what these decoders raise for bytes that they cannot take
DAMAGE = (binascii.Error, zlib.error, lzma.LZMAError, ValueError, OverflowError, EOFError)
COPIES = 6  # of an array in 64 bits that are there at a time, from bytes to the surface
REAL = re.compile(r"[0-9eE.+\-\snaifNAIF]*")
WHOLE = re.compile(r"[0-9+\-\s]*")


@dataclass
class XmlFile:
    """The XML tree, and how its arrays are encoded."""

    path: Path
    size: int
    tree: ElementTree.Element
    appended: bytes
    raw: bool
    order: str
    header: np.dtype
    compressor: str | None
    offsets: list[int] = field(default_factory=list)  # where appended arrays begin, sorted
    taken: int = 0  # bytes of all arrays so far

    def array(self, node: ElementTree.Element | None, what: str) -> np.ndarray:
        """Return the flat values of a DataArray element."""
        kind = None if node is None else DTYPES.get(str(node.get("type")))
        if node is None or kind is None:
            found = "no array" if node is None else f"an array of type {node.get('type')!r}"
            raise FormatError(
                f"{self.path}: found {found} for {what}, expected numbers. The file is damaged "
                "or does not hold a surface; export it again."
            )

        # byte order is that of the root element
        dtype = np.dtype(self.order + kind)
        try:
            if node.get("format") == "ascii":
                return _of_text(node.text or "", dtype)
            values = np.frombuffer(self.payload(node, what, dtype.itemsize), dtype=dtype)
            node.text = None  # of a large file; each array is read once
            return values
        except DAMAGE as error:
            if isinstance(error, FormatError):
                raise
            raise FormatError(
                f"{self.path}: array {what} cannot be decoded ({error}). The file is damaged "
                "or truncated; export it again."
            ) from error

    def payload(
        self, node: ElementTree.Element, what: str, itemsize: int = 1
    ) -> bytes | memoryview:
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
                except DAMAGE:
                    return None
        return None

    def whole_number(self, node: ElementTree.Element, key: str, default: int) -> int:
        """Return an attribute that counts something."""
        text = node.get(key) or str(default)
        if not (text.isascii() and text.isdecimal() and len(text) < 19):
            raise FormatError(
                f"{self.path}: {key} of a <{node.tag}> is {text[:40]!r}, expected a whole number. "
                "The file is damaged; export it again."
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
            raise FormatError(
                f"{path}, byte {mark.start()}: AppendedData has no end. The file is truncated; "
                "export it again."
            )
        appended, raw = data[mark.end() : end], b"base64" not in mark.group(1)
        data = data[: mark.start()] + data[end + len(b"</AppendedData>") :]

    refuse_entities(path, data)
    try:
        tree = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise FormatError(
            f"{path}: the XML is incomplete ({error}). The file is damaged or truncated; "
            "export it again."
        ) from error
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


def refuse_entities(path: Path, data: bytes) -> None:
    """Refuse XML that declares a document type: its entities may expand without end."""
    # in wide encodings the letters have zero bytes between them
    plain = data.replace(b"\0", b"") if b"\0" in data[:8] else data  # UTF-16, UTF-32
    if b"<!DOCTYPE" in plain or b"<!ENTITY" in plain:
        raise FormatError(
            f"{path}: the XML declares a document type or entities, which mesh files do not need. "
            "Export the file again, or delete that declaration."
        )


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
