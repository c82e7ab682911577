"""Meshes: meshio, VTK, glTF, GOCAD Model3d; what damaged files must not do to us."""

from __future__ import annotations

import base64
import json
import struct
import warnings

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, InputError
from geosurf.read.model3d import read_model3d
from geosurf.read.registry import SIGNATURES
from tests.messages import refused

OBJ = "v 0 0 0\nv 9 0 0\nv 9 9 9\nv 0 9 9\nf 1 2 3 4\n"


def ramp():
    east, north = 500_000.5, 6_000_000.25
    vertices = [[east, north, 0], [east + 9, north, 0.25], [east, north + 9, 9.5]]
    return gs.TriSurface("F1", "fault", vertices, [[0, 1, 2]])


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.obj", OBJ.replace("1 2 3 4", "1 2 7 4"), r"triangle 0 refers to vertices"),
        (
            "a.obj",
            OBJ.replace("9 9 9", "9 nan 9"),
            r"vertices has values that are not finite.*point 2",
        ),
        ("a.stl", "solid\nfacet normal 0 0 1\n", r"the last line is 'facet.*expected 'endsolid'"),
        ("a.off", "OFF\n# made by\n\n", r"missing after the first line.*export"),
        ("b.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n", r"a section does not begin"),
    ],
)
def test_wrong_meshes(tmp_path, capfd, name, text, message):
    (tmp_path / name).write_text(text)
    refused(FormatError, message, gs.read_fault, tmp_path / name)
    out, err = capfd.readouterr()
    assert out + err == ""


def test_volumes_are_refused(tmp_path):
    import meshio

    tetra = meshio.Mesh(np.eye(4)[:, :3], [("tetra", [[0, 1, 2, 3]])])
    tetra.write(tmp_path / "a.vtu")
    with pytest.raises(FormatError, match=r"cell 0 is of VTK type 10, expected triangles"):
        gs.read_fault(tmp_path / "a.vtu")


@pytest.mark.parametrize(
    ("mode", "compressor", "header"),
    [("Ascii", "None", "32"), ("Binary", "None", "64"), ("Binary", "ZLib", "32"),
     ("Binary", "LZMA", "64"), ("Appended", "None", "32"), ("Appended", "ZLib", "64")],
)  # fmt: skip
def test_vtp_in_every_encoding_of_vtk(tmp_path, mode, compressor, header):
    pytest.importorskip("pyvista")
    import pyvista
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    rng = np.random.default_rng(5)
    points = rng.normal(size=(3000, 3))
    faces = rng.permuted(np.tile(np.arange(3000), (2, 1)), axis=1).reshape(-1, 3)
    mesh = pyvista.PolyData.from_regular_faces(points, faces)
    mesh.point_data["throw"] = points[:, 0]
    writer = vtkXMLPolyDataWriter()
    writer.SetFileName(str(tmp_path / "a.vtp"))
    writer.SetInputData(mesh)
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetHeaderTypeToUInt{header}")()
    if mode == "Appended":
        writer.SetEncodeAppendedData(header == "32")
    assert writer.Write() == 1
    back = gs.read_fault(tmp_path / "a.vtp")
    np.testing.assert_array_equal(back.triangles, faces)
    if mode == "Ascii":
        np.testing.assert_allclose(back.vertices, points, rtol=1e-10)
    else:
        np.testing.assert_array_equal(back.vertices, points)
        np.testing.assert_array_equal(back.vertex_data["throw"], points[:, 0])


def vtp(tmp_path, *change):
    (path,) = gs.write(ramp(), tmp_path / "F1.vtp")
    text = path.read_text()
    assert change[0] in text
    path.write_text(text.replace(*change))
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('type="PolyData"', 'type="ImageData"'), r"type='ImageData'>, expected .*Save"),
        (
            ('header_type="UInt64"', 'compressor="vtkLZ4DataCompressor"'),
            r"compressed with vtkLZ4.*Save",
        ),
        (('NumberOfPoints="3"', 'NumberOfPoints="4"'), r"found 3 points, expected 4"),
        (('NumberOfStrips="0"', 'NumberOfStrips="1"'), r"triangle strips.*Triangulate"),
        (('NumberOfPolys="1"', 'NumberOfPolys="2"'), r"found 1 cells with 3 corners, expected 2"),
        (('"UInt64"', '"UInt32"'), r"F1.vtp: "),
        (("</VTKFile>", ""), r"the XML is incomplete"),
    ],
)
def test_wrong_vtp(tmp_path, change, message):
    refused(FormatError, message, lambda: gs.read_fault(vtp(tmp_path, *change)))


