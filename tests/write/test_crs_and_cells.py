"""What a file keeps of a coordinate reference system; words that are no formulas."""

from __future__ import annotations

import csv
import io
import json
import zipfile

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.conventions.axes import COORDINATES
from geosurf.errors import InputError
from geosurf.write import WRITERS
from geosurf.write.datasets import FORMULA, csv_of_rows
from tests.measure.worlds import tops_at
from tests.messages import refused

CRS = "EPSG:23031"


@pytest.fixture(scope="module")
def scene():
    """A model whose horizons declare a reference system, and whose fault does not."""
    world = gs.synthetic.tilted_planes()
    horizons = {name: grid.assign_attrs(crs=CRS) for name, grid in world.horizons.items()}
    return gs.Scene(horizons, world.faults, world.box)


@pytest.fixture(scope="module")
def results(scene):
    """One of each kind of thing that can be written."""
    corners = np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]])
    one, faces = np.zeros(1, dtype=int), np.array([[0, 2, 1]])
    sides = np.array([[-1, 0]])
    row = np.arange(4)[None]
    tets = gs.TetMesh(corners, np.zeros(3), row, one, ("A",), faces, one, sides, ("B",))
    sticks = gs.FaultSticks("F", [corners[:2], corners[2:]])
    for made in (tets, sticks):
        object.__setattr__(made, "crs", CRS)
    wall = gs.TriSurface("F2", "fault", corners, [[0, 1, 2]])
    top = gs.synthetic.tilted_planes().horizons["Top"].assign_attrs(crs=CRS)
    place = {axis: ("point", corners[:, k]) for k, axis in enumerate(COORDINATES)}
    scatter = xr.Dataset(place | {"pick": ("point", [*"abcd"])})
    return {
        "TriSurface": scene.surface("Top"),
        "Curves": scene.curves,
        "Patches": scene.patches,
        "Unit": next(iter(scene.units.values())),
        "Units": scene.units,
        "horizon (DataArray)": top,
        "Dataset of fault multipliers": gs.fault_multipliers(
            scene, gs.build_grid(scene, cell=1000, layers=1), vshale=0.3, permeability=9.0
        ),
        "Dataset": xr.Dataset({"volume": ("unit", [1.0, 2.0])}, attrs={"crs": CRS}),
        "Dataset of lines": scene.fault_polygons("Top"),
        "Dataset of points": scatter.assign_attrs(crs=CRS),
        "Dataset on a grid": scene.sample(cell=(500, 500, 100)),
        "DataFrame": scatter.to_dataframe(),
        "list of lines": scene.cutoffs("Top", "F1"),
        "TetMesh": tets,
        "FaultSticks": sticks,
        "CornerPointGrid": gs.build_grid(scene, cell=(2000, 1500), layers=1),
        "surfaces": [top.rename("Top"), wall],
    }


@pytest.mark.parametrize(
    ("kind", "suffix"), [(kind, suffix) for kind in WRITERS for suffix in WRITERS[kind]]
)
def test_law_a_reference_system_is_in_the_file_or_in_the_losses(results, tmp_path, kind, suffix):
    if suffix in (".egrid", ".roff"):
        pytest.importorskip("xtgeo", reason="xtgeo is not installed")
    if suffix == ".parquet":
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    if suffix == ".zarr":
        pytest.importorskip("zarr", reason="zarr is not installed")
    written = gs.write(results[kind], tmp_path / f"a{suffix}", crs=CRS)
    noted = [one for one in written.lost if one.what == "crs" and CRS in one.sentence]
    content = b"".join(content_of(path) for path in written)
    # a .prj of ESRI, written where pyproj is installed, has names and no codes
    assert (b"23031" in content or b"ED_1950_UTM_Zone_31N" in content) == (not noted)


def content_of(path):
    """The bytes of a file; of an archive or a folder, those of all files in it."""
    if path.is_dir():
        return b"".join(one.read_bytes() for one in path.rglob("*") if one.is_file())
    if path.suffix != ".epc":
        return path.read_bytes()
    with zipfile.ZipFile(path) as archive:
        return b"".join(map(archive.read, archive.namelist()))


def test_a_horizon_with_a_grid_mapping_keeps_it_in_netcdf(tmp_path):
    mark = xr.DataArray(0, attrs={"spatial_ref": CRS})
    top = gs.synthetic.tilted_planes().horizons["Top"].assign_coords(spatial_ref=mark)
    gs.write(top, tmp_path / "a.nc")
    assert gs.read_horizon(tmp_path / "a.nc").attrs["crs"] == CRS


@given(st.lists(st.one_of(st.floats(), st.integers(), st.text("=+-@\t\r\n ,'\"aF1\uff1d"))))
def test_law_words_are_no_formulas_and_numbers_stay(row):
    data, notes = csv_of_rows(["x"] * len(row), [row])
    found = list(csv.reader(io.StringIO(data.decode(), newline="")))[1:] or [[]]
    risky = [isinstance(cell, str) and cell.startswith(FORMULA) for cell in row]
    for cell, text, risk in zip(row, found[0], risky, strict=True):
        assert text == (f"'{cell}" if risk else str(cell))
    assert bool(notes) == any(risky)


