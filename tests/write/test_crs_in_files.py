"""Reference systems in files, as other programs look for them; tops and areas in another one."""

from __future__ import annotations

import json

import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import InputError

CRS = "EPSG:23031"
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
    found = gs.read_horizon(written[0], positive="up").attrs["crs"]
    assert found == CRS


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
    tops = xr.Dataset(
        {
            "well": ("top", ["W"]),
            "horizon": ("top", ["Top"]),
            "easting": ("top", [0.5 * (west + east)]),
            "northing": ("top", [0.5 * (south + north)]),
            "elevation": ("top", [-1000.0]),
        },
        attrs={"crs": "EPSG:32631"},
    )
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
    with pytest.raises(InputError, match=r"'tops' is in EPSG:32631, but .* Convert one"):
        scene.misfit(tops)


def test_wells_places_and_contacts_in_another_system_are_refused():
    world = gs.synthetic.tilted_planes(n=9)
    other = {"crs": "EPSG:32631"}
    scene = gs.Scene(world.horizons, world.faults, world.box, crs=CRS)
    axes = {"easting": [1000.0] * 2, "northing": [1000.0] * 2, "elevation": [-1800.0, -2400.0]}
    well = xr.Dataset({key: ("point", values) for key, values in axes.items()}, attrs=other)
    for ask in (scene.sample, scene.well_intervals, lambda one: scene.well_intervals({"W": one})):
        with pytest.raises(InputError, match=f"is in EPSG:32631, but 'scene' is in {CRS}"):
            ask(well)
    with pytest.warns(gs.GeosurfWarning, match="cannot compare"):
        scene.well_intervals(well.assign_attrs(crs="ED50-UTM31"))
    level = (0 * world.horizons["Top"] - 2100.0).assign_attrs(positive="up", units="m", **other)
    with pytest.raises(InputError, match=f"'OWC' is in EPSG:32631, but '(crs|Top)' is in {CRS}"):
        _ = scene.replace(contacts={"OWC": level}).units
