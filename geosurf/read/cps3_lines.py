"""CPS-3 lines, as Petrel exports polygons and fault sticks.

Lines of the header begin with ``FF``. ``-> name`` begins a line; its points ``x y z`` follow.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.model import FaultSticks
from geosurf.read._common import number, read_text
from geosurf.read._placed import refuse_columns
from geosurf.read.polylines import Part, polylines_from, sticks_from

HEADER, BEGIN = "FF", "->"


def read_cps3_polygons(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> list[np.ndarray]:
    r"""
    Read the lines of a CPS-3 file.

    Parameters
    ----------
    path : pathlib.Path
    name : str, optional
        Only the lines of this name.
    positive, length_unit
        As for `read_polylines`.
    columns, decimal
        Not for this format, whose columns are fixed.

    Returns
    -------
    list of ndarray of float64, each (n, 3)

    Raises
    ------
    FormatError, InputError
        If a line of the file is neither a header, a begin nor three numbers; or as
        `read_polylines`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "outline.cps3"
    >>> _ = file.write_text("FFASCI 0 0 COMPUTED 0 1E30\nFFATTR 0 0\n-> 1\n0 0 0\n9 0 0\n9 9 0\n")
    >>> [len(line) for line in read_cps3_polygons(file)]
    [3]
    """
    refuse_columns(path, "a file of CPS-3 lines", columns, decimal)
    return polylines_from(path, _lines(path), positive, length_unit, name)


def read_cps3_sticks(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> FaultSticks:
    """
    Read the lines of a CPS-3 file as the sticks of one fault.

    Parameters
    ----------
    path : pathlib.Path
    name : str, optional
        Name of the fault; names of lines are those of sticks here. Default: that of the file.
    positive, length_unit
        As for `read_sticks`.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError
        As `read_cps3_polygons` and `read_sticks`.
    """
    parts = [Part(part.points, part.line) for part in _lines(path)]
    return sticks_from(path, parts, name, positive, length_unit)


def _lines(path: Path) -> list[Part]:
    """Lines as they stand in the file."""
    found: list[tuple[str, int, list[list[float]]]] = []
    for i, line in enumerate(read_text(path).split("\n"), start=1):
        words = line.split()
        if not words or words[0].startswith("!"):
            continue
        if line.lstrip().startswith(BEGIN):
            found.append((line.strip()[len(BEGIN) :].strip(), i, []))
        elif words[0].upper().startswith(HEADER) and not found:
            continue
        elif len(words) != 3 or not found:
            raise FormatError(
                f"{path}, line {i}: found {line.strip()[:60]!r}, expected '-> name' or x y z. "
                "Correct that line, or export the CPS-3 lines again."
            )
        else:
            found[-1][2].append([number(word, path, i, "x, y or z") for word in words])
    # a begin without points ends some files
    parts = [Part(np.array(points), line, name) for name, line, points in found if points]
    if not parts:
        raise FormatError(f"{path}: the file has no lines with points. Export it again.")
    return parts
