"""glTF 2.0, binary (``.glb``) or JSON (``.gltf``): surfaces and units as nodes with names, colours.

Written by hand, a few lines of JSON and the arrays: the writer of VTK crashes on blocks with names,
its exporter needs a window, and meshio and pyvista have none of their own. glTF knows float32 only
and has y upwards: vertices are stored relative to an origin, and the node above all others moves
them back. Easting is x, elevation y, northing -z.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions.colours import RGB, fault, stratum, unit_colours
from geosurf.errors import OutputError
from geosurf.model import Patches, TriSurface, Unit, Units
from geosurf.write.written import Loss, precision_lost

PLAIN: RGB = (0.83, 0.84, 0.86)  # walls and contacts
FLOAT, UINT32 = 5126, 5125
ARRAY, ELEMENTS = 34962, 34963
MAGIC, VERSION, JSON_CHUNK, BIN_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942


@dataclass(frozen=True)
class Body:
    """One node: its name, colour, vertices (n, 3) [m], triangles (n, 3) and words about it."""

    name: str
    colour: RGB
    vertices: np.ndarray
    triangles: np.ndarray
    words: dict[str, str]


def gltf_of_surface(surface: TriSurface, name: str, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return one surface."""
    lost = []
    if surface.vertex_data:
        keys = sorted(surface.vertex_data)
        lost.append(Loss("data", f"Vertex data {keys} were left out; .vtp stores numeric data."))
    body = Body(
        name, _colour(surface.role, 0), surface.vertices, surface.triangles, {"role": surface.role}
    )
    data, rounded = _encode([body], surface.crs, suffix)
    return data, [*lost, *rounded]


