"""Paths of wells in a RESQML package: ``WellboreTrajectoryRepresentation``.

The control points of a trajectory are places that the file states, with measured depths. The path
is straight between them: tangents and kinds of curves are not used, as for places in tables.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from geosurf.conventions import metres_per_unit
from geosurf.errors import FormatError
from geosurf.read._common import Request, noted
from geosurf.read.resqml.package import Package, find, kind, open_package, values_of
from geosurf.read.resqml.representations import SPELLINGS, crs_of, points_of, world

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
    titles = [_title(node) for _, node in held]
    found = {}
    for (uuid, node), well, title in zip(held, wells, titles, strict=True):
        name = well if well and wells.count(well) == 1 else title
        found[name if name and name not in found else f"{name} {uuid}".strip()] = node
    return found


def _title(node: Element | None) -> str:
    title = None if node is None else find(node, "Citation", "Title")
    return ("" if title is None else title.text or "").strip()


def _well(package: Package, node: Element | None) -> str:
    """Name of the well that a trajectory represents, or '' where the package does not have it."""
    for word in ("RepresentedInterpretation", "InterpretedFeature"):
        referred = None if node is None else find(node, word, "UUID")
        uuid = "" if referred is None else (referred.text or "").strip()
        node = package.objects.get(uuid)
    return _title(node)


def _geometry(package: Package, name: str, node: Element) -> Element:
    """The line of control points of a trajectory."""
    found = find(node, "Geometry")
    if found is None or kind(found) != EXPLICIT or find(found, "ControlPoints") is None:
        held = "no geometry" if found is None else f"a geometry ({kind(found)}) without points"
        raise FormatError(
            f"{package.path}: the trajectory of well {name!r} has {held}, and geosurf reads "
            "control points. Export it with its points, or as a table with MD, X, Y and Z."
        )
    return found


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
