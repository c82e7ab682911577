"""Compute area, dip and azimuth of horizons and faults."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from geosurf.measure.faces import faces_of, row_of
from geosurf.model import Patches, Units

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

_DEGREE = "degree"


def orientation(patches: Patches, units: Units, name: str) -> xarray.Dataset:
    """
    Area, dip and azimuth of a horizon or fault inside the model, as a whole and by triangle.

    Parameters
    ----------
    patches, units : Patches, Units
    name : str
        Of a horizon or a fault. What the column has clipped away of a horizon is left out.

    Returns
    -------
    xarray.Dataset
        Over ``triangle``: ``area``, ``dip`` (0 to 90 from horizontal), ``azimuth`` (dip direction,
        clockwise from north, NaN where the dip is 0), ``overturned`` (its front looks down), and
        the middle. As a whole: ``total_area``, ``mean_dip``, ``mean_azimuth``, ``mean_strike``
        (azimuth less 90, right-hand rule), of the sum of all areas times their normals.

    Raises
    ------
    InputError
        If no horizon or fault has that name.
    GeometryError
        If it does not reach into the model, or has no mean normal.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9, dip=60.0, dip_direction=75.0)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> found = orientation(scene.patches, scene.units, "F1")
    >>> round(float(found.mean_dip), 9), round(float(found.mean_azimuth), 9)
    (60.0, 75.0)
    """
    import xarray as xr

    faces = faces_of(patches, units, name)
    role = patches.sources[row_of(patches, name, "horizon", "fault")].role

    # a horizon that ends inside one unit, or that the column clipped, bounds nothing there; a fault
    # counts where it dies, too
    kept = np.ones(len(faces.areas), dtype=bool)
    if role == "horizon":
        kept = faces.sides[:, 0] != faces.sides[:, 1]
    vectors, areas = faces.vectors[kept], faces.areas[kept]

    # dip is that of the plane: the normal is turned up, and `overturned` keeps what was lost
    up = vectors[:, 2] < 0
    dip, azimuth = _lie(np.where(up[:, None], -vectors, vectors))

    # area-weighted mean: the sum of vectors does not depend on how the surface is meshed. fsum is
    # exact, so the order of triangles does not matter either
    total = np.array([math.fsum(column) for column in vectors.T.tolist()])
    mean_dip, mean_azimuth = _lie((-total if total[2] < 0 else total)[None])
    middle = faces.x[faces.triangles[kept]].mean(axis=1) + faces.origin
    azimuth_words = "dip direction, clockwise from north"
    data = {
        "area": ("triangle", areas, {"units": "m2", "long_name": "area"}),
        "dip": ("triangle", dip, {"units": _DEGREE, "long_name": "dip from horizontal"}),
        "azimuth": ("triangle", azimuth, {"units": _DEGREE, "long_name": azimuth_words}),
        "overturned": ("triangle", up, {"units": "1", "long_name": "whether its front looks down"}),
        "total_area": ((), math.fsum(areas.tolist()), {"units": "m2", "long_name": "area"}),
        "mean_dip": ((), mean_dip[0], {"units": _DEGREE, "long_name": "dip of the mean normal"}),
        "mean_azimuth": (
            (), mean_azimuth[0],
            {"units": _DEGREE, "long_name": f"{azimuth_words}, of the mean normal"},
        ),
        "mean_strike": (
            (), (mean_azimuth[0] - 90.0) % 360.0,
            {"units": _DEGREE, "long_name": "strike by the right-hand rule"},
        ),
    }  # fmt: skip
    for k, axis in enumerate(("easting", "northing", "elevation")):
        words = {"units": "m", "long_name": f"{axis} of the middle of each triangle"}
        data[axis] = ("triangle", middle[:, k], words)
    return xr.Dataset(data, attrs={"surface": name, "role": role})


def _lie(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Dip and azimuth of planes from their upward normals (n, 3) [degrees]."""
    # a horizontal plane has no dip direction: NaN, not north
    flat = np.hypot(normals[:, 0], normals[:, 1])
    dip = np.degrees(np.arctan2(flat, normals[:, 2]))
    azimuth = np.degrees(np.arctan2(normals[:, 0], normals[:, 1])) % 360.0
    return dip, np.where(flat > 0, azimuth, np.nan)
