"""Charisma fault sticks, as Petrel and others export them.

Each line is ``INLINE- 1201 3405 461000.1 5932000.5 1600.0 F1 1``: the kind of seismic line, inline,
crossline, x, y, z, the name of the fault, and the number of the stick. Names may contain blanks.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._columns import Table
from geosurf.read._common import number, read_text
from geosurf.read._noted import noted

# kind, inline, crossline, x, y, z, the name, the stick
ROW = re.compile(
    r"[A-Za-z]+[ \t]*[-:]?[ \t]*-?\d\S*[ \t]+-?\d\S*[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)"
    r"(?:[ \t]+(\S.*?))?[ \t]+(\d+)[ \t]*"
)


def read_charisma(path: Path) -> Table:
    r"""
    Return the points of all sticks, with the numbers of sticks and names of faults.

    Parameters
    ----------
    path : pathlib.Path

    Returns
    -------
    Table

    Raises
    ------
    FormatError
        If a line is not that of a stick.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "faults.dat"
    >>> _ = file.write_text("INLINE- 1201 3405 461000.1 5932000.5 1600.0 Main fault 7\n")
    >>> found = read_charisma(file)
    >>> found.points.tolist(), found.names
    ([[461000.1, 5932000.5, 1600.0]], ['Main fault'])
    """
    points: list[list[float]] = []
    lines: list[int] = []
    labels: list[str] = []
    names: list[str] = []
    for i, line in enumerate(read_text(path).split("\n"), start=1):
        row = line.strip()
        if not row or row.startswith(("#", "!")):
            continue
        found = ROW.fullmatch(row)
        if found is None:
            raise FormatError(
                f"{path}, line {i}: found {row[:60]!r}, expected INLINE-, inline, crossline, x, y, "
                "z, the name of the fault and the number of its stick. Correct that line or export "
                "the Charisma file again."
            )
        points.append([number(word, path, i, "x, y or z") for word in found.groups()[:3]])
        names.append(" ".join((found[4] or "").strip("\"'").split()))
        labels.append(found[5])
        lines.append(i)
    if not points:
        raise FormatError(f"{path}: the file has comments only. Export it again.")
    noted("columns", "x, y, z, name and stick follow inline and crossline, which are not used")
    return Table(np.array(points), np.array(lines), labels, names)
