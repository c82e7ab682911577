"""Triangle meshes through meshio, the one place where geosurf reads with it, and glTF.

meshio prints, warns and ends the process (`sys.exit`) when a file is not what it expects; none of
that gets past this file. z is elevation in metres unless the caller states otherwise; easting and
northing are metres.

glTF 2.0 (ISO/IEC 12113, Khronos) is read by trimesh. Its Y axis points up and its Z axis south:
easting is x, northing is -z, elevation is y [m]. Nodes move, turn and scale their meshes in
float64, so that coordinates are not limited to the float32 of positions. Materials and textures are
not used. What a file announces is compared with its size before trimesh makes room for it.
"""

from __future__ import annotations

import base64
import contextlib
import io
import json
import re
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions.machine import need
from geosurf.errors import FormatError
from geosurf.model import TriSurface
from geosurf.read._common import Request, chosen, noted, warn_of_end
from geosurf.read._guard import damaged, opened, read_bytes, reading_with, same_file
from geosurf.read._placed import split_quads, surface_from_mesh
from geosurf.read.vtp import read_vtu

# ---- gmsh ----------------------------------------
# Counts and tags of a Gmsh file, checked before meshio makes room for them.
#
# meshio makes arrays as long as a file announces, and one as long as the largest tag of a
# node: one spoiled byte asks for gigabytes. What a file announces has to be in it; the format
# (Gmsh reference manual, MSH 2.2 and 4.1) allows sparse tags, which must not be wasteful.


LARGEST_TAG = 10_000_000  # in files with fewer bytes than that
ROW = np.dtype([("tag", "<i4"), ("point", "<f8", 3)])
POINT = np.dtype(("<f8", 3))


def refuse_wrong_counts(path: Path, data: bytes) -> None:
    """
    Refuse a Gmsh file with more nodes than bytes, or tags that no mesh of its size has.

    Parameters
    ----------
    path : pathlib.Path
        For the message.
    data : bytes
        Of the whole file, binary or text.

    Raises
    ------
    FormatError
    """
    _refuse_tag_lines(path, data)

    # version, ascii (0) or binary (1), and bytes of a whole number
    head = re.match(rb"\s*\$MeshFormat\s+([24])\.(\d+)\s+([01])\s+([48])\s", data)
    start = re.search(rb"^\$Nodes[ \t\r]*\n", data, re.M)
    if head is None or start is None:
        return
    version = (head[1] + head[2][:1]).decode()
    if head[3] == b"0":
        end = data.find(b"$EndNodes", start.end())
        words = data[start.end() : end if end >= 0 else None].split()
        tags = [_count(path, word) for word in _tags_of_words(path, words, version)]
    else:
        tags = _tags_of_bytes(path, data, start.end(), version, int(head[4]))

    # meshio allocates up to the largest tag: a sparse one in a small file is damage
    limit = max(LARGEST_TAG, len(data))
    if max(tags, default=0) > limit:
        raise damaged(
            f"{path}: a node has the tag {max(tags)}, but a file of {len(data)} bytes may use tags "
            f"up to {limit} only"
        )


def _refuse_tag_lines(path: Path, data: bytes) -> None:
    """Refuse more lines of strings, numbers and counts before data than there are in the file."""
    for match in re.finditer(rb"\$((?:Node|Element|ElementNode)Data)[^\n]*\n", data):
        # three lists follow: strings, reals, integers, each after a line with its length
        at = match.end()
        for _ in range(3):
            end = data.find(b"\n", at)
            try:
                n = int(data[at : max(end, at)])  # as meshio takes it: with signs and underscores
            except ValueError:
                n = 0
            left = data.count(b"\n", at)
            if n > left:
                raise damaged(
                    f"{path}: {n} lines are announced in section ${match[1].decode()}, and the "
                    f"file has {left} left"
                )
            for _ in range(max(n, 0) + 1):
                at = data.find(b"\n", at) + 1 or len(data)


def _tags_of_words(path: Path, words: list[bytes], version: str) -> list[bytes]:
    """Tags of the nodes of a text: in rows, in blocks of rows (4.0), or before the points (4.1)."""
    if version[0] == "2":
        return words[1::4]
    # version 4: the section's counts, then blocks of four words and their nodes
    tags: list[bytes] = []
    at = 4 if version == "41" else 2
    while at + 4 <= len(words):
        n = _count(path, words[at + 3])
        if 4 * n > len(words) - at - 4:
            raise damaged(
                f"{path}: {n} nodes are announced in section $Nodes, and it has "
                f"{len(words) - at - 4} numbers left"
            )
        at += 4
        tags += words[at : at + n] if version == "41" else words[at : at + 4 * n : 4]
        at += 4 * n

    # meshio makes an array of the section's own count, however many nodes follow
    if len(words) > 1 and _count(path, words[1]) != len(tags):
        raise damaged(
            f"{path}: {int(words[1])} nodes are announced in section $Nodes, and its blocks have "
            f"{len(tags)}"
        )
    return tags


