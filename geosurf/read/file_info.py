"""What a file holds and how geosurf reads it: format, columns, signs, units, and first doubts."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from geosurf import read
from geosurf.errors import GeosurfError
from geosurf.model.expected import path_of
from geosurf.read._common import WIDE, WIDE_MARKS, collected, noted, otherwise
from geosurf.read._guard import is_zarr, opened, size_of_store
from geosurf.read.features import features
from geosurf.read.grids.node_lists import looks_like_ijxyz
from geosurf.read.las import holds_tops
from geosurf.read.model3d import read_model3d
from geosurf.read.registry import (
    END_MARK,
    GRID_FORMATS,
    LABEL,
    MESH_FORMATS,
    OF_ONE_FUNCTION,
    TITLES,
    detect,
    detect_foreign,
    has_lines,
    has_numbers,
    head_of,
)
from geosurf.read.resqml.surfaces import all_points, functions_of
from geosurf.read.tops import from_header, holds_picks
from geosurf.read.wells.columns import heads_of, holds_heads, holds_wells

WELL = re.compile(rb"\b(?:well|wellname|uwi|wellbore|borehole)\b", re.I)
HORIZON = re.compile(rb"^(?:string\s+)?[\"']?(?:horizon|surface|marker|pick|top)", re.I | re.M)
# values that programs write for "undefined"; as elevations they would be rare
NULLS = (-999.0, -999.25, -9999.0, -99999.0, 9999.0, 99999.0, 9999900.0)
_SHOWN = 1_000_000  # nodes of a large grid that are looked at
ASSUMED: dict[str, Any] = otherwise({"positive": "up", "length_unit": "m"})
STRANGE = "geosurf knows no format with this content or suffix; docs/formats.md lists all."
SCENARIO = "This looks like a scenario, no data: `geosurf validate` lists its mistakes."


READ_WITH = {
    **OF_ONE_FUNCTION,
    "model3d": "read_units",
    "pline": "read_polygons or read_fault",
    "vset": "read_points",
    "charisma": "read_fault",
    "cps3_lines": "read_polygons or read_fault",
}


@dataclass(frozen=True)
class FileInfo:
    """
    How geosurf reads one file.

    Attributes
    ----------
    path : str
    size : int
        Bytes.
    format : str
        Name of the format, as in ``format=``; ``"unknown"`` where geosurf reads it with nothing.
    read_with : str
        The function that reads the file.
    notes : dict of str to str
        What the reader found: columns, decimal sign, null value, order of values, rotation, sign
        and unit of z.
    count : int
        Nodes, vertices or points with a value.
    extent : dict of str to list of float
        Lowest and highest easting, northing and z [m]; z is elevation if the file states its
        direction, else as the file has it.
    doubts : list of str
        What the file does not state, and what looks wrong, a sentence each.
    """

    path: str
    size: int
    format: str
    read_with: str = ""
    notes: dict[str, str] = field(default_factory=dict)
    count: int = 0
    extent: dict[str, list[float]] = field(default_factory=dict)
    doubts: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        title = TITLES.get(self.format, self.format)
        lines = [f"{self.path}: {title}, {self.size} bytes"]
        rows = {"format": self.format, "read with": self.read_with} | self.notes
        if self.count:
            rows["points"] = str(self.count)
        rows |= {key: f"{low:.2f} to {high:.2f} m" for key, (low, high) in self.extent.items()}
        lines += [f"  {key:<15} {value}" for key, value in rows.items() if value]
        return "\n".join(lines + [f"  doubt: {doubt}" for doubt in self.doubts])


def info(path: str | PathLike[str]) -> FileInfo:
    r"""
    Report what a file holds and how geosurf reads it.

    Parameters
    ----------
    path : path-like
        A file of any format, under any suffix.

    Returns
    -------
    FileInfo
        `print` shows it as text.

    Raises
    ------
    InputError
        If it is not a regular file that can be opened.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.dat"
    >>> head = "-996 2 10 10\n500 510 0 10\n2 0 500 0\n0 0 0 0 0 0 0\n"
    >>> _ = file.write_text(head + "1600 1610\n1605 9999900.0\n")
    >>> found = info(file)
    >>> found.format, found.count, found.notes["rotation"]
    ('irap', 3, '0 degrees counter-clockwise from east')
    >>> found.doubts[0]
    'The file does not state depth or elevation: give positive="down" or positive="up".'
    """
    path = path_of(path, "info")
    size = size_of_store(path) if is_zarr(path) else None
    if size is None:
        with opened(path) as (_, size):
            pass
    key, function = kind_of_file(path)
    points = np.empty((0, 3))
    doubts: list[str] = []
    with collected(looking=True) as notes:
        try:
            points = points_of_file(path, key, function)
        except GeosurfError as error:
            # the reader's own sentence says what is wrong, or which argument it needs
            sentence = str(error).removeprefix(f"{path}: ").removeprefix(f"{path}, ")
            doubts.append(strange(path) if "it reads ." in sentence else sentence)

    known = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        notes.clear()  # what readers asked before they refused the file says nothing about it
    doubts += _open_questions(key, notes) + _strange_values(points, known)
    extent = {}
    if len(known):
        low, high = known.min(axis=0).tolist(), known.max(axis=0).tolist()
        names = ("easting", "northing", "z")
        extent = {name: [low[k], high[k]] for k, name in enumerate(names)}
    return FileInfo(str(path), size, key, function, dict(notes), len(known), extent, doubts)


def strange(path: str | PathLike[str]) -> str:
    """What to do with a file that no reader takes."""
    if not Path(path).stat().st_size:
        return "The file is empty (0 bytes)."
    if Path(path).is_file():
        with Path(path).open("rb") as file:
            if file.read(4).startswith(WIDE_MARKS):
                return WIDE[0].upper() + WIDE[1:]
    return SCENARIO if str(path).lower().endswith(".toml") else STRANGE


def kind_of_file(path: Path) -> tuple[str, str]:
    """Format of a file, and the function that reads it; tables by their header and end marks."""
    key, suffix = "zarr" if is_zarr(path) else detect(path), path.suffix.lower()
    if key is None:
        key = next((k for k, (*_, names) in MESH_FORMATS.items() if suffix in names), None)
    if key in GRID_FORMATS:
        return key, "read_horizon"
    if key in MESH_FORMATS:
        return key, "read_horizon or read_fault"
    if key == "resqml":
        return key, _resqml_function(path)
    if key == "las":
        return key, "read_tops" if holds_tops(path) else "read_points"
    if key == "attributes" and WELL.search(head_of(path)) and HORIZON.search(head_of(path)):
        return "tops", "read_tops"
    if key == "attributes":
        ends = END_MARK.search(head_of(path)) or LABEL.search(head_of(path))
        return key, "read_polygons or read_fault" if ends else "read_points"
    if key in ("geojson", "shapefile"):
        return key, "read_points" if _holds_points(path) else "read_polygons or read_fault"
    if key in READ_WITH:
        return key, READ_WITH[key]

    # tables of numbers have no signature: names of columns and end marks decide
    head = head_of(path)
    first = head.lstrip().split(b"\n", 1)[0]
    foreign = detect_foreign(path)
    if foreign is not None or not has_numbers(head):
        return foreign or "unknown", ""
    head = from_header(head)
    first = head.lstrip().split(b"\n", 1)[0]
    if holds_heads(head):
        return "well_heads", ""
    if holds_wells(head):
        return "wells", "read_wells"
    if WELL.search(first) and not holds_picks(first):
        return "tops", "read_tops"
    if suffix == ".pol" or (has_lines(head) and suffix != ".poi"):
        return "polygons", "read_polygons or read_fault"
    return ("ijxyz", "read_horizon") if looks_like_ijxyz(head) else ("xyz", "read_points")


def _resqml_function(path: Path) -> str:
    """What reads the objects of a package; damaged ones are left to their reader."""
    try:
        return " or ".join(functions_of(path))
    except GeosurfError:
        return "read_horizon"


def _holds_points(path: Path) -> bool:
    """Whether a file of features begins with a point; damaged ones are left to their reader."""
    try:
        read = features(path)
    except GeosurfError:
        return False
    return bool(read.items) and read.items[0].kind == "point"


def points_of_file(path: Path, key: str, function: str) -> np.ndarray:
    """Points (n, 3) of a file with z as elevation in metres, if it states nothing else."""
    data: Any
    if key == "netcdf":
        from geosurf.read.netcdf import holds_fault  # it loads xarray

        data = (read.read_fault if holds_fault(path) else read.read_horizon)(path, **ASSUMED)
    elif key == "tsurf":
        data = read.read_tsurf(path, **ASSUMED)
    elif key == "model3d":
        data = list(read_model3d(path, **ASSUMED).values())
    elif key == "resqml":
        data = all_points(path)
    elif key in GRID_FORMATS or key in MESH_FORMATS:
        form = key if key == "ijxyz" else None  # other suffixes keep their own words
        data = read.read_horizon(path, format=form, **ASSUMED)
    elif key == "well_heads":
        noted("used as", "heads= of read_wells")
        return np.array(list(heads_of(path, ".").values()))
    elif function:
        reader = getattr(read, function.split()[0])
        form = key if key in ("geojson", "shapefile") else None
        data = reader(path, format=form, **ASSUMED) if form else reader(path, **ASSUMED)
    else:
        # the sentence of the reader names kinds of files that geosurf does not read
        data = read.read_horizon(path, **ASSUMED)
    listed = data if isinstance(data, list) else [data]
    return np.concatenate([points_of(_some_of(one)) for one in listed])


def _some_of(data: Any) -> Any:
    """What a reader returns; of a grid that is opened, not read, some rows and columns."""
    if not hasattr(getattr(data, "data", None), "dask"):
        return data
    step = math.ceil(math.sqrt(data.size / _SHOWN))
    noted("read", f"every {step}th row and column of a large grid")
    return data[::step, ::step]


def points_of(data: Any) -> np.ndarray:
    """Return the points (n, 3) of what a reader returns, undefined ones too."""
    if isinstance(data, np.ndarray):
        return data
    if hasattr(data, "sticks"):
        return np.concatenate(data.sticks)
    if hasattr(data, "vertices"):
        return np.asarray(data.vertices, dtype=np.float64)
    z = data.elevation if hasattr(data, "data_vars") else data
    x, y = data.easting.values, data.northing.values
    if x.ndim == 1 and z.ndim == 2:
        x, y = np.meshgrid(x, y)
    return np.column_stack([np.ravel(v) for v in (x, y, z.values)]).astype(np.float64)


def _open_questions(key: str, notes: dict[str, str]) -> list[str]:
    """What the file does not state."""
    doubts = [f"There is {notes.pop('end')}."] if "end" in notes else []
    if notes.get("sign", "").startswith("open"):
        if key in MESH_FORMATS or key in ("model3d", "pline", "vset"):
            notes["sign"] = "open: elevation unless positive="
            choice = 'positive="down" for depth'
        else:
            choice = 'positive="down" or positive="up"'
        doubts.append(f"The file does not state depth or elevation: give {choice}.")
    return doubts


def _strange_values(points: np.ndarray, known: np.ndarray) -> list[str]:
    """What looks wrong: null values that were read as elevations, few values, no relief."""
    if len(points) == 0:
        return []
    if len(known) == 0:
        return ["All values are undefined."]
    doubts = []
    for null in NULLS:
        # a reader that takes depth turns the sign
        count = int(np.count_nonzero(known[:, 2] == null))
        if count:
            doubts.append(f"{count} values are {null:g}, which many programs write for undefined.")
    if len(known) * 2 < len(points):
        share = 100 * (1 - len(known) / len(points))
        doubts.append(f"{share:.0f} % of the nodes are undefined.")
    if np.abs(known[:, :2]).max() <= 360.0 and np.ptp(known[:, :2], axis=0).max() > 0:
        doubts.append("Easting and northing are below 360: they may be degrees, not metres.")
    return doubts
