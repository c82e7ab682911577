"""What callers read of a RESQML package: horizons, faults, points, polygons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import FAULT_DIMS
from geosurf.errors import FormatError, InputError, SurfaceError
from geosurf.model import FaultSticks, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.read._choice import chosen
from geosurf.read._noted import noted
from geosurf.read.grids.nodes import GridNodes, nodes_from_places
from geosurf.read.resqml.package import Package, open_package
from geosurf.read.resqml.representations import (
    GRID,
    KINDS,
    LINES,
    MESH,
    POINTS,
    Representation,
    Words,
    grid_of,
    lines_of,
    mesh_of,
    patches_of,
    places_of,
    representations,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr


def read_resqml_horizon(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> GridNodes | TriSurface:
    """
    Read a horizon: a grid, or triangles.

    Parameters
    ----------
    path : pathlib.Path
        The ``.epc``; the ``.h5`` lies next to it.
    name : str, optional
        Which object, if there are several; those of faults are not counted.
    positive, length_unit : optional
        Only to confirm what the file states.

    Returns
    -------
    GridNodes or TriSurface
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
        one = _one(package, name, (GRID, MESH), "horizon")
        words = Words(positive, length_unit)
        if one.kind == MESH:
            return mesh_of(package, one, words, "horizon")
        nodes, crs = grid_of(package, one, words)
        return nodes_from_places(nodes, name=one.title, source=path.name, crs=crs)


