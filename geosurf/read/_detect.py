"""Which format a file has, by its first bytes; suffixes are only a hint where content is open.

Signatures exclude each other, so their order does not matter. A table of numbers has no signature:
what it holds follows from the function that reads it.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from pathlib import Path

from geosurf.errors import FormatError
from geosurf.read._guard import opened

HEAD = 8192  # bytes that decide


def _text(pattern: str) -> Callable[[bytes], bool]:
    """A test of the first words of a text, after a byte order mark and blank lines."""
    found = re.compile(rb"\A(?:\xef\xbb\xbf)?\s*(?:" + pattern.encode() + rb")", re.IGNORECASE)
    return lambda head: found.match(head) is not None


def _comments(*words: bytes) -> Callable[[bytes], bool]:
    """A test of comments that begin with # and hold all of some words."""
    return lambda head: (
        head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"#")
        and all(re.search(rb"^#\s*" + word, head, re.M | re.I) for word in words)
    )


def _is_irap(head: bytes) -> bool:
    """A text that begins with -996, or a Fortran record of 32 bytes that does."""
    binary = head[:8] == struct.pack(">ii", 32, -996)
    return binary or head.lstrip().startswith(b"-996")


VTK = re.compile(
    rb"# vtk DataFile Version[^\n]*\n[^\n]*\n\s*(?:ASCII|BINARY)\s+DATASET\s+POLYDATA\b",
    re.IGNORECASE,
)


GEOJSON = re.compile(
    rb"\A(?:\xef\xbb\xbf)?\s*\{.*?\"type\"\s*:\s*\"(?:FeatureCollection|GeometryCollection|Feature|"
    rb"(?:Multi)?(?:Point|LineString|Polygon))\"",
    re.DOTALL,
)