def horizon_2_by_2(folder):
    path = folder / "in.irap"
    path.write_text("-996 2 10 10\n500 510 0 10\n2 30 500 0\n0 0 0 0 0 0 0\n1.25 2.5 3 9999900.0\n")
    return gs.read_horizon(path, positive="up", name="Top")


@pytest.fixture(scope="module")
def whole_files(tmp_path_factory):
    """One small file per format, and its reader, which gives an array."""
    folder = tmp_path_factory.mktemp("whole")
    pol = folder / "s.pol"
    pol.write_text("0 0 15.25\n0 5 16\n999 999 999\n")
    (folder / "z.zmap").write_text(
        "@a, GRID, 2\n 8, -99, , 1, 1\n 2, 2, 0, 10, 0, 10\n 0, 0, 0\n@\n 1.5 2.25\n 3.0 -99\n"
    )
    top = horizon_2_by_2(folder)

    def elevations(path):
        kwargs = {} if path.suffix == ".nc" else {"positive": "up"}
        return gs.read_horizon(path, **kwargs).values

    def corners(path):
        fault = gs.read_fault(path)
        return fault.vertices[fault.triangles]

    cases = [(gs.write(top, folder / f"a{s}")[0], elevations) for s in (".irap", ".gri")]
    cases.append((folder / "z.zmap", elevations))
    cases.append((pol, lambda path: np.concatenate(gs.read_fault(path, positive="up").sticks)))
    suffixes = (".ts", ".vtp", ".vtu", ".vtk", ".obj", ".stl", ".ply")
    cases += [(gs.write(ramp(), folder / f"a{s}")[0], corners) for s in suffixes]
    return {path.name: (path, read) for path, read in cases}


NAMES = [f"a{s}" for s in (".irap", ".gri", ".ts", ".vtp", ".vtu", ".vtk", ".obj", ".stl", ".ply")]
NAMES += ["z.zmap", "s.pol"]


@pytest.mark.parametrize("name", NAMES)
def test_a_file_cut_at_any_byte_is_refused_or_read_right_or_warned_of(tmp_path, whole_files, name):
    path, read = whole_files[name]
    right = read(path)
    data = path.read_bytes()
    cut = tmp_path / f"cut{path.suffix}"
    refused = warned = 0
    ends = range(0, len(data), 3)
    for n in ends:
        cut.write_bytes(data[:n])
        with warnings.catch_warnings(record=True, action="always") as told:
            try:
                found = read(cut)
            except FormatError as error:
                refused += cut.name in str(error)
                continue
        warned += len(told) > 0
        assert {one.message.kind for one in told} <= {"file end"}
        if not told:
            np.testing.assert_array_equal(found, right, err_msg=f"cut at {n} of {len(data)}")
    assert refused + warned > 0.9 * len(ends)
    assert warned < 0.25 * len(ends)


def test_a_netcdf_file_cut_short_is_refused(tmp_path):
    (path,) = gs.write(horizon_2_by_2(tmp_path), tmp_path / "a.nc")
    data = path.read_bytes()
    cut = tmp_path / "cut.nc"
    for n in {*range(0, len(data), 97), *range(16), len(data) - 1}:
        cut.write_bytes(data[:n])
        refused(FormatError, r"cut.nc", gs.read_horizon, cut)


