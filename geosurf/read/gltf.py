"""Surfaces in glTF 2.0 (.glb, .gltf): triangles of meshes, placed by their nodes.

The format is ISO/IEC 12113 (Khronos glTF 2.0). Its Y axis points up and its Z axis south: easting
is x, northing is -z, elevation is y [m]. Nodes move, turn and scale their meshes in float64, so
that coordinates are not limited to the float32 of positions. Materials and textures are not used.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.errors import FormatError
from geosurf.model import TriSurface
from geosurf.read._choice import chosen
from geosurf.read._guard import read_bytes
from geosurf.read._noted import noted
from geosurf.read._triangles import surface_from_mesh

TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
TRIANGLES, FLAT = 4, (0, 1, 2, 3)  # modes of primitives: points and lines have no area
# extensions that change neither positions nor triangles
HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_mesh_quantization")
DEPTH = 64  # nodes below one another
# glTF (x east, y up, z south) -> easting, northing, elevation
AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


Part = tuple[np.ndarray, np.ndarray]  # points (n, 3) and triangles (m, 3)


@dataclass(frozen=True)
class Document:
    """The JSON of a file, and the bytes that it refers to."""

    path: Path
    json: dict[str, Any]
    binary: bytes | None  # the second chunk of a .glb

    def item(self, kind: str, index: Any) -> dict[str, Any]:
        """One entry of a list such as "meshes"."""
        entries = self.json.get(kind)
        whole = isinstance(index, int) and not isinstance(index, bool)
        if not isinstance(entries, list) or not whole or not 0 <= index < len(entries):
            raise self.damaged(f"entry {index!r} of {kind!r} is missing")
        if not isinstance(entries[index], dict):
            raise self.damaged(f"entry {index} of {kind!r} has no keys")
        return dict(entries[index])

    def damaged(self, reason: str) -> FormatError:
        """An error about the structure of the file."""
        return FormatError(f"{self.path}: {reason}. The glTF file is damaged; export it again.")


def read_gltf(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> TriSurface:
    """
    Read a triangulated surface from glTF.

    Parameters
    ----------
    path : pathlib.Path
    name : str, optional
        Which mesh, if there are several. Default: the name of the node or mesh, else the file name
        without suffix.
    positive : {"up", "down"}, optional
        Default ``"up"``.
    length_unit : str, optional
        Unit of elevations. Default ``"m"``, which the format states for all axes.

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
    """
    document = _document(path, read_bytes(path))
    required = document.json.get("extensionsRequired") or []
    other = [str(one) for one in required if not str(one).startswith(HARMLESS)]
    if other:
        raise FormatError(
            f"{path}: the file needs the glTF extension {other[0]}, which geosurf does not read. "
            "Export it without compression."
        )
    meshes: dict[str, list[Part]] = {}
    for title, parts in _placed_meshes(document):
        meshes.setdefault(title, []).extend(parts)
    noted("kind", "glTF, binary" if document.binary is not None else "glTF, text")
    noted("axes", "easting is x, northing is -z, z is y: glTF points Y up")
    noted("names", ", ".join(meshes))
    title, parts = chosen(path, meshes, name, "meshes")
    points = np.concatenate([part[0] for part in parts]) if parts else np.empty((0, 3))
    shifts = np.cumsum([0, *(len(part[0]) for part in parts)])
    triangles = [part[1] + shift for part, shift in zip(parts, shifts[:-1], strict=True)]
    surface = surface_from_mesh(
        path,
        name or title or path.stem,
        points,
        np.concatenate([np.empty((0, 3), dtype=np.int64), *triangles]),
        {},
        positive,
        length_unit,
    )
    surface.crs = _crs(document)
    return surface


def _crs(document: Document) -> str | None:
    """The reference system that geosurf writes into the extras of the node of a model."""
    for node in document.json.get("nodes") or []:
        extras = node.get("extras") if isinstance(node, dict) else None
        crs = extras.get("crs") if isinstance(extras, dict) else None
        if isinstance(crs, str) and crs.strip():
            return crs.strip()
    return None


# ------------------------------------------------------------------------ container
def _document(path: Path, data: bytes) -> Document:
    """The JSON and the binary chunk of a file."""
    text, binary = data, None
    if data[:4] == b"glTF":
        version, size = struct.unpack_from("<II", data.ljust(12, b"\0"), 4)
        if version != 2 or size != len(data):
            raise FormatError(
                f"{path}: found {len(data)} bytes of glTF version {version}, expected {size} of "
                "version 2. The file is truncated or of another version; export it again."
            )
        chunks = dict(_chunks(path, data))
        text, binary = chunks.get(b"JSON", b""), chunks.get(b"BIN\0", b"")
    try:
        found = json.loads(text.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise FormatError(
            f"{path}: the JSON of the glTF file is incomplete ({error}). Export it again."
        ) from error
    if not isinstance(found, dict):
        raise FormatError(f"{path}: the JSON is not that of a glTF file. Export it again.")
    return Document(path, found, binary)


def _chunks(path: Path, data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Kind and bytes of each chunk; the first of a kind comes last, so that it counts."""
    found = []
    at = 12
    while at < len(data):
        size, kind = struct.unpack_from("<I4s", data.ljust(at + 8, b"\0"), at)
        if at + 8 + size > len(data):
            raise FormatError(
                f"{path}: byte {at}: a chunk announces {size} bytes, but {len(data) - at - 8} "
                "follow. The file is damaged or truncated; export it again."
            )
        found.append((kind, data[at + 8 : at + 8 + size]))
        at += 8 + size
    return iter(found[::-1])


