"""Meshes: what meshio and VTK write, what it must not do to us, and files truncated."""

from __future__ import annotations

import sys
import warnings

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, InputError

OBJ = "v 0 0 0\nv 9 0 0\nv 9 9 9\nv 0 9 9\nf 1 2 3 4\n"


def ramp():
    east, north = 500_000.5, 6_000_000.25
    vertices = [[east, north, 0], [east + 9, north, 0.25], [east, north + 9, 9.5]]
    return gs.TriSurface("F1", "fault", vertices, [[0, 1, 2]])


def test_quads_are_split(tmp_path):
    (tmp_path / "F1.obj").write_text(OBJ)
    fault = gs.read_fault(tmp_path / "F1.obj")
    assert fault.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.obj", OBJ.replace("1 2 3 4", "1 2 7 4"), r"triangle 0 refers to vertices"),
        ("a.obj", OBJ.replace("9 9 9", "9 9 nine"), r"meshio cannot read it .*nine.*export it"),
        ("a.obj", OBJ.replace("9 9 9", "9 nan 9"), r"vertices are not finite.*vertex 2"),
        ("a.stl", "solid\nfacet normal 0 0 1\n", r"the last line is 'facet.*expected 'endsolid'"),
        (
            "a.vtk",
            "# vtk DataFile Version 4.2\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n",
            r"meshio cannot read it",
        ),
        ("a.off", "OFF\n# made by\n\n", r"missing after the first line.*export"),
        ("b.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n", r"a section does not begin"),
        ("a.ply", "ply\nformat ascii 1.0\n", r"has no line 'end_header'.*export"),
    ],
)
def test_wrong_meshes(tmp_path, capfd, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(FormatError, match=message):
        gs.read_fault(tmp_path / name)
    out, err = capfd.readouterr()
    assert out + err == ""


def test_volumes_are_refused(tmp_path):
    import meshio

    tetra = meshio.Mesh(np.eye(4)[:, :3], [("tetra", [[0, 1, 2, 3]])])
    tetra.write(tmp_path / "a.vtu")
    with pytest.raises(FormatError, match=r"cell 0 is of VTK type 10, expected triangles"):
        gs.read_fault(tmp_path / "a.vtu")


def test_meshio_is_imported_only_when_needed(tmp_path):
    import subprocess

    (path,) = gs.write(ramp(), tmp_path / "F1.vtp")
    code = (
        "import sys, geosurf as gs; gs.read_fault(sys.argv[1]); gs.write;"
        "print([m for m in ('meshio', 'xarray', 'pyvista', 'vtk', 'scipy') if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZMA"])
@pytest.mark.parametrize("header", ["32", "64"])
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
        (('NumberOfStrips="0"', 'NumberOfStrips="#"'), r"NumberOfStrips of a <Piece> is '#'"),
        (('NumberOfPolys="1"', 'NumberOfPolys="2"'), r"found 1 cells with 3 corners, expected 2"),
        (('NumberOfPolys="1"', 'NumberOfPolys="0"'), r"the file has no triangles"),
        (('Name="connectivity"', 'Name="x"'), r"found no array for connectivity"),
        (('"Float64"', '"String"'), r"an array of type 'String' for Points"),
        (('"UInt64"', '"UInt32"'), r"F1.vtp: "),
        (("</VTKFile>", ""), r"the XML is incomplete"),
    ],
)
def test_wrong_vtp(tmp_path, change, message):
    with pytest.raises(FormatError, match=message):
        gs.read_fault(vtp(tmp_path, *change))


def horizon_2_by_2(folder):
    path = folder / "in.irap"
    path.write_text("-996 2 10 10\n500 510 0 10\n2 30 500 0\n0 0 0 0 0 0 0\n1.25 2.5 3 9999900.0\n")
    return gs.read_horizon(path, positive="up", name="Top")


def whole_files(folder):
    """One small file per format, the reader, and its right answer as an array."""
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
def test_a_file_cut_at_any_byte_is_refused_or_read_right_or_warned_of(tmp_path, name):
    path, read = whole_files(tmp_path)[name]
    right = read(path)
    data = path.read_bytes()
    cut = path.with_name(f"cut{path.suffix}")
    refused = warned = 0
    for n in range(len(data)):
        cut.write_bytes(data[:n])
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            try:
                found = read(cut)
            except FormatError as error:
                refused += cut.name in str(error)
                continue
        warned += len(told) > 0
        assert {one.message.kind for one in told} <= {"file end"}
        if not told:
            np.testing.assert_array_equal(found, right, err_msg=f"cut at {n} of {len(data)}")
    assert refused + warned > 0.9 * len(data)
    assert warned < 0.25 * len(data)


def test_a_netcdf_file_cut_short_is_refused(tmp_path):
    (path,) = gs.write(horizon_2_by_2(tmp_path), tmp_path / "a.nc")
    data = path.read_bytes()
    cut = tmp_path / "cut.nc"
    for n in {*range(0, len(data), 97), *range(16), len(data) - 1}:
        cut.write_bytes(data[:n])
        with pytest.raises(FormatError, match=r"cut.nc"):
            gs.read_horizon(cut)


@pytest.mark.filterwarnings("ignore:.*no line end follows")
@pytest.mark.parametrize("name", NAMES)
def test_a_damaged_byte_is_read_or_refused_by_name(tmp_path, rng, name):
    """Whatever one byte says, the reader gives numbers, or names the file in an error of ours."""
    path, read = whole_files(tmp_path)[name]
    data = path.read_bytes()
    bad = path.with_name(f"bad{path.suffix}")
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


@pytest.mark.parametrize("place", range(3))
def test_tags_of_gmsh_data_are_no_more_than_lines(tmp_path, place):
    """meshio would read lines behind the end of the file, as many as are announced."""
    counts = ["1", "1", "3"]
    counts[place] = "99999999"
    data = f'$NodeData\n{counts[0]}\n"a"\n{counts[1]}\n0.0\n{counts[2]}\n0\n1\n1\n1 5.0\n'
    path = tmp_path / "a.msh"
    path.write_text(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 9 0 0\n3 0 9 9\n$EndNodes\n"
        f"$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n{data}$EndNodeData\n"
    )
    with pytest.raises(FormatError, match=r"a\.msh: 99999999 lines .*\$NodeData"):
        gs.read_fault(path)
