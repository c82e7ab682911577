"""Legacy VTK and glTF: the same triangles as they were written with, and damaged files."""

from __future__ import annotations

import base64
import json
import struct

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, InputError
from geosurf.read.registry import SIGNATURES

POINTS = np.array([[461000.125, 5932000.5, -1600], [461100, 5932000, -1650], [461000, 5932100, -1]])
QUAD = np.array([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 3.5]])


def written(tmp_path, content, name="a.bin"):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


# ------------------------------------------------------------------------ legacy VTK
HEAD = "# vtk DataFile Version 3.0\n\n{}\nDATASET POLYDATA\n"
TEXT = (
    HEAD.format("ASCII")
    + "FIELD FieldData 1\ncrs 1 1 string\nEPSG:23031\nPOINTS 4 float\n"
    + "0 0 0 9 0 0\n9 9 0 0 9 3.5\nLINES 1 3\n2 0 1\nPOLYGONS 2 9\n3 0 1 2\n4 0 1 2 3\n"
    + "POINT_DATA 4\nSCALARS throw int 1\nLOOKUP_TABLE default\n1 2 3 4\n"
)


def test_polydata_in_text_is_read_with_its_numbers_and_its_system(tmp_path):
    fault = gs.read_fault(written(tmp_path, TEXT))
    assert fault.vertices.tolist() == QUAD.tolist()
    assert fault.triangles.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3]]
    assert fault.vertex_data["throw"].tolist() == [1, 2, 3, 4]
    assert fault.crs == "EPSG:23031"
    assert gs.read_horizon(tmp_path / "a.bin", positive="down").vertices[3, 2] == -3.5
    found = gs.info(tmp_path / "a.bin")
    assert (found.format, found.count, found.notes["crs"]) == ("vtk", 4, "EPSG:23031")


@pytest.mark.parametrize("version", [42, 51])
@pytest.mark.parametrize("binary", [True, False])
def test_law_what_vtk_writes_comes_back(tmp_path, version, binary):
    legacy = pytest.importorskip("vtkmodules.vtkIOLegacy")
    surface = gs.TriSurface(
        "F1", "fault", POINTS, [[0, 1, 2]], vertex_data={"dip": [0.5, 2, 1 / 4]}
    )
    writer = legacy.vtkPolyDataWriter()
    writer.SetInputData(surface.to_pyvista())
    writer.SetFileName(str(tmp_path / "a"))
    writer.SetFileVersion(version)
    (writer.SetFileTypeToBinary if binary else writer.SetFileTypeToASCII)()
    writer.Write()
    back = gs.read_fault(tmp_path / "a")
    # VTK writes six digits or more as text
    assert np.allclose(back.vertices, POINTS, rtol=0 if binary else 1e-5, atol=0)
    assert back.triangles.tolist() == [[0, 1, 2]]
    assert back.vertex_data["dip"].tolist() == [0.5, 2, 0.25]


NEW = HEAD.format("ASCII").replace("3.0", "5.1") + "POINTS 3 double\n0 0 0 9 0 0 0 9 0\n"
BINARY = HEAD.format("BINARY").encode()
VTK_DAMAGES = {
    "points": (TEXT.replace("POINTS 4", "POINTS 5"), "points have 12 numbers, expected 15"),
    "huge": (TEXT.replace("POINTS 4", "POINTS 9" + "0" * 15), "points are announced, but"),
    "nan": (TEXT.replace("9 9 0 0", "9 9 nan 0"), "line 10: found 'nan'"),
    "comma": (TEXT.replace("3.5", "3,5"), "found '3,5'"),
    "corner": (TEXT.replace("3 0 1 2\n4", "3 0 1 7\n4"), "names point 7, expected 0 to 3"),
    "cells": (TEXT.replace("POLYGONS 2", "POLYGONS 3"), "have 2 cells, expected 3"),
    "five": (TEXT.replace("4 0 1 2 3", "5 0 1 2 3 0").replace("2 9", "2 10"), "has 5 corners"),
    "strips": (TEXT.replace("POLYGONS", "TRIANGLE_STRIPS"), "found triangle strips"),
    "data": (TEXT.replace("POINT_DATA 4", "POINT_DATA 3"), "3 rows of point data for 4 points"),
    "type": (TEXT.replace("throw int", "throw bit"), "are of the type 'bit'"),
    "word": (TEXT.replace("LINES", "LANES"), "found 'LANES'"),
    "short": (TEXT.replace("LINES 1 3", "LINES 1"), "'LINES 1' is incomplete"),
    "none": (HEAD.format("ASCII"), "has no POINTS"),
    "offsets": (NEW + "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 2\n", "do not rise|found ''"),
    "binary": (BINARY + b"POINTS 2 double\n" + b"\0" * 47, "points need 48 bytes, but 47 follow"),
    "infinite": (BINARY + b"POINTS 1 float\n\xff\xff\xff\xff" + b"\0" * 8 + b"\n", "point 0 is"),
    "text": (BINARY + b"FIELD f 1\ncrs 1 1 string\n\xc9abc", "a text is incomplete"),
}  # fmt: skip


@pytest.mark.parametrize("case", VTK_DAMAGES)
def test_damaged_polydata_gets_one_sentence(tmp_path, case):
    content, message = VTK_DAMAGES[case]
    with pytest.raises(FormatError, match=message):
        gs.read_fault(written(tmp_path, content))