def _count(path: Path, word: bytes) -> int:
    """A number of things or a tag, as a text."""
    if not re.fullmatch(rb"[0-9]{1,18}", word):
        raise damaged(
            f"{path}: found {word[:40].decode('latin-1')!r} in section $Nodes, expected a count or "
            "a tag"
        )
    return int(word)


def _tags_of_bytes(path: Path, data: bytes, at: int, version: str, size: int) -> list[int]:
    """Tags of the nodes of a binary file; whole numbers of version 4.1 have `size` bytes."""

    def taken(kind: np.dtype, n: int) -> np.ndarray:
        """The next `n` things, which have to be there."""
        nonlocal at
        left = max(len(data) - at, 0)
        if n * kind.itemsize > left:
            raise damaged(
                f"{path}, byte {at}: {n} entries are announced in section $Nodes, and the file "
                f"has room for {left // kind.itemsize}"
            )
        at += n * kind.itemsize
        return np.frombuffer(data, kind, n, at - n * kind.itemsize)

    if version[0] == "2":  # the number of nodes as text, then rows without any separator
        end = data.find(b"\n", at)
        text, at = data[at:end].strip(), end + 1
        return taken(ROW, int(text) if text.isdigit() else 0)["tag"].tolist()

    # blocks of rows (4.0), or of tags and then points (4.1), each after its entity and count
    in_rows = version == "40"
    whole = np.dtype("<u8" if in_rows else f"<u{size}")
    n_node = int(taken(whole, 2 if in_rows else 4)[1])
    before = at
    taken(ROW if in_rows else np.dtype((np.void, size + POINT.itemsize)), n_node)
    at = before
    tags: list[int] = []
    while len(tags) < n_node:
        taken(np.dtype("<i4"), 3)
        n = int(taken(whole, 1)[0])
        if in_rows:
            tags += taken(ROW, n)["tag"].tolist()
        else:
            tags += taken(whole, n).tolist()
            taken(POINT, n)
    return tags


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


def read_mesh(path: Path, request: Request) -> TriSurface:
    r"""
    Read a triangulated surface with meshio.

    Parameters
    ----------
    path : pathlib.Path
        ``.vtu``, ``.vtk`` (unstructured grid), ``.obj``, ``.stl``, ``.ply``, ``.off``, ``.msh`` ...
    request : Request
        `name`: Default: the file name without suffix.
        `positive`: Default ``"up"``.
        `length_unit`: Unit of elevations. Default ``"m"``. Easting and northing are metres.

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
    >>> read_mesh(file, Request())
    <TriSurface 'F1' (fault): 3 vertices, 1 triangles>
    """
    if path.suffix.lower() == ".vtu":
        return read_vtu(path, request)
    name = request.named(path)

    # Cheap checks first: meshio waits for ever or exhausts memory on some damaged files.
    data = read_bytes(path)
    _refuse_cut_short(path, data)
    need(f"{path}: this format needs", "meshio")
    import meshio

    # the format by suffix; without it meshio would try one after the other, and print
    kind, printed = FORMATS.get(path.suffix.lower()), io.StringIO()
    if kind is None:
        raise FormatError(
            f"{path}: the suffix of a mesh is one of {', '.join(FORMATS)}. Rename or export it."
        )
    with (
        opened(path) as (file, _),
        contextlib.redirect_stdout(printed),
        contextlib.redirect_stderr(printed),
        warnings.catch_warnings(),
        np.errstate(all="ignore"),
    ):
        warnings.simplefilter("ignore")
        opened_as = same_file(path, file)
        with reading_with(path, "meshio", opened_as, printed):
            obj = kind == "obj"
            source = io.StringIO(_plain_obj(data.decode("latin-1"))) if obj else opened_as
            mesh = meshio.read(source, file_format=kind)
            points = np.asarray(mesh.points, dtype=np.float64)
            triangles = _triangles(path, mesh.cells)

    # texts and objects are no vertex data of a surface
    numeric = {
        key: value
        for key, value in mesh.point_data.items()
        if np.asarray(value).dtype.kind in "biuf"
    }
    return surface_from_mesh(path, name, points, triangles, numeric, request)


