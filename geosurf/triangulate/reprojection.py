"""Coordinates from one coordinate reference system into another, through pyproj."""

from __future__ import annotations

from typing import Any

import numpy as np

from geosurf.conventions.crs import are_same, crs_of, label
from geosurf.errors import DependencyError, GeosurfWarning, InputError
from geosurf.model import FaultSticks, TriSurface
from geosurf.model.expected import name_of
from geosurf.warning import warn

# A stated accuracy beyond this is worth a warning: picks and grids are seldom better [m].
ACCURATE = 1.0


def reproject(obj: Any, crs: str, *, source: str | None = None) -> Any:
    """
    Return a surface, grid or table in another coordinate reference system.

    Easting and northing are converted node by node, elevations stay. One operation of PROJ
    converts the whole object, the most accurate one that is installed for its area.

    Parameters
    ----------
    obj : DataArray, Dataset, TriSurface or FaultSticks
        A horizon; a table of points, tops or polygons, or a fault; a mesh; fault sticks.
    crs : str
        The new system, projected and in metres: ``"EPSG:32631"``.
    source : str, optional
        The system of an object that declares none.

    Returns
    -------
    DataArray, Dataset, TriSurface or FaultSticks
        A converted grid has easting and northing of each node, over (row, column): a regular grid
        is not regular in another system.

    Raises
    ------
    InputError
        If the object declares no system, declares another than `source`, cannot be converted, or
        lies outside the area of either system.
    DependencyError
        If pyproj is not installed.

    Examples
    --------
    >>> import geosurf as gs
    >>> top = gs.synthetic.graben(n=9).horizons["Top"].assign_attrs(crs="EPSG:23031")
    >>> gs.reproject(top, "EPSG:23031") is top  # nothing to convert
    True
    """
    crs = name_of(crs, "coordinate reference system")
    known = obj.crs if isinstance(obj, TriSurface | FaultSticks) else crs_of(obj, any_unit=True)
    what = repr(getattr(obj, "name", None) or "the object")
    if source is not None and not isinstance(source, str):
        raise InputError(f'source is {source!r}; give a text such as "EPSG:23031".')
    if known is None and source is None:
        raise InputError(
            f"{what} declares no coordinate reference system. Name it: gs.reproject(obj, {crs!r}, "
            'source="EPSG:...").'
        )
    if known is not None and source is not None and are_same(known, source) is False:
        raise InputError(
            f"{what} is in {label(known)}, but source is {source!r}. Leave source out."
        )
    known = known or str(source)
    if are_same(known, crs) and source is None:
        return obj

    # One way for each form; all end in `_converted`.
    if isinstance(obj, TriSurface):
        return _surface(obj, known, crs)
    if isinstance(obj, FaultSticks):
        return _sticks(obj, known, crs)
    if hasattr(obj, "coords") and {"easting", "northing"} <= {*obj.coords, *_variables(obj)}:
        return _labelled(obj, known, crs, what)
    raise InputError(
        f"{what}: cannot convert {type(obj).__name__}. Give a horizon or table with easting and "
        "northing, a TriSurface or FaultSticks."
    )


def _variables(obj: Any) -> tuple[str, ...]:
    return tuple(getattr(obj, "data_vars", ()))


def _surface(surface: TriSurface, known: str, crs: str) -> TriSurface:
    # as a mesh: the rules for grids (diagonals, rows that rise) belong to the old axes
    vertices = surface.vertices.copy()
    what = f"{surface.role} {surface.name!r}"
    vertices[:, 0], vertices[:, 1] = _converted(vertices[:, 0], vertices[:, 1], known, crs, what)
    made = TriSurface(
        surface.name, surface.role, vertices, surface.triangles, vertex_data=surface.vertex_data
    )
    made.crs = crs
    return made


