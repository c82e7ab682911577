"""Polylines in text.

``.pol`` has ``x y z`` per line, each polyline ended by ``999 999 999``; ``.csv`` a row for each
point, with the number of its line and all words and numbers of the line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import OutputError
from geosurf.model import Curves, FaultSticks
from geosurf.write.table import csv_of_rows

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

END_OF_LINE = "999.0 999.0 999.0"
DIRECTION = "z is elevation in metres, which .pol does not store: read the file with positive='up'."


def pol_of_curves(curves: Curves, name: str | None) -> tuple[bytes, list[str]]:
    """Return the curves as polylines; which surfaces meet there is lost."""
    if curves.n_curve == 0:
        raise OutputError(
            "there are no curves to write, and a .pol file needs at least one. Write .vtp instead."
        )
    lost = "The format does not store the names of the surfaces; .vtp and .pl do."
    return _text([curves.points[curve] for curve in curves.curves]), [DIRECTION, lost]


def pol_of_sticks(fault: FaultSticks, name: str | None) -> tuple[bytes, list[str]]:
    """Return the sticks of a fault."""
    return _text(list(fault.sticks)), [DIRECTION]


def pol_of_lines(lines: xarray.Dataset, name: str | None) -> tuple[bytes, list[str]]:
    """Return fault polygons or other lines of a model; closed ones repeat their first point."""
    parts = lines_in_space(lines)
    lost = "The format does not store the names of the faults; .csv and .nc do."
    return _text([part for _, part in parts]), [DIRECTION, lost]


def csv_of_lines(lines: xarray.Dataset, name: str | None) -> tuple[bytes, list[str]]:
    """Return the same as a table: one row for each point, closed lines with their first again."""
    # one column for each word or number that belongs to a whole line
    words = [str(key) for key in lines.data_vars if lines[key].dims == ("line",) and key != "count"]
    header = ["X", "Y", "Z", "POLY_ID", *(word.upper() for word in words)]
    rows: list[list[Any]] = []
    for row, part in lines_in_space(lines):
        labels = [lines[word].values[row].item() for word in words]
        rows += [[*point, row + 1, *labels] for point in part.tolist()]
    data, notes = csv_of_rows(header, rows)
    return data, ["Z is elevation in metres, positive up.", *notes]


def lines_in_space(lines: xarray.Dataset) -> list[tuple[int, np.ndarray]]:
    """Number and points (n, 3) of each line."""
    axes = ("easting", "northing", "elevation")
    if not {*axes, "count"} <= set(lines.variables) or not lines.sizes.get("line"):
        raise OutputError(
            "this Dataset has no lines in space such as those of Scene.fault_polygons. Write "
            ".nc instead."
        )

    # The points of all lines follow one another; `count` has how many each line has.
    points = np.stack([lines[axis].values for axis in axes], axis=1)
    ends = np.cumsum(lines["count"].values)
    parts = np.split(points, ends[:-1])

    # rings are stored without their first point again; text has no other way to close them
    closed = bool(lines.attrs.get("closed", False))
    return list(enumerate(np.concatenate([p, p[:1]]) if closed else p for p in parts))


def _text(polylines: list[np.ndarray]) -> bytes:
    lines = []
    for polyline in polylines:
        lines += [" ".join(map(repr, row)) for row in polyline.tolist()]
        lines.append(END_OF_LINE)
    return ("\n".join(lines) + "\n").encode("ascii")
