"""GOCAD TSurf: triangulated surfaces in text.

What files in the wild do, and what is done with it:

- ``ZPOSITIVE Depth`` turns z over; without the word z is elevation.
- ``AXIS_UNIT`` scales each axis to metres; without it lengths are metres.
- ``AXIS_NAME "Z" "Y" "X"`` puts columns in another order.
- ``NAME`` of the coordinate system (else ``DATUM`` and ``PROJECTION``) is the attribute `crs`.
- Keys are in upper or lower case.
- Several TFACE blocks are parts of one surface; ids run through all of them, may
  begin anywhere and skip.
- ``ATOM`` and ``PATOM`` are other names of a vertex: triangles share that vertex.
- Words after the coordinates (``CNXYZ``) are control-node flags and dropped.
- Other objects in the file (SGrid, VSet ...) are ignored.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.errors import FormatError, InputError
from geosurf.model import TriSurface
from geosurf.read._common import read_text
from geosurf.read._gocad_draft import Draft, bodies, fill
from geosurf.read._guard import refuse_large


def read_gocad(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> TriSurface:
    r"""
    Read the one TSurf of a file, or the one called `name`.

    Parameters
    ----------
    path : pathlib.Path
    name : str, optional
        Which surface, where the file has several; otherwise the name to give.
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    TriSurface
        Role ``"fault"``.

    Raises
    ------
    InputError
        If there are several surfaces and `name` is not one of them, or only one of several
        equally named ones; or if `positive` or `length_unit` contradicts the file.
    FormatError
        As `read_tsurf`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "F1.ts"
    >>> _ = file.write_text("GOCAD TSurf 1\nHEADER {\nname: F1\n}\nTFACE\n"
    ...     "VRTX 5 0 0 0\nVRTX 6 9 0 0\nVRTX 9 0 9 9\nTRGL 5 6 9\nEND\n")
    >>> read_gocad(file)
    <TriSurface 'F1' (fault): 3 vertices, 1 triangles>
    """
    surfaces = read_tsurf(path, positive=positive, length_unit=length_unit)
    if len(surfaces) == 1:
        return surfaces[0] if name is None else surfaces[0].renamed(name)

    # several surfaces: exactly one of them has to have the name
    names = [surface.name for surface in surfaces]
    found = [surface for surface in surfaces if surface.name == name]
    if len(found) != 1:
        guess = "" if name is None else did_you_mean(name, names)
        asked = "name= is not given" if name is None else f"{len(found)} are called {name!r}"
        raise InputError(
            f"{path}: the file has {len(surfaces)} surfaces, {names}, but {asked}.{guess} "
            "Select one with name=, or read all with geosurf.read.read_tsurf."
        )
    return found[0]


def read_tsurf(
    path: str | Path, *, positive: str | None = None, length_unit: str | None = None
) -> list[TriSurface]:
    r"""
    Read all TSurf of a GOCAD file.

    Parameters
    ----------
    path : str or pathlib.Path
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    list of TriSurface
        In file order, role ``"fault"``. Vertices in metres, elevation positive up;
        numeric properties in ``vertex_data``, NaN where the file has its no-data value.

    Raises
    ------
    FormatError
        If the file has no TSurf, is cut short, or a line cannot be understood.
    InputError
        If `positive` or `length_unit` contradicts the file or is unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "F1.ts"
    >>> _ = file.write_text("GOCAD TSurf 1\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\n"
    ...     "ZPOSITIVE Depth\nEND_ORIGINAL_COORDINATE_SYSTEM\nTFACE\n"
    ...     "VRTX 1 0 0 0\nVRTX 2 9 0 0\nVRTX 3 0 9 9\nTRGL 1 2 3\nEND\n")
    >>> read_tsurf(file)[0].vertices[2].tolist()
    [0.0, 9.0, -9.0]
    """
    path = Path(path)
    text = read_text(path, final_line_end=False)
    surfaces = []
    for i, kind, body in bodies(path, text):
        draft = Draft(path, len(text), i)
        if kind == "tsurf":
            fill(draft, body)
            surfaces.append(_finish(draft, positive, length_unit))
        else:
            for _ in body:  # another kind of object: pass over it
                pass
    if not surfaces:
        raise FormatError(
            f"{path}: the file has no TSurf object (a line 'GOCAD TSurf 1'). Export the "
            "surface as TSurf."
        )
    return surfaces


def _finish(draft: Draft, positive: str | None, length_unit: str | None) -> TriSurface:
    """Turn a draft into a surface in metres, elevation up."""
    path, header = draft.path, draft.header
    name = header.name or path.stem
    what = f"{path.name}: surface {name!r}"

    # points alone are no surface
    triangles = np.array(draft.corners, dtype=np.int64).reshape(-1, 3)
    if not len(triangles):
        raise FormatError(
            f"{path}: surface {name!r}, which begins on line {draft.line}, has no TRGL lines. "
            "Export it as a triangulated surface."
        )

    # order, units and direction of the axes are settled here, once for all vertices
    points = header.to_metres(np.concatenate(draft.points), positive, length_unit, what)
    surface = TriSurface(name, "fault", points, triangles, vertex_data=_vertex_data(draft))
    surface.crs = header.crs
    return surface


def _vertex_data(draft: Draft) -> dict[str, np.ndarray]:
    """Property arrays, (n_vertex,) or (n_vertex, size); NaN for no data."""
    header = draft.header

    sizes = header.property_sizes(draft.path, draft.line)
    if not sizes:
        return {}
    refuse_large(
        draft.path,
        8 * draft.n_vertex * sum(sizes),
        draft.size,
        f"a table of {sum(sizes)} properties",
    )

    # Vertices without values (VRTX, ATOM) have NaN in all columns.
    table = np.full((draft.n_vertex, sum(sizes)), np.nan)
    for rows, values in zip(draft.valued, draft.values, strict=True):
        table[rows] = values

    data, at = {}, 0
    for k, (key, size) in enumerate(zip(header.properties, sizes, strict=True)):
        # columns of one property; its own no-data value means NaN
        part = table[:, at : at + size].copy()
        if k < len(header.no_data):
            part[part == header.no_data[k]] = np.nan
        data[key] = part[:, 0].copy() if size == 1 else part
        at += size
    return data