def _sticks(fault: FaultSticks, known: str, crs: str) -> FaultSticks:
    # all sticks at once: one operation for the fault
    points = np.concatenate(fault.sticks)
    x, y = _converted(points[:, 0], points[:, 1], known, crs, f"fault {fault.name!r}")
    points = np.stack([x, y, points[:, 2]], axis=1)
    ends = np.cumsum([len(stick) for stick in fault.sticks])[:-1]
    made = FaultSticks(fault.name, tuple(np.split(points, ends)))
    object.__setattr__(made, "crs", crs)  # frozen
    return made


def _labelled(obj: Any, known: str, crs: str, what: str) -> Any:
    """Grids and tables of xarray, without the old declarations."""
    old = [key for key in ("spatial_ref", "crs", obj.attrs.get("grid_mapping")) if key]
    obj = obj.drop_vars([key for key in old if key in obj.coords]).copy()
    obj.attrs = {key: value for key, value in obj.attrs.items() if key != "grid_mapping"}
    obj.encoding = {key: value for key, value in obj.encoding.items() if key != "grid_mapping"}
    x, y = obj["easting"], obj["northing"]
    if x.dims != y.dims:  # axes of a regular grid
        east, north = np.meshgrid(x.values, y.values)
        obj = obj.transpose("northing", "easting", ...).drop_vars(["easting", "northing"])
        obj = obj.rename(northing="row", easting="column")
        dims: Any = ("row", "column")
    else:
        east, north, dims = x.values, y.values, x.dims
    new = _converted(east, north, known, crs, what)
    named = {
        key: (dims, part, {"units": "m"})
        for key, part in zip(("easting", "northing"), new, strict=True)
    }
    made = obj.assign(named) if "easting" in _variables(obj) else obj.assign_coords(named)
    return made.assign_attrs(crs=crs)


def _converted(
    x: np.ndarray, y: np.ndarray, known: str, crs: str, what: str
) -> tuple[np.ndarray, np.ndarray]:
    """Easting and northing in the new system [m]."""
    try:
        from pyproj import CRS, Transformer
        from pyproj.aoi import AreaOfInterest
        from pyproj.exceptions import CRSError, ProjError
        from pyproj.transformer import TransformerGroup
    except ImportError as error:
        raise DependencyError(
            "converting coordinates takes pyproj. Install it: pip install 'geosurf[crs]'."
        ) from error
    try:
        start, end = CRS.from_user_input(known), CRS.from_user_input(crs)
    except CRSError as error:
        raise InputError(
            f"{what}: PROJ does not know {label(known)!r} or {label(crs)!r}. Give EPSG codes, "
            'such as "EPSG:32631".'
        ) from error
    if not end.is_projected or any(a.unit_conversion_factor != 1.0 for a in end.axis_info[:2]):
        raise InputError(f"{label(crs)!r} is not projected in metres. Give one that is.")

    # the area in degrees: operations between datums hold in countries
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    try:
        to_degrees = Transformer.from_crs(start, start.geodetic_crs, always_xy=True)
        lon, lat = to_degrees.transform(x, y)
        area = AreaOfInterest(
            float(np.min(lon)), float(np.min(lat)), float(np.max(lon)), float(np.max(lat))
        )
        best = TransformerGroup(start, end, always_xy=True, area_of_interest=area).transformers[0]
        made_x, made_y = best.transform(x, y)
    except (ProjError, IndexError) as error:
        raise InputError(f"{what}: PROJ cannot convert it to {label(crs)} ({error}).") from error
    if not (np.isfinite(made_x).all() and np.isfinite(made_y).all()):
        raise InputError(
            f"{what}: some coordinates lie outside the area of {label(known)} or {label(crs)}. "
            "Check the declared system."
        )
    if not 0.0 <= best.accuracy <= ACCURATE:
        size = f"{best.accuracy:g} m" if best.accuracy >= 0.0 else "unknown"
        warn(
            GeosurfWarning(
                "crs",
                what.split("'")[1] if "'" in what else what,
                f"{what} was converted to {label(crs)} by {best.description!r}, whose stated "
                f"accuracy is {size}.",
                "Convert all inputs the same way, or install the grids of PROJ for the area.",
            )
        )
    return np.asarray(made_x), np.asarray(made_y)
