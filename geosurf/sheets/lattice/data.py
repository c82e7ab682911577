"""Horizon data in any form -> picks on one lattice, or scattered points with a lattice over them.

Points that sit on a lattice, rotated or not, are recognised; several may share a node.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from geosurf.conventions import elevation_sign, first_given, is_number, metres_per_unit
from geosurf.conventions.checks import are_points
from geosurf.errors import HorizonError, InputError
from geosurf.model import TriSurface
from geosurf.model.expected import name_of
from geosurf.sheets.lattice.find_lattice import find_lattice
from geosurf.sheets.lattice.frame import frame_of_lattice
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.scattered import proposed_spacing, refuse_too_few, scattered
from geosurf.triangulate import triangulate_horizon
from geosurf.triangulate.spikes import check_marks, check_spikes


def picks_of(
    data: Any, name: str | None, positive: str | None = None, length_unit: str | None = None
) -> Picks:
    """Read horizon data: a DataArray, a gridded TriSurface, a table or array of points.

    Raises
    ------
    HorizonError
        If the data cannot be used; the message states what to do.
    """
    if isinstance(data, TriSurface):
        if data.lattice is None:
            raise HorizonError(
                f"horizon {data.name!r} is a mesh without a lattice, which cannot be torn. "
                "Give the grid or the points that it was made from."
            )
        return _from_lattice(data.renamed(name or data.name))
    if are_points(data):
        return points_on_lattice(*points_of(data, name, positive, length_unit))
    surface = triangulate_horizon(data, name=name, positive=positive, length_unit=length_unit)
    check_spikes(surface)
    return _from_lattice(surface)


def has_fewer_nodes(data: Any) -> bool:
    """Whether a tolerance has left out nodes of horizon data."""
    return isinstance(data, TriSurface) and "volume_error" in data.vertex_data


def _from_lattice(surface: TriSurface) -> Picks:
    # no index array for a grid without holes: pick k is that of node k
    assert surface.lattice is not None
    frame, z = frame_of_lattice(surface.lattice, f"horizon {surface.name!r}")
    there = np.isfinite(z)
    if there.all():
        return Picks(surface.name, frame, None, z.ravel())
    node = np.flatnonzero(there)
    return Picks(surface.name, frame, node, z.ravel()[node])


def points_on_lattice(title: str, points: np.ndarray) -> Picks:
    """Picks of points (n, 3) that sit on a lattice."""
    what = f"horizon {title!r}"
    found = find_lattice(points[:, :2], what)
    if found is None:
        raise HorizonError(
            f"{what}: the points sit on no lattice of right angles. Give a grid, or points on one."
        )
    return Picks(title, *found, points[:, 2])


def picks_or_points(
    data: Any,
    name: str | None,
    positive: str | None,
    length_unit: str | None,
    spacing: float | None,
) -> Picks:
    """Picks on a lattice, or scattered points: those that are on none, or if a spacing is given."""
    if spacing is not None and not (is_number(spacing) and spacing > 0):
        raise InputError(f"spacing is {spacing!r}, expected metres above 0.")
    if not are_points(data):
        if spacing is not None:
            raise InputError(
                f"spacing is {spacing:g} m, but the data are a grid, which has its own. "
                "Leave it out."
            )
        return picks_of(data, name, positive, length_unit)
    title, points = points_of(data, name, positive, length_unit)

    # without a spacing, points that sit on a lattice keep it
    if spacing is None:
        found = find_lattice(points[:, :2], f"horizon {title!r}")
        if found is not None:
            return Picks(title, *found, points[:, 2])
        refuse_too_few(points, f"horizon {title!r}")
    return scattered(title, points, spacing or proposed_spacing(points))


def points_of(
    data: Any, name: str | None, positive: str | None, length_unit: str | None
) -> tuple[str, np.ndarray]:
    """Name and points (n, 3) of a table or array: easting, northing, elevation [m]."""
    own = getattr(data, "attrs", {}).get("name") or "horizon"
    title = str(own) if name is None else name_of(name, "horizon")
    what = f"horizon {title!r}"

    # tables name their columns, and may say units and direction; arrays are in this order
    if hasattr(data, "data_vars") or hasattr(data, "columns"):
        there = list(data.variables if hasattr(data, "data_vars") else data.columns)
        missing = [k for k in ("easting", "northing", "elevation") if k not in there]
        if missing:
            raise HorizonError(
                f"{what}: points lack {missing}, there are {sorted(map(str, there))}. "
                "Give easting, northing and elevation, one value per point."
            )
        attrs = data["elevation"].attrs
        declared = attrs.get("positive", data.attrs.get("positive"))
        positive = _agreed(declared, positive, what)
        length_unit = first_given(length_unit, attrs.get("units"), "m")
        points = np.stack(
            [np.ravel(data[k].values) for k in ("easting", "northing", "elevation")], axis=1
        )
    else:
        points = np.asarray(data)
        length_unit = first_given(length_unit, "m")
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "fiu":
        raise HorizonError(
            f"{what}: points have shape {points.shape}, expected numbers (n, 3): easting, "
            "northing, elevation."
        )

    # a point without a number would be a hole that nobody drew: an error, not a gap
    points = points.astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise HorizonError(
            f"{what}: {len(bad)} points are not finite, the first is point {bad[0]}. Leave out "
            "points that are undefined."
        )

    # elevations in metres, positive up, from here on
    try:
        scale = elevation_sign(positive, what) * metres_per_unit(length_unit, what)
    except InputError as error:
        raise HorizonError(str(error)) from error
    points[:, 2] *= scale
    check_marks(title, points)
    return title, points


def _agreed(attribute: str | None, argument: str | None, what: str) -> str | None:
    """Whether a table of points has elevations or depths, by its attribute or by the argument."""
    if attribute is not None and argument is not None and attribute != argument:
        raise HorizonError(
            f"{what}: attrs['positive'] of its elevations is {attribute!r}, the argument positive "
            f"is {argument!r}. Leave the argument out, or correct the attribute."
        )
    return argument if attribute is None else attribute
