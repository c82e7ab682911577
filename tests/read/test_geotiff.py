"""GeoTIFF through rasterio: placed exactly, rotated or not; damaged files in one sentence."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import DependencyError, FormatError, InputError

Z = np.array([[1.25, 2.5, 3.0], [4.0, np.nan, 6.125]], dtype=np.float32)


def made(path, place, values=Z, **words):
    """A GeoTIFF as rasterio writes it."""
    rasterio = pytest.importorskip("rasterio", reason="rasterio is not installed (extra gis)")
    words = {"crs": "EPSG:32631", "nodata": -999.0, "dtype": values.dtype} | words
    layers = values if values.ndim == 3 else values[None]
    count, height, width = layers.shape
    scale = words.pop("scale", None)
    with rasterio.open(
        path, "w", driver="GTiff", width=width, height=height, count=count,
        transform=rasterio.Affine(*place), **words,
    ) as file:  # fmt: skip
        file.write(np.where(np.isnan(layers), -999.0, layers).astype(values.dtype))
        if scale:
            file.scales, file.offsets, file.units = (scale,), (10.0,), ("ft",)
    return path


def nodes(top):
    x, y = top.easting.values, top.northing.values
    if x.ndim == 1:
        x, y = np.meshgrid(x, y)
    z = top.values
    return {row for row in zip(x.ravel(), y.ravel(), z.ravel(), strict=True) if row[2] == row[2]}


@pytest.mark.parametrize("more", [{}, {"compress": "lzw", "predictor": 3, "tiled": True,
                                       "blockxsize": 16, "blockysize": 16}])  # fmt: skip
def test_a_map_lies_at_the_centres_of_its_cells(tmp_path, more):
    path = made(tmp_path / "top", (10, 0, 461000, 0, -20, 5932000), **more)
    top = gs.read_horizon(path, positive="up")
    np.testing.assert_array_equal(top.values, Z[::-1])
    assert top.easting.values.tolist() == [461005, 461015, 461025]
    assert top.northing.values.tolist() == [5931970, 5931990]
    assert top.attrs["crs"] == "EPSG:32631"
    found = gs.info(path)
    assert (found.format, found.count) == ("geotiff", 5)
    assert (found.notes["null"], found.notes["crs"]) == ("-999", "EPSG:32631")


@pytest.mark.parametrize("flip", [1, -1])
def test_a_rotated_map_keeps_every_node(tmp_path, flip):
    cos, sin = np.cos(np.radians(30)), np.sin(np.radians(30))
    place = (10 * cos, -20 * sin * flip, 461000, 10 * sin, 20 * cos * flip, 5932000)
    top = gs.read_horizon(made(tmp_path / "t.tif", place), positive="down")
    j, i = np.meshgrid(np.arange(3) + 0.5, np.arange(2) + 0.5)
    x = place[0] * j + place[1] * i + place[2]
    y = place[3] * j + place[4] * i + place[5]
    wanted = np.stack([x, y, -Z], axis=-1)[~np.isnan(Z)]
    found = np.array(sorted(nodes(top)))
    assert np.abs(found - wanted[np.lexsort(wanted.T[::-1])]).max() < 1e-6
    assert gs.Lattice(top.easting.values, top.northing.values, top.values).right_handed


def test_scale_offset_and_unit_of_the_band_count(tmp_path):
    path = made(
        tmp_path / "t.tif", (10, 0, 0, 0, -10, 0), np.nan_to_num(Z * 8).astype("i2"), scale=0.5
    )
    top = gs.read_horizon(path, positive="up")
    assert top.values[1, 0] == (10 * 0.5 + 10) * 0.3048


@pytest.mark.parametrize(
    ("place", "words", "error", "message"),
    [
        ((10, 0, 0, 0, -10, 0), {"values": np.stack([Z, Z])}, FormatError, "has 2 bands"),
        ((1, 0, 0, 0, 1, 0), {"crs": None}, FormatError, "states no place"),
        ((10, 5, 0, 0, -10, 0), {}, FormatError, "not at right angles"),
        ((0.1, 0, 2, 0, -0.1, 56), {"crs": "EPSG:4326"}, InputError, "are in degrees"),
        ((10, 0, 0, 0, -10, 0), {"values": np.full((2, 2), np.inf, "f4")}, FormatError, "infinite"),
    ],
)
@pytest.mark.filterwarnings("ignore::Warning")
def test_maps_that_cannot_be_used_get_one_sentence(tmp_path, place, words, error, message):
    path = made(tmp_path / "t.tif", place, **words)
    with pytest.raises(error, match=message):
        gs.read_horizon(path, positive="up")


def test_damaged_files_get_one_sentence(tmp_path):
    path = made(tmp_path / "t.tif", (10, 0, 461000, 0, -20, 5932000))
    whole = path.read_bytes()
    for data in (whole[:150], whole[:9], b"II*\0" + bytes(100), whole[:8] + b"\xff" * 200):
        path.write_bytes(data)
        with pytest.raises(FormatError, match=r"t\.tif: "):
            gs.read_horizon(path, positive="up")


def test_without_rasterio_the_extra_is_named(tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "rasterio", None)
    (tmp_path / "t.tif").write_bytes(b"II*\0" + bytes(100))
    with pytest.raises(DependencyError, match=r"GeoTIFF needs rasterio.*geosurf\[gis\]"):
        gs.read_horizon(tmp_path / "t.tif", positive="up")
    assert gs.info(tmp_path / "t.tif").format == "geotiff"