def _plain_obj(text: str) -> str:
    """Vertices and corners of an OBJ file alone: meshio knows no colours, nor textures apart."""
    lines, n = [], 0
    for line in text.replace("\r", "").replace("\\\n", " ").split("\n"):
        words = line.split()
        if words[:1] == ["v"]:
            n, words = n + 1, words[:4]
        elif words[:1] == ["f"]:
            corners = [word.split("/")[0] for word in words[1:]]
            # -1 is the last vertex above the line
            words[1:] = [f"{n + 1 + int(w)}" if w[:1] == "-" else w for w in corners]
        else:
            continue
        lines.append(" ".join(words))
    return "\n".join([*lines, ""])


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
        raise damaged(
            f"{path}: the header announces {max(counts)} points, cells or bytes, but the file has "
            f"{len(data)} bytes"
        )


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
        raise damaged(f"{path}: the header has no line 'end_header'")
    if path.suffix.lower() == ".off" and not re.search(rb"\n[ \t\r]*[^\s#]", data):
        raise damaged(f"{path}: the numbers of vertices and faces are missing after the first line")
    if path.suffix.lower() == ".msh":
        # Gmsh: every section that begins has to end, and none ends that did not begin
        names = set(re.findall(rb"^\$(\w+)", data, re.M))
        if not names and data.lstrip().startswith(b"("):  # meshio writes this by default
            raise FormatError(
                f"{path} is a mesh of ANSYS. Write one of Gmsh: meshio.write(path, mesh, "
                "file_format='gmsh')."
            )
        # Each section `$Name` needs its `$EndName`.
        ends = {b"End" + name for name in names if not name.startswith(b"End")}
        if not names or ends ^ {name for name in names if name.startswith(b"End")}:
            raise damaged(f"{path}: a section does not begin with '$Name' and end with '$EndName'")
        refuse_wrong_counts(path, data)

    _refuse_counts(path, data)

    # text is left: its last line has to be whole
    start = data[:256].lstrip().lower()
    if b"\0" in data or start.startswith(b"<"):
        return  # binary and XML notice by themselves
    if not data[-1:].isspace():
        text = data[data.rfind(b"\n") + 1 :].decode("latin-1")
        warn_of_end(path, data.count(b"\n") + 1, text)
    if path.suffix.lower() == ".stl":
        last = data.rstrip().splitlines()[-1:] or [b""]
        if not last[0].strip().lower().startswith(b"endsolid"):
            raise damaged(
                f"{path}: the last line is {last[0][:40].decode('latin-1')!r}, expected 'endsolid'"
            )


# extensions that change neither positions nor triangles
HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_mesh_quantization")
# glTF (x east, y up, z south) -> easting, northing, elevation
GLTF_AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def read_gltf(path: Path, request: Request) -> TriSurface:
    """
    Read a triangulated surface from glTF.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Which mesh, if there are several. Default: the name of the node or mesh, else the
        file name without suffix.
        `positive`: Default ``"up"``.
        `length_unit`: Unit of elevations. Default ``"m"``, which the format states for all axes.

    Returns
    -------
    TriSurface
        Role ``"fault"``.

    Raises
    ------
    FormatError
        If the file is damaged or compressed, or has no triangles.
    InputError
        If there are several meshes and `name` picks none.
    DependencyError
        If trimesh is not installed.
    """
    need(f"{path}: this format needs", "trimesh")
    data = read_bytes(path)
    binary = data.startswith(b"glTF")
    document = _document(path, data)
    files = _refuse_what_is_not_there(path, document, len(data))
    noted("kind", "glTF, binary" if binary else "glTF, text")
    noted("axes", "easting is x, northing is -z, z is y: glTF points Y up")
    meshes = _meshes(path, data, "glb" if binary else "gltf", files)
    order = [one.get("name") for one in _listed(document, "nodes")]
    meshes = dict(sorted(meshes.items(), key=lambda one: one[0] in order and order.index(one[0])))
    noted("names", ", ".join(meshes))
    named = [(name, part) for name, parts in meshes.items() for part in parts]
    title, parts = chosen(path, named, request.name, "meshes")
    points, triangles, n_point = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for part_points, part_triangles in parts:
        points.append(part_points)
        triangles.append(part_triangles + n_point)
        n_point += len(part_points)
    world = np.concatenate(points)
    if not np.isfinite(world).all():
        raise damaged(f"{path}: a position is not a finite number")
    name, crs = request.name or title or path.stem, _crs(document)
    return surface_from_mesh(path, name, world, np.concatenate(triangles), {}, request, crs)