def _buffer(document: Document, index: Any) -> bytes:
    """Bytes of a buffer: the second chunk, base64 in the JSON, or a file in the same folder."""
    uri = document.item("buffers", index).get("uri")
    if uri is None:
        if document.binary is None:
            raise document.damaged(f"buffer {index} has no data")
        return document.binary
    if str(uri).startswith("data:"):
        try:
            return base64.b64decode(str(uri).partition(",")[2], validate=True)
        except (binascii.Error, ValueError) as error:
            raise document.damaged(f"buffer {index} is not base64 ({error})") from error
    # only files next to this one: a path from elsewhere may point anywhere
    if Path(str(uri)).name != str(uri):
        raise document.damaged(
            f"buffer {index} is {str(uri)[:60]!r}, expected a file of the same folder"
        )
    return read_bytes(document.path.parent / str(uri))


def _array(document: Document, index: Any, kind: str) -> np.ndarray:
    """Numbers (count, width) of an accessor."""
    accessor = document.item("accessors", index)
    if accessor.get("type") != kind or accessor.get("componentType") not in TYPES:
        raise document.damaged(f"accessor {index} does not hold {kind} of numbers")
    if "sparse" in accessor or "bufferView" not in accessor:
        raise FormatError(
            f"{document.path}: accessor {index} is sparse. Export the file with full arrays."
        )
    view = document.item("bufferViews", accessor["bufferView"])
    data = _buffer(document, view.get("buffer"))
    dtype = np.dtype(TYPES[accessor["componentType"]])
    size = dtype.itemsize * WIDTHS[kind]
    numbers: Any = (
        accessor.get("count"), view.get("byteStride", size), view.get("byteOffset", 0),
        accessor.get("byteOffset", 0), view.get("byteLength"),
    )  # fmt: skip
    if any(not isinstance(one, int) or one < 0 for one in numbers):
        raise document.damaged(f"accessor {index} has counts {numbers}")
    count, stride, start, offset, length = numbers
    last = offset + (count - 1) * stride + size if count else 0
    if stride < size or last > length or start + length > len(data):
        raise document.damaged(
            f"accessor {index} announces {count} values of {size} bytes, but its buffer has "
            f"{len(data)} bytes"
        )
    rows = np.ndarray((count, WIDTHS[kind]), dtype, data, start + offset, (stride, dtype.itemsize))
    if not accessor.get("normalized") or dtype.kind == "f":
        return np.array(rows)
    return np.maximum(rows / np.iinfo(dtype).max, -1.0)


