"""A fault in any of its forms -> `TriSurface` with normals into the hanging wall."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import (
    FAULT_DIMS,
    elevation_sign,
    first_given,
    is_number,
    metres_per_unit,
    place,
)
from geosurf.conventions.crs import crs_of
from geosurf.errors import InputError, SurfaceError
from geosurf.model import FluidContact, Lattice, TriSurface
from geosurf.model.base import in_crs_of, with_crs
from geosurf.model.column import ELSEWHERE
from geosurf.model.expected import box_of_sides, name_of
from geosurf.triangulate.grids import in_metres
from geosurf.triangulate.horizon import triangulate_horizon
from geosurf.triangulate.mesh import (
    fault_diagonal,
    is_mesh,
    orient_fault,
    refuse_far,
    refuse_flat_triangles,
    refuse_zero_area,
    triangulate_mesh,
)
from geosurf.triangulate.neighbours import own_form
from geosurf.triangulate.sticks import triangulate_sticks

_HOW_FAULT = (
    "Give an xarray.Dataset with easting, northing and elevation (or depth) over "
    f"{FAULT_DIMS}, sticks as a list of arrays (n, 3), a TriSurface, or (vertices, triangles)."
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
        lattice = _read_lattice(obj, title, positive, length_unit)
        surface = with_crs(TriSurface(title, "fault", lattice=lattice), crs_of(obj))
    elif hasattr(obj, "sticks"):
        scale = _scale(title, first_given(positive, "up"), first_given(length_unit, "m"))
        sticks = [np.asarray(stick, dtype=np.float64) * (1.0, 1.0, scale) for stick in obj.sticks]
        return in_crs_of(triangulate_sticks(sticks, name=title), [obj])
    else:
        raise SurfaceError(f"fault {title!r}: cannot use {type(obj).__name__}. {_HOW_FAULT}")

    if surface.n_triangle == 0:
        raise SurfaceError(
            f"fault {title!r} has no triangles: no three neighbouring nodes are present. "
            "Check the NaN mask, or drop the fault."
        )

    # Triangles without area have no normal, so exact geometry cannot use them.
    if surface.lattice is None:
        refuse_flat_triangles(surface)
    elif len(keys := surface.lattice.normals[2]):
        doubted = surface.lattice.rows_of_keys(keys)
        remedy = "Set one of the coincident or collinear nodes to NaN."
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
            f"{sorted(map(str, ds.variables))}. {_HOW_FAULT}"
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
            f"{sorted(map(str, ds.variables))}. {_HOW_FAULT}"
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
    if metres:
        return in_metres(variable, f"{key} of fault {title!r}", SurfaceError)
    return np.asarray(variable.values, dtype=np.float64)


# ---- contacts ----------------------------------------
# Fluid contacts: levels and grids that split units.


_HOW = (
    "Give an elevation [m], a gridded horizon, a surface, a FluidContact, {block: one of these}, "
    "or a list of FluidContacts."
)


def build_contacts(
    contacts: Mapping[str, Any], box: Sequence[float]
) -> tuple[list[TriSurface], list[FluidContact]]:
    """
    Return the surfaces of fluid contacts, and in which zones and blocks they count.

    Parameters
    ----------
    contacts : mapping of str to contact
        From the top down: ``{"GOC": -1650.0, "OWC": -1705.0}``. A contact is an elevation
        [m, positive up], a gridded horizon (`xarray.DataArray`), a `TriSurface`, or a mapping of
        block to one of these: ``{"F1+": -1705.0, "F1- F2+": -1720.0, "elsewhere": -1690.0}``.
        A block is given by sides of faults that units lie on (``Unit.fault_sides``); of several
        that fit, the one with most sides in the name of the unit's block counts, then most sides.
        Units that no entry fits are not split, and are listed in
        ``units.report["without_contact"]``.
        A `FluidContact`, or a list of them, also names the zones where it applies:
        ``[FluidContact(-1705.0, zones="Top/Middle"), FluidContact(-1720.0, zones="Middle/Base")]``.
        One without zones applies to those of the reservoir.
    box : (west, east, south, north, bottom, top)
        Of the model [m].

    Returns
    -------
    surfaces : list of TriSurface
        Role ``"contact"``.
    contacts : list of FluidContact
        One for each surface, with its name.

    Raises
    ------
    InputError
        If a contact has another type, an elevation is not inside the box, or one block and its
        zones are given twice.

    Examples
    --------
    >>> surfaces, contacts = build_contacts({"OWC": {"F1+": -1705.0}}, (0, 9, 0, 9, -1800, -1600))
    >>> surfaces[0], contacts[0].block
    (<TriSurface 'OWC in F1+' (contact): 4 vertices, 2 triangles>, 'F1+')
    """
    if not isinstance(contacts, Mapping):
        raise InputError(
            "`contacts` must be a mapping such as {'OWC': -1705.0}, not "
            f"{type(contacts).__name__}."
        )

    surfaces: list[TriSurface] = []
    fluid_contacts: list[FluidContact] = []
    box = box_of_sides(box).tolist()

    # A contact has one entry for the whole field, or one for each block; each becomes a surface.
    for name, value in contacts.items():
        entries = _entries(str(name), value)
        if not entries:
            raise InputError(f"fluid contact {name!r} has an empty mapping of blocks. {_HOW}")
        for entry in entries:
            if entry.name not in ("", str(name)):
                raise InputError(
                    f"fluid contact {name!r} holds a FluidContact with another name, "
                    f"{entry.name!r}. Use one name for both."
                )

            # the same contact may count in several zones or blocks, but once in each
            contact = replace(entry, name=str(name))
            if any(contact.surface == surface.name for surface in surfaces):
                raise InputError(
                    f"fluid contact {contact.surface!r} is given twice. Leave one of them out, or "
                    "give each its own zones or block."
                )
            surfaces.append(_surface(contact.surface, contact.at, box))
            fluid_contacts.append(contact)
    return surfaces, fluid_contacts


def _entries(name: str, value: Any) -> list[FluidContact]:
    """What is given for one contact, each with its zones and block."""
    if isinstance(value, FluidContact):
        return [value]
    if isinstance(value, list | tuple):
        odd = [contact for contact in value if not isinstance(contact, FluidContact)]
        if odd:
            raise InputError(f"fluid contact {name!r} is a list that holds {odd[0]!r}. {_HOW}")
        return list(value)
    if not isinstance(value, Mapping) or hasattr(value, "data_vars"):
        return [FluidContact(value)]
    # A mapping that is not a Dataset: one value per block.
    return [contact for key, part in value.items() for contact in _of_block(name, str(key), part)]


def _of_block(name: str, key: str, value: Any) -> list[FluidContact]:
    """What is given for one block of a contact."""
    # The key says which block; a FluidContact may repeat it, but not contradict it.
    block = "" if key == ELSEWHERE else key
    parts = list(value) if isinstance(value, list | tuple) else [value]
    entries = [entry if isinstance(entry, FluidContact) else FluidContact(entry) for entry in parts]
    for entry in entries:
        if entry.block not in ("", block):
            raise InputError(
                f"fluid contact {name!r} has two blocks: {key!r} as its key and {entry.block!r} "
                "in the FluidContact. Keep one of them."
            )
    return [replace(entry, block=block) for entry in entries]


def _surface(name: str, value: Any, box: Sequence[float]) -> TriSurface:
    # A surface, a grid, or else a level.
    if isinstance(value, TriSurface):
        return value.renamed(name, "contact")
    if hasattr(value, "dims"):
        return triangulate_horizon(value, name=name).renamed(name, "contact")
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise InputError(f"fluid contact {name!r} cannot be a {type(value).__name__}. {_HOW}")
    if not is_number(value):
        raise InputError(f"the elevation of fluid contact {name!r} is {value}. Give a number [m].")

    # A level inside the box: a rectangle of two triangles, counter-clockwise seen from above.
    west, east, south, north, bottom, top = box
    if not bottom < value < top:
        remedy = f"Write {-float(value):g}" if bottom < -value < top else "Correct the elevation"
        raise InputError(
            f"fluid contact {name!r} is at elevation {float(value):g} m, outside the model box "
            f"({bottom:g} to {top:g} m). Elevation is positive up, so depths are negative. "
            f"{remedy}, or enlarge the box."
        )
    level = float(value)
    corners = [
        [west, south, level],
        [east, south, level],
        [east, north, level],
        [west, north, level],
    ]
    return TriSurface(name, "contact", corners, [[0, 1, 2], [0, 2, 3]])