def gltf_of_patches(patches: Patches, name: str | None, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return all surfaces, each cut where others meet it."""
    bodies, seen = [], {"horizon": 0, "fault": 0}
    for row, source in enumerate(patches.sources):
        part = patches.surface(row)
        number = seen.get(source.role, 0)
        seen[source.role] = number + 1
        if part.n_triangle:
            colour = _colour(source.role, number)
            bodies.append(
                Body(part.name, colour, part.vertices, part.triangles, {"role": source.role})
            )
    data, lost = _encode(bodies, patches.crs, suffix)
    words = "Which patch and parent each triangle is from was left out; .vtp stores it."
    return data, [Loss("data", words), *lost]


def gltf_of_unit(unit: Unit, name: str, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return the shell of one unit."""
    data, lost = _encode([_body(unit, stratum(unit.zone_index), name)], unit.crs, suffix)
    return data, [_SURFACES, *lost]


def gltf_of_units(units: Units, name: str | None, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return all units: one colour for each zone, shades of it for blocks."""
    colours = unit_colours((unit.name, unit.zone_index) for unit in units.values())
    bodies = [_body(unit, colours[unit.name], unit.name) for unit in units.values()]
    data, lost = _encode(bodies, units.crs, suffix)
    return data, [_SURFACES, *lost]


_SURFACES = Loss(
    "data", "Which surface each triangle of a unit lies on was left out; .vtm stores it."
)


def _body(unit: Unit, colour: RGB, name: str) -> Body:
    words = {"zone": unit.zone, "block": unit.block}
    if unit.contact:
        words["contact"] = unit.contact
    return Body(name, colour, unit.vertices, unit.triangles, words)


def _colour(role: str, number: int) -> RGB:
    if role == "horizon":
        return stratum(number)
    return fault(number) if role == "fault" else PLAIN


def _encode(bodies: Sequence[Body], crs: str | None, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return a file of some bodies, and how far float32 moved their vertices."""
    bodies = [body for body in bodies if len(body.triangles)]
    if not bodies:
        raise OutputError("there are no triangles to write. Write .vtp instead.")

    # a whole number of metres in the middle, which JSON and doubles hold exactly
    low = np.min([body.vertices.min(axis=0) for body in bodies], axis=0)
    high = np.max([body.vertices.max(axis=0) for body in bodies], axis=0)
    origin = np.round(0.5 * (low + high))

    buffer, document = bytearray(), _document(origin, crs)
    moved = 0.0
    for body in bodies:
        local = body.vertices - origin
        single = local.astype(np.float32)
        moved = max(moved, float(np.linalg.norm(single.astype(np.float64) - local, axis=1).max()))
        _add(document, buffer, body, np.stack([single[:, 0], single[:, 2], -single[:, 1]], axis=1))
    lost = precision_lost(moved, "glTF stores float32: vertices were moved")
    document["buffers"] = [{"byteLength": len(buffer)}]
    return (_binary if suffix == ".glb" else _text)(document, bytes(buffer)), lost


def _document(origin: np.ndarray, crs: str | None) -> dict[str, Any]:
    """The JSON of no body: one node that moves all others to their place."""
    east, north, up = origin.tolist()
    words: dict[str, Any] = {"axes": "x easting, y elevation, z minus northing [m]"}
    if crs is not None:
        words["crs"] = crs
    root = {"name": "model", "translation": [east, up, -north], "children": [], "extras": words}
    return {
        "asset": {"version": "2.0", "generator": "geosurf"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [root],
        "meshes": [],
        "materials": [],
        "accessors": [],
        "bufferViews": [],
    }


def _add(document: dict[str, Any], buffer: bytearray, body: Body, points: np.ndarray) -> None:
    """Add the node, mesh, material and arrays of one body."""
    row = len(document["meshes"])
    corners = np.ascontiguousarray(body.triangles, dtype="<u4").ravel()
    for array, target in ((np.ascontiguousarray(points, dtype="<f4"), ARRAY), (corners, ELEMENTS)):
        document["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(buffer), "byteLength": array.nbytes, "target": target}
        )
        buffer += array.tobytes()
    document["accessors"] += [
        {
            "bufferView": 2 * row,
            "componentType": FLOAT,
            "count": len(points),
            "type": "VEC3",
            "min": points.min(axis=0).tolist(),
            "max": points.max(axis=0).tolist(),
        },
        {
            "bufferView": 2 * row + 1,
            "componentType": UINT32,
            "count": len(corners),
            "type": "SCALAR",
        },
    ]
    document["materials"].append(
        {
            "name": body.name,
            "doubleSided": True,
            "pbrMetallicRoughness": {
                "baseColorFactor": [*map(_linear, body.colour), 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 1.0,
            },
        }
    )
    primitive = {"attributes": {"POSITION": 2 * row}, "indices": 2 * row + 1, "material": row}
    document["meshes"].append({"name": body.name, "primitives": [primitive]})
    document["nodes"][0]["children"].append(row + 1)
    document["nodes"].append({"name": body.name, "mesh": row, "extras": body.words})


def _linear(value: float) -> float:
    """One channel of sRGB as glTF has colours: linear light."""
    linear = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
    return round(linear, 6)


def _text(document: dict[str, Any], buffer: bytes) -> bytes:
    """One JSON file with its arrays in base64."""
    data = base64.b64encode(buffer).decode("ascii")
    document["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
    return (json.dumps(document, ensure_ascii=False) + "\n").encode("utf-8")


def _binary(document: dict[str, Any], buffer: bytes) -> bytes:
    """Header, JSON and arrays; chunks end at multiples of four bytes."""
    text = json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode("utf-8")
    text += b" " * (-len(text) % 4)
    buffer += b"\0" * (-len(buffer) % 4)
    size = 12 + 8 + len(text) + 8 + len(buffer)
    return b"".join(
        [
            struct.pack("<3I", MAGIC, VERSION, size),
            struct.pack("<2I", len(text), JSON_CHUNK),
            text,
            struct.pack("<2I", len(buffer), BIN_CHUNK),
            buffer,
        ]
    )