# ---- Reference systems in files, as other programs look for them; tops and areas in another o

WKT = 'PROJCS["ED50 / UTM zone 31N",GEOGCS["ED50"],UNIT["metre",1],AUTHORITY["EPSG","23031"]]'


def top(**attrs):
    return gs.synthetic.tilted_planes(n=9).horizons["Top"].assign_attrs(attrs)


@pytest.mark.parametrize("crs", [CRS, WKT])
def test_netcdf_has_the_grid_mapping_of_cf_and_rioxarray(tmp_path, crs):
    (path,) = gs.write(top(), tmp_path / "a.nc", crs=crs)
    with xr.open_dataset(path, decode_coords=False) as found:
        assert found["elevation"].attrs["grid_mapping"] == "spatial_ref"
        assert found["spatial_ref"].shape == ()
        text = found["spatial_ref"].attrs["spatial_ref"]
        assert "23031" in text or "ED50" in text
        assert found.easting.attrs["standard_name"] == "projection_x_coordinate"
    assert gs.read_horizon(path).attrs["crs"] in (CRS, crs)


def test_a_file_of_rioxarray_is_read(tmp_path):
    mapping = xr.DataArray(0, attrs={"spatial_ref": WKT, "GeoTransform": "0 1 0 0 0 1"})
    made = top().rename("elevation").to_dataset().assign_coords(spatial_ref=mapping)
    made["elevation"].attrs["grid_mapping"] = "spatial_ref"
    made.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    assert gs.read_horizon(tmp_path / "a.nc").attrs["crs"] == CRS


@pytest.mark.parametrize("suffix", [".asc", ".zmap"])
def test_text_grids_come_back_in_their_system(tmp_path, suffix):
    written = gs.write(top(crs=WKT), tmp_path / f"a{suffix}")
    assert not [one for one in written.lost if one.what == "crs"]
    assert gs.read_horizon(written[0], positive="up").attrs["crs"] == CRS


def test_an_epsg_code_needs_pyproj_for_prj(tmp_path):
    try:
        import pyproj  # noqa: F401
    except ImportError:
        written = gs.write(top(crs=CRS), tmp_path / "a.asc")
        assert len(written) == 1
        assert 'pip install "geosurf[crs]"' in written.notes[-1]
    else:
        written = gs.write(top(crs=CRS), tmp_path / "a.asc")
        assert gs.read_horizon(written[0], positive="up").attrs["crs"] == CRS


def test_tops_and_area_in_another_system_are_refused(tmp_path):
    world = gs.synthetic.tilted_planes(n=9)
    west, east, south, north, *_ = world.box
    table = tops_at([0.5 * (west + east), 0.5 * (south + north), -1000.0])
    tops = xr.Dataset({k: ("top", of) for k, of in table.items()}, attrs={"crs": "EPSG:32631"})
    ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    area = {
        "type": "Feature",
        "properties": {},
        "geometry": {"type": "Polygon", "coordinates": [[[*p, 0.0] for p in ring]]},
        "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32631"}},
    }
    (tmp_path / "area.geojson").write_text(json.dumps(area))
    words = {"horizons": world.horizons, "faults": world.faults, "crs": CRS}
    for more, name in (({"tops": tops}, "tops"), ({"aoi": tmp_path / "area.geojson"}, "aoi")):
        with pytest.raises(
            InputError, match=rf"'{name}' is in EPSG:32631, but '(crs|Top)' is in {CRS}"
        ):
            _ = gs.Scene(**words, **more).units
    scene = gs.Scene(**words, tops=tops.assign_attrs(crs=CRS), aoi=ring)
    assert scene.misfit().sizes["top"] == 1
    refused(InputError, r"'tops' is in EPSG:32631, but .* Convert one", scene.misfit, tops)


def test_wells_places_and_contacts_in_another_system_are_refused():
    world = gs.synthetic.tilted_planes(n=9)
    other = {"crs": "EPSG:32631"}
    scene = gs.Scene(world.horizons, world.faults, world.box, crs=CRS)
    axes = {"easting": [1000.0] * 2, "northing": [1000.0] * 2, "elevation": [-1800.0, -2400.0]}
    well = xr.Dataset({key: ("point", values) for key, values in axes.items()}, attrs=other)
    for ask in (scene.sample, scene.well_intervals, lambda one: scene.well_intervals({"W": one})):
        refused(InputError, f"is in EPSG:32631, but 'scene' is in {CRS}", ask, well)
    with pytest.warns(gs.GeosurfWarning, match="cannot compare"):
        scene.well_intervals(well.assign_attrs(crs="ED50-UTM31"))
    level = (0 * world.horizons["Top"] - 2100.0).assign_attrs(positive="up", units="m", **other)
    with pytest.raises(InputError, match=f"'OWC' is in EPSG:32631, but '(crs|Top)' is in {CRS}"):
        _ = scene.replace(contacts={"OWC": level}).units