def _document(path: Path, data: bytes) -> dict[str, Any]:
    """The JSON of a file: all of it, or the first chunk."""
    text = data
    if data.startswith(b"glTF"):
        version, size, length, kind = struct.unpack_from("<4xIII4s", data.ljust(20, b"\0"))
        if version != 2 or size != len(data):
            raise damaged(
                f"{path}: found {len(data)} bytes of glTF version {version}, expected {size} of "
                "version 2"
            )
        if kind != b"JSON" or 20 + length > len(data):
            raise damaged(f"{path}: the first chunk announces {length} bytes of {kind!r}")
        text = data[20 : 20 + length]
    with reading_with(path, "the JSON parser"):
        document = json.loads(text.decode("utf-8-sig"))
    if not isinstance(document, dict):
        raise damaged(f"{path}: the JSON is not that of a glTF file")
    required = [str(one) for one in document.get("extensionsRequired") or []]
    other = [one for one in required if not one.startswith(HARMLESS)]
    if other:
        raise FormatError(
            f"{path}: the file needs the glTF extension {other[0]}, which geosurf does not read. "
            "Export it without compression."
        )
    return document


def _refuse_what_is_not_there(path: Path, document: dict[str, Any], size: int) -> dict[str, bytes]:
    """Bytes of files next to this one, if all that is announced fits into these and `size`."""
    files = {}
    for row, entry in enumerate(_listed(document, "buffers")):
        uri = str(entry.get("uri", "data:"))
        if uri.startswith("data:"):
            with reading_with(path, f"the base64 decoder (buffer {row})"):
                base64.b64decode(uri.partition(",")[2], validate=True)
            continue
        # only files next to this one: a path from elsewhere may point anywhere
        if Path(uri).name != uri:
            raise damaged(
                f"{path}: buffer {row} is {uri[:60]!r}, expected a file of the same folder"
            )
        files[uri] = read_bytes(path.parent / uri)
        size += len(files[uri])
    for row, entry in enumerate(_listed(document, "accessors")):
        count = entry.get("count")
        if "sparse" in entry:
            raise FormatError(
                f"{path}: accessor {row} is sparse. Export the file with full arrays."
            )
        if type(count) is not int or not 0 <= count <= size:
            raise damaged(f"{path}: accessor {row} announces {count} values in {size} bytes")
    return files


def _listed(document: dict[str, Any], key: str) -> list[dict[str, Any]]:
    """The entries of a list that have keys."""
    entries = document.get(key)
    return [one for one in entries if isinstance(one, dict)] if isinstance(entries, list) else []


def _meshes(
    path: Path, data: bytes, kind: str, files: dict[str, bytes]
) -> dict[str, list[tuple[np.ndarray, np.ndarray]]]:
    """Points and triangles of each mesh in the world, on the axes of geosurf."""
    import trimesh

    meshes: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    with reading_with(path, "trimesh"):
        scene = trimesh.load_scene(
            io.BytesIO(data), file_type=kind, resolver=files, process=False, merge_primitives=True
        )
        for node in scene.graph.nodes_geometry:
            matrix, title = scene.graph[node]
            mesh = scene.geometry[title]
            if not isinstance(mesh, trimesh.Trimesh):  # points and lines have no area
                continue
            world = np.asarray(mesh.vertices, dtype=np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
            # a mirror turns triangles over
            turn = [0, 2, 1] if np.linalg.det(matrix[:3, :3]) < 0 else [0, 1, 2]
            faces = np.asarray(mesh.faces, dtype=np.int64)[:, turn]
            if len(faces) and not 0 <= faces.min() <= faces.max() < len(world):
                raise damaged(f"{path}: corners of triangles do not fit {len(world)} points")
            meshes.setdefault(str(node), []).append((world @ GLTF_AXES.T, faces))
    return meshes


def _crs(document: dict[str, Any]) -> str | None:
    """The reference system that geosurf writes into the extras of the node of a model."""
    for node in _listed(document, "nodes"):
        extras = node.get("extras")
        crs = extras.get("crs") if isinstance(extras, dict) else None
        if isinstance(crs, str) and crs.strip():
            return crs.strip()
    return None
