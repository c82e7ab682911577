"""Trajectories of RESQML packages, made by hand: places, units, names, and what is refused."""

from __future__ import annotations

import zipfile

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, InputError

h5py = pytest.importorskip("h5py", reason="h5py is not installed")
SPACES = (
    'xmlns:resqml2="http://www.energistics.org/energyml/data/resqmlv2" '
    'xmlns:eml="http://www.energistics.org/energyml/data/commonv2" '
    'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
)
FT = 0.3048
MD = np.array([0.0, 1000.0, 2000.0, 3000.0])
LOCAL = np.array([[0, 0, -25], [0, 0, 975], [300, 0, 1900], [900, 100, 2600.0]])


def tagged(name, text):
    return f"<resqml2:{name}>{text}</resqml2:{name}>"


def titled(name, uuid, title, body):
    citation = f"<eml:Citation><eml:Title>{title}</eml:Title></eml:Citation>"
    return f'<resqml2:{name} {SPACES} uuid="{uuid}">{citation}{body}</resqml2:{name}>'


def reference(name, uuid):
    return tagged(name, f"<eml:UUID>{uuid}</eml:UUID>")


def array(word, kind, inner, path):
    proxy = "<eml:HdfProxy><eml:UUID>h5</eml:UUID></eml:HdfProxy>"
    values = f"<eml:PathInHdfFile>{path}</eml:PathInHdfFile>{proxy}"
    return f'<resqml2:{word} xsi:type="resqml2:{kind}">{tagged(inner, values)}</resqml2:{word}>'


def system(unit="m", crs="<resqml2:EpsgCode>32631</resqml2:EpsgCode>", uuid="crs"):
    body = (
        "<resqml2:XOffset>100</resqml2:XOffset><resqml2:YOffset>50</resqml2:YOffset>"
        '<resqml2:ZOffset>0</resqml2:ZOffset><resqml2:ArealRotation uom="rad">0'
        "</resqml2:ArealRotation>"
        + tagged("ProjectedAxisOrder", "easting northing")
        + tagged("ProjectedUom", "m")
        + tagged("VerticalUom", unit)
        + tagged("ZIncreasingDownward", "true")
        + tagged("ProjectedCrs", crs)
    )
    return titled("LocalDepth3dCrs", uuid, "local", body)


def trajectory(uuid, title, *, n=4, unit="m", geometry=True, listed=True, crs="crs", of=""):
    line = (
        tagged("KnotCount", n)
        + tagged("LineKindIndex", 5)
        + (array("ControlPointParameters", "DoubleHdf5Array", "Values", f"{uuid}/md") * listed)
        + array("ControlPoints", "Point3dHdf5Array", "Coordinates", f"{uuid}/xyz")
        + reference("LocalCrs", crs)
    )
    line = f'<resqml2:Geometry xsi:type="resqml2:ParametricLineGeometry">{line}</resqml2:Geometry>'
    body = (reference("RepresentedInterpretation", of) if of else "") + tagged("MdUom", unit)
    return titled("WellboreTrajectoryRepresentation", uuid, title, body + line * geometry)


def package(folder, objects, arrays):
    path = folder / "w.epc"
    with zipfile.ZipFile(path, "w") as held:
        held.writestr("[Content_Types].xml", "<Types/>")
        for k, text in enumerate(objects):
            held.writestr(f"obj_{k}.xml", text)
    with h5py.File(path.with_suffix(".h5"), "w") as file:
        for uuid, (md, xyz) in arrays.items():
            file[f"{uuid}/md"], file[f"{uuid}/xyz"] = md, xyz
    return path


def single(folder, md=MD, xyz=LOCAL, unit="m", **words):
    held = [system(words.pop("z_unit", "m")), trajectory("t1", "W-1", unit=unit, **words)]
    return package(folder, held, {"t1": (md, xyz)})