# ------------------------------------------------------------------------------ glTF
def gltf(points=QUAD, corners=(0, 1, 2, 0, 2, 3), nodes=None, **changed):
    """A document with one mesh, whose buffer is in the JSON."""
    # easting, northing, elevation -> x, y up, z south
    raw = np.asarray(points)[:, [0, 2, 1]] * [1, 1, -1]
    data = raw.astype("<f4").tobytes() + np.array(corners, dtype="<u2").tobytes()
    size = 12 * len(points)
    found = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": nodes or [{"mesh": 0, "name": "F1"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": len(corners), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": size},
            {"buffer": 0, "byteOffset": size, "byteLength": len(data) - size},
        ],
        "buffers": [{"byteLength": len(data)}],
    }
    found.update(changed)
    return found, data


def in_text(found, data):
    found["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(data).decode()
    return json.dumps(found)


def packed(found, data):
    text = json.dumps(found).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<I4s", len(text), b"JSON") + text
    parts += struct.pack("<I4s", len(data), b"BIN\0") + data
    return b"glTF" + struct.pack("<II", 2, 12 + len(parts)) + parts


@pytest.mark.parametrize("form", [in_text, packed])
def test_gltf_is_read_on_the_axes_of_geosurf(tmp_path, form):
    path = written(tmp_path, form(*gltf()))
    fault = gs.read_fault(path)
    assert (fault.name, fault.vertices.tolist()) == ("F1", QUAD.tolist())
    assert fault.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    found = gs.info(path)
    assert (found.format, found.count) == ("gltf", 4)
    assert found.notes["axes"] == "easting is x, northing is -z, z is y: glTF points Y up"


def test_nodes_move_turn_and_mirror_their_meshes_in_float64(tmp_path):
    # a parent far away, in float64; a child turned by 90 degrees about the vertical
    turn = [0, np.sqrt(0.5), 0, np.sqrt(0.5)]
    nodes = [
        {"children": [1], "translation": [461000.123456, -1600.5, -5932000.25]},
        {"mesh": 0, "rotation": turn, "scale": [1, 1, -1], "name": "F1"},
    ]
    fault = gs.read_fault(written(tmp_path, packed(*gltf(nodes=nodes))))
    x, y, z = QUAD.T
    expected = np.stack([461000.123456 + y, 5932000.25 + x, z - 1600.5], axis=1)
    assert np.abs(fault.vertices - expected).max() < 1e-9
    # the mirror turned the map over, so corners change places: normals stay up
    a, b, c = (fault.vertices[fault.triangles[0, k]] for k in range(3))
    assert np.cross(b - a, c - a)[2] > 0


def test_one_of_several_meshes_is_chosen_by_name(tmp_path):
    nodes = [{"mesh": 0, "name": "F1"}, {"mesh": 0, "name": "F2", "translation": [0, 5, 0]}]
    path = written(tmp_path, packed(*gltf(nodes=nodes, scenes=[{"nodes": [0, 1]}])))
    assert gs.read_fault(path, name="F2").vertices[0, 2] == 5
    with pytest.raises(InputError, match=r"has 2 meshes: F1, F2\. Choose one, as in name='F1'"):
        gs.read_fault(path)
    with pytest.raises(InputError, match=r"F1, F2, but none is called 'F3'\. Choose one"):
        gs.read_fault(path, name="F3")
    assert gs.info(path).count == 8


def entry(kind, index, **changed):
    found, data = gltf()
    found[kind][index].update(changed)
    return in_text(found, data)


GLTF_DAMAGES = {
    "cut": (packed(*gltf())[:-4], r"found \d+ bytes of glTF version 2"),
    "chunk": (b"glTF" + struct.pack("<III4s", 2, 20, 99, b"JSON"), "announces 99 bytes"),
    "json": (in_text(*gltf())[:-3], "JSON parser cannot read it"),
    "deep": ('{"asset": 1, "nodes": ' + "[" * 100_000, "is incomplete|recursion"),
    "count": (entry("accessors", 0, count=10**12), "announces 1000000000000 values"),
    "minus": (entry("accessors", 0, count=-1), "announces -1 values"),
    "offset": (entry("bufferViews", 1, byteOffset=50), "trimesh cannot read it"),
    "corner": (in_text(*gltf(corners=(0, 1, 9))), "corners of triangles do not fit 4 points"),
    "two": (in_text(*gltf(corners=(0, 1))), "trimesh cannot read it"),
    "nan": (in_text(*gltf(points=[[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], corners=(0, 1, 2))),
            "a position is not a finite number"),
    "view": (entry("accessors", 0, bufferView=7), "trimesh cannot read it"),
    "sparse": (entry("accessors", 0, sparse={}), "accessor 0 is sparse"),
    "place": (entry("nodes", 0, translation=[0, "x", 0]), "trimesh cannot read it"),
    "base64": (in_text(*gltf()).replace("base64,", "base64,*"), "base64 decoder"),
    "elsewhere": (json.dumps(gltf(buffers=[{"uri": "../../etc/passwd"}])[0]), "same folder"),
    "packed": (in_text(*gltf(extensionsRequired=["KHR_draco_mesh_compression"])),
               "needs the glTF extension KHR_draco"),
    "strip": (entry("meshes", 0, primitives=[{"attributes": {}, "mode": 5}]), "cannot read"),
    "none": (entry("meshes", 0, primitives=[]), "trimesh cannot read it|has no triangles"),
}  # fmt: skip


@pytest.mark.parametrize("case", GLTF_DAMAGES)
def test_damaged_gltf_gets_one_sentence(tmp_path, case):
    content, message = GLTF_DAMAGES[case]
    with pytest.raises(FormatError, match=message):
        gs.read_fault(written(tmp_path, content, "a.gltf"))


def test_signatures_exclude_those_of_other_formats():
    for head in (TEXT.encode(), BINARY, in_text(*gltf()).encode(), packed(*gltf())):
        assert sum(fits(head[:8192]) for fits in SIGNATURES.values()) == 1
