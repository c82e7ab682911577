"""Surfaces in glTF 2.0 (.glb, .gltf), through trimesh: triangles of meshes, placed by their nodes.

The format is ISO/IEC 12113 (Khronos glTF 2.0). Its Y axis points up and its Z axis south: easting
is x, northing is -z, elevation is y [m]. Nodes move, turn and scale their meshes in float64, so
that coordinates are not limited to the float32 of positions. Materials and textures are not used.
What a file announces is compared with its size before trimesh makes room for it.
"""

from __future__ import annotations

import base64
import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions.packages import need
from geosurf.errors import FormatError
from geosurf.model import TriSurface
from geosurf.read._common import Request, chosen, noted
from geosurf.read._guard import damaged, read_bytes, reading_with
from geosurf.read._placed import surface_from_mesh

# extensions that change neither positions nor triangles
HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_mesh_quantization")
# glTF (x east, y up, z south) -> easting, northing, elevation
AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


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
    title, parts = chosen(path, meshes, request.name, "meshes")
    points, triangles, n_point = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for part_points, part_triangles in parts:
        points.append(part_points)
        triangles.append(part_triangles + n_point)
        n_point += len(part_points)
    world = np.concatenate(points)
    if not np.isfinite(world).all():
        raise damaged(f"{path}: a position is not a finite number")
    surface = surface_from_mesh(
        path, request.name or title or path.stem, world, np.concatenate(triangles), {}, request
    )
    surface.crs = _crs(document)
    return surface


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
        found = json.loads(text.decode("utf-8-sig"))
    if not isinstance(found, dict):
        raise damaged(f"{path}: the JSON is not that of a glTF file")
    required = [str(one) for one in found.get("extensionsRequired") or []]
    other = [one for one in required if not one.startswith(HARMLESS)]
    if other:
        raise FormatError(
            f"{path}: the file needs the glTF extension {other[0]}, which geosurf does not read. "
            "Export it without compression."
        )
    return found


def _refuse_what_is_not_there(path: Path, document: dict[str, Any], size: int) -> dict[str, bytes]:
    """Bytes of files next to this one, if all that is announced fits into these and `size`."""
    files = {}
    for row, one in enumerate(_listed(document, "buffers")):
        uri = str(one.get("uri", "data:"))
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
    for row, one in enumerate(_listed(document, "accessors")):
        count = one.get("count")
        if "sparse" in one:
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
            meshes.setdefault(str(node), []).append((world @ AXES.T, faces))
    return meshes


def _crs(document: dict[str, Any]) -> str | None:
    """The reference system that geosurf writes into the extras of the node of a model."""
    for node in _listed(document, "nodes"):
        extras = node.get("extras")
        crs = extras.get("crs") if isinstance(extras, dict) else None
        if isinstance(crs, str) and crs.strip():
            return crs.strip()
    return None