def test_control_points_become_the_path(tmp_path):
    path = single(tmp_path)
    wells = gs.read_wells(path)
    assert set(wells.well.values) == {"W-1"}
    np.testing.assert_array_equal(wells.md, MD)
    np.testing.assert_array_equal(wells.easting, LOCAL[:, 0] + 100)
    np.testing.assert_array_equal(wells.northing, LOCAL[:, 1] + 50)
    np.testing.assert_array_equal(wells.elevation, -LOCAL[:, 2])
    assert wells.attrs["crs"] == "EPSG:32631"
    text = str(gs.info(path))
    assert "read_wells" in text
    assert "1, by control points with straight lines of up to 1000 m" in text
    assert "doubt" not in text


@pytest.mark.parametrize("md_unit", ["m", "ft"])
@pytest.mark.parametrize("z_unit", ["m", "ft"])
def test_law_measured_depths_and_z_have_units_of_their_own(tmp_path, md_unit, z_unit):
    wells = gs.read_wells(single(tmp_path, unit=md_unit, z_unit=z_unit))
    scale = {"m": 1.0, "ft": FT}
    np.testing.assert_allclose(wells.md, scale[md_unit] * MD, rtol=1e-15)
    np.testing.assert_allclose(wells.elevation, -scale[z_unit] * LOCAL[:, 2], rtol=1e-15)


def test_without_measured_depths_there_are_places_only(tmp_path):
    wells = gs.read_wells(single(tmp_path, listed=False))
    assert "md" not in wells
    assert wells.sizes["point"] == 4


def test_names_are_those_of_wells_where_each_has_one_trajectory(tmp_path):
    def well(k, name):
        feature = titled("WellboreFeature", f"f{k}", name, "")
        body = reference("InterpretedFeature", f"f{k}")
        return [feature, titled("WellboreInterpretation", f"i{k}", "any", body)]

    objects = [system(), *well(1, "A-1"), *well(2, "A-2")]
    lines = [("t1", "survey", "i1"), ("t2", "main", "i2"), ("t3", "side track", "i2"),
             ("t4", "survey", ""), ("t5", "survey", "gone")]  # fmt: skip
    objects += [trajectory(uuid, title, of=of) for uuid, title, of in lines]
    path = package(tmp_path, objects, {uuid: (MD, LOCAL) for uuid, *_ in lines})
    names = [*dict.fromkeys(gs.read_wells(path).well.values)]
    assert names == ["A-1", "main", "side track", "survey", "survey t5"]


def test_what_cannot_be_a_path_is_refused(tmp_path):
    for words, sentence in [
        ({"geometry": False}, "trajectory of well 'W-1' has no geometry"),
        ({"xyz": LOCAL * np.nan}, "control point that is not finite"),
        ({"xyz": LOCAL * 0}, "control points in one place"),
        ({"md": MD[::-1]}, "does not have 4 measured depths that rise"),
        ({"md": MD[:3]}, "does not have 4 measured depths that rise"),
        ({"n": 5}, "expected 5 x 3"),
    ]:
        with pytest.raises(FormatError, match=sentence):
            gs.read_wells(single(tmp_path, **words))
    with pytest.raises(InputError, match="the file has positive="):
        gs.read_wells(single(tmp_path), positive="up")
    with pytest.raises(InputError, match="columns"):
        gs.read_wells(single(tmp_path), columns={"md": "MD"})


def test_two_reference_systems_are_refused(tmp_path):
    other = system(crs="<resqml2:EpsgCode>23031</resqml2:EpsgCode>", uuid="other")
    objects = [system(), other, trajectory("t1", "A"), trajectory("t2", "B", crs="other")]
    path = package(tmp_path, objects, {"t1": (MD, LOCAL), "t2": (MD, LOCAL)})
    with pytest.raises(FormatError, match="2 coordinate reference systems"):
        gs.read_wells(path)


def test_packages_without_wells_name_what_they_have(tmp_path):
    world = gs.synthetic.graben(n=5)
    path = gs.write(world.horizons["Top"], tmp_path / "t.epc")[0]
    with pytest.raises(FormatError, match=r"no trajectory of a well; .* Grid2dRepresentation"):
        gs.read_wells(path)
    with pytest.raises(FormatError, match=r"no horizons.*WellboreTrajectoryRepresentation"):
        gs.read_horizon(single(tmp_path))
