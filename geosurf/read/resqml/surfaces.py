"""What callers read of a RESQML package: horizons, faults, points, polygons, paths of wells.

The control points of a trajectory are places that the file states, with measured depths. The path
is straight between them: tangents and kinds of curves are not used, as for places in tables.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from xml.etree.ElementTree import Element

import numpy as np

from geosurf.conventions import metres_per_unit
from geosurf.errors import FormatError, InputError, SurfaceError
from geosurf.lazy import xarray as xr
from geosurf.model import FaultSticks, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.read._common import Request, chosen, noted
from geosurf.read._placed import fault_dataset, points_dataset
from geosurf.read.grids import nodes_from_places
from geosurf.read.resqml import Package, find, kind, open_package, values_of, word_of
from geosurf.read.resqml.representations import (
    GRID,
    KINDS,
    LINES,
    MESH,
    POINTS,
    SPELLINGS,
    TITLE,
    Representation,
    crs_of,
    grid_of,
    holds_units,
    lines_of,
    mesh_of,
    patches_of,
    places_of,
    points_of,
    representations,
    world,
)


def read_resqml_horizon(path: Path, request: Request) -> xr.DataArray | TriSurface:
    """
    Read a horizon: a grid, or triangles.

    Parameters
    ----------
    path : pathlib.Path
        The ``.epc``; the ``.h5`` lies next to it.
    request : Request
        `name`: Which object, if there are several; those of faults are not counted.
        `positive`, `length_unit`: Only to confirm what the file states.

    Returns
    -------
    xarray.DataArray or TriSurface
        The second with the role ``"horizon"``.

    Raises
    ------
    FormatError
        If the package is damaged, in time, or of another version, or has no surface.
    InputError
        If there are several horizons and `name` picks none, or the file states otherwise.
    DependencyError
        If h5py is not installed.
    """
    with open_package(path) as package:
        horizon = _one(package, request.name, (GRID, MESH), "horizon")
        if horizon.kind == MESH:
            return mesh_of(package, horizon, request, "horizon")
        nodes, crs = grid_of(package, horizon, request)
        return nodes_from_places(nodes, horizon.title, path, crs)


def read_resqml_fault(path: Path, request: Request) -> TriSurface | FaultSticks | xr.Dataset:
    """
    Read a fault: triangles, sticks, or a parametric grid.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`, `positive`, `length_unit`: As for `read_resqml_horizon`; objects of horizons are not
        counted.

    Returns
    -------
    TriSurface, FaultSticks or xarray.Dataset

    Raises
    ------
    FormatError, InputError, DependencyError
        As `read_resqml_horizon`.
    """
    with open_package(path) as package:
        fault = _one(package, request.name, (GRID, MESH, *LINES), "fault")
        if fault.kind == MESH:
            return mesh_of(package, fault, request, "fault")
        if fault.kind == GRID:
            nodes, crs = grid_of(package, fault, request)
            return fault_dataset(nodes, fault.title, path.name, crs)
        lines, crs = lines_of(package, fault, request)
        try:
            sticks = FaultSticks(fault.title, tuple(lines))
        except SurfaceError as error:
            raise FormatError(f"{path}: {error}") from error
        return in_crs_of(sticks, [SimpleNamespace(crs=crs)])


def read_resqml_points(path: Path, request: Request) -> xr.Dataset:
    """
    Read the points of the only point set.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`: As for `read_resqml_horizon`.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point`` [m].

    Raises
    ------
    FormatError, InputError, DependencyError
        As `read_resqml_horizon`; if there are several sets.
    """
    with open_package(path) as package:
        sets = _of_kinds(package, (POINTS,), "sets of points")
        noted("names", ", ".join(point_set.title for point_set in sets))
        if len(sets) > 1:
            raise InputError(
                f"{path}: the package has {len(sets)} sets of points: "
                f"{', '.join(point_set.title for point_set in sets)}. Export them one by one: "
                "together they would be one horizon."
            )
        points, crs = patches_of(package, sets[0].node, "NodePatch", request)
    return points_dataset(points, path.name, crs)


def read_resqml_polygons(path: Path, request: Request) -> list[np.ndarray]:
    """
    Read the lines of all polylines.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`: As for `read_resqml_horizon`.
        `name`: Only the lines of the object of this name.

    Returns
    -------
    list of ndarray of float64, each (n, 3)
        Easting, northing, elevation [m]; closed ones repeat their first point.

    Raises
    ------
    FormatError, InputError, DependencyError
        As `read_resqml_horizon`.
    """
    with open_package(path) as package:
        sets = _of_kinds(package, LINES, "polylines")
        if request.name is not None:
            sets = chosen(path, [(one.title, one) for one in sets], request.name, "polylines")[1]
        return [line for one in sets for line in lines_of(package, one, request)[0]]


def surfaces_of(path: Path) -> list[Representation]:
    """Return the surfaces, lines and sets of points of a package, in the order of the file."""
    with open_package(path) as package:
        return _of_kinds(package, KINDS, "surfaces")


def functions_of(path: Path) -> list[str]:
    """Return the functions that read the objects of a package."""
    with open_package(path) as package:
        wells = ["read_wells"] if trajectories(package) else []
        held = representations(package) if wells else _of_kinds(package, KINDS, "surfaces")
        found = [*map(_function, held), *wells]
        sealed = ["read_units"] if holds_units(package) else []
        return [*dict.fromkeys(found), *sealed]


def function_of(path: Path, name: str | None, sealed: bool) -> str:
    """
    Return the function that reads one object: that of a name, or the only one.

    If `sealed`, a package with a sealed model is read as units where no name is given.
    """
    with open_package(path) as package:
        if sealed and name is None and holds_units(package):
            return "read_units"
        if name is None and trajectories(package) and not representations(package):
            return "read_wells"
        named = [(one.title, one) for one in _of_kinds(package, KINDS, "surfaces")]
        return _function(chosen(path, named, name, "objects")[1][0])


def all_points(path: Path) -> list[np.ndarray]:
    """Return the points (n, 3) of all objects, for `geosurf.info`."""
    request = Request()
    with open_package(path) as package:
        wells = trajectories(package)
        held = representations(package) if wells else _of_kinds(package, KINDS, "surfaces")
        if held:
            named = [f"{one.title} ({one.role})" if one.role else one.title for one in held]
            noted("names", ", ".join(named))
        places = [places_of(package, one, request).reshape(-1, 3) for one in held]
        paths = paths_of(package, request)[0] if wells else {}
        return [*places, *(points for points, _ in paths.values())]


# ------------------------------------------------------------------ which object
def _of_kinds(package: Package, kinds: tuple[str, ...], what: str) -> list[Representation]:
    """All objects of some kinds; at least one."""
    held = representations(package)
    fitting = [candidate for candidate in held if candidate.kind in kinds]
    if not fitting:
        raise FormatError(
            f"{package.path}: the package has no {what}; its representations are "
            f"{kinds_in(package)}. Read them with geosurf.info to see what there is."
        )
    return fitting


def _one(package: Package, name: str | None, kinds: tuple[str, ...], role: str) -> Representation:
    """The object that a caller means: by its name, else the only one of that role."""
    held = _of_kinds(package, kinds, f"{role}s")
    if name is not None and name in {candidate.title for candidate in held}:
        held = [candidate for candidate in held if candidate.title == name]
    fitting = [candidate for candidate in held if candidate.role == role]
    open_ones = [candidate for candidate in held if not candidate.role]
    named = [(candidate.title, candidate) for candidate in fitting or open_ones or held]
    surface = chosen(package.path, named, name, f"{role}s")[1][0]
    return surface if name is None else replace(surface, title=name)


def _function(representation: Representation) -> str:
    """The function of geosurf that reads an object."""
    if representation.kind == POINTS:
        return "read_points"
    if representation.role == "fault":
        return "read_fault"
    return "read_polygons" if representation.kind in LINES else "read_horizon"


TRAJECTORY = "WellboreTrajectoryRepresentation"
EXPLICIT = "ParametricLineGeometry"
Path3 = tuple[np.ndarray, np.ndarray | None]  # points (n, 3) and measured depths (n,)


def wells_of_resqml(path: Path, request: Request) -> tuple[dict[str, Path3], str | None]:
    """
    Return the paths of all wells of a package, and their reference system.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`: Only to confirm what the file states of z.

    Returns
    -------
    wells : dict of str to tuple
        Places (n, 3) and measured depths (n,), or None, of the control points [m].
    crs : str or None

    Raises
    ------
    FormatError
        If there is no trajectory, one has no control points, or the package is damaged.
    InputError
        If the file states otherwise than `positive` or `length_unit`.
    """
    with open_package(path) as package:
        if not trajectories(package):
            raise FormatError(
                f"{path}: the package has no trajectory of a well; its representations are "
                f"{kinds_in(package)}. Export the trajectories of the wells, too."
            )
        return paths_of(package, request)


def paths_of(package: Package, request: Request) -> tuple[dict[str, Path3], str | None]:
    """Return the paths of the wells of an open package; there is at least one."""
    wells: dict[str, Path3] = {}
    systems: dict[str | None, None] = {}
    for name, node in trajectories(package).items():
        geometry = _geometry(package, name, node)
        wells[name] = _path(package, name, node, geometry, request)
        systems[crs_of(package, geometry)] = None
    if len(systems) > 1:
        raise package.damaged(
            f"its {len(wells)} wells have {len(systems)} coordinate reference systems"
        )
    gap = max(np.linalg.norm(np.diff(p, axis=0), axis=1).max() for p, _ in wells.values())
    noted("wells", f"{len(wells)}, by control points with straight lines of up to {gap:.4g} m")
    (crs,) = systems
    if crs is not None:
        noted("crs", crs)
    return wells, crs


def kinds_in(package: Package) -> str:
    """Return the kinds of representations of a package, for messages."""
    found = {kind(node) for node in package.objects.values()}
    return ", ".join(sorted(one for one in found if one.endswith("Representation"))) or "none"


def trajectories(package: Package) -> dict[str, Element]:
    """Return the trajectories of a package by name of their well, in the order of the file."""
    held = [(u, node) for u, node in package.objects.items() if kind(node) == TRAJECTORY]
    # the well is the feature; where several trajectories share it, each has its own title
    wells = [_well(package, node) for _, node in held]
    titles = [word_of(node, *TITLE) for _, node in held]
    by_well = {}
    for (uuid, node), well, title in zip(held, wells, titles, strict=True):
        name = well if well and wells.count(well) == 1 else title
        by_well[name if name and name not in by_well else f"{name} {uuid}".strip()] = node
    return by_well


def _well(package: Package, node: Element | None) -> str:
    """Name of the well that a trajectory represents, or '' where the package does not have it."""
    for word in ("RepresentedInterpretation", "InterpretedFeature"):
        node = package.objects.get(word_of(node, word, "UUID"))
    return word_of(node, *TITLE)


def _geometry(package: Package, name: str, node: Element) -> Element:
    """The line of control points of a trajectory."""
    geometry = find(node, "Geometry")
    if geometry is None or kind(geometry) != EXPLICIT or find(geometry, "ControlPoints") is None:
        held = (
            "no geometry" if geometry is None else f"a geometry ({kind(geometry)}) without points"
        )
        raise FormatError(
            f"{package.path}: the trajectory of well {name!r} has {held}, and geosurf reads "
            "control points. Export it with its points, or as a table with MD, X, Y and Z."
        )
    return geometry


def _path(package: Package, name: str, node: Element, geometry: Element, request: Request) -> Path3:
    """Control points and measured depths of one well, checked."""
    n = package.count(geometry, "KnotCount")
    points = points_of(package, package.need(geometry, "ControlPoints"), (n,))
    if not np.isfinite(points).all():
        raise package.damaged(f"well {name!r} has a control point that is not finite")
    if n < 2 or not (np.ptp(points, axis=0) > 0.0).any():
        raise FormatError(
            f"{package.path}: well {name!r} has its {n} control points in one place; a path needs "
            "two different ones. Complete it, or leave the well out."
        )
    places = world(package, geometry, points, request)
    listed = find(geometry, "ControlPointParameters")
    if listed is None:
        return places, None
    md = values_of(package, listed).astype(np.float64).ravel()
    if len(md) != n or not np.isfinite(md).all() or (np.diff(md) < 0.0).any():
        raise package.damaged(
            f"well {name!r} does not have {n} measured depths that rise along its control points"
        )
    unit = package.text(node, "MdUom")
    return places, md * metres_per_unit(
        SPELLINGS.get(unit, unit), f"{package.path.name}: measured depths"
    )
