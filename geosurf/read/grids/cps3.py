"""CPS-3 grids (text): columns of a map, west to east, each from north to south.

Lines of the header begin with ``FSASCI`` (null value), ``FSLIMI`` (west, east, south, north,
lowest, highest), ``FSNROW`` (rows, columns) and ``FSXINC`` (steps); values follow a line ``->``.
The format knows no rotation.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._common import integer, is_number, number
from geosurf.read._noted import noted
from geosurf.read._table import words_per_line
from geosurf.read.grids.nodes import GridHeader, GridNodes
from geosurf.read.grids.text import check_step, finished, from_corners, scale_of, text_values

NULL = 1e30  # where the header states none
HUGE = 1e20  # null values of a header are larger, other numbers of its line smaller

Lines = dict[str, tuple[int, list[str]]]


def read_cps3(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read a CPS-3 grid in text.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Name of the horizon.
    positive : {"up", "down"}
        The format does not state it, so this argument is required.
    length_unit : str, optional
        Unit of the values (z only; x and y are metres). Default ``"m"``.

    Returns
    -------
    GridNodes
        Elevation [m], positive up, NaN where undefined, shape (nrow, ncol).

    Raises
    ------
    FormatError
        If the header is incomplete, values are missing, too many or not numbers, or line ends show
        that values run along rows.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.cps3"
    >>> head = "FSASCI 0 1 COMPUTED 0 1.0E30 0\nFSLIMI 0 10 0 20 1 6\nFSNROW 2 2\nFSXINC 10 20\n"
    >>> _ = file.write_text(head + "-> MODEL\n1 2\n3 1.0E30\n")
    >>> read_cps3(file, name="Top", positive="up").values
    array([[ 2., nan],
           [ 1.,  3.]])
    """
    scale = scale_of(path, name, positive, length_unit)
    blocks = TextBlocks(path)
    lines, start = _header(path, blocks.head)

    # rows first, then columns; limits are those of the outer nodes
    i, words = _line(path, lines, "FSNROW", 2)
    nrow, ncol = (integer(word, path, i, "number of rows or columns") for word in words[:2])
    k, words = _line(path, lines, "FSLIMI", 4)
    west, east, south, north = (number(word, path, k, "limit of x or y") for word in words[:4])
    header = from_corners(path, f"lines {i} and {k}", (ncol, nrow), (west, east), (south, north))
    if "FSXINC" in lines:
        i, words = _line(path, lines, "FSXINC", 2)
        steps = [number(word, path, i, "step") for word in words[:2]]
        check_step(path, header, steps[0], steps[1], f"line {i}")

    # the null value is the one huge number of the first line
    _, words = lines.get("FSASCI", (0, []))
    nulls = [float(word) for word in words if is_number(word) and abs(float(word)) >= HUGE]
    null = nulls[0] if nulls else NULL
    noted("null", f"{null:g}")

    blocks.skip(start)
    ends = _LineEnds(header)
    values = text_values(blocks, header, ends.look)
    ends.refuse_rows(path)
    values[values == null] = np.nan
    grid = values.reshape(header.ncol, header.nrow).T[::-1]
    return finished(path, name, header, grid, scale, "columns from the west, each from the north")


class _LineEnds:
    """
    Where lines end, counted in values: after columns of the map, or after its rows.

    Some programs write rows, and do not agree whether the first is in the north or in the south.

    Parameters
    ----------
    header : GridHeader
    """

    def __init__(self, header: GridHeader) -> None:
        self.header = header
        self._n_value = 0
        self._n_end = {header.nrow: 0, header.ncol: 0}  # lines that end after a multiple of these

    def look(self, piece: str) -> None:
        """Count the values of each line of a piece."""
        if self.header.nrow == self.header.ncol:
            return
        count = words_per_line(piece)
        ends = self._n_value + np.cumsum(count[count > 0])
        for size in self._n_end:
            self._n_end[size] += int(np.count_nonzero(ends % size == 0))
        self._n_value += int(count.sum())

    def refuse_rows(self, path: Path) -> None:
        """Refuse values that begin a new line with each row of the map, not with each column."""
        nrow, ncol = self.header.nrow, self.header.ncol
        if nrow == ncol:
            return
        if self._n_end[ncol] == nrow and self._n_end[nrow] < ncol:
            raise FormatError(
                f"{path}: a new line begins after every {ncol} values, so they run along rows. "
                "CPS-3 has columns from the north, and programs that write rows do not agree "
                "where they begin. Export the grid as IRAP or ZMAP+."
            )


def _header(path: Path, text: str) -> tuple[Lines, int]:
    """Lines of the header by their first word, and where values begin."""
    lines: Lines = {}
    at = 0
    for i, line in enumerate(text.split("\n", 100)[:100], start=1):
        words = line.replace(",", " ").split()
        key = words[0].upper() if words else "!"

        # `-> name` is the last line of the header; some programs leave it out
        if key.startswith("->"):
            return lines, at + len(line) + 1
        if is_number(key):
            return lines, at
        if key.startswith("FS"):
            lines[key] = (i, words[1:])
        at += len(line) + 1
    raise FormatError(f"{path}: the header has no values after it. Export the file again.")


def _line(path: Path, lines: Lines, key: str, count: int) -> tuple[int, list[str]]:
    """Line and words of one key, at least `count` words."""
    i, words = lines.get(key, (0, []))
    if len(words) < count:
        where = f", line {i}" if i else ""
        raise FormatError(
            f"{path}{where}: {key} has {len(words)} values, expected {count}. The header of the "
            "CPS-3 grid is incomplete; export the file again."
        )
    return i, words
