"""Coordinate reference systems as files state them, and the file ``.prj`` next to another one."""

from __future__ import annotations

from pathlib import Path

from geosurf.conventions.crs import EPSG, crs_of, label
from geosurf.read._guard import read_bytes
from geosurf.read._noted import noted

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
