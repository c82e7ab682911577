"""GeoJSON, VSet, glTF and tables: what is written is read back, or refused in one sentence."""

from __future__ import annotations

import csv
import json
import struct

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.conventions.axes import COORDINATES
from geosurf.errors import DependencyError, OutputError
from tests.grids import lines_of
from tests.messages import refused

CRS = "EPSG:23031"


@pytest.fixture(scope="module")
def scene(planes):
    return planes.replace(crs=CRS)


def points(**more):
    rng = np.random.default_rng(1)
    place = np.array([461000.0, 5932000.0, -1700.0]) + rng.normal(0, 100, (7, 3))
    data = {axis: ("point", place[:, k]) for k, axis in enumerate(COORDINATES)}
    return xr.Dataset(data | {key: ("point", value) for key, value in more.items()})


@pytest.mark.parametrize("suffix", [".xyz", ".poi", ".csv", ".vs", ".geojson"])
def test_law_points_come_back(tmp_path, suffix):
    cloud = points(pick=[*"abcdefg"])
    written = gs.write(cloud, tmp_path / f"a{suffix}", crs=CRS)
    stated = suffix in (".vs", ".geojson")
    back = gs.read_points(written[0], positive=None if stated else "up")
    for axis in COORDINATES:
        np.testing.assert_array_equal(back[axis], cloud[axis])
    assert stated != ("direction" in [one.what for one in written.lost])
    assert ("data" in [one.what for one in written.lost]) == (suffix in (".xyz", ".poi", ".vs"))


def test_points_that_files_do_not_hold(tmp_path):
    end = points()
    for axis in COORDINATES:
        end[axis][3] = 999.0
    with pytest.raises(OutputError, match=r"\(999, 999, 999\), which ends.*Write .csv"):
        gs.write(end, tmp_path / "a.xyz")
    gone = points()
    gone.elevation[2] = np.nan
    with pytest.raises(OutputError, match=r"point 2 .*not all of them finite. Drop"):
        gs.write(gone, tmp_path / "a.vs")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".pol", ".csv", ".geojson"])
def test_law_lines_come_back(scene, tmp_path, suffix):
    ring = np.array([[0.0, 0, 1], [9e5, 0, 2], [9e5, 9e5, 1 / 3], [0, 0, 1]])
    for lines in (scene.cutoffs("Top", "F1"), [ring, ring[:2]]):
        (path,) = gs.write(lines, tmp_path / f"a{suffix}", crs=CRS)
        back = gs.read_polygons(path, positive=None if suffix == ".geojson" else "up")
        assert len(back) == len(lines)
        for one, other in zip(lines, back, strict=True):
            np.testing.assert_array_equal(one, other)


def test_geojson_states_names_and_the_system(scene, tmp_path):
    (path,) = gs.write(scene.fault_polygons("Top"), tmp_path / "a.geojson")
    found = json.loads(path.read_text())
    assert found["crs"]["properties"]["name"] == "urn:ogc:def:crs:EPSG::23031"
    assert [one["properties"]["fault"] for one in found["features"]] == ["F1"]
    gs.write(scene.curves, tmp_path / "b.geojson")
    pairs = [
        (one["properties"]["surface"], one["properties"]["other"])
        for one in json.loads((tmp_path / "b.geojson").read_text())["features"]
    ]
    assert ("Top", "F1") in pairs
    with pytest.raises(OutputError, match=r"needs a coordinate reference .*found no .*crs='EPSG:2"):
        gs.write(scene.cutoffs("Top", "F1"), tmp_path / "c.geojson")
    with pytest.raises(OutputError, match=r"found 'UTM zone 31', no EPSG code"):
        gs.write(scene.cutoffs("Top", "F1"), tmp_path / "c.geojson", crs="UTM zone 31")
    with pytest.raises(OutputError, match=r"is in EPSG:23031, and crs= is EPSG:32631. Leave crs="):
        gs.write(scene.curves, tmp_path / "c.geojson", crs="EPSG:32631")


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_law_gltf_holds_names_colours_and_places(scene, tmp_path, suffix):
    written = gs.write(scene.units, tmp_path / f"a{suffix}")
    data = written[0].read_bytes()
    if suffix == ".glb":
        size, kind = struct.unpack("<2I", data[12:20])
        assert struct.unpack("<3I", data[:12]) == (0x46546C67, 2, len(data))
        assert (size % 4, kind) == (0, 0x4E4F534A)
        data = data[20 : 20 + size]
    nodes = json.loads(data)["nodes"][1:]
    assert [node["name"] for node in nodes] == list(scene.units)
    colours = [
        tuple(one["pbrMetallicRoughness"]["baseColorFactor"])
        for one in json.loads(data)["materials"]
    ]
    assert len(set(colours)) == len(scene.units)

    unit = next(iter(scene.units.values()))
    back = gs.read_fault(written[0], name=unit.name)
    np.testing.assert_array_equal(back.triangles, unit.triangles)
    moved = np.linalg.norm(back.vertices - unit.vertices, axis=1).max()
    assert moved <= max(written.largest_difference, 1e-6)