@pytest.mark.filterwarnings("ignore:.*no line end follows")
@pytest.mark.parametrize("name", NAMES)
def test_a_damaged_byte_is_read_or_refused_by_name(tmp_path, whole_files, rng, name):
    """Whatever one byte says, the reader gives numbers, or names the file in an error of ours."""
    path, read = whole_files[name]
    data = path.read_bytes()
    bad = tmp_path / f"bad{path.suffix}"
    refusals = []
    for n in rng.choice(len(data), 60):
        changed = bytearray(data)
        changed[n] = rng.integers(256)
        bad.write_bytes(bytes(changed))
        try:
            found = read(bad)
        except InputError as error:
            refusals.append(str(error))
        else:
            assert found.dtype == np.float64
    assert refusals
    assert all(bad.name in refusal for refusal in refusals)


@pytest.mark.parametrize("version", ["2.2", "4.0", "4.1"])
@pytest.mark.parametrize("binary", [False, True])
def test_tags_of_gmsh_are_checked_in_every_version(tmp_path, version, binary):
    """Whole files are read; a huge tag or count is refused before room is made for it."""
    import meshio

    corners = np.array([[0.0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 5]])
    mesh = meshio.Mesh(corners, [("triangle", np.array([[0, 1, 2], [0, 2, 3]]))])
    path = tmp_path / "a.msh"
    meshio.gmsh.write(path, mesh, version, binary=binary)
    assert gs.read_fault(path).n_triangle == 2
    data = path.read_bytes()
    four, huge = (b"\x04\x00\x00\x00", b"\xff\xff\xff\x7f") if binary else (b"4", b"99999999")
    start, end = data.index(b"$Nodes"), data.index(b"$EndNodes")
    refused, at = 0, data.find(four, start, end)
    while at >= 0:  # the number of nodes, and the last tag, wherever they stand
        path.write_bytes(data[:at] + huge + data[at + len(four) :])
        try:
            assert gs.read_fault(path).n_vertex == 4
        except FormatError as error:
            refused += "a.msh" in str(error) and ("$Nodes" in str(error) or "tag" in str(error))
        at = data.find(four, at + 1, end)
    assert refused >= (1 if binary and version == "2.2" else 2)


# ---- Legacy VTK and glTF: the same triangles as they were written with, and damaged files.
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
    "huge": (TEXT.replace("POINTS 4", "POINTS 9" + "0" * 15), "points are announced, but"),
    "nan": (TEXT.replace("9 9 0 0", "9 9 nan 0"), "line 10: found 'nan'"),
    "points": (TEXT.replace("POINTS 4", "POINTS 5"), "points have 12 numbers, expected 15"),
    "cells": (TEXT.replace("POLYGONS 2", "POLYGONS 3"), "have 2 cells, expected 3"),
    "corner": (TEXT.replace("3 0 1 2\n4", "3 0 1 7\n4"), "names point 7, expected 0 to 3"),
    "strips": (TEXT.replace("POLYGONS", "TRIANGLE_STRIPS"), "found triangle strips"),
    "data": (TEXT.replace("POINT_DATA 4", "POINT_DATA 3"), "3 rows of point data for 4 points"),
    "type": (TEXT.replace("throw int", "throw bit"), "are of the type 'bit'"),
    "offsets": (NEW + "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 2\n", "do not rise|found ''"),
    "binary": (BINARY + b"POINTS 2 double\n" + b"\0" * 47, "points need 48 bytes, but 47 follow"),
}  # fmt: skip


@pytest.mark.parametrize("case", VTK_DAMAGES)
def test_damaged_polydata_gets_one_sentence(tmp_path, case):
    content, message = VTK_DAMAGES[case]
    refused(FormatError, message, lambda: gs.read_fault(written(tmp_path, content)))


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
    refused(InputError, r"has 2 meshes: F1, F2\. Choose one, as in name='F1'", gs.read_fault, path)
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
    "deep": ('{"asset": 1, "nodes": ' + "[" * 100_000, "is incomplete|recursion"),
    "count": (entry("accessors", 0, count=10**12), "announces 1000000000000 values"),
    "corner": (in_text(*gltf(corners=(0, 1, 9))), "corners of triangles do not fit 4 points"),
    "nan": (in_text(*gltf(points=[[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], corners=(0, 1, 2))),
            "a position is not a finite number"),
    "sparse": (entry("accessors", 0, sparse={}), "accessor 0 is sparse"),
    "base64": (in_text(*gltf()).replace("base64,", "base64,*"), "base64 decoder"),
    "elsewhere": (json.dumps(gltf(buffers=[{"uri": "../../etc/passwd"}])[0]), "same folder"),
    "packed": (in_text(*gltf(extensionsRequired=["KHR_draco_mesh_compression"])),
               "needs the glTF extension KHR_draco"),
}  # fmt: skip


