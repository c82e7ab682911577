"""What users hand to a scene -> what stages take: files are opened, grids triangulated."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from geosurf.conventions import did_you_mean, frame_origin, shift_is_exact
from geosurf.errors import InputError
from geosurf.model import FaultSticks, FluidContact, Sheet, TriSurface
from geosurf.triangulate import orient_fault, triangulate_fault, triangulate_horizon
from geosurf.triangulate.horizon_mesh import check_horizon_mesh
from geosurf.triangulate.outline import check_outline
from geosurf.triangulate.spikes import check_spikes

Options = Mapping[str, Any]

# what a scene is made of, as `Scene` and `Scene.replace` call it
INPUTS = (
    "horizons", "faults", "box", "column", "contacts", "aoi", "positive", "length_unit",
    "voxel_size", "self_intersections", "extend", "truncations", "tolerance",
)  # fmt: skip


def refuse_assignment(name: str) -> NoReturn:
    """Refuse to change a scene in place, and name what to type instead."""
    if name in INPUTS:
        raise InputError(
            f"a scene cannot be changed, so scene.{name} cannot be set. Make another one, which "
            f"shares all results that still hold: scene = scene.replace({name}=...)."
        )
    raise InputError(
        f"a scene cannot be changed, and {name!r} is not one of its inputs. They are {INPUTS}, and "
        f"scene.replace takes them.{did_you_mean(name, INPUTS)}"
    )


def as_mapping(what: str, inputs: Any) -> dict[str, Any]:
    """Return named inputs, or an InputError that says how to name them."""
    if not isinstance(inputs, Mapping):
        raise InputError(f"{what} is a {type(inputs).__name__}; give a mapping {{name: ...}}.")
    named: dict[str, Any] = {}
    for key, value in inputs.items():
        name = str(key)
        if not name.strip() or name in named:
            fault = f"{name!r} twice, as text and as a number" if name.strip() else "an empty name"
            raise InputError(f"{what} has {fault}; give each a name of its own.")
        named[name] = value
    return named


def refuse_namesakes(**kinds: Mapping[str, Any]) -> None:
    """Refuse a name that two inputs have: results are asked for by name."""
    seen: dict[str, str] = {}
    for kind, inputs in kinds.items():
        for name in inputs:
            if name in seen:
                raise InputError(
                    f"{name!r} is the name of a {seen[name]} and of a {kind}; rename one."
                )
            seen[name] = kind


def as_surface(
    name: str,
    role: str,
    value: Any,
    options: Options,
    others: Callable[[str], TriSurface] | None = None,
) -> TriSurface:
    """Return a horizon or fault as a surface, whatever it was.

    Parameters
    ----------
    name : str
    role : {"horizon", "fault"}
    value : path, xarray object, FaultSticks, TriSurface, (vertices, triangles) or Sheet
    options : mapping
        ``positive`` and ``length_unit``, for inputs that do not say theirs.
    others : callable, optional
        Surface of a name: a sheet asks for the faults that tear it.

    Returns
    -------
    TriSurface
        A fault has its normals in the hanging wall, however its file or mesh was wound.
    """
    found = _read(value, role, options) if isinstance(value, str | Path) else value
    if role == "horizon" and isinstance(found, tuple | list):
        found = triangulate_horizon(found, name=name, **_only_if_unsaid(found, options))
    torn = isinstance(found, Sheet)  # one that ends on its faults has been checked
    if torn:
        found = found.surface_among(others)
    if isinstance(found, TriSurface):
        found = found.renamed(name, role)
        if role == "horizon" and not torn:
            check_horizon_mesh(found)
            check_spikes(found)
        return orient_fault(found) if role == "fault" else found
    if found is value and hasattr(found, "coords"):
        found = found.copy(deep=True)  # a scene outlives what is done to its inputs afterwards
    make = triangulate_horizon if role == "horizon" else triangulate_fault
    made = make(found, name=name, **_only_if_unsaid(found, options))
    if role == "horizon":
        check_spikes(made)
    return made


def opened_contacts(contacts: Mapping[str, Any], options: Options) -> dict[str, Any]:
    """Return fluid contacts, paths and grids as surfaces, for `build_contacts`."""
    return {name: _opened(name, value, options) for name, value in contacts.items()}


def _opened(name: str, value: Any, options: Options) -> Any:
    """A contact with its paths read; a mapping has one for each block, a list several."""
    if isinstance(value, FluidContact):
        return replace(value, at=_opened(name, value.at, options))
    if isinstance(value, list | tuple):
        return [_opened(name, one, options) for one in value]
    if isinstance(value, str | Path) or hasattr(value, "dims"):
        return as_surface(name, "horizon", value, options)
    if isinstance(value, Mapping) and not hasattr(value, "data_vars"):
        return {block: _opened(f"{name} in {block}", one, options) for block, one in value.items()}
    return value


def opened_outline(aoi: Any) -> np.ndarray:
    """Return the corners of an area of interest, given as an array or a file of polygons."""
    if isinstance(aoi, str | Path):
        from geosurf.read import read_polygons

        aoi = read_polygons(aoi, positive="up")
    return check_outline(aoi)


def only_of(entries: Mapping[str, Any], names: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entries that are about some names."""
    return {name: value for name, value in entries.items() if name in names}