def _is_gltf(head: bytes) -> bool:
    """An object in JSON with the key "asset" and lists that only glTF has."""
    words = (b'"asset"', b'"accessors"', b'"bufferViews"', b'"meshes"', b'"nodes"', b'"scenes"')
    return (
        head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{")
        and sum(word in head for word in words) >= 2
        and b'"coordinates"' not in head
    )


def _is_resqml(head: bytes) -> bool:
    """A zip file whose first files are those of a package of Energistics."""
    words = (b"obj_", b"EpcExternalPartReference", b"resqml")
    opc = b"[Content_Types].xml" in head or b"_rels/" in head or b"docProps/" in head
    return head.startswith(b"PK\x03\x04") and (opc or any(word in head for word in words))


# lines of RMS such as "Float dip" before numbers, or the header of Petrel
ATTRIBUTES = (
    r"#\s*Petrel Points with attributes\b|(?:#[^\n]*\n\s*)*"
    r"(?:(?:float|string|discrete|int|integer)[ \t]+[^\n]*\n\s*)+"
    r"[-+]?\d\S*[ \t]+[-+]?\d\S*[ \t]+[-+]?\d"
)
# kind of line, inline, crossline, three numbers, perhaps a name, the number of the stick
CHARISMA = (
    r"(?:[#!][^\n]*\n\s*)*(?:INLINE|XLINE|CROSSLINE)[ \t]*-[ \t]*-?\d\S*[ \t]+-?\d\S*"
    r"(?:[ \t]+-?[\d.]\S*){3}(?:[ \t]+\S[^\n]*?)?[ \t]+\d+[ \t]*\r?\n"
)

# version, kind, name with two or three numbers behind it, number of logs
RMS_WELL = (
    r"\d+\.\d+[ \t]*\r?\n[^\n]*\n[ \t]*\S[^\n]*?(?:[ \t]+[-+]?\d[\d.eE+-]*){2,3}[ \t]*\r?\n"
    r"[ \t]*\d+[ \t]*\r?\n[ \t]*(?:[A-Za-z]|[-+]?\d\S*[ \t]+[-+]?\d\S*[ \t]+[-+]?\d)"
)
SGRID = _text(r"(?:#[^\n]*\n\s*)*GOCAD[ \t]+SGrid\b")

# name of the format -> test of the first bytes; names of formats as in `geosurf.read`
SIGNATURES: dict[str, Callable[[bytes], bool]] = {
    "irap": _is_irap,
    "zmap": _text(r"(?:![^\n]*\n\s*)*@[^\n]*\bGRID\b"),
    "cps3": _text(r"(?:![^\n]*\n\s*)*FS(?:ASCI|ATTR|LIMI|NROW|XINC)\b"),
    "cps3_lines": _text(r"(?:![^\n]*\n\s*)*FF(?:ASCI|ATTR)\b"),
    "surfer": lambda head: head[:4] in (b"DSAA", b"DSBB", b"DSRB"),
    "storm": _text(r"STORMGRID_(?:BINARY|ASCII)\b"),
    "esri": _text(r"(?:ncols|nrows)[ \t]+\d+[ \t]*\r?\n\s*(?:ncols|nrows|[xy]ll)"),
    "gxf": _comments(rb"POINTS\b", rb"ROWS\b"),
    "earthvision": _comments(rb"Grid_size:", rb"Grid_space:"),
    "netcdf": lambda head: head.startswith((b"CDF\x01", b"CDF\x02", b"CDF\x05", b"\x89HDF\r\n")),
    "tsurf": _text(r"(?:#[^\n]*\n\s*)*GOCAD[ \t]+TSurf\b"),
    "model3d": _text(r"(?:#[^\n]*\n\s*)*GOCAD[ \t]+Model3d\b"),
    "pline": _text(r"(?:#[^\n]*\n\s*)*GOCAD[ \t]+PLine\b"),
    "vset": _text(r"(?:#[^\n]*\n\s*)*GOCAD[ \t]+VSet\b"),
    "vtp": lambda head: b"<VTKFile" in head and re.search(rb"type=.PolyData.", head) is not None,
    # other data sets of this kind go to meshio by their suffix
    "vtk": lambda head: VTK.match(head) is not None,
    "gltf": lambda head: head.startswith(b"glTF") or _is_gltf(head),
    "geojson": lambda head: GEOJSON.search(head) is not None and b'"Topology"' not in head,
    # the index of a shapefile (.shx) begins alike; its first entry is no record number
    "shapefile": lambda head: (
        head.startswith(b"\x00\x00\x27\x0a") and head[100:104] in (b"", b"\x00\x00\x00\x01")
    ),
    "charisma": _text(CHARISMA),
    "attributes": _text(ATTRIBUTES),
    # a TSurf may follow a grid that it was cut from
    "sgrid": lambda head: SGRID(head) and b"GOCAD TSurf" not in head,
    "las": _text(r"(?:#[^\n]*\n\s*)*~V"),
    "geotiff": lambda head: head[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    "petrel_tops": _text(r"#\s*Petrel well tops\b"),
    "petrel_well": _text(r"#\s*WELL TRACE\b"),
    "rms_well": _text(RMS_WELL),
    "resqml": _is_resqml,
}
# what else is recognised, to name it in errors: geosurf does not read these
FOREIGN: dict[str, Callable[[bytes], bool]] = {
    "GOCAD Well": _text(r"(?:#[^\n]*\n\s*)*GOCAD[ \t]+Well\b"),
    "ZIP archive": lambda head: head.startswith(b"PK\x03\x04"),
    "gzip": lambda head: head.startswith(b"\x1f\x8b"),
}


def detect(path: Path) -> str | None:
    """
    Return the name of the format that the content of a file has, or None where it is open.

    Parameters
    ----------
    path : pathlib.Path

    Returns
    -------
    str or None
        A key of `SIGNATURES`.

    Raises
    ------
    InputError
        If it is not a regular file that can be opened.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.txt"
    >>> _ = file.write_text("FSASCI 0 1 COMPUTED 0 1.0E30 0")
    >>> detect(file)
    'cps3'
    """
    return _first(head_of(path), SIGNATURES)


def detect_foreign(path: Path) -> str | None:
    """Return what a file is that geosurf does not read, in words, or None."""
    return _first(head_of(path), FOREIGN)


def refuse_foreign(path: Path) -> None:
    """
    Refuse a file of wells that geosurf recognises and does not read.

    Raises
    ------
    FormatError
    """
    if detect_foreign(path) == "GOCAD Well":
        raise FormatError(
            f"{path}: this is a GOCAD Well, which geosurf does not read. Export the path as a "
            "table with the columns Well, MD, X, Y and Z, and read that with read_wells."
        )


def head_of(path: Path) -> bytes:
    """Return the first bytes of a regular file."""
    with opened(path) as (file, _):
        return file.read(HEAD)


def _first(head: bytes, tests: dict[str, Callable[[bytes], bool]]) -> str | None:
    return next((key for key, fits in tests.items() if fits(head)), None)
