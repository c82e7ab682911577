"""Choose what an interactive view shows, with few enough triangles; nothing is drawn here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from geosurf.conventions import counted, volume_text
from geosurf.conventions.colours import unit_colours
from geosurf.errors import InputError
from geosurf.model import (
    Curves,
    FaultNetwork,
    FaultSticks,
    Patches,
    Sheet,
    TetMesh,
    TriSurface,
    Unit,
    Units,
)
from geosurf.model.view3d import Body, View3D
from geosurf.render import palette
from geosurf.render.bodies import curve_bodies, network_bodies, stick_body, tet_bodies
from geosurf.render.cluster import clustered
from geosurf.render.surface_layers import rim
from geosurf.render.thin_surfaces import thinned
from geosurf.render.thin_units import mesh_to_draw, shells_to_draw
from geosurf.render.unit_layers import explosion, outline
from geosurf.render.views import bounds_of, choose_exaggeration

# of all bodies: about 2.5 MB of a page
MAX_VIEW_TRIANGLE = 120_000
EXPLODED = 0.3  # shift at the end of the slider, as a fraction of the model box
SHORTEST = 1.0 / 3000.0  # lines, as a fraction of the diagonal of the map: less than a pixel
SLIVERS = "Slivers"
GROUPS = {"horizon": "Horizons", "fault": "Faults", "wall": "Walls", "contact": "Contacts"}


def view_of_units(units: Units, max_triangle: int = MAX_VIEW_TRIANGLE) -> View3D:
    """Return an interactive view of units: one group per zone, slivers in a group of their own.

    Parameters
    ----------
    units : Units
    max_triangle : int
        Of all units, about.

    Returns
    -------
    View3D
    """
    shades = unit_colours((unit.name, unit.zone_index) for unit in units.without_slivers)
    stretch = choose_exaggeration(units.box)
    mesh = mesh_to_draw(units, max_triangle)
    few = mesh.n_drawn <= max_triangle
    shells = (
        shells_to_draw(units, max_triangle)
        if few
        else clustered(mesh, max_triangle, stretch).shells
    )
    drawn = zip(units.values(), shells, explosion(units, EXPLODED), strict=True)
    diagonal = float(np.hypot(*np.ptp(np.reshape(units.box[:4], (2, 2)), axis=1)))
    bodies = []
    for unit, shell, (east, north, up) in drawn:
        facts = [("Zone", unit.zone), ("Block", unit.block)]
        facts += [("Contact", unit.contact)] if unit.contact else []
        facts += [("Volume", volume_text(unit.volume)), ("Bounded by", ", ".join(unit.bounded_by))]
        bodies.append(
            Body(
                unit.name,
                unit.zone if unit.name in shades else SLIVERS,
                shades.get(unit.name, palette.FAINT),
                shell.points,
                shell.triangles,
                shell.surface,
                _visible(shell.points, outline(shell, creases=False), diagonal),
                tuple(facts),
                (float(east), float(north), float(up)),
            )
        )

    # slivers come last: their group is folded
    bodies.sort(key=lambda body: body.group == SLIVERS)
    return View3D(tuple(bodies), units.box, stretch)


def _visible(points: np.ndarray, lines: np.ndarray, diagonal: float) -> np.ndarray:
    """Lines without the shortest ones: graphics drivers draw those in front of anything."""
    length = np.linalg.norm(points[lines[:, 0]] - points[lines[:, 1]], axis=1)
    result: np.ndarray = lines[length > SHORTEST * diagonal]
    return result


def view_of_surfaces(
    surfaces: Iterable[TriSurface], max_triangle: int = MAX_VIEW_TRIANGLE
) -> View3D:
    """Return an interactive view of surfaces: one group per role.

    Parameters
    ----------
    surfaces : iterable of TriSurface
        Horizons youngest first: they take the colours of the column.
    max_triangle : int
        Of each gridded surface; other surfaces are shown as they are.

    Returns
    -------
    View3D

    Raises
    ------
    InputError
        If there are no triangles.
    """
    surfaces = tuple(surfaces)
    bodies, count = [], {"fault": 0, "horizon": 0}
    plain = {"wall": palette.WALL, "contact": palette.CONTACT}
    only_walls = all(surface.role == "wall" for surface in surfaces)
    for surface in surfaces:
        role = "fault" if surface.role == "fault" else "horizon"
        if surface.role in plain:
            colour = plain[surface.role]
        else:
            colour = (palette.fault if role == "fault" else palette.stratum)(count[role])
            count[role] += 1
        light = thinned(surface, max_triangle)
        if not light.n_triangle:
            continue
        bodies.append(
            Body(
                surface.name,
                GROUPS.get(surface.role, "Surfaces"),
                colour,
                light.vertices,
                light.triangles,
                np.zeros(light.n_triangle, dtype=np.int64),
                rim(light.triangles),
                (("Role", surface.role), ("Size", counted(surface.n_triangle, "triangle"))),
                closed=False,
                shown=only_walls or surface.role != "wall",  # walls hide all others
            )
        )
    box = bounds_of([body.points for body in bodies])
    return View3D(tuple(bodies), box, choose_exaggeration(box))


def view_of(things: Sequence[object], max_triangle: int = MAX_VIEW_TRIANGLE) -> View3D:
    """Return an interactive view of any nouns together.

    Parameters
    ----------
    things : sequence of objects
        TriSurface, Sheet, Curves, Patches, FaultSticks, FaultNetwork, Unit, Units or TetMesh. A
        sheet brings the faults that tear it, a fault network its faults.
    max_triangle : int
        Of all units, and of each gridded surface, about.

    Returns
    -------
    View3D

    Raises
    ------
    InputError
        If there is nothing to show, or something that has no place in space.
    """
    surfaces: list[TriSurface] = []
    others: list[Body] = []
    for thing in things:
        match thing:
            case TriSurface():
                surfaces.append(thing)
            case Sheet():
                surfaces += [thing.surface, *thing.faults]
            case Patches():
                surfaces += [thing.surface(k) for k in range(len(thing.sources))]
            case Units():
                others += view_of_units(thing, max_triangle).bodies
            case Unit():
                low, high = thing.vertices.min(axis=0), thing.vertices.max(axis=0)
                box = tuple(np.ravel((low, high), order="F").tolist())
                alone = Units([thing], box, {})
                others += view_of_units(alone, max_triangle).bodies
            case Curves():
                others += curve_bodies(thing)
            case FaultSticks():
                others.append(stick_body(thing, len(others)))
            case TetMesh():
                others += tet_bodies(thing)
            case FaultNetwork():
                surfaces += thing.faults
                others += network_bodies(thing)
            case _:
                raise InputError(
                    f"an object of type {type(thing).__name__} cannot be shown in three "
                    "dimensions. Show surfaces, sheets, curves, patches, fault sticks, fault "
                    "networks, units or a scene; triangulate grids first: "
                    "gs.triangulate_horizon(top)."
                )

    # a fault that tears several sheets is shown once
    surfaces = list({id(surface): surface for surface in surfaces if surface.n_triangle}.values())
    bodies = (*view_of_surfaces(surfaces, max_triangle).bodies, *others) if surfaces else others
    if not bodies:
        raise InputError("there is nothing to show: no triangles and no curves.")
    box = bounds_of([body.points for body in bodies])
    return View3D(tuple(bodies), box, choose_exaggeration(box))


__all__ = ["view_of", "view_of_surfaces", "view_of_units"]
