"""Meshes: through meshio, the one place where geosurf writes with it, Exodus, and glTF.

meshio signs .obj and .ply files with the time of day; that line is taken out, so that the same mesh
gives the same bytes.
"""

from __future__ import annotations

import base64
import contextlib
import io
import json
import re
import struct
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from geosurf.conventions.machine import need
from geosurf.conventions.palette import RGB, fault, stratum, unit_colours
from geosurf.errors import OutputError
from geosurf.model import Patches, TetMesh, TriSurface, Unit, Units
from geosurf.model.patches import labels_of_triangles
from geosurf.stopping import temporary_folder
from geosurf.write.datasets import words_of_unit
from geosurf.write.written import Loss, precision_lost

# ---- exodus ----------------------------------------
# Exodus II of tetrahedra: one element block for each unit.
#
# The container is NetCDF with 64-bit offsets, which every reader of Exodus opens; scipy writes it,
# with the same bytes each time. Layout: Schoof & Yarberry, EXODUS II: A Finite Element Data Model,
# SAND92-2137, with coordinates in one variable for each axis (the layout for large models).


LENGTH = 33  # of a text, with its end
LINE = 81
MOST = 2**32 - 1  # bytes of a variable
VERSION = np.float32(5.1)


def exodus_of_tets(mesh: TetMesh, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return tetrahedra in blocks, unit by unit, with the name of each block."""
    largest = max(16 * len(mesh.tetrahedra), 8 * len(mesh.local))
    if largest > MOST:
        raise OutputError(
            f"{len(mesh.tetrahedra)} tetrahedra are too many for Exodus: a variable has at most "
            "4 GiB. Write .msh or .vtu instead."
        )
    # a size of 0 stands for an unlimited one in NetCDF: units without tetrahedra have no block
    rows = [np.flatnonzero(mesh.region == k) for k in range(len(mesh.unit_names))]
    labels = labels_of_units(mesh, LENGTH - 1)
    labels = [label for label, row in zip(labels, rows, strict=True) if len(row)]
    rows = [row for row in rows if len(row)]
    if not rows:
        raise OutputError("the mesh has no tetrahedra, which Exodus needs. Write .vtu instead.")
    buffer = io.BytesIO()
    file = netcdf_file(buffer, "w", version=2)
    file.title, file.api_version, file.version = "geosurf", VERSION, VERSION
    file.floating_point_word_size, file.file_size = np.int32(8), np.int32(1)
    for key, size in (
        ("time_step", None), ("len_string", LENGTH), ("len_line", LINE), ("four", 4),
        ("num_dim", 3), ("num_nodes", len(mesh.local)), ("num_elem", len(mesh.tetrahedra)),
        ("num_el_blk", len(labels)),
    ):  # fmt: skip
        file.createDimension(key, size)
    file.createVariable("time_whole", "f8", ("time_step",))

    # blocks have numbers from 1 on, and are in use
    count = np.arange(1, len(labels) + 1, dtype=np.int32)
    numbers = file.createVariable("eb_prop1", "i4", ("num_el_blk",))
    numbers[:], numbers.name = count, "ID"
    file.createVariable("eb_status", "i4", ("num_el_blk",))[:] = np.ones_like(count)
    _texts(file, "eb_names", "num_el_blk", labels)
    _texts(file, "coor_names", "num_dim", ["x", "y", "z"])
    for axis, values in zip("xyz", mesh.vertices.T, strict=True):
        file.createVariable(f"coord{axis}", "f8", ("num_nodes",))[:] = values
    for k, row in enumerate(rows):
        tets = mesh.tetrahedra[row]
        dims = (f"num_el_in_blk{k + 1}", f"num_nod_per_el{k + 1}")
        for key, size in zip(dims, (len(tets), 4), strict=True):
            file.createDimension(key, size)
        block = file.createVariable(f"connect{k + 1}", "i4", dims)
        block[:], block.elem_type = tets + 1, "TETRA"
    file.flush()
    data = buffer.getvalue()
    file.close()
    return data, [
        Loss("name", f"Element blocks are named {labels}."),
        Loss("data", "Tetrahedra are in the order of their units."),
        FACES_LOST,
    ]


def _texts(file, name: str, dim: str, words: list[str]) -> None:  # type: ignore[no-untyped-def]
    """Write texts, padded with zeros."""
    letters = np.array([word.encode("ascii") for word in words], dtype=f"S{LENGTH}")
    table = letters.view("S1").reshape(len(words), LENGTH)
    file.createVariable(name, "c", (dim, "len_string"))[:] = table


SIGNATURE = re.compile(rb"^(# |comment )Created by meshio[^\n]*\n", re.MULTILINE)
FACES_LOST = Loss("data", "Faces and their surfaces were left out; .msh stores them.")
NAMES_LOST = Loss("name", "The format does not store names.")
TOPOLOGY_LOST = Loss(
    "topology",
    "STL stores three corners for every triangle. Readers merge vertices only where "
    "coordinates are equal.",
)


def mesh_of_surface(surface: TriSurface, name: str, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return a surface in the format of `suffix`."""
    notes = [NAMES_LOST]
    keeps_data = suffix in (".vtu", ".vtk", ".ply")

    # VTK formats hold arrays of any width, PLY one number for each vertex, the others none.
    data = {}
    for key, value in surface.vertex_data.items():
        flat = value.ndim == 1 or suffix in (".vtu", ".vtk")
        if keeps_data and flat and value.dtype.kind in "iuf" and " " not in key:
            data[key] = value
    lost = [key for key in surface.vertex_data if key not in data]
    if lost:
        words = f"Vertex data {lost} were left out; .vtp stores numeric data."
        notes.append(Loss("data", words))
    n_lost = surface.n_vertex - len(np.unique(surface.triangles)) if suffix == ".stl" else 0
    if n_lost:
        notes.append(Loss("data", f"{n_lost} vertices that no triangle uses were left out."))
    return _encode(surface.vertices, surface.triangles, suffix, point_data=data), _noted(
        suffix, notes
    )


def mesh_of_patches(patches: Patches, name: str | None, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return all patches with surface, parent and patch of each triangle."""
    labels = labels_of_triangles(patches)
    data = _encode(patches.vertices, patches.triangles, suffix, cell_data=labels)
    words = f"{NAMES_LOST} Row i of 'surface' is the i-th of {list(patches.names)}."
    return data, [Loss("name", words)]


def mesh_of_unit(unit: Unit, name: str, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return the shell of a unit."""
    # only VTK formats have numbers for each triangle
    labels = {"surface": unit.surface_of_triangle} if suffix in (".vtu", ".vtk") else {}
    data = _encode(unit.vertices, unit.triangles, suffix, cell_data=labels)
    return data, _noted(suffix, [NAMES_LOST])


def mesh_of_tets(mesh: TetMesh, name: str | None, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return tetrahedra with the unit of each; Gmsh also has faces and names."""
    tets, region = mesh.tetrahedra, mesh.region
    rows = f"Row i of 'unit' is the i-th of {list(mesh.unit_names)}."
    if suffix == ".vtu":
        data = _encode(mesh.vertices, tets, suffix, cell_data={"unit": region}, kind="tetra")
        return data, [Loss("name", f"{NAMES_LOST} {rows}"), FACES_LOST]
    if suffix == ".inp":
        labels = labels_of_units(mesh, 80)
        sets = {label: [np.flatnonzero(region == k)] for k, label in enumerate(labels)}
        data = _encode(mesh.vertices, tets, suffix, kind="tetra", cell_sets=sets)
        return data, [Loss("name", f"Element sets are named {list(sets)}."), FACES_LOST]
    return _gmsh(mesh), []


def labels_of_units(mesh: TetMesh, longest: int) -> list[str]:
    """Return names of units as letters, numbers and underscores, each another one."""
    return [
        f"U{k + 1}_{re.sub('[^A-Za-z0-9]+', '_', unit)}"[:longest]
        for k, unit in enumerate(mesh.unit_names)
    ]


def _gmsh(mesh: TetMesh) -> bytes:
    """Return bytes of Gmsh 2.2: units and surfaces are physical groups with their names."""
    # walls may share one name: surfaces of one name are one group
    names = list(dict.fromkeys(mesh.surface_names))
    row = np.array([names.index(name) for name in mesh.surface_names])
    groups = [mesh.region + 1, row[mesh.surface_of_face] + 1]
    tags = [group.astype(np.int32) for group in groups]

    # names are in quotes there; a unit and a surface of one name stay apart by a word
    units = [f"unit {name}" if name in names else name for name in mesh.unit_names]
    known = {name: (k + 1, 3) for k, name in enumerate(units)}
    known |= {name: (k + 1, 2) for k, name in enumerate(names)}
    return _encode(
        mesh.vertices,
        mesh.tetrahedra,
        ".msh",
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        kind="tetra",
        also=[("triangle", np.array(mesh.faces))],
        field_data={name.replace('"', "'"): np.array(of) for name, of in known.items()},
        file_format="gmsh22",
    )


def _noted(suffix: str, notes: list[Loss]) -> list[Loss]:
    return [*notes, TOPOLOGY_LOST] if suffix == ".stl" else notes


def _encode(
    vertices: np.ndarray,
    triangles: np.ndarray,
    suffix: str,
    point_data: Mapping[str, Any] | None = None,
    cell_data: Mapping[str, Any] | None = None,
    *,
    kind: str = "triangle",
    also: Sequence[tuple[str, np.ndarray]] = (),
    file_format: str | None = None,
    **named: Any,
) -> bytes:
    """Return the bytes that meshio writes, without its signature.

    With cells of other kinds (`also`), cell data are lists: one array for each kind.
    """
    need(f"{suffix} files need", "meshio")
    import meshio

    # copies: meshio changes what it is given
    mesh = meshio.Mesh(
        np.array(vertices),
        [(kind, np.array(triangles)), *also],
        point_data={key: np.array(value) for key, value in (point_data or {}).items()},
        cell_data={
            key: value if also else [np.array(value)] for key, value in (cell_data or {}).items()
        },
        **named,
    )

    # meshio writes files only, and prints: to a folder of its own, in silence
    with temporary_folder() as folder:
        file = Path(folder) / f"mesh{suffix}"
        try:
            with (
                contextlib.redirect_stdout(io.StringIO()),
                contextlib.redirect_stderr(io.StringIO()),
                warnings.catch_warnings(),
                np.errstate(all="ignore"),
            ):
                warnings.simplefilter("ignore")
                meshio.write(file, mesh, file_format)
        except (meshio.WriteError, SystemExit, ValueError, TypeError, KeyError) as error:
            raise OutputError(
                f"meshio cannot write {suffix} ({type(error).__name__}: {error}). "
                "Write .vtp or .ts instead."
            ) from error
        data = file.read_bytes()
    return SIGNATURE.sub(b"", data, count=1) if suffix in (".obj", ".ply") else data


PLAIN: RGB = (0.83, 0.84, 0.86)  # walls and contacts
FLOAT, UINT32 = 5126, 5125
ARRAY, ELEMENTS = 34962, 34963
MAGIC, GLTF_VERSION, JSON_CHUNK, BIN_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942


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
    data, rounded = _encode_gltf([body], surface.crs, suffix)
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
    data, lost = _encode_gltf(bodies, patches.crs, suffix)
    words = "Which patch and parent each triangle is from was left out; .vtp stores it."
    return data, [Loss("data", words), *lost]


def gltf_of_unit(unit: Unit, name: str, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return the shell of one unit."""
    data, lost = _encode_gltf([_body(unit, stratum(unit.zone_index), name)], unit.crs, suffix)
    return data, [_SURFACES, *lost]


def gltf_of_units(units: Units, name: str | None, suffix: str) -> tuple[bytes, list[Loss]]:
    """Return all units: one colour for each zone, shades of it for blocks."""
    labels = units.labels
    colours = unit_colours((labels[unit.name], unit.zone_index) for unit in units.values())
    bodies = [_body(unit, colours[labels[unit.name]], unit.name) for unit in units.values()]
    data, lost = _encode_gltf(bodies, units.crs, suffix)
    return data, [_SURFACES, *lost]


_SURFACES = Loss(
    "data", "Which surface each triangle of a unit lies on was left out; .vtm stores it."
)


def _body(unit: Unit, colour: RGB, name: str) -> Body:
    return Body(name, colour, unit.vertices, unit.triangles, words_of_unit(unit))


def _colour(role: str, number: int) -> RGB:
    if role == "horizon":
        return stratum(number)
    return fault(number) if role == "fault" else PLAIN


def _encode_gltf(bodies: Sequence[Body], crs: str | None, suffix: str) -> tuple[bytes, list[Loss]]:
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
            struct.pack("<3I", MAGIC, GLTF_VERSION, size),
            struct.pack("<2I", len(text), JSON_CHUNK),
            text,
            struct.pack("<2I", len(buffer), BIN_CHUNK),
            buffer,
        ]
    )
