"""What readers return of places that are in metres already: points, and faults as grids."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import FAULT_DIMS
from geosurf.conventions.crs import EPSG, crs_of, label
from geosurf.errors import InputError
from geosurf.read._common import Request
from geosurf.read._guard import read_bytes
from geosurf.read._noted import noted

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr


# ---- prj ----------------------------------------
# Coordinate reference systems as files state them, and the file ``.prj`` next to another one.


SUFFIXES = (".prj", ".PRJ")


class _Declared:
    """What `crs_of` looks at."""

    def __init__(self, crs: str | None) -> None:
        self.attrs = {"crs": crs}


def crs_from(text: str) -> str | None:
    """
    Return a reference system as geosurf has it: an EPSG code where the text has one.

    Examples
    --------
    >>> crs_from("urn:ogc:def:crs:EPSG::23031"), crs_from(" ")
    ('EPSG:23031', None)
    """
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
    crs = None if found is None else crs_from(read_bytes(found).decode("latin-1"))
    if crs is not None and "[" in crs:
        crs = _with_code(crs)
    if crs is not None:
        noted("crs", f"{label(crs)}, from the file .prj")
    return crs


def _with_code(crs: str) -> str:
    """A description as its EPSG code, if pyproj knows it."""
    try:
        from pyproj import CRS
        from pyproj.exceptions import CRSError
    except ImportError:
        return crs
    try:
        code = CRS.from_wkt(crs).to_epsg()
    except CRSError:
        return crs
    return crs if code is None else f"EPSG:{code}"


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
    import xarray as xr

    data = {
        key: ("point", points[:, k].copy(), dict(meaning))
        for k, (key, meaning) in enumerate(AXES.items())
    }
    stated = {} if crs is None else {"crs": crs}
    return xr.Dataset(data | (others or {}), attrs={"source": source, **attrs, **stated})


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
    import xarray as xr

    data = {
        key: (FAULT_DIMS, nodes[..., k].copy(), dict(meaning))
        for k, (key, meaning) in enumerate(AXES.items())
    }
    stated = {} if crs is None else {"crs": crs}
    return xr.Dataset(data, attrs={"name": name, "source": source, **stated})


def refuse_columns(path: Path, format_: str, request: Request) -> None:
    """Refuse arguments that apply to tables of text only."""
    if request.columns is not None or request.decimal != ".":
        raise InputError(
            f"{path}: columns= and decimal= apply to tables of text, but this is {format_}. Leave "
            "them out."
        )
