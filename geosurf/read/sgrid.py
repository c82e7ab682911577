"""GOCAD SGrid of one layer: a grid of nodes with its points in a second file.

The header (.sg) has AXIS_N and the name of the file of points: ``POINTS_FILE``, big-endian float32
(float64 with ``double_precision_binary: on``), or ``ASCII_DATA_FILE``, x y z and properties on each
line. The first axis runs fastest. Header, axes, units and direction of z are those of TSurf.
Flags, which mark dead cells and split faces, have no public description and are not used.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geosurf.errors import FormatError, GeosurfWarning
from geosurf.read._common import integer, number, read_text
from geosurf.read._gocad_draft import bodies
from geosurf.read._gocad_header import Header
from geosurf.read._guard import read_bytes, refuse_large
from geosurf.read._noted import is_looking, noted
from geosurf.read._placed import fault_dataset
from geosurf.read.grids.nodes import GridNodes, nodes_from_places
from geosurf.warning import warn

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

NULL = 1e20  # coordinates from here on are undefined


@dataclass
class SGrid:
    """What the header of one grid states."""

    path: Path
    header: Header = field(default_factory=Header)
    shape: tuple[int, ...] = ()
    words: dict[str, str] = field(default_factory=dict)  # of the files
    wide: bool = False  # float64

    def take(self, i: int, words: list[str], inside: bool) -> None:
        """Read one line; `inside` of the braces of HEADER."""
        key = words[0].upper()
        if inside:
            text = " ".join(words)
            self.header.take_brace_line(text)
            name, _, value = text.lower().partition(":")
            self.wide |= name.strip() == "double_precision_binary" and value.strip() == "on"
        elif key == "AXIS_N":
            self.shape = tuple(integer(word, self.path, i, "AXIS_N") for word in words[1:4])
            if len(self.shape) != 3 or min(self.shape) < 1:
                raise FormatError(
                    f"{self.path}, line {i}: AXIS_N is {' '.join(words[1:])!r}, expected three "
                    "numbers of nodes. Export the SGrid again."
                )
        elif key in ("POINTS_FILE", "POINTS_OFFSET", "ASCII_DATA_FILE", "FLAGS_FILE"):
            self.words[key] = " ".join(words[1:])
        else:
            self.header.take_line(self.path, i, words)

    def companion(self, key: str) -> Path:
        """A file next to the header."""
        name = self.words[key].strip("\"'").strip()
        # only files of the same folder: a header from elsewhere may point anywhere
        if not name or Path(name).name != name:
            raise FormatError(
                f"{self.path}: {key} is {name!r}, expected a file of the same folder. Copy it "
                "there and correct the line."
            )
        return self.path.parent / name


def read_sgrid(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read a horizon from an SGrid of one layer.

    Parameters
    ----------
    path : pathlib.Path
        The header; the file of points lies next to it.
    name : str
        Name of the horizon.
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    GridNodes
        Elevation [m]; easting and northing for each node, or along the axes.

    Raises
    ------
    FormatError
        If there are several layers, or points are missing, too many or not numbers.
    InputError
        If `positive` or `length_unit` contradicts the file.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.sg"
    >>> _ = file.write_text("GOCAD SGrid 1\nAXIS_N 2 2 1\nASCII_DATA_FILE top.dat\nEND\n")
    >>> _ = file.with_suffix(".dat").write_text("0 0 5\n9 0 6\n0 9 7\n9 9 8\n")
    >>> read_sgrid(file, name="Top").values.tolist()
    [[5.0, 6.0], [7.0, 8.0]]
    """
    grid, nodes = _nodes(path, positive, length_unit)

    return nodes_from_places(nodes, name=name, source=path.name, crs=grid.header.crs)


