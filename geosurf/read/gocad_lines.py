"""GOCAD VSet and PLine: points, and polylines that segments join.

Headers, axes, units and direction of z are those of TSurf (`geosurf.read.gocad`). A PLine holds
``ILINE`` parts of vertices and ``SEG a b``; segments that follow one another form one line, and a
closed line repeats its first point. Properties are not used.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions.crs import label
from geosurf.errors import FormatError, InputError
from geosurf.model import FaultSticks
from geosurf.model.base import in_crs_of
from geosurf.read._common import read_text
from geosurf.read._gocad_draft import Draft, Line, bodies, fill, row_of
from geosurf.read._noted import noted
from geosurf.read._placed import points_dataset, refuse_columns

BREAK = (-1, -1)  # between two parts: their lines do not join, even at a shared vertex

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr


def read_vset(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> xr.Dataset:
    r"""
    Read the points of all VSet of a GOCAD file.

    Parameters
    ----------
    path : pathlib.Path
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.
    columns, decimal
        Of tables of text only.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point`` [m], positive up.

    Raises
    ------
    FormatError
        If the file has no VSet, is cut short, or a line cannot be understood.
    InputError
        If `positive` or `length_unit` contradicts the file, or `columns` is given.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "a.vs"
    >>> _ = file.write_text("GOCAD VSet 1\nVRTX 1 5 6 7\nVRTX 2 8 9 1\nEND\n")
    >>> read_vset(file).elevation.values
    array([7., 1.])
    """
    refuse_columns(path, "a GOCAD file", columns, decimal)
    drafts = [draft for draft, _ in _objects(path, "vset")]
    parts = [_points(draft, positive, length_unit) for draft in drafts]
    return points_dataset(np.concatenate(parts), path.name, _crs(path, drafts))


def read_pline(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
    name: str | None = None,
) -> list[np.ndarray]:
    r"""
    Read the lines of all PLine of a GOCAD file.

    Parameters
    ----------
    path, positive, length_unit, columns, decimal
        As for `read_vset`.
    name : str, optional
        Only the lines of the object of this name.

    Returns
    -------
    list of ndarray of float64, each (n, 3)
        Easting, northing, elevation [m], in the order of the file.

    Raises
    ------
    FormatError
        If the file has no PLine or no segments, is cut short, or a line cannot be understood.
    InputError
        If `positive` or `length_unit` contradicts the file, or `columns` is given.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "a.pl"
    >>> _ = file.write_text("GOCAD PLine 1\nILINE\nVRTX 1 0 0 5\nVRTX 2 9 0 5\nSEG 1 2\nEND\n")
    >>> read_pline(file)[0].tolist()
    [[0.0, 0.0, 5.0], [9.0, 0.0, 5.0]]
    """
    refuse_columns(path, "a GOCAD file", columns, decimal)
    lines = []
    names: dict[str, None] = {}
    for draft, segments in _objects(path, "pline"):
        names[draft.header.name or path.stem] = None
        points = _points(draft, positive, length_unit)
        if name in (None, draft.header.name or path.stem):
            lines += [points[rows] for rows in _chains(segments)]
    if name is not None and name not in names:
        raise InputError(
            f"{path}: no line is called {name!r}. Names are {', '.join(list(names)[:12])}; leave "
            "name= out to read all lines."
        )
    if not lines:
        raise FormatError(f"{path}: the file has no segments (SEG). Export the lines again.")
    return lines


def read_pline_sticks(
    path: Path, *, name: str | None = None, positive: str | None = None,
    length_unit: str | None = None,
) -> FaultSticks:  # fmt: skip
    """
    Read the lines of a GOCAD file as the sticks of one fault.

    Parameters
    ----------
    path : pathlib.Path
    name : str, optional
        Name of the fault; default: the file name without suffix.
    positive, length_unit
        As for `read_vset`.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError
        As `read_pline`.
    """
    lines = read_pline(path, positive=positive, length_unit=length_unit)
    made = FaultSticks(name or path.stem, tuple(lines))
    return in_crs_of(made, [_Declared(crs_of_gocad_lines(path))])


def crs_of_gocad_lines(path: Path) -> str | None:
    """Return the reference system that the PLine of a file declare; None without one.

    Parameters
    ----------
    path : pathlib.Path

    Raises
    ------
    FormatError
        If they declare several.
    """
    return _crs(path, [draft for draft, _ in _objects(path, "pline")])


@dataclass(frozen=True)
class _Declared:
    """What `in_crs_of` looks at."""

    crs: str | None


def _crs(path: Path, drafts: list[Draft]) -> str | None:
    """The system of all objects of a file."""
    found = list(dict.fromkeys(draft.header.crs for draft in drafts))
    if len(found) > 1:
        names = ", ".join("none" if one is None else label(one) for one in found)
        raise FormatError(
            f"{path}: its objects are in several coordinate reference systems: {names}. Write one "
            "file for each."
        )
    return found[0]


def _objects(path: Path, kind: str) -> Iterator[tuple[Draft, list[tuple[int, int]]]]:
    """Each object of one kind, with its segments as rows of vertices."""
    count = 0
    text = read_text(path, final_line_end=False)
    for i, found, body in bodies(path, text):
        if found != kind:
            for _ in body:  # another kind of object: pass over it
                pass
            continue
        draft = Draft(path, len(text), i)
        segments: list[tuple[int, int]] = []
        fill(draft, _without_segments(draft, body, segments))
        count += 1
        yield draft, segments
    noted("objects", f"{count} of the kind {kind}")
    if not count:
        raise FormatError(f"{path}: the file has no GOCAD {kind}. Export it again.")


def _without_segments(
    draft: Draft, body: Iterator[Line], segments: list[tuple[int, int]]
) -> Iterator[Line]:
    """Lines of an object except ``SEG a b``, which are taken here."""
    for i, words in body:
        if words[0].upper() == "ILINE":
            segments.append(BREAK)
        elif words[0].upper() != "SEG":
            yield i, words
        elif len(words) < 3:
            raise FormatError(
                f"{draft.path}, line {i}: SEG has {len(words) - 1} values, expected 2 vertex ids. "
                "Correct that line or export the file again."
            )
        else:
            segments.append((row_of(draft, i, words[1]), row_of(draft, i, words[2])))


def _points(draft: Draft, positive: str | None, length_unit: str | None) -> np.ndarray:
    """Vertices (n, 3) of an object in metres, elevation up."""
    name = draft.header.name or draft.path.stem
    if not draft.points:
        raise FormatError(
            f"{draft.path}: object {name!r}, which begins on line {draft.line}, has no vertices. "
            "Export it again."
        )
    what = f"{draft.path.name}: {name!r}"
    return draft.header.to_metres(np.concatenate(draft.points), positive, length_unit, what) + 0.0


def _chains(segments: list[tuple[int, int]]) -> list[list[int]]:
    """Rows of vertices of each line: a segment goes on where the one before it ended."""
    chains: list[list[int]] = []
    before = BREAK
    for first, last in segments:
        if (first, last) != BREAK and before[1] == first:
            chains[-1].append(last)
        elif (first, last) != BREAK:
            chains.append([first, last])
        before = (first, last)
    return chains
