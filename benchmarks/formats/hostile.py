"""Objects that formats cannot hold, or hold only just: each comes back or is refused.

What is neither is wrong: a file that cannot be read, or one that holds something else than what
its losses state.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import geosurf as gs
from benchmarks.formats.round_trips import read_back, reader
from benchmarks.formats.subjects import CRS, difference, places
from geosurf.conventions.axes import COORDINATES
from geosurf.errors import GeosurfError
from geosurf.write import WRITERS
from geosurf.write.written import SMALLEST

ROUNDING = 1e-9  # of a coordinate: what float64 loses where steps follow from corners


def regular(values: Any, x: float = 0.0, y: float = 0.0, dx: float = 10.0, dy: float = 20.0) -> Any:
    """An unrotated grid."""
    values = np.array(values, dtype=float)
    coords = {
        "northing": y + dy * np.arange(values.shape[0]),
        "easting": x + dx * np.arange(values.shape[1]),
    }
    attrs = {"units": "m", "positive": "up"}
    return xr.DataArray(values, dims=("northing", "easting"), coords=coords, attrs=attrs)


def turned(top: Any, degrees: float) -> Any:
    """The same nodes, rotated about the first one, over rows and columns."""
    x, y = np.meshgrid(top.easting.values, top.northing.values)
    turn = np.radians(degrees)
    dx, dy = x - x[0, 0], y - y[0, 0]
    coords = {
        "easting": (("row", "column"), x[0, 0] + dx * np.cos(turn) - dy * np.sin(turn)),
        "northing": (("row", "column"), y[0, 0] + dx * np.sin(turn) + dy * np.cos(turn)),
    }
    return xr.DataArray(top.values, dims=("row", "column"), coords=coords, attrs=top.attrs)


def hostile_grids() -> Iterator[tuple[str, Any]]:
    """Maps with rims, marks, odd steps, odd axes."""
    plain = np.arange(12.0).reshape(3, 4) - 1700.3
    yield "one node", regular([[1.5]])
    yield "one row", regular([[1.0, 2.0, np.nan]])
    yield "one column", regular([[1.0], [2.0]])
    yield "no values", regular(np.full((3, 4), np.nan))
    yield "one value", regular(np.where(plain == plain[1, 1], plain, np.nan))
    yield "rim without values", regular(np.pad(plain, 1, constant_values=np.nan))
    for mark in (-99999.0, -9999.0, 9999900.0, 1e30, -3.4e38, 999.0, 1.70141e38):
        yield f"value {mark:g}", regular(np.where(plain == plain[0, 1], mark, plain))
    yield "infinite", regular(np.where(plain == plain[0, 1], np.inf, plain))
    yield "minus zero", regular(-0.0 * plain)
    yield "tiny values", regular(plain * 1e-300)
    yield "values of 1e12", regular(plain * 1e9)
    yield "steps of a millimetre", regular(plain, dx=0.001, dy=0.001)
    yield "coordinates of 1e8", regular(plain, 1e8 + 0.1, -1e8 - 0.3)
    yield "thirds", regular(plain / 3, 1 / 3, 2 / 3, 1 / 3, 2 / 3)
    for degrees in (30.0, 90.0, 180.0, -90.0, 0.001, 359.9):
        yield f"rotated by {degrees:g}", turned(regular(plain, 5e5, 6e6), degrees)
    yield "left-handed", turned(regular(plain), 0.0)[::-1]
    yield "columns first", regular(plain).transpose()
    yield "falling axes", regular(plain)[::-1, ::-1]
    yield "uneven steps", regular(plain).assign_coords(easting=[0.0, 1.0, 3.0, 4.0])
    yield "equal columns", regular(plain).assign_coords(easting=[0.0, 0.0, 0.0, 0.0])
    yield "axis with NaN", regular(plain).assign_coords(easting=[0.0, 1.0, np.nan, 3.0])
    yield "float32", regular(plain).astype(np.float32)
    yield "depth in feet", regular(plain).assign_attrs(positive="down", units="ft")
    yield "odd name", regular(plain).assign_attrs(long_name='@a, "b"\n{c} Ø')


def hostile_surfaces() -> Iterator[tuple[str, Any]]:
    """Triangles with odd corners, names and data."""
    corners = np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 9], [9, 9, -1 / 3]])
    both = np.array([[0, 1, 2], [1, 3, 2]])
    make = gs.TriSurface
    yield "one triangle", make("F", "fault", corners[:3], both[:1])
    yield "unused vertex", make("F", "fault", corners, both[:1])
    yield "vertices of 1e8", make("F", "fault", corners + np.array([1e8, -1e8, 1e5]), both)
    yield "edges of a micrometre", make("F", "fault", corners * 1e-7 + 5e5, both)
    yield (
        "separate triangles",
        make("F", "fault", corners[both.ravel()] + 0.0, np.arange(6).reshape(2, 3)),
    )
    for name in ("a b", '"a" {b}', "Ø層", "two\nlines", "x" * 300, "-", "1e5"):
        yield f"name {name[:12]!r}", make(name, "fault", corners, both)
    for key, data in {
        "NaN data": [1, np.nan, 3, 4], "no-data value": [-99999, 1, 2, 3], "words": [*"abcd"],
        "infinite data": [1, np.inf, 2, 3], "truth values": [True, False, True, True],
    }.items():  # fmt: skip
        yield key, make("F", "fault", corners, both, vertex_data={"a b": np.array(data)})


def hostile_lines() -> Iterator[tuple[str, Any]]:
    """Lines that end, close, repeat and stop short."""
    line = np.array([[0.0, 0, -1], [1e6, 5e6, -2], [1 / 3, 2 / 3, -1e-20]])
    yield "one point", [line[:1]]
    yield "closed", [np.concatenate([line, line[:1]])]
    yield "there and back", [line[[0, 1, 0]]]
    yield "end mark", [np.full((2, 3), 999.0)]
    yield "NaN", [line, np.full((2, 3), np.nan)]
    yield "twice the same", [line, line]
    yield "three points the same", [line[[0, 0, 0]]]
    yield "100 lines", [line + k for k in range(100)]


def hostile_points() -> Iterator[tuple[str, Any]]:
    """Points that end files, are nowhere, or are named oddly."""

    def cloud(place: Any, **more: Any) -> Any:
        data = {
            axis: ("point", np.array(place, dtype=float)[:, k])
            for k, axis in enumerate(COORDINATES)
        }
        return xr.Dataset(data | {key: ("point", value) for key, value in more.items()})

    yield "one point", cloud([[1, 2, 3]])
    yield "no point", cloud(np.empty((0, 3)))
    yield "end mark", cloud([[1, 2, 3], [999, 999, 999], [4, 5, 6]])
    yield "NaN", cloud([[1, 2, np.nan]])
    yield "infinite", cloud([[1, 2, 3], [np.inf, 2, 3]])
    yield "minus zero, tiny, huge", cloud([[-0.0, 5e-324, 1e300], [1 / 3, 1e22, -1e-7]])
    yield "twice the same", cloud([[1, 2, 3], [1, 2, 3]])
    yield "words", cloud([[1, 2, 3]] * 3, well=["a,b", '"q"', "=1+1"])


HOSTILE = {
    "horizon (DataArray)": hostile_grids,
    "TriSurface": hostile_surfaces,
    "list of lines": hostile_lines,
    "Dataset of points": hostile_points,
}


ANSWERS = ("back", "refused", "written")


def judge(kind: str, suffix: str, obj: Any, path: Path) -> str:
    """``"back"``, ``"refused"``, ``"written"`` if geosurf cannot read it, or what is wrong."""
    try:
        written = gs.write(obj, path, crs=CRS)
    except GeosurfError as error:
        words = str(error)
        return "refused" if len(words) > 30 and not path.exists() else f"refused as {words!r}"
    function = reader(kind, suffix)
    if not function:
        return "written"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # coordinates may be degrees
            found = read_back(function, path, kind)
    except GeosurfError as error:
        return f"cannot be read: {error}"
    truth = _truth(kind, obj, suffix)
    slack = (
        SMALLEST
        + written.largest_difference
        + ROUNDING * max(1.0, float(np.abs(truth).max(initial=0)))
    )
    moved = difference(truth, found)
    return (
        "back" if moved <= slack else f"moved by {moved:g}, stated {written.largest_difference:g}"
    )


def _truth(kind: str, obj: Any, suffix: str) -> np.ndarray:
    """What is read back: NetCDF and RESQML state direction and unit, other maps copy values."""
    truth = places(kind, obj)
    assert truth is not None
    if (
        suffix in (".nc", ".epc")
        and isinstance(obj, xr.DataArray)
        and obj.attrs["positive"] == "down"
    ):
        truth[:, 2] *= -0.3048
    # STL holds triangles only; its loss states that other vertices are left out
    return truth[np.unique(obj.triangles)] if suffix == ".stl" else truth


def hostile_rows(folder: Path) -> list[tuple[str, str, int, int, list[str]]]:
    """Kind, suffix, how many came back and were refused, and what is wrong."""
    rows = []
    for kind, make in HOSTILE.items():
        for suffix in WRITERS[kind]:
            if suffix == ".parquet":
                continue
            answers = {
                name: judge(kind, suffix, obj, folder / f"h{len(rows)}_{k}{suffix}")
                for k, (name, obj) in enumerate(make())
            }
            count = [*answers.values()].count
            wrong = [f"{name}: {one}" for name, one in answers.items() if one not in ANSWERS]
            rows.append((kind, suffix, count("back"), count("refused"), wrong))
    return rows


__all__ = ["HOSTILE", "hostile_rows", "judge"]