def exchanged(what: str, inputs: Mapping[str, Any], changes: Any) -> dict[str, Any]:
    """Return named inputs with some exchanged, added, or (None) removed."""
    changed = as_mapping(what, {} if changes is None else changes)
    for name, value in changed.items():
        if value is None and name not in inputs:
            raise InputError(
                f"{what} has no {name!r} to remove; there are {list(inputs)}."
                f"{did_you_mean(name, inputs)}"
            )
    return {name: one for name, one in {**inputs, **changed}.items() if one is not None}


def shared_origin(box: tuple[float, ...] | None, surfaces: Sequence[TriSurface]) -> np.ndarray:
    """Return the origin of the local frame: the box's where shifts by it are exact."""
    if box is not None:
        w, e, s, n, b, t = box
        origin = frame_origin(np.array([[w, s, b], [e, n, t]]))
        if all(_shift_is_exact(surface, origin) for surface in surfaces):
            return origin
    return frame_origin(*(surface.extent for surface in surfaces))


def _shift_is_exact(surface: TriSurface, origin: np.ndarray) -> bool:
    """Whether a surface can be moved to an origin (whose elevation is 0); a grid has short axes."""
    if not origin.any():
        return True
    lattice = surface.lattice
    axes = surface.vertices.T[:2] if lattice is None else (lattice.easting, lattice.northing)
    return all(shift_is_exact(axis, shift) for axis, shift in zip(axes, origin[:2], strict=True))


def box_in_words(
    sides: Sequence[float], horizons: Sequence[TriSurface], aoi: np.ndarray | None
) -> str:
    """Return where a default box lies, and how much it leaves out because of holes and rims."""
    if aoi is not None:
        return "where the area of interest is"
    bounds = np.array([horizon.bounds for horizon in horizons])
    span = bounds[:, 1:4:2].min(axis=0) - bounds[:, 0:4:2].max(axis=0)
    west, east, south, north = sides
    share = (east - west) * (north - south) / float(span.prod())
    if share > 0.99:
        return "where all horizons are"
    return (
        f"the largest rectangle that all horizons cover, {100 * share:.0f} % of where they "
        "overlap; the rest has holes or slanting rims"
    )


def boxes_meet(p: Sequence[float], q: Sequence[float]) -> bool:
    """Return whether two boxes, (west, east, south, north, bottom, top), have a point in common."""
    return all(p[2 * k] <= q[2 * k + 1] and q[2 * k] <= p[2 * k + 1] for k in range(3))


def _read(path: Any, role: str, options: Options) -> Any:
    from geosurf.read import otherwise, read_fault, read_nodes

    return (read_nodes if role == "horizon" else read_fault)(path, **otherwise(options))


def _only_if_unsaid(value: Any, options: Options) -> dict[str, Any]:
    """Scene-wide words count only for inputs that do not say theirs themselves."""
    if isinstance(value, FaultSticks):
        return {}  # metres, elevation positive up: a reader has turned what a file held
    attrs = dict(getattr(value, "attrs", {}))
    if hasattr(value, "data_vars"):  # a fault: its third variable says by its name which way is up
        height = "elevation" if "elevation" in value.variables else "depth"
        # what it says counts, as it does for triangulate_fault; attributes of the whole do not
        attrs = {"positive": None, **(value[height].attrs if height in value.variables else {})}
    attribute = {"length_unit": "units"}  # the name that CF gives it
    return {
        key: word
        for key, word in options.items()
        if word is not None and attribute.get(key, key) not in attrs
    }