def read_sgrid_fault(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> xr.Dataset:
    """
    Read a fault from an SGrid of one layer, as a parametric grid.

    Parameters
    ----------
    path, positive, length_unit
        As for `read_sgrid`.
    name : str, optional
        Name of the fault. Default: the name in the file, else the file name without suffix.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``(down_dip, along_strike)``.

    Raises
    ------
    FormatError, InputError
        As `read_sgrid`.
    """
    grid, nodes = _nodes(path, positive, length_unit)
    title = name or grid.header.name or path.stem
    return fault_dataset(nodes, title, path.name, grid.header.crs)


def _nodes(path: Path, positive: str | None, length_unit: str | None) -> tuple[SGrid, np.ndarray]:
    """Header, and the nodes (row, column, 3) in metres, elevation up; NaN where undefined."""
    grid = _header(path)
    # a layer may be any of the three axes
    shape = tuple(n for n in grid.shape if n > 1)
    if len(shape) != 2:
        counts = " x ".join(map(str, grid.shape))
        raise FormatError(
            f"{path}: the SGrid has {counts} nodes, expected one layer of them, as in AXIS_N 50 40 "
            "1. Export one layer, or the surface as TSurf."
        )
    expected = shape[0] * shape[1]
    points = _points(grid, expected)
    points[(np.abs(points) >= NULL).any(axis=1)] = np.nan
    if not np.isfinite(points).any():
        raise FormatError(f"{path}: all nodes of the SGrid are undefined. Export it again.")
    title = grid.header.name or path.stem
    world = grid.header.to_metres(points, positive, length_unit, f"{path.name}: {title!r}")
    _warn_of_flags(grid, expected)
    noted("names", title)
    noted("nodes", f"{shape[0]} columns x {shape[1]} rows")
    noted("order of values", "the first axis runs fastest")
    return grid, world.reshape(shape[1], shape[0], 3) + 0.0


def _header(path: Path) -> SGrid:
    """The header of the first SGrid of a file."""
    for _, kind, body in bodies(path, read_text(path, final_line_end=False)):
        if kind == "sgrid":
            grid, inside = SGrid(path), False
            for i, words in body:
                inside |= words[0].upper() == "HEADER" or words[0].upper().startswith("HEADER{")
                _take(grid, i, words, inside)
                inside = inside and not words[-1].endswith("}")
            if not grid.shape or not {"POINTS_FILE", "ASCII_DATA_FILE"} & set(grid.words):
                raise FormatError(
                    f"{path}: the SGrid has no line AXIS_N, or no file of points (POINTS_FILE, "
                    "ASCII_DATA_FILE). Export it again."
                )
            return grid
        for _ in body:  # another kind of object: pass over it
            pass
    raise FormatError(f"{path}: the file has no GOCAD SGrid. Export it again.")


def _take(grid: SGrid, i: int, words: list[str], inside: bool) -> None:
    """Take a line without the word HEADER and braces."""
    if inside:
        words = [
            word.strip("{}") for word in words if word.upper().strip("{}") not in ("HEADER", "")
        ]
    if words:
        grid.take(i, words, inside)


def _points(grid: SGrid, expected: int) -> np.ndarray:
    """Points (expected, 3) as they stand in their file."""
    if "POINTS_FILE" not in grid.words:
        return _text_points(grid.companion("ASCII_DATA_FILE"), expected)
    path = grid.companion("POINTS_FILE")
    data = read_bytes(path)
    offset = integer(grid.words.get("POINTS_OFFSET", "0"), grid.path, 0, "POINTS_OFFSET")
    width = 8 if grid.wide else 4
    found = (len(data) - offset) / (3 * width)
    if offset < 0 or found != expected:
        raise FormatError(
            f"{path}: found {found:g} points of {3 * width} bytes, expected {expected}. The file "
            "is truncated, or belongs to another SGrid; export it again."
        )
    refuse_large(path, 24 * expected, len(data), f"{expected} points")
    noted("kind", f"binary points, float{8 * width}")
    values = np.frombuffer(data, f">f{width}", offset=offset).astype(np.float64)
    if not np.isfinite(values).all():
        bad = int(np.argmin(np.isfinite(values))) // 3
        raise FormatError(f"{path}: point {bad} is not finite. Export the SGrid again.")
    return values.reshape(-1, 3)


def _text_points(path: Path, expected: int) -> np.ndarray:
    """Points of text: x y z first on each line; ``*`` and ``#`` begin comments."""
    rows: list[list[float]] = []
    for i, line in enumerate(read_text(path).split("\n"), start=1):
        words = line.split()
        if not words or words[0][0] in "*#":
            continue
        if len(words) < 3:
            raise FormatError(
                f"{path}, line {i}: found {len(words)} values, expected x y z. Export it again."
            )
        rows.append([number(word, path, i, "x, y or z") for word in words[:3]])
    if len(rows) != expected:
        raise FormatError(
            f"{path}: found {len(rows)} points, expected {expected}. The file is truncated, or "
            "belongs to another SGrid; export it again."
        )
    noted("kind", "points in text")
    return np.array(rows)


def _warn_of_flags(grid: SGrid, expected: int) -> None:
    """Name flags that differ between nodes: dead cells may be among them."""
    if "FLAGS_FILE" not in grid.words:
        return
    path = grid.companion("FLAGS_FILE")
    if not path.exists():
        noted("flags", f"none: {path.name} is missing")
        return
    flags = np.frombuffer(read_bytes(path)[: 4 * expected], dtype=">u4")
    count = int((flags != np.median(flags)).sum()) if len(flags) else 0
    noted("flags", f"not used; {count} of {expected} nodes differ from the others")
    if count and not is_looking():
        effect = (
            f"'{path.name}' marks {count} of {expected} nodes of '{grid.path.name}'. geosurf does "
            "not use these flags: dead cells among them become part of the surface."
        )
        remedy = "If cells are dead there, export the surface as TSurf."
        warn(GeosurfWarning("flags", grid.header.name or grid.path.stem, effect, remedy))


__all__ = ["read_sgrid", "read_sgrid_fault"]
