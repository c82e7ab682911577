"""The file ``.prj`` of ESRI: the coordinate reference system of a file that has no place for it."""

from __future__ import annotations

from geosurf.conventions.crs import epsg_of, label
from geosurf.write.written import Loss


def prj_of(crs: str) -> tuple[bytes | None, list[Loss]]:
    """
    Return the content of a ``.prj``, or why there is none.

    Parameters
    ----------
    crs : str

    Returns
    -------
    content : bytes or None
        A description in WKT, in the words of ESRI where pyproj is installed.
    lost : list of Loss

    Examples
    --------
    >>> prj_of('PROJCS["ED50 / UTM zone 31N"]')
    (b'PROJCS["ED50 / UTM zone 31N"]', [])
    """
    if "[" in crs:
        return " ".join(crs.split()).encode("utf-8"), []
    reason = "it is not an EPSG code"
    if epsg_of(crs) is not None:
        try:
            from pyproj import CRS
            from pyproj.exceptions import CRSError
        except ImportError:
            reason = "pyproj is not installed: pip install 'geosurf[crs]'"
        else:
            try:
                return CRS.from_epsg(epsg_of(crs)).to_wkt("WKT1_ESRI").encode("utf-8"), []
            except CRSError:
                reason = "pyproj does not know it, or ESRI has no words for it"
    return None, [
        Loss(
            "crs",
            f"The coordinate reference system (CRS), {label(crs)}, is not in the file, and no "
            f".prj was written: {reason}.",
        )
    ]
