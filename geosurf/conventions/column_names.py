"""Usual names of columns of tables of points and lines, in lower case."""

from __future__ import annotations

# easting, northing and z
USUAL = {
    "x": ("x", "x_utme", "easting", "east"),
    "y": ("y", "y_utmn", "northing", "north"),
    "z": ("z", "z_tvdss", "tvdss", "elevation", "depth"),
}
# number of the line that a point belongs to
LABELS = ("poly_id", "stick_id", "stick", "segment_id", "segment")
