"""What readers return of places that are in metres already: points, and faults as grids."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import FAULT_DIMS, first_given
from geosurf.conventions.crs import EPSG, crs_of, label, proj_system, refuse_other_units
from geosurf.errors import FormatError, SurfaceError
from geosurf.lazy import xarray as xr
from geosurf.model import TriSurface
from geosurf.model.base import with_crs
from geosurf.read._common import Request, agreed_scale, agreed_sign, noted
from geosurf.read._guard import damaged, read_bytes

# ---- triangles ----------------------------------------
# Points and cells of a mesh file -> a surface in metres, elevation up; for every mesh format.


def surface_from_mesh(
    path: Path,
    name: str,
    points: np.ndarray,
    triangles: np.ndarray,
    vertex_data: dict[str, Any],
    request: Request,
    crs: str | None = None,
) -> TriSurface:
    """Turn what a mesh file holds into a surface in metres, elevation up."""
    what = f"{path}: surface {name!r}"

    # mesh formats state neither direction nor unit: elevation in metres, unless the caller does
    sign = agreed_sign(None, first_given(request.positive, "up"), what)
    scale = agreed_scale(None, request.length_unit, "m", what)
    if len(triangles) == 0:
        raise FormatError(
            f"{path}: the file has no triangles. Export the surface as a triangle mesh."
        )
    try:
        world = points * [1.0, 1.0, scale * sign]
        return with_crs(TriSurface(name, "fault", world, triangles, vertex_data=vertex_data), crs)
    except (SurfaceError, ValueError) as error:
        raise FormatError(f"{path}: {error}") from error


def split_quads(quads: np.ndarray) -> np.ndarray:
    """Triangles (2 n, 3) of quads (n, 4), each split from its first corner."""
    return np.asarray(quads)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def triangles_of_cells(
    path: Path, corners: np.ndarray, ends: np.ndarray, count: np.ndarray, n_point: int
) -> np.ndarray:
    """
    Return triangles (n, 3) of cells with three or four corners, cell by cell.

    Parameters
    ----------
    path : pathlib.Path
    corners : ndarray of int64, shape (n_corner,)
        Points of all cells, one cell after the other.
    ends, count : ndarray of int64, shape (n_cell,)
        Where the corners of each cell end, and how many it has.
    n_point : int

    Raises
    ------
    FormatError
        If a cell has other than three or four corners, or names a point that is not there.
    """
    odd = np.flatnonzero((count != 3) & (count != 4))
    if len(odd):
        raise FormatError(
            f"{path}: cell {odd[0]} has {count[odd[0]]} corners, expected 3 or 4. "
            "Triangulate the surface before saving it."
        )

    # numpy would take negative rows from the end, without an error
    if len(corners) and (corners.min() < 0 or corners.max() >= n_point):
        bad = np.flatnonzero((corners < 0) | (corners >= n_point))
        raise damaged(f"{path}: a cell names point {corners[bad[0]]}, expected 0 to {n_point - 1}")

    # triangles only, one after the other: they are there already
    if (count == 3).all() and len(corners) == 3 * len(count) and (np.diff(ends) == 3).all():
        return corners.reshape(-1, 3)

    # Two slots for each cell: quads fill both, triangles only the first.
    starts = ends - count
    quads = count == 4
    out = np.empty((len(count), 2, 3), dtype=np.int64)
    out[:, 0] = corners[starts[:, None] + np.arange(3)]
    out[quads] = split_quads(corners[starts[quads, None] + np.arange(4)]).reshape(-1, 2, 3)

    keep = np.ones((len(count), 2), dtype=bool)
    keep[:, 1] = quads
    return out[keep]


# ---- prj ----------------------------------------
# Coordinate reference systems as files state them, and the file ``.prj`` next to another one.


SUFFIXES = (".prj", ".PRJ")


class _Declared:
    """What `crs_of` looks at."""

    def __init__(self, crs: str | None) -> None:
        self.attrs = {"crs": crs}


def crs_from(text: str, path: Path | None = None) -> str | None:
    """
    Return a reference system as geosurf has it: an EPSG code where the text has one.

    Examples
    --------
    >>> crs_from("urn:ogc:def:crs:EPSG::23031"), crs_from(" ")
    ('EPSG:23031', None)
    """
    refuse_other_units(text, str(path or "the file"))
    found = crs_of(_Declared(" ".join(text.split()) or None))
    code = EPSG.fullmatch(found or "")
    return f"EPSG:{code[1]}" if code else found


def crs_of_prj(path: Path) -> str | None:
    """
    Return the reference system in the ``.prj`` of the same name, or None without one.

    ESRI writes no EPSG codes into it: pyproj finds the code, where it is installed.

    Parameters
    ----------
    path : pathlib.Path
        The file next to it.
    """
    found = next((one for word in SUFFIXES if (one := path.with_suffix(word)).exists()), None)
    crs = None if found is None else crs_from(read_bytes(found).decode("latin-1"), found)
    if crs is not None and "[" in crs:
        code = system.to_epsg() if (system := proj_system(crs)) else None
        crs = crs if code is None else f"EPSG:{code}"
    if crs is not None:
        noted("crs", f"{label(crs)}, from the file .prj")
    return crs


METRE, UP = {"units": "m"}, {"units": "m", "positive": "up"}
AXES = {"easting": METRE, "northing": METRE, "elevation": UP}


def points_dataset(
    points: np.ndarray,
    source: str,
    crs: str | None = None,
    others: dict[str, Any] | None = None,
    **attrs: str,
) -> xr.Dataset:
    """
    Return points as a Dataset.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 3)
        Easting, northing, elevation [m].
    source : str
        Name of the file.
    crs : str, optional
    others : dict, optional
        Further variables, as xarray takes them.
    **attrs : str
        Further attributes.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point``.
    """
    stated = {} if crs is None else {"crs": crs}
    data = _axes(points, "point") | (others or {})
    return xr.Dataset(data, attrs={"source": source, **attrs, **stated})


def _axes(places: np.ndarray, dims: Any) -> dict[str, Any]:
    """Easting, northing, elevation of places (..., 3) as xarray takes variables."""
    return {
        key: (dims, places[..., k].copy(), dict(meaning))
        for k, (key, meaning) in enumerate(AXES.items())
    }


def fault_dataset(nodes: np.ndarray, name: str, source: str, crs: str | None) -> xr.Dataset:
    """
    Return a fault given by rows down its dip and columns along its strike.

    Parameters
    ----------
    nodes : ndarray of float64, shape (n_row, n_column, 3)
        Easting, northing, elevation [m].
    name, source : str
        Of the fault, and of its file.
    crs : str or None

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``(down_dip, along_strike)``.
    """
    stated = {} if crs is None else {"crs": crs}
    attrs = {"name": name, "source": source, **stated}
    return xr.Dataset(_axes(nodes, FAULT_DIMS), attrs=attrs)