@pytest.mark.parametrize("case", GLTF_DAMAGES)
def test_damaged_gltf_gets_one_sentence(tmp_path, case):
    content, message = GLTF_DAMAGES[case]
    refused(FormatError, message, lambda: gs.read_fault(written(tmp_path, content, "a.gltf")))


def test_signatures_exclude_those_of_other_formats():
    for head in (TEXT.encode(), BINARY, in_text(*gltf()).encode(), packed(*gltf())):
        assert sum(fits(head[:8192]) for fits in SIGNATURES.values()) == 1


# ---- GOCAD Model3d: surfaces with roles, welded; damage is named.
HEAD_READ_MODEL3D = """GOCAD Model3d 1
HEADER {
name:two
}
TSURF F1
TSURF Top
TFACE 1 reverse_fault F1
  0 0 0
TFACE 2 top Top
  0 0 0
REGION 3 Universe
  +1  -2  0
END
"""
TSURF = """GOCAD TSurf 1
HEADER {
name:%s
}
GOCAD_ORIGINAL_COORDINATE_SYSTEM
ZPOSITIVE Depth
END_ORIGINAL_COORDINATE_SYSTEM
TFACE
VRTX 1 0 0 100
VRTX 2 9 0 100
VRTX 3 0 9 200
TRGL 1 2 3
TFACE
VRTX 4 9 0 100
VRTX 5 9 9 200
VRTX 6 0 9 200
TRGL 4 5 6
END
"""


def test_parts_are_welded_and_roles_are_those_of_the_model(tmp_path):
    text = HEAD_READ_MODEL3D + TSURF % "F1" + TSURF % "Top"
    surfaces = read_model3d(written(tmp_path, text))
    assert {name: s.role for name, s in surfaces.items()} == {"F1": "fault", "Top": "horizon"}
    for surface in surfaces.values():
        assert (surface.n_vertex, surface.n_triangle) == (4, 2)
        assert surface.bounds == (0.0, 9.0, 0.0, 9.0, -200.0, -100.0)


def test_horizons_are_turned_so_that_their_normals_point_up(tmp_path):
    upside_down = (TSURF % "Top").replace("TRGL 1 2 3", "TRGL 1 3 2")
    upside_down = upside_down.replace("TRGL 4 5 6", "TRGL 4 6 5")
    for text in (TSURF % "Top", upside_down):
        path = written(tmp_path, HEAD_READ_MODEL3D + TSURF % "F1" + text)
        top = read_model3d(path)["Top"]
        for a, b, c in top.vertices[top.triangles][:, :, :2].tolist():
            assert (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TSURF % "F1", r"two\.ml, line 1: found 'GOCAD TSurf 1', expected .*Model3d.*read_fault"),
        (
            HEAD_READ_MODEL3D + TSURF % "F1",
            r"two\.ml.*'Top', but the file has no such TSurf.*\['F1'\].*Export",
        ),
        (
            HEAD_READ_MODEL3D + 2 * (TSURF % "F1") + TSURF % "Top",
            r"two\.ml.*'F1' occurs twice.*Rename",
        ),
        (
            HEAD_READ_MODEL3D.replace("TFACE 2 top Top", "TFACE 2"),
            r"line 9: TFACE has 1 words.*Correct",
        ),
        (
            HEAD_READ_MODEL3D.replace("END\n", ""),
            r"model that begins on line 1 has no END.*export it again",
        ),
    ],
)
def test_damage_is_named(tmp_path, text, message):
    refused(FormatError, message, read_model3d, written(tmp_path, text, "two.ml"))
