"""Triangle meshes through meshio: the one place where geosurf reads with it.

meshio prints, warns and ends the process (`sys.exit`) when a file is not what it
expects; none of that gets past this file. z is elevation in metres unless the caller states
otherwise; easting and northing are metres.
"""

from __future__ import annotations

import contextlib
import io
import re
import struct
import warnings
import zlib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import ParseError

import numpy as np

from geosurf.conventions.packages import need
from geosurf.errors import FormatError
from geosurf.model import TriSurface
from geosurf.read._guard import opened, read_bytes, same_file
from geosurf.read._hdf5 import refuse_bombs
from geosurf.read._triangles import split_quads, surface_from_mesh
from geosurf.read._vtkxml import refuse_entities
from geosurf.read.gmsh import refuse_wrong_counts
from geosurf.read.vtp import read_vtu

# What damaged files make meshio raise. Its readers index, unpack and convert whatever they find,
# and its own errors have no common root, so that its one call catches what Python itself raises.
DAMAGE = (
    SystemExit,
    ParseError,
    struct.error,
    zlib.error,
    ArithmeticError,
    AssertionError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    TypeError,
    UnboundLocalError,
    ValueError,
)
# suffix -> name of the format in meshio, which would try others, some of them for ever
FORMATS = {
    ".vtk": "vtk", ".obj": "obj", ".stl": "stl", ".ply": "ply", ".off": "off", ".msh": "gmsh",
    ".inp": "abaqus",
}  # fmt: skip
# numbers in headers that meshio makes room for
COUNTS = {
    ".vtk": re.compile(
        rb"^(?:POINTS|CELLS|CELL_TYPES|POINT_DATA|CELL_DATA)[ \t]+([0-9]+)(?:[ \t]+([0-9]+))?", re.M
    ),
    ".ply": re.compile(rb"^element[ \t]+\w+[ \t]+([0-9]+)", re.M),
    ".off": re.compile(rb"\AOFF\s+(?:#.*\s+)*([0-9]+)[ \t]+([0-9]+)"),
}
# cells other than surfaces, which a file may also hold
PASSED_OVER = ("vertex", "line", "line3")