def test_tables(scene, tmp_path):
    written = gs.write(points(pick=[*"=bcdefg"]).to_dataframe(), tmp_path / "a.csv")
    assert written[0].read_text().split("\n")[0] == "easting,northing,elevation,pick"
    assert "'=" in written[0].read_text()
    table = xr.Dataset({"volume": ("unit", [1.0, 1 / 3], {"units": "m3"})})
    assert gs.write(table, tmp_path / "b.csv")[0].read_text() == f"volume_m3\n1.0\n{1 / 3!r}\n"
    (path,) = gs.write(scene.volumes, tmp_path / "d.csv")
    assert path.read_text().startswith("unit,zone,block,")
    assert path.read_text().split("\n")[0].endswith("volume_m3")
    thickness = scene.thickness(scene.reservoir[0], 500.0)
    (path,) = gs.write(thickness, tmp_path / "e.nc")
    np.testing.assert_array_equal(xr.load_dataset(path).thickness, thickness)
    (path,) = gs.write(thickness.rename(None), tmp_path / "e.nc")
    np.testing.assert_array_equal(xr.load_dataset(path).e, thickness)
    with pytest.raises(OutputError, match=r"a table has one dimension. Write .nc"):
        gs.write(xr.Dataset({"a": (("x", "y"), [[1.0]])}), tmp_path / "c.csv")


def test_parquet(scene, tmp_path):
    pandas = pytest.importorskip("pandas")
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        with pytest.raises(DependencyError, match=r'geosurf\[table\]"'):
            gs.write(scene.units, tmp_path / "a.parquet")
        return
    gs.write(scene.units, tmp_path / "a.parquet")
    back = pandas.read_parquet(tmp_path / "a.parquet")
    assert back["volume_m3"].tolist() == scene.volumes.volume.values.tolist()
    assert back.attrs["crs"] == CRS


def test_a_prj_next_to_an_esri_grid(tmp_path):
    top = gs.synthetic.tilted_planes(n=9).horizons["Top"]
    text = 'PROJCS["ED50 / UTM zone 31N",AUTHORITY["EPSG","23031"]]'
    written = gs.write(top, tmp_path / "a.asc", crs=text)
    assert [path.name for path in written] == ["a.asc", "a.prj"]
    assert "crs" not in [one.what for one in written.lost]
    with pytest.raises(OutputError, match=r"a.prj lies next to it .*Remove a.prj, or give crs="):
        gs.write(top, tmp_path / "a.asc")


# ---- Fault polygons and other lines of a model as files for mapping.
@pytest.fixture(scope="module")
def scene_lines():
    world = gs.synthetic.graben(n=5)
    return gs.Scene(world.horizons, world.faults, world.box)


def test_fault_polygons_come_back_from_pol_and_csv(scene_lines, tmp_path):
    lines = scene_lines.fault_polygons("Top")
    for name in ("a.pol", "a.csv"):
        written = gs.write(lines, tmp_path / name)
        found = gs.read_polygons(written[0], positive="up")
        assert len(found) == lines.sizes["line"] == 2
        for ring, part in zip(found, lines_of(lines, *COORDINATES), strict=True):
            np.testing.assert_array_equal(ring, np.concatenate([part, part[:1]]))
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {(row["POLY_ID"], row["FAULT"]) for row in rows} == {("1", "F1"), ("2", "F2")}
    assert set(rows[0]) == {"X", "Y", "Z", "POLY_ID", "FAULT", "PART", "MAP_AREA", "KIND"}


def test_what_is_no_file_says_what_is(scene_lines, tmp_path):
    words = r"suffixes .epc\. Or write its scene.units, scene.curves or"
    refused(OutputError, words, gs.write, scene_lines, tmp_path / "a.vtm")
