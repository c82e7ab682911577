"""RESQML: nodes and triangles to the last bit, objects that all exist, same bytes twice."""

from __future__ import annotations

import io
import shutil
import zipfile
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import geosurf as gs
from geosurf.cli import main
from geosurf.errors import FormatError, InputError, OutputError
from geosurf.write.model3d import parts_of
from geosurf.write.resqml_framework import lines_of, shells_of
from tests.grids import gridded, nodes_of
from tests.messages import refused
from tests.read.test_resqml import edited
from tests.write.sealed import assert_equal

h5py = pytest.importorskip("h5py")
CRS = "EPSG:32631"


@pytest.fixture(scope="module")
def world():
    return gs.synthetic.graben(n=7)


@pytest.fixture(scope="module")
def fault(world):
    surface = gs.triangulate_fault(world.faults["F1"], name="F1")
    surface.crs = CRS
    return surface


def rotated(horizon):
    """The same horizon, turned by 30 degrees about its first node: no step gives its nodes."""
    x, y = np.meshgrid(horizon.easting, horizon.northing)
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    return gridded(horizon.values, c * x - s * y + 461_000.1, s * x + c * y, **horizon.attrs)


class Package:
    """What lies in an .epc: objects by kind and title, arrays by path."""

    def __init__(self, path):
        self.names = zipfile.ZipFile(path).namelist()
        self.texts = {name: zipfile.ZipFile(path).read(name).decode() for name in self.names}
        self.roots = {
            name: ElementTree.fromstring(text)
            for name, text in self.texts.items()
            if name.startswith("obj_")
        }
        self.file = h5py.File(io.BytesIO(path.with_suffix(".h5").read_bytes()), "r")

    def one(self, kind, title):
        (root,) = (
            root for name, root in self.roots.items()
            if name.startswith(f"obj_{kind}_") and text(root, "Title") == title
        )  # fmt: skip
        return root

    def arrays(self, root):
        return [self.file[e.text][()] for e in root.iter() if tag(e) == "PathInHdfFile"]


def tag(element):
    return element.tag.rpartition("}")[2]


def text(root, name):
    return next(e.text for e in root.iter() if tag(e) == name)


def nodes(package, title):
    """Coordinates of all nodes of a grid, by the rule of the format."""
    root = package.one("Grid2dRepresentation", title)
    (array,) = package.arrays(root)
    n_row, n_col = int(text(root, "SlowestAxisCount")), int(text(root, "FastestAxisCount"))
    if array.ndim == 3:
        assert array.shape == (n_row, n_col, 3)
        return np.moveaxis(array, -1, 0)
    points = [
        [float(c.text) for c in e] for e in root.iter()
        if [tag(c) for c in e] == ["Coordinate1", "Coordinate2", "Coordinate3"]
    ]  # fmt: skip
    spacing = [float(e.text) for e in root.iter() if tag(e) == "Value"]
    counts = [int(e.text) for e in root.iter() if tag(e) == "Count"]
    assert counts == [n_row - 1, n_col - 1]
    origin, down, along = map(np.array, points)
    row, column = np.arange(n_row)[:, None, None], np.arange(n_col)[:, None]
    place = origin + row * (spacing[0] * down) + column * (spacing[1] * along)
    return place[..., 0], place[..., 1], array


def test_nodes_and_triangles_are_those_of_the_surfaces(world, fault, tmp_path):
    top = world.horizons["Top"].copy()
    top[2, 3] = np.nan
    turned = rotated(top)
    written = gs.write({"Top": top, "Turned": turned, "F1": fault}, tmp_path / "m.epc")
    assert [path.name for path in written] == ["m.epc", "m.h5"]
    package = Package(written[0])
    for name, horizon in (("Top", top), ("Turned", turned)):
        for k, found in enumerate(nodes(package, name)):
            np.testing.assert_array_equal(found, nodes_of(horizon)[..., k])
    arrays = package.arrays(package.one("TriangulatedSetRepresentation", "F1"))
    triangles, points = sorted(arrays, key=lambda a: a.dtype.kind == "f")
    np.testing.assert_array_equal(points, fault.vertices)
    np.testing.assert_array_equal(triangles, fault.triangles)
    system = package.one("LocalDepth3dCrs", CRS)
    words = ("EpsgCode", "ZIncreasingDownward", "VerticalUom", "ProjectedUom")
    assert [text(system, word) for word in words] == ["32631", "false", "m", "m"]


