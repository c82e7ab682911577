"""A fault in any of its forms -> `TriSurface` with normals into the hanging wall."""

from __future__ import annotations

from typing import Any

import numpy as np

from geosurf.conventions import FAULT_DIMS, elevation_sign, first_given, metres_per_unit, place
from geosurf.conventions.crs import crs_of
from geosurf.errors import InputError, SurfaceError
from geosurf.model import Lattice, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.expected import name_of
from geosurf.triangulate.cells import corners_are_open, fault_diagonal
from geosurf.triangulate.degenerate import refuse_zero_area
from geosurf.triangulate.mesh import is_mesh, refuse_flat_triangles, triangulate_mesh
from geosurf.triangulate.neighbours import own_form
from geosurf.triangulate.orient import orient_fault, refuse_far
from geosurf.triangulate.sticks import triangulate_sticks

_HOW = (
    "Give an xarray.Dataset with easting, northing and elevation (or depth) over "
    f"{FAULT_DIMS}, geosurf.FaultSticks(name, sticks), a TriSurface, or (vertices, triangles)."
)


def triangulate_fault(
    obj: Any,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> TriSurface:
    """Turn a fault into a triangulated surface.

    Parameters
    ----------
    obj : xarray.Dataset, fault sticks, TriSurface, or (vertices, triangles)
        - a Dataset with `easting`, `northing` and `elevation` or `depth`, each 2-D
          over ``("down_dip", "along_strike")``; NaN marks absent nodes;
        - an object with `name` and `sticks`, see `triangulate_sticks`;
        - a `TriSurface`: checked, oriented and passed on;
        - vertices (n_vertex, 3) and triangles (n_triangle, 3);
        - a surface or lines of another package, see docs/guides/other_packages.md.
    name : str, optional
        Needed where the object has no name of its own.
    positive : {"up", "down"}, optional
        Whether the third coordinate is elevation or depth. A Dataset states it
        by the name of its variable; sticks and vertices are elevations by default.
    length_unit : str, optional
        Unit of elevation or depth. Default: ``attrs["units"]`` of that variable of a
        Dataset; metres for sticks and vertices. Easting and northing are
        metres unless their own ``attrs["units"]`` differ.

    Returns
    -------
    TriSurface
        Role "fault", normals into the hanging wall (`orient_fault`); with its
        `Lattice` if it came from a grid. Arrays of float64 in metres, positive up, are not
        copied: leave them as they are afterwards.

    Raises
    ------
    SurfaceError
        If the input cannot be used, a triangle has exactly zero area, or the
        surface has only one side.
    InputError
        If `positive` or `length_unit` is missing or unknown.

    Examples
    --------
    A fault that dips 45 degrees east:

    >>> import numpy as np, xarray as xr
    >>> dims = ("down_dip", "along_strike")
    >>> ds = xr.Dataset({
    ...     "easting": (dims, [[0.0, 0.0], [900.0, 900.0]]),
    ...     "northing": (dims, [[0.0, 500.0], [0.0, 500.0]]),
    ...     "depth": (dims, [[1500.0, 1500.0], [2400.0, 2400.0]], {"units": "m"}),
    ... })
    >>> fault = triangulate_fault(ds, name="F1")
    >>> fault.n_triangle, fault.bounds
    (2, (0.0, 900.0, 0.0, 500.0, -2400.0, -1500.0))
    """
    # The name may come from the argument, the object or its attributes, in this order.
    attrs = getattr(obj, "attrs", {})
    if name is not None:
        name = name_of(name, "fault")
    title = name or getattr(obj, "name", None) or attrs.get("name") or attrs.get("long_name")
    if not title:
        raise SurfaceError("a fault has no name. Pass it, as in triangulate_fault(..., name='F1').")
    title = str(title)

    given, obj = obj, own_form(obj, title, "fault", positive)
    if obj is not given and hasattr(obj, "sticks"):
        positive = "up"  # sticks in their own form are elevations

    # One reader for each form; all end as a surface in metres, positive up.
    if is_mesh(obj):
        scale = _scale(title, first_given(positive, "up"), first_given(length_unit, "m"))
        surface = triangulate_mesh(obj, title, "fault", scale=scale, words=(positive, length_unit))
    elif hasattr(obj, "data_vars"):
        surface = TriSurface(
            title, "fault", lattice=_read_lattice(obj, title, positive, length_unit)
        )
        surface.crs = crs_of(obj)
    elif hasattr(obj, "sticks"):
        scale = _scale(title, first_given(positive, "up"), first_given(length_unit, "m"))
        sticks = [np.asarray(stick, dtype=np.float64) * (1.0, 1.0, scale) for stick in obj.sticks]
        return in_crs_of(triangulate_sticks(sticks, name=title), [obj])
    else:
        raise SurfaceError(f"fault {title!r}: cannot use {type(obj).__name__}. {_HOW}")

    if surface.n_triangle == 0:
        raise SurfaceError(
            f"fault {title!r} has no triangles: no three neighbouring nodes are present. "
            "Check the NaN mask, or drop the fault."
        )

    # Triangles without area have no normal, so exact geometry cannot use them.
    if surface.lattice is None:
        refuse_flat_triangles(surface)
    elif not corners_are_open(surface.lattice):
        doubted = surface.lattice.rows_of_keys(surface.lattice.normals[2])
        remedy = "Set one of the coincident or collinear nodes to NaN."
        if len(doubted):
            refuse_zero_area(title, surface.vertices, surface.triangles, remedy, doubted)

    surface = orient_fault(surface)
    surface.checked = surface.lattice is not None
    return surface


def _scale(title: str, positive: str | None, length_unit: str | None) -> float:
    what = f"fault {title!r}"
    return elevation_sign(positive, what) * metres_per_unit(length_unit, what)


def _read_lattice(ds: Any, title: str, positive: str | None, length_unit: str | None) -> Lattice:
    """The lattice of a Dataset over (down_dip, along_strike), in metres, positive up."""
    # Without attributes, the name of the variable determines the sign.
    easting, northing = (_plane(ds, key, title) for key in ("easting", "northing"))
    height = "elevation" if "elevation" in ds.variables else "depth"
    if height not in ds.variables:
        raise SurfaceError(
            f"fault {title!r}: neither elevation nor depth is among the variables "
            f"{sorted(map(str, ds.variables))}. {_HOW}"
        )

    attrs = ds.variables[height].attrs
    implied = "up" if height == "elevation" else "down"

    # the name of the variable and its direction must not contradict each other
    said = first_given(positive, attrs.get("positive"), implied)
    if said != implied:
        raise SurfaceError(
            f"fault {title!r}: {height} has positive={said!r}, expected {implied!r}. Name the "
            "variable elevation (positive up) or depth (positive down)."
        )

    scale = _scale(title, said, first_given(length_unit, attrs.get("units")))
    elevation = _plane(ds, height, title, metres=False)
    if scale != 1.0:
        elevation = elevation * scale
    if min(elevation.shape) < 2:
        raise SurfaceError(
            f"fault {title!r}: the grid has {elevation.shape[0]} x {elevation.shape[1]} nodes, "
            "expected 2 x 2 or more. Read a larger part of the fault."
        )

    lattice = Lattice(easting, northing, elevation, True, False)
    # -0.0 and 0.0 are one number with two bit patterns; keep 0.0 only.
    if lattice.survey.minus_zero:
        lattice = Lattice(easting, northing, elevation + 0.0, True, False)

    if not lattice.survey.finite:
        nodes = np.stack([easting, northing, elevation])
        infinite = np.isinf(nodes).any(axis=0)
        i, j = map(int, np.argwhere(infinite)[0])
        raise SurfaceError(
            f"fault {title!r}: {int(infinite.sum())} nodes are infinite, the first is node "
            f"({i}, {j}) at {place(nodes[:, i, j])}. Set missing nodes to NaN."
        )

    refuse_far(title, lattice.survey.box)
    return lattice.turned_as(fault_diagonal(lattice), False)


def _plane(ds: Any, key: str, title: str, metres: bool = True) -> np.ndarray:
    """One variable over (down_dip, along_strike), float64."""
    if key not in ds.variables:
        raise SurfaceError(
            f"fault {title!r}: {key} is not among the variables "
            f"{sorted(map(str, ds.variables))}. {_HOW}"
        )
    variable = ds.variables[key]  # the array alone: labels cost more than what they label
    if set(variable.dims) != set(FAULT_DIMS):
        raise SurfaceError(
            f"fault {title!r}: dims of {key} are {tuple(variable.dims)}, expected {FAULT_DIMS}. "
            "Rename them with ds.rename(...)."
        )
    if variable.dtype.kind not in "fiu":
        raise SurfaceError(
            f"fault {title!r}: {key} has dtype {variable.dtype}, expected numbers. "
            f"Convert it with ds[{key!r}].astype(float)."
        )
    if variable.dims != FAULT_DIMS:  # a new variable costs ten times as much as its values
        variable = variable.transpose(*FAULT_DIMS)

    # Coordinates are converted to metres here; elevation is converted with its sign.
    values = np.asarray(variable.values, dtype=np.float64)
    length_unit = variable.attrs.get("units")
    if not metres or length_unit is None:
        return values
    try:
        factor = metres_per_unit(length_unit, f"{key} of fault {title!r}")
    except InputError as error:
        raise SurfaceError(str(error)) from error
    return values if factor == 1.0 else values * factor