def read_resqml_fault(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> TriSurface | FaultSticks | xr.Dataset:
    """
    Read a fault: triangles, sticks, or a parametric grid.

    Parameters
    ----------
    path, name, positive, length_unit
        As for `read_resqml_horizon`; objects of horizons are not counted.

    Returns
    -------
    TriSurface, FaultSticks or xarray.Dataset

    Raises
    ------
    FormatError, InputError, DependencyError
        As `read_resqml_horizon`.
    """
    with open_package(path) as package:
        one = _one(package, name, (GRID, MESH, *LINES), "fault")
        words = Words(positive, length_unit)
        if one.kind == MESH:
            return mesh_of(package, one, words, "fault")
        if one.kind == GRID:
            return _fault_grid(one, path, *grid_of(package, one, words))
        lines, crs = lines_of(package, one, words)
        try:
            sticks = FaultSticks(one.title, tuple(lines))
        except SurfaceError as error:
            raise FormatError(f"{path}: {error}") from error
        return in_crs_of(sticks, [SimpleNamespace(crs=crs)])


def read_resqml_points(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> xr.Dataset:
    """
    Read the points of all point sets.

    Parameters
    ----------
    path, positive, length_unit
        As for `read_resqml_horizon`.
    columns, decimal
        Of tables of text only.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point`` [m].

    Raises
    ------
    FormatError, InputError, DependencyError
        As `read_resqml_horizon`, and if `columns` is given.
    """
    import xarray as xr

    _no_table(path, columns, decimal)
    with open_package(path) as package:
        sets = _of_kinds(package, (POINTS,), "sets of points")
        words = Words(positive, length_unit)
        parts = [patches_of(package, one.node, "NodePatch", words) for one in sets]
        points = np.concatenate([part for part, _ in parts])
        systems = {crs for _, crs in parts}
        noted("names", ", ".join(one.title for one in sets))
    if len(systems) > 1:
        named = ", ".join(sorted(str(crs) for crs in systems))
        raise FormatError(
            f"{path}: sets of points are in different coordinate reference systems, {named}. "
            "Export them one by one."
        )
    metre, up = {"units": "m"}, {"units": "m", "positive": "up"}
    columns_of = {"easting": metre, "northing": metre, "elevation": up}
    made = xr.Dataset(
        {
            key: ("point", points[:, k].copy(), meta)
            for k, (key, meta) in enumerate(columns_of.items())
        }
    )
    (crs,) = systems
    made.attrs = {"source": path.name} | ({} if crs is None else {"crs": crs})
    return made


def read_resqml_polygons(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
    name: str | None = None,
) -> list[np.ndarray]:
    """
    Read the lines of all polylines.

    Parameters
    ----------
    path, positive, length_unit
        As for `read_resqml_horizon`.
    columns, decimal
        Of tables of text only.
    name : str, optional
        Only the lines of the object of this name.

    Returns
    -------
    list of ndarray of float64, each (n, 3)
        Easting, northing, elevation [m]; closed ones repeat their first point.

    Raises
    ------
    FormatError, InputError, DependencyError
        As `read_resqml_horizon`, and if `columns` is given.
    """
    _no_table(path, columns, decimal)
    with open_package(path) as package:
        sets = _of_kinds(package, LINES, "polylines")
        if name is not None:
            groups = {one.title: [one] for one in sets}
            sets = chosen(path, groups, name, "polylines")[1]
        words = Words(positive, length_unit)
        return [line for one in sets for line in lines_of(package, one, words)[0]]


def surfaces_of(path: Path) -> list[Representation]:
    """Return the surfaces and lines of a package, in the order of the file."""
    with open_package(path) as package:
        return _of_kinds(package, (GRID, MESH, *LINES), "surfaces")


def functions_of(path: Path) -> list[str]:
    """Return the functions that read the objects of a package."""
    with open_package(path) as package:
        found = [_function(one) for one in _of_kinds(package, KINDS, "surfaces")]
        return list(dict.fromkeys(found))


def function_of(path: Path, name: str | None) -> str:
    """Return the function that reads one object: that of a name, or the only one."""
    with open_package(path) as package:
        groups = {one.title: [one] for one in _of_kinds(package, KINDS, "surfaces")}
        return _function(chosen(path, groups, name, "objects")[1][0])


def all_points(path: Path) -> list[np.ndarray]:
    """Return the points (n, 3) of all objects, for `geosurf.info`."""
    words = Words(None, None)
    with open_package(path) as package:
        held = _of_kinds(package, KINDS, "surfaces")
        noted(
            "names",
            ", ".join(f"{one.title} ({one.role})" if one.role else one.title for one in held),
        )
        return [places_of(package, one, words).reshape(-1, 3) for one in held]


# ------------------------------------------------------------------ which object
def _of_kinds(package: Package, kinds: tuple[str, ...], what: str) -> list[Representation]:
    """All objects of some kinds; at least one."""
    held = representations(package)
    found = [one for one in held if one.kind in kinds]
    if not found:
        others = sorted({one.kind for one in held}) or ["none that is read"]
        raise FormatError(
            f"{package.path}: the package has no {what}; its representations are "
            f"{', '.join(others)}. Read them with geosurf.info to see what there is."
        )
    return found


def _one(package: Package, name: str | None, kinds: tuple[str, ...], role: str) -> Representation:
    """The object that a caller means: by its name, else the only one of that role."""
    held = _of_kinds(package, kinds, f"{role}s")
    if name is not None and name in {one.title for one in held}:
        held = [one for one in held if one.title == name]
    fitting = [one for one in held if one.role == role]
    open_ones = [one for one in held if not one.role]
    groups = {one.title: [one] for one in fitting or open_ones or held}
    found = chosen(package.path, groups, name, f"{role}s")[1][0]
    return found if name is None else replace(found, title=name)


def _function(one: Representation) -> str:
    """The function of geosurf that reads an object."""
    if one.kind == POINTS:
        return "read_points"
    if one.role == "fault":
        return "read_fault"
    return "read_polygons" if one.kind in LINES else "read_horizon"


def _no_table(path: Path, columns: object, decimal: str) -> None:
    if columns is not None or decimal != ".":
        raise InputError(
            f"{path}: columns= and decimal= apply to tables of text, but this is RESQML. Leave "
            "them out."
        )


def _fault_grid(one: Representation, path: Path, nodes: np.ndarray, crs: str | None) -> xr.Dataset:
    """A fault given by rows down its dip and columns along its strike."""
    import xarray as xr

    metre, up = {"units": "m"}, {"units": "m", "positive": "up"}
    made = xr.Dataset(
        {
            "easting": (FAULT_DIMS, nodes[..., 0].copy(), metre),
            "northing": (FAULT_DIMS, nodes[..., 1].copy(), metre),
            "elevation": (FAULT_DIMS, nodes[..., 2].copy(), up),
        }
    )
    made.attrs = {"name": one.title, "source": path.name} | ({} if crs is None else {"crs": crs})
    return made


__all__ = [
    "all_points",
    "function_of",
    "functions_of",
    "read_resqml_fault",
    "read_resqml_horizon",
    "read_resqml_points",
    "read_resqml_polygons",
    "surfaces_of",
]
