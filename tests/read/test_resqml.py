"""RESQML read back: what geosurf writes to the last bit, local systems by their formula, damage."""

from __future__ import annotations

import io
import math
import re
import zipfile

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, InputError
from tests.grids import nodes_of
from tests.messages import refused

h5py = pytest.importorskip("h5py")
CRS = "EPSG:32631"
MOVED = np.array([5000.0, 0.0, 0.0])
PLAIN = (
    ('<resqml2:ArealRotation uom="rad">0<', '<resqml2:ArealRotation uom="{uom}">{turn}<'),
    ("<resqml2:XOffset>0<", "<resqml2:XOffset>{x}<"),
    ("<resqml2:YOffset>0<", "<resqml2:YOffset>{y}<"),
    ("<resqml2:ZOffset>0<", "<resqml2:ZOffset>{z}<"),
    ("<resqml2:ZIncreasingDownward>false<", "<resqml2:ZIncreasingDownward>{down}<"),
    ("<resqml2:VerticalUom>m<", "<resqml2:VerticalUom>{unit}<"),
    (">easting northing<", ">{axes}<"),
)


@pytest.fixture(scope="module")
def world():
    return gs.synthetic.graben(n=6)


@pytest.fixture
def package(world, tmp_path):
    scene = gs.Scene(world.horizons, world.faults, world.box, crs=CRS)
    return gs.write(scene, tmp_path / "m.epc")[0]