# ---------------------------------------------------------------------------- nodes
def _placed_meshes(
    document: Document,
) -> Iterator[tuple[str, list[Part]]]:
    """Name, points and triangles of the mesh of each node of the scene."""
    nodes = document.json.get("nodes") or []
    scenes = document.json.get("scenes") or []
    if scenes:
        roots = document.item("scenes", document.json.get("scene", 0)).get("nodes") or []
    else:
        children = {one for node in nodes if isinstance(node, dict) for one in _children(node)}
        roots = [k for k in range(len(nodes)) if k not in children]
    seen: set[int] = set()
    waiting = [(root, np.eye(4), 0) for root in roots[::-1]]
    while waiting:
        index, above, depth = waiting.pop()
        node = document.item("nodes", index)
        if index in seen or depth > DEPTH:
            raise document.damaged(f"node {index} is there twice, or below itself")
        seen.add(index)
        matrix = above @ _matrix(document, node)
        waiting += [(child, matrix, depth + 1) for child in _children(node)[::-1]]
        if "mesh" in node:
            mesh = document.item("meshes", node["mesh"])
            title = str(node.get("name") or mesh.get("name") or "")
            yield title, [_moved(part, matrix) for part in _primitives(document, mesh)]


def _children(node: dict[str, Any]) -> list[Any]:
    found = node.get("children")
    return [one for one in found if isinstance(one, int)] if isinstance(found, list) else []


def _moved(part: Part, matrix: np.ndarray) -> Part:
    """Points in the world, on the axes of geosurf."""
    points, triangles = part
    # a mirror turns triangles over: the third corner and the second change places
    flip = np.linalg.det(matrix[:3, :3]) < 0
    turned = points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    return turned @ AXES.T, triangles[:, [0, 2, 1]] if flip else triangles


def _matrix(document: Document, node: dict[str, Any]) -> np.ndarray:
    """The 4 x 4 matrix of a node: given, or from translation, rotation and scale."""
    if "matrix" in node:
        return _numbers(document, node["matrix"], 16).reshape(4, 4).T
    matrix = np.eye(4)
    if "rotation" in node:
        matrix[:3, :3] = _turned(_numbers(document, node["rotation"], 4))
    if "scale" in node:
        matrix[:3, :3] *= _numbers(document, node["scale"], 3)
    if "translation" in node:
        matrix[:3, 3] = _numbers(document, node["translation"], 3)
    return matrix


def _numbers(document: Document, value: Any, size: int) -> np.ndarray:
    """A list of finite numbers as an array."""
    words = value if isinstance(value, list) else []
    plain = all(isinstance(one, int | float) and not isinstance(one, bool) for one in words)
    if len(words) != size or not plain or not np.isfinite(np.array(words, dtype=float)).all():
        raise document.damaged("the place of a node is not made of numbers")
    return np.array(words, dtype=np.float64)


def _turned(quaternion: np.ndarray) -> np.ndarray:
    """The matrix of a rotation by a unit quaternion (x, y, z, w)."""
    x, y, z, w = quaternion / (np.linalg.norm(quaternion) or 1.0)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _primitives(document: Document, mesh: dict[str, Any]) -> list[Part]:
    """Points (n, 3) and triangles (m, 3) of each part of a mesh."""
    found = []
    for part in mesh.get("primitives") or []:
        if not isinstance(part, dict) or not isinstance(part.get("attributes"), dict):
            raise document.damaged("a part of a mesh has no attributes")
        mode = part.get("mode", TRIANGLES)
        if mode in FLAT:
            continue
        if mode != TRIANGLES:
            raise FormatError(
                f"{document.path}: found triangle strips or fans, expected triangles. Export "
                "triangles."
            )
        points = _array(document, part["attributes"].get("POSITION"), "VEC3")
        if "indices" in part:
            corners = _array(document, part["indices"], "SCALAR").ravel().astype(np.int64)
        else:
            corners = np.arange(len(points))
        inside = len(corners) == 0 or 0 <= corners.min() <= corners.max() < len(points)
        if len(corners) % 3 or not inside:
            raise document.damaged(
                f"{len(corners)} corners of triangles do not fit {len(points)} points"
            )
        if not np.isfinite(points).all():
            raise document.damaged("a position is not a finite number")
        found.append((points, corners.reshape(-1, 3)))
    return found
