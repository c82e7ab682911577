"""GeoTIFF through rasterio: one band of values, placed by an affine map, with its system.

Nodes of the horizon are the centres of cells. Rotated maps are read; sheared ones and those that
ground control points place are refused. The reference system, the null value, masks, scale and
offset of the band count; overviews do not.
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions.crs import label
from geosurf.conventions.packages import need
from geosurf.errors import FormatError, InputError
from geosurf.read._common import noted
from geosurf.read._guard import damaged, read_bytes, reading_with, refuse_large
from geosurf.read.grids.nodes import Decoded, GridHeader, grid_reader

if TYPE_CHECKING:  # pragma: no cover - types only
    pass

STRAIGHT = 1e-9  # cosine of the angle between rows and columns that is a right one, to rounding
UNITS = ("m", "metre", "meter", "metres", "meters", "ft", "foot", "feet", "km")


@grid_reader
def read_geotiff(path: Path) -> Decoded:
    """Read a GeoTIFF of one band."""
    data = read_bytes(path)
    need(f"{path}: GeoTIFF needs", "rasterio")
    import rasterio

    with (
        warnings.catch_warnings(),
        reading_with(path, "rasterio"),
        rasterio.MemoryFile(data) as memory,
        memory.open(driver="GTiff") as source,
    ):
        warnings.simplefilter("ignore")  # a map without a place is refused here
        header = _header(path, source)
        cells = header.ncol * header.nrow
        refuse_large(path, 24 * cells, len(data), f"a map of {header.ncol} x {header.nrow} cells")
        values = _values(path, source)
        unit = (source.units[0] or "").strip().lower()
        crs = _crs(path, source)
    noted("kind", "nodes are the centres of cells")
    if crs is not None:
        noted("crs", label(crs))
    order = "rows from the first corner of the file"
    return Decoded(header, values, order, crs=crs, unit=unit if unit in UNITS else None)


def _header(path: Path, source: Any) -> GridHeader:
    """Where the centres of cells are."""
    if source.count != 1:
        raise FormatError(
            f"{path}: the GeoTIFF has {source.count} bands, expected 1 of elevations or depths. "
            "Export that band alone."
        )
    place = source.transform
    if place.is_identity:
        raise FormatError(
            f"{path}: the TIFF states no place (or places cells by control points). Export it with "
            "an affine map, as in gdalwarp."
        )
    # a column goes along (a, d), a row along (b, e); a right angle is needed
    xinc, yinc = math.hypot(place.a, place.d), math.hypot(place.b, place.e)
    bent = abs(place.a * place.b + place.d * place.e) > STRAIGHT * xinc * yinc
    if bent or not xinc or not yinc:
        raise FormatError(
            f"{path}: rows and columns of the GeoTIFF are not at right angles. Warp it to a "
            "regular grid, as in gdalwarp."
        )
    x, y = place @ (0.5, 0.5) if hasattr(place, "__matmul__") else place * (0.5, 0.5)
    if place.b == 0.0 and place.d == 0.0:
        header = GridHeader(source.width, source.height, x, y, place.a, place.e)
    else:
        left = place.a * place.e - place.b * place.d > 0.0  # rows to the left of columns
        turn = math.degrees(math.atan2(place.d, place.a)) % 360.0
        header = GridHeader(source.width, source.height, x, y, xinc, yinc if left else -yinc, turn)
    return header.checked(path, "header")


def _values(path: Path, source: Any) -> np.ndarray:
    """Values (row, column) in the order of the file, NaN where undefined."""
    band = source.read(1, masked=True)
    if band.dtype.kind not in "iuf":
        raise FormatError(f"{path}: values are {band.dtype}, expected real numbers.")
    values: np.ndarray = np.ma.filled(band.astype(np.float64), np.nan)
    noted("null", "none stated" if source.nodata is None else f"{source.nodata:g}")
    if np.isinf(values).any():
        raise damaged(f"{path}: {np.isinf(values).sum()} values are infinite")
    scale, offset = source.scales[0], source.offsets[0]
    if (scale, offset) != (1.0, 0.0):
        noted("transform", f"{scale:g} x value + {offset:g}")
        values = values * scale + offset
    return values


def _crs(path: Path, source: Any) -> str | None:
    """The reference system, as a code where it has one."""
    if source.crs is None or not source.crs.to_wkt():
        return None
    code = source.crs.to_epsg()
    text = f"EPSG:{code}" if code else str(source.crs.to_wkt())
    if source.crs.is_geographic:
        raise InputError(
            f"{path}: coordinates are in degrees ({label(text)}); geosurf takes metres. Convert "
            "the map, as in gdalwarp -t_srs EPSG:32631 in.tif out.tif."
        )
    return text