def read_mesh(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> TriSurface:
    r"""
    Read a triangulated surface with meshio.

    Parameters
    ----------
    path : pathlib.Path
        ``.vtu``, ``.vtk`` (unstructured grid), ``.obj``, ``.stl``, ``.ply``, ``.off``, ``.msh`` ...
    name : str, optional
        Default: the file name without suffix.
    positive : {"up", "down"}, optional
        Default ``"up"``.
    length_unit : str, optional
        Unit of elevations. Default ``"m"``. Easting and northing are metres.

    Returns
    -------
    TriSurface
        Role ``"fault"``. Quads are split along the diagonal of their first corner;
        lines and points are ignored; numeric point data are kept.

    Raises
    ------
    FormatError
        If the file is damaged, of a kind that meshio does not know, or holds volumes.
    InputError
        If `positive` or `length_unit` is unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "F1.obj"
    >>> _ = file.write_text("v 0 0 0\nv 9 0 0\nv 0 9 9\nf 1 2 3\n")
    >>> read_mesh(file)
    <TriSurface 'F1' (fault): 3 vertices, 1 triangles>
    """
    if path.suffix.lower() == ".vtu":
        return read_vtu(path, name=name, positive=positive, length_unit=length_unit)
    name = name or path.stem

    # Cheap checks first: meshio waits for ever or exhausts memory on some damaged files.
    _refuse_cut_short(path, read_bytes(path))
    mesh = _meshio_read(path)
    try:
        points = np.asarray(mesh.points, dtype=np.float64)
        triangles = _triangles(path, mesh.cells)
    except (TypeError, ValueError, OverflowError) as error:
        raise FormatError(
            f"{path}: points or cells are incomplete ({error}). The file is damaged or "
            "truncated; export it again."
        ) from error

    # texts and objects are no vertex data of a surface
    numeric = {
        key: value
        for key, value in mesh.point_data.items()
        if np.asarray(value).dtype.kind in "biuf"
    }
    return surface_from_mesh(path, name, points, triangles, numeric, positive, length_unit)


def _meshio_read(path: Path) -> Any:
    """Return a meshio mesh; prints, warnings and exits become a FormatError."""
    need(f"{path}: this format needs", "meshio")
    import meshio

    said = io.StringIO()

    # the format by suffix; without it meshio would try one after the other
    kind = FORMATS.get(path.suffix.lower())
    with opened(path) as (file, _):
        name = same_file(path, file) if kind else str(path)
        try:
            with (
                contextlib.redirect_stdout(said),
                contextlib.redirect_stderr(said),
                warnings.catch_warnings(),
                np.errstate(all="ignore"),
            ):
                warnings.simplefilter("ignore")
                return meshio.read(name, file_format=kind)
        except (meshio.ReadError, *DAMAGE) as error:
            # what meshio printed says more than its error, where it printed anything
            reason = " ".join(said.getvalue().split()) or f"{type(error).__name__}: {error}"
            raise FormatError(
                f"{path}: meshio cannot read it ({reason.replace(name, path.name)[:200]}). The "
                "file is damaged or of an unsupported kind; export it as .vtp or GOCAD .ts."
            ) from error


def _refuse_counts(path: Path, data: bytes) -> None:
    """Refuse a file whose header announces more points or cells than it has bytes."""
    suffix = path.suffix.lower()
    pattern = COUNTS.get(suffix)
    words = [w for match in pattern.finditer(data) for w in match.groups() if w] if pattern else []

    # 19 digits are more than any file has: no need to convert them
    counts = [int(word) if len(word) < 19 else 1 << 60 for word in words]
    # Binary STL: 80 bytes of header, a count, then 50 bytes for each triangle.
    if suffix == ".stl" and len(data) >= 84 and not data[:80].lstrip().startswith(b"solid"):
        counts.append(50 * int.from_bytes(data[80:84], "little"))

    # No element takes less than one byte.
    if max(counts, default=0) > len(data):
        raise FormatError(
            f"{path}: the header announces {max(counts)} points, cells or bytes, but the file "
            f"has {len(data)} bytes. It is damaged or truncated; export it again."
        )


def _refuse_foreign_data(path: Path, data: bytes) -> None:
    """Look at the files that XDMF refers to as at any other: what is read of them has a limit."""
    refuse_entities(path, data)
    try:
        items = list(ElementTree.fromstring(data).iter("DataItem"))
    except (ParseError, ValueError, LookupError) as error:
        raise FormatError(
            f"{path}: the XML is incomplete ({error}). The file is damaged or truncated; "
            "export it again."
        ) from error
    for item in items:
        # HDF parts are written as file:path; other formats name a file.
        kind, text = (item.get("Format") or "XML").upper(), (item.text or "").strip()
        if kind == "XML":
            continue
        other = path.parent / (text.split(":")[0] if kind == "HDF" else text)
        with opened(other) as (file, size):
            if kind != "HDF":
                continue
            import h5py

            try:
                with h5py.File(same_file(other, file), "r") as held:
                    refuse_bombs(other, held, size)
            except (OSError, RuntimeError, ValueError, LookupError, TypeError) as error:
                if isinstance(error, FormatError):
                    raise
                raise FormatError(
                    f"{other}: not an HDF5 file ({error}). Copy it again into the folder "
                    f"of {path.name}."
                ) from error


def _triangles(path: Path, blocks: Any) -> np.ndarray:
    """All triangles and split quads, int64 (n, 3)."""
    parts = [np.empty((0, 3), dtype=np.int64)]
    for block in blocks:
        # lines and points may come along; cells of other kinds mean that this is not a surface
        if block.type == "triangle":
            parts.append(np.asarray(block.data).reshape(-1, 3).astype(np.int64))
        elif block.type == "quad":
            parts.append(split_quads(block.data).astype(np.int64))
        elif block.type not in PASSED_OVER:
            raise FormatError(
                f"{path}: found {len(block.data)} cells of type {block.type!r}, expected triangles "
                "or quads. Export the surface only, triangulated."
            )
    return np.concatenate(parts)


def _refuse_cut_short(path: Path, data: bytes) -> None:
    """Refuse text that stops in mid-line: its last number may be cut and still parse."""
    if path.suffix.lower() == ".ply" and not re.search(rb"^[ \t]*end_header[ \t\r]*$", data, re.M):
        # meshio would look for it for ever
        raise FormatError(
            f"{path}: the header has no line 'end_header'. The file is truncated or not a PLY "
            "file; export it again."
        )
    if path.suffix.lower() == ".off" and not re.search(rb"\n[ \t\r]*[^\s#]", data):
        raise FormatError(  # meshio would look for it for ever
            f"{path}: the numbers of vertices and faces are missing after the first line. The "
            "file is truncated or not an OFF file; export it again."
        )
    if path.suffix.lower() == ".msh":
        # Gmsh: every section that begins has to end, and none ends that did not begin
        names = set(re.findall(rb"^\$(\w+)", data, re.M))
        # Each section `$Name` needs its `$EndName`.
        ends = {b"End" + name for name in names if not name.startswith(b"End")}
        if not names or ends ^ {name for name in names if name.startswith(b"End")}:
            raise FormatError(  # meshio would look for the end of a section for ever
                f"{path}: a section does not begin with '$Name' and end with '$EndName'. The "
                "file is truncated or not a Gmsh file; export it again."
            )
        refuse_wrong_counts(path, data)

    if path.suffix.lower() == ".xdmf":
        _refuse_foreign_data(path, data)
    _refuse_counts(path, data)

    # text is left: its last line has to be whole
    start = data[:256].lstrip().lower()
    if b"\0" in data or start.startswith(b"<"):
        return  # binary and XML notice by themselves
    if not data[-1:].isspace():
        line = data.count(b"\n") + 1
        raise FormatError(
            f"{path}, line {line}: the last line has no line end, so the file may be "
            "truncated. Export it again, or add a line end if the file is complete."
        )
    if path.suffix.lower() == ".stl":
        last = data.rstrip().splitlines()[-1:] or [b""]
        if not last[0].strip().lower().startswith(b"endsolid"):
            raise FormatError(
                f"{path}: the last line is {last[0][:40].decode('latin-1')!r}, expected "
                "'endsolid'. The file is truncated; export it again."
            )