def test_depths_and_feet_become_elevations_in_metres(world, tmp_path):
    top = world.horizons["Top"]
    deep = (-top / 0.3048).assign_attrs(positive="down", units="ft")
    (path, _) = gs.write(deep, tmp_path / "deep.epc", name="Deep")
    np.testing.assert_allclose(nodes(Package(path), "Deep")[2], top.values, rtol=1e-15)


def test_all_references_and_relations_lead_to_objects_of_the_package(world, tmp_path):
    scene = gs.Scene(world.horizons, world.faults, world.box, crs=CRS)
    package = Package(gs.write(scene, tmp_path / "scene.epc")[0])
    known = {root.get("uuid"): name for name, root in package.roots.items()}
    assert len(known) == len(package.roots) == 2 + 3 * 5  # five horizons and faults
    for name, root in package.roots.items():
        for uuid in (e.text for e in root.iter() if tag(e) == "UUID"):
            assert uuid in known
            assert known[uuid] in package.texts[f"_rels/{name}.rels"]
            assert name in package.texts[f"_rels/{known[uuid]}.rels"]
        assert f'PartName="/{name}"' in package.texts["[Content_Types].xml"]
    for title, kind in (("Top", "Horizon"), ("F2", "Fault")):
        assert package.one(f"{kind}Interpretation", title) is not None


def test_the_same_surfaces_give_the_same_bytes_and_others_other_identifiers(world, tmp_path):
    once = gs.write(world.horizons, tmp_path / "a.epc")
    first = [path.read_bytes() for path in once]
    gs.write(world.horizons, tmp_path / "a.epc")
    assert [path.read_bytes() for path in once] == first
    moved = {name: horizon + 1.0 for name, horizon in world.horizons.items()}
    moved = {name: moved[name].assign_attrs(world.horizons[name].attrs) for name in moved}
    other = gs.write(moved, tmp_path / "b.epc")
    assert not set(Package(once[0]).roots) & set(Package(other[0]).roots)


def test_what_is_no_surface_is_refused_and_nothing_is_left(world, fault, tmp_path):
    top = world.horizons["Top"].assign_attrs(crs="EPSG:23031")
    for wrong, words in (
        (5, "cannot write an object of type int"),
        ([], "cannot write an object of type list"),
        ([fault, "F2"], "cannot write str"),
        ([fault, fault], "two surfaces are called 'F1'"),
        ([top, fault], "different coordinate reference systems, EPSG:23031 and EPSG:32631"),
    ):
        refused(OutputError, words, gs.write, wrong, tmp_path / "m.epc")
    with pytest.raises(InputError, match="positive"):
        gs.write(world.horizons["Top"].drop_attrs(), tmp_path / "m.epc")
    assert not list(tmp_path.iterdir())


# ---- Sealed models as RESQML: units out are units in; patches share the nodes of lines.
pytest.importorskip("h5py")


@pytest.fixture(scope="module")
def whole(graben, tmp_path_factory):
    """The files of a sealed model; tests take copies."""
    return gs.write(graben, tmp_path_factory.mktemp("whole") / "m.epc", name="m")


@pytest.fixture
def written(whole, tmp_path):
    package, _ = (Path(shutil.copy(path, tmp_path)) for path in whole)
    return package


