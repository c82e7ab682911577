"""Scattered points: ``.xyz``, ``.csv``, GOCAD VSet and GeoJSON of a Dataset over one dimension."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import elevation_sign, metres_per_unit
from geosurf.conventions.crs import crs_of
from geosurf.errors import OutputError
from geosurf.write.decimals import rows_text
from geosurf.write.gocad import _head as head_of
from geosurf.write.polylines import END_OF_LINE, OLD_STANDARD, collection
from geosurf.write.table import csv_of_rows
from geosurf.write.written import Loss

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

AXES = ("easting", "northing", "elevation")
DIRECTION = Loss(
    "direction",
    "z is elevation in metres, which the format does not store: read the file with positive='up'.",
)


def xyz_of_points(points: xr.Dataset, name: str | None) -> tuple[bytes | bytearray, list[Loss]]:
    """Return ``x y z`` of each point."""
    x, y, z = columns_of(points).T
    if ((x == END_OF_LINE) & (y == END_OF_LINE) & (z == END_OF_LINE)).any():
        raise OutputError(
            "a point is (999, 999, 999), which ends the points in files of x y z. Write .csv."
        )
    return rows_text([x, b" ", y, b" ", z, b"\n"]), [*_others_lost(points), DIRECTION]


def csv_of_points(points: xr.Dataset, name: str | None) -> tuple[bytes | bytearray, list[Loss]]:
    """Return a table with the columns X, Y, Z and those of all other variables."""
    place = columns_of(points)
    others = _others(points)
    head = Loss("direction", "Z is elevation in metres: read the file with positive='up'.")
    if not others:
        x, y, z = place.T
        return rows_text([x, b",", y, b",", z, b"\n"], head=b"X,Y,Z\n"), [head]
    rows = zip(*place.T.tolist(), *(points[key].values.tolist() for key in others), strict=True)
    data, lost = csv_of_rows(["X", "Y", "Z", *others], (list(row) for row in rows))
    return data, [head, *lost]


def vset_of_points(points: xr.Dataset, name: str | None) -> tuple[bytes | bytearray, list[Loss]]:
    """Return a GOCAD VSet."""
    x, y, z = columns_of(points).T
    head = "\n".join(head_of("VSet", name or "points", crs_of(points))) + "\n"
    ids = np.arange(1, len(x) + 1)
    body = rows_text([b"VRTX ", ids, b" ", x, b" ", y, b" ", z, b"\n"])
    return head.encode("utf-8") + body + b"END\n", _others_lost(points)


def geojson_of_points(
    points: xr.Dataset, name: str | None, crs: str | None
) -> tuple[bytes | bytearray, list[Loss]]:
    """Return a feature for each point, with all other variables as properties."""
    others = {key: points[key].values.tolist() for key in _others(points)}
    features = [
        {
            "type": "Feature",
            "properties": {key: _finite(values[row]) for key, values in others.items()},
            "geometry": {"type": "Point", "coordinates": place},
        }
        for row, place in enumerate(columns_of(points).tolist())
    ]
    return collection(features, name, crs), [OLD_STANDARD]


def columns_of(points: xr.Dataset) -> np.ndarray:
    """Easting, northing and elevation [m], positive up, of each point, shape (n, 3)."""
    z = points["elevation"]
    scale = elevation_sign(z.attrs.get("positive", "up"), "points") * metres_per_unit(
        z.attrs.get("units", "m"), "points"
    )
    columns = np.stack([np.asarray(points[axis].values, dtype=np.float64) for axis in AXES], axis=1)
    columns[:, 2] *= scale
    if not len(columns):
        raise OutputError("there are no points to write. Write .nc instead.")
    bad = np.flatnonzero(~np.isfinite(columns).all(axis=1))
    if len(bad):
        raise OutputError(
            f"point {bad[0]} (counted from 0) has coordinates {columns[bad[0]].tolist()}, not all "
            "of them finite. Drop such points, or write .nc."
        )
    return columns + 0.0


def _others(points: xr.Dataset) -> list[str]:
    """Names of the variables that are not coordinates in space."""
    (dim,) = points["elevation"].dims
    return [
        str(key)
        for key, variable in points.variables.items()
        if key not in AXES and variable.dims == (dim,)
    ]


def _others_lost(points: xr.Dataset) -> list[Loss]:
    others = _others(points)
    if not others:
        return []
    return [Loss("data", f"The columns {others} were left out; .csv and .nc store them.")]


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not np.isfinite(value) else value


__all__ = ["columns_of", "csv_of_points", "geojson_of_points", "vset_of_points", "xyz_of_points"]