def edited(path, *pairs, more=None, drop=()):
    """Rewrite the texts of a package: a pattern becomes a word, in all that have it."""
    with zipfile.ZipFile(path) as held:
        texts = {name: held.read(name).decode() for name in held.namelist() if name not in drop}
    for old, new in pairs:
        assert any(re.search(old, text) for text in texts.values()), old
        texts = {name: re.sub(old, lambda _, w=new: w, text) for name, text in texts.items()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as held:
        for name, text in (texts | (more or {})).items():
            held.writestr(name, text)
    return path


def test_what_is_written_comes_back_to_the_last_bit(world, package):
    for name, horizon in world.horizons.items():
        found = gs.read_horizon(package, name=name)
        np.testing.assert_array_equal(nodes_of(found), nodes_of(horizon))
        assert (found.dims, found.attrs["crs"]) == (("northing", "easting"), CRS)
    for name, given in world.faults.items():
        expected = gs.triangulate_fault(given, name=name)
        found = gs.read_fault(package, name=name)
        np.testing.assert_array_equal(found.vertices, expected.vertices)
        np.testing.assert_array_equal(found.triangles, expected.triangles)
        assert (found.role, found.crs) == ("fault", CRS)
    text = str(gs.info(package))
    assert "Top (horizon), Middle (horizon), Base (horizon), F1 (fault), F2 (fault)" in text
    assert "positive up, stated by the file" in text


@pytest.mark.parametrize("turn", [0, 37.5, -120])
@pytest.mark.parametrize(("down", "unit"), [("true", "ft"), ("false", "m"), ("true", "m")])
def test_local_systems_are_moved_turned_and_scaled(package, turn, down, unit):
    local = nodes_of(gs.read_horizon(package, name="Top"))
    words = {"uom": "dega", "turn": turn, "x": 461000.5, "y": 5.9e6, "z": 25, "down": down}
    words |= {"unit": unit, "axes": "easting northing"}
    edited(package, *((old, new.format(**words)) for old, new in PLAIN))
    top = gs.read_horizon(package, name="Top")
    # clockwise from north: the local y axis points to (sin, cos)
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    scale = (0.3048 if unit == "ft" else 1.0) * (-1.0 if down == "true" else 1.0)
    expected = np.stack(
        [
            461000.5 + c * local[..., 0] + s * local[..., 1],
            5.9e6 - s * local[..., 0] + c * local[..., 1],
            scale * (local[..., 2] + 25),
        ],
        axis=-1,
    )
    np.testing.assert_allclose(nodes_of(top), expected, rtol=0, atol=1e-9)
    with pytest.raises(InputError, match="the file has positive="):
        gs.read_horizon(package, name="Top", positive="up" if down == "true" else "down")


def patched(package, local):
    """Divide the mesh of F1 into two patches, with corners counted in each or through both."""
    with h5py.File(package.with_suffix(".h5"), "r+") as file:
        with zipfile.ZipFile(package) as held:
            (name,) = (
                one for one in held.namelist()
                if "TriangulatedSet" in one and "rels" not in one and b">F1<" in held.read(one)
            )  # fmt: skip
            text = held.read(name).decode()
        folder = re.search(r"(/RESQML/[^/]+)/points", text)[1]
        points, triangles = (
            file[f"{folder}/points_patch0"][()],
            file[f"{folder}/triangles_patch0"][()],
        )
        n = len(points)
        file[f"{folder}/points_patch1"] = points[::-1] + MOVED
        file[f"{folder}/triangles_patch1"] = triangles + (0 if local else n)
    patch = re.search(r"<resqml2:TrianglePatch>.*</resqml2:TrianglePatch>", text, re.DOTALL)[0]
    second = patch.replace("patch0", "patch1").replace(
        ">0</resqml2:PatchIndex", ">1</resqml2:PatchIndex"
    )
    edited(package, more={name: text.replace(patch, patch + second)}, drop=(name,))
    both = np.concatenate([points, points[::-1] + MOVED])
    return both, np.concatenate([triangles, triangles + n])


@pytest.mark.parametrize("local", [True, False])
def test_patches_count_nodes_in_each_or_through_all(package, local):
    points, triangles = patched(package, local)
    fault = gs.read_fault(package, name="F1")
    np.testing.assert_array_equal(fault.vertices, points)
    np.testing.assert_array_equal(fault.triangles, triangles)


def lines_of(package, kind, body):
    """Add an object of lines or points that uses the points of F1."""
    with zipfile.ZipFile(package) as held:
        (text,) = (
            held.read(one).decode() for one in held.namelist()
            if "TriangulatedSet" in one and "rels" not in one and b">F1<" in held.read(one)
        )  # fmt: skip
    geometry = re.search(r"<resqml2:Geometry.*</resqml2:Geometry>", text, re.DOTALL)[0]
    head = text[: text.index("<resqml2:TrianglePatch>")]
    head = re.sub(
        r"<resqml2:RepresentedInterpretation.*?</resqml2:RepresentedInterpretation>", "", head
    )
    head = head.replace("TriangulatedSetRepresentation", kind).replace(">F1<", ">L<")
    head = re.sub(r'uuid="[^"]*"', 'uuid="line"', head, count=1)
    edited(package, more={"obj_l.xml": f"{head}{body.format(geometry)}</resqml2:{kind}>"})


def test_points_and_lines(package):
    points = gs.read_fault(package, name="F1").vertices
    n = len(points)
    patch = f"<resqml2:NodePatch><resqml2:Count>{n}</resqml2:Count>{{}}</resqml2:NodePatch>"
    lines_of(package, "PointSetRepresentation", patch)
    found = gs.read_points(package)
    np.testing.assert_array_equal(
        np.stack([found.easting, found.northing, found.elevation], 1), points
    )
    assert found.attrs["crs"] == CRS

    closed = "<resqml2:IsClosed>true</resqml2:IsClosed>"
    lines_of(package, "PolylineRepresentation", closed + patch)
    (ring,) = gs.read_polygons(package)
    np.testing.assert_array_equal(ring, np.concatenate([points, points[:1]]))

    counts = f"<v:Value>{n // 2}</v:Value><v:Count>2</v:Count>"
    never = "<v:Value>false</v:Value><v:Count>2</v:Count>"
    body = (
        '<resqml2:LinePatch xmlns:v="a"><v:ClosedPolylines xsi:type="r:BooleanConstantArray">'
        f'{never}</v:ClosedPolylines><v:NodeCountPerPolyline xsi:type="r:IntegerConstantArray">'
        f"{counts}</v:NodeCountPerPolyline>{{}}</resqml2:LinePatch>"
    )
    lines_of(package, "PolylineSetRepresentation", body)
    assert [len(line) for line in gs.read_polygons(package, name="L")] == [n // 2, n // 2]
    sticks = gs.read_fault(package, name="L")
    np.testing.assert_array_equal(np.concatenate(sticks.sticks), points)
    assert (len(sticks.sticks), sticks.crs) == (2, CRS)


def test_the_object_is_chosen_by_name_and_role(package):
    refused(InputError, "has 3 horizons: Top, Middle, Base", gs.read_horizon, package)
    with pytest.raises(InputError, match="has 2 faults: F1, F2, but none is called 'F3'"):
        gs.read_fault(package, name="F3")
    refused(FormatError, "has no sets of points", gs.read_points, package)
    edited(package, ("<eml:Title>Middle<", "<eml:Title>Top<"))
    with pytest.raises(InputError, match=r"has 3 horizons: Top [0-9a-f-]{36}, Top"):
        gs.read_horizon(package, name="Top")


def test_a_moved_package_finds_its_arrays_beside_it(package, tmp_path):
    (tmp_path / "m.h5").rename(tmp_path / "n.h5")
    package = package.rename(tmp_path / "n.epc")
    assert gs.read_horizon(package, name="Top").shape == (6, 6)
    (tmp_path / "n.h5").unlink()
    with pytest.raises(InputError, match=r"arrays are in m\.h5, which is not next to it"):
        gs.read_horizon(package, name="Top")


FAST = "<resqml2:FastestAxisCount>6"
# what is replaced by what, and what the error says
DAMAGES = {
    "time": ("LocalDepth3dCrs", "LocalTime3dCrs", "surfaces in depth, not in time"),
    "entities": ("<resqml2:Grid2dRep", "<!DOCTYPE a><resqml2:Grid2dRep", "declares a document"),
    "no array": ("/zvalues", "/other", r"m\.h5: h5py .array '/RESQML/.*other'"),
    "count": (FAST, FAST[:-1] + "7", "an axis of 7 nodes has 5 steps"),
    "huge": (FAST, FAST + "00000000", "needs .* MB of memory"),
    "word": ("Offset>0<", "Offset>1_0<", "ZOffset of a LocalDepth3dCrs is '1_0', no number"),
    "kind": ("Point3dZValueArray", "Point3dParametricArray", "kind Point3dParametricArray"),
}


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_packages_get_one_sentence(package, case):
    old, new, message = DAMAGES[case]
    edited(package, (old, new))
    refused(FormatError, message, gs.read_horizon, package, name="Top")


def test_other_archives_and_bombs(package, tmp_path):
    other = io.BytesIO()
    with zipfile.ZipFile(other, "w") as held:
        held.writestr("[Content_Types].xml", "<a/>")
    (tmp_path / "other.epc").write_bytes(other.getvalue())
    refused(FormatError, "not a package of RESQML", gs.read_horizon, tmp_path / "other.epc")
    bytes_ = package.read_bytes()
    package.write_bytes(bytes_[: len(bytes_) // 2])
    refused(FormatError, "zipfile cannot read it", gs.read_horizon, package)
    package.write_bytes(bytes_)
    edited(package, more={"obj_big.xml": b" " * (40 << 20)})
    refused(FormatError, r"'obj_big\.xml' needs 400 MB of memory", gs.read_horizon, package)
    package.with_suffix(".h5").write_bytes(b"\x89HDF\r\n\x1a\n" + b"\0" * 200)
    package.write_bytes(bytes_)
    refused(FormatError, r"m\.h5: h5py cannot read it", gs.read_horizon, package, name="Top")
