"""Choose what an interactive view shows, with few enough triangles; nothing is drawn here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from geosurf.conventions import counted, volume_text
from geosurf.conventions.colours import unit_colours
from geosurf.errors import InputError
from geosurf.model import Curves, FaultSticks, Patches, Sheet, TetMesh, TriSurface, Unit, Units
from geosurf.model.view3d import Body, View3D
from geosurf.render import palette
from geosurf.render.cluster import clustered
from geosurf.render.surface_layers import rim, thinned
from geosurf.render.thin_units import shells_to_draw
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
    shells = clustered(shells_to_draw(units, max_triangle), max_triangle, stretch)
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
    things : sequence of TriSurface, Sheet, Curves, Patches, FaultSticks, Unit, Units or TetMesh
        A sheet brings the faults that tear it.
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
                others += _curve_bodies(thing)
            case FaultSticks():
                others.append(_stick_body(thing, len(others)))
            case TetMesh():
                others += _tet_bodies(thing)
            case _:
                raise InputError(
                    f"an object of type {type(thing).__name__} cannot be shown in three "
                    "dimensions. Show surfaces, sheets, curves, patches, fault sticks, units or a "
                    "scene; triangulate grids first: gs.triangulate_horizon(top)."
                )

    # a fault that tears several sheets is shown once
    surfaces = list({id(surface): surface for surface in surfaces if surface.n_triangle}.values())
    bodies = (*view_of_surfaces(surfaces, max_triangle).bodies, *others) if surfaces else others
    if not bodies:
        raise InputError("there is nothing to show: no triangles and no curves.")
    box = bounds_of([body.points for body in bodies])
    return View3D(tuple(bodies), box, choose_exaggeration(box))


def _curve_bodies(curves: Curves) -> list[Body]:
    """A body of lines for each pair of surfaces that meet."""
    bodies = []
    of_curve, of_segment = np.sort(curves.surfaces_of_curve), np.sort(curves.surfaces_of_segment)
    for a, b in np.unique(of_curve, axis=0).tolist():
        mine = (of_curve == (a, b)).all(axis=1)
        first, second = curves.names[a], curves.names[b]
        name = f"{first} and {second}" if a != b else f"{first} with itself"
        length = float(curves.length_of_curve[mine].sum())
        facts = (("Curves", str(int(mine.sum()))), ("Length", f"{length:.6g} m"))
        segments = curves.segments[(of_segment == (a, b)).all(axis=1)]
        bodies.append(_lines(name, "Curves", palette.ACCENT, curves.points, segments, facts))
    return bodies


def _stick_body(sticks: FaultSticks, number: int) -> Body:
    """The picked lines of a fault."""
    sizes = [len(stick) for stick in sticks.sticks]
    last = np.cumsum(sizes) - 1
    rows = np.setdiff1d(np.arange(sum(sizes)), last)  # the last point of a stick starts no line
    facts = (("Role", "fault sticks"), ("Size", f"{len(sizes)} sticks, {sum(sizes)} points"))
    lines, points = np.stack([rows, rows + 1], axis=1), np.concatenate(sticks.sticks)
    return _lines(sticks.name, "Fault sticks", palette.fault(number), points, lines, facts)


def _lines(
    name: str,
    group: str,
    colour: palette.RGB,
    points: np.ndarray,
    lines: np.ndarray,
    facts: tuple[tuple[str, str], ...],
) -> Body:
    """A body of lines."""
    used, rows = np.unique(lines, return_inverse=True)
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    return Body(name, group, colour, points[used], *none, rows.reshape(-1, 2), facts, closed=False)


def _tet_bodies(mesh: TetMesh) -> list[Body]:
    """The skin of the tetrahedra of each unit, with the edges of the mesh."""
    bodies = []
    for row, name in enumerate(mesh.unit_names):
        # a face is seen from its front, so its unit in front has it the other way round
        front, behind = (mesh.face_sides[:, side] == row for side in (0, 1))
        faces = np.concatenate([mesh.faces[front][:, ::-1], mesh.faces[behind]])
        used, corners = np.unique(faces, return_inverse=True)
        triangles = corners.reshape(-1, 3)
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2))
        size = f"{int((mesh.region == row).sum())} tetrahedra"
        bodies.append(
            Body(
                name,
                "Tetrahedra",
                palette.stratum(row),
                mesh.vertices[used],
                triangles,
                np.concatenate([mesh.surface_of_face[front], mesh.surface_of_face[behind]]),
                np.unique(edges, axis=0),
                (("Size", size), ("Volume", volume_text(float(mesh.volumes[row])))),
            )
        )
    return bodies


__all__ = ["view_of", "view_of_surfaces", "view_of_units"]