def test_packages_of_other_programs_name_zones_only(graben, written):
    labels = "<resqml2:ExtraMetadata>.*?</resqml2:Value></resqml2:ExtraMetadata>"
    back = gs.read_units(edited(written, (labels, "")))
    assert [u.zone for u in back.values()] == [u.zone for u in graben.values()]
    assert [u.volume for u in back.values()] == pytest.approx([u.volume for u in graben.values()])
    assert len(set(back)) == len(graben)


@pytest.mark.parametrize("model", ["graben", "slit"])
def test_each_edge_where_parts_meet_is_on_one_line_with_all_its_sides(model, request):
    parts = parts_of(request.getfixturevalue(model))
    expected = Counter()
    for k in range(len(parts.surface)):
        mine = parts.triangles[parts.first_triangle[k] : parts.first_triangle[k + 1]]
        edges = {(t[i], t[(i + 1) % 3]) for t in mine.tolist() for i in range(3)}
        for a, b in edges:
            if (b, a) not in edges:
                ends = sorted([tuple(parts.vertices[a]), tuple(parts.vertices[b])])
                expected[tuple(ends)] += 1

    found = Counter()
    for line in lines_of(parts):
        places = parts.vertices[line.vertices]
        assert (places == places[0]).all()
        assert len({tuple(row) for row in line.vertices.tolist()}) == len(line.parts) >= 2
        for side in places:
            for a, b in zip(side[:-1].tolist(), side[1:].tolist(), strict=True):
                found[tuple(sorted([tuple(a), tuple(b)]))] += 1
    assert found == Counter({edge: n for edge, n in expected.items() if n > 1})


def test_a_shell_inside_of_a_unit_is_an_inner_one(slit):
    """Parts of a fault that touches no border of its unit are a shell of their own."""
    parts = parts_of(slit)
    shells = shells_of(parts, lines_of(parts), len(slit))
    for unit, mine in enumerate(shells[:-1]):
        listed = Counter(face for shell in mine for face in shell)
        sides = [(k, s == 0) for k, s in np.argwhere(parts.sides == unit).tolist()]
        assert listed == Counter(sides)
    assert len(shells[-1]) == 1
    alone = shells_of(parts, [], len(slit))
    assert all(len(shell) <= 2 for mine in alone for shell in mine)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<resqml2:SideIsPlus>true", "<resqml2:SideIsPlus>false", "lie on the same side|closed"),
        ("<resqml2:PatchIndexOfRepresentation>0<", "<resqml2:PatchIndexOfRepresentation>99<",
         "names patch 99 of surface"),
        ("obj_SealedVolumeFrameworkRepresentation", "obj_Other", "0 sealed volume frameworks"),
        ("<resqml2:Name>geosurf.model", "<resqml2:Name>geosurf.unit", "describes"),
        ("<resqml2:Value>", "<resqml2:Value>{", "metadata .* is damaged"),
        ('"above OWC"', "5", "damaged labels"),
        ("<resqml2:BasedOn .*?</resqml2:BasedOn>", "", "has no BasedOn"),
        ("<resqml2:Represents .*?</resqml2:Represents>", "", "has no Represents"),
        ("<resqml2:ExternalShell>.*?</resqml2:MacroFaces>", "<resqml2:ExternalShell>",
         "is not closed near"),
    ],
)  # fmt: skip
def test_damage_is_named(written, old, new, words):
    refused(FormatError, words, gs.read_units, edited(written, (old, new)))


def test_convert_takes_the_units_where_the_target_does(graben, written, tmp_path, capsys):
    assert main(["convert", str(written), str(tmp_path / "m.ml")]) == 0
    assert "read with read_units" in capsys.readouterr().out
    assert_equal(gs.read_units(tmp_path / "m.ml"), graben)


def test_no_units_are_refused(graben, tmp_path):
    refused(OutputError, "no units", lambda: gs.write(gs.Units([], graben.box), tmp_path / "m.epc"))
    assert not list(tmp_path.iterdir())
