"""GeoTIFF through rasterio: one band of values, placed by an affine map, with its system.

Nodes of the horizon are the centres of cells. Rotated maps are read; sheared ones and those that
ground control points place are refused. The reference system, the null value, masks, scale and
offset of the band count; overviews do not.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions.crs import label
from geosurf.errors import DependencyError, FormatError, InputError
from geosurf.read._common import Request, noted
from geosurf.read._guard import read_bytes, refuse_large
from geosurf.read.grids.nodes import GridHeader, finished

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

STRAIGHT = 1e-9  # cosine of the angle between rows and columns that is a right one, to rounding
UNITS = ("m", "metre", "meter", "metres", "meters", "ft", "foot", "feet", "km")


def read_geotiff(path: Path, request: Request) -> xr.DataArray:
    """
    Read a GeoTIFF of one band.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Name of the horizon.
        `positive`: The format does not state it, so this argument is required.
        `length_unit`: Unit of the values, if the band does not state it. Default ``"m"``.

    Returns
    -------
    xarray.DataArray
        Elevation [m] at the centres of cells, positive up, NaN where undefined.

    Raises
    ------
    DependencyError
        If rasterio is not installed (extra ``gis``).
    FormatError
        If the file is damaged, has several bands, no place, or is sheared.
    InputError
        If `positive` is missing, or coordinates are in degrees.
    """
    data = read_bytes(path)
    try:
        import rasterio
    except ImportError as error:
        raise DependencyError(
            f"{path}: GeoTIFF needs rasterio. Install the extra: pip install 'geosurf[gis]'."
        ) from error

    # a map without a place is refused below; rasterio warns of it, too
    import warnings

    try:
        with (
            warnings.catch_warnings(),
            rasterio.MemoryFile(data) as memory,
            memory.open(driver="GTiff") as source,
        ):
            warnings.simplefilter("ignore")
            header = _header(path, source)
            refuse_large(
                path, 24 * header.ncol * header.nrow, len(data),
                f"a map of {header.ncol} x {header.nrow} cells",
            )  # fmt: skip
            values = _values(path, source)
            unit = (source.units[0] or "").strip().lower()
            crs = _crs(path, source)
    except rasterio.errors.RasterioError as error:
        raise FormatError(
            f"{path}: rasterio cannot read it ({' '.join(str(error).split())[:160]}). The GeoTIFF "
            "is damaged or truncated; export it again."
        ) from error
    what = f"{path.name}: horizon {request.named(path)!r}"
    stated = unit if unit in UNITS else None
    scale = request.scale(what, unit=stated)
    noted("kind", "nodes are the centres of cells")
    nodes = finished(path, request, header, values, scale, "rows from the first corner of the file")
    if crs is not None:
        nodes.attrs["crs"] = crs
        noted("crs", label(crs))
    return nodes


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
        raise FormatError(f"{path}: {np.isinf(values).sum()} values are infinite. Export it again.")
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
